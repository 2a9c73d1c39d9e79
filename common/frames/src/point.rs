//! Points with their frame in the type, in metres.

use std::marker::PhantomData;

/// A point in the plane of `Frame`, in metres.
#[derive(Debug)]
pub struct Point2<Frame> {
    /// First coordinate in metres.
    pub x_m: f64,
    /// Second coordinate in metres.
    pub y_m: f64,
    frame: PhantomData<Frame>,
}

/// A point in `Frame`, in metres.
#[derive(Debug)]
pub struct Point3<Frame> {
    /// First coordinate in metres.
    pub x_m: f64,
    /// Second coordinate in metres.
    pub y_m: f64,
    /// Height in metres.
    pub z_m: f64,
    frame: PhantomData<Frame>,
}

impl<Frame> Point2<Frame> {
    /// The point at (`x_m`, `y_m`).
    pub const fn new(x_m: f64, y_m: f64) -> Self {
        Self { x_m, y_m, frame: PhantomData }
    }
}

impl<Frame> Point3<Frame> {
    /// The point at (`x_m`, `y_m`, `z_m`).
    pub const fn new(x_m: f64, y_m: f64, z_m: f64) -> Self {
        Self { x_m, y_m, z_m, frame: PhantomData }
    }

    /// The point below this one in the plane.
    pub const fn in_plane(self) -> Point2<Frame> {
        Point2::new(self.x_m, self.y_m)
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
        (self.x_m, self.y_m) == (other.x_m, other.y_m)
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
        (self.x_m, self.y_m, self.z_m) == (other.x_m, other.y_m, other.z_m)
    }
}
