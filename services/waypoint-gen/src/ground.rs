//! Where a robot can stand on a storey, and which places belong together.

use frames::{Map, Point2, TENTHS_PER_M};
use grid::{Cell, GridSpec, Sight, squared_distances};
use messages::Grid;

/// A storey as a robot of one radius finds it.
///
/// It stands where the map is free, no keep-out cell is under its centre, and the middle of no cell that is not free is
/// nearer than its radius, as costmaps measure it. Cells that it can stand on and that meet along a side are one part.
pub(crate) struct Ground {
    pub(crate) spec: GridSpec,
    /// Lines through free cells.
    pub(crate) sight: Sight,
    /// Squared distance of each cell to the nearest one that is not free, in cells.
    squared: Vec<u32>,
    /// Part of each cell, from 1; 0 where it cannot stand.
    part: Vec<u32>,
    /// Number of cells of each part; of part 0 nothing is counted.
    sizes: Vec<u32>,
}

impl Ground {
    pub(crate) fn of(grid: &Grid<'_>, radius_m: f64) -> Self {
        let spec = grid.spec();
        let not_free: Vec<bool> = grid.planning.iter().map(|&p| p != 0).collect();
        let squared = squared_distances(&not_free, spec.width as usize);
        // Squared cells from which on it is clear; a tenth of a millimetre is no obstacle.
        let needed = (radius_m * f64::from(TENTHS_PER_M) - 1.0) / f64::from(spec.cell_tenths);
        let needed = (needed.max(0.0) * needed.max(0.0)).ceil() as u32;
        let stands = squared.iter().zip(grid.keepout).map(|(&d2, &keepout)| keepout == 0 && d2 >= needed.max(1));
        let mut part: Vec<u32> = stands.map(|stands| if stands { UNLABELLED } else { 0 }).collect();
        let sizes = label(&mut part, spec.width as usize);
        Self { spec, sight: Sight::from_distances(&squared, spec.width as usize), squared, part, sizes }
    }

    /// The part that a cell belongs to, from 1; 0 where a robot cannot stand.
    pub(crate) fn part(&self, cell: usize) -> u32 {
        self.part[cell]
    }

    /// Number of parts; the last one has this number.
    pub(crate) fn n_parts(&self) -> u32 {
        self.sizes.len() as u32 - 1
    }

    /// Number of cells of a part.
    pub(crate) fn size(&self, part: u32) -> u32 {
        self.sizes[part as usize]
    }

    /// The part with the most cells, of equals the one with the lowest cell; 0 if there is none.
    pub(crate) fn largest(&self) -> u32 {
        (1..=self.n_parts()).max_by_key(|&p| (self.size(p), std::cmp::Reverse(p))).unwrap_or(0)
    }

    /// Distance in metres from a point to the middle of the nearest cell that is not free; 0 on such a cell and outside the
    /// grid.
    pub(crate) fn clearance_m(&self, p: Point2<Map>) -> f64 {
        let Some(at) = self.spec.cell_at(p) else { return 0.0 };
        let cell = self.spec.index(at);
        if self.squared[cell] == 0 || self.middle(cell) == p {
            return self.clearance_of(cell);
        }
        // The nearest one of a point is at most a diagonal farther than that of its own cell's middle.
        let longest = self.spec.width.max(self.spec.height);
        let reach = (f64::from(self.squared[cell]).sqrt().min(f64::from(longest)) + 1.5).ceil() as u32;
        let range = |at: u32, n: u32| at.saturating_sub(reach)..(at + reach + 1).min(n);
        let mut nearest = f64::INFINITY;
        for row in range(at.row, self.spec.height) {
            for column in range(at.column, self.spec.width) {
                let other = Cell { column, row };
                if self.squared[self.spec.index(other)] == 0 {
                    let c = self.spec.centre_of(other);
                    nearest = nearest.min(libm::hypot(p.x_m - c.x_m, p.y_m - c.y_m));
                }
            }
        }
        nearest
    }

    /// The same for the middle of a cell.
    pub(crate) fn clearance_of(&self, cell: usize) -> f64 {
        f64::from(self.squared[cell]).sqrt() * self.spec.resolution_m()
    }

    /// The middle of a cell.
    pub(crate) fn middle(&self, cell: usize) -> Point2<Map> {
        self.spec.centre_of(self.spec.cell_of(cell))
    }

    /// A place in cells from the lower left corner of the grid.
    pub(crate) fn in_cells(&self, p: Point2<Map>) -> [f64; 2] {
        let origin = self.spec.origin_m();
        [(p.x_m - origin[0]) / self.spec.resolution_m(), (p.y_m - origin[1]) / self.spec.resolution_m()]
    }
}

const UNLABELLED: u32 = u32::MAX;

/// Numbers the parts of all cells that are [`UNLABELLED`], from 1; returns their sizes, that of number 0 first.
fn label(part: &mut [u32], width: usize) -> Vec<u32> {
    let mut sizes = vec![0];
    let mut waiting = Vec::new();
    for start in 0..part.len() {
        if part[start] != UNLABELLED {
            continue;
        }
        let number = sizes.len() as u32;
        sizes.push(0);
        part[start] = number;
        waiting.push(start);
        while let Some(cell) = waiting.pop() {
            sizes[number as usize] += 1;
            let column = cell % width;
            let left = (column > 0).then(|| cell - 1);
            let right = (column + 1 < width).then(|| cell + 1);
            let below = cell.checked_sub(width);
            let above = Some(cell + width).filter(|c| *c < part.len());
            for next in [left, right, below, above].into_iter().flatten() {
                if part[next] == UNLABELLED {
                    part[next] = number;
                    waiting.push(next);
                }
            }
        }
    }
    sizes
}
