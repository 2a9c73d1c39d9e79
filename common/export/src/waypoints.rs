//! Waypoints as JSON, GeoJSON and the YAML of Nav2's panel.

use crate::coverage_curve::{CurvePoint, coverage_curve};
use crate::input::ExportInput;
use crate::scan_summary::ScanSummary;
use crate::text::{rounded, share, text_or_null};
use frames::Attitude;
use messages::{
    DriveModel, JOULES_PER_WH, MissionPlan, MissionPlanStoreyRecord, NoWaypoint, ScanSensor, Site, WaypointRecord,
};
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
    /// What scans are made with.
    sensor: Sensor,
    /// Classes of the elements that the scans are to see.
    classes: Vec<&'static str>,
    /// Share of the faces that can be seen that the scans were to see; 0 if only centres are planned.
    coverage_goal: f64,
    /// Length of faces for which a scan is worth its time.
    min_gain_m: f64,
    /// Share of each scan's faces that scans registered before it were to have seen.
    overlap_goal: f64,
    /// Smallest distance between two scans.
    separation_m: f64,
    /// Budget: largest number of scans; null without.
    scans_max: Option<u32>,
    /// Budget: longest duration of all tours; null without.
    mission_max_s: Option<f64>,
    /// Scans, those that join others included.
    scans: u32,
    /// Scans that are there to join others.
    connecting_scans: u32,
    /// Share of the faces that can be seen that the scans see; null if there are none, or no scans are planned.
    coverage: Option<f64>,
    /// Scans against the share of the faces that they see, over all storeys.
    curve: Vec<CurvePoint>,
    /// Estimated time of driving all tours.
    driving_s: f64,
    /// Time of all scans.
    scanning_s: f64,
    /// Estimated duration of all tours: driving and scanning.
    mission_s: f64,
    /// Estimated energy of that in watt-hours, if the options tell the mass of the robot.
    #[serde(skip_serializing_if = "Option::is_none")]
    mission_wh: Option<f64>,
    /// How the robot drives, if the options tell what climbing takes, or by what ways are chosen.
    #[serde(skip_serializing_if = "Option::is_none")]
    drive: Option<Drive>,
    /// What became of each map storey that is written.
    storeys: Vec<StoreyOutcome>,
    /// Notices.
    notices: Vec<Notice>,
    /// The waypoints.
    waypoints: Vec<Waypoint>,
    /// What became of each space, by GlobalId.
    spaces: BTreeMap<String, SpaceOutcome>,
}

/// How the robot drives, as the options have it.
#[derive(Debug, Serialize, JsonSchema)]
struct Drive {
    /// By what ways are chosen: `length`, `time` or `energy`. The order of a tour goes by length.
    cost: &'static str,
    /// Speed.
    speed_m_s: f64,
    /// Seconds that each metre of climb adds.
    climb_s_per_m: f64,
    /// Mass with all load; null if it is unknown.
    mass_kg: Option<f64>,
    /// Coefficient of rolling resistance.
    rolling_resistance: f64,
    /// Share of the energy of the battery that arrives at the wheels.
    drive_efficiency: f64,
    /// Power of all that runs while the robot drives or stands.
    idle_w: f64,
}

impl Drive {
    fn of(model: &DriveModel) -> Self {
        let DriveModel {
            speed_m_s, climb_s_per_m, mass_kg, rolling_resistance, drive_efficiency, idle_w, cost, ..
        } = *model;
        let mass_kg = model.has_energy().then_some(mass_kg);
        let cost = cost.get().name();
        Self { cost, speed_m_s, climb_s_per_m, mass_kg, rolling_resistance, drive_efficiency, idle_w }
    }
}

/// Lengths in metres, angles in radians.
#[derive(Debug, Serialize, JsonSchema)]
struct Sensor {
    /// Farthest that it measures.
    range_m: f64,
    /// Nearest that it measures.
    min_range_m: f64,
    /// Largest angle between a ray and the normal of the face that it meets.
    max_incidence_rad: f64,
    /// Horizontal field of view around the heading.
    field_of_view_rad: f64,
}

