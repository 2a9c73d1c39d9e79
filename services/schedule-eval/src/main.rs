//! Schedule evaluation: `site`, schedule files and the plan time in, `tasks` and `schedule-state` out.
//!
//! # Guarantees
//!
//! - `schedule-eval` watches the schedule files of a site, and reads them once they look the same at two looks. What is in
//!   force lies with its contents in the state folder: a file that is removed or spoilt changes nothing, and is a warning.
//!   The tasks are on the bus before the states that follow them, and a `SiteSet` that names tasks has them.

use schedule_eval::service::ScheduleEval;
use std::process::ExitCode;

fn main() -> ExitCode {
    daemon::run(bus::commit!(), ScheduleEval::start)
}
