//! Requests to waypoint-gen.

use crate::request::{Published, Request};
use bus::Daemon;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// What waypoint-gen takes; it answers with the mission plan that it published.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum WaypointRequest {
    /// What to plan, beside what is configured; with nothing, what is configured counts again.
    SetWaypoints {
        /// Absolute path of options, in the place of those that are configured.
        options: Option<PathBuf>,
        /// Only these spaces: names, long names or GlobalIds, with `*` and `?`.
        spaces: Vec<String>,
        /// Only what was built since this plan time, civil seconds since 1970.
        changed_since_s: Option<i64>,
    },
}

impl Request for WaypointRequest {
    const DAEMON: Daemon = Daemon::WaypointGen;
    type Answer = Published;
}
