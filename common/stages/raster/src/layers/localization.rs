//! Localization layer: a two-cell shell of finished structure at lidar height that faces floor.

use super::cell_flags::{DOOR, FLOOR, NAV_FREE, NAV_OCCUPIED, NAV_UNKNOWN, OCCUPIED, STRUCTURE};
use super::tile::{inner_rows, rows};
use grid::{CellRect, Growth, REACHED};

/// Cells of depth that are drawn of a wall; thicker walls pull scan matchers inward.
const SHELL_CELLS: f64 = 2.0;

/// Regions of the growth of visible structure.
mod region {
    pub(super) const FLOOR: u8 = 1;
    pub(super) const STRUCTURE: u8 = 2;
    /// Between floor and structure.
    pub(super) const GAP: u8 = 4;
    /// Between such a gap and structure: where the gaps along two walls meet.
    pub(super) const GAP_CORNER: u8 = 8;
}

/// The layer in a cell: occupied for structure that is seen, free for floor without obstacle, unknown for all else.
pub(crate) const fn localization_value(flags: u8, is_seen: bool) -> i8 {
    if is_seen {
        NAV_OCCUPIED
    } else if flags & (FLOOR | STRUCTURE | OCCUPIED | DOOR) == FLOOR {
        NAV_FREE
    } else {
        NAV_UNKNOWN
    }
}

/// The localization layer of a storey and its inputs.
pub(crate) struct Localization<'a> {
    pub(crate) flags: &'a [u8],
    pub(crate) layer: &'a mut [i8],
    pub(crate) whole: CellRect,
    /// Maximum number of cells in a narrow gap between floor and structure, across which a lidar sees.
    pub(crate) gap_cells: u32,
}

impl Localization<'_> {
    /// Columns and rows around a cell on which its value depends: through the shell, the corner of a gap and the gap to the
    /// floor.
    pub(crate) fn reach(&self) -> u32 {
        SHELL_CELLS as u32 + 2 * self.gap_cells + 1
    }

    /// Recomputes a tile: occupied for a shell of structure at the lidar's height that faces floor, also across a narrow
    /// gap; free for floor without obstacle; unknown for all else. Blocked spaces have no effect.
    pub(crate) fn draw(&mut self, growth: &mut Growth, tile: &CellRect) {
        let around = tile.grown(self.reach(), &self.whole);
        growth.load(around.width(), rows(self.flags, &around, &self.whole), |flags| {
            // Doors, glass, furniture and the like may hide a face that is structure all the same.
            u8::from(flags & (FLOOR | STRUCTURE) == FLOOR) * region::FLOOR
                + u8::from(flags & STRUCTURE != 0) * region::STRUCTURE
        });
        let gap_cells = self.gap_cells as usize;
        growth.bridge([region::FLOOR, region::STRUCTURE], region::GAP, gap_cells);
        growth.bridge([region::FLOOR | region::GAP, region::STRUCTURE], region::GAP_CORNER, gap_cells);
        growth.grow(region::FLOOR | region::GAP | region::GAP_CORNER, region::STRUCTURE, SHELL_CELLS);
        for (row, grown) in tile.rows(self.whole.width()).zip(inner_rows(growth, tile, &around)) {
            for ((out, &flags), &grown) in self.layer[row.clone()].iter_mut().zip(&self.flags[row]).zip(grown) {
                *out = localization_value(flags, grown & REACHED != 0);
            }
        }
    }
}
