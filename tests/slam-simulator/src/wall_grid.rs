//! Walls and floor of a model map, by place.

use crate::plane::Vector;

/// Cells of walls and of floor, row-major from the lower left corner.
#[derive(Debug, Clone)]
pub struct WallGrid {
    /// Cells in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Side of a cell.
    pub resolution_m: f64,
    /// Lower left corner.
    pub origin: Vector,
    /// Cells of walls.
    pub walls: Vec<bool>,
    /// Cells of floor, furnished or not.
    pub floor: Vec<bool>,
}

impl WallGrid {
    /// Area of its floor.
    pub fn floor_m2(&self) -> f64 {
        self.floor.iter().filter(|f| **f).count() as f64 * self.resolution_m * self.resolution_m
    }

    /// The index of the cell at a point; `None` outside.
    pub(crate) fn index_at(&self, p: Vector) -> Option<usize> {
        let [x, y] = [0, 1].map(|k| ((p[k] - self.origin[k]) / self.resolution_m).floor());
        let is_inside = 0.0 <= x && x < self.width as f64 && 0.0 <= y && y < self.height as f64;
        is_inside.then(|| y as usize * self.width + x as usize)
    }

    /// The middle of a cell.
    pub(crate) fn middle(&self, index: usize) -> Vector {
        let [x, y] = [index % self.width, index / self.width].map(|c| (c as f64 + 0.5) * self.resolution_m);
        [self.origin[0] + x, self.origin[1] + y]
    }

    pub(crate) fn is_wall(&self, p: Vector) -> bool {
        self.index_at(p).is_some_and(|k| self.walls[k])
    }

    pub(crate) fn is_floor(&self, p: Vector) -> bool {
        self.index_at(p).is_some_and(|k| self.floor[k])
    }
}
