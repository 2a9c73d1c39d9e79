//! Errors of the robot's places, as they come from odometry and are partly taken back by SLAM.

use super::drive::Drive;
use crate::plane::{Vector, difference, direction_of, distance, left_of, moved, scaled, sum, turned};
use crate::random_generator::RandomGenerator;
use crate::strengths::Strengths;
use frames::{Map, Rigid2, Slam, wrapped};
use serde::Serialize;

/// Directions count as much in the fit as places this far away: what the lidar sees is around the robot.
const LEVER_M: f64 = 3.0;
/// Drives of this length and more bend as much as their strength says.
const FULL_WAY_M: f64 = 60.0;
const MAX_YAW_RAD: f64 = 2.0 * std::f64::consts::PI / 180.0;
/// A robot knows a place again if it is this close to it, after this many scans.
const SAME_PLACE_M: f64 = 1.5;
const SCANS_BETWEEN: usize = 25;

/// Where the robot believes that it scanned, in the frame of its map.
#[derive(Debug, Clone)]
pub(crate) struct BelievedDrive {
    pub(crate) places: Vec<Vector>,
    pub(crate) headings: Vec<Vector>,
    /// The best rigid fit of believed to true poses.
    pub(crate) map_from_slam: Rigid2<Map, Slam>,
    pub(crate) residual: Residual,
}

/// What no rigid motion takes away between believed and true poses.
#[derive(Debug, Clone, Default, Serialize)]
pub struct Residual {
    /// Root mean square of the offsets of places.
    pub residual_m: f64,
    /// The largest of them.
    pub residual_max_m: f64,
    /// The largest of the angles.
    pub residual_max_deg: f64,
}

/// Offset and yaw of a believed pose from the true one.
#[derive(Debug, Clone, Copy, Default)]
struct PoseError {
    offset: Vector,
    yaw_rad: f64,
}

/// Believed poses in a frame of its own, which is anywhere: after each of these numbers of scans those until then.
///
/// If it bends back, a place that is known again moves what was mapped since it was first seen, as SLAM with a graph of poses
/// does; else only what is mapped from then on.
pub(crate) fn believed(
    drive: &Drive,
    ends: &[usize],
    bends_back: bool,
    strengths: &Strengths,
    random: &mut RandomGenerator,
) -> Vec<BelievedDrive> {
    let pi = std::f64::consts::PI;
    let slam_from_map =
        Rigid2::new([random.between(-40.0, 40.0), random.between(-40.0, 40.0)], random.between(-pi, pi));
    let after = drifted(drive, ends, bends_back, strengths, random);
    let errors = &after[after.len() - 1];
    let share = (drive.whole_way_m / FULL_WAY_M).min(1.0);
    let (wanted_m, wanted_rad) = (strengths.bend_m * share, MAX_YAW_RAD * share);
    // The errors as drawn are of any size, and the fit turns with them: scaled more than once.
    let mut scale = 1.0;
    for _ in 0..3 {
        scale *= scale_for(wanted_m, wanted_rad, &fit(drive, errors, scale).1);
    }
    after.iter().map(|errors| located(&drive.begin(errors.len()), errors, &slam_from_map, scale)).collect()
}

/// What makes a residual as large as wanted, in metres or in radians, whichever is less.
fn scale_for(wanted_m: f64, wanted_rad: f64, residual: &Residual) -> f64 {
    if residual.residual_max_m < 1e-9 {
        return 0.0;
    }
    let by_yaw = wanted_rad / residual.residual_max_deg.to_radians().max(1e-9);
    (wanted_m / residual.residual_max_m).min(by_yaw)
}

