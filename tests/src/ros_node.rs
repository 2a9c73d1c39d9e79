//! A node of ROS 2 itself: rclpy on Fast DDS, from wheels.

use super::peer::Peer;
use super::{announce, root};
use std::ffi::OsStr;
use std::process::Command;
use std::sync::OnceLock;

const PACKAGES: [&str; 5] = [
    "ros-kilted-rclpy==9.1.2",
    "ros-kilted-rmw-fastrtps-cpp==9.3.3",
    "ros-kilted-rmw-implementation==3.0.4",
    "ros-kilted-nav-msgs==5.5.1",
    "ros-kilted-std-srvs==5.5.1",
];

/// True, unless ROS 2 cannot be had: then it says so. Its wheels are for CPython 3.11. All tests of a process look once.
pub fn has_node() -> bool {
    static HAS_NODE: OnceLock<bool> = OnceLock::new();
    *HAS_NODE.get_or_init(|| {
        let made = Command::new(root().join("scripts/python-env")).args(PACKAGES).output().unwrap();
        if !made.status.success() {
            let why = String::from_utf8_lossy(&made.stderr);
            announce(&format!("SKIPPED: ROS 2 (rclpy) cannot be installed: {why}"));
        }
        made.status.success()
    })
}

fn start(script: &str, domain: u16, more: &[&dyn AsRef<OsStr>]) -> Peer {
    let mut command = Command::new(root().join("target/venv/bin/python"));
    Peer::start(command.arg(root().join(script)).args(["--domain", &domain.to_string()]).args(more))
}

/// A node that prints once a second what it sees of the graph.
pub fn join(domain: u16) -> Peer {
    start("scripts/ros_node.py", domain, &[])
}

/// A node that takes the grids, and does what it is told to.
pub fn consumer(domain: u16, more: &[&dyn AsRef<OsStr>]) -> Peer {
    start("scripts/ros_consumer.py", domain, more)
}
