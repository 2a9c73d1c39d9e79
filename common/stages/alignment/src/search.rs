//! Global pose search: candidates, refinement, distinct results.

use crate::candidate::Candidate;
use crate::candidates::candidates;
use crate::corner_voting::voted;
use crate::correlation::{OtherFace, correlated};
use crate::features::Features;
use crate::pose::{Pose, is_within, moved};
use crate::rotations::turns;
use crate::thresholds::{MIN_WALL_POINTS, N_CORRELATED};
use frames::wrapped;

/// Poses that differ by less are refined to the same.
const START_M: f64 = 0.15;
const START_RAD: f64 = 0.015;

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
pub(crate) fn search(
    reference: &Features,
    slam: &Features,
    near: Option<&PoseGuess>,
    earlier: &[Pose],
) -> Vec<Candidate> {
    if reference.n_wall_points() < MIN_WALL_POINTS {
        return Vec::new();
    }
    let turns = turns(slam.directions(), reference.directions());
    let mut poses = earlier.to_vec();
    poses.extend(voted(slam.corners(), reference.corners(), &turns));
    poses.extend(correlated(slam, slam.wall_points(), reference, &turns, OtherFace::Against, N_CORRELATED));
    let about = slam.centre;
    let mut apart: Vec<Pose> = Vec::with_capacity(poses.len());
    for pose in poses {
        if !apart.iter().any(|other| is_within(other, &pose, about, START_M, START_RAD)) {
            apart.push(pose);
        }
    }
    let mut poses = apart;
    if let Some(near) = near {
        poses.retain(|pose| near.holds(pose, about));
        poses.extend(near.poses(about));
    }
    let mut candidates = candidates(reference, slam, &poses, near.is_none());
    if let Some(near) = near {
        candidates.retain(|c| near.holds(&c.refined.pose, about));
    }
    candidates
}
