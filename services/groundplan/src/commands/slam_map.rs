//! `groundplan slam-map`: a map of the robot for the running daemons.

use crate::alignment_request::{outcome_of, searched};
use crate::args::SiteOfRobotArgs;
use crate::failure::Failure;
use crate::run::{Outcome, Run};
use daemon::AlignRequest;
use std::path::PathBuf;

/// Arguments of `slam-map`.
#[derive(Debug, Clone, clap::Args)]
#[command(after_help = "\
Exit codes: 0 accepted and effective, 1 failed (the map before it stays), 2 bad usage or configuration, 3 waits_for_confirm, \
4 held, 5 refused or ambiguous, 6 uncertain; see `groundplan align`.")]
pub struct Args {
    /// Map that the robot made, as its map server saves it
    #[arg(value_name = "MAP.yaml")]
    map: PathBuf,

    /// Where the robot is in that map, in metres [default: not known, so that the pose must be known well enough anywhere in it]
    #[arg(long, num_args = 2, value_names = ["X", "Y"], allow_negative_numbers = true)]
    robot: Vec<f64>,

    /// Print one JSON document on standard output and nothing else there
    #[arg(long)]
    json: bool,

    /// The site.
    #[command(flatten)]
    site: SiteOfRobotArgs,
}

impl Run for Args {
    /// Gives the daemon a map of the robot; all is well if its pose may be used.
    ///
    /// # Errors
    /// No daemons, a map that cannot be used, no site to compare it with; the map before it stays.
    fn run(&self) -> Result<Outcome, Failure> {
        let file = std::path::absolute(&self.map).map_err(Failure::usage)?;
        let sample = searched(&self.site.config()?, &AlignRequest::ReadSlamMap { file })?;
        Ok(outcome_of(&sample, self.robot.first_chunk::<2>().copied(), self.json))
    }
}
