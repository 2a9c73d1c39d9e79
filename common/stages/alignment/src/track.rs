//! Local refinement of the last pose with a newer SLAM map.

use crate::alignment::{AlignedPose, PreparedMap, between_cells};
use crate::chance::Chance;
use crate::faces::Face;
use crate::pose::is_same;
use crate::refine::refined;
use crate::score::{SCALES, Sides, evidence};
use crate::search::Candidate;
use crate::thresholds::{LEAST_FACES, N_TRACKED_FACES};
use crate::verdict::is_borne_out;
use frames::{Map, Rigid2, Slam};

/// Scales of the refinement, in metres: the first reaches what a map moves by between two updates.
const FOLLOWING: [f64; 4] = [0.6, 0.3, 0.15, 0.1];

/// The pose of a newer SLAM map near that of the last; `None` if the map does not bear it out, or holds it too loosely.
pub fn track_map(
    references: &[impl AsRef<PreparedMap<Map>>],
    slam: &PreparedMap<Slam>,
    last: (usize, &Rigid2<Map, Slam>),
) -> Option<AlignedPose> {
    let (at, last) = last;
    let reference = references.get(at)?.as_ref();
    if slam.features.faces.len() < LEAST_FACES || reference.features.faces.len() < LEAST_FACES {
        return None;
    }
    let mut chance = Chance::new(1);
    let mut drawn = |faces: &[Face], by_weight: bool| -> Vec<Face> {
        let weights = faces.iter().map(|f| if by_weight { f.weight } else { 1.0 });
        chance.draw(weights, N_TRACKED_FACES).into_iter().map(|k| faces[k as usize]).collect()
    };
    let slam_faces = drawn(&slam.features.faces, true);
    let reference_faces = drawn(&reference.features.faces, false);
    let start = between_cells(reference, slam, last);
    let refined = refined(&reference.features, &slam_faces, start, &FOLLOWING)?;
    let sides = Sides {
        slam: &slam.features,
        reference: &reference.features,
        slam_faces: &slam_faces,
        reference_faces: &reference_faces,
        scans: true,
    };
    let evidence = evidence(&sides, &refined.pose, &SCALES);
    let candidate = Candidate { refined, evidence };
    let is_near = is_same(&refined.pose, &start, slam.features.centre);
    (is_near && is_borne_out(&slam.features, &candidate)).then(|| AlignedPose::of(at, reference, slam, &candidate))
}
