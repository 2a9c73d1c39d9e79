//! A floor plan that is drawn: floor, walls over it, gaps in them.

use crate::plane::{Rectangle, Vector};
use occupancy::{CELL_M, Cell, OccupancyMap};

const MARGIN_M: f64 = 1.0;

/// What becomes of a corner of a building.
#[derive(Debug, Clone, Copy)]
pub(super) enum Shape {
    /// The building is set back: a square is missing.
    SetBack,
    /// A wall at 45 degrees.
    Oblique,
    /// A quarter of a circle.
    Round,
}

/// Cells of a floor plan that begins at the origin.
pub(super) struct Drawing {
    width: usize,
    height: usize,
    cells: Vec<Cell>,
}

impl Drawing {
    /// Nothing yet, of this size.
    pub(super) fn new(size_m: [f64; 2]) -> Self {
        let [width, height] = size_m.map(|m| ((m + 2.0 * MARGIN_M) / CELL_M).ceil() as usize);
        Self { width, height, cells: vec![Cell::Unknown; width * height] }
    }

    pub(super) fn size_m(&self) -> [f64; 2] {
        [self.width, self.height].map(|n| n as f64 * CELL_M - 2.0 * MARGIN_M)
    }

    /// Wall in place of floor.
    pub(super) fn build(&mut self, rectangle: &Rectangle) {
        self.change(|p, cell| (rectangle.contains(p) && cell == Cell::Free).then_some(Cell::Occupied));
    }

    /// Fills the rectangle between two corners.
    pub(super) fn fill_box(&mut self, low: Vector, high: Vector, cell: Cell) {
        let first = low.map(|m| ((m + MARGIN_M) / CELL_M).round().max(0.0) as usize);
        let end = high.map(|m| ((m + MARGIN_M) / CELL_M).round().max(0.0) as usize);
        for y in first[1].min(self.height)..end[1].min(self.height) {
            self.cells[y * self.width + first[0].min(self.width)..y * self.width + end[0].min(self.width)].fill(cell);
        }
    }

    /// Walls along the inner side of the border between two corners.
    pub(super) fn wall_around(&mut self, low: Vector, high: Vector, thickness: f64) {
        self.fill_box(low, [high[0], low[1] + thickness], Cell::Occupied);
        self.fill_box([low[0], high[1] - thickness], high, Cell::Occupied);
        self.fill_box(low, [low[0] + thickness, high[1]], Cell::Occupied);
        self.fill_box([high[0] - thickness, low[1]], high, Cell::Occupied);
    }

    /// Floor in place of wall.
    pub(super) fn cut(&mut self, rectangle: &Rectangle) {
        self.change(|p, cell| (rectangle.contains(p) && cell == Cell::Occupied).then_some(Cell::Free));
    }

    /// Changes the building at one corner of its extent, `size` far along both sides.
    pub(super) fn reshape_corner(&mut self, [right, top]: [bool; 2], size: f64, thickness: f64, shape: Shape) {
        let whole = self.size_m();
        self.change(|p, cell| {
            let x = if right { whole[0] - p[0] } else { p[0] };
            let y = if top { whole[1] - p[1] } else { p[1] };
            if x > size + thickness || y > size + thickness || cell == Cell::Unknown {
                return None;
            }
            // How far the place is inside of the new border.
            let inside = match shape {
                Shape::SetBack => (x - size).max(y - size) + thickness,
                Shape::Oblique => (x + y - size) * std::f64::consts::FRAC_1_SQRT_2,
                Shape::Round if x < size && y < size => size - libm::hypot(size - x, size - y),
                Shape::Round => f64::INFINITY,
            };
            match inside {
                _ if inside < 0.0 => Some(Cell::Unknown),
                _ if inside < thickness => Some(Cell::Occupied),
                _ => None,
            }
        });
    }

    fn change(&mut self, what: impl Fn(Vector, Cell) -> Option<Cell>) {
        for (k, cell) in self.cells.iter_mut().enumerate() {
            let p = [k % self.width, k / self.width].map(|c| (c as f64 + 0.5) * CELL_M - MARGIN_M);
            *cell = what(p, *cell).unwrap_or(*cell);
        }
    }

    pub(super) fn into_map(self) -> OccupancyMap {
        OccupancyMap { width: self.width, cells: self.cells, resolution_m: CELL_M, origin: [-MARGIN_M, -MARGIN_M, 0.0] }
    }
}
