//! Affine maps in f64: placements and mapping operators.

use crate::Placement;

/// `p -> axes * p + origin`; `axes` are columns.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Affine {
    pub(crate) axes: [[f64; 3]; 3],
    pub(crate) origin: [f64; 3],
}

impl Affine {
    pub(crate) const IDENTITY: Self =
        Self { axes: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], origin: [0.0; 3] };

    pub(crate) fn rotate(&self, v: [f64; 3]) -> [f64; 3] {
        let [x, y, z] = &self.axes;
        [0, 1, 2].map(|i| x[i] * v[0] + y[i] * v[1] + z[i] * v[2])
    }

    pub(crate) fn apply(&self, p: [f64; 3]) -> [f64; 3] {
        let r = self.rotate(p);
        [0, 1, 2].map(|i| r[i] + self.origin[i])
    }

    /// First `inner`, then `self`.
    pub(crate) fn after(&self, inner: &Self) -> Self {
        Self { axes: inner.axes.map(|axis| self.rotate(axis)), origin: self.apply(inner.origin) }
    }

    pub(crate) fn mirrored(&self) -> bool {
        dot(cross(self.axes[0], self.axes[1]), self.axes[2]) < 0.0
    }

    pub(crate) fn is_finite(&self) -> bool {
        self.axes.iter().flatten().chain(&self.origin).all(|x| x.is_finite())
    }

    /// As a frame with unit axes.
    pub(crate) fn placement(&self) -> Option<Placement> {
        let [x, y, z] = self.axes.map(normalised);
        Some(Placement { origin_m: self.origin, axes: [x?, y?, z?] })
    }
}

pub(crate) fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(crate) fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

pub(crate) fn normalised(v: [f64; 3]) -> Option<[f64; 3]> {
    let length = dot(v, v).sqrt();
    (length > 1e-12 && length.is_finite()).then(|| v.map(|x| x / length))
}