#[derive(Debug, Serialize, JsonSchema)]
struct StoreyOutcome {
    /// Index of the map storey.
    storey: u32,
    /// Share of the faces that can be seen that the scans see; null if there are none, or no scans are planned.
    coverage: Option<f64>,
    /// Sides of occupied cells that can be seen from some place.
    faces: u32,
    /// Those of them that the scans see.
    faces_seen: u32,
    /// Scans.
    scans: u32,
    /// Scans that are there to join others.
    connecting_scans: u32,
    /// Scans against the share of the faces of the storey that they see.
    curve: Vec<CurvePoint>,
    /// Length of the tour through all waypoints.
    tour_m: f64,
    /// No tour through them is shorter.
    tour_bound_m: f64,
    /// Floor that the middle of the robot can get to.
    reached_m2: f64,
    /// Floor that it could stand on and cannot get to.
    unreached_m2: f64,
    /// Separate parts of the storey that the waypoints lie in.
    parts: u32,
    /// How the robot comes to the storey: `start`, `portal` from another storey, `outer_door`, or `placed` where it has to be put
    /// there; null if it does not.
    entry: Option<&'static str>,
    /// Points on the meshes of elements at all heights that the check looked at; null without it.
    mesh_points: Option<u32>,
    /// Those of them that the scans see.
    mesh_points_seen: Option<u32>,
}

#[derive(Debug, Serialize, JsonSchema)]
struct Notice {
    /// Stable code for programs.
    code: &'static str,
    /// One sentence for people.
    message: String,
    /// GlobalId of the element that it is about.
    element: Option<String>,
    /// Name of the element.
    name: Option<String>,
}

#[derive(Debug, Serialize, JsonSchema)]
struct Waypoint {
    /// Number in the mission plan.
    id: u32,
    /// Place in the tour over all storeys, from 0.
    order: u32,
    /// `centre` or `scan`.
    kind: &'static str,
    /// Index of the map storey.
    storey: u32,
    /// GlobalId of the space; null outside of spaces.
    space: Option<String>,
    /// Name and long name of the space; null outside of spaces, or if it has none.
    name: Option<String>,
    /// In `map`.
    x_m: f64,
    /// In `map`.
    y_m: f64,
    /// Height of the floor in `map`.
    z_m: f64,
    /// Height of the sensor in `map`.
    sensor_z_m: f64,
    /// Place of the sensor in `map`, where the ground is not level: above the waypoint along `up`. Without it, straight above.
    #[serde(skip_serializing_if = "Option::is_none")]
    sensor_m: Option<[f64; 3]>,
    /// Normal of the ground on which the robot stands, a unit vector in `map`, where the ground is not level. Without it, straight up.
    #[serde(skip_serializing_if = "Option::is_none")]
    up: Option<[f64; 3]>,
    /// Heading in `map`: the angle in plan of where the robot looks, whatever the slope. The robot is turned by it, then pitched and
    /// rolled until its vertical axis is `up`.
    yaw_rad: f64,
    /// Area centroid of the space's floor, not moved; the waypoint itself outside of spaces.
    centroid_m: [f64; 3],
    /// Distance to the middle of the nearest cell that is not free.
    clearance_m: f64,
    /// Floor that a scan from here sees and none before it; 0 for centres.
    covers_m2: f64,
    /// Sides of occupied cells that a scan from here sees.
    faces: u32,
    /// Share of them that scans before it have seen.
    overlap: f64,
    /// True for a scan that is there to join others.
    connects: bool,
    /// For such a scan the id of one that does not register without it.
    joins: Option<u32>,
    /// Share of that scan's faces that scans registered without this one saw.
    joins_overlap_without: Option<f64>,
    /// Place in the order in which the scans of the storey register with each other, from 0; null for centres.
    registration_order: Option<u32>,
    /// Share of its faces that scans registered before it saw; null for centres.
    registration_overlap: Option<f64>,
    /// Way over the floor from the waypoint before it on this storey.
    leg_m: f64,
}

#[derive(Debug, Serialize, JsonSchema)]
struct SpaceOutcome {
    /// Index of the map storey; null if it is on none.
    storey: Option<u32>,
    /// Share of the faces in it that can be seen that the scans see; null if there are none, or no scans are planned.
    coverage: Option<f64>,
    /// Why it has no waypoint; null if it has one.
    reason: Option<String>,
    /// The same as a code for programs: `blocked`, `closed_door`, `too_narrow` ..
    why: Option<&'static str>,
    /// GlobalId of the closed door that is nearest to it on the way there.
    door: Option<String>,
    /// Whether the robot gets there: `reached`, `no_way` where it is open by the schedule, or `closed` by the schedule; null
    /// for gross areas and spaces without a body or a map.
    access: Option<&'static str>,
    /// Why no way leads there: of all ways the obstacles of that with the fewest, the nearest to it first; null unless that is
    /// so.
    access_reason: Option<String>,
}

