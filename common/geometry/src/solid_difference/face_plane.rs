//! Planes of faces, and the lattice on each.

use super::solid::{Extent, NEAR_M};
use crate::polygon::Point;
use nalgebra::{Point3, Vector3};

/// Units of the lattice per metre, a power of two, and the largest coordinate on it.
const UNITS_PER_M: f64 = 262_144.0;
const MAX_UNITS: f64 = 5e8;

/// Triangles of a body whose height is less than this say little about their plane.
pub(super) const SLIVER_M: f64 = 1e-3;

/// The plane of faces, and where they are.
#[derive(Clone, Copy)]
pub(super) struct Facet {
    pub(super) origin: Point3<f64>,
    pub(super) normal: Vector3<f64>,
    pub(super) extent: Extent,
}

impl Facet {
    pub(super) fn of(corners: [Point3<f64>; 3]) -> Option<(Self, f64)> {
        let [a, b, c] = corners;
        let across = (b - a).cross(&(c - a));
        let longest = [b - a, c - b, a - c].iter().map(Vector3::norm).fold(0.0, f64::max);
        let normal = across.try_normalize(1e-14)?;
        Some((Self { origin: a, normal, extent: Extent::of(&corners) }, across.norm() / longest))
    }

    pub(super) fn distance(&self, p: &Point3<f64>) -> f64 {
        self.normal.dot(&(p - self.origin))
    }

    pub(super) fn has(&self, corners: &[Point3<f64>; 3]) -> bool {
        corners.iter().all(|p| self.distance(p).abs() <= NEAR_M)
    }
}

/// A plane with the faces of bodies on it.
pub(super) struct FacePlane {
    pub(super) facet: Facet,
    /// Axes in the plane: both and the normal are right-handed.
    pub(super) axes: [Vector3<f64>; 2],
    /// Body, triangle, and whether it looks along the normal.
    pub(super) faces: Vec<(usize, [u32; 3], bool)>,
}

impl FacePlane {
    pub(super) fn new(facet: Facet) -> Self {
        let up = if facet.normal.z.abs() < 0.999 { Vector3::z() } else { Vector3::y() };
        let x = up.cross(&facet.normal).normalize();
        Self { axes: [x, facet.normal.cross(&x)], facet, faces: Vec::new() }
    }

    /// A point on the lattice of the plane; `None` if it is too far away.
    pub(super) fn on_lattice(&self, p: &Point3<f64>) -> Option<Point> {
        let units = self.axes.map(|axis| (axis.dot(&(p - self.facet.origin)) * UNITS_PER_M).round());
        units.iter().all(|c| c.abs() < MAX_UNITS).then(|| units.map(|c| c as i32))
    }

    pub(super) fn in_space(&self, p: Point) -> Point3<f64> {
        let [x, y] = p.map(|c| f64::from(c) / UNITS_PER_M);
        self.facet.origin + self.axes[0] * x + self.axes[1] * y
    }

    pub(super) fn body(&self) -> Option<usize> {
        let first = self.faces.first()?.0;
        self.faces.iter().all(|(body, ..)| *body == first).then_some(first)
    }
}
