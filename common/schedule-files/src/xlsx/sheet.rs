//! The cells of a sheet of a workbook.

use super::cell_text::Cell;
use super::sheet_notes::{MAX_PLACE, SheetNotes};
use crate::PlanFileError;
use crate::csv::letters;
use calamine::Xlsx;
use std::collections::BTreeMap;
use std::io::Cursor;

/// Cells that are not empty.
const MAX_CELLS: usize = 4_000_000;
/// Bytes of their texts: many cells may share a long one.
const MAX_TEXT_BYTES: usize = 1 << 28;

/// Rows and columns are from 0.
#[derive(Debug)]
pub(super) struct Sheet {
    pub(super) name: String,
    /// Cells that are not empty by row, then by column.
    pub(super) rows: BTreeMap<u32, BTreeMap<u32, Cell>>,
    pub(super) notes: SheetNotes,
    /// Serial numbers of dates begin with 1904.
    pub(super) is_1904: bool,
}

impl Sheet {
    /// Reads a sheet; `text` is its part of the container.
    ///
    /// # Errors
    /// A sheet that cannot be read, more cells than a schedule has.
    pub(super) fn read(book: &mut Xlsx<Cursor<&[u8]>>, name: &str, text: &str) -> Result<Self, PlanFileError> {
        let wrong = |why: String| PlanFileError::Sheet { sheet: name.to_owned(), why };
        let notes = SheetNotes::of(text).map_err(wrong)?;
        let is_1904 = book.has_1904_epoch();
        let mut reader = book.worksheet_cells_reader(name).map_err(|error| wrong(error.to_string()))?;
        let styles = reader.styles().to_vec();
        let mut rows: BTreeMap<u32, BTreeMap<u32, Cell>> = BTreeMap::new();
        let (mut n_cells, mut n_bytes, mut last) = (0, 0, None);
        loop {
            let next = reader.next_cell_with_style_id().map_err(|error| {
                let place = last
                    .map_or_else(|| "its first cell".to_owned(), |at| format!("what follows cell {}", cell_name(at)));
                wrong(format!("{place} cannot be read: {error}"))
            })?;
            let Some((cell, style)) = next else { break };
            let at = cell.get_position();
            last = Some(at);
            if at.0 >= MAX_PLACE.0 || at.1 >= MAX_PLACE.1 {
                return Err(wrong(format!("row {}, column {} is no cell", u64::from(at.0) + 1, u64::from(at.1) + 1)));
            }
            let Some(cell) = Cell::of(cell.get_value(), styles.get(style), is_1904) else { continue };
            n_cells += 1;
            n_bytes += cell.n_bytes();
            check(n_cells, n_bytes)?;
            rows.entry(at.0).or_default().insert(at.1, cell);
        }
        Ok(Self { name: name.to_owned(), rows, notes, is_1904 })
    }

    /// The cell that stands in a place itself.
    pub(super) fn own(&self, row: u32, column: u32) -> Option<&Cell> {
        self.rows.get(&row)?.get(&column)
    }

    /// The cell in a place, or the merged one that covers it.
    pub(super) fn cell(&self, row: u32, column: u32) -> Option<&Cell> {
        self.own(row, column).or_else(|| {
            let (row, column) = *self.notes.covered_by.get(&(row, column))?;
            self.own(row, column)
        })
    }

    /// The last column of a row that has a cell, or is covered by one.
    pub(super) fn last_column(&self, row: u32) -> Option<u32> {
        let own = self.rows.get(&row).and_then(|cells| cells.keys().next_back()).copied();
        let covered =
            self.notes.covered_by.range((row, 0)..=(row, u32::MAX)).next_back().map(|((_, column), _)| *column);
        own.max(covered)
    }
}

/// # Errors
/// More than a schedule has.
fn check(n_cells: usize, n_bytes: usize) -> Result<(), PlanFileError> {
    if n_cells > MAX_CELLS {
        return Err(PlanFileError::TooMany { max: MAX_CELLS, what: "cells in a sheet" });
    }
    if n_bytes > MAX_TEXT_BYTES {
        return Err(PlanFileError::TooMany { max: MAX_TEXT_BYTES, what: "bytes of texts in a sheet" });
    }
    Ok(())
}

/// `C7`.
pub(super) fn cell_name((row, column): (u32, u32)) -> String {
    format!("{}{}", letters(column as usize), row + 1)
}
