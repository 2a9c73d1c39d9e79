//! Schedule evaluation: `site` and the plan time in, `schedule-state` out.

mod machine_time;
mod plan_time_clock;
mod plan_time_setting;
mod service;

use service::ScheduleService;
use std::process::ExitCode;

fn main() -> ExitCode {
    daemon::run(ScheduleService::new)
}
