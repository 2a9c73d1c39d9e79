//! Contents of the dashboard, printed by `--json`.

use daemon::facts::AlignmentSummary;
use serde::Serialize;

/// The running site at a moment.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub(crate) struct Snapshot {
    /// Generation of the bus; `None` if there is no bus.
    pub(crate) bus_generation: Option<u64>,
    pub(crate) daemons: Vec<DaemonLine>,
    pub(crate) topics: Vec<TopicLine>,
    #[serde(rename = "plan")]
    pub(crate) plan_time_line: Option<PlanTimeLine>,
    /// What a robot may do with the maps: `current`, `overtaken`, `hold` or `no_map`, and why.
    pub(crate) verdict: &'static str,
    pub(crate) why_no_map: Option<String>,
    pub(crate) robot: Option<String>,
    /// Where the robot's map lies; `None` while there is no such map.
    pub(crate) alignment: Option<AlignmentSummary>,
    pub(crate) storeys: Vec<StoreyLine>,
    /// The last errors, the newest first.
    pub(crate) errors: Vec<String>,
}

/// A daemon.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct DaemonLine {
    pub(crate) name: &'static str,
    pub(crate) alive: bool,
    #[serde(rename = "stage")]
    pub(crate) activity: &'static str,
    pub(crate) process_id: u32,
    /// Deaths that were seen.
    pub(crate) restarts: u32,
    pub(crate) memory_bytes: u64,
    pub(crate) silent_s: f64,
    pub(crate) error: Option<String>,
}

/// A topic that has had a sample.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct TopicLine {
    pub(crate) topic: String,
    pub(crate) epoch: u64,
    pub(crate) bytes: u64,
    /// Samples that were seen.
    pub(crate) samples: u64,
    /// Samples a second, over the last ten.
    pub(crate) rate_hz: f64,
    pub(crate) age_s: f64,
    /// From publication to having it; `None` for a sample that was there before.
    pub(crate) latency_ms: Option<f64>,
}

/// The plan time.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize)]
pub(crate) struct PlanTimeLine {
    /// `None` if everything is built.
    pub(crate) plan_time: Option<String>,
    pub(crate) valid_from: Option<String>,
    pub(crate) valid_until: Option<String>,
    pub(crate) changes: u32,
}

/// A map storey.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub(crate) struct StoreyLine {
    pub(crate) index: usize,
    /// `None` if it has none.
    pub(crate) name: Option<String>,
    pub(crate) epoch: u64,
    pub(crate) content_hash: String,
    pub(crate) size_cells: [u32; 2],
    /// Cells that differ from the sample before; `None` if there was none.
    pub(crate) changed_cells: Option<usize>,
    pub(crate) free_m2: f64,
}
