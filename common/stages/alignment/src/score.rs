//! Scores a pose by precision, recall and free space.

use crate::faces::Face;
use crate::features::Features;
use crate::pose::Pose;
use crate::thresholds::FARTHEST_M;
use messages::Evidence;
use occupancy::Cell;

/// Scales over which a score is averaged, in metres: a bent map still scores on the coarse ones.
pub(crate) const SCALES: [f64; 3] = [0.1, 0.25, 0.5];
/// What the robot has seen of a face of the reference is judged so far in front of it.
const IN_FRONT_M: f64 = 0.15;
const LEAST_SEEN: usize = 20;
const PRECISION_SHARE: f64 = 0.65;

/// The faces that are compared; those of the SLAM map are drawn by weight.
pub(crate) struct Sides<'a> {
    pub(crate) slam: &'a Features,
    pub(crate) reference: &'a Features,
    pub(crate) slam_faces: &'a [Face],
    pub(crate) reference_faces: &'a [Face],
    /// True where so few faces of the reference are looked for in the SLAM map that its nearest faces need not be known everywhere.
    pub(crate) scans: bool,
}

/// Every so many cells of free space is looked at, in both directions.
const FREE_STEP: usize = 4;

/// What speaks for a pose.
pub(crate) fn evidence(sides: &Sides<'_>, pose: &Pose, scales: &[f64]) -> Evidence {
    let close = |squared: f64| {
        scales.iter().map(|tau| libm::exp(-squared / (2.0 * tau * tau))).sum::<f64>() / scales.len() as f64
    };
    let mut precision = 0.0;
    for face in sides.slam_faces {
        if let Some((nearest, squared)) = sides.reference.nearest(pose.apply(face.at)) {
            let n = pose.rotate(face.normal);
            let agreement = n[0] * nearest.normal[0] + n[1] * nearest.normal[1];
            if squared <= FARTHEST_M * FARTHEST_M && agreement > 0.0 {
                precision += close(squared) * agreement;
            }
        }
    }
    precision /= sides.slam_faces.len().max(1) as f64;
    let (mut n_seen, mut recall) = (0usize, 0.0);
    for face in sides.reference_faces {
        let front = [0, 1].map(|k| face.at[k] + IN_FRONT_M * face.normal[k]);
        if sides.slam.raster.at(pose.apply_inverse(front)) == Cell::Free {
            n_seen += 1;
            let place = pose.apply_inverse(face.at);
            let nearest = if sides.scans { sides.slam.nearest_by_scan(place) } else { sides.slam.nearest(place) };
            recall += nearest.map_or(0.0, |(_, squared)| close(squared));
        }
    }
    let recall = if n_seen > LEAST_SEEN { recall / n_seen as f64 } else { 0.0 };
    let score = PRECISION_SHARE * precision + (1.0 - PRECISION_SHARE) * recall;
    Evidence { score, precision, recall, free: free(sides, pose) }
}

fn free(sides: &Sides<'_>, pose: &Pose) -> f64 {
    let raster = &sides.slam.raster;
    let (mut n, mut n_free) = (0usize, 0usize);
    for row in (0..raster.height).step_by(FREE_STEP) {
        for column in (0..raster.width).step_by(FREE_STEP) {
            let index = row * raster.width + column;
            if raster.cells[index] == Cell::Free {
                n += 1;
                n_free += usize::from(sides.reference.raster.at(pose.apply(raster.middle(index))) == Cell::Free);
            }
        }
    }
    n_free as f64 / n.max(1) as f64
}
