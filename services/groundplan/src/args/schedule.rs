//! Schedule arguments: rules of dates, delays, reported progress.

use super::models::ModelArgs;
use crate::failure::Failure;
use crate::progress_line::ProgressLine;
use jiff::tz::TimeZone;
use messages::Site;
use schedule::{Delay, Overrides, Probabilities, Rules, Timeline, parse_actuals};
use std::path::{Path, PathBuf};

/// Rules of dates, and overrides of the schedule.
#[derive(Debug, Clone, clap::Args)]
pub struct ScheduleArgs {
    /// Rules of dates, construction phases and closed spaces [default: see config/schedule.toml]
    #[arg(long, value_name = "FILE")]
    schedule: Option<PathBuf>,

    /// What if: delay a task and all that depends on it, by GlobalId, identification or name; may be repeated
    #[arg(long, value_name = "TASK=5d")]
    delay: Vec<String>,

    /// Reported progress, which replaces planned dates: a CSV table with the columns id, start, finish
    #[arg(long, value_name = "FILE.csv")]
    actual: Option<PathBuf>,
}

impl ScheduleArgs {
    /// True if dates are not those of the models and rules alone.
    pub(crate) fn changes_dates(&self) -> bool {
        !self.delay.is_empty() || self.actual.is_some()
    }
}

/// A file of the schedule that cannot be used.
#[derive(Debug, thiserror::Error)]
#[error("{}", path.display())]
struct FileError {
    path: PathBuf,
    source: Box<dyn std::error::Error + Send + Sync>,
}

/// Schedule arguments of the command line.
pub(crate) struct ScheduleInput {
    rules: Rules,
    overrides: Overrides,
}

impl ScheduleInput {
    /// Reads the files that are named.
    ///
    /// # Errors
    /// Files that cannot be read or mean nothing, delays of another form.
    pub(crate) fn read(arguments: &ScheduleArgs) -> Result<Self, Failure> {
        let usage = |path: &Path, source: Box<dyn std::error::Error + Send + Sync>| {
            Failure::usage(FileError { path: path.to_owned(), source })
        };
        let rules = arguments.schedule.as_deref().map_or(Ok(Rules::default()), |path| {
            let text = std::fs::read_to_string(path).map_err(|e| usage(path, e.into()))?;
            Rules::parse(&text).map_err(|e| usage(path, e.into()))
        })?;
        let actuals = arguments.actual.as_deref().map_or(Ok(Vec::new()), |path| {
            let bytes = std::fs::read(path).map_err(|e| usage(path, e.into()))?;
            parse_actuals(&bytes).map_err(|e| usage(path, e.into()))
        })?;
        let delays = arguments.delay.iter().map(|text| Delay::parse(text)).collect::<Result<_, _>>();
        Ok(Self {
            rules,
            overrides: Overrides { delays: delays.map_err(Failure::usage)?, actuals, ..Overrides::default() },
        })
    }

    /// The zone of the site, for dates with an offset.
    pub(crate) fn site_zone(&self) -> Option<&TimeZone> {
        self.rules.site_zone.as_ref()
    }

    /// Works out the schedule of a site.
    ///
    /// # Errors
    /// Dates that can be read in two ways, or overrides of unknown tasks or elements.
    pub(crate) fn timeline(&self, site: &Site<'_>) -> Result<Timeline, Failure> {
        schedule::evaluate(site, &self.rules, &self.overrides).map_err(Failure::usage)
    }

    /// Simulates the schedule of a site around the dates of its timeline.
    ///
    /// # Errors
    /// More runs of the tasks than there is room for, rules of the prototype.
    pub(crate) fn probabilities<'t>(
        &self,
        site: &Site<'_>,
        timeline: &'t Timeline,
    ) -> Result<Probabilities<'t>, Failure> {
        schedule::probabilities(site, &self.rules, &self.overrides, timeline).map_err(Failure::usage)
    }
}

/// Reads the models, works out their schedule, and goes on with both on the threads that were asked for.
///
/// # Errors
/// Those of reading, of the schedule, and of the work.
pub(crate) fn with_timeline<T: Send>(
    model: &ModelArgs,
    schedule: &ScheduleInput,
    work: impl FnOnce(&Site<'_>, &Timeline, &ProgressLine) -> Result<T, Failure> + Send,
) -> Result<T, Failure> {
    let progress = ProgressLine::new(false);
    model.pool()?.install(|| {
        let site = model.site(None, 1, &progress)?;
        let site = Site::open(site.bytes()).map_err(Failure::work)?;
        work(&site, &schedule.timeline(&site)?, &progress)
    })
}
