//! Alignment: `site`, `schedule-state` and the robot's map in, where that map lies and what differs out.
//!
//! # Guarantees
//!
//! - `slam-align` follows the robot's map on its own thread; references, searches of all poses and comparisons run on
//!   another, behind all other processes. It never waits for that thread: a client asks for a search by number and then about
//!   it, so that a newer map is known while an earlier one is searched. A panic there is the error of its job; a result is
//!   taken, also in the next generation of the bus, if site, robot and frame are still the same, and made again if not.
//! - `slam-align` keeps a copy of a map file, and who confirmed what when: a confirmation is taken back with the pose before
//!   it.

use slam_align::service::SlamAlign;
use std::process::ExitCode;

fn main() -> ExitCode {
    daemon::run(bus::commit!(), SlamAlign::start)
}
