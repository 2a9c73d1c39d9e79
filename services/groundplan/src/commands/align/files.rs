//! Aligning maps in files.

use super::args::Args;
use super::semantic::site_places;
use super::slam_frame;
use super::storey_claim::StoreyClaim;
use crate::alignment_report;
use crate::args::report_set_aside;
use crate::failure::Failure;
use crate::input_document::read_document;
use crate::run::Outcome;
use alignment::{
    AlignmentSources, Looks, PlaceHint, PreparedMap, align_maps_at_any_scale, align_maps_within, overlay,
    references_hash,
};
use daemon::write_durably;
use frames::Map;
use messages::{
    Alignment, AlignmentEvidence, AlignmentVerdict, ArchiveBuffer, ArchiveError, ContentHash, ContentId, NONE,
    ScheduleStateHead,
};
use occupancy::{MapFileContent, OccupancyMap, UndecidedCells};
use serde::Deserialize;
use serde_json::json;
use std::collections::BTreeSet;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// Aligns a map of the robot with those of a folder, or with one.
///
/// # Errors
/// A map that cannot be used, a file that cannot be written.
pub(super) fn align(arguments: &Args, reference: &Path, slam: &Path) -> Result<Outcome, Failure> {
    let references = ReferenceMaps::of(reference, arguments.place.storey, arguments.free_scale)?;
    let claim = references.storey_claim();
    let ReferenceMaps { storeys, plan_time_s, given } = references;
    let maps: Vec<PreparedMap<Map>> = storeys
        .iter()
        .map(|s| OccupancyMap::read(&s.path).map(|map| PreparedMap::of_model(&map)).map_err(Failure::usage))
        .collect::<Result<_, _>>()?;
    let (map, content) = OccupancyMap::read_with_content(slam).map_err(Failure::usage)?;
    let hint = arguments.place.hint();
    let slam_map = PreparedMap::of_slam(&map);
    let content_hash = map.content_hash().map_err(Failure::usage)?;
    let numbers: Vec<u32> = storeys.iter().map(|s| s.index).collect();
    let known = arguments.place.known_places()?;
    let places = site_places(reference, storeys.iter().filter_map(|s| Some((s.index, s.floor_z_m?))))?;
    let hints = places.hints(known.points_in_rooms(), known.elevation_m, known.portal.as_deref());
    let mut hints = hints.map_err(Failure::usage)?;
    hints.extend(given.map(PlaceHint::on_storey));
    let before = arguments.evidence.as_deref().map(evidence_at).transpose()?.flatten();
    let before = before.as_ref().map(|archive| AlignmentEvidence::open(archive.bytes()));
    let before = before.transpose().map_err(|error| unusable_evidence(arguments, &error))?;
    let hash = references_hash(&maps, &numbers);
    let looks = before.and_then(|evidence| Looks::of(evidence, hash, &slam_map));
    let mut found = match arguments.free_scale {
        false => align_maps_within(&maps, &numbers, &slam_map, hint.as_ref(), &hints, looks.as_ref()),
        true => align_maps_at_any_scale(&maps, &map, hint.as_ref()),
    };
    let scaled = found.scale.filter(|_| arguments.free_scale).map_or(1.0, |s| s.value);
    let slam_map = if scaled == 1.0 { slam_map } else { PreparedMap::of_slam(&map.divided_by(scaled)) };
    if let Some(path) = &arguments.evidence
        && let Some(after) = found.evidence(&slam_map, content_hash, hash, &numbers, looks.as_ref())
    {
        write_durably(path, after.bytes()).map_err(|error| Failure::work(format!("{}: {error}", path.display())))?;
    }
    found.decide(&maps, &slam_map, &numbers, &places.rooms);
    if found.verdict != AlignmentVerdict::Accepted {
        found.reason.push_str(&undecided_cells(&content, slam));
    }
    let none = ContentHash::NONE;
    let sources = AlignmentSources { site_hash: none, slam_map_hash: none, searched_map_hash: none, plan_time_s };
    let pose_status = found.pose_status(&numbers, arguments.max_uncertainty(), arguments.robot_m());
    let archive = found.archive(&numbers, &pose_status, sources);
    let alignment = Alignment::open(archive.bytes()).map_err(Failure::work)?;
    arguments.write_pose(&alignment)?;
    let is_usable = alignment.usable(arguments.robot_m()).is_ok();
    // Maps follow the whole of the robot's map and never the robot's place: they would jump under it.
    if let (Some(folder), Some(frame)) = (&arguments.resample, alignment.slam_frame()) {
        let of_storey = |s: &&StoreyMap| s.index == frame.map_storey() && s.index != NONE;
        if let Some(map) = storeys.iter().find(of_storey).map(|s| &s.path) {
            let files = slam_frame::files(reference, map, &frame)?;
            let folder = arguments.overwrite.folder_at(folder)?;
            report_set_aside(folder.replace(&files).map_err(Failure::work)?);
        }
    }
    if let (Some(path), Some(pose)) = (&arguments.overlay, found.poses.first()) {
        let image = overlay(&maps[pose.reference], &slam_map, pose).map_err(Failure::work)?;
        write_durably(path, &image).map_err(|error| Failure::work(format!("{}: {error}", path.display())))?;
    }
    let alike = storeys_alike(&found, alignment.pose().map(|pose| pose.map_storey));
    let claim = claim.after_hints(&alike);
    let text = if arguments.json {
        let inputs = json!({"reference_sha256": sha256(reference)?, "slam_sha256": sha256(slam)?});
        let mut document = alignment_report::document(&alignment, arguments.robot_m(), inputs);
        document["storey_claim"] = claim.name().into();
        document["storeys_alike"] = alike.into();
        format!("{document:#}\n")
    } else {
        alignment_report::text(&alignment, arguments.robot_m()) + &claim.told(&alignment, &alike)
    };
    Ok(Outcome::judged(text, is_usable))
}

