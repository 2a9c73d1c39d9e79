//! Angles within half a turn.

use std::f64::consts::{PI, TAU};

/// The same angle from -pi to pi, in radians; one that lies there already keeps every bit.
pub fn wrapped(angle_rad: f64) -> f64 {
    if (-PI..=PI).contains(&angle_rad) {
        return angle_rad;
    }
    let turn = libm::fmod(angle_rad + PI, TAU);
    if turn < 0.0 { turn + PI } else { turn - PI }
}
