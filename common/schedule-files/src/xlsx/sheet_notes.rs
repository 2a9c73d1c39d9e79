//! Notes of a sheet beside the values of its cells: merged cells, hidden rows, formulas that nobody has computed.

use super::parts::{reader, value};
use quick_xml::events::Event;
use std::collections::{BTreeMap, BTreeSet};

/// Rows and columns of Excel.
pub(super) const MAX_PLACE: (u32, u32) = (1_048_576, 16_384);
/// Cells that one merged cell spreads its value over; larger ones are titles.
const MAX_SPREAD_CELLS: u64 = 10_000;
/// Cells that all of them spread over.
const MAX_SPREAD: usize = 1_000_000;

/// Rows and columns are from 0.
#[derive(Debug, Default)]
pub(super) struct SheetNotes {
    /// Rows that nobody sees.
    pub(super) hidden_rows: BTreeSet<u32>,
    /// Cells with a formula and without a value.
    pub(super) without_value: Vec<(u32, u32)>,
    /// The first and the last cell of each merged one.
    pub(super) merged: Vec<[(u32, u32); 2]>,
    /// By a cell that is covered by a merged one: the first cell of that.
    pub(super) covered_by: BTreeMap<(u32, u32), (u32, u32)>,
}

impl SheetNotes {
    /// Reads them from the part of a sheet.
    ///
    /// # Errors
    /// A reference that is no cell, in a sentence.
    pub(super) fn of(text: &str) -> Result<Self, String> {
        let mut notes = Self::default();
        let mut reader = reader(text);
        let mut cell: Option<(u32, u32)> = None;
        let (mut has_formula, mut has_value, mut is_in_value) = (false, false, false);
        loop {
            match reader.read_event() {
                Ok(Event::Start(tag)) => match tag.local_name().as_ref() {
                    "dimension" => drop(value(&tag, "ref").map(|range| corners(&range)).transpose()?),
                    "row" => {
                        if let Some(row) = value(&tag, "r") {
                            let row = row.parse().ok().filter(|row| (1..=MAX_PLACE.0).contains(row));
                            let row = row.ok_or_else(|| "a row has no number of a row".to_owned())?;
                            if value(&tag, "hidden").is_some_and(|hidden| ["1", "true"].contains(&&*hidden)) {
                                notes.hidden_rows.insert(row - 1);
                            }
                        }
                    }
                    "c" => {
                        cell = value(&tag, "r").map(|name| place(&name)).transpose()?;
                        (has_formula, has_value) = (false, false);
                    }
                    "f" => has_formula = true,
                    "v" | "is" => is_in_value = true,
                    "mergeCell" => {
                        if let Some(range) = value(&tag, "ref") {
                            notes.merge(corners(&range)?);
                        }
                    }
                    _ => {}
                },
                Ok(Event::Text(_) | Event::GeneralRef(_) | Event::CData(_)) => has_value |= is_in_value,
                Ok(Event::End(tag)) => match tag.local_name().as_ref() {
                    "v" | "is" => is_in_value = false,
                    "c" if has_formula && !has_value => notes.without_value.extend(cell),
                    _ => {}
                },
                Ok(Event::Eof) => return Ok(notes),
                Ok(_) => {}
                Err(error) => return Err(error.to_string()),
            }
        }
    }

    fn merge(&mut self, [first, last]: [(u32, u32); 2]) {
        self.merged.push([first, last]);
        let n_cells = u64::from(last.0 - first.0 + 1) * u64::from(last.1 - first.1 + 1);
        if n_cells <= MAX_SPREAD_CELLS && self.covered_by.len() + (n_cells as usize) <= MAX_SPREAD {
            for row in first.0..=last.0 {
                self.covered_by.extend((first.1..=last.1).map(|column| ((row, column), first)));
            }
            self.covered_by.remove(&first);
        }
    }
}

/// The first and the last cell of `B2:C7`, or of one cell.
fn corners(range: &str) -> Result<[(u32, u32); 2], String> {
    let (first, last) = range.split_once(':').unwrap_or((range, range));
    let (first, last) = (place(first)?, place(last)?);
    if first.0 > last.0 || first.1 > last.1 {
        return Err(format!("{range:?} is no range of cells"));
    }
    Ok([first, last])
}

/// Row and column of `C7`.
fn place(name: &str) -> Result<(u32, u32), String> {
    let split = name.find(|c: char| c.is_ascii_digit()).unwrap_or(name.len());
    let (letters, digits) = name.split_at(split);
    let column = letters.bytes().try_fold(0_u32, |sum, letter| {
        let letter = letter.to_ascii_uppercase();
        (letter.is_ascii_uppercase() && sum < MAX_PLACE.1).then(|| sum * 26 + u32::from(letter - b'A') + 1)
    });
    let row = digits.parse::<u32>().ok().filter(|_| digits.len() <= 7);
    match (row, column) {
        (Some(row), Some(column)) if 1 <= row && row <= MAX_PLACE.0 && 1 <= column && column <= MAX_PLACE.1 => {
            Ok((row - 1, column - 1))
        }
        _ => Err(format!("{name:?} is no cell")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_those_of_excel() {
        assert_eq!(place("A1"), Ok((0, 0)));
        assert_eq!(place("XFD1048576"), Ok((1_048_575, 16_383)));
        for name in ["", "A", "1", "A0", "XFE1", "A1048577", "AAAAAAAAAAAAA1", "A99999999999", "Ä1", "A1B", "$A$1"] {
            assert!(place(name).is_err(), "{name}");
        }
        assert_eq!(corners("B2:C7"), Ok([(1, 1), (6, 2)]));
        assert!(corners("C7:B2").is_err());
    }

    #[test]
    fn a_merged_cell_spreads_and_a_formula_without_value_is_told() {
        let text = "<worksheet><sheetData><row r=\"2\" hidden=\"1\"><c r=\"A2\"><f>1+1</f></c><c r=\"B2\"><f>1</f><v>1</v></c>\
                    </row></sheetData><mergeCells><mergeCell ref=\"A1:B2\"/></mergeCells></worksheet>";
        let notes = SheetNotes::of(text).unwrap();
        assert_eq!(notes.hidden_rows, [1].into());
        assert_eq!(notes.without_value, [(1, 0)]);
        assert_eq!(notes.covered_by.keys().copied().collect::<Vec<_>>(), [(0, 1), (1, 0), (1, 1)]);
    }
}
