//! Tiles with margins, for layers whose cells depend on neighbouring cells.

use grid::{CellRect, Growth};

/// Columns and rows of a tile: small enough for a processor's cache, large compared with the margins around it.
pub(crate) const TILE_CELLS: u32 = 512;

/// The cells of a rectangle, row by row.
pub(crate) fn rows<'a>(cells: &'a [u8], rect: &CellRect, whole: &CellRect) -> impl Iterator<Item = &'a [u8]> {
    rect.rows(whole.width()).map(|row| &cells[row])
}

/// The grown rows of a tile, without its margin.
pub(crate) fn inner_rows<'a>(growth: &'a Growth, tile: &CellRect, around: &CellRect) -> impl Iterator<Item = &'a [u8]> {
    let [columns, rows] = [0, 1].map(|k| (tile.min[k] - around.min[k]) as usize);
    growth.rows().skip(rows).map(move |row| &row[columns..])
}