impl Waypoints {
    /// Of the inputs of an export.
    pub fn of(input: &ExportInput<'_>) -> Self {
        let (site, mission_plan) = (input.site, input.mission_plan);
        let id = |index: usize| site.text(site.spaces[index].global_id).to_owned();
        let ScanSensor { range_m, min_range_m, max_incidence_rad, field_of_view_rad, .. } = mission_plan.head.sensor;
        let optional = |text| text_or_null(mission_plan.text(text));
        let notice = |d: &messages::DiagnosticRecord| Notice {
            code: d.code.get().name(),
            message: mission_plan.text(d.message).to_owned(),
            element: optional(d.global_id),
            name: optional(d.name),
        };
        let head = mission_plan.head;
        let summary = ScanSummary::of(mission_plan);
        let written = mission_plan.storeys.iter().filter(|s| input.writes(s.map_storey));
        let has_class = |class: &grid::Class| *class != grid::Class::None && head.classes & (1 << class.id()) != 0;
        Self {
            frame: "map",
            frame_epoch: site.head.frame_epoch,
            plan_time: input.schedule_state.head.plan_time().map(|t| t.to_string()),
            sensor: Sensor { range_m, min_range_m, max_incidence_rad, field_of_view_rad },
            classes: grid::Class::ALL.iter().filter(|class| has_class(class)).map(|class| class.name()).collect(),
            coverage_goal: head.coverage_goal,
            min_gain_m: head.min_gain_m,
            overlap_goal: head.overlap_goal,
            separation_m: head.separation_m,
            scans_max: (head.scans_max != messages::NONE).then_some(head.scans_max),
            mission_max_s: Some(60.0 * head.minutes_max).filter(|s| s.is_finite()),
            scans: summary.as_ref().map_or(0, |summary| summary.scans),
            connecting_scans: summary.as_ref().map_or(0, |summary| summary.connecting_scans),
            coverage: summary.map(|summary| summary.coverage),
            curve: coverage_curve(mission_plan, None),
            driving_s: rounded(head.mission_s[0]),
            scanning_s: rounded(head.mission_s[1]),
            mission_s: rounded(head.mission_s.iter().sum()),
            mission_wh: head.drive.has_energy().then(|| rounded(head.mission_j / JOULES_PER_WH)),
            drive: head.drive.is_asked_for().then(|| Drive::of(&head.drive)),
            storeys: written.map(|record| storey(mission_plan, record)).collect(),
            notices: mission_plan.diagnostics.iter().map(notice).collect(),
            waypoints: mission_plan.waypoints.iter().map(|w| waypoint(input, w)).collect(),
            spaces: (0..site.spaces.len()).map(|index| (id(index), space(input, index))).collect(),
        }
    }
}

fn storey(mission_plan: &MissionPlan<'_>, record: &MissionPlanStoreyRecord) -> StoreyOutcome {
    let is_checked = record.n_mesh_points > 0;
    StoreyOutcome {
        storey: record.map_storey,
        coverage: share(record.n_seen, record.n_faces),
        faces: record.n_faces,
        faces_seen: record.n_seen,
        scans: record.n_scans,
        connecting_scans: record.n_connecting,
        curve: coverage_curve(mission_plan, Some(record.map_storey)),
        tour_m: rounded(record.tour_m),
        tour_bound_m: rounded(record.tour_bound_m),
        reached_m2: rounded(record.reached_m2),
        unreached_m2: rounded(record.unreached_m2),
        parts: record.n_parts,
        entry: record.entry.get().name(),
        mesh_points: is_checked.then_some(record.n_mesh_points),
        mesh_points_seen: is_checked.then_some(record.n_mesh_seen),
    }
}

fn space(input: &ExportInput<'_>, index: usize) -> SpaceOutcome {
    let map_storey = input.site.spaces[index].map_storey;
    let record = &input.mission_plan.spaces[index];
    let why = Some(record.why.get()).filter(|why| *why != NoWaypoint::Has);
    let door = input.site.doors.get(record.door as usize);
    SpaceOutcome {
        storey: (map_storey != messages::NONE).then_some(map_storey),
        coverage: share(record.n_seen, record.n_faces),
        reason: text_or_null(input.mission_plan.reason(index)),
        why: why.map(NoWaypoint::name),
        door: door.map(|d| input.site.text(input.site.elements[d.element as usize].global_id).to_owned()),
        access: record.access.get().name(),
        access_reason: text_or_null(input.mission_plan.access_reason(index)),
    }
}

