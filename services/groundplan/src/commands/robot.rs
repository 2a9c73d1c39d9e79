//! `groundplan robot`: another robot for the running daemons.

use crate::args::SiteArgs;
use crate::failure::Failure;
use crate::run::{Outcome, Run};
use crate::wait::{ask, join};
use daemon::RasterizeRequest;
use std::path::PathBuf;

/// Arguments of `robot`.
#[derive(Debug, Clone, clap::Args)]
pub struct Args {
    /// Robot profile, see config/robots
    #[arg(value_name = "FILE")]
    profile: PathBuf,

    /// The site.
    #[command(flatten)]
    site: SiteArgs,
}

impl Run for Args {
    /// Sets the robot profile.
    ///
    /// # Errors
    /// No daemons, a file that is no profile.
    fn run(&self) -> Result<Outcome, Failure> {
        let profile = std::path::absolute(&self.profile).map_err(Failure::usage)?;
        let (bus, mut waiter) = join(&self.site.config()?)?;
        ask(&bus, &mut waiter, &RasterizeRequest::SetRobot { profile })?;
        Ok(Outcome::silent())
    }
}