/// Storeys that hints exclude although the map fits about as well there, in order.
fn storeys_alike(found: &alignment::Alignment, own: Option<u32>) -> Vec<u32> {
    let all = found.exclusions.iter().flat_map(|exclusion| &exclusion.storeys).copied();
    let others: BTreeSet<u32> = all.filter(|storey| Some(*storey) != own).collect();
    others.into_iter().collect()
}

/// What is wrong with the thresholds of a map that leave most of its cells undecided, as the end of a reason; empty if nothing is.
fn undecided_cells(content: &MapFileContent, slam: &Path) -> String {
    let undecided = content.undecided().filter(|undecided| undecided.share > MAX_UNDECIDED_SHARE);
    undecided.map_or_else(String::new, |UndecidedCells { share, free_thresh, occupied_thresh }| {
        format!(
            "; {:.0} % of the cells that are not of the unknown grey lie between free_thresh {free_thresh} and occupied_thresh \
             {occupied_thresh} and tell nothing: if they are probabilities, set occupied_thresh: 0.5 and free_thresh: 0.49 in {}",
            100.0 * share,
            slam.display()
        )
    })
}

/// Of more undecided cells the answer says that the thresholds may be wrong.
const MAX_UNDECIDED_SHARE: f64 = 0.3;

/// Evidence of earlier looks; `None` if there is no file yet.
fn evidence_at(path: &Path) -> Result<Option<ArchiveBuffer>, Failure> {
    match read_document(path) {
        Ok(bytes) => Ok(Some(ArchiveBuffer::copy_of(&bytes))),
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(None),
        Err(error) => Err(Failure::usage(format!("{}: {error}", path.display()))),
    }
}

fn unusable_evidence(arguments: &Args, error: &ArchiveError) -> Failure {
    let path = arguments.evidence.as_deref().unwrap_or(Path::new("")).display();
    Failure::usage(format!("{path}: {error}; remove it to begin anew"))
}

/// A map of the model.
struct StoreyMap {
    path: PathBuf,
    /// Index of the map storey; [`NONE`] for a map of its own.
    index: u32,
    /// Height of its floor; `None` for a map of its own.
    floor_z_m: Option<f64>,
}

/// Maps of the model that a SLAM map is compared with, and what is known of its storey.
struct ReferenceMaps {
    storeys: Vec<StoreyMap>,
    plan_time_s: i64,
    /// The storey that the robot is said to be on.
    given: Option<u32>,
}

