//! An alignment as JSON and as text, from its archive: the same for files and for the running daemon.

use crate::date_argument::optional_text;
use daemon::facts::Pose;
use export::rounded;
use frames::counted;
use messages::{
    Alignment, AlignmentVerdict, DecidingPlaceRecord, HintRecord, NONE, PlacedRecord, PoseEvidence, PosePairRecord,
    PoseRecord, PoseValidity, SampleHeader,
};
use serde_json::{Value, json};
use std::fmt::Write;

/// A scale is worth telling if it differs from 1 by more than this, and by more than three standard deviations.
const MIN_SCALE_DEVIATION: f64 = 0.005;

/// People read the poses that come so near to the best in log odds; programs get all.
const NEAR_BEST: f64 = 7.0;

/// What `--json` prints; `inputs` says what the maps were.
pub(crate) fn document(alignment: &Alignment<'_>, mut inputs: Value) -> Value {
    inputs["plan_time"] = json!(optional_text(alignment.head.plan_time_s));
    let (counting, head) = (alignment.pose(), alignment.head);
    let hint = |hint: &HintRecord| json!({"hint": alignment.text(hint.label), "excluded": hint.n_excluded});
    let candidates: Vec<Value> = alignment
        .candidates
        .iter()
        .map(|c| {
            let storey = storey(c);
            json!({
                "storey": storey, "map_from_slam": motion(c), "score": c.evidence.score, "evidence": evidence(&c.evidence),
            })
        })
        .collect();
    let waiting = alignment.waiting().map(|w| json!({"storey": storey(w), "map_from_slam": motion(w)}));
    json!({
        "validity": alignment.validity().name(),
        "usable": alignment.validity() == PoseValidity::Effective && alignment.verdict() == AlignmentVerdict::Accepted,
        "verdict": alignment.verdict().name(),
        "wrong_probability": head.wrong_probability,
        "of_newest_map": alignment.is_searched(),
        "reason": alignment.reason(),
        "state": alignment.state().name(),
        "storey": counting.and_then(storey),
        "map_from_slam": counting.map(motion),
        "slam_from_map": counting.map(inverse),
        "covariance": counting.map(|p| p.covariance),
        "about": counting.map(|p| p.about_m),
        "score": counting.or(alignment.candidates.first()).map(|p| p.evidence.score),
        "scale": head.scale,
        "scale_deviation": head.scale_deviation,
        "waiting": waiting,
        "candidates": candidates,
        "change": alignment.change(),
        "decide": decision(alignment),
        "hints": alignment.hints.iter().map(hint).collect::<Vec<_>>(),
        "inputs": inputs,
    })
}

/// What would decide between the candidates of an ambiguous alignment; null where nothing has to be decided.
fn decision(alignment: &Alignment<'_>) -> Value {
    let Some(text) = alignment.decision() else { return Value::Null };
    let at = |[x, y]: [f64; 2]| json!({"x_m": rounded(x), "y_m": rounded(y)});
    let pairs = |pairs: &[PosePairRecord]| -> Vec<[u32; 2]> { pairs.iter().map(|pair| pair.candidates).collect() };
    let candidate = |(candidate, placed): (&PoseRecord, &PlacedRecord)| {
        let [global_id, name, long_name] =
            [placed.room_global_id, placed.room_name, placed.room_long_name].map(|text| alignment.text(text));
        let room = json!({"global_id": global_id, "name": name, "long_name": long_name});
        let room = if global_id.is_empty() { Value::Null } else { room };
        json!({"storey": storey(candidate), "place": at(placed.in_map_m), "room": room})
    };
    let place = |place: &DecidingPlaceRecord| {
        let by_pose = alignment.candidates.iter().zip(alignment.placed(place));
        json!({
            "in_slam": at(place.in_slam_m),
            "way_m": rounded(place.way_m),
            "differing_m": rounded(place.differing_m),
            "decided": pairs(alignment.decided(place)),
            "candidates": by_pose.map(candidate).collect::<Vec<_>>(),
        })
    };
    json!({
        "text": text,
        "places": alignment.deciding_places.iter().map(place).collect::<Vec<_>>(),
        "undecided": pairs(alignment.undecided()),
    })
}

/// What a sample was made from, as `document` takes it.
pub(crate) fn inputs_of(header: &SampleHeader) -> Value {
    let inputs = header.inputs;
    let hash = |hash: u64| format!("{hash:016x}");
    json!({"site_hash": hash(inputs.site), "phase_hash": hash(inputs.schedule_state), "slam_map_hash": hash(inputs.slam_map)})
}

