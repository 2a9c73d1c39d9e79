//! The coverage curve of a mission plan: scans against the share of the faces that they see.

use crate::text::rounded;
use messages::MissionPlan;
use schemars::JsonSchema;
use serde::Serialize;

/// A point of the curve.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub(crate) struct CurvePoint {
    /// Number of scans, those that join others included.
    pub(crate) scans: u32,
    /// Share of the faces that can be seen that so many scans see; a plan with as many sees at least this.
    pub(crate) coverage: f64,
}

/// The curve of a map storey, or of all, from one scan to as many as see anything new; empty if no scans are planned.
pub(crate) fn coverage_curve(mission_plan: &MissionPlan<'_>, map_storey: Option<u32>) -> Vec<CurvePoint> {
    let counts = |storey: u32| map_storey.is_none_or(|wanted| wanted == storey);
    let storeys = mission_plan.storeys.iter().filter(|storey| counts(storey.map_storey));
    let n_faces: u64 = storeys.map(|storey| u64::from(storey.n_faces)).sum();
    let mut n_seen = 0;
    let point = |(scans, scan): (u32, &messages::GrownScanRecord)| {
        n_seen += u64::from(scan.n_new);
        CurvePoint { scans, coverage: rounded(n_seen as f64 / n_faces.max(1) as f64) }
    };
    let growth = mission_plan.growth.iter().filter(|scan| counts(scan.map_storey));
    (1..).zip(growth).map(point).collect()
}
