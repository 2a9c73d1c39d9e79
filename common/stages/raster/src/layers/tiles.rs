//! Tiles with margins, in which layers that depend on neighbouring cells are computed.

use grid::{CellRect, Growth};

/// Columns and rows of a window: small enough for a processor's cache, large beside the margins around it.
pub(crate) const SIDE: u32 = 512;

/// The cells of a rectangle, row by row.
pub(crate) fn rows<'a>(cells: &'a [u8], rect: &CellRect, whole: &CellRect) -> impl Iterator<Item = &'a [u8]> {
    rect.rows(whole.width()).map(|row| &cells[row])
}

/// What was grown in a window, without what lies around it.
pub(crate) fn inner_rows<'a>(
    growth: &'a Growth,
    window: &CellRect,
    around: &CellRect,
) -> impl Iterator<Item = &'a [u8]> {
    let [columns, rows] = [0, 1].map(|k| (window.min[k] - around.min[k]) as usize);
    growth.rows().skip(rows).map(move |row| &row[columns..])
}
