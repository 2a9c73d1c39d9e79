//! Logging of a process of a site: destination, format and level.

use crate::config::{LogConfig, LogFormat};
use bus::RobotName;
use std::io::IsTerminal;
use tracing::{Event, Subscriber};
use tracing_subscriber::fmt::format::Writer;
use tracing_subscriber::fmt::{FmtContext, FormatEvent, FormatFields};
use tracing_subscriber::layer::SubscriberExt;
use tracing_subscriber::registry::LookupSpan;
use tracing_subscriber::util::SubscriberInitExt;
use tracing_subscriber::{EnvFilter, Layer, Registry, fmt, reload};

/// The default filter: information from the crates of this workspace, warnings from others; but not an error for each client of
/// Foxglove that connects to it and does not speak its protocol.
const DEFAULT_FILTER: &str = "warn,groundplan=info,daemon=info,ifc_ingest=info,schedule_eval=info,rasterize=info,waypoint_gen=info,slam_align=info,ros_bridge=info,groundplan_web=info,site_follow=info,site_server=info,foxglove=off,zenoh=off";

/// A log that cannot be had.
#[derive(Debug, thiserror::Error)]
pub enum LogError {
    /// Not in the syntax of RUST_LOG.
    #[error("log level {level:?}")]
    Level {
        /// As configured.
        level: String,
        /// Why.
        source: tracing_subscriber::filter::ParseError,
    },
    /// No journal to write to.
    #[error("the journal of systemd cannot be opened")]
    Journal(#[source] std::io::Error),
}

/// The running log.
#[derive(Debug, Clone)]
pub struct Log {
    filter: reload::Handle<EnvFilter, Registry>,
}

impl Log {
    /// Starts the log of this process.
    ///
    /// # Errors
    /// A level that is none, no journal.
    pub fn start(config: &LogConfig) -> Result<Self, LogError> {
        Self::start_for(config, None)
    }

    /// The same for a daemon of a robot with a name, which each line has.
    ///
    /// # Errors
    /// As [`Self::start`].
    pub fn start_for(config: &LogConfig, robot: Option<RobotName>) -> Result<Self, LogError> {
        let (filter, handle) = reload::Layer::new(filter(config)?);
        let lines = || fmt::layer().with_writer(std::io::stderr);
        let layer: Box<dyn Layer<_> + Send + Sync> = match (config.format, robot) {
            (LogFormat::Terminal, None) => lines().with_ansi(std::io::stderr().is_terminal()).boxed(),
            (LogFormat::Terminal, Some(robot)) => {
                let before = format!("{robot}: ");
                let format = LinesOfRobot { before, begins_with: "", format: fmt::format() };
                lines().with_ansi(std::io::stderr().is_terminal()).event_format(format).boxed()
            }
            (LogFormat::Json, None) => lines().json().flatten_event(true).boxed(),
            (LogFormat::Json, Some(robot)) => {
                let before = format!("{{\"robot\":\"{robot}\",");
                let format =
                    LinesOfRobot { before, begins_with: "{", format: fmt::format().json().flatten_event(true) };
                lines().json().event_format(format).boxed()
            }
            (LogFormat::Journald, robot) => {
                let journal = tracing_journald::layer().map_err(LogError::Journal)?;
                journal.with_custom_fields(robot.map(|robot| ("ROBOT", robot.to_string()))).boxed()
            }
        };
        tracing_subscriber::registry().with(filter).with(layer).init();
        Ok(Self { filter: handle })
    }

    /// Changes what is logged from now on; where it goes stays.
    ///
    /// # Errors
    /// A level that is none: the log stays as it is.
    pub(crate) fn set_level(&self, config: &LogConfig) -> Result<(), LogError> {
        let filter = filter(config)?;
        // The log lives as long as the process.
        let _ = self.filter.reload(filter);
        Ok(())
    }
}

/// Lines that begin with the robot whose they are.
struct LinesOfRobot<F> {
    before: String,
    /// The beginning of a line in whose place `before` stands.
    begins_with: &'static str,
    format: F,
}

impl<S, N, F> FormatEvent<S, N> for LinesOfRobot<F>
where
    S: Subscriber + for<'a> LookupSpan<'a>,
    N: for<'a> FormatFields<'a> + 'static,
    F: FormatEvent<S, N>,
{
    fn format_event(&self, context: &FmtContext<'_, S, N>, mut out: Writer<'_>, event: &Event<'_>) -> std::fmt::Result {
        out.write_str(&self.before)?;
        if self.begins_with.is_empty() {
            return self.format.format_event(context, out, event);
        }
        let mut line = String::new();
        self.format.format_event(context, Writer::new(&mut line), event)?;
        out.write_str(line.strip_prefix(self.begins_with).unwrap_or(&line))
    }
}

impl LogConfig {
    /// Tries whether its level is one.
    ///
    /// # Errors
    /// A level that is not in the words of RUST_LOG.
    pub fn check(&self) -> Result<(), LogError> {
        filter(self).map(drop)
    }
}

/// RUST_LOG overrides the configuration.
fn filter(config: &LogConfig) -> Result<EnvFilter, LogError> {
    if let Ok(filter) = EnvFilter::try_from_default_env() {
        return Ok(filter);
    }
    let level = config.level.as_deref().unwrap_or(DEFAULT_FILTER);
    EnvFilter::try_new(level).map_err(|source| LogError::Level { level: level.to_owned(), source })
}
