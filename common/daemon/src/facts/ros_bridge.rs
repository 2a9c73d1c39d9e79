//! Facts of ros-bridge.

use super::Pose;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::net::SocketAddr;

/// Facts of ros-bridge.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct RosBridgeFacts {
    /// Index of the map storey that is published; `None` before the first maps.
    pub storey: Option<u32>,
    /// Index of the map storey that a robot or a person has set; `None` for that of configuration or alignment.
    pub set_storey: Option<u32>,
    /// Index of the map storey that the robot is known to be on, because it went through a portal or the storey was set.
    pub known_storey: Option<u32>,
    /// Metres per cell of the published grids.
    pub resolution_m: Option<f64>,
    /// True if a transform of the robot's map was published.
    pub has_transform: bool,
    /// Pose of the robot in its own map, from `/tf`; `None` if that does not tell it now.
    pub robot_in_slam_map: Option<Pose>,
    /// The same in the model's map, by the alignment that is in effect.
    pub robot_in_map: Option<Pose>,
    /// When the transform of the robot's own frame came that these two poses are by, nanoseconds of the machine's monotonic clock.
    pub robot_seen_ns: Option<u64>,
    /// The ROS domain.
    pub domain_id: u16,
    /// What is there of others.
    pub peers: RosPeers,
    /// Where Foxglove is served; `None` without a server that listens.
    pub foxglove: Option<SocketAddr>,
}

/// Other participants of the ROS 2 graph.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct RosPeers {
    /// How many there are.
    pub participants: usize,
    /// Publishers and subscriptions of theirs, by topic of the bridge.
    pub topics: BTreeMap<String, [usize; 2]>,
}
