//! Rasterisation: `site`, `schedule-state` and the robot in, one grid per map storey and their index out.

use rasterize::service::Rasterize;
use std::process::ExitCode;

fn main() -> ExitCode {
    daemon::run(bus::commit!(), Rasterize::start)
}
