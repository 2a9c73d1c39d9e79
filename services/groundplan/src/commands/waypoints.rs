//! `groundplan waypoints`: other waypoints of the running daemons.

use crate::args::SiteArgs;
use crate::date_argument;
use crate::failure::Failure;
use crate::run::{Outcome, Run};
use crate::wait::{ask, join};
use daemon::WaypointRequest;
use std::path::PathBuf;

/// Arguments of `waypoints`.
#[derive(Debug, Clone, clap::Args)]
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

    /// The site.
    #[command(flatten)]
    site: SiteArgs,
}

impl Run for Args {
    /// Sets what waypoints to plan.
    ///
    /// # Errors
    /// No daemons, a file or date that cannot be used.
    fn run(&self) -> Result<Outcome, Failure> {
        let options = self.options.as_deref().map(std::path::absolute).transpose().map_err(Failure::usage)?;
        let config = self.site.config()?;
        let instant_s = |text| date_argument::instant_at_site_s(text, &config);
        let changed_since_s = self.changed_since.as_deref().map(instant_s).transpose()?;
        let (bus, mut waiter) = join(&config)?;
        let request = WaypointRequest::SetWaypoints { options, spaces: self.space.clone(), changed_since_s };
        ask(&bus, &mut waiter, &request)?;
        Ok(Outcome::silent())
    }
}
