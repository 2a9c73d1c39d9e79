//! `deviations.json`: evidence for every element by GlobalId, obstacles and map residuals.

use super::input::DeviationExport;
use crate::text::{rounded, text_or_null};
use messages::{
    AbsentPartRecord, DeviationVerdict, ElementDeviationRecord, Observation, ObstacleRecord, ResidualRecord,
    UnseenReason,
};
use schemars::JsonSchema;
use serde::Serialize;
use std::collections::BTreeMap;

/// `deviations.json`: what a robot saw of a storey's elements, judged by what was planned.
#[derive(Debug, Serialize, JsonSchema)]
pub struct DeviationsDocument {
    /// `map`.
    frame: &'static str,
    /// Epoch of the map frame.
    frame_epoch: u32,
    /// Plan time that elements are judged by; null if all are planned to stand.
    plan_time: Option<String>,
    /// Index of the map storey.
    storey: u32,
    /// Name of the map storey; null if it has none.
    storey_name: Option<String>,
    /// Height of the lidar's plane in `map`.
    lidar_z_m: f64,
    /// Where the robot's map lies.
    map_from_slam: Motion,
    /// Standard deviations of that, at the middle of the robot's map.
    pose_deviation: Motion,
    /// Hash of the robot's map.
    slam_map_hash: String,
    /// Side of its cells.
    slam_cell_m: f64,
    /// Root mean square of how far its surfaces are off around each place: how far it is bent.
    residual_rms_m: f64,
    /// Occupied cells of it outside of the storey, which were not compared.
    cells_outside: u32,
    /// Number of elements by observation.
    observations: BTreeMap<&'static str, usize>,
    /// Number of elements by verdict.
    #[serde(rename = "judgements")]
    verdicts: BTreeMap<&'static str, usize>,
    /// The evidence, by GlobalId.
    elements: BTreeMap<String, ElementEvidence>,
    /// What stands on the storey and is no element of the model, from large to small.
    obstacles: Vec<Obstacle>,
    /// How the robot's map is bent, by place.
    residuals: Vec<Residual>,
}

/// Metres and radians.
#[derive(Debug, Serialize, JsonSchema)]
struct Motion {
    /// Along x.
    x_m: f64,
    /// Along y.
    y_m: f64,
    /// About z.
    yaw_rad: f64,
}

#[derive(Debug, Serialize, JsonSchema)]
struct ElementEvidence {
    /// Entity name.
    r#type: String,
    /// Class on the maps.
    class: &'static str,
    /// Name; null if it has none.
    name: Option<String>,
    /// Planned state: `not_started`, `in_progress`, `built`, `being_removed` or `removed`.
    planned: &'static str,
    /// `observed`, `absent`, `displaced` or `unseen`.
    observation: &'static str,
    /// `on_plan`, `late`, `early`, `displaced` or `unknown`.
    #[serde(rename = "judgement")]
    verdict: &'static str,
    /// Why it is unseen: `glass`, `no_section`, `not_seen`, `door`, `covered`, `inconclusive` or `stand_in`; null if it is not.
    reason: Option<&'static str>,
    /// Share of its visible sides that was met in its place; null if none is visible.
    confirmed: Option<f64>,
    /// Length of its sides at the lidar's height that no other element covers.
    sides_m: f64,
    /// Of these: what the robot could judge.
    visible_m: f64,
    /// Of these: where free cells lie inside of it.
    contradicted_m: f64,
    /// How far it stands off, along the outward normal of the side that was seen most; null if it was not met.
    offset_m: Option<f64>,
    /// The same as a vector in `map`.
    displacement_m: Option<[f64; 2]>,
    /// Standard deviation of the two.
    deviation_m: f64,
    /// How far the robot's map is bent there: taken off.
    residual_m: [f64; 2],
    /// Stretches of it that the robot saw through, while the rest stands or was not seen.
    absent_parts: Vec<AbsentPart>,
}

#[derive(Debug, Serialize, JsonSchema)]
struct AbsentPart {
    /// `late` or `on_plan`.
    #[serde(rename = "judgement")]
    verdict: &'static str,
    /// Where it begins along the element's axis: from the end with the smaller x, or the smaller y of one that runs along y.
    from_m: f64,
    /// Where it ends.
    to_m: f64,
    /// The same two places in `map`, on the middle line of the element.
    ends_m: [[f64; 2]; 2],
    /// Standard deviation of each end along the axis.
    deviation_m: f64,
}

#[derive(Debug, Serialize, JsonSchema)]
struct Obstacle {
    /// `not_in_the_model`.
    #[serde(rename = "judgement")]
    verdict: &'static str,
    /// Of what was seen of it.
    area_m2: f64,
    /// Its longer side.
    length_m: f64,
    /// In `map`.
    centroid_m: [f64; 2],
    /// GlobalId of the space that it stands in; null outside of spaces.
    space: Option<String>,
    /// Rings in `map`: exteriors counter-clockwise, holes clockwise.
    polygon_m: Vec<Vec<[f64; 2]>>,
}

