//! Poses of a SLAM map in a reference, between their cells.

use crate::thresholds::{SAME_M, SAME_RAD};
use frames::{Map, Rigid2, Slam, wrapped};
use std::marker::PhantomData;

/// The frame of a map's cells: metres from its lower left corner, along its rows and columns. `Frame` is that of the map.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Cells<Frame>(PhantomData<Frame>);

/// The motion that lays the cells of a SLAM map on those of a reference.
pub(crate) type Pose = Rigid2<Cells<Map>, Cells<Slam>>;

/// A pose followed by a small motion, metres and radians, around a place in the reference.
pub(crate) fn moved(pose: &Pose, [dx_m, dy_m, turn_rad]: [f64; 3], about: [f64; 2]) -> Pose {
    let turn = Pose::new([0.0; 2], turn_rad);
    let [x, y] = pose.translation_m();
    let d = turn.rotate([x - about[0], y - about[1]]);
    Pose::new([about[0] + dx_m + d[0], about[1] + dy_m + d[1]], wrapped(pose.yaw_rad() + turn_rad))
}

/// True if both poses move a point of the SLAM map to the same place, and turn it as far.
pub(crate) fn is_same_pose<To, From>(a: &Rigid2<To, From>, b: &Rigid2<To, From>, about: [f64; 2]) -> bool {
    is_within(a, b, about, SAME_M, SAME_RAD)
}

/// True if both poses move a point of the SLAM map to places that are at most so far apart, and turn it by angles that are.
pub(crate) fn is_within<To, From>(
    a: &Rigid2<To, From>,
    b: &Rigid2<To, From>,
    about: [f64; 2],
    distance_m: f64,
    angle_rad: f64,
) -> bool {
    let (at, other) = (a.apply(about), b.apply(about));
    libm::hypot(at[0] - other[0], at[1] - other[1]) <= distance_m
        && wrapped(a.yaw_rad() - b.yaw_rad()).abs() <= angle_rad
}
