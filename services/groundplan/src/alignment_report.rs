//! An alignment as JSON and as text, from its archive: the same for files and for the running daemon.

use crate::date_argument::optional_text;
use alignment::{HOLDS_M, Scale};
use daemon::facts::Pose;
use diagnostics::counted;
use export::rounded;
use messages::{
    Alignment, AlignmentVerdict, ContentHash, DecidingPlaceRecord, HintRecord, LocalPoses, LocalPosesHead, NONE,
    PlacedRecord, PoseEvidence, PosePairRecord, PoseRecord, PoseValidity, SampleHeader,
};
use serde_json::{Value, json};
use std::fmt::Write;

/// People read the poses that come so near to the best in log odds; programs get all.
const NEAR_BEST: f64 = 7.0;

/// What `--json` prints; `inputs` says what the maps were.
pub(crate) fn document(alignment: &Alignment<'_>, robot_m: Option<[f64; 2]>, mut inputs: Value) -> Value {
    inputs["plan_time"] = json!(optional_text(alignment.head.plan_time_s));
    let head = alignment.head;
    let (counting, validity) = pose_for(alignment, robot_m);
    let counting = counting.as_ref();
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
        "validity": validity.name(),
        "usable": alignment.usable(robot_m).is_ok(),
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
        "holds": alignment.local_poses.map(|local_poses| holds(&local_poses, robot_m.or(local_poses.robot_m()))),
        "score": counting.or(alignment.candidates.first()).map(|p| p.evidence.score),
        "scale": head.scale,
        "scale_deviation": head.scale_deviation,
        "off_by_scale_m": off_by_scale_m(alignment, counting).map(rounded),
        "waiting": waiting,
        "candidates": candidates,
        "change": alignment.change(),
        "decide": decision(alignment),
        "hints": alignment.hints.iter().map(hint).collect::<Vec<_>>(),
        "inputs": inputs,
    })
}

/// For which part of the SLAM map the pose holds.
fn holds(local_poses: &LocalPoses<'_>, robot_m: Option<[f64; 2]>) -> Value {
    let head = local_poses.head;
    let ring = |corners: &[[f64; 2]]| -> Vec<[f64; 2]> { corners.iter().map(|corner| corner.map(rounded)).collect() };
    let mut outline: Vec<Vec<Vec<[f64; 2]>>> = Vec::new();
    for (is_hole, corners) in local_poses.outline_m() {
        match outline.last_mut().filter(|_| is_hole) {
            Some(piece) => piece.push(ring(corners)),
            None => outline.push(vec![ring(corners)]),
        }
    }
    json!({
        "within_m": HOLDS_M,
        "outline_in_slam_m": outline,
        "share_of_walls": rounded(head.walls_share),
        "share_of_floor": rounded(head.area_share),
        "largest_known_off_m": rounded(head.largest_off_m),
        "unknown_share_of_floor": rounded(head.unknown_share),
        "anywhere_m": rounded(head.anywhere_m),
        "anywhere_rad": head.anywhere_rad,
        "robot": robot_m.map(|[x, y]| json!({"x_m": x, "y_m": y})),
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
    let hash = |hash: ContentHash| hash.to_string();
    json!({"site_hash": hash(inputs.site), "phase_hash": hash(inputs.schedule_state), "slam_map_hash": hash(inputs.slam_map)})
}

/// The current pose and what it is worth: around the robot, if its place in its map is told.
fn pose_for(alignment: &Alignment<'_>, robot_m: Option<[f64; 2]>) -> (Option<PoseRecord>, PoseValidity) {
    match alignment.pose_around(robot_m) {
        Some((pose, validity)) => (Some(pose), validity),
        None => (None, alignment.validity()),
    }
}

/// What people read.
pub(crate) fn text(alignment: &Alignment<'_>, robot_m: Option<[f64; 2]>) -> String {
    let (pose, validity) = pose_for(alignment, robot_m);
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
    if let Some(pose) = &pose {
        line(&mut out, pose, alignment.state().name());
        let _ = match alignment.local_poses {
            Some(local_poses) => writeln!(out, "  {}", known_to(pose, &local_poses, robot_m)),
            None => writeln!(out, "  known to {} in the middle of the SLAM map", pose.deviation_text()),
        };
        let (scale, deviation) = (alignment.head.scale, alignment.head.scale_deviation);
        if (Scale { value: scale, deviation }).is_off() {
            let off = match off_by_scale_m(alignment, Some(pose)) {
                Some(ends_m) => format!("{ends_m:.2} m off at the ends of the map"),
                None => format!("{:.2} m off in 10 m", 10.0 * (scale - 1.0).abs()),
            };
            let _ = writeln!(
                out,
                "  lengths of the SLAM map are {scale:.4} of the model's (+-{deviation:.4}): {off}; --free-scale corrects them"
            );
        }
    }
    if let Some(pose) = alignment.waiting() {
        line(&mut out, pose, "waits for groundplan confirm");
    }
    if validity == PoseValidity::Held {
        let _ = writeln!(out, "held: {}", alignment.searched().why_held());
    }
    if validity == PoseValidity::Uncertain {
        let _ = writeln!(out, "uncertain: {}", alignment.why_uncertain(robot_m));
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

/// How far lengths that are not the model's put the ends of a SLAM map off that lies right in its middle, in metres; `None` if they are the
/// model's, or where the map is not known from place to place.
fn off_by_scale_m(alignment: &Alignment<'_>, pose: Option<&PoseRecord>) -> Option<f64> {
    let (value, deviation) = (alignment.head.scale, alignment.head.scale_deviation);
    let (pose, local_poses) = pose.zip(alignment.local_poses)?;
    let from_middle_m = |[x, y]: [f64; 2]| libm::hypot(x - pose.about_m[0], y - pose.about_m[1]);
    let ends_m = local_poses.parts.iter().map(|part| from_middle_m(part.about_m)).fold(0.0, f64::max);
    (Scale { value, deviation }).is_off().then_some((value - 1.0).abs() * ends_m)
}

/// How well a pose is known, and for which part of the SLAM map it holds.
fn known_to(pose: &PoseRecord, local_poses: &LocalPoses<'_>, robot_m: Option<[f64; 2]>) -> String {
    let LocalPosesHead { anywhere_m, anywhere_rad, walls_share, area_share, largest_off_m, unknown_share, .. } =
        local_poses.head;
    let place = match robot_m.or(local_poses.robot_m()) {
        Some([x_m, y_m]) => {
            format!("known to {} around the robot at x {x_m:.2} m, y {y_m:.2} m", pose.deviation_text())
        }
        None => {
            format!("known to {anywhere_m:.3} m and {:.2} degrees anywhere in the SLAM map", anywhere_rad.to_degrees())
        }
    };
    let [walls, area, unknown] = [walls_share, area_share, unknown_share].map(|share| 100.0 * share);
    let off = if *largest_off_m > HOLDS_M {
        format!("off by up to {largest_off_m:.2} m")
    } else {
        "nowhere known to be off".to_owned()
    };
    format!(
        "{place}\n  holds within {HOLDS_M} m for {walls:.0} % of its walls and {area:.0} % of its floor; beyond that {off}, and not \
         known for {unknown:.0} % of the floor"
    )
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
