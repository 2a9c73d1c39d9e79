//! Schedule evaluation: `site` and the plan time in, `phase` out.

use bus::Daemon;
use schedule_eval::service::ScheduleService;
use std::process::ExitCode;

fn main() -> ExitCode {
    daemon::run(Daemon::ScheduleEval, ScheduleService::new)
}
