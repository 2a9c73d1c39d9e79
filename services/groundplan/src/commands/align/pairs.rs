//! `groundplan align --pairs`: alignment of many map pairs, for benchmarks.

use crate::alignment_report::evidence;
use crate::failure::Failure;
use crate::input_document::MAX_DOCUMENT_BYTES;
use alignment::{
    AlignedPose, Alignment, Contrast, LocalPose, Looks, PoseExtent, PreparedMap, align_maps_within, references_hash,
};
use input_files::read_regular_text;
use messages::{AlignmentEvidence, ArchiveBuffer, ContentHash, NONE};
use occupancy::OccupancyMap;
use rustix::time::{ClockId, clock_gettime};
use serde::Deserialize;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// A line of `pairs.jsonl`; paths count from its folder.
#[derive(Deserialize)]
struct Pair {
    pair: String,
    reference: PathBuf,
    slam: PathBuf,
    /// The drive of a growing map: its pairs are looks, in their order, and each begins with the evidence of those before.
    drive: Option<String>,
    /// Places of the robot in its map, in metres: the answer has the pose around each.
    #[serde(default)]
    robots: Vec<[f64; 2]>,
}

/// Aligns all pairs of a folder, a JSON document a line.
///
/// # Errors
/// A list or a map that cannot be used.
pub(super) fn pairs(folder: &Path) -> Result<String, Failure> {
    let list = folder.join("pairs.jsonl");
    let text = read_regular_text(&list, MAX_DOCUMENT_BYTES)
        .map_err(|error| Failure::usage(format!("{} cannot be read: {error}", list.display())))?;
    let mut out = String::new();
    let mut drives: BTreeMap<String, ArchiveBuffer> = BTreeMap::new();
    for line in text.lines().filter(|line| !line.trim().is_empty()) {
        let pair: Pair =
            serde_json::from_str(line).map_err(|error| Failure::usage(format!("{}: {error}", list.display())))?;
        let read = |path: &Path| OccupancyMap::read(&folder.join(path)).map_err(Failure::usage);
        let (reference, slam) = (read(&pair.reference)?, read(&pair.slam)?);
        let begun_s = cpu_s();
        let slam = PreparedMap::of_slam(&slam);
        let references = [PreparedMap::of_model(&reference)];
        let hash = references_hash(&references, &[NONE]);
        let before = pair.drive.as_ref().and_then(|drive| drives.get(drive));
        let before =
            before.map(|archive| AlignmentEvidence::open(archive.bytes())).transpose().map_err(Failure::work)?;
        let looks = before.and_then(|evidence| Looks::of(evidence, hash, &slam));
        let alignment = align_maps_within(&references, &[NONE], &slam, None, &[], looks.as_ref());
        let after = alignment.evidence(&slam, ContentHash::NONE, hash, &[NONE], looks.as_ref());
        if let (Some(drive), Some(after)) = (pair.drive, after) {
            drives.insert(drive, after);
        }
        let mut answer = answer(&pair.pair, &alignment, cpu_s() - begun_s);
        answer["walls_m"] = slam.walls_m().into();
        if let (Some(field), false) = (&alignment.field, pair.robots.is_empty()) {
            answer["at_robots"] = pair.robots.iter().map(|place| field.at(*place).map(around)).collect();
        }
        let _ = writeln!(out, "{answer}");
    }
    Ok(out)
}

/// The pose around a place, with its covariance and whether the walls there bear it out.
fn around(local: LocalPose) -> Value {
    let [x, y, yaw] = local.map_from_slam.x_y_yaw();
    json!({"x": x, "y": y, "yaw": yaw, "covariance": local.covariance.rows(), "is_borne_out": local.is_borne_out})
}

fn answer(pair: &str, alignment: &Alignment, cpu_s: f64) -> Value {
    let pose = |p: &AlignedPose| {
        let [x, y, yaw] = p.map_from_slam.x_y_yaw();
        json!({"x": x, "y": y, "yaw": yaw, "score": p.evidence.score, "evidence": evidence(&p.evidence)})
    };
    let candidate = |p: &AlignedPose| {
        let Contrast { in_walls, free_outside, distinct, seen_through, exact, seen, precision, corners } = p.contrast;
        let mut candidate = pose(p);
        candidate["contrast"] = json!({
            "in_walls": in_walls, "free_outside": free_outside, "distinct": distinct, "seen_through": seen_through,
            "exact": exact, "seen": seen, "precision": precision, "corners": corners,
        });
        candidate
    };
    let candidates: Vec<Value> = alignment.poses.iter().skip(1).map(candidate).collect();
    let mut answer = json!({
        "pair": pair, "verdict": alignment.verdict.name(), "reason": alignment.reason, "candidates": candidates,
        "wrong_probability": alignment.wrong_probability, "change": alignment.change,
        "scale": alignment.scale.map(|s| [s.value, s.deviation]), "cpu_s": cpu_s,
    });
    if let Some(best) = alignment.poses.first() {
        let [x, y, yaw] = best.map_from_slam.x_y_yaw();
        (answer["x"], answer["y"], answer["yaw"]) = (x.into(), y.into(), yaw.into());
        answer["score"] = best.evidence.score.into();
        answer["evidence"] = evidence(&best.evidence);
        answer["corners"] = json!({"seen": best.corners.n_seen, "found": best.corners.n_found});
        answer["new"] =
            json!(best.new.map(|n| json!({"seen_m": n.seen_m, "recalled_m": n.recalled_m, "through_m": n.through_m})));
        answer["covariance"] = json!(best.covariance_of_motion().rows());
    }
    if let (Some(field), Some(best)) = (&alignment.field, alignment.poses.first()) {
        let PoseExtent { walls_share, area_share, largest_off_m, unknown_share, .. } =
            field.extent_of(&best.map_from_slam);
        answer["holds"] = json!({
            "share_of_walls": walls_share, "share_of_floor": area_share, "largest_known_off_m": largest_off_m,
            "unknown_share_of_floor": unknown_share, "anywhere_m": field.covariance_of(&best.map_from_slam).map(|c| c.worst_m()),
        });
    }
    answer
}

/// CPU seconds of this thread.
fn cpu_s() -> f64 {
    let now = clock_gettime(ClockId::ThreadCPUTime);
    now.tv_sec as f64 + now.tv_nsec as f64 / 1e9
}
