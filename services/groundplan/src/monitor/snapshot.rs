//! Contents of the dashboard, printed by `--json`.

use daemon::facts::AlignmentSummary;
use schemars::JsonSchema;
use serde::Serialize;

/// The running site at a moment.
#[derive(Debug, Clone, Default, PartialEq, Serialize, JsonSchema)]
pub(crate) struct Snapshot {
    /// Generation of the bus; null if there is no bus.
    pub(crate) bus_generation: Option<u64>,
    /// The supervised ones in the order of the data, then others.
    pub(crate) daemons: Vec<DaemonLine>,
    /// By name.
    pub(crate) topics: Vec<TopicLine>,
    /// The plan time of the schedule state; null before the first.
    #[serde(rename = "plan")]
    pub(crate) plan_time_line: Option<PlanTimeLine>,
    /// What a robot may do with the maps: `current`, `overtaken`, `hold` or `no_map`, and why.
    pub(crate) verdict: &'static str,
    /// Null unless the verdict is `no_map`.
    pub(crate) why_no_map: Option<String>,
    /// Name of the robot that the maps are for; null before the first maps.
    pub(crate) robot: Option<String>,
    /// Where the robot's map lies; null while there is no such map.
    pub(crate) alignment: Option<AlignmentSummary>,
    /// Map storeys that have a grid.
    pub(crate) storeys: Vec<StoreyLine>,
    /// The last errors, the newest first.
    pub(crate) errors: Vec<String>,
}

/// A daemon.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub(crate) struct DaemonLine {
    /// As of its process.
    pub(crate) name: &'static str,
    /// True if its heartbeat comes.
    pub(crate) alive: bool,
    /// What it was doing at its last heartbeat; `silent` before the first.
    #[serde(rename = "stage")]
    pub(crate) activity: &'static str,
    /// Its process; 0 before the first heartbeat.
    pub(crate) process_id: u32,
    /// Deaths that were seen.
    pub(crate) restarts: u32,
    /// Resident memory in bytes.
    pub(crate) memory_bytes: u64,
    /// Seconds since its last heartbeat.
    pub(crate) silent_s: f64,
    /// Its error, or its warning.
    pub(crate) error: Option<String>,
}

/// A topic that has had a sample.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub(crate) struct TopicLine {
    /// As `groundplan topic list` names it.
    pub(crate) topic: String,
    /// Epoch of the last sample.
    pub(crate) epoch: u64,
    /// Length of its payload.
    pub(crate) bytes: u64,
    /// Samples that were seen.
    pub(crate) samples: u64,
    /// Samples a second, over the last ten.
    pub(crate) rate_hz: f64,
    /// Seconds since the last sample was published.
    pub(crate) age_s: f64,
    /// Milliseconds from publication to having it; null for a sample that was there before.
    pub(crate) latency_ms: Option<f64>,
}

/// The plan time.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, JsonSchema)]
pub(crate) struct PlanTimeLine {
    /// null if everything is built.
    pub(crate) plan_time: Option<String>,
    /// Since when the states hold; null if they always did.
    pub(crate) valid_from: Option<String>,
    /// Until when the states hold; null if for good.
    pub(crate) valid_until: Option<String>,
    /// Changes of the whole schedule.
    pub(crate) changes: u32,
}

/// A map storey.
#[derive(Debug, Clone, Default, PartialEq, Serialize, JsonSchema)]
pub(crate) struct StoreyLine {
    /// Number of its topic: `grid/00` for 0.
    pub(crate) index: usize,
    /// null if it has none.
    pub(crate) name: Option<String>,
    /// Epoch of its grid.
    pub(crate) epoch: u64,
    /// Of its grid, in hexadecimal.
    pub(crate) content_hash: String,
    /// Columns and rows.
    pub(crate) size_cells: [u32; 2],
    /// Cells that differ from the sample before; null if there was none.
    pub(crate) changed_cells: Option<usize>,
    /// Area that the robot may drive on.
    pub(crate) free_m2: f64,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shipped_schema::assert_shipped_schema;

    #[test]
    fn the_shipped_schema_is_that_of_a_line() {
        assert_shipped_schema("monitor", &schemars::schema_for!(Snapshot));
    }
}
