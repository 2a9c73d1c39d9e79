//! The rows of a sheet as those of a table, and what is said about them.

use super::layout::{Grid, IDENTITY, Layout};
use super::sheet::{Sheet, cell_name};
use crate::PlanFileError;
use crate::csv::{DATE_COLUMNS, Remark};
use crate::options::CsvColumn;
use csv::StringRecord;
use jiff::ToSpan;
use jiff::civil::{Date, Weekday};
use std::collections::BTreeSet;

/// Cells of all rows together, empty ones included.
const MAX_TABLE_CELLS: usize = 1 << 24;
/// Bytes of them: many may be covered by a merged cell with a long text.
const MAX_TABLE_BYTES: usize = 1 << 28;
/// Names in a remark.
const MAX_NAMED: usize = 8;
/// What people set for a day of work; so is any number above 0.
const CROSSES: [&str; 9] = ["x", "×", "✓", "✔", "✗", "✘", "■", "●", "*"];

/// Rows of a table, and what is said about them.
#[derive(Debug, Default)]
pub(super) struct Rows {
    /// Number of the row in the sheet, from 1, and its cells.
    pub(super) rows: Vec<(usize, StringRecord)>,
    pub(super) remarks: Vec<Remark>,
}

/// The rows of tasks in a sheet.
///
/// # Errors
/// More of them than a schedule has.
pub(super) fn rows_of(sheet: &Sheet, layout: &Layout) -> Result<Rows, PlanFileError> {
    let n_columns = layout.headings.len();
    let below = || sheet.rows.range(layout.first_row..);
    if below().count() * n_columns > MAX_TABLE_CELLS {
        return Err(PlanFileError::TooMany { max: MAX_TABLE_CELLS, what: "cells in a table" });
    }
    let mut found = Rows::default();
    let (mut titles, mut unnamed, mut hidden) = (Vec::new(), Vec::new(), Vec::new());
    // Rows with crosses, and their days.
    let mut worked: Vec<(usize, BTreeSet<Date>)> = Vec::new();
    let mut n_bytes = 0;
    for row in below().map(|(row, _)| *row) {
        let mut cells = cells_of(sheet, layout, row);
        let identity = || IDENTITY.iter().filter_map(|column| layout.columns.index_of(*column));
        if identity().all(|k| cells[k].trim().is_empty()) {
            if cells.iter().any(|cell| !cell.trim().is_empty()) {
                unnamed.push(row);
            }
            continue;
        }
        if identity().filter(|k| !cells[*k].is_empty()).all(|k| cells[k] == layout.headings[k]) {
            // Headings again, as on the next page.
            continue;
        }
        if is_title(sheet, layout, row) {
            titles.push(row);
            continue;
        }
        let index = found.rows.len();
        if let Some(grid) = &layout.grid {
            let (days, others) = crosses(sheet, grid, row);
            if !others.is_empty() {
                let message = format!("{} of sheet {:?} is no cross and does not count", listed(&others), sheet.name);
                found.remarks.push(Remark { row: Some(index), message });
            }
            found
                .remarks
                .extend(set_dates(layout, grid, &days, &mut cells).map(|message| Remark { row: Some(index), message }));
            worked.push((index, days));
        }
        if sheet.notes.hidden_rows.contains(&row) {
            hidden.push(row);
        }
        n_bytes += cells.iter().map(String::len).sum::<usize>();
        if n_bytes > MAX_TABLE_BYTES {
            return Err(PlanFileError::TooMany { max: MAX_TABLE_BYTES, what: "bytes of texts in a table" });
        }
        found.rows.push((row as usize + 1, StringRecord::from(cells)));
    }
    let name = &sheet.name;
    let mut remark = |rows: &[u32], what: &str| {
        if !rows.is_empty() {
            let numbers: Vec<String> = rows.iter().map(|row| (row + 1).to_string()).collect();
            let message = format!("{what} in sheet {name:?}: row {}", listed(&numbers));
            found.remarks.push(Remark { row: None, message });
        }
    };
    remark(&hidden, "hidden rows are read as the others");
    remark(&titles, "titles over several columns are no tasks");
    remark(&unnamed, "rows without an id, code or name are left out");
    let uncomputed: Vec<String> = sheet.notes.without_value.iter().map(|at| cell_name(*at)).collect();
    if !uncomputed.is_empty() {
        let message = format!(
            "formulas in sheet {name:?} have no value, and count as empty: {}; open the workbook in a spreadsheet program and save it",
            listed(&uncomputed)
        );
        found.remarks.push(Remark { row: None, message });
    }
    if let Some(grid) = &layout.grid {
        if grid.is_weekly {
            let message =
                format!("columns of sheet {name:?} are weeks: tasks last to the end of the last week with a cross");
            found.remarks.push(Remark { row: None, message });
        }
        let gaps = gaps(grid, &worked);
        found.remarks.extend(gaps.into_iter().map(|(row, message)| Remark { row: Some(row), message }));
    }
    Ok(found)
}

