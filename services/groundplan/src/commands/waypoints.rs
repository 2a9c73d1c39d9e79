//! `groundplan waypoints`: other waypoints of the running daemons.

use crate::args::SiteOfRobotArgs;
use crate::date_argument;
use crate::failure::Failure;
use crate::run::{Outcome, Run};
use crate::wait::{ask, join};
use daemon::{FileText, WaypointAnswer, WaypointRequest};
use diagnostics::counted;
use input_files::MAX_CONFIGURATION_BYTES;
use std::path::PathBuf;

/// Arguments of `waypoints`.
#[derive(Debug, Clone, clap::Args)]
#[command(
    after_help = "The options are kept with the content of their file, and count until waypoints.options of the site's file, or \
the file that it names, is edited. Without arguments those of the site's file count again."
)]
pub struct Args {
    /// What to plan and with which sensor, see config/waypoints.toml [default: what is configured]
    #[arg(value_name = "FILE")]
    options: Option<PathBuf>,

    /// Only this space, by name, long name or GlobalId, with * and ?; may be repeated
    #[arg(long, value_name = "SPACE")]
    space: Vec<String>,

    /// Scan only what was built since this plan time
    #[arg(long, value_name = "DATE")]
    changed_since: Option<String>,

    /// Print one JSON document on standard output and nothing else there
    #[arg(long)]
    json: bool,

    /// The site.
    #[command(flatten)]
    site: SiteOfRobotArgs,
}

impl Run for Args {
    /// Sets what waypoints to plan, and prints what is planned.
    ///
    /// # Errors
    /// No daemons, a file or date that cannot be used, a space that the site does not have; the options of before stay.
    fn run(&self) -> Result<Outcome, Failure> {
        let read = |path| FileText::read_up_to("options of waypoints", path, MAX_CONFIGURATION_BYTES);
        let options = self.options.as_deref().map(read).transpose().map_err(Failure::work)?;
        let config = self.site.config_of_drawing()?;
        let instant_s = |text| date_argument::instant_at_site_s(text, &config);
        let changed_since_s = self.changed_since.as_deref().map(instant_s).transpose()?;
        let (bus, mut waiter) = join(&config)?;
        let request = WaypointRequest::SetWaypoints { options, spaces: self.space.clone(), changed_since_s };
        let answer = ask(&bus, &mut waiter, &request)?;
        if answer.mission_plan.epoch > 0 && answer.waypoints == 0 {
            eprintln!(
                "groundplan: warning: no waypoint: nothing that is meant can be reached and scanned at this plan time"
            );
        }
        Ok(if self.json { Outcome::json(&answer)? } else { text(&answer).into() })
    }
}

fn text(answer: &WaypointAnswer) -> String {
    let WaypointAnswer { mission_plan, storeys, waypoints, scans, mission_s, setting } = answer;
    let planned = match mission_plan.epoch {
        0 => "they are planned when there are maps".to_owned(),
        epoch => format!(
            "{} with {} on {}, about {:.0} minutes, epoch {epoch}",
            counted(*waypoints, "waypoint"),
            counted(*scans as usize, "scan"),
            counted(*storeys, "storey"),
            mission_s / 60.0
        ),
    };
    format!("waypoints of {}: {planned}\n", setting.value)
}
