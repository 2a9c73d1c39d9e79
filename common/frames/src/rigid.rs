//! Rigid motions between frames.

use crate::{Point2, Point3, wrapped};
use nalgebra::{
    Complex, Isometry2, IsometryMatrix3, Matrix3, Rotation3, Translation2, Translation3, UnitComplex, Vector2,
};
use std::marker::PhantomData;
use std::ops::Mul;

/// Rigid motion of the plane taking `From` coordinates to `To` coordinates.
///
/// A value is named destination first: `map_from_world`.
///
/// ```
/// use frames::{Map, Point2, Rigid2, Slam};
///
/// let map_from_slam = Rigid2::<Map, Slam>::new([3.0, -7.0], std::f64::consts::FRAC_PI_2);
/// let in_map: Point2<Map> = &map_from_slam * Point2::<Slam>::new(1.0, 0.0);
/// assert!(in_map.distance_m(&Point2::new(3.0, -6.0)) < 1e-12);
/// ```
#[derive(Debug)]
pub struct Rigid2<To, From> {
    motion: Isometry2<f64>,
    // The angle of `motion` as it was given: taken back from its cosine and sine it would change its last bit on each way
    // through a file or an archive.
    yaw_rad: f64,
    frames: PhantomData<(To, From)>,
}

impl<To, From> Rigid2<To, From> {
    /// The motion `p_to = R(yaw_rad) p_from + (x_m, y_m)`.
    ///
    /// A yaw of zero is exact: no rounding touches the coordinates.
    pub fn new([x_m, y_m]: [f64; 2], yaw_rad: f64) -> Self {
        let (sin, cos) = libm::sincos(yaw_rad);
        Self::of_parts([x_m, y_m], UnitComplex::new_unchecked(Complex::new(cos, sin)), yaw_rad)
    }

    fn of_parts([x_m, y_m]: [f64; 2], turn: UnitComplex<f64>, yaw_rad: f64) -> Self {
        Self { motion: Isometry2::from_parts(Translation2::new(x_m, y_m), turn), yaw_rad, frames: PhantomData }
    }

    /// From x and y in metres and yaw in radians, as archives and files hold them.
    pub fn of_x_y_yaw([x_m, y_m, yaw_rad]: [f64; 3]) -> Self {
        Self::new([x_m, y_m], yaw_rad)
    }

    /// x and y in metres and yaw in radians, as archives and files hold them.
    pub fn x_y_yaw(&self) -> [f64; 3] {
        let [x_m, y_m] = self.translation_m();
        [x_m, y_m, self.yaw_rad]
    }

    /// Angle of the motion in radians, as it was given; of a composed or inverted motion from -pi to pi.
    pub fn yaw_rad(&self) -> f64 {
        self.yaw_rad
    }

    /// The origin of `From` in `To`, in metres.
    pub fn translation_m(&self) -> [f64; 2] {
        self.motion.translation.vector.into()
    }

    /// Turns a direction without moving it.
    pub fn rotate(&self, direction: [f64; 2]) -> [f64; 2] {
        (self.motion.rotation * Vector2::from(direction)).into()
    }

    /// Moves bare coordinates: for loops over cells and points.
    pub fn apply(&self, p_from_m: [f64; 2]) -> [f64; 2] {
        (self.motion * nalgebra::Point2::from(p_from_m)).into()
    }

    /// Moves bare coordinates back: for loops over cells and points.
    pub fn apply_inverse(&self, p_to_m: [f64; 2]) -> [f64; 2] {
        self.motion.inverse_transform_point(&p_to_m.into()).into()
    }

    fn after<Before>(&self, first: &Rigid2<From, Before>) -> Rigid2<To, Before> {
        // The cosine and sine are those of the angle, not products: they stay on the unit circle however many motions follow.
        Rigid2::new(self.apply(first.translation_m()), wrapped(self.yaw_rad + first.yaw_rad))
    }