/// The texts of a row in the columns of the table; a merged cell counts in all that it covers, unless it says which task the row is.
fn cells_of(sheet: &Sheet, layout: &Layout, row: u32) -> Vec<String> {
    let mut texts = vec![String::new(); layout.headings.len()];
    let is_date =
        |k: usize| DATE_COLUMNS.as_flattened().iter().any(|column| layout.columns.index_of(*column) == Some(k));
    let is_identity = |k: usize| IDENTITY.iter().any(|column| layout.columns.index_of(*column) == Some(k));
    let own = sheet.rows.get(&row).into_iter().flat_map(|cells| cells.keys().copied());
    let covered = sheet.notes.covered_by.range((row, 0)..=(row, u32::MAX)).map(|((_, column), _)| *column);
    for column in own.chain(covered) {
        let k = column as usize;
        let cell = if is_identity(k) { sheet.own(row, column) } else { sheet.cell(row, column) };
        if let (Some(text), Some(cell)) = (texts.get_mut(k), cell)
            && !layout.headings[k].is_empty()
        {
            *text = if is_date(k) { cell.date_text(sheet.is_1904) } else { cell.text() };
        }
    }
    texts
}

/// True for a row whose name reaches into the next column of the table: the title of what follows.
fn is_title(sheet: &Sheet, layout: &Layout, row: u32) -> bool {
    let identity = IDENTITY.iter().filter_map(|column| layout.columns.index_of(*column)).map(|k| k as u32);
    let first = identity.filter(|column| sheet.own(row, *column).is_some()).min();
    let Some(first) = first else { return false };
    let is_covered = |column: &u32| sheet.notes.covered_by.get(&(row, *column)) == Some(&(row, first));
    let known = layout.columns.known().map(|(_, k)| k as u32);
    let days = layout.grid.iter().flat_map(|grid| grid.days.iter().map(|(column, _)| *column));
    known.chain(days).any(|column| is_covered(&column))
}

/// The days of a row with a cross, and cells that are neither empty nor a cross.
fn crosses(sheet: &Sheet, grid: &Grid, row: u32) -> (BTreeSet<Date>, Vec<String>) {
    let (mut days, mut others) = (BTreeSet::new(), Vec::new());
    for (column, day) in &grid.days {
        let text = sheet.cell(row, *column).map(|cell| cell.text()).unwrap_or_default();
        let mark = text.trim().to_lowercase();
        if CROSSES.contains(&&*mark) || mark.parse::<f64>().is_ok_and(|number| number > 0.0) {
            days.insert(*day);
        } else if !["", "0", "-", "–"].contains(&&*mark) {
            others.push(format!("{text:?} in cell {}", cell_name((row, *column))));
        }
    }
    (days, others)
}

/// Sets start and finish of a row by its crosses, unless it has its own; a sentence if these are others.
fn set_dates(layout: &Layout, grid: &Grid, days: &BTreeSet<Date>, cells: &mut [String]) -> Option<String> {
    let (first, last) = (days.first()?, days.last()?);
    let last = if grid.is_weekly { last.checked_add(6.days()).ok()? } else { *last };
    let mut differs = false;
    for (column, day) in [(CsvColumn::Start, *first), (CsvColumn::Finish, last)] {
        let cell = &mut cells[layout.columns.index_of(column)?];
        if cell.trim().is_empty() {
            *cell = day.to_string();
        } else {
            differs |= !cell.starts_with(&day.to_string());
        }
    }
    differs.then(|| format!("its crosses are from {first} to {last}; its columns of dates say otherwise and count"))
}

/// Rows whose crosses leave out days on which work was possible: those from Monday to Friday, and those on which others work.
fn gaps(grid: &Grid, worked: &[(usize, BTreeSet<Date>)]) -> Vec<(usize, String)> {
    let all: BTreeSet<Date> = grid.days.iter().map(|(_, day)| *day).collect();
    let used: BTreeSet<Date> = worked.iter().flat_map(|(_, days)| days).copied().collect();
    let is_possible = |day: &&Date| {
        grid.is_weekly || used.contains(*day) || ![Weekday::Saturday, Weekday::Sunday].contains(&day.weekday())
    };
    let gap = |(row, days): &(usize, BTreeSet<Date>)| {
        let (first, last) = (*days.first()?, *days.last()?);
        let between = all.range(first..=last).filter(is_possible).filter(|day| !days.contains(*day));
        let missing: Vec<String> = between.map(Date::to_string).collect();
        let what = if grid.is_weekly { "the weeks from" } else { "" };
        let sentence =
            || format!("its crosses leave out {what} {}; it is one task from the first to the last", listed(&missing));
        (!missing.is_empty()).then(|| (*row, sentence().replace("  ", " ")))
    };
    worked.iter().filter_map(gap).collect()
}

/// The first names, and the number of the others.
fn listed(names: &[String]) -> String {
    let first = names.iter().take(MAX_NAMED).map(String::as_str).collect::<Vec<_>>().join(", ");
    match names.len().saturating_sub(MAX_NAMED) {
        0 => first,
        n => format!("{first} and {n} more"),
    }
}
