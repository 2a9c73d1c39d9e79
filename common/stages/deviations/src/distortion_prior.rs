//! Prior covariance of the distortion: errors of the pose, and drift that changes slowly from place to place.

use crate::thresholds::DISTORTION_LENGTH_M;
use frames::PoseCovariance;
use nalgebra::{Matrix2, Matrix3};

/// Prior of the distortion: a Gaussian process with mean 0.
#[derive(Debug, Clone, Copy)]
pub(crate) struct DistortionPrior {
    /// Place in `map` for which the covariance of the pose holds.
    about_m: [f64; 2],
    pose: Matrix3<f64>,
    /// Standard deviation of the drift at any place.
    pub(crate) drift_m: f64,
}

impl DistortionPrior {
    pub(crate) fn new(about_m: [f64; 2], pose: &PoseCovariance, drift_m: f64) -> Self {
        Self { about_m, pose: Matrix3::from(pose.rows()).transpose(), drift_m }
    }

    /// Covariance of the distortions at two places, in m².
    pub(crate) fn covariance(&self, p: [f64; 2], q: [f64; 2]) -> Matrix2<f64> {
        let drift = self.drift_m * self.drift_m * correlation(libm::hypot(p[0] - q[0], p[1] - q[1]));
        self.of_pose(p, q) + Matrix2::from_diagonal_element(drift)
    }

    /// The part of it that the pose makes: a small turn moves places across.
    fn of_pose(&self, p: [f64; 2], q: [f64; 2]) -> Matrix2<f64> {
        let [xx, xy, xt, yy, yt, tt] = [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)].map(|rc| self.pose[rc]);
        let [[px, py], [qx, qy]] = [p, q].map(|at| [at[0] - self.about_m[0], at[1] - self.about_m[1]]);
        Matrix2::new(
            xx - (py + qy) * xt + py * qy * tt,
            xy + qx * xt - py * yt - py * qx * tt,
            xy + px * xt - qy * yt - px * qy * tt,
            yy + (px + qx) * yt + px * qx * tt,
        )
    }

    /// Variance of the local turn of the map, in rad².
    pub(crate) fn turn_variance(&self) -> f64 {
        // Half the curl of two independent fields; the second derivative of the correlation at 0 is -3 / L².
        self.pose[(2, 2)] + 1.5 * (self.drift_m / DISTORTION_LENGTH_M).powi(2)
    }
}

/// Matérn's correlation with smoothness 3/2.
fn correlation(far_m: f64) -> f64 {
    let far = 3f64.sqrt() * far_m / DISTORTION_LENGTH_M;
    (1.0 + far) * libm::exp(-far)
}