    /// The motion back.
    pub fn inverse(&self) -> Rigid2<From, To> {
        Rigid2 { motion: self.motion.inverse(), yaw_rad: wrapped(-self.yaw_rad), frames: PhantomData }
    }
}

impl<To, From> Mul<Point2<From>> for &Rigid2<To, From> {
    type Output = Point2<To>;

    fn mul(self, p: Point2<From>) -> Point2<To> {
        (self.motion * p.point).into()
    }
}

/// First the right one, then the left one.
impl<To, Via, From> Mul<&Rigid2<Via, From>> for &Rigid2<To, Via> {
    type Output = Rigid2<To, From>;

    fn mul(self, first: &Rigid2<Via, From>) -> Rigid2<To, From> {
        self.after(first)
    }
}

/// Rigid motion of space that keeps Z upright: a turn about Z and a shift.
#[derive(Debug)]
pub struct UprightRigid3<To, From> {
    // With a matrix and not a quaternion, which rounds otherwise and would need half the angle.
    motion: IsometryMatrix3<f64>,
    // As in `Rigid2`.
    yaw_rad: f64,
    frames: PhantomData<(To, From)>,
}

impl<To, From> UprightRigid3<To, From> {
    /// The motion `p_to = Rz(yaw_rad) p_from + (x_m, y_m, z_m)`.
    pub fn new([x_m, y_m, z_m]: [f64; 3], yaw_rad: f64) -> Self {
        let (sin, cos) = libm::sincos(yaw_rad);
        let turn = Matrix3::new(cos, -sin, 0.0, sin, cos, 0.0, 0.0, 0.0, 1.0);
        let turn = Rotation3::from_matrix_unchecked(turn);
        let motion = IsometryMatrix3::from_parts(Translation3::new(x_m, y_m, z_m), turn);
        Self { motion, yaw_rad, frames: PhantomData }
    }

    /// The motion of the plane under this one.
    pub fn in_plane(&self) -> Rigid2<To, From> {
        let ([x_m, y_m, _], turn) = (self.translation_m(), self.motion.rotation.matrix());
        let turn = UnitComplex::new_unchecked(Complex::new(turn.m11, turn.m21));
        Rigid2::of_parts([x_m, y_m], turn, self.yaw_rad)
    }

    /// Angle about Z in radians, as it was given.
    pub fn yaw_rad(&self) -> f64 {
        self.yaw_rad
    }

    /// The origin of `From` in `To`, in metres.
    pub fn translation_m(&self) -> [f64; 3] {
        self.motion.translation.vector.into()
    }

    /// Moves bare coordinates: for loops over vertices.
    pub fn apply(&self, p_from_m: [f64; 3]) -> [f64; 3] {
        (self.motion * nalgebra::Point3::from(p_from_m)).into()
    }

    /// The motion back.
    pub fn inverse(&self) -> UprightRigid3<From, To> {
        UprightRigid3 { motion: self.motion.inverse(), yaw_rad: -self.yaw_rad, frames: PhantomData }
    }
}

impl<To, From> Mul<Point3<From>> for &UprightRigid3<To, From> {
    type Output = Point3<To>;

    fn mul(self, p: Point3<From>) -> Point3<To> {
        (self.motion * p.point).into()
    }
}

// Derives would ask the frames for these traits, which they do not need.
impl<To, From> Clone for Rigid2<To, From> {
    fn clone(&self) -> Self {
        *self
    }
}
impl<To, From> Copy for Rigid2<To, From> {}
impl<To, From> PartialEq for Rigid2<To, From> {
    fn eq(&self, other: &Self) -> bool {
        (self.motion, self.yaw_rad) == (other.motion, other.yaw_rad)
    }
}
impl<To, From> Clone for UprightRigid3<To, From> {
    fn clone(&self) -> Self {
        *self
    }
}
impl<To, From> Copy for UprightRigid3<To, From> {}
