//! Schedule evaluation: `site`, schedule files and the plan time in, `tasks` and `schedule-state` out.

use schedule_eval::service::ScheduleEval;
use std::process::ExitCode;

fn main() -> ExitCode {
    daemon::run(ScheduleEval::start)
}
