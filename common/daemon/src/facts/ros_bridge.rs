//! Facts of ros-bridge.

use serde::{Deserialize, Serialize};
use std::net::SocketAddr;

/// Facts of ros-bridge.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct RosBridgeFacts {
    /// Index of the map storey that is published; `None` before the first maps.
    pub storey: Option<usize>,
    /// True if a transform of the robot's map was published.
    pub has_transform: bool,
    /// Where Foxglove is served; `None` without a server that listens.
    pub foxglove: Option<SocketAddr>,
}
