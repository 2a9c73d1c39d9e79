//! Deviations: site, schedule state and an aligned SLAM map in, what differs out.
//!
//! Every element is probed from samples on its sides, along their normals: a surface in its place, a surface beside it, or
//! free cells through the solid. A lidar sees the first surface only: what hides a side makes it unseen, and an element is
//! absent only where the robot saw through it. The distortion of the SLAM map is estimated from the surfaces around, and
//! taken off.
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

mod bend;
mod displaced;
mod evidence;
mod input;
mod judgement;
mod observed;
mod obstacles;
mod probed_sample;
mod sections;
mod sides;
mod slam_view;
mod thresholds;
mod written;

pub use input::DeviationInput;
pub use observed::Observed;

use bend::{Bends, Tie};
use evidence::{Evidence, evidence};
use messages::ArchiveBuffer;
use obstacles::{Explained, obstacles};
use rayon::prelude::*;
use sections::{Kind, Sections};
use sides::{Sample, open_samples};
use slam_view::{Probe, SlamView};
use thresholds::{MOST_BENT_M, OUTSIDE_M, SAME_SIDE_M};

/// The evidence for every element of a storey, and what stands there beside them, as a `deviations` archive. Judged by the planned
/// states alone.
///
/// # Panics
/// If the site has no such map storey, or the phase is of another site.
pub fn deviations(input: &DeviationInput<'_>) -> ArchiveBuffer {
    let slam = SlamView::new(input.slam, &input.map_from_slam);
    let sections = Sections::of(input.site, input.phase, input.robot, input.map_storey);
    let n_cuts = sections.cuts.len() as u32;
    let samples: Vec<Vec<Sample>> = (0..n_cuts).into_par_iter().map(|cut| open_samples(&sections, cut)).collect();
    let pose_m = pose_deviation_m(input);
    let bends = Bends::new(ties(&sections, &samples, &slam).into_iter(), pose_m);
    let all: Vec<Evidence> =
        (0..n_cuts).into_par_iter().map(|k| evidence(&sections, k, &samples[k as usize], &slam, &bends)).collect();
    let bounds = input.site.map_storeys[input.map_storey].bounds_tenths.map(frames::metres);
    let explained = Explained {
        sections: &sections,
        evidence: &all,
        bends: &bends,
        deviation_m: pose_m,
        bounds_m: [[bounds[0], bounds[1]].map(|c| c - OUTSIDE_M), [bounds[2], bounds[3]].map(|c| c + OUTSIDE_M)],
    };
    let (found, n_outside) = obstacles(input.site, &slam, &explained);
    written::archive(input, &slam, &sections, &all, &bends, &found, n_outside)
}

/// Surfaces beside sides that are planned to stand and stay where they are.
fn ties(sections: &Sections, samples: &[Vec<Sample>], slam: &SlamView) -> Vec<([f64; 2], Tie)> {
    let of_cut = |cut: u32| -> Vec<([f64; 2], Tie)> {
        let own = &sections.cuts[cut as usize];
        if !own.stands || own.kind != Kind::Solid {
            return Vec::new();
        }
        let tie = |s: &Sample| {
            let Sample { at, normal, thick_m } = *s;
            let met = slam.probe(&Probe { at, normal, thick_m, tolerance_m: SAME_SIDE_M });
            let nearest = met.offsets_m.into_iter().min_by(|a, b| a.abs().total_cmp(&b.abs()))?;
            (nearest.abs() <= MOST_BENT_M).then_some((at, Tie { normal, offset_m: nearest, cut }))
        };
        samples[cut as usize].iter().filter_map(tie).collect()
    };
    (0..samples.len() as u32).into_par_iter().flat_map_iter(of_cut).collect()
}

/// What the pose is uncertain by at the corner of the storey that lies farthest from where it is told for.
fn pose_deviation_m(input: &DeviationInput<'_>) -> f64 {
    let about = input.map_from_slam.apply(input.about_m);
    let bounds = input.site.map_storeys[input.map_storey].bounds_tenths.map(frames::metres);
    let corners = [[0, 1], [0, 3], [2, 1], [2, 3]].map(|[x, y]| [bounds[x] - about[0], bounds[y] - about[1]]);
    corners.map(|d| input.covariance.transported(d).worst_m()).into_iter().fold(0.0, f64::max)
}
