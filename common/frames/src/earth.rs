//! Affine map from the IFC world to a projected coordinate system.

use crate::{Point3, World};
use nalgebra::{Matrix3, Vector3};
use std::ops::Mul;

/// A projected coordinate system: eastings, northings and orthogonal height in metres.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Earth {}

/// The map from the IFC world to a projected system, as an IfcMapConversion gives it: `p_earth = origin + R (scale * p_world)`,
/// with a turn about Z and a scale for each axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EarthFromWorld {
    origin_m: nalgebra::Point3<f64>,
    turn: Matrix3<f64>,
    scale: Vector3<f64>,
}

impl EarthFromWorld {
    /// `origin_m` is where the world's origin lies, `x_axis` its x axis in eastings and northings (of length 1), `scale` metres
    /// of the projected system per metre of the world.
    pub fn new(origin_m: [f64; 3], [cos, sin]: [f64; 2], scale: [f64; 3]) -> Self {
        let turn = Matrix3::new(cos, -sin, 0.0, sin, cos, 0.0, 0.0, 0.0, 1.0);
        Self { origin_m: origin_m.into(), turn, scale: scale.into() }
    }

    /// Angle from east to the world's x axis, counter-clockwise, in radians.
    pub fn yaw_rad(&self) -> f64 {
        libm::atan2(self.turn.m21, self.turn.m11)
    }

    /// The point of the world that lies there on earth.
    pub fn apply_inverse(&self, p: Point3<Earth>) -> Point3<World> {
        let turned_back = self.turn.tr_mul(&(p.point - self.origin_m));
        nalgebra::Point3::from(turned_back.component_div(&self.scale)).into()
    }
}

impl Mul<Point3<World>> for &EarthFromWorld {
    type Output = Point3<Earth>;

    fn mul(self, p: Point3<World>) -> Point3<Earth> {
        let scaled = p.point.coords.component_mul(&self.scale);
        // One axis after the other: eastings and northings are so large that the order shows.
        (0..3).fold(self.origin_m, |sum, k| sum + self.turn.column(k) * scaled[k]).into()
    }
}
