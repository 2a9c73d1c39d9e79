//! Alignment: `site`, `schedule-state` and the robot's map in, where that map lies and what differs out.

mod persisted_state;
mod reference_inputs;
mod robot_map;
mod service;
mod worker;

use service::AlignService;
use std::process::ExitCode;

fn main() -> ExitCode {
    daemon::run(AlignService::new)
}
