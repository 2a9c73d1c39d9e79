//! `groundplan export`: the files of `convert`, made from what the daemons publish.

mod args;
mod sets;
mod watch;

use crate::args::report_set_aside;
use crate::failure::Failure;
use crate::run::{Outcome, Run};
use crate::wait::Expectation;
use crate::wait::join;
pub use args::Args;
use bus::Daemon;
use sets::Sets;
use site_files::SiteFiles;
use std::time::Duration;

const POLL_INTERVAL: Duration = Duration::from_millis(50);

impl Run for Args {
    /// Writes the output folder at the plan time that the daemons hold: the same bytes as `convert --date` at that instant.
    ///
    /// # Errors
    /// No daemons, maps that the daemons do not make, with the reason; a folder that cannot be written.
    fn run(&self) -> Result<Outcome, Failure> {
        if self.watch {
            return watch::watch(self);
        }
        let config = self.site.config()?;
        let mut files = SiteFiles::new(self.optional_files.options(&config.world)?);
        let folder = self.overwrite.folder_at(&self.out)?;
        let (bus, mut waiter) = join(&config)?;
        let mut sets = Sets::of(&bus)?;
        let mut expectation = Expectation::of(&config, Daemon::WaypointGen);
        while sets.take()?.is_none() {
            expectation.check()?;
            waiter.wait(POLL_INTERVAL).map_err(Failure::work)?;
        }
        let files = sets.files(&config, &mut files)?;
        report_set_aside(folder.replace(&files).map_err(Failure::work)?);
        Ok(Outcome::silent())
    }
}
