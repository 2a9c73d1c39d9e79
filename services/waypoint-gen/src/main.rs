//! Planning of waypoints: `site`, `phase` and grids in, centres, scans, tours and the route graph out.

use bus::Daemon;
use std::process::ExitCode;
use waypoint_gen::service::WaypointService;

fn main() -> ExitCode {
    // Maps do not wait for waypoints.
    daemon::in_background();
    daemon::run(Daemon::WaypointGen, WaypointService::new)
}