/// A yaw rate that wanders and a wrong wheel size, integrated along the way; known places take errors back. The errors until
/// each of these numbers of scans, as they are then; all of them at last.
fn drifted(
    drive: &Drive,
    ends: &[usize],
    bends_back: bool,
    strengths: &Strengths,
    random: &mut RandomGenerator,
) -> Vec<Vec<PoseError>> {
    let mut after: Vec<Vec<PoseError>> = Vec::new();
    let mut errors = vec![PoseError::default()];
    let (mut rate, stretch) = (0.0, 0.006 * random.normal());
    for k in 1..drive.places.len() {
        ends.iter().filter(|end| **end == k).for_each(|_| after.push(errors.clone()));
        let step = difference(drive.places[k], drive.places[k - 1]);
        let way = distance(drive.places[k], drive.places[k - 1]);
        rate = 0.995 * rate + 2e-4 * random.normal();
        let mut error = errors[k - 1];
        error.offset = moved(error.offset, left_of(step), error.yaw_rad);
        error.offset = moved(error.offset, step, stretch);
        error.yaw_rad += rate * way;
        let before = (0..k.saturating_sub(SCANS_BETWEEN))
            .map(|j| (distance(drive.places[j], drive.places[k]), j))
            .min_by(|a, b| a.0.total_cmp(&b.0));
        if let Some((_, j)) = before.filter(|b| b.0 < SAME_PLACE_M) {
            let pull = 0.5 * strengths.loop_correction;
            let known = errors[j];
            let (step_back, turn_back) = (difference(known.offset, error.offset), known.yaw_rad - error.yaw_rad);
            error.offset = moved(error.offset, step_back, pull);
            error.yaw_rad += pull * turn_back;
            for (i, earlier) in errors.iter_mut().enumerate().skip(j + 1).filter(|_| bends_back) {
                let share = pull * (i - j) as f64 / (k - j) as f64;
                earlier.offset = moved(earlier.offset, step_back, share);
                earlier.yaw_rad += share * turn_back;
            }
        }
        errors.push(error);
    }
    ends.iter().filter(|end| **end == errors.len()).for_each(|_| after.push(errors.clone()));
    after
}

/// The pose of map in the frame of errors that fits best, and what is left.
fn fit(drive: &Drive, errors: &[PoseError], scale: f64) -> (Rigid2<Map, Map>, Residual) {
    let wrong: Vec<(Vector, Vector)> = drive
        .places
        .iter()
        .zip(&drive.headings)
        .zip(errors)
        .map(|((place, heading), e)| {
            (moved(*place, e.offset, scale), turned(*heading, direction_of(scale * e.yaw_rad)))
        })
        .collect();
    // Each pose as two points, before and behind the robot.
    let points = |place: Vector, heading: Vector| [LEVER_M, -LEVER_M].map(|far| moved(place, heading, far));
    let pairs: Vec<(Vector, Vector)> = wrong
        .iter()
        .zip(drive.places.iter().zip(&drive.headings))
        .flat_map(|(w, (place, heading))| {
            let (from, to) = (points(w.0, w.1), points(*place, *heading));
            [(from[0], to[0]), (from[1], to[1])]
        })
        .collect();
    let motion = best_motion(&pairs);
    let mut residual = Residual::default();
    for (w, (place, heading)) in wrong.iter().zip(drive.places.iter().zip(&drive.headings)) {
        let off = distance(motion.apply(w.0), *place);
        let turned_heading = motion.rotate(w.1);
        let yaw = yaw_of(turned_heading) - yaw_of(*heading);
        residual.residual_m += off * off / wrong.len() as f64;
        residual.residual_max_m = residual.residual_max_m.max(off);
        residual.residual_max_deg = residual.residual_max_deg.max(wrapped(yaw).abs().to_degrees());
    }
    residual.residual_m = residual.residual_m.sqrt();
    (motion, residual)
}

fn yaw_of(direction: Vector) -> f64 {
    libm::atan2(direction[1], direction[0])
}

/// The rigid motion that takes the first points of pairs closest to the second, by least squares.
fn best_motion(pairs: &[(Vector, Vector)]) -> Rigid2<Map, Map> {
    let n = 1.0 / pairs.len() as f64;
    let from = scaled(pairs.iter().fold([0.0; 2], |s, p| sum(s, p.0)), n);
    let to = scaled(pairs.iter().fold([0.0; 2], |s, p| sum(s, p.1)), n);
    let (mut sin, mut cos) = (0.0, 0.0);
    for (a, b) in pairs {
        let (a, b) = (difference(*a, from), difference(*b, to));
        cos += a[0] * b[0] + a[1] * b[1];
        sin += a[0] * b[1] - a[1] * b[0];
    }
    let yaw_rad = libm::atan2(sin, cos);
    let turn = Rigid2::<Map, Map>::new([0.0; 2], yaw_rad);
    Rigid2::new(difference(to, turn.rotate(from)), yaw_rad)
}

fn located(drive: &Drive, errors: &[PoseError], slam_from_map: &Rigid2<Slam, Map>, scale: f64) -> BelievedDrive {
    let (right_from_wrong, residual) = fit(drive, errors, scale);
    let place = |(place, e): (&Vector, &PoseError)| slam_from_map.apply(moved(*place, e.offset, scale));
    let heading =
        |(heading, e): (&Vector, &PoseError)| slam_from_map.rotate(turned(*heading, direction_of(scale * e.yaw_rad)));
    BelievedDrive {
        places: drive.places.iter().zip(errors).map(place).collect(),
        headings: drive.headings.iter().zip(errors).map(heading).collect(),
        map_from_slam: &right_from_wrong * &slam_from_map.inverse(),
        residual,
    }
}
