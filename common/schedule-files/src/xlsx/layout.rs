//! The place of the table of tasks in a sheet: its headings, its first row, and days with crosses.

use super::sheet::Sheet;
use crate::ReadOptions;
use crate::csv::{self, Columns, DATE_COLUMNS};
use crate::options::CsvColumn;
use jiff::civil::Date;
use std::collections::BTreeSet;

/// Rows with something in them that are looked through for headings.
const MAX_HEADING_ROWS: usize = 100;
/// Fewer days are columns of dates that happen to stand beside each other.
const MIN_DAYS: usize = 3;
/// Columns that say which task a row is.
pub(super) const IDENTITY: [CsvColumn; 3] = [CsvColumn::Id, CsvColumn::Code, CsvColumn::Name];

/// A table of tasks in a sheet.
#[derive(Debug)]
pub(super) struct Layout {
    pub(super) columns: Columns,
    pub(super) headings: Vec<String>,
    /// The row of the headings, from 0.
    pub(super) heading_row: u32,
    /// The first row below them.
    pub(super) first_row: u32,
    /// Columns of days, if tasks are crosses below days.
    pub(super) grid: Option<Grid>,
}

/// Columns that are days, or weeks by their first day.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Grid {
    row: u32,
    /// Columns of the sheet, from 0.
    pub(super) days: Vec<(u32, Date)>,
    /// Each is a week.
    pub(super) is_weekly: bool,
}

impl Layout {
    /// The row whose headings say most, with the days beside it.
    ///
    /// # Errors
    /// There is none; what is lacking, in a sentence about the sheet.
    pub(super) fn of(sheet: &Sheet, options: &ReadOptions) -> Result<Self, String> {
        let mut best: Option<(usize, u32, Vec<String>)> = None;
        for row in sheet.rows.keys().copied().take(MAX_HEADING_ROWS) {
            for headings in [headings(sheet, row, false), headings(sheet, row, true)] {
                let n_known = known(&headings, options).map_or(0, |columns| columns.known().count());
                if n_known > best.as_ref().map_or(0, |(n, ..)| *n) {
                    best = Some((n_known, row, headings));
                }
            }
        }
        let Some((_, heading_row, mut headings)) = best else { return Err(lack(options)) };
        let columns = known(&headings, options).ok_or_else(|| lack(options))?;
        let grid = grid(sheet, heading_row, &columns, options);
        let mut first_row = heading_row + 1;
        if let Some(grid) = &grid {
            first_row = first_row.max(grid.row + 1);
            for (column, _) in &grid.days {
                if let Some(heading) = headings.get_mut(*column as usize) {
                    heading.clear();
                }
            }
            for (column, heading) in [(CsvColumn::Start, "Start"), (CsvColumn::Finish, "Finish")] {
                if columns.index_of(column).is_none() {
                    // Behind the days, where a row has nothing of its own.
                    let last = grid.days.iter().map(|(column, _)| *column as usize + 1).max().unwrap_or(0);
                    headings.resize(headings.len().max(last), String::new());
                    headings.push(heading.to_owned());
                }
            }
        }
        let columns = known(&headings, options).ok_or_else(|| lack(options))?;
        Ok(Self { columns, headings, heading_row, first_row, grid })
    }

    /// True if the table says when tasks are.
    pub(super) fn has_times(&self) -> bool {
        let is_time = |column: &CsvColumn| {
            DATE_COLUMNS.as_flattened().contains(column)
                || [CsvColumn::Duration, CsvColumn::RemainingDuration, CsvColumn::Predecessors].contains(column)
        };
        self.columns.known().any(|(column, _)| is_time(&column))
    }
}

/// The columns that headings name, if they name tasks.
fn known(headings: &[String], options: &ReadOptions) -> Option<Columns> {
    let texts: Vec<&str> = headings.iter().map(String::as_str).collect();
    Columns::of(&texts, options, 0).ok()
}

/// What a sheet without headings lacks.
fn lack(options: &ReadOptions) -> String {
    match options.columns.values().map(|heading| format!("{heading:?}")).collect::<Vec<_>>() {
        named if named.is_empty() => "no row has a heading of the id, code or name of tasks".to_owned(),
        named => format!("no row has the headings {} of csv_columns beside an id, code or name", named.join(", ")),
    }
}

/// The texts of a row, also with those of merged cells above it before them: `Actual` over `Start` and `Finish`.
fn headings(sheet: &Sheet, row: u32, with_groups: bool) -> Vec<String> {
    let n = sheet.last_column(row).map_or(0, |last| last + 1);
    let text = |row: u32, column: u32| {
        let text = sheet.cell(row, column).map(|cell| cell.text()).unwrap_or_default();
        text.split_whitespace().collect::<Vec<_>>().join(" ")
    };
    let group = |column: u32| {
        let above = row.checked_sub(1).filter(|_| with_groups)?;
        let first = sheet.notes.covered_by.get(&(above, column)).copied().unwrap_or((above, column));
        let is_wide = sheet.notes.covered_by.get(&(first.0, first.1 + 1)) == Some(&first);
        Some(text(above, column)).filter(|text| is_wide && !text.is_empty())
    };
    (0..n)
        .map(|column| match (group(column), text(row, column)) {
            (Some(group), own) if own != group && !own.is_empty() => format!("{group} {own}"),
            (_, own) => own,
        })
        .collect()
}

/// Days in the row of the headings, or near it.
fn grid(sheet: &Sheet, heading_row: u32, columns: &Columns, options: &ReadOptions) -> Option<Grid> {
    let taken: BTreeSet<u32> = columns.known().map(|(_, k)| k as u32).collect();
    let is_task = |row: u32| {
        let identity = IDENTITY.iter().filter_map(|column| columns.index_of(*column));
        row > heading_row && identity.into_iter().any(|k| sheet.own(row, k as u32).is_some())
    };
    let rows = heading_row.saturating_sub(3)..=heading_row + 2;
    let grids = rows.filter(|row| !is_task(*row)).filter_map(|row| days_in(sheet, row, &taken, options));
    grids.reduce(|best, grid| if grid.days.len() > best.days.len() { grid } else { best })
}

fn days_in(sheet: &Sheet, row: u32, taken: &BTreeSet<u32>, options: &ReadOptions) -> Option<Grid> {
    let columns = 0..sheet.last_column(row)? + 1;
    let cells: Vec<_> = columns
        .filter(|column| !taken.contains(column))
        .filter_map(|column| Some((column, sheet.cell(row, column)?)))
        .collect();
    let texts: Vec<String> = cells.iter().map(|(_, cell)| cell.text()).collect();
    let order = options.date_format.or_else(|| csv::decided(texts.iter().map(String::as_str)).ok());
    let day = |text: &str| csv::date(text, order?).filter(|date| date.is_day).map(|date| date.at.0.date());
    let days: Vec<(u32, Date)> = cells
        .iter()
        .zip(&texts)
        .filter_map(|((column, cell), text)| Some((*column, cell.day().or_else(|| day(text))?)))
        .collect();
    let mut distinct: Vec<Date> = days.iter().map(|(_, day)| *day).collect();
    distinct.dedup();
    let steps = || distinct.windows(2).map(|pair| pair[0].until(pair[1]).map_or(0, |span| span.get_days()));
    // Days of a week, with or without its end; or weeks.
    let is_weekly = steps().all(|days| days == 7);
    let is_grid = distinct.len() >= MIN_DAYS && (is_weekly || steps().all(|days| (1..=3).contains(&days)));
    is_grid.then_some(Grid { row, days, is_weekly })
}
