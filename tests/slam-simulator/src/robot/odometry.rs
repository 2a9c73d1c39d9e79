//! Poses that a robot counts from the turns of its wheels: they drift from the true ones by a given share of the way.

use super::drive::Drive;
use crate::plane::{Vector, difference, direction_of, distance, scaled, sum, turned};
use crate::random_generator::RandomGenerator;
use frames::wrapped;

/// Drift is measured over parts of the way that are this long, or over all of a shorter way.
const PART_M: f64 = 10.0;
/// Errors before they are scaled to the drift that is wanted: of lengths, of yaw by length and by turns, and their noise.
const LENGTH_SHARE: f64 = 0.01;
const YAW_RAD_PER_M: f64 = 0.004;
const YAW_WANDER_RAD_PER_M: f64 = 0.002;
const YAW_SHARE: f64 = 0.015;
const NOISE_SHARE: f64 = 0.02;
/// Errors add up nearly in proportion: scaled so many times, they are as large as wanted.
const N_SCALINGS: usize = 5;

/// A pose of the odometry: in the frame in which the robot starts at the origin, along the first axis.
#[derive(Debug, Clone, Copy)]
pub(crate) struct OdometryPose {
    pub(crate) place: Vector,
    pub(crate) yaw_rad: f64,
}

/// A motion between two scans, in the frame of the first.
#[derive(Debug, Clone, Copy)]
struct Step {
    motion: Vector,
    turn_rad: f64,
}

/// The pose of each scan by odometry. Over 10 m of way it ends, in the mean, as far from the true place as `drift_share` says.
pub(crate) fn odometry(drive: &Drive, drift_share: f64, random: &mut RandomGenerator) -> Vec<OdometryPose> {
    let true_steps = steps(drive);
    let errors = errors(&true_steps, random);
    let mut scale = 1.0;
    for _ in 0..N_SCALINGS {
        let measured = drift(drive, &counted(&true_steps, &errors, scale));
        if measured > 0.0 {
            scale *= drift_share / measured;
        }
    }
    counted(&true_steps, &errors, scale)
}

/// Mean offset after 10 m of way, as a share of it: of the end of each part from its true place, seen from its begin.
pub(crate) fn drift(drive: &Drive, odometry: &[OdometryPose]) -> f64 {
    let whole_m = drive.way_m.last().copied().unwrap_or(0.0);
    let part_m = PART_M.min(whole_m);
    let (mut n, mut total) = (0usize, 0.0);
    for begin in 0..odometry.len() {
        let end = drive.way_m.partition_point(|m| *m < drive.way_m[begin] + part_m);
        if end >= odometry.len() || end == begin {
            break;
        }
        let true_end = turned(difference(drive.places[end], drive.places[begin]), back(drive.headings[begin]));
        let start = odometry[begin];
        let counted_end = turned(difference(odometry[end].place, start.place), direction_of(-start.yaw_rad));
        n += 1;
        total += distance(true_end, counted_end) / (drive.way_m[end] - drive.way_m[begin]);
    }
    total / n.max(1) as f64
}

/// The direction that undoes a turn.
fn back(direction: Vector) -> Vector {
    [direction[0], -direction[1]]
}

fn steps(drive: &Drive) -> Vec<Step> {
    let step = |k: usize| {
        let undone = back(drive.headings[k]);
        let motion = turned(difference(drive.places[k + 1], drive.places[k]), undone);
        let turn = turned(drive.headings[k + 1], undone);
        Step { motion, turn_rad: libm::atan2(turn[1], turn[0]) }
    };
    (0..drive.places.len().saturating_sub(1)).map(step).collect()
}

/// What is added to each step before it is scaled: wheels of wrong size and width, a yaw rate that wanders, and noise.
fn errors(steps: &[Step], random: &mut RandomGenerator) -> Vec<Step> {
    let length_share = LENGTH_SHARE * random.normal();
    let yaw_per_m = YAW_RAD_PER_M * random.normal();
    let yaw_share = YAW_SHARE * random.normal();
    let mut wander = 0.0;
    let error = |step: &Step| {
        let way_m = distance(step.motion, [0.0; 2]);
        wander = 0.98 * wander + 0.2 * YAW_WANDER_RAD_PER_M * random.normal();
        let turn_rad = (yaw_per_m + wander) * way_m + yaw_share * step.turn_rad;
        Step {
            motion: scaled(step.motion, length_share + NOISE_SHARE * random.normal()),
            turn_rad: turn_rad + NOISE_SHARE * step.turn_rad * random.normal(),
        }
    };
    steps.iter().map(error).collect()
}

fn counted(steps: &[Step], errors: &[Step], scale: f64) -> Vec<OdometryPose> {
    let mut pose = OdometryPose { place: [0.0; 2], yaw_rad: 0.0 };
    let mut poses = vec![pose];
    for (step, error) in steps.iter().zip(errors) {
        let motion = sum(step.motion, scaled(error.motion, scale));
        let place = sum(pose.place, turned(motion, direction_of(pose.yaw_rad)));
        pose = OdometryPose { place, yaw_rad: wrapped(pose.yaw_rad + step.turn_rad + scale * error.turn_rad) };
        poses.push(pose);
    }
    poses
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rounds in a square of 8 m, with a scan each 0.2 m and at each part of a turn.
    fn rounds(n_scans: usize) -> Drive {
        let place = |k: usize| {
            let (side, along) = (k / 40 % 4, (k % 40) as f64 * 0.2);
            [[along, 0.0], [8.0, along], [8.0 - along, 8.0], [0.0, 8.0 - along]][side]
        };
        let heading = |k: usize| [[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]][k / 40 % 4];
        let drive = Drive {
            places: (0..n_scans).map(place).collect(),
            headings: (0..n_scans).map(heading).collect(),
            covered: vec![1.0; n_scans],
            way_m: (0..n_scans).map(|k| 0.2 * k as f64).collect(),
            whole_way_m: 0.2 * (n_scans - 1) as f64,
            reachable_m2: 64.0,
        };
        drive.turning(20f64.to_radians())
    }

    #[test]
    fn odometry_drifts_by_the_share_of_the_way_that_was_asked_for() {
        for (seed, share) in [(1, 0.01), (2, 0.03), (3, 0.05), (4, 0.05)] {
            for n_scans in [30, 400] {
                let drive = rounds(n_scans);
                let odometry = odometry(&drive, share, &mut RandomGenerator::of(&[seed]));
                assert_eq!(odometry.len(), drive.places.len());
                let measured = drift(&drive, &odometry);
                assert!((measured - share).abs() < 0.1 * share, "{seed}, {n_scans} scans: {measured} for {share}");
            }
        }
    }

    #[test]
    fn odometry_without_drift_is_the_true_way_from_where_the_robot_started() {
        let drive = rounds(100);
        for (pose, place) in odometry(&drive, 0.0, &mut RandomGenerator::of(&[1])).iter().zip(&drive.places) {
            assert!(distance(pose.place, *place) < 1e-9);
        }
    }

    #[test]
    fn a_robot_that_turns_scans_at_each_part_of_the_turn() {
        let drive = rounds(100);
        assert_eq!(drive.places.len(), 100 + 2 * 4);
        let most = steps(&drive).iter().map(|s| s.turn_rad.abs()).fold(0.0, f64::max);
        assert!((most - 18f64.to_radians()).abs() < 1e-9, "{most}");
    }
}
