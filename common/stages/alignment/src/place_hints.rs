//! Alignment within place hints: storeys, rooms and portals exclude the poses that contradict them.

use crate::alignment::{AlignedPose, Alignment, Hint, candidates_of, judged, judged_unbent};
use crate::candidate::Candidate;
use crate::exclusion::Exclusion;
use crate::looks::Looks;
use crate::pose::Pose;
use crate::prepared_map::PreparedMap;
use crate::rooms::Room;
use crate::search::{PoseGuess, search};
use crate::thresholds::{MIN_WALL_POINTS, RIVAL_LEAD};
use frames::{Map, Slam};
use messages::{AlignmentVerdict, NONE};
use occupancy::Cell;

/// A hint of which every pose is excluded that contradicts it.
#[derive(Debug, Clone, PartialEq)]
pub struct PlaceHint {
    /// What people call it.
    pub label: String,
    /// Where the SLAM map may lie: in any of these.
    pub areas: Vec<Area>,
}

impl PlaceHint {
    /// The robot is on this map storey.
    pub fn on_storey(storey: u32) -> Self {
        Self { label: format!("storey {storey}"), areas: vec![Area::Storey(storey)] }
    }
}

/// Where a SLAM map may lie.
#[derive(Debug, Clone, PartialEq)]
pub enum Area {
    /// On this map storey.
    Storey(u32),
    /// A point of the SLAM map, in its frame, lies in this room.
    Room {
        /// The point, in metres.
        in_slam_m: [f64; 2],
        /// The room.
        room: Room,
    },
    /// The SLAM map shows what lies beside this box, on one of these map storeys.
    Beside {
        /// Indices of map storeys.
        map_storeys: Vec<u32>,
        /// Lower left and upper right corner in `map`, in metres.
        bounds_m: [[f64; 2]; 2],
    },
}

/// How far outside of a room a point may lie, in metres, beside the uncertainty of the pose.
const ROOM_MARGIN_M: f64 = 0.5;
/// Standard deviations of a pose that are added to it.
const N_DEVIATIONS: f64 = 2.0;
/// What lies so near to a portal is beside it, and the distance of the points that are looked at, in metres.
const BESIDE_M: f64 = 1.0;
const BESIDE_STEP_M: f64 = 0.25;
/// Points that are looked at along a side of a box, at most.
const MAX_STEPS: usize = 200;

/// Aligns as [`crate::align_maps`], of the poses that no hint excludes. `storeys` are those of the references, as for
/// [`AlignedPose::record`].
///
/// Poses that earlier looks at a growing map found are tested by what is new since.
///
/// If the map fits clearly better where a hint excludes it, the alignment is refused: the hint may be wrong.
pub fn align_maps_within(
    references: &[impl AsRef<PreparedMap<Map>>],
    storeys: &[u32],
    slam: &PreparedMap<Slam>,
    hint: Option<&Hint>,
    place_hints: &[PlaceHint],
    looks: Option<&Looks<'_>>,
) -> Alignment {
    let all = candidates_of(references, storeys, slam, hint, looks);
    let pose_of =
        |(at, candidate): &(usize, Candidate)| AlignedPose::of(*at, references[*at].as_ref(), slam, candidate);
    let storey_of = |at: usize| storeys.get(at).copied().unwrap_or(NONE);
    let excludes = |place_hint: &PlaceHint, found: &(usize, Candidate)| {
        !place_hint.areas.iter().any(|area| area.holds(&pose_of(found), storey_of(found.0), slam))
    };
    let is_kept = |found: &(usize, Candidate)| !place_hints.iter().any(|place_hint| excludes(place_hint, found));
    let (mut kept, excluded): (Vec<_>, Vec<_>) = all.into_iter().partition(is_kept);
    let best = |found: &[(usize, Candidate)]| {
        found.first().map_or(f64::NEG_INFINITY, |(_, candidate)| candidate.evidence.log_odds)
    };
    let is_elsewhere = |kept: &[(usize, Candidate)]| best(kept) < best(&excluded) - RIVAL_LEAD;
    if hint.is_none() && is_elsewhere(&kept) {
        // In a building with many alike rooms the search ends before it comes to those of the hints.
        let mut closer: Vec<(usize, Candidate)> = Vec::new();
        for (at, reference) in references.iter().map(AsRef::as_ref).enumerate() {
            if let Some(guess) = guess_in_rooms(reference, slam, storey_of(at), place_hints) {
                let found = search(&reference.features, &slam.features, Some(&guess), &[]);
                closer.extend(found.into_iter().map(|candidate| (at, candidate)).filter(&is_kept));
            }
        }
        closer.sort_by(|a, b| b.1.evidence.log_odds.total_cmp(&a.1.evidence.log_odds));
        if best(&closer) > best(&kept) {
            kept = closer;
        }
    }
    let mut alignment = judged(references, slam, &kept);
    if hint.is_none() && place_hints.is_empty() {
        alignment = judged_unbent(alignment, references, slam).with_faults(references, slam);
    }
    alignment = alignment.with_storeys(references, storeys, slam);
    let best_of_all = best(&kept).max(best(&excluded));
    let fits_as_well = |found: &&(usize, Candidate)| found.1.evidence.log_odds >= best_of_all - RIVAL_LEAD;
    let exclusion = |place_hint: &PlaceHint| {
        let contradict = excluded.iter().filter(fits_as_well).filter(|found| excludes(place_hint, found));
        let mut storeys: Vec<u32> = contradict.map(|(at, _)| storey_of(*at)).collect();
        let n_poses = storeys.len();
        storeys.sort_unstable();
        storeys.dedup();
        Exclusion { label: place_hint.label.clone(), n_poses, storeys }
    };
    alignment.exclusions = place_hints.iter().map(exclusion).collect();
    if let Some(elsewhere) = excluded.first().filter(|_| is_elsewhere(&kept)) {
        let labels: Vec<&str> =
            place_hints.iter().filter(|hint| excludes(hint, elsewhere)).map(|hint| hint.label.as_str()).collect();
        alignment.verdict = AlignmentVerdict::Refused;
        alignment.reason = format!(
            "the SLAM map fits better where it cannot lie by the hints ({}): log odds {:.1}, and {} where it can",
            labels.join("; "),
            elsewhere.1.evidence.log_odds,
            kept.first().map_or("none".to_owned(), |(_, candidate)| format!("{:.1}", candidate.evidence.log_odds))
        );
    }
    alignment.change = looks.and_then(|looks| looks.change(&alignment, storeys));
    alignment
}

