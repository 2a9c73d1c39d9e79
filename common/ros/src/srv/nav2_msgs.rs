//! Services of Nav2.

use super::ros_service;
use serde::{Deserialize, Serialize};

/// Nothing, in one byte.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Empty {
    /// Zero.
    pub structure_needs_at_least_one_member: u8,
}

/// Whether it was done.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Success {
    /// True if it was.
    pub success: bool,
}

/// A command to a lifecycle manager.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct ManageLifecycleNodesRequest {
    /// [`Self::PAUSE`], [`Self::RESUME`] and others.
    pub command: u8,
}

impl ManageLifecycleNodesRequest {
    /// Deactivates the nodes.
    pub const PAUSE: u8 = 1;
    /// Activates them again.
    pub const RESUME: u8 = 2;
}

/// A route graph for the route server.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct SetRouteGraphRequest {
    /// Path of its file on the server's machine.
    pub graph_filepath: String,
}

ros_service! {
    /// Forgets what a costmap holds: `<costmap>/clear_entirely_<costmap>`.
    ClearEntireCostmap: nav2_msgs, Empty => Empty
}
ros_service! {
    /// Commands the nodes of a lifecycle manager: `<manager>/manage_nodes`.
    ManageLifecycleNodes: nav2_msgs, ManageLifecycleNodesRequest => Success
}
ros_service! {
    /// Loads another route graph: `<route server>/set_route_graph`.
    SetRouteGraph: nav2_msgs, SetRouteGraphRequest => Success
}
