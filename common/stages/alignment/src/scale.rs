//! Estimates the scale of a SLAM map relative to the model.

use crate::features::Features;
use crate::pose::{Pose, moved};
use crate::refine::{Normal, matches};
use crate::thresholds::MAX_SCALE;
use crate::wall_points::WallPoint;

/// Lengths of a SLAM map as a share of the model's.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scale {
    /// 1 if they are right, 1.02 if the map is 2 % too large.
    pub value: f64,
    /// Standard deviation.
    pub deviation: f64,
}

/// Residuals count up to about so far, in metres.
const WITHIN_M: f64 = 0.2;
const TIMES: usize = 8;
const STILL: f64 = 1e-6;

/// The scale at which the wall points of a SLAM map lie best on the reference, from a pose that fits; `None` if too little matches, or if
/// nothing holds it, as where two walls meet and no other is seen.
pub(crate) fn scale(reference: &Features, slam: &Features, wall_points: &[WallPoint], start: &Pose) -> Option<Scale> {
    let (mut pose, mut factor, middle) = (*start, 1.0, slam.centre);
    let mut deviation = f64::INFINITY;
    for _ in 0..TIMES {
        let grown = |at: [f64; 2]| [0, 1].map(|k| middle[k] + factor * (at[k] - middle[k]));
        let placed = |wall_point: &WallPoint| (pose.apply(grown(wall_point.at)), pose.rotate(wall_point.normal));
        let found = matches(reference, wall_points, WITHIN_M, placed)?;
        let about = pose.apply(middle);
        let normal = Normal::of(&found, |m| {
            let ([nx, ny], d) = (m.normal, [m.at[0] - about[0], m.at[1] - about[1]]);
            [nx, ny, ny * d[0] - nx * d[1], (nx * d[0] + ny * d[1]) / factor]
        });
        let [dx, dy, turn_rad, more] = normal.solved()?.into();
        pose = moved(&pose, [dx, dy, turn_rad], about);
        factor += more;
        if !(1.0 / MAX_SCALE..=MAX_SCALE).contains(&factor) {
            return None;
        }
        deviation = normal.covariance()?[(3, 3)].max(0.0).sqrt();
        if more.abs() < STILL {
            break;
        }
    }
    // What has to grow was too small.
    Some(Scale { value: 1.0 / factor, deviation: deviation / (factor * factor) })
}