/// All poses by which points of the SLAM map may lie in the rooms of a storey; `None` if no hint names a room there.
fn guess_in_rooms(
    reference: &PreparedMap<Map>,
    slam: &PreparedMap<Slam>,
    storey: u32,
    place_hints: &[PlaceHint],
) -> Option<PoseGuess> {
    if slam.features.n_wall_points() < MIN_WALL_POINTS {
        return None;
    }
    let about = slam.features.centre;
    let guess = |place_hint: &PlaceHint| {
        let here = place_hint.areas.iter().filter_map(|area| match area {
            Area::Room { in_slam_m, room } if room.map_storey == storey => Some((in_slam_m, room)),
            _ => None,
        });
        let (points, rooms): (Vec<&[f64; 2]>, Vec<&Room>) = here.unzip();
        let corners: Vec<[f64; 2]> = rooms.iter().flat_map(|room| room.rings_m.iter().flatten().copied()).collect();
        let bound = |k: usize, of: fn(f64, f64) -> f64| corners.iter().map(|p| p[k]).reduce(of);
        let lo = [bound(0, f64::min)?, bound(1, f64::min)?];
        let hi = [bound(0, f64::max)?, bound(1, f64::max)?];
        let middle = reference.frame_from_cells().apply_inverse([0, 1].map(|k| (lo[k] + hi[k]) / 2.0));
        let point = slam.frame_from_cells().apply_inverse(**points.first()?);
        let lever_m = libm::hypot(point[0] - about[0], point[1] - about[1]);
        let radius_m = lever_m + libm::hypot(hi[0] - lo[0], hi[1] - lo[1]) / 2.0 + ROOM_MARGIN_M;
        let pose = Pose::new([0, 1].map(|k| middle[k] - about[k]), 0.0);
        Some(PoseGuess { pose, radius_m, radius_rad: std::f64::consts::PI })
    };
    place_hints.iter().filter_map(guess).min_by(|a, b| a.radius_m.total_cmp(&b.radius_m))
}

impl Area {
    /// True if the SLAM map may lie here by a pose on a map storey.
    fn holds(&self, pose: &AlignedPose, storey: u32, slam: &PreparedMap<Slam>) -> bool {
        match self {
            Self::Storey(wanted) => *wanted == storey,
            Self::Room { in_slam_m, room } => {
                let place = pose.map_from_slam.apply(*in_slam_m);
                let about = pose.map_from_slam.apply(pose.about_m);
                let deviation_m = pose.covariance.transported([0, 1].map(|k| place[k] - about[k])).worst_m();
                room.map_storey == storey && room.distance_m(place) <= ROOM_MARGIN_M + N_DEVIATIONS * deviation_m
            }
            Self::Beside { map_storeys, bounds_m } => {
                map_storeys.contains(&storey) && points_beside(*bounds_m).any(|point| shows(slam, pose, point))
            }
        }
    }
}

/// Points in and around a box, not far from each other.
fn points_beside([lo, hi]: [[f64; 2]; 2]) -> impl Iterator<Item = [f64; 2]> {
    let size = [0, 1].map(|k| hi[k] - lo[k] + 2.0 * BESIDE_M);
    let n = size.map(|m| ((m / BESIDE_STEP_M) as usize).clamp(1, MAX_STEPS));
    let at = move |k: usize, step: usize| lo[k] - BESIDE_M + size[k] * step as f64 / n[k] as f64;
    (0..=n[1]).flat_map(move |row| (0..=n[0]).map(move |column| [at(0, column), at(1, row)]))
}

/// True if the SLAM map shows anything at a point of the model's map.
fn shows(slam: &PreparedMap<Slam>, pose: &AlignedPose, point: [f64; 2]) -> bool {
    let in_cells = slam.frame_from_cells().apply_inverse(pose.map_from_slam.apply_inverse(point));
    slam.features.raster.at(in_cells) != Cell::Unknown
}
