//! Schedule evaluation: `site` and the plan time in, `phase` out.

mod plan_clock;
mod service;

use service::ScheduleService;
use std::process::ExitCode;

fn main() -> ExitCode {
    daemon::run(ScheduleService::new)
}
