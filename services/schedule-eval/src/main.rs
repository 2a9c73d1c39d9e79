//! Schedule evaluation: `site`, schedule files and the plan time in, `tasks` and `schedule-state` out.

mod evaluation;
mod machine_time;
mod plan_time_clock;
mod plan_time_setting;
mod schedule_files;
mod service;

use service::ScheduleService;
use std::process::ExitCode;

fn main() -> ExitCode {
    daemon::run(ScheduleService::new)
}
