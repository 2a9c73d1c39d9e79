//! Facts of ros-bridge.

use super::Pose;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Facts of ros-bridge.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct RosBridgeFacts {
    /// Index of the map storey that is published; `None` before the first maps.
    pub storey: Option<u32>,
    /// Index of the map storey that a robot or a person has set; `None` for that of configuration or alignment.
    pub set_storey: Option<u32>,
    /// Metres per cell of the published grids.
    pub resolution_m: Option<f64>,
    /// True if a transform of the robot's map was published.
    pub has_transform: bool,
    /// Pose of the robot in its own map, from `/tf`; `None` if that does not tell it now.
    pub robot_in_slam_map: Option<Pose>,
    /// The same in the model's map, by the alignment that is in effect.
    pub robot_in_map: Option<Pose>,
    /// Publishers and subscriptions of other nodes, by topic.
    pub peers: BTreeMap<String, [usize; 2]>,
}