impl ReferenceMaps {
    /// The localization maps of a folder that `convert` wrote, or one map: the storeys beside it are looked at, too, if it lies in such a
    /// folder. There must be that of the storey `wanted`, and at any scale it is the only one: the others are looked at to tell whether
    /// they fit better.
    fn of(reference: &Path, wanted: Option<u32>, free_scale: bool) -> Result<Self, Failure> {
        if reference.is_dir() {
            return Self::of_folder(reference, wanted, free_scale);
        }
        if let Some((folder, storey)) =
            folder_around(reference).filter(|(_, storey)| wanted.is_none_or(|w| w == *storey))
        {
            return Self::of_folder(&folder, Some(storey), free_scale);
        }
        let storeys = vec![StoreyMap { path: reference.to_owned(), index: NONE, floor_z_m: None }];
        Ok(Self { storeys, plan_time_s: ScheduleStateHead::NO_TIME, given: None })
    }

    fn of_folder(folder: &Path, wanted: Option<u32>, free_scale: bool) -> Result<Self, Failure> {
        let unusable = |why: String| Failure::usage(format!("{}: {why}", folder.join(MANIFEST).display()));
        let manifest = Manifest::read(folder).map_err(&unusable)?;
        let storeys: Vec<StoreyMap> = manifest
            .storeys
            .iter()
            .filter(|s| s.floor != GROUND && (!free_scale || wanted.is_none_or(|wanted| s.index == wanted)))
            .map(|s| StoreyMap {
                path: folder.join(&s.directory).join(LOCALIZATION),
                index: s.index,
                floor_z_m: Some(s.floor_z_m),
            })
            .collect();
        if manifest.storeys.iter().any(|s| s.floor == GROUND && Some(s.index) == wanted) {
            return Err(unusable("that storey is the ground outdoors, with which no map is aligned".to_owned()));
        }
        if wanted.is_some_and(|wanted| storeys.iter().all(|s| s.index != wanted)) || storeys.is_empty() {
            return Err(unusable("it has no such storey".to_owned()));
        }
        let plan_time = manifest.plan_time.as_deref().map(str::parse::<frames::PlanTime>).transpose();
        let plan_time = plan_time.map_err(|error| unusable(error.to_string()))?;
        let plan_time_s = plan_time.map_or(ScheduleStateHead::NO_TIME, frames::PlanTime::civil_seconds);
        Ok(Self { storeys, plan_time_s, given: wanted })
    }

    /// What the answer says about the storey.
    fn storey_claim(&self) -> StoreyClaim {
        match self.given {
            _ if self.storeys.len() < 2 => StoreyClaim::NotTested,
            Some(_) => StoreyClaim::Given,
            None => StoreyClaim::Tested,
        }
    }
}

const MANIFEST: &str = "manifest.json";
/// What a manifest says of the floor of the map storey outdoors.
const GROUND: &str = "ground";
const LOCALIZATION: &str = "localization.yaml";

/// The folder that `convert` wrote around the localization map of a storey, and that storey.
fn folder_around(map: &Path) -> Option<(PathBuf, u32)> {
    let map = map.canonicalize().ok()?;
    let folder = map.ancestors().nth(3)?.to_owned();
    let manifest = Manifest::read(&folder).ok()?;
    let own =
        |s: &&ManifestStorey| folder.join(&s.directory).join(LOCALIZATION).canonicalize().is_ok_and(|path| path == map);
    let storey = manifest.storeys.iter().find(own)?.index;
    Some((folder, storey))
}

#[derive(Deserialize)]
struct Manifest {
    plan_time: Option<String>,
    storeys: Vec<ManifestStorey>,
}

impl Manifest {
    fn read(folder: &Path) -> Result<Self, String> {
        let bytes = read_document(&folder.join(MANIFEST)).map_err(|error| error.to_string())?;
        serde_json::from_slice(&bytes).map_err(|error| error.to_string())
    }
}

#[derive(Deserialize)]
struct ManifestStorey {
    index: u32,
    directory: PathBuf,
    floor: String,
    floor_z_m: f64,
}

fn sha256(path: &Path) -> Result<String, Failure> {
    // A folder is identified by its manifest, which has the sums of all its files.
    let path = if path.is_dir() { path.join("manifest.json") } else { path.to_owned() };
    let bytes = read_document(&path).map_err(Failure::work)?;
    Ok(ContentId::of(&bytes).to_string())
}
