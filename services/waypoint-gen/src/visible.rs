//! Which faces a scan sees.

use crate::face::{Face, Faces};
use grid::Sight;
use messages::ScanSensor;
use std::f64::consts::{PI, TAU};

/// What a sensor manages, in cells.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Reach {
    range: f64,
    min_range_squared: f64,
    /// Squared cosine of the largest angle of incidence.
    cos_squared: f64,
    half_view_rad: f64,
}

/// A place in cells, and a heading where that matters.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Pose {
    pub(crate) at: [f64; 2],
    pub(crate) yaw_rad: f64,
}

impl Reach {
    pub(crate) fn of(sensor: &ScanSensor, resolution_m: f64) -> Self {
        let cells = |m: f64| m / resolution_m;
        let cos = libm::cos(sensor.max_incidence_rad.clamp(0.0, PI / 2.0)).max(0.0);
        Self {
            range: cells(sensor.range_m),
            min_range_squared: cells(sensor.min_range_m) * cells(sensor.min_range_m),
            cos_squared: cos * cos,
            half_view_rad: if sensor.sees_around() { f64::INFINITY } else { sensor.field_of_view_rad / 2.0 },
        }
    }

    /// Faces that are seen from a place if the sensor looks everywhere, ascending: those whose middle is in range, at which
    /// the ray and the normal are not too far apart, and to which a straight line leads through free cells.
    pub(crate) fn seen_around(&self, sight: &Sight, faces: &Faces, at: [f64; 2]) -> Vec<u32> {
        let candidates = faces.near(at, self.range);
        candidates.filter(|&k| self.is_seen(sight, &faces.all[k as usize], at)).collect()
    }

    /// Those of the faces, seen from the pose's place, that lie in the field of view.
    pub(crate) fn in_view(&self, faces: &Faces, seen: &[u32], pose: Pose) -> Vec<u32> {
        let is_in_view = |&&k: &&u32| {
            let middle = faces.all[k as usize].middle;
            let bearing = libm::atan2(middle[1] - pose.at[1], middle[0] - pose.at[0]);
            turn_between(bearing, pose.yaw_rad) <= self.half_view_rad
        };
        seen.iter().filter(is_in_view).copied().collect()
    }

    fn is_seen(&self, sight: &Sight, face: &Face, at: [f64; 2]) -> bool {
        let d = [at[0] - face.middle[0], at[1] - face.middle[1]];
        let squared = d[0] * d[0] + d[1] * d[1];
        let along = d[0] * face.normal[0] + d[1] * face.normal[1];
        let in_front = d[0] * f64::from(face.side[0]) + d[1] * f64::from(face.side[1]) > 0.0;
        in_front
            && along > 0.0
            && self.min_range_squared <= squared
            && squared <= self.range * self.range
            && along * along >= self.cos_squared * squared
            && sight.is_clear(at, face.middle)
    }
}

/// Size of the turn from one heading to another, 0 to pi.
pub(crate) fn turn_between(a_rad: f64, b_rad: f64) -> f64 {
    let turn = libm::fabs(libm::fmod(a_rad - b_rad, TAU));
    turn.min(TAU - turn)
}
