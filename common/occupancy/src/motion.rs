//! Motions of the plane between maps, and covariances that they carry along.

use messages::PoseRecord;
use std::f64::consts::{PI, TAU};

/// `p_reference = R(yaw) p_slam + t`, with both in metres from their map's lower left corner.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pose {
    /// The translation, in metres.
    pub t: [f64; 2],
    /// The rotation, in radians.
    pub yaw_rad: f64,
    cos: f64,
    sin: f64,
}

impl Pose {
    /// From a translation and a rotation.
    pub fn new(t: [f64; 2], yaw_rad: f64) -> Self {
        let (sin, cos) = libm::sincos(yaw_rad);
        Self { t, yaw_rad, cos, sin }
    }

    /// Turns a direction.
    pub fn turn(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        [self.cos * x - self.sin * y, self.sin * x + self.cos * y]
    }

    /// Moves a point.
    pub fn apply(&self, p: [f64; 2]) -> [f64; 2] {
        let [x, y] = self.turn(p);
        [x + self.t[0], y + self.t[1]]
    }

    /// Back from the reference.
    pub fn undo(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let d = [x - self.t[0], y - self.t[1]];
        [self.cos * d[0] + self.sin * d[1], -self.sin * d[0] + self.cos * d[1]]
    }

    /// Followed by a small motion around a point of the reference.
    pub fn moved(&self, [dx, dy, turn_rad]: [f64; 3], about: [f64; 2]) -> Self {
        let small = Self::new([0.0; 2], turn_rad);
        let d = small.turn([self.t[0] - about[0], self.t[1] - about[1]]);
        Self::new([about[0] + dx + d[0], about[1] + dy + d[1]], wrapped(self.yaw_rad + turn_rad))
    }
}

/// From -pi to pi.
pub fn wrapped(angle_rad: f64) -> f64 {
    let turn = libm::fmod(angle_rad + PI, TAU);
    if turn < 0.0 { turn + PI } else { turn - PI }
}

/// A motion of the plane: `p_map = R(yaw) p_slam + (x, y)`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MapFromSlam {
    /// Metres.
    pub x_m: f64,
    /// Metres.
    pub y_m: f64,
    /// Radians, -pi to pi.
    pub yaw_rad: f64,
}

impl MapFromSlam {
    /// Moves a point.
    pub fn apply(&self, p: [f64; 2]) -> [f64; 2] {
        Pose::new([self.x_m, self.y_m], self.yaw_rad).apply(p)
    }

    /// The motion back: x, y, yaw of `slam_from_map`.
    pub fn inverse(&self) -> [f64; 3] {
        let [x, y] = Pose::new([self.x_m, self.y_m], self.yaw_rad).undo([0.0; 2]);
        [x, y, wrapped(-self.yaw_rad)]
    }
}

impl From<&PoseRecord> for MapFromSlam {
    fn from(record: &PoseRecord) -> Self {
        let [x_m, y_m, yaw_rad] = record.map_from_slam;
        Self { x_m, y_m, yaw_rad }
    }
}

/// The covariance at a place that lies `d` from that where it holds: a small turn moves it across.
pub fn transported(covariance: &[[f64; 3]; 3], d: [f64; 2]) -> [[f64; 3]; 3] {
    congruent(&[[1.0, 0.0, -d[1]], [0.0, 1.0, d[0]], [0.0, 0.0, 1.0]], covariance)
}

/// A covariance in other coordinates: `j c jT`.
pub fn congruent(j: &[[f64; 3]; 3], covariance: &[[f64; 3]; 3]) -> [[f64; 3]; 3] {
    let product = |a: &[[f64; 3]; 3], b: &[[f64; 3]; 3]| {
        [0, 1, 2].map(|r| [0, 1, 2].map(|c| (0..3).map(|k| a[r][k] * b[k][c]).sum::<f64>()))
    };
    let transposed = [0, 1, 2].map(|r| [0, 1, 2].map(|c| j[c][r]));
    product(&product(j, covariance), &transposed)
}
