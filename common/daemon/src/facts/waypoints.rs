//! Facts of waypoint-gen.

use crate::request::Published;
use crate::setting::SettingInForce;
use messages::ContentHash;
use serde::{Deserialize, Serialize};

/// Facts of waypoint-gen.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct WaypointFacts {
    /// The mission plan that is published.
    pub mission_plan: Published,
    /// Content hash of the index of grids that it was made from.
    pub grids_hash: ContentHash,
    /// Its waypoints.
    pub waypoints: usize,
    /// Those that are scan poses.
    pub scans: u32,
    /// Where the options come from.
    pub settings: Vec<SettingInForce>,
}
