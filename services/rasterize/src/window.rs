//! Layers that depend on the cells around: computed in windows, each with as much around it as can matter.

use crate::facts::{BLOCKED, DOOR, FLOOR, NAV_FREE, NAV_OCCUPIED, NAV_UNKNOWN, OCCUPIED, OUTLINE, STRUCTURE, WORK};
use crate::facts::{is_edge, is_free, is_void};
use grid::{CellRect, Growth};

/// A wall shows its face and the cell behind it: thicker walls pull scan matchers inward.
const SHELL_CELLS: f64 = 2.0;

/// Columns and rows of a window: small enough for a processor's cache, large beside the margins around it.
pub(crate) const SIDE: u32 = 512;

/// Margins of the keep-out mask in cells.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Margins {
    /// Around drop-offs.
    pub(crate) edge_cells: f64,
    /// Around work.
    pub(crate) work_cells: f64,
}

impl Margins {
    /// Beyond the rim of a slab at least one cell is marked.
    fn beyond_edge_cells(self) -> f64 {
        self.edge_cells.max(1.0)
    }

    /// Columns and rows from a cell within which the mask depends on other cells.
    pub(crate) fn reach(self, has_work: bool) -> u32 {
        let cells = if has_work { self.beyond_edge_cells().max(self.work_cells) } else { self.beyond_edge_cells() };
        // A cell more than the margin: a fraction may be missing to a whole number.
        cells.floor() as u32 + 1
    }
}

/// Columns and rows from a cell within which the localization layer depends on other cells.
pub(crate) const LOCALIZATION_REACH: u32 = SHELL_CELLS as u32 + 1;

/// Memory for windows, used again and again.
#[derive(Debug, Default)]
pub(crate) struct Scratch {
    growth: Growth,
    seeds: Vec<bool>,
    through: Vec<bool>,
    grown: Vec<bool>,
}

/// The facts of all cells of a storey.
#[derive(Clone, Copy)]
pub(crate) struct Facts<'a> {
    pub(crate) cells: &'a [u8],
    pub(crate) whole: CellRect,
}

impl Facts<'_> {
    fn select(&self, window: &CellRect, wanted: impl Fn(u8) -> bool, out: &mut Vec<bool>) {
        out.clear();
        out.reserve(window.n_cells());
        for row in window.rows(self.whole.width()) {
            out.extend(self.cells[row].iter().map(|&facts| wanted(facts)));
        }
    }
}

impl Scratch {
    /// Writes the keep-out mask of a window: blocked spaces, work, cells without floor inside the outline, and margins around
    /// work and edges.
    ///
    /// Margins grow through free cells only, so that they never leak through a wall. Outside the outline only what lies at
    /// the edge of free cells is marked: beyond a door, or beyond the rim of a slab.
    pub(crate) fn keepout(
        &mut self,
        facts: Facts<'_>,
        margins: Margins,
        has_work: bool,
        window: &CellRect,
        layer: &mut [i8],
    ) {
        let around = window.grown(margins.reach(has_work), &facts.whole);
        let width = around.width();
        facts.select(&around, is_edge, &mut self.seeds);
        facts.select(&around, is_free, &mut self.through);
        self.grown.clear();
        self.grown.resize(around.n_cells(), false);
        self.growth.grow(width, &self.seeds, &self.through, margins.edge_cells, &mut self.grown);
        self.growth.grow(width, &self.through, &self.seeds, margins.beyond_edge_cells(), &mut self.grown);
        if has_work {
            facts.select(&around, |f| f & WORK != 0, &mut self.seeds);
            self.growth.grow(width, &self.seeds, &self.through, margins.work_cells, &mut self.grown);
        }
        self.write(facts, window, &around, layer, |facts, grown| {
            let drop_off = facts & OUTLINE != 0 && is_void(facts);
            if grown || drop_off || facts & (WORK | BLOCKED) != 0 { NAV_OCCUPIED } else { NAV_FREE }
        });
    }

    /// Writes the localization layer of a window: a shell of lasting structure at the lidar's height where it faces floor,
    /// floor without anything on it free, all else unknown. Blocking a space changes nothing.
    pub(crate) fn localization(&mut self, facts: Facts<'_>, window: &CellRect, layer: &mut [i8]) {
        let around = window.grown(LOCALIZATION_REACH, &facts.whole);
        // Doors, glass, furniture and the like may hide a face that is structure all the same.
        facts.select(&around, |f| f & (FLOOR | STRUCTURE) == FLOOR, &mut self.seeds);
        facts.select(&around, |f| f & STRUCTURE != 0, &mut self.through);
        self.grown.clear();
        self.grown.resize(around.n_cells(), false);
        self.growth.grow(around.width(), &self.seeds, &self.through, SHELL_CELLS, &mut self.grown);
        self.write(facts, window, &around, layer, |facts, shell| {
            if shell {
                NAV_OCCUPIED
            } else if facts & (FLOOR | STRUCTURE | OCCUPIED | DOOR) == FLOOR {
                NAV_FREE
            } else {
                NAV_UNKNOWN
            }
        });
    }

    /// Writes a window of a layer from the facts and what was grown around it.
    fn write(
        &self,
        facts: Facts<'_>,
        window: &CellRect,
        around: &CellRect,
        layer: &mut [i8],
        value: impl Fn(u8, bool) -> i8,
    ) {
        let offset = [0, 1].map(|k| (window.min[k] - around.min[k]) as usize);
        let rows = self.grown.chunks_exact(around.width()).skip(offset[1]);
        for (row, grown) in window.rows(facts.whole.width()).zip(rows) {
            let cells = layer[row.clone()].iter_mut().zip(&facts.cells[row]).zip(&grown[offset[0]..]);
            for ((out, &facts), &grown) in cells {
                *out = value(facts, grown);
            }
        }
    }
}
