//! Facts of each daemon beside its heartbeat, for `status`, the monitor and metrics.
//!
//! A service makes its facts after every event and request; its loop writes them to the [`crate::StatusBoard`].

mod align;
mod ask;
mod ingest;
mod rasterize;
mod ros_bridge;
mod schedule;
mod server;
mod waypoints;
mod web;

pub use align::{AlignFacts, AlignmentSummary, Pose, PoseHolds};
pub use ask::AskFacts;
pub use ingest::{IngestFacts, MeshFacts, ModelFile};
pub use rasterize::{RasterizeFacts, RobotSummary};
pub use ros_bridge::{RosBridgeFacts, RosPeers};
pub use schedule::{ProgressRows, ScheduleFacts};
pub use server::{FollowFacts, ServeFacts};
pub use waypoints::WaypointFacts;
pub use web::WebFacts;
