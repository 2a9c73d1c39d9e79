//! `groundplan robot`: another robot for the running daemons.

use crate::args::SiteOfRobotArgs;
use crate::failure::Failure;
use crate::run::{Outcome, Run};
use crate::wait::{ask, join};
use daemon::{FileText, RasterizeAnswer, RasterizeRequest};
use input_files::MAX_CONFIGURATION_BYTES;
use std::path::PathBuf;

/// Arguments of `robot`.
#[derive(Debug, Clone, clap::Args)]
#[command(
    after_help = "The robot is kept with the content of its profile, and counts until robot.profile of the site's file, or the \
profile that it names, is edited."
)]
pub struct Args {
    /// Robot profile, see config/robots
    #[arg(value_name = "FILE")]
    profile: PathBuf,

    /// Print one JSON document on standard output and nothing else there
    #[arg(long)]
    json: bool,

    /// The site.
    #[command(flatten)]
    site: SiteOfRobotArgs,
}

impl Run for Args {
    /// Sets the robot profile, and prints the robot that is in force.
    ///
    /// # Errors
    /// No daemons, a file that is no profile, a robot that cannot be drawn for; the robot of before stays.
    fn run(&self) -> Result<Outcome, Failure> {
        let profile = FileText::read_up_to("robot profile", &self.profile, MAX_CONFIGURATION_BYTES);
        let profile = profile.map_err(Failure::work)?;
        let (bus, mut waiter) = join(&self.site.config_of_drawing()?)?;
        let answer = ask(&bus, &mut waiter, &RasterizeRequest::SetRobot { profile })?;
        Ok(if self.json { Outcome::json(&answer)? } else { text(&answer).into() })
    }
}

fn text(answer: &RasterizeAnswer) -> String {
    let RasterizeAnswer { grids, robot, resolution_m, .. } = answer;
    let maps = match grids.epoch {
        0 => "maps follow when there is a site".to_owned(),
        epoch => format!("maps of {resolution_m} m a cell, epoch {epoch}"),
    };
    format!("{robot}; {maps}\n")
}
