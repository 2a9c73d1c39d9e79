//! Waypoints as JSON, GeoJSON and the YAML of Nav2's panel.

use crate::{ExportInput, rounded};
use messages::{WaypointKind, WaypointRecord};
use schemars::JsonSchema;
use serde::Serialize;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::fmt::Write;

/// `waypoints.json`: poses to drive to, in order.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Waypoints {
    /// `map`.
    frame: &'static str,
    /// Epoch of the map frame.
    frame_epoch: u32,
    /// Plan time; null if all elements stand regardless of dates.
    plan_time: Option<String>,
    /// The waypoints.
    waypoints: Vec<Waypoint>,
    /// What became of each space, by GlobalId.
    spaces: BTreeMap<String, SpaceOutcome>,
}

#[derive(Debug, Serialize, JsonSchema)]
struct Waypoint {
    /// Number in the plan.
    id: u32,
    /// Place in the tour over all storeys, from 0.
    order: u32,
    /// `centre` or `scan`.
    kind: &'static str,
    /// Index of the map storey.
    storey: u32,
    /// GlobalId of the space.
    space: String,
    /// Name of the space.
    name: String,
    /// In `map`.
    x_m: f64,
    /// In `map`.
    y_m: f64,
    /// Height of the floor in `map`.
    z_m: f64,
    /// Height of the sensor in `map`.
    sensor_z_m: f64,
    /// Heading in `map`.
    yaw_rad: f64,
    /// Area centroid of the space's floor, not moved.
    centroid_m: [f64; 3],
    /// Distance to the nearest cell that is not free.
    clearance_m: f64,
    /// Area that a scan from here adds; 0 for centres.
    covers_m2: f64,
}

#[derive(Debug, Serialize, JsonSchema)]
struct SpaceOutcome {
    /// Index of the map storey; null if it is on none.
    storey: Option<u32>,
    /// Share of what can be seen that scans cover; null if only centres are planned.
    coverage: Option<f64>,
    /// Why it has no waypoint; null if it has one.
    reason: Option<String>,
}

impl Waypoints {
    pub(crate) fn of(input: &ExportInput<'_>) -> Self {
        let site = input.site;
        let outcome = |index: usize| {
            let map_storey = site.spaces[index].map_storey;
            let reason = input.plan.reason(index);
            SpaceOutcome {
                storey: (map_storey != messages::NONE).then_some(map_storey),
                coverage: None,
                reason: (!reason.is_empty()).then(|| reason.to_owned()),
            }
        };
        let id = |index: usize| site.text(site.spaces[index].global_id).to_owned();
        Self {
            frame: "map",
            frame_epoch: site.head.frame_epoch,
            plan_time: input.phase.head.plan_time().map(|t| t.to_string()),
            waypoints: input.plan.waypoints.iter().map(|w| waypoint(input, w)).collect(),
            spaces: (0..site.spaces.len()).map(|index| (id(index), outcome(index))).collect(),
        }
    }
}

fn waypoint(input: &ExportInput<'_>, w: &WaypointRecord) -> Waypoint {
    let space = &input.site.spaces[w.space as usize];
    let [x_m, y_m, z_m] = w.position_in_map_m.map(rounded);
    Waypoint {
        id: w.id,
        order: w.order,
        kind: kind(w),
        storey: w.map_storey,
        space: input.site.text(space.global_id).to_owned(),
        name: name_of(input, w),
        x_m,
        y_m,
        z_m,
        sensor_z_m: rounded(w.sensor_z_m),
        yaw_rad: w.yaw_rad,
        centroid_m: w.centroid_in_map_m.map(rounded),
        clearance_m: rounded(w.clearance_m),
        covers_m2: rounded(w.covers_m2),
    }
}

pub(crate) fn kind(w: &WaypointRecord) -> &'static str {
    if w.kind == WaypointKind::Scan as u32 { "scan" } else { "centre" }
}

/// Name and long name of the waypoint's space.
pub(crate) fn name_of(input: &ExportInput<'_>, w: &WaypointRecord) -> String {
    let space = &input.site.spaces[w.space as usize];
    let names = [input.site.text(space.name), input.site.text(space.long_name)];
    names.into_iter().filter(|n| !n.is_empty()).collect::<Vec<_>>().join(" ")
}

/// A FeatureCollection of points in `map` metres.
pub(crate) fn geojson(input: &ExportInput<'_>) -> Value {
    let feature = |w: &WaypointRecord| {
        let [x, y, z] = w.position_in_map_m.map(rounded);
        let properties = serde_json::to_value(waypoint(input, w)).unwrap_or_default();
        json!({"type": "Feature", "geometry": {"type": "Point", "coordinates": [x, y, z]}, "properties": properties})
    };
    let features: Vec<Value> = input.plan.waypoints.iter().map(feature).collect();
    json!({"type": "FeatureCollection", "frame": "map", "features": features})
}

/// The waypoints of one storey as Nav2's RViz panel reads them: z = 0, quaternion w first.
pub(crate) fn nav2_yaml(input: &ExportInput<'_>, map_storey: u32) -> String {
    let mut of_storey: Vec<&WaypointRecord> =
        input.plan.waypoints.iter().filter(|w| w.map_storey == map_storey).collect();
    of_storey.sort_by_key(|w| w.order);
    if of_storey.is_empty() {
        return "waypoints: {}\n".to_owned();
    }
    let mut text = "waypoints:\n".to_owned();
    for (order, w) in of_storey.into_iter().enumerate() {
        let [x, y, _] = w.position_in_map_m.map(rounded);
        let (sin, cos) = libm::sincos(w.yaw_rad / 2.0);
        let pose =
            format!("  waypoint{order}:\n    pose: [{x:?}, {y:?}, 0.0]\n    orientation: [{cos:?}, 0.0, 0.0, {sin:?}]");
        // Writing to a string does not fail.
        let _ = writeln!(text, "{pose}");
    }
    text
}
