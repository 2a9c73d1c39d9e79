//! Scores a pose by precision, recall and free space.

use crate::features::Features;
use crate::pose::Pose;
use crate::thresholds::MAX_MATCH_M;
use crate::wall_points::WallPoint;
use messages::PoseEvidence;
use occupancy::Cell;

/// Scales over which a score is averaged, in metres: a distorted map still scores on the coarse ones.
pub(crate) const SCALES: [f64; 3] = [0.1, 0.25, 0.5];
/// Distance in front of a wall point of the reference at which visibility is tested.
const IN_FRONT_M: f64 = 0.15;
const MIN_SEEN: usize = 20;
const PRECISION_SHARE: f64 = 0.65;

/// The wall points that are compared; those of the SLAM map are drawn by weight.
pub(crate) struct ComparedMaps<'a> {
    pub(crate) slam: &'a Features,
    pub(crate) reference: &'a Features,
    pub(crate) slam_points: &'a [WallPoint],
    pub(crate) reference_points: &'a [WallPoint],
    /// True where so few wall points of the reference are looked for in the SLAM map that its nearest wall points need not
    /// be known everywhere.
    pub(crate) scans: bool,
}

/// Every so many cells of free space is looked at, in both directions.
const FREE_STEP: usize = 4;

/// The evidence for a pose.
pub(crate) fn evidence(maps: &ComparedMaps<'_>, pose: &Pose, scales: &[f64]) -> PoseEvidence {
    let close = |squared: f64| {
        scales.iter().map(|tau| libm::exp(-squared / (2.0 * tau * tau))).sum::<f64>() / scales.len() as f64
    };
    let mut precision = 0.0;
    for wall_point in maps.slam_points {
        if let Some((nearest, squared)) = maps.reference.nearest(pose.apply(wall_point.at)) {
            let n = pose.rotate(wall_point.normal);
            let agreement = n[0] * nearest.normal[0] + n[1] * nearest.normal[1];
            if squared <= MAX_MATCH_M * MAX_MATCH_M && agreement > 0.0 {
                precision += close(squared) * agreement;
            }
        }
    }
    precision /= maps.slam_points.len().max(1) as f64;
    let (mut n_seen, mut recall) = (0usize, 0.0);
    for wall_point in maps.reference_points {
        let front = [0, 1].map(|k| wall_point.at[k] + IN_FRONT_M * wall_point.normal[k]);
        if maps.slam.raster.at(pose.apply_inverse(front)) == Cell::Free {
            n_seen += 1;
            let place = pose.apply_inverse(wall_point.at);
            let nearest = if maps.scans { maps.slam.nearest_by_scan(place) } else { maps.slam.nearest(place) };
            recall += nearest.map_or(0.0, |(_, squared)| close(squared));
        }
    }
    let recall = if n_seen > MIN_SEEN { recall / n_seen as f64 } else { 0.0 };
    let score = PRECISION_SHARE * precision + (1.0 - PRECISION_SHARE) * recall;
    PoseEvidence { score, precision, recall, free: free(maps, pose) }
}

fn free(maps: &ComparedMaps<'_>, pose: &Pose) -> f64 {
    let raster = &maps.slam.raster;
    let (mut n, mut n_free) = (0usize, 0usize);
    for row in (0..raster.height).step_by(FREE_STEP) {
        for column in (0..raster.width).step_by(FREE_STEP) {
            let index = row * raster.width + column;
            if raster.cells[index] == Cell::Free {
                n += 1;
                n_free += usize::from(maps.reference.raster.at(pose.apply(raster.middle(index))) == Cell::Free);
            }
        }
    }
    n_free as f64 / n.max(1) as f64
}
