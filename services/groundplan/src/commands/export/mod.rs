//! `groundplan export`: the files of `convert`, made from what the daemons publish.

mod args;
mod follow;
mod sets;

use crate::args::report_set_aside;
use crate::failure::Failure;
use crate::run::{Outcome, Run};
use crate::wait::join;
pub use args::Args;
use sets::Sets;
use std::time::{Duration, Instant};

/// Samples that belong together are waited for.
const TIMEOUT: Duration = Duration::from_secs(30);
const POLL_INTERVAL: Duration = Duration::from_millis(50);

impl Run for Args {
    /// Writes the output folder at the plan time that the daemons hold: the same bytes as `convert --date` at that instant.
    ///
    /// # Errors
    /// No daemons, samples that do not come together, a folder that cannot be written.
    fn run(&self) -> Result<Outcome, Failure> {
        if self.watch {
            return follow::follow(self);
        }
        let config = self.site.config()?;
        let world = self.world.options(&config.world)?;
        let folder = self.overwrite.folder_at(&self.out)?;
        let (bus, mut waiter) = join(&config)?;
        let mut sets = Sets::of(&bus)?;
        let begun = Instant::now();
        while sets.take()?.is_none() {
            if begun.elapsed() > TIMEOUT {
                return Err(Failure::work(
                    "site, schedule state and grids do not come together: see groundplan status",
                ));
            }
            waiter.wait(POLL_INTERVAL).map_err(Failure::work)?;
        }
        let files = sets.files(&config, world.as_ref())?;
        report_set_aside(folder.replace(&files).map_err(Failure::work)?);
        Ok(Outcome::silent())
    }
}
