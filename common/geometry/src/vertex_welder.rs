//! Vertices that are one where they are near each other.

use nalgebra::{Point3, Vector3};
use rustc_hash::FxHashMap;

/// Gives positions numbers, the same one to all that lie within a distance of the first of them.
pub(crate) struct VertexWelder {
    reach: f64,
    positions: Vec<Point3<f64>>,
    /// Vertices by the cell, of twice the reach, that they lie in.
    by_cell: FxHashMap<[i64; 3], Vec<u32>>,
}

impl VertexWelder {
    pub(crate) fn new(reach: f64) -> Self {
        Self { reach, positions: Vec::new(), by_cell: FxHashMap::default() }
    }

    /// With these vertices, whatever their distances are.
    pub(crate) fn of(reach: f64, positions: Vec<Point3<f64>>) -> Self {
        let mut welder = Self::new(reach);
        for p in &positions {
            welder.push(*p);
        }
        welder
    }

    /// The number of the vertex there.
    pub(crate) fn add(&mut self, p: Point3<f64>) -> u32 {
        let around = Vector3::repeat(self.reach);
        let cells = [p - around, p + around].map(|p| self.cell(&p));
        for x in cells[0][0]..=cells[1][0] {
            for y in cells[0][1]..=cells[1][1] {
                for z in cells[0][2]..=cells[1][2] {
                    let near = self.by_cell.get(&[x, y, z]).map_or(&[][..], Vec::as_slice);
                    let found = near.iter().find(|k| (self.positions[**k as usize] - p).norm() <= self.reach);
                    if let Some(found) = found {
                        return *found;
                    }
                }
            }
        }
        self.push(p)
    }

    fn push(&mut self, p: Point3<f64>) -> u32 {
        let id = self.positions.len() as u32;
        self.positions.push(p);
        self.by_cell.entry(self.cell(&p)).or_default().push(id);
        id
    }

    fn cell(&self, p: &Point3<f64>) -> [i64; 3] {
        [0, 1, 2].map(|k| (p[k] / (2.0 * self.reach)).floor() as i64)
    }

    pub(crate) fn positions(&self) -> &[Point3<f64>] {
        &self.positions
    }

    pub(crate) fn into_positions(self) -> Vec<Point3<f64>> {
        self.positions
    }
}
