//! Motions of the plane from a SLAM map's corner to the reference's.

use crate::thresholds::{SAME_M, SAME_RAD};
use std::f64::consts::{PI, TAU};

/// `p_reference = R(yaw) p_slam + t`, with both in metres from their map's lower left corner.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Pose {
    pub(crate) t: [f64; 2],
    pub(crate) yaw_rad: f64,
    cos: f64,
    sin: f64,
}

impl Pose {
    pub(crate) fn new(t: [f64; 2], yaw_rad: f64) -> Self {
        let (sin, cos) = libm::sincos(yaw_rad);
        Self { t, yaw_rad, cos, sin }
    }

    pub(crate) fn turn(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        [self.cos * x - self.sin * y, self.sin * x + self.cos * y]
    }

    pub(crate) fn apply(&self, p: [f64; 2]) -> [f64; 2] {
        let [x, y] = self.turn(p);
        [x + self.t[0], y + self.t[1]]
    }

    /// Back from the reference.
    pub(crate) fn undo(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let d = [x - self.t[0], y - self.t[1]];
        [self.cos * d[0] + self.sin * d[1], -self.sin * d[0] + self.cos * d[1]]
    }

    /// Followed by a small motion around a point of the reference.
    pub(crate) fn moved(&self, [dx, dy, turn_rad]: [f64; 3], about: [f64; 2]) -> Self {
        let small = Self::new([0.0; 2], turn_rad);
        let d = small.turn([self.t[0] - about[0], self.t[1] - about[1]]);
        Self::new([about[0] + dx + d[0], about[1] + dy + d[1]], wrapped(self.yaw_rad + turn_rad))
    }

    /// True if it moves a point of the SLAM map to the same place, and turns as far.
    pub(crate) fn is_same(&self, other: &Self, about: [f64; 2]) -> bool {
        let (a, b) = (self.apply(about), other.apply(about));
        libm::hypot(a[0] - b[0], a[1] - b[1]) <= SAME_M && wrapped(self.yaw_rad - other.yaw_rad).abs() <= SAME_RAD
    }
}

/// From -pi to pi.
pub(crate) fn wrapped(angle_rad: f64) -> f64 {
    let turn = libm::fmod(angle_rad + PI, TAU);
    if turn < 0.0 { turn + PI } else { turn - PI }
}