fn waypoint(input: &ExportInput<'_>, w: &WaypointRecord) -> Waypoint {
    let [x_m, y_m, z_m] = w.position_in_map_m.map(rounded);
    let purpose = w.purpose();
    let scan = purpose.scan();
    let joins = scan.and_then(|scan| scan.joins);
    Waypoint {
        id: w.id,
        order: w.order,
        kind: purpose.kind().name(),
        storey: w.map_storey,
        space: space_id(input, w.space),
        name: space_name(input.site, w.space),
        x_m,
        y_m,
        z_m,
        sensor_z_m: rounded(w.sensor_in_map_m[2]),
        sensor_m: w.attitude().is_tilted().then(|| w.sensor_in_map_m.map(rounded)),
        up: w.attitude().is_tilted().then_some(w.up_in_map),
        yaw_rad: w.yaw_rad,
        centroid_m: w.centroid_in_map_m.map(rounded),
        clearance_m: rounded(w.clearance_m),
        covers_m2: rounded(w.covers_m2),
        faces: w.n_faces,
        overlap: rounded(w.overlap),
        connects: joins.is_some(),
        joins: joins.map(|joined| joined.waypoint),
        joins_overlap_without: joins.map(|joined| rounded(joined.overlap_without)),
        registration_order: scan.map(|scan| scan.registration_order),
        registration_overlap: scan.map(|scan| rounded(scan.registration_overlap)),
        leg_m: rounded(w.leg_m),
    }
}

/// GlobalId of a space; `None` for none.
pub(crate) fn space_id(input: &ExportInput<'_>, space: u32) -> Option<String> {
    input.site.spaces.get(space as usize).map(|s| input.site.text(s.global_id).to_owned())
}

/// Name and long name of a space; `None` for none, or if it has neither.
pub fn space_name(site: &Site<'_>, space: u32) -> Option<String> {
    let space = site.spaces.get(space as usize)?;
    let names = [site.text(space.name), site.text(space.long_name)];
    text_or_null(&names.into_iter().filter(|n| !n.is_empty()).collect::<Vec<_>>().join(" "))
}

/// A FeatureCollection of points in `map` metres.
pub(crate) fn geojson(input: &ExportInput<'_>) -> Value {
    let feature = |w: &WaypointRecord| {
        let [x, y, z] = w.position_in_map_m.map(rounded);
        let properties = serde_json::to_value(waypoint(input, w)).unwrap_or_default();
        json!({"type": "Feature", "geometry": {"type": "Point", "coordinates": [x, y, z]}, "properties": properties})
    };
    let features: Vec<Value> = input.mission_plan.waypoints.iter().map(feature).collect();
    json!({"type": "FeatureCollection", "frame": "map", "features": features})
}

/// The waypoints of one storey as Nav2's RViz panel reads them: z = 0, quaternion w first, tilted as the ground is.
pub(crate) fn nav2_yaml(input: &ExportInput<'_>, map_storey: u32) -> String {
    let mut of_storey: Vec<&WaypointRecord> =
        input.mission_plan.waypoints.iter().filter(|w| w.map_storey == map_storey).collect();
    of_storey.sort_by_key(|w| w.order);
    nav2_poses(of_storey.into_iter().map(|w| {
        let [x, y, _] = w.position_in_map_m.map(rounded);
        ([x, y], w.attitude())
    }))
}

/// Poses over the plane, in their order, as Nav2 reads waypoints.
pub fn nav2_poses(poses: impl Iterator<Item = ([f64; 2], Attitude)>) -> String {
    let mut text = String::new();
    for (order, ([x, y], attitude)) in poses.enumerate() {
        let [qx, qy, qz, qw] = attitude.quaternion();
        let pose = format!(
            "  waypoint{order}:\n    pose: [{x:?}, {y:?}, 0.0]\n    orientation: [{qw:?}, {qx:?}, {qy:?}, {qz:?}]"
        );
        // Writing to a string does not fail.
        let _ = writeln!(text, "{pose}");
    }
    if text.is_empty() { "waypoints: {}\n".to_owned() } else { format!("waypoints:\n{text}") }
}
