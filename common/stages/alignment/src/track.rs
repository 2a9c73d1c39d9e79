//! Local refinement of the last pose with a newer SLAM map.

use crate::alignment::AlignedPose;
use crate::candidate::Candidate;
use crate::pose::is_same_pose;
use crate::prepared_map::{PreparedMap, between_cells};
use crate::random_generator::RandomGenerator;
use crate::refine::refined;
use crate::score::{ComparedMaps, SlamCells, evidence};
use crate::thresholds::{MIN_WALL_POINTS, N_TRACKED_CELLS, N_TRACKED_POINTS};
use crate::verdict::is_borne_out;
use crate::wall_points::drawn_evenly;
use frames::{Map, Rigid2, Slam};

/// Scales of the refinement, in metres: the first reaches what a map moves by between two updates.
const TRACKING_SCALES_M: [f64; 4] = [0.6, 0.3, 0.15, 0.1];

/// The pose of a newer SLAM map near that of the last; `None` if the map does not support it, or constrains it too little.
pub fn track_map(
    references: &[impl AsRef<PreparedMap<Map>>],
    slam: &PreparedMap<Slam>,
    last: (usize, &Rigid2<Map, Slam>),
) -> Option<AlignedPose> {
    let (at, last) = last;
    let reference = references.get(at)?.as_ref();
    let (of_slam, of_reference) = (&slam.features, &reference.features);
    if of_slam.n_wall_points() < MIN_WALL_POINTS || of_reference.n_wall_points() < MIN_WALL_POINTS {
        return None;
    }
    let mut random = RandomGenerator::new(1);
    let slam_points = of_slam.drawn_wall_points(&mut random, N_TRACKED_POINTS);
    let reference_points = drawn_evenly(of_reference.wall_points(), N_TRACKED_POINTS, &mut random);
    let slam_cells = SlamCells::drawn(&of_slam.raster, N_TRACKED_CELLS, N_TRACKED_CELLS);
    let start = between_cells(reference, slam, last);
    let refined =
        refined(of_reference, &slam_points, start, &TRACKING_SCALES_M)?.with_distortion(of_reference, &slam_points);
    let maps = ComparedMaps {
        slam: of_slam,
        reference: of_reference,
        slam_points: &slam_points,
        reference_points: &reference_points,
        slam_cells: &slam_cells,
        scans: true,
    };
    let evidence = evidence(&maps, &refined.pose);
    let candidate = Candidate::new(refined, evidence);
    let is_near = is_same_pose(&refined.pose, &start, of_slam.centre);
    (is_near && is_borne_out(&evidence)).then(|| AlignedPose::of(at, reference, slam, &candidate))
}
