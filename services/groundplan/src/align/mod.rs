//! The pose of a SLAM map in a map of the model.

use crate::cli::AlignArgs;
use crate::failure::Failure;
use rustix::time::{ClockId, clock_gettime};
use serde::Deserialize;
use serde_json::{Value, json};
use sha2::{Digest, Sha256};
use slam_align::{AlignedPose, Alignment, Hint, MapFromSlam, OccupancyMap, PreparedMap, Verdict, align_maps, overlay};
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// A line of `pairs.jsonl`; paths count from its folder.
#[derive(Deserialize)]
struct Pair {
    pair: String,
    reference: PathBuf,
    slam: PathBuf,
}

/// Aligns two maps, or all pairs of a folder; the text, and whether the alignment is accepted.
///
/// # Errors
/// A map that cannot be used.
pub fn align(arguments: &AlignArgs) -> Result<(String, bool), Failure> {
    if let Some(folder) = &arguments.pairs {
        return pairs(folder).map(|text| (text, true));
    }
    let (Some(reference), Some(slam)) = (&arguments.reference, &arguments.slam) else {
        return Err(Failure::usage("--reference and --slam are needed"));
    };
    let storeys = storeys(reference, arguments.storey)?;
    let maps: Vec<PreparedMap> = storeys
        .iter()
        .map(|s| OccupancyMap::read(&s.path).map(|map| PreparedMap::of_model(&map)).map_err(Failure::usage))
        .collect::<Result<_, _>>()?;
    let slam_map = PreparedMap::of_slam(&OccupancyMap::read(slam).map_err(Failure::usage)?);
    let alignment = align_maps(&maps, &slam_map, hint(arguments).as_ref());
    let accepted = alignment.poses.first().filter(|_| alignment.verdict == Verdict::Accepted);
    if let (Some(path), Some(pose)) = (&arguments.transform, accepted) {
        write(path, transform(pose).as_bytes())?;
    }
    if let (Some(path), Some(pose)) = (&arguments.overlay, alignment.poses.first()) {
        write(path, &overlay(&maps[pose.reference], &slam_map, pose).map_err(Failure::work)?)?;
    }
    let text = if arguments.json {
        let inputs = json!({"reference_sha256": sha256(reference)?, "slam_sha256": sha256(slam)?});
        format!("{:#}\n", document(&alignment, &storeys, inputs))
    } else {
        text(&alignment, &storeys)
    };
    Ok((text, alignment.verdict == Verdict::Accepted))
}

/// A map of the model.
struct StoreyMap {
    path: PathBuf,
    /// Index of the map storey; none for a map of its own.
    storey: Option<u64>,
}

/// The map itself, or the localization maps of a folder that `convert` wrote.
fn storeys(reference: &Path, only: Option<u64>) -> Result<Vec<StoreyMap>, Failure> {
    if !reference.is_dir() {
        return Ok(vec![StoreyMap { path: reference.to_owned(), storey: None }]);
    }
    let path = reference.join("manifest.json");
    let unusable = |why: String| Failure::usage(format!("{}: {why}", path.display()));
    let bytes = std::fs::read(&path).map_err(|error| unusable(error.to_string()))?;
    let manifest: Manifest = serde_json::from_slice(&bytes).map_err(|error| unusable(error.to_string()))?;
    let storeys: Vec<StoreyMap> = manifest
        .storeys
        .iter()
        .filter(|s| only.is_none_or(|only| s.index == only))
        .map(|s| StoreyMap { path: reference.join(&s.directory).join("localization.yaml"), storey: Some(s.index) })
        .collect();
    if storeys.is_empty() {
        return Err(unusable("it has no such storey".to_owned()));
    }
    Ok(storeys)
}

#[derive(Deserialize)]
struct Manifest {
    storeys: Vec<ManifestStorey>,
}

#[derive(Deserialize)]
struct ManifestStorey {
    index: u64,
    directory: PathBuf,
}

fn hint(arguments: &AlignArgs) -> Option<Hint> {
    let &[x_m, y_m, yaw] = arguments.hint.as_deref()?.first_chunk::<3>()?;
    let &[radius_m, radius] = arguments.hint_radius.first_chunk::<2>()?;
    let map_from_slam = MapFromSlam { x_m, y_m, yaw_rad: yaw.to_radians() };
    Some(Hint { map_from_slam, radius_m, radius_rad: radius.to_radians() })
}

fn pairs(folder: &Path) -> Result<String, Failure> {
    let list = folder.join("pairs.jsonl");
    let text = std::fs::read_to_string(&list)
        .map_err(|error| Failure::usage(format!("{} cannot be read: {error}", list.display())))?;
    let mut out = String::new();
    for line in text.lines().filter(|line| !line.trim().is_empty()) {
        let pair: Pair =
            serde_json::from_str(line).map_err(|error| Failure::usage(format!("{}: {error}", list.display())))?;
        let read = |path: &Path| OccupancyMap::read(&folder.join(path)).map_err(Failure::usage);
        let (reference, slam) = (read(&pair.reference)?, read(&pair.slam)?);
        let begun_s = cpu_s();
        let alignment = align_maps(&[PreparedMap::of_model(&reference)], &PreparedMap::of_slam(&slam), None);
        let answer = answer(&pair.pair, &alignment, cpu_s() - begun_s);
        let _ = writeln!(out, "{answer}");
    }
    Ok(out)
}

