//! The scans of a room: every pose with what it sees, or why there is none.

use crate::circumstances::Circumstances;
use crate::closed_by::ClosedBy;
use crate::named::{RoomRef, StoreyRef};
use crate::situation::Situation;
use export::rounded;
use messages::{MissionPlan, WaypointRecord};
use schemars::JsonSchema;
use serde::Serialize;
use std::fmt::Write;

/// The scans of a room.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct ScansAnswer {
    /// What the answer is made of.
    pub circumstances: Circumstances,
    /// The room.
    pub room: RoomRef,
    /// The map storey of its floor; null if it is on none.
    pub storey: Option<StoreyRef>,
    /// Share of the faces in it that can be seen that all scans see, those of other rooms too; null if there are none, or no scans
    /// are planned.
    pub coverage: Option<f64>,
    /// Scans in it, in the order of the tour.
    pub scans: Vec<ScanPose>,
    /// Why it has none; null if it has.
    pub why_none: Option<String>,
}

/// A pose at which the robot scans.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct ScanPose {
    /// Number of the waypoint in the mission plan.
    pub id: u32,
    /// Place in the tour, from 0 over all storeys.
    pub order: u32,
    /// Position in `map`, on the floor.
    pub at_m: [f64; 3],
    /// Height of the sensor in `map`.
    pub sensor_z_m: f64,
    /// Place of the sensor in `map`, where the ground is not level: along `up`. Without it, straight above.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sensor_m: Option<[f64; 3]>,
    /// Normal of the ground on which the robot stands, a unit vector in `map`, where the ground is not level. Without it, straight up.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub up: Option<[f64; 3]>,
    /// Heading in `map`: the angle in plan of where the robot looks, whatever the slope.
    pub yaw_rad: f64,
    /// Floor that it sees and no scan before it.
    pub covers_m2: f64,
    /// Sides of occupied cells that it sees.
    pub faces: u32,
    /// Share of them that scans before it have seen.
    pub overlap: f64,
    /// For a scan that is there to join others: the number of one that does not register without it; else null.
    pub joins: Option<u32>,
}

/// Scans of a space in the order of the tour.
pub(crate) fn scans_in<'m>(mission_plan: &MissionPlan<'m>, space: usize) -> Vec<&'m WaypointRecord> {
    let here = mission_plan.waypoints.iter().filter(|w| w.space as usize == space && w.purpose().scan().is_some());
    let mut scans: Vec<_> = here.collect();
    scans.sort_by_key(|scan| scan.order);
    scans
}

/// The scans of a space of the site.
pub fn scans(situation: &Situation<'_>, space: usize) -> ScansAnswer {
    let Situation { site, mission_plan, .. } = *situation;
    let pose = |w: &WaypointRecord| ScanPose {
        id: w.id,
        order: w.order,
        at_m: w.position_in_map_m.map(rounded),
        sensor_z_m: rounded(w.sensor_in_map_m[2]),
        sensor_m: w.attitude().is_tilted().then(|| w.sensor_in_map_m.map(rounded)),
        up: w.attitude().is_tilted().then_some(w.up_in_map),
        yaw_rad: w.yaw_rad,
        covers_m2: rounded(w.covers_m2),
        faces: w.n_faces,
        overlap: rounded(w.overlap),
        joins: w.purpose().scan().and_then(|scan| scan.joins).map(|joined| joined.waypoint),
    };
    let scans: Vec<ScanPose> = scans_in(mission_plan, space).into_iter().map(pose).collect();
    let planned = &mission_plan.spaces[space];
    ScansAnswer {
        circumstances: situation.circumstances.clone(),
        room: RoomRef::of(site, space),
        storey: StoreyRef::of(site, site.spaces[space].map_storey),
        coverage: (planned.n_faces > 0).then(|| rounded(f64::from(planned.n_seen) / f64::from(planned.n_faces))),
        why_none: scans.is_empty().then(|| why_none(situation, space)),
        scans,
    }
}

fn why_none(situation: &Situation<'_>, space: usize) -> String {
    let mission_plan = situation.mission_plan;
    let closed_by: Vec<String> = ClosedBy::all_of(situation, space).iter().map(ClosedBy::text).collect();
    if !closed_by.is_empty() {
        return format!("it is closed by the schedule: {}", closed_by.join("; "));
    }
    let reasons = [mission_plan.access_reason(space), mission_plan.reason(space)];
    if let Some(reason) = reasons.into_iter().find(|reason| !reason.is_empty()) {
        return reason.to_owned();
    }
    let planned = &mission_plan.spaces[space];
    match (planned.n_seen, planned.n_faces) {
        (_, 0) if mission_plan.storeys.iter().all(|storey| storey.n_faces == 0) => "no scans are planned".to_owned(),
        (_, 0) => "nothing in it is to be seen".to_owned(),
        (seen, faces) if seen == faces => "scans of other rooms see all of it".to_owned(),
        (seen, faces) => {
            let percent = 100.0 * f64::from(seen) / f64::from(faces);
            format!("scans of other rooms see {percent:.1} % of it, and one in it was not worth its time")
        }
    }
}

impl ScansAnswer {
    /// For people: a line for each pose.
    pub fn text(&self) -> String {
        let mut out = String::new();
        let storey = self.storey.as_ref().map_or("on no map storey", |storey| &storey.name);
        // Writing to a string does not fail.
        let _ = writeln!(out, "{} ({}), {storey}", self.room.label(), self.room.global_id);
        if let Some(coverage) = self.coverage {
            let _ = writeln!(out, "  {:.1} % of what can be seen in it is seen", 100.0 * coverage);
        }
        for scan in &self.scans {
            let _ = writeln!(out, "  {}", scan.line());
        }
        if let Some(why) = &self.why_none {
            let _ = writeln!(out, "  no scan: {why}");
        }
        let _ = writeln!(out, "{}", self.circumstances);
        out
    }
}

impl ScanPose {
    fn line(&self) -> String {
        let [x_m, y_m, z_m] = self.at_m;
        let joins = self.joins.map_or(String::new(), |id| format!(", joins waypoint {id} to the others"));
        format!(
            "waypoint {} at x {x_m:.2} m, y {y_m:.2} m, z {z_m:.2} m: {:.1} m2 of floor that no scan before it sees{joins}",
            self.id, self.covers_m2
        )
    }
}
