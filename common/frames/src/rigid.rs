//! Rigid motions between frames.

use crate::{Point2, Point3};
use std::marker::PhantomData;
use std::ops::Mul;

/// Rigid motion of the plane taking `From` coordinates to `To` coordinates.
///
/// A value is named destination first: `map_from_world`.
#[derive(Debug)]
pub struct Rigid2<To, From> {
    cos: f64,
    sin: f64,
    yaw_rad: f64,
    t: (f64, f64),
    frames: PhantomData<(To, From)>,
}

impl<To, From> Clone for Rigid2<To, From> {
    fn clone(&self) -> Self {
        *self
    }
}
impl<To, From> Copy for Rigid2<To, From> {}

impl<To, From> Rigid2<To, From> {
    /// The motion `p_to = R(yaw_rad) p_from + (x_m, y_m)`.
    ///
    /// A yaw of zero is exact: no rounding touches the coordinates.
    pub fn new(x_m: f64, y_m: f64, yaw_rad: f64) -> Self {
        let (sin, cos) = libm::sincos(yaw_rad);
        Self { cos, sin, yaw_rad, t: (x_m, y_m), frames: PhantomData }
    }

    /// Angle of the motion in radians, as it was given.
    pub fn yaw_rad(&self) -> f64 {
        self.yaw_rad
    }

    /// Where the origin of `From` lies in `To`, in metres.
    pub fn translation_m(&self) -> (f64, f64) {
        self.t
    }

    /// Turns a direction without moving it.
    pub fn rotate(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        [self.cos * x - self.sin * y, self.sin * x + self.cos * y]
    }

    /// The motion back.
    pub fn inverse(&self) -> Rigid2<From, To> {
        let (x, y) = self.t;
        let t = (-(self.cos * x + self.sin * y), self.sin * x - self.cos * y);
        Rigid2 { cos: self.cos, sin: -self.sin, yaw_rad: -self.yaw_rad, t, frames: PhantomData }
    }
}

impl<To, From> Mul<Point2<From>> for &Rigid2<To, From> {
    type Output = Point2<To>;

    fn mul(self, p: Point2<From>) -> Point2<To> {
        let [x, y] = self.rotate([p.x_m, p.y_m]);
        Point2::new(x + self.t.0, y + self.t.1)
    }
}

/// Rigid motion of space that keeps Z upright: a turn about Z and a shift.
#[derive(Debug)]
pub struct UprightRigid3<To, From> {
    plane: Rigid2<To, From>,
    z_m: f64,
}

impl<To, From> Clone for UprightRigid3<To, From> {
    fn clone(&self) -> Self {
        *self
    }
}
impl<To, From> Copy for UprightRigid3<To, From> {}

impl<To, From> UprightRigid3<To, From> {
    /// The motion `p_to = Rz(yaw_rad) p_from + (x_m, y_m, z_m)`.
    pub fn new([x_m, y_m, z_m]: [f64; 3], yaw_rad: f64) -> Self {
        Self { plane: Rigid2::new(x_m, y_m, yaw_rad), z_m }
    }

    /// The motion of the plane under this one.
    pub fn in_plane(&self) -> Rigid2<To, From> {
        self.plane
    }

    /// Angle about Z in radians.
    pub fn yaw_rad(&self) -> f64 {
        self.plane.yaw_rad
    }

    /// Where the origin of `From` lies in `To`, in metres.
    pub fn translation_m(&self) -> [f64; 3] {
        [self.plane.t.0, self.plane.t.1, self.z_m]
    }

    /// Moves bare coordinates: for loops over vertices.
    pub fn apply(&self, [x, y, z]: [f64; 3]) -> [f64; 3] {
        let [tx, ty] = self.plane.rotate([x, y]);
        [tx + self.plane.t.0, ty + self.plane.t.1, z + self.z_m]
    }
}

impl<To, From> Mul<Point3<From>> for &UprightRigid3<To, From> {
    type Output = Point3<To>;

    fn mul(self, p: Point3<From>) -> Point3<To> {
        let [x, y, z] = self.apply([p.x_m, p.y_m, p.z_m]);
        Point3::new(x, y, z)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    struct A;
    struct B;

    #[test]
    fn a_motion_and_its_inverse_cancel() {
        let b_from_a = Rigid2::<B, A>::new(3.0, -2.0, 0.7);
        let p = Point2::<A>::new(11.0, 5.0);
        let back: Point2<A> = &b_from_a.inverse() * (&b_from_a * p);
        assert!((back.x_m - p.x_m).abs() < 1e-12 && (back.y_m - p.y_m).abs() < 1e-12);
    }

    #[test]
    fn a_yaw_of_zero_is_exact() {
        let b_from_a = UprightRigid3::<B, A>::new([0.0; 3], 0.0);
        assert_eq!(b_from_a.apply([0.1, 0.2, 0.3]), [0.1, 0.2, 0.3]);
    }
}
