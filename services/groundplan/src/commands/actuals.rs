//! `groundplan actuals`: reported progress for the running daemons.

use crate::args::SiteArgs;
use crate::failure::Failure;
use crate::run::{Outcome, Run};
use crate::wait::{ask, join, wait_for_schedule_state};
use daemon::{ActualsSource, ScheduleRequest};
use std::path::PathBuf;

/// Arguments of `actuals`.
#[derive(Debug, Clone, clap::Args)]
pub struct Args {
    /// CSV table with the columns id, start, finish; it replaces what was reported before
    #[arg(value_name = "FILE.csv", required_unless_present = "clear")]
    file: Option<PathBuf>,

    /// Nothing was reported
    #[arg(long, conflicts_with = "file")]
    clear: bool,

    /// The site.
    #[command(flatten)]
    site: SiteArgs,
}

impl Run for Args {
    /// Sets the progress that was reported.
    ///
    /// # Errors
    /// No daemons, a file that cannot be used; what was reported before stays.
    fn run(&self) -> Result<Outcome, Failure> {
        let file = self.file.as_ref().map(std::path::absolute).transpose().map_err(Failure::usage)?;
        let config = self.site.config()?;
        let (bus, mut waiter) = join(&config)?;
        let request = ScheduleRequest::SetActuals { file, source: ActualsSource::Reported };
        let answer = ask(&bus, &mut waiter, &request)?;
        if answer.state.epoch > 0 {
            wait_for_schedule_state(&bus, &mut waiter, &config, &answer.state)?;
        }
        Ok(Outcome::silent())
    }
}
