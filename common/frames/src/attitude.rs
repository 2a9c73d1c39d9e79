//! Attitude of a robot that stands on a slope, from its heading and the normal of the ground.

/// The normal of level ground.
pub const UPRIGHT: [f64; 3] = [0.0, 0.0, 1.0];

/// How a robot stands in a frame whose Z is up: its heading, and the axis of the robot that is up for it.
///
/// Yaw, pitch and roll as REP 103 has them: the heading in plan is the yaw, whatever the slope, and what reads the yaw of the
/// quaternion reads `yaw_rad`.
///
/// ```
/// use frames::{Attitude, UPRIGHT};
///
/// let level = Attitude { yaw_rad: 0.0, up: UPRIGHT };
/// assert_eq!(level.quaternion(), [0.0, 0.0, 0.0, 1.0]);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Attitude {
    /// Angle of the heading in plan.
    pub yaw_rad: f64,
    /// Unit vector, less than a quarter turn off Z.
    pub up: [f64; 3],
}

impl Attitude {
    /// True unless the robot stands upright.
    pub fn is_tilted(&self) -> bool {
        self.up[0] != 0.0 || self.up[1] != 0.0
    }

    /// The unit quaternion (x, y, z, w) that turns axes of the robot into those of the frame; a turn about Z alone if it stands upright.
    pub fn quaternion(&self) -> [f64; 4] {
        let (sin_yaw, cos_yaw) = libm::sincos(self.yaw_rad / 2.0);
        if !self.is_tilted() {
            return [0.0, 0.0, sin_yaw, cos_yaw];
        }
        let [pitch_rad, roll_rad] = self.pitch_and_roll_rad();
        let ((sin_pitch, cos_pitch), (sin_roll, cos_roll)) =
            (libm::sincos(pitch_rad / 2.0), libm::sincos(roll_rad / 2.0));
        [
            sin_roll * cos_pitch * cos_yaw - cos_roll * sin_pitch * sin_yaw,
            cos_roll * sin_pitch * cos_yaw + sin_roll * cos_pitch * sin_yaw,
            cos_roll * cos_pitch * sin_yaw - sin_roll * sin_pitch * cos_yaw,
            cos_roll * cos_pitch * cos_yaw + sin_roll * sin_pitch * sin_yaw,
        ]
    }

    /// A direction of the frame along the axes of the robot: forward, left, up.
    pub fn in_robot(&self, direction: [f64; 3]) -> [f64; 3] {
        let (sin_yaw, cos_yaw) = libm::sincos(self.yaw_rad);
        let [pitch_rad, roll_rad] = self.pitch_and_roll_rad();
        let ((sin_pitch, cos_pitch), (sin_roll, cos_roll)) = (libm::sincos(pitch_rad), libm::sincos(roll_rad));
        let [x, y, z] = direction;
        let [ahead, left] = [cos_yaw * x + sin_yaw * y, cos_yaw * y - sin_yaw * x];
        let below = sin_pitch * ahead + cos_pitch * z;
        [cos_pitch * ahead - sin_pitch * z, cos_roll * left + sin_roll * below, cos_roll * below - sin_roll * left]
    }

    /// The turns about the left axis and then the forward one that bring Z to `up`, after that about Z.
    fn pitch_and_roll_rad(&self) -> [f64; 2] {
        let (sin, cos) = libm::sincos(self.yaw_rad);
        let [x, y, z] = self.up;
        let [ahead, left] = [cos * x + sin * y, cos * y - sin * x];
        [libm::atan2(ahead, z), libm::atan2(-left, libm::hypot(ahead, z))]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Quaternion, UnitQuaternion, Vector3};

    fn turned(attitude: &Attitude, axis: [f64; 3]) -> Vector3<f64> {
        let [x, y, z, w] = attitude.quaternion();
        UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z)) * Vector3::from(axis)
    }

    #[test]
    fn a_robot_on_a_slope_heads_in_plan_where_its_yaw_says_and_its_up_is_the_normal() {
        for (yaw_deg, climb, across) in [(0.0, 0.3, 0.0), (30.0, -0.2, 0.1), (-170.0, 0.05, -0.4), (90.0, 0.0, 0.25)] {
            let yaw_rad = f64::to_radians(yaw_deg);
            let length = libm::sqrt(1.0f64 + climb * climb + across * across);
            let attitude = Attitude { yaw_rad, up: [-climb / length, -across / length, 1.0 / length] };
            let [ahead, left, up] =
                [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(|axis| turned(&attitude, axis));
            assert!((up - Vector3::from(attitude.up)).norm() < 1e-12, "{attitude:?}: {up}");
            assert!((libm::atan2(ahead.y, ahead.x) - yaw_rad).abs() < 1e-12, "{attitude:?}: {ahead}");
            // Along the heading the ground rises by its gradient.
            let rise = climb * libm::cos(yaw_rad) + across * libm::sin(yaw_rad);
            assert!((ahead.z / libm::hypot(ahead.x, ahead.y) - rise).abs() < 1e-12, "{attitude:?}: {ahead}");
            let direction = Vector3::new(0.3, -0.7, 0.2);
            let expected = [ahead, left, up].map(|axis| axis.dot(&direction));
            let found = attitude.in_robot(direction.into());
            assert!((0..3).all(|k| (found[k] - expected[k]).abs() < 1e-12), "{attitude:?}: {found:?}, {expected:?}");
        }
    }

    #[test]
    fn a_robot_that_stands_upright_is_turned_about_z_alone() {
        let [x, y, z, w] = Attitude { yaw_rad: -2.0, up: UPRIGHT }.quaternion();
        assert_eq!([x.to_bits(), y.to_bits()], [0; 2]);
        assert_eq!((z, w), (libm::sin(-1.0), libm::cos(-1.0)));
    }
}
