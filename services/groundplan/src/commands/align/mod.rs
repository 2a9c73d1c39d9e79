//! `groundplan align`: the pose of a robot's SLAM map in a map of the model.

mod args;
mod files;
mod initial_pose;
mod pairs;
mod pose_file;
mod semantic;
mod slam_frame;
mod storey_claim;
mod transform;

use crate::alignment_request::{outcome_of, searched};
use crate::failure::Failure;
use crate::run::{Outcome, Run};
pub use args::Args;
use daemon::AlignRequest;

impl Run for Args {
    /// Aligns two maps, all pairs of a folder, or the map that the running daemon follows; all is well if the pose
    /// may be used.
    ///
    /// # Errors
    /// A map that cannot be used; no daemon.
    fn run(&self) -> Result<Outcome, Failure> {
        if let Some(folder) = &self.pairs {
            return pairs::pairs(folder).map(Outcome::from);
        }
        match (&self.reference, &self.slam) {
            (Some(reference), Some(slam)) => files::align(self, reference, slam),
            (None, None) => self.align_live(),
            _ => Err(Failure::usage("--reference and --slam belong together; without both the running daemon aligns")),
        }
    }
}

impl Args {
    /// Asks the daemon to search the pose of the map that it follows.
    fn align_live(&self) -> Result<Outcome, Failure> {
        let place = &self.place;
        let (hint, storey, places) = (place.pose_hint(), place.storey, place.known_places()?);
        let sample = searched(&self.site.config()?, &AlignRequest::Align { hint, storey, places })?;
        self.write_pose(&sample.view())?;
        Ok(outcome_of(&sample, self.robot_m(), self.json))
    }
}
