//! Global pose search: candidates, refinement, distinct results.

use crate::corner_voting::voted;
use crate::correlation::correlated;
use crate::features::Features;
use crate::pose::{Pose, is_same_pose, moved};
use crate::random_generator::RandomGenerator;
use crate::refine::{FINE, NARROW, Refined, SOFT, TIGHT, WIDE, refined};
use crate::rotations::turns;
use crate::score::{ComparedMaps, SlamCells, evidence};
use crate::thresholds::{MIN_WALL_POINTS, N_REFINED, SOFT_ADVANTAGE};
use crate::wall_points::WallPoint;
use frames::wrapped;
use messages::PoseEvidence;

/// Wall points and cells that are drawn.
const N_WALL_POINTS: usize = 1500;
const N_REFERENCE_POINTS: usize = 3000;
const N_OCCUPIED_CELLS: usize = 2000;
const N_FREE_CELLS: usize = 3000;
/// Those that poses are compared by at first.
const N_COARSE_POINTS: usize = 500;
const N_COARSE_REFERENCE_POINTS: usize = 800;
const COARSE_CELL_STEP: usize = 4;

/// A pose with its score.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Candidate {
    pub(crate) refined: Refined,
    pub(crate) evidence: PoseEvidence,
}

/// An initial guess of the pose, with bounds.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PoseGuess {
    pub(crate) pose: Pose,
    pub(crate) radius_m: f64,
    pub(crate) radius_rad: f64,
}

impl PoseGuess {
    /// True if it moves a point of the SLAM map to about the same place, and turns about as far.
    fn holds(&self, pose: &Pose, about: [f64; 2]) -> bool {
        let (a, b) = (self.pose.apply(about), pose.apply(about));
        libm::hypot(a[0] - b[0], a[1] - b[1]) <= self.radius_m
            && wrapped(self.pose.yaw_rad() - pose.yaw_rad()).abs() <= self.radius_rad
    }

    /// The guess, and poses around it from which a refinement reaches all that is near.
    fn poses(&self, about: [f64; 2]) -> Vec<Pose> {
        let steps = |radius: f64, step: f64| ((radius / step).ceil() as i32).min(MAX_STEPS);
        let (n, n_turns) = (steps(self.radius_m, STEP_M), steps(self.radius_rad, STEP_RAD));
        let part = |k: i32, n: i32, radius: f64| if n == 0 { 0.0 } else { f64::from(k) / f64::from(n) * radius };
        let middle = self.pose.apply(about);
        let mut poses = Vec::new();
        for turn in -n_turns..=n_turns {
            for y in -n..=n {
                for x in -n..=n {
                    let step =
                        [part(x, n, self.radius_m), part(y, n, self.radius_m), part(turn, n_turns, self.radius_rad)];
                    poses.push(moved(&self.pose, step, middle));
                }
            }
        }
        poses
    }
}

/// Distance between the poses that are tried around a guess, and how many at most to each side.
const STEP_M: f64 = 0.5;
const STEP_RAD: f64 = 0.1;
const MAX_STEPS: i32 = 4;

/// The poses in which a SLAM map fits a reference best, best first: anywhere, or near a guess. None if the reference shows too
/// little.
pub(crate) fn search(reference: &Features, slam: &Features, near: Option<&PoseGuess>) -> Vec<Candidate> {
    if reference.wall_points.len() < MIN_WALL_POINTS {
        return Vec::new();
    }
    let turns = turns(slam.directions(), reference.directions());
    let mut poses = voted(slam.corners(), reference.corners(), &turns);
    poses.extend(correlated(slam, reference, &turns));
    let about = slam.centre;
    if let Some(near) = near {
        poses.retain(|pose| near.holds(pose, about));
        poses.extend(near.poses(about));
    }
    let mut candidates = candidates(reference, slam, &poses);
    if let Some(near) = near {
        candidates.retain(|c| near.holds(&c.refined.pose, about));
    }
    candidates
}

/// Refines all poses roughly and the best exactly; best first, no two the same.
fn candidates(reference: &Features, slam: &Features, poses: &[Pose]) -> Vec<Candidate> {
    let mut random = RandomGenerator::new(1);
    let pick = |numbers: Vec<u32>, wall_points: &[WallPoint]| {
        numbers.into_iter().map(|k| wall_points[k as usize]).collect::<Vec<_>>()
    };
    let slam_points = sampled_points(slam, &mut random);
    let reference_points =
        pick(random.draw(reference.wall_points.iter().map(|_| 1.0), N_REFERENCE_POINTS), &reference.wall_points);
    let few = pick(random.draw(slam_points.iter().map(|_| 1.0), N_COARSE_POINTS), &slam_points);
    let few_reference_points =
        pick(random.draw(reference_points.iter().map(|_| 1.0), N_COARSE_REFERENCE_POINTS), &reference_points);
    let slam_cells = SlamCells::drawn(&slam.raster, &mut random, N_OCCUPIED_CELLS, N_FREE_CELLS);
    let few_cells = slam_cells.thinned(COARSE_CELL_STEP);
    let maps = ComparedMaps {
        slam,
        reference,
        slam_points: &slam_points,
        reference_points: &reference_points,
        slam_cells: &slam_cells,
        scans: false,
    };
    let rough =
        ComparedMaps { slam_points: &few, reference_points: &few_reference_points, slam_cells: &few_cells, ..maps };
    let about = slam.centre;
    let refined_with = |maps: &ComparedMaps<'_>, pose: &Pose, scales: &[f64]| {
        let refined = refined(reference, maps.slam_points, *pose, scales)?;
        Some(Candidate { refined, evidence: evidence(maps, &refined.pose) })
    };
    let coarse = poses.iter().flat_map(|pose| [&WIDE[..], &NARROW].map(|scales| refined_with(&rough, pose, scales)));
    let coarse = distinct(coarse.flatten().collect(), about);
    let exact = coarse.into_iter().take(N_REFINED).filter_map(|c| {
        let log_odds = |candidate: &Candidate| candidate.evidence.log_odds;
        let tried = [&TIGHT[..], &FINE].map(|scales| refined_with(&maps, &c.refined.pose, scales));
        let sharp = tried.into_iter().flatten().reduce(|a, b| if log_odds(&b) > log_odds(&a) { b } else { a });
        match (sharp, refined_with(&maps, &c.refined.pose, &SOFT)) {
            (Some(sharp), Some(soft)) if log_odds(&soft) > log_odds(&sharp) + SOFT_ADVANTAGE => Some(soft),
            (sharp, soft) => sharp.or(soft),
        }
    });
    let mut exact = distinct(exact.collect(), about);
    for candidate in &mut exact {
        candidate.refined = candidate.refined.with_distortion(reference, &slam_points);
    }
    exact
}

/// The wall points of a SLAM map that are compared.
pub(crate) fn sampled_points(slam: &Features, random: &mut RandomGenerator) -> Vec<WallPoint> {
    let numbers = random.draw(slam.wall_points.iter().map(|f| f.weight), N_WALL_POINTS);
    numbers.into_iter().map(|k| slam.wall_points[k as usize]).collect()
}

/// Best first, without those that are the same as a better one.
fn distinct(mut candidates: Vec<Candidate>, about: [f64; 2]) -> Vec<Candidate> {
    candidates.sort_by(|a, b| b.evidence.log_odds.total_cmp(&a.evidence.log_odds));
    let mut kept: Vec<Candidate> = Vec::new();
    for candidate in candidates {
        if !kept.iter().any(|k| is_same_pose(&k.refined.pose, &candidate.refined.pose, about)) {
            kept.push(candidate);
        }
    }
    kept
}
