//! Points with their frame in the type, in metres.

use std::marker::PhantomData;

/// A point in the plane of `Frame`, in metres.
#[derive(Debug)]
pub struct Point2<Frame> {
    pub(crate) point: nalgebra::Point2<f64>,
    frame: PhantomData<Frame>,
}

/// A point in `Frame`, in metres.
#[derive(Debug)]
pub struct Point3<Frame> {
    pub(crate) point: nalgebra::Point3<f64>,
    frame: PhantomData<Frame>,
}

impl<Frame> Point2<Frame> {
    /// The point at (`x_m`, `y_m`).
    pub const fn new(x_m: f64, y_m: f64) -> Self {
        Self { point: nalgebra::Point2::new(x_m, y_m), frame: PhantomData }
    }

    /// First coordinate in metres.
    pub fn x_m(&self) -> f64 {
        self.point.x
    }

    /// Second coordinate in metres.
    pub fn y_m(&self) -> f64 {
        self.point.y
    }

    /// Both coordinates in metres.
    pub fn coordinates_m(&self) -> [f64; 2] {
        self.point.into()
    }

    /// The length of the straight line to another point, in metres.
    pub fn distance_m(&self, other: &Self) -> f64 {
        // Not the square root of a sum of squares, whose last bit differs.
        let way = other.point - self.point;
        libm::hypot(way.x, way.y)
    }
}

impl<Frame> Point3<Frame> {
    /// The point at (`x_m`, `y_m`, `z_m`).
    pub const fn new(x_m: f64, y_m: f64, z_m: f64) -> Self {
        Self { point: nalgebra::Point3::new(x_m, y_m, z_m), frame: PhantomData }
    }

    /// Coordinates and height in metres.
    pub fn coordinates_m(&self) -> [f64; 3] {
        self.point.into()
    }
}

impl<Frame> From<nalgebra::Point2<f64>> for Point2<Frame> {
    fn from(point: nalgebra::Point2<f64>) -> Self {
        Self { point, frame: PhantomData }
    }
}
impl<Frame> From<nalgebra::Point3<f64>> for Point3<Frame> {
    fn from(point: nalgebra::Point3<f64>) -> Self {
        Self { point, frame: PhantomData }
    }
}

// Derives would ask the frame for these traits, which it does not need.
impl<Frame> Clone for Point2<Frame> {
    fn clone(&self) -> Self {
        *self
    }
}
impl<Frame> Copy for Point2<Frame> {}
impl<Frame> PartialEq for Point2<Frame> {
    fn eq(&self, other: &Self) -> bool {
        self.point == other.point
    }
}
impl<Frame> Clone for Point3<Frame> {
    fn clone(&self) -> Self {
        *self
    }
}
impl<Frame> Copy for Point3<Frame> {}
impl<Frame> PartialEq for Point3<Frame> {
    fn eq(&self, other: &Self) -> bool {
        self.point == other.point
    }
}
