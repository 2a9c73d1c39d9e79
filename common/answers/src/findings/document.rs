//! The keys of `report.json` and `waypoints.json` that findings are made of; other keys are left alone.

use serde::Deserialize;

/// What of `report.json` findings are made of.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub struct ReportDocument {
    pub(crate) schedule_ignored: bool,
    pub(crate) diagnostics: Vec<Entry>,
    pub(crate) assumed_rooms: Vec<Entry>,
    pub(crate) doors: Vec<Entry>,
    pub(crate) failed_geometry: Vec<Entry>,
    pub(crate) spaces_not_mapped: Vec<Entry>,
    pub(crate) storeys_not_mapped: Vec<Entry>,
}

/// What of `waypoints.json` findings are made of.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub struct WaypointsDocument {
    pub(crate) notices: Vec<Entry>,
}

/// An entry of any list of the two documents.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct Entry {
    pub(crate) severity: Option<String>,
    pub(crate) code: Option<String>,
    pub(crate) message: Option<String>,
    pub(crate) reason: Option<String>,
    pub(crate) file: Option<String>,
    pub(crate) entity: Option<String>,
    pub(crate) global_id: Option<String>,
    /// GlobalId, where a list calls it so.
    pub(crate) element: Option<String>,
    pub(crate) name: Option<String>,
    pub(crate) drawn_as: Option<String>,
    pub(crate) clear_width_from: Option<String>,
    pub(crate) clear_width_m: Option<f64>,
}
