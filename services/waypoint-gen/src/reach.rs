//! Where a robot can get to on a storey.

use crate::centre::Clearance;
use grid::{Cell, GridSpec};
use messages::Grid;

/// Cells that a robot of this radius can stand on and get to: the largest connected part of the storey.
///
/// It stands where the map is free, no keep-out cell is under its centre, and nothing is nearer than its radius. Which
/// part of a storey it is put into nobody says, so it is the largest; of equals the one with the lowest cell.
pub(crate) struct Reach {
    /// Part of each cell, from 1; 0 where it cannot stand.
    part: Vec<u32>,
    largest: u32,
}

impl Reach {
    pub(crate) fn of(grid: &Grid<'_>, clearance: &Clearance, radius_m: f64) -> Self {
        let width = grid.head.width as usize;
        let stands: Vec<bool> =
            (0..grid.planning.len()).map(|k| grid.keepout[k] == 0 && clearance.at_cell(k) >= radius_m).collect();
        let mut part = vec![0u32; stands.len()];
        let (mut n_parts, mut largest, mut most) = (0, 0, 0);
        let mut waiting = Vec::new();
        for start in 0..stands.len() {
            if !stands[start] || part[start] != 0 {
                continue;
            }
            n_parts += 1;
            part[start] = n_parts;
            waiting.push(start);
            let mut n_cells = 0;
            while let Some(cell) = waiting.pop() {
                n_cells += 1;
                let (row, column) = (cell / width, cell % width);
                let left = (column > 0).then(|| cell - 1);
                let right = (column + 1 < width).then(|| cell + 1);
                let below = (row > 0).then(|| cell - width);
                let above = Some(cell + width).filter(|c| *c < stands.len());
                for next in [left, right, below, above].into_iter().flatten() {
                    if stands[next] && part[next] == 0 {
                        part[next] = n_parts;
                        waiting.push(next);
                    }
                }
            }
            if n_cells > most {
                (largest, most) = (n_parts, n_cells);
            }
        }
        Self { part, largest }
    }

    /// True if a robot can stand on the cell and get there.
    pub(crate) fn contains(&self, cell: usize) -> bool {
        self.part[cell] != 0 && self.part[cell] == self.largest
    }

    /// True if a robot can get to the cell or one next to it: a place between cell centres may be clear although that of
    /// its own cell is not.
    pub(crate) fn is_beside(&self, spec: &GridSpec, cell: Cell) -> bool {
        let around = |at: u32, n: u32| at.saturating_sub(1)..(at + 2).min(n);
        around(cell.row, spec.height)
            .any(|row| around(cell.column, spec.width).any(|column| self.contains(spec.index(Cell { column, row }))))
    }

    /// True if a robot can stand on the cell, wherever it is.
    pub(crate) fn can_stand(&self, cell: usize) -> bool {
        self.part[cell] != 0
    }
}
