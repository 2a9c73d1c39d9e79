//! Localization layer: a two-cell shell of finished structure at lidar height that faces floor.

use super::cell_flags::{DOOR, FLOOR, NAV_FREE, NAV_OCCUPIED, NAV_UNKNOWN, OCCUPIED, STRUCTURE};
use super::tiles::{inner_rows, rows};
use grid::{CellRect, Growth, REACHED};

/// A wall shows its face and the cell behind it: thicker walls pull scan matchers inward.
const SHELL_CELLS: f64 = 2.0;

/// Regions of the growth of what a lidar sees.
mod seen {
    pub(super) const FLOOR: u8 = 1;
    pub(super) const STRUCTURE: u8 = 2;
    /// Between floor and structure.
    pub(super) const GAP: u8 = 4;
    /// Between such a gap and structure: where the gaps along two walls meet.
    pub(super) const GAP_CORNER: u8 = 8;
}

/// The localization layer of a storey, and what it is made from.
pub(crate) struct Localization<'a> {
    pub(crate) facts: &'a [u8],
    pub(crate) layer: &'a mut [i8],
    pub(crate) whole: CellRect,
    /// Most cells without floor in a gap between floor and structure that a lidar looks across.
    pub(crate) gap_cells: u32,
}

impl Localization<'_> {
    /// Columns and rows from a cell within which the layer depends on other cells: through the shell, over the corner of a gap
    /// and the gap, to the floor.
    pub(crate) fn reach(&self) -> u32 {
        SHELL_CELLS as u32 + 2 * self.gap_cells + 1
    }

    /// Computes a window: a shell of lasting structure at the lidar's height where it faces floor, also across a narrow gap,
    /// floor without anything on it free, all else unknown. Blocking a space changes nothing.
    pub(crate) fn draw(&mut self, growth: &mut Growth, window: &CellRect) {
        let around = window.grown(self.reach(), &self.whole);
        growth.load(around.width(), rows(self.facts, &around, &self.whole), |facts| {
            // Doors, glass, furniture and the like may hide a face that is structure all the same.
            u8::from(facts & (FLOOR | STRUCTURE) == FLOOR) * seen::FLOOR
                + u8::from(facts & STRUCTURE != 0) * seen::STRUCTURE
        });
        let gap_cells = self.gap_cells as usize;
        growth.bridge([seen::FLOOR, seen::STRUCTURE], seen::GAP, gap_cells);
        growth.bridge([seen::FLOOR | seen::GAP, seen::STRUCTURE], seen::GAP_CORNER, gap_cells);
        growth.grow(seen::FLOOR | seen::GAP | seen::GAP_CORNER, seen::STRUCTURE, SHELL_CELLS);
        for (row, grown) in window.rows(self.whole.width()).zip(inner_rows(growth, window, &around)) {
            for ((out, &facts), &grown) in self.layer[row.clone()].iter_mut().zip(&self.facts[row]).zip(grown) {
                *out = if grown & REACHED != 0 {
                    NAV_OCCUPIED
                } else if facts & (FLOOR | STRUCTURE | OCCUPIED | DOOR) == FLOOR {
                    NAV_FREE
                } else {
                    NAV_UNKNOWN
                };
            }
        }
    }
}
