//! Keep-out mask from cell flags: drop-offs, blocked spaces, cells under elements that are worked on, with margins grown
//! through free cells.

use super::cell_flags::{BLOCKED, NAV_OCCUPIED, NAV_UNKNOWN, OUTLINE, WORK, is_edge, is_free, is_void};
use super::tile::{inner_rows, rows};
use crate::model::storey_inputs::StoreyInputs;
use grid::{CellRect, Growth, REACHED};

/// A margin around drop-offs.
const EDGE_MARGIN: u8 = 1;
/// A margin around work.
const WORK_MARGIN: u8 = 2;

/// Regions of the growth of margins.
mod region {
    pub(super) const EDGE: u8 = 1;
    pub(super) const FREE: u8 = 2;
    pub(super) const WORK: u8 = 4;
}

/// Margins of the keep-out mask in cells.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Margins {
    /// Around drop-offs.
    pub(crate) edge_cells: f64,
    /// Around work.
    pub(crate) work_cells: f64,
}

impl Margins {
    /// The robot's margins in cells of a storey.
    pub(crate) fn of(inputs: StoreyInputs<'_>) -> Self {
        let StoreyInputs { robot, storey, .. } = inputs;
        let cells = |metres_m: f64| metres_m / frames::metres(storey.spec.cell_tenths);
        Self { edge_cells: cells(robot.edge_margin_m), work_cells: cells(robot.work_margin_m) }
    }

    /// Width of the margin beyond the rim of a slab: at least one cell.
    fn beyond_edge_cells(self) -> f64 {
        self.edge_cells.max(1.0)
    }

    /// Columns and rows from a cell within which the margins of edges depend on other cells.
    pub(crate) fn edge_reach(self) -> u32 {
        reach(self.beyond_edge_cells())
    }

    /// The same for the margins of work.
    pub(crate) fn work_reach(self) -> u32 {
        reach(self.work_cells)
    }
}

/// One cell more than the margin, because of rounding.
fn reach(cells: f64) -> u32 {
    cells.floor() as u32 + 1
}

/// The mask in a cell: occupied for blocked spaces, work, cells without floor inside the outline, and margins; unknown for all else.
/// It is never free: Nav2's filter would write that over unknown cells of the costmap.
pub(crate) const fn keepout_value(flags: u8, margins: u8) -> i8 {
    let is_keep_out = (flags & (WORK | BLOCKED) != 0) | (margins != 0) | ((flags & OUTLINE != 0) & is_void(flags));
    if is_keep_out { NAV_OCCUPIED } else { NAV_UNKNOWN }
}

/// The keep-out mask of a storey and its inputs.
pub(crate) struct Keepout<'a> {
    pub(crate) flags: &'a [u8],
    /// Margins of each cell.
    pub(crate) margins: &'a mut [u8],
    pub(crate) layer: &'a mut [i8],
    pub(crate) whole: CellRect,
}

impl Keepout<'_> {
    /// Recomputes a tile after drop-offs, obstacles or blocked spaces changed.
    ///
    /// Margins grow through free cells only, so that they never leak through a wall. Outside the outline only cells next to
    /// free cells are marked: beyond a door, or beyond the rim of a slab.
    pub(crate) fn edges(&mut self, growth: &mut Growth, margins: Margins, tile: &CellRect) {
        let around = tile.grown(margins.edge_reach(), &self.whole);
        growth.load(around.width(), rows(self.flags, &around, &self.whole), |flags| {
            u8::from(is_edge(flags)) * region::EDGE + u8::from(is_free(flags)) * region::FREE
        });
        growth.grow(region::EDGE, region::FREE, margins.edge_cells);
        growth.grow(region::FREE, region::EDGE, margins.beyond_edge_cells());
        self.write(growth, EDGE_MARGIN, tile, &around);
    }

    /// Recomputes a tile after work or its surroundings changed.
    pub(crate) fn work(&mut self, growth: &mut Growth, margins: Margins, tile: &CellRect) {
        let around = tile.grown(margins.work_reach(), &self.whole);
        growth.load(around.width(), rows(self.flags, &around, &self.whole), |flags| {
            u8::from(flags & WORK != 0) * region::WORK + u8::from(is_free(flags)) * region::FREE
        });
        growth.grow(region::WORK, region::FREE, margins.work_cells);
        self.write(growth, WORK_MARGIN, tile, &around);
    }

    /// Stores one margin from the grown cells and writes the mask.
    fn write(&mut self, growth: &Growth, margin: u8, tile: &CellRect, around: &CellRect) {
        for (row, grown) in tile.rows(self.whole.width()).zip(inner_rows(growth, tile, around)) {
            let layer = self.layer[row.clone()].iter_mut();
            let cells = layer.zip(&mut self.margins[row.clone()]).zip(&self.flags[row]).zip(grown);
            for (((out, margins), &flags), &grown) in cells {
                *margins = (*margins & !margin) | if grown & REACHED != 0 { margin } else { 0 };
                *out = keepout_value(flags, *margins);
            }
        }
    }
}
