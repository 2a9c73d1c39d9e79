//! Summary of the scans of a mission plan: how many there are, what they see, how long they take.

use crate::text::rounded;
use diagnostics::counted;
use messages::MissionPlan;
use serde::{Deserialize, Serialize};

/// The scans of a mission plan over all storeys.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ScanSummary {
    /// Scans, those that join others included.
    pub scans: u32,
    /// Scans that are there to join others.
    pub connecting_scans: u32,
    /// Share of the faces that can be seen that they see.
    pub coverage: f64,
    /// Estimated duration of all tours, driving and scanning.
    pub mission_s: f64,
    /// Of which scanning.
    pub scanning_s: f64,
}

impl ScanSummary {
    /// `None` if no scans are planned, or nothing can be seen.
    pub fn of(mission_plan: &MissionPlan<'_>) -> Option<Self> {
        let sum = |of: fn(&messages::MissionPlanStoreyRecord) -> u32| mission_plan.storeys.iter().map(of).sum::<u32>();
        let n_faces = sum(|storey| storey.n_faces);
        let [driving_s, scanning_s] = mission_plan.head.mission_s;
        (n_faces > 0).then(|| Self {
            scans: sum(|storey| storey.n_scans),
            connecting_scans: sum(|storey| storey.n_connecting),
            coverage: rounded(f64::from(sum(|storey| storey.n_seen)) / f64::from(n_faces)),
            mission_s: rounded(driving_s + scanning_s),
            scanning_s: rounded(scanning_s),
        })
    }

    /// `12 scans, 2 of them to join others, see 99.1 % of what can be seen; about 31 minutes, 12 of them scanning`.
    pub fn text(&self) -> String {
        let Self { scans, connecting_scans, coverage, mission_s, scanning_s } = self;
        let joining = match connecting_scans {
            0 => String::new(),
            n => format!(", {n} of them to join others,"),
        };
        let see = if *scans == 1 { "sees" } else { "see" };
        format!(
            "{}{joining} {see} {:.1} % of what can be seen; about {:.0} minutes, {:.0} of them scanning",
            counted(*scans as usize, "scan"),
            100.0 * coverage,
            mission_s / 60.0,
            scanning_s / 60.0
        )
    }
}
