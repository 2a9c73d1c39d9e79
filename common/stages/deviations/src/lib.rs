//! Deviations: site, schedule state and an aligned SLAM map in, observation and verdict of each element out.
//!
//! Every element is probed from samples on its sides, along their normals: a surface in its place, a surface beside it, or
//! free cells through the solid. A lidar sees the first surface only: a hidden side is unseen, and an element is absent only
//! where the robot saw through it. Leafs of a wall are seen as one, and a stretch of a wall that is seen through is an absent
//! part of it. The distortion of the SLAM map is estimated from surrounding surfaces and subtracted.
//!
//! ```text
//! groundplan deviations house.ifc --slam robot.yaml --date 2024-04-15
//! groundplan deviations house.ifc --slam robot.yaml --date 2024-04-15 -o deviations    # JSON, BCF 2.1, CSV, a picture
//! groundplan deviations                                                # of the running daemons, at the plan time
//! groundplan confirm 2O2Fr$t4X7Zf8NOew3FLOH                            # an element that the robot saw through
//! ```
//!
//! With `apply = true` in `[align]` of the site's configuration, an element that the robot sees before its time is on the
//! maps from then on. What seems absent stays on them until an operator confirms it; a confirmed element is off the maps
//! until it is seen.
//!
//! # Guarantees
//!
//! - Glass, doors, what is hidden and what does not cross the lidar's plane is unseen.
//! - A wall that is modelled as several leafs is seen as one: all of them are absent or displaced where its outer faces are.
//!   A leaf that others hide is unseen while the wall stands.
//! - A stretch of a wall that is seen through is an absent part of it, with its ends along the wall and in the map; the wall
//!   stays on the maps. Openings of the model are none.
//! - A surface before a wall whose place was not seen may be a row of furniture, and displaces nothing unless it is as long
//!   as a wall.
//! - A SLAM map that bends by more than 0.4 m is compared as its frame bends; below that drift around one pose, which is
//!   calibrated, follows it.
//! - A displacement is measured against the pose and against the distortion of the map around the element, which the other
//!   elements foretell with a covariance.
//! - The published pose stays rigid; `LocalTransform` carries places into a bent map beside it, and says where it knows no
//!   better than the pose.
//! - What seems absent opens no way until an operator confirms it.
//!
//! # Where
//!
//! - deviations: absent parts: `src/partial_absence.rs`
//! - deviations: absent, displaced, unseen: `src/evidence.rs`, `src/displacement.rs`, `src/thresholds.rs`
//! - deviations: distortion of a SLAM map: `src/distortion.rs`, `src/distortion_prior.rs`, `src/surface_pieces.rs`
//! - deviations: obstacles that the model lacks: `src/obstacles.rs`
//! - deviations: places carried into a bent SLAM map: `src/local_transform.rs`
//! - deviations: walls of several leafs: `src/wall_bodies.rs`, `src/side_samples.rs`

mod applied_observations;
mod deviation_verdict;
mod deviations_archive;
mod displacement;
mod distortion;
mod distortion_prior;
mod evidence;
mod input;
mod local_transform;
mod obstacles;
mod partial_absence;
mod probed_sample;
mod sampled_storey;
mod sections;
mod side_samples;
mod slam_view;
mod surface_pieces;
mod thresholds;
mod wall_bodies;

pub use applied_observations::AppliedObservations;
pub use input::DeviationInput;
pub use local_transform::{LocalTransform, SlamPlace};

use deviations_archive::Findings;
use evidence::{Comparison, Evidence, evidence};
use messages::ArchiveBuffer;
use obstacles::{KnownSurfaces, obstacles};
use partial_absence::AbsentPart;
use rayon::prelude::*;
use sampled_storey::SampledStorey;
use thresholds::OUTSIDE_M;

/// The evidence for every element of a storey, and the obstacles that the model lacks, as a `deviations` archive. Verdicts
/// use the planned states alone.
///
/// # Panics
/// If the site has no such map storey, or the schedule state is of another site.
pub fn deviations(input: &DeviationInput<'_>) -> ArchiveBuffer {
    let sampled = SampledStorey::of(input);
    let distortions = sampled.distortion_field(input);
    let SampledStorey { slam, sections, bodies, samples } = sampled;
    let n_cuts = sections.cuts.len() as u32;
    let pose_m = pose_deviation_m(input);
    let comparison = Comparison { sections: &sections, bodies: &bodies, slam: &slam, distortions: &distortions };
    let (all, parts): (Vec<Evidence>, Vec<Vec<AbsentPart>>) =
        (0..n_cuts).into_par_iter().map(|k| evidence(&comparison, k, &samples[k as usize])).unzip();
    let bounds = input.site.map_storeys[input.map_storey].bounds_tenths.map(frames::metres);
    let known = KnownSurfaces {
        sections: &sections,
        evidence: &all,
        distortions: &distortions,
        deviation_m: pose_m,
        bounds_m: [[bounds[0], bounds[1]].map(|c| c - OUTSIDE_M), [bounds[2], bounds[3]].map(|c| c + OUTSIDE_M)],
    };
    let (found, n_outside) = obstacles(input.site, &slam, &known);
    let found = Findings { evidence: &all, parts: &parts, obstacles: &found, n_outside };
    deviations_archive::archive(input, &slam, &sections, &distortions, &found)
}

/// Standard deviation of the pose at the corner of the storey with the largest.
fn pose_deviation_m(input: &DeviationInput<'_>) -> f64 {
    let about = input.motion().apply(input.about_m);
    let bounds = input.site.map_storeys[input.map_storey].bounds_tenths.map(frames::metres);
    let corners = [[0, 1], [0, 3], [2, 1], [2, 3]].map(|[x, y]| [bounds[x] - about[0], bounds[y] - about[1]]);
    corners.map(|d| input.covariance.transported(d).worst_m()).into_iter().fold(0.0, f64::max)
}
