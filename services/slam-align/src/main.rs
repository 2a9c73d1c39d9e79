//! Alignment: `site`, `phase` and the robot's map in, where that map lies and what differs out.

use bus::Daemon;
use slam_align::service::AlignService;
use std::process::ExitCode;

fn main() -> ExitCode {
    daemon::run(Daemon::SlamAlign, AlignService::new)
}
