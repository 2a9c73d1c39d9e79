//! Requests to waypoint-gen.

use crate::file_text::FileText;
use crate::request::{Published, Request};
use crate::setting::SettingInForce;
use bus::Daemon;
use serde::{Deserialize, Serialize};

/// Requests to waypoint-gen.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum WaypointRequest {
    /// What to plan, beside what is configured; with nothing, what is configured counts again.
    SetWaypoints {
        /// Options that the client has read, in the place of those that `site.toml` names.
        options: Option<FileText>,
        /// Only these spaces: names, long names or GlobalIds, with `*` and `?`.
        spaces: Vec<String>,
        /// Only what was built since this plan time, civil seconds since 1970.
        changed_since_s: Option<i64>,
    },
}

/// Answer of waypoint-gen: what is in force.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct WaypointAnswer {
    /// The mission plan that it published; none before there are maps.
    pub mission_plan: Published,
    /// Its map storeys with waypoints.
    pub storeys: usize,
    /// Its waypoints.
    pub waypoints: usize,
    /// Those of them that are scan poses.
    pub scans: u32,
    /// Estimated duration of all tours, driving and scanning.
    pub mission_s: f64,
    /// The options, and where they come from.
    pub setting: SettingInForce,
}

impl Request for WaypointRequest {
    const DAEMON: Daemon = Daemon::WaypointGen;
    type Answer = WaypointAnswer;

    fn may_be_sent_twice(&self) -> bool {
        true
    }
}
