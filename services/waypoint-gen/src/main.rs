//! Planning of waypoints: `site`, `schedule-state` and grids in, centres, scans, tours and the route graph out.

mod options_setting;
mod service;

use service::WaypointService;
use std::process::ExitCode;

fn main() -> ExitCode {
    // Maps do not wait for waypoints.
    daemon::in_background();
    daemon::run(WaypointService::new)
}