/// What people read.
pub(crate) fn text(alignment: &Alignment<'_>) -> String {
    let mut out = alignment.verdict().name().to_owned();
    if !alignment.reason().is_empty() {
        let _ = write!(out, ": {}", alignment.reason());
    }
    out.push('\n');
    if alignment.verdict() == AlignmentVerdict::Ambiguous {
        let best = alignment.candidates.first().map_or(0.0, |pose| pose.evidence.log_odds);
        let near = alignment.candidates.iter().filter(|pose| pose.evidence.log_odds > best - NEAR_BEST);
        near.for_each(|pose| line(&mut out, pose, ""));
    }
    if let Some(pose) = alignment.pose() {
        line(&mut out, pose, alignment.state().name());
        let _ = writeln!(out, "  known to {}", uncertainty(pose));
        let (scale, deviation) = (alignment.head.scale, alignment.head.scale_deviation);
        if (scale - 1.0).abs() > MIN_SCALE_DEVIATION.max(3.0 * deviation) {
            let _ = writeln!(out, "  lengths of the SLAM map are {scale:.4} of the model's (+-{deviation:.4})");
        }
    }
    if let Some(pose) = alignment.waiting() {
        line(&mut out, pose, "waits for groundplan confirm");
    }
    if alignment.validity() == PoseValidity::Held {
        let _ = writeln!(out, "held: {}", why_held(alignment));
    }
    if alignment.validity() == PoseValidity::Uncertain {
        let _ = writeln!(out, "uncertain: {}", why_uncertain(alignment));
    }
    if let Some(change) = alignment.change() {
        let _ = writeln!(out, "changed: {change}");
    }
    for hint in alignment.hints {
        let excluded = counted(hint.n_excluded as usize, "pose");
        let _ = writeln!(out, "  {} excludes {excluded}", alignment.text(hint.label));
    }
    out
}

/// Why the pose must not be used; `None` if it is effective.
pub(crate) fn why_not_effective(alignment: &Alignment<'_>) -> Option<String> {
    match alignment.validity() {
        PoseValidity::Effective => None,
        PoseValidity::WaitsForConfirm => Some("another pose waits for `groundplan confirm`".to_owned()),
        PoseValidity::Uncertain => Some(format!("the pose is uncertain: {}", why_uncertain(alignment))),
        PoseValidity::Held => Some(format!("the pose is held: {}", why_held(alignment))),
        PoseValidity::Refused => Some(why_not_accepted(alignment)),
    }
}

/// Why no pose of the map that was searched last is accepted.
pub(crate) fn why_not_accepted(alignment: &Alignment<'_>) -> String {
    format!("the SLAM map is {}: {}", alignment.verdict().name(), alignment.reason())
}

fn why_uncertain(alignment: &Alignment<'_>) -> String {
    let held = alignment.pose().map_or_else(String::new, |pose| format!(" to {} only", uncertainty(pose)));
    format!("the walls that the SLAM map shows hold it{held}, less well than max_uncertainty asks for")
}

/// Standard deviations of a pose, of the middle of the SLAM map in the direction that is held worst.
fn uncertainty(pose: &PoseRecord) -> String {
    let covariance = pose.pose_covariance();
    let [_, _, yaw_rad] = covariance.deviations();
    format!("{:.3} m and {:.2} degrees", covariance.worst_m(), yaw_rad.to_degrees())
}

fn why_held(alignment: &Alignment<'_>) -> &'static str {
    match alignment.is_searched() {
        true => "the newest SLAM map does not bear the pose out",
        false => "the newest SLAM map waits for its search",
    }
}

fn line(out: &mut String, pose: &PoseRecord, what: &str) {
    let [x_m, y_m, yaw_rad] = pose.map_from_slam;
    let (degrees, score) = (yaw_rad.to_degrees(), pose.evidence.score);
    if let Some(storey) = storey(pose) {
        let _ = write!(out, "  storey {storey}");
    }
    let _ = write!(out, "  map_from_slam x {x_m:.3} m, y {y_m:.3} m, yaw {degrees:.3} degrees, score {score:.3}");
    let _ = if what.is_empty() { writeln!(out) } else { writeln!(out, ", {what}") };
}

fn storey(pose: &PoseRecord) -> Option<u32> {
    (pose.map_storey != NONE).then_some(pose.map_storey)
}

fn motion(pose: &PoseRecord) -> Value {
    json!(Pose::of(pose.map_from_slam))
}

fn inverse(pose: &PoseRecord) -> Value {
    json!(Pose::of(pose.map_from_slam().inverse().x_y_yaw()))
}

/// The evidence for a pose.
pub(crate) fn evidence(evidence: &PoseEvidence) -> Value {
    let PoseEvidence { log_odds, precision, recall, free, seen_m, seen_through, in_walls, .. } = evidence;
    let PoseEvidence { outside, free_in_walls, distinct_m, .. } = evidence;
    json!({
        "log_odds": log_odds, "precision": precision, "recall": recall, "free": free, "seen_m": seen_m,
        "seen_through": seen_through, "in_walls": in_walls, "outside": outside, "free_in_walls": free_in_walls,
        "distinct_m": distinct_m,
    })
}
