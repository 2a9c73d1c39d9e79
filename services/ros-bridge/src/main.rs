//! ROS 2 and Foxglove: maps, masks, markers and diagnostics of the robot's storey out, the robot's SLAM map in.

mod board;
mod calls;
mod config_check;
mod control;
mod followed_transform;
mod foxglove;
mod graph;
mod kept_slam_frame;
mod machine_clock;
mod map_sender;
mod nav2;
mod outputs;
mod parameters;
mod portals;
mod rivals;
mod robot;
mod robot_pose;
mod service;
mod sim_time;
mod slam_map;
mod storey;

use service::BridgeService;
use std::process::ExitCode;

fn main() -> ExitCode {
    daemon::run(BridgeService::new)
}