fn word(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Accepted => "accepted",
        Verdict::Ambiguous => "ambiguous",
        Verdict::Refused => "refused",
    }
}

fn motion(pose: &AlignedPose) -> Value {
    let m = pose.map_from_slam;
    json!({"x_m": m.x_m, "y_m": m.y_m, "yaw_rad": m.yaw_rad})
}

fn evidence(pose: &AlignedPose) -> Value {
    let slam_align::Evidence { precision, recall, free, .. } = pose.evidence;
    json!({"precision": precision, "recall": recall, "free": free})
}

/// What `align --json` prints.
fn document(alignment: &Alignment, storeys: &[StoreyMap], inputs: Value) -> Value {
    let storey = |p: &AlignedPose| storeys[p.reference].storey;
    let candidates: Vec<Value> = alignment
        .poses
        .iter()
        .map(|p| {
            let (storey, score) = (storey(p), p.evidence.score);
            json!({"storey": storey, "map_from_slam": motion(p), "score": score, "evidence": evidence(p)})
        })
        .collect();
    let best = alignment.poses.first().filter(|_| alignment.verdict == Verdict::Accepted);
    let back = best.map(|p| {
        let [x_m, y_m, yaw_rad] = p.map_from_slam.inverse();
        json!({"x_m": x_m, "y_m": y_m, "yaw_rad": yaw_rad})
    });
    json!({
        "verdict": word(alignment.verdict),
        "reason": alignment.reason,
        "storey": best.and_then(storey),
        "map_from_slam": best.map(motion),
        "slam_from_map": back,
        "covariance": best.map(|p| p.covariance.concat()),
        "about": best.map(|p| p.about_m),
        "score": alignment.poses.first().map(|p| p.evidence.score),
        "candidates": candidates,
        "inputs": inputs,
    })
}

/// A line of a benchmark.
fn answer(pair: &str, alignment: &Alignment, cpu_s: f64) -> Value {
    let pose = |p: &AlignedPose| {
        let m = p.map_from_slam;
        json!({"x": m.x_m, "y": m.y_m, "yaw": m.yaw_rad, "score": p.evidence.score, "evidence": evidence(p)})
    };
    let candidates: Vec<Value> = alignment.poses.iter().skip(1).map(pose).collect();
    let mut answer = json!({
        "pair": pair, "verdict": word(alignment.verdict), "reason": alignment.reason, "candidates": candidates,
        "cpu_s": cpu_s,
    });
    if let Some(best) = alignment.poses.first() {
        let m = best.map_from_slam;
        (answer["x"], answer["y"], answer["yaw"]) = (m.x_m.into(), m.y_m.into(), m.yaw_rad.into());
        answer["score"] = best.evidence.score.into();
        answer["evidence"] = evidence(best);
        answer["covariance"] = json!(best.covariance_of_motion());
    }
    answer
}

fn text(alignment: &Alignment, storeys: &[StoreyMap]) -> String {
    let mut out = word(alignment.verdict).to_owned();
    if !alignment.reason.is_empty() {
        let _ = write!(out, ": {}", alignment.reason);
    }
    out.push('\n');
    let told = match alignment.verdict {
        Verdict::Accepted => 1,
        Verdict::Ambiguous => alignment.poses.len(),
        Verdict::Refused => 0,
    };
    for pose in &alignment.poses[..told] {
        let m = pose.map_from_slam;
        let (degrees, score) = (m.yaw_rad.to_degrees(), pose.evidence.score);
        if let Some(storey) = storeys[pose.reference].storey {
            let _ = write!(out, "  storey {storey}");
        }
        let _ = writeln!(
            out,
            "  map_from_slam x {:.3} m, y {:.3} m, yaw {degrees:.3} degrees, score {score:.3}",
            m.x_m, m.y_m
        );
    }
    out
}

/// A static transform as ROS writes one: where the model's frame lies in the robot's.
fn transform(pose: &AlignedPose) -> String {
    let [x_m, y_m, yaw_rad] = pose.map_from_slam.inverse();
    let (sin, cos) = libm::sincos(yaw_rad / 2.0);
    format!(
        "# ros2 run tf2_ros static_transform_publisher --x {x_m} --y {y_m} --yaw {yaw_rad} --frame-id map \\\n\
         #   --child-frame-id site_map\n\
         header:\n  frame_id: map\nchild_frame_id: site_map\n\
         transform:\n  translation: {{x: {x_m}, y: {y_m}, z: 0.0}}\n  rotation: {{x: 0.0, y: 0.0, z: {sin}, w: {cos}}}\n"
    )
}

fn write(path: &Path, bytes: &[u8]) -> Result<(), Failure> {
    std::fs::write(path, bytes).map_err(|error| Failure::work(format!("{}: {error}", path.display())))
}

fn sha256(path: &Path) -> Result<String, Failure> {
    // A folder is told by its manifest, which has the sums of all its files.
    let path = if path.is_dir() { path.join("manifest.json") } else { path.to_owned() };
    let bytes = std::fs::read(path).map_err(Failure::work)?;
    Ok(Sha256::digest(bytes).iter().fold(String::new(), |mut hex, byte| {
        let _ = write!(hex, "{byte:02x}");
        hex
    }))
}

/// CPU seconds of this thread.
fn cpu_s() -> f64 {
    let now = clock_gettime(ClockId::ThreadCPUTime);
    now.tv_sec as f64 + now.tv_nsec as f64 / 1e9
}
