//! `groundplan deviations`: what differs between a site as planned and a robot's map.

mod args;
mod files;
mod goals;
mod live;
mod planner_files;
mod report;

use crate::failure::Failure;
use crate::run::{Outcome, Run};
pub use args::Args;
pub(crate) use live::with_newest;

impl Run for Args {
    /// Compares, or takes what the daemon compared, and writes files of it.
    ///
    /// # Errors
    /// Models or maps that cannot be read, a map whose pose is not accepted, a folder that cannot be written; no daemon.
    fn run(&self) -> Result<Outcome, Failure> {
        let text = match &self.slam {
            None if self.models.is_empty() => live::take(self),
            None => Err(Failure::usage(
                "--slam is needed with models; without both, deviations of the running daemon are printed",
            )),
            Some(slam) => files::compare(self, slam),
        }?;
        Ok(text.into())
    }
}
