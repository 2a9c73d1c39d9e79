//! Facts of site-server and site-follow.

use super::rasterize::RasterizeFacts;
use super::schedule::ScheduleFacts;
use super::waypoints::WaypointFacts;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Facts of site-server.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct ServeFacts {
    /// Address of the store.
    pub store: String,
    /// The site.
    pub site: String,
    /// Epoch of the index that is in the store; 0 before the first.
    pub epoch: u64,
    /// Plan times of the sets that it has, civil seconds since 1970; `None` if everything is built.
    pub plan_times_s: Vec<Option<i64>>,
    /// Bytes that the last index needed, of blobs that were not there.
    pub new_bytes: u64,
    /// Why nothing is drawn ahead, where the plan time moves.
    pub why_no_later: Option<String>,
}

/// Facts of site-follow. Those of the schedule have the names that schedule-eval has for them.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct FollowFacts {
    /// Address of the store.
    pub store: String,
    /// The site.
    pub site: String,
    /// Epoch of the index that is shown; 0 before the first.
    pub epoch: u64,
    /// Epoch of the newest index that was accepted; it is fetched if it is higher.
    pub newest_epoch: u64,
    /// When the server made the index that is shown, by its clock: RFC 3339 in UTC.
    pub published: Option<String>,
    /// When the index was last asked for and the store answered, milliseconds since 1970 in UTC.
    pub asked_ms: Option<i64>,
    /// Bytes that are fetched, and how many there are of them.
    pub fetching: Option<[u64; 2]>,
    /// Bytes that were fetched for what is shown.
    pub fetched_bytes: u64,
    /// The maps that are published, as rasterize tells of its own.
    pub maps: RasterizeFacts,
    /// The mission plan that is published, as waypoint-gen tells of its own.
    pub mission_plan: WaypointFacts,
    /// Later plan times whose maps are here, civil seconds since 1970.
    pub later_s: Vec<i64>,
    /// What schedule-eval tells where the site is drawn.
    #[serde(flatten)]
    pub schedule: ScheduleFacts,
}
