//! Solids as meshes, and boxes around them.

use nalgebra::Point3;
use std::collections::BTreeSet;

/// Points at most so far from each other, from a plane or from an edge are on it: twice what single precision loses at 100 m.
pub(super) const NEAR_M: f64 = 2e-5;

/// A solid: positions in metres, triangles counter-clockwise from outside.
#[derive(Debug, Clone, Default)]
pub struct Solid {
    /// Positions of the vertices.
    pub positions: Vec<Point3<f64>>,
    /// Vertex indices, each below `positions.len()`.
    pub triangles: Vec<[u32; 3]>,
}

impl Solid {
    pub(super) fn corners(&self, triangle: [u32; 3]) -> [Point3<f64>; 3] {
        triangle.map(|k| self.positions[k as usize])
    }

    pub(super) fn volume_m3(&self) -> f64 {
        let Some(origin) = self.positions.first() else { return 0.0 };
        let of = |t: &[u32; 3]| {
            let [a, b, c] = self.corners(*t).map(|p| p - origin);
            a.dot(&b.cross(&c)) / 6.0
        };
        self.triangles.iter().map(of).sum()
    }

    /// Vertices of edges that are not used equally often in both directions; none of a closed solid.
    pub(super) fn open_vertices(&self) -> BTreeSet<u32> {
        let directed = |&[a, b, c]: &[u32; 3]| [(a, b), (b, c), (c, a)].map(|(p, q)| (p.min(q), p.max(q), p < q));
        let mut edges: Vec<(u32, u32, bool)> = self.triangles.iter().flat_map(directed).collect();
        edges.sort_unstable();
        let same_edge = edges.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1));
        let open = same_edge.filter(|same| 2 * same.iter().filter(|edge| edge.2).count() != same.len());
        open.flat_map(|same| [same[0].0, same[0].1]).collect()
    }

    /// True if every edge is used equally often in both directions.
    pub(super) fn is_closed(&self) -> bool {
        self.open_vertices().is_empty()
    }
}

impl Solid {
    /// The same without vertices that no triangle names.
    pub(super) fn compact(self) -> Self {
        let mut ids = vec![u32::MAX; self.positions.len()];
        let mut positions = Vec::new();
        let triangles = self.triangles.iter().map(|t| {
            t.map(|k| {
                let id = &mut ids[k as usize];
                if *id == u32::MAX {
                    *id = positions.len() as u32;
                    positions.push(self.positions[k as usize]);
                }
                *id
            })
        });
        let triangles = triangles.collect();
        Self { positions, triangles }
    }
}

/// An upright box.
#[derive(Debug, Clone, Copy)]
pub(super) struct Extent {
    pub(super) low: Point3<f64>,
    pub(super) high: Point3<f64>,
}

impl Extent {
    pub(super) fn of<'p>(points: impl IntoIterator<Item = &'p Point3<f64>>) -> Self {
        let none = Self { low: Point3::from([f64::INFINITY; 3]), high: Point3::from([f64::NEG_INFINITY; 3]) };
        points.into_iter().fold(none, |sum, p| Self { low: sum.low.inf(p), high: sum.high.sup(p) })
    }

    pub(super) fn and(self, other: &Self) -> Self {
        Self { low: self.low.inf(&other.low), high: self.high.sup(&other.high) }
    }

    pub(super) fn meets(&self, other: &Self) -> bool {
        self.is_within(other, NEAR_M)
    }

    /// True if the boxes are at most so far apart.
    pub(super) fn is_within(&self, other: &Self, reach: f64) -> bool {
        (0..3).all(|k| self.low[k] <= other.high[k] + reach && other.low[k] <= self.high[k] + reach)
    }

    pub(super) fn is_near(&self, p: &Point3<f64>, reach: f64) -> bool {
        (0..3).all(|k| self.low[k] - reach <= p[k] && p[k] <= self.high[k] + reach)
    }
}
