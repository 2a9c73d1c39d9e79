//! Poses that count as one.

use crate::thresholds::{SAME_M, SAME_RAD};
use occupancy::{Pose, wrapped};

/// True if both poses move a point of the SLAM map to the same place, and turn it as far.
pub(crate) fn is_same(a: &Pose, b: &Pose, about: [f64; 2]) -> bool {
    let (at, other) = (a.apply(about), b.apply(about));
    libm::hypot(at[0] - other[0], at[1] - other[1]) <= SAME_M && wrapped(a.yaw_rad - b.yaw_rad).abs() <= SAME_RAD
}
