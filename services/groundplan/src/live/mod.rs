//! The running daemons: starting and stopping them, asking them, looking at what they publish.

mod align;
mod ask;
mod deviations;
mod doctor;
mod export;
mod keeper;
mod status;
mod topic;
mod up;
mod watch;

pub use align::{align, confirm, slam_map};
pub use ask::{actuals, date, load, robot, waypoints};
pub use deviations::deviations;
pub use doctor::doctor;
pub use export::export;
pub use keeper::keeper;
pub use status::status;
pub use topic::topic;
pub use up::{down, up};

use crate::failure::Failure;
use bus::{Bus, Daemon, Waiter};
use daemon::SiteConfig;

/// Joins the bus of a site as a client.
fn join(config: &SiteConfig) -> Result<(Bus, Waiter), Failure> {
    let domain = config.bus.domain().map_err(Failure::usage)?;
    Bus::join(&domain, Daemon::Groundplan).map_err(Failure::work)
}
