//! Alignment: `site`, `schedule-state` and the robot's map in, where that map lies and what differs out.

mod background_worker;
mod compared_elements;
mod job;
mod map_setting;
mod newest_inputs;
mod persisted_state;
mod robot_map;
mod searches;
mod service;
mod stored_evidence;
mod stored_map;

use service::AlignService;
use std::process::ExitCode;

fn main() -> ExitCode {
    daemon::run(AlignService::new)
}
