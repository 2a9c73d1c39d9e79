//! Covariance of where a moved place comes to lie, and of yaw.

use crate::Rigid2;
use nalgebra::Matrix3;

/// Covariance of x, y and yaw of a motion of the plane: m², m rad and rad². It holds for one
/// place, which is named beside it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PoseCovariance(Matrix3<f64>);

impl PoseCovariance {
    /// From its rows; the matrix is symmetric.
    pub fn from_rows(rows: [[f64; 3]; 3]) -> Self {
        Self(Matrix3::from(rows).transpose())
    }

    /// Its rows.
    pub fn rows(&self) -> [[f64; 3]; 3] {
        self.0.transpose().into()
    }

    /// The covariance at a place that lies `d_m` from that where it holds: a small turn moves it across.
    #[must_use]
    pub fn transported(&self, d_m: [f64; 2]) -> Self {
        let [dx, dy] = d_m;
        self.in_coordinates(&Matrix3::new(1.0, 0.0, -dy, 0.0, 1.0, dx, 0.0, 0.0, 1.0))
    }

    /// The covariance in the axes of the frame that a motion leads to.
    #[must_use]
    pub fn turned<To, From>(&self, by: &Rigid2<To, From>) -> Self {
        let [x, y] = [[1.0, 0.0], [0.0, 1.0]].map(|axis| by.rotate(axis));
        self.in_coordinates(&Matrix3::new(x[0], y[0], 0.0, x[1], y[1], 0.0, 0.0, 0.0, 1.0))
    }

    fn in_coordinates(&self, jacobian: &Matrix3<f64>) -> Self {
        Self(jacobian * self.0 * jacobian.transpose())
    }

    /// Standard deviations of x and y in metres and of yaw in radians.
    pub fn deviations(&self) -> [f64; 3] {
        self.0.diagonal().map(|variance| variance.max(0.0).sqrt()).into()
    }

    /// Standard deviation of the place in the direction that is held worst, in metres.
    pub fn worst_m(&self) -> f64 {
        let of_place = self.0.fixed_view::<2, 2>(0, 0).into_owned();
        of_place.symmetric_eigenvalues().max().max(0.0).sqrt()
    }
}
