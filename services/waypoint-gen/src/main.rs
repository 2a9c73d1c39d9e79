//! Planning of waypoints: `site`, `schedule-state` and grids in, centres, scans, tours and the route graph out.
//!
//! # Guarantees
//!
//! - `waypoint-gen` gives way to all other processes: maps do not wait for waypoints.

use std::process::ExitCode;
use waypoint_gen::service::WaypointGen;

fn main() -> ExitCode {
    // Maps do not wait for waypoints.
    daemon::in_background();
    daemon::run(bus::commit!(), WaypointGen::start)
}