#[derive(Debug, Serialize, JsonSchema)]
struct Residual {
    /// In `map`.
    at_m: [f64; 2],
    /// Robot's map less model.
    residual_m: [f64; 2],
    /// Standard deviation in the direction that is held worst.
    deviation_m: f64,
}

impl DeviationsDocument {
    /// From the archives.
    pub fn of(input: &DeviationExport<'_>) -> Self {
        let (site, deviations) = (input.site, input.deviations);
        let head = deviations.head;
        let motion = |m: [f64; 3]| Motion { x_m: m[0], y_m: m[1], yaw_rad: m[2] };
        let observed = |o: Observation| deviations.elements.iter().filter(|e| e.observation == o).count();
        let judged = |j: DeviationVerdict| deviations.elements.iter().filter(|e| e.verdict == j).count();
        Self {
            frame: "map",
            frame_epoch: site.head.frame_epoch,
            plan_time: messages::plan_time(head.plan_time_s).map(|t| t.to_string()),
            storey: head.map_storey,
            storey_name: text_or_null(input.storey()),
            lidar_z_m: rounded(head.lidar_z_m),
            map_from_slam: motion(head.map_from_slam),
            pose_deviation: motion(head.pose_deviation),
            slam_map_hash: head.slam_map_hash.to_string(),
            slam_cell_m: head.slam_cell_m,
            residual_rms_m: rounded(head.residual_rms_m),
            cells_outside: head.n_outside,
            observations: Observation::ALL.into_iter().map(|o| (o.name(), observed(o))).collect(),
            verdicts: DeviationVerdict::ALL.into_iter().map(|j| (j.name(), judged(j))).collect(),
            elements: deviations.elements.iter().map(|e| (input.global_id(e).to_owned(), evidence(input, e))).collect(),
            obstacles: deviations.obstacles.iter().map(|o| obstacle(input, o)).collect(),
            residuals: deviations.residuals.iter().map(residual).collect(),
        }
    }
}

fn evidence(input: &DeviationExport<'_>, e: &ElementDeviationRecord) -> ElementEvidence {
    let element = &input.site.elements[e.element as usize];
    let length = |n: u32| rounded(f64::from(n) * e.sample_m);
    let is_met = e.n_confirmed > 0 || e.observation == Observation::Displaced;
    ElementEvidence {
        r#type: input.site.text(element.ifc_type).to_owned(),
        class: element.class().name(),
        name: text_or_null(input.site.text(element.name)),
        planned: e.planned.get().name(),
        observation: e.observation.get().name(),
        verdict: e.verdict.get().name(),
        reason: Some(e.reason.get()).filter(|r| *r != UnseenReason::Seen).map(UnseenReason::name),
        confirmed: (e.n_visible > 0).then(|| rounded(f64::from(e.n_confirmed) / f64::from(e.n_visible))),
        sides_m: length(e.n_samples),
        visible_m: length(e.n_visible),
        contradicted_m: length(e.n_contradicted),
        offset_m: is_met.then(|| rounded(e.offset_m)),
        displacement_m: is_met.then(|| e.displacement_m.map(rounded)),
        deviation_m: rounded(e.deviation_m),
        residual_m: e.residual_m.map(rounded),
        absent_parts: input.deviations.absent_parts_of(e).map(absent_part).collect(),
    }
}

fn absent_part(part: &AbsentPartRecord) -> AbsentPart {
    AbsentPart {
        verdict: part.verdict.get().name(),
        from_m: rounded(part.from_m),
        to_m: rounded(part.to_m),
        ends_m: part.ends_m.map(|end| end.map(rounded)),
        deviation_m: rounded(part.deviation_m),
    }
}

fn obstacle(input: &DeviationExport<'_>, o: &ObstacleRecord) -> Obstacle {
    let ring = |ring: &[[i32; 2]]| ring.iter().map(|p| p.map(frames::metres)).collect();
    let space = input.site.spaces.get(o.space as usize);
    Obstacle {
        verdict: "not_in_the_model",
        area_m2: rounded(o.area_m2),
        length_m: rounded(o.length_m),
        centroid_m: o.centroid_m.map(rounded),
        space: space.map(|s| input.site.text(s.global_id).to_owned()),
        polygon_m: input.deviations.rings_of(o).map(ring).collect(),
    }
}

fn residual(r: &ResidualRecord) -> Residual {
    Residual { at_m: r.at_m.map(rounded), residual_m: r.residual_m.map(rounded), deviation_m: rounded(r.deviation_m) }
}
