//! ROS 2 and Foxglove: maps, masks, markers and diagnostics of the robot's storey out, the robot's SLAM map in.

mod foxglove;
mod graph;
mod outputs;
mod service;
mod slam_map;
mod storey;

use service::BridgeService;
use std::process::ExitCode;

fn main() -> ExitCode {
    daemon::run(BridgeService::new)
}
