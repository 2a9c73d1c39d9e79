//! Logging of a process of a site: destination, format and level.

use crate::config::{LogConfig, LogFormat};
use std::io::IsTerminal;
use tracing_subscriber::layer::SubscriberExt;
use tracing_subscriber::util::SubscriberInitExt;
use tracing_subscriber::{EnvFilter, Layer, Registry, fmt, reload};

/// The default filter: information from the crates of this workspace, warnings from others; but not an error for each client of
/// Foxglove that connects to it and does not speak its protocol.
const DEFAULT_FILTER: &str = "warn,groundplan=info,daemon=info,ifc_ingest=info,schedule_eval=info,rasterize=info,waypoint_gen=info,slam_align=info,ros_bridge=info,groundplan_web=info,foxglove=off";

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
        let (filter, handle) = reload::Layer::new(filter(config)?);
        let lines = || fmt::layer().with_writer(std::io::stderr);
        let layer: Box<dyn Layer<_> + Send + Sync> = match config.format {
            LogFormat::Terminal => lines().with_ansi(std::io::stderr().is_terminal()).boxed(),
            LogFormat::Json => lines().json().flatten_event(true).boxed(),
            LogFormat::Journald => tracing_journald::layer().map_err(LogError::Journal)?.boxed(),
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
