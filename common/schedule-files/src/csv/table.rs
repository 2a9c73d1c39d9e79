//! Rows and columns of a CSV, or of a sheet of a workbook, as text.

use super::headings::Columns;
use crate::cells::text_of;
use crate::options::CsvColumn;
use crate::values::number;
use crate::{PlanFileError, ReadOptions};
use csv::{ReaderBuilder, StringRecord};
use std::collections::HashMap;

/// Rows of a file; its tasks have a limit of their own.
const MAX_ROWS: usize = 1_100_000;

const SEPARATORS: [char; 4] = [';', '\t', '|', ','];

/// A table with known columns and no empty rows.
#[derive(Debug)]
pub(crate) struct Table {
    columns: Columns,
    rows: Vec<StringRecord>,
    /// The line, or row of a sheet, of each row; from 1.
    lines: Vec<usize>,
    /// Name of the sheet, of a workbook.
    sheet: Option<String>,
    /// Identity of the task of each row.
    uids: Vec<String>,
}

impl Table {
    /// Splits a text into rows.
    ///
    /// # Errors
    /// No row; headings that are not known; too many rows.
    pub(super) fn of(text: &str, options: &ReadOptions) -> Result<Self, PlanFileError> {
        let (named, text) = match text.strip_prefix("sep=").and_then(|rest| Some((rest.chars().next()?, rest))) {
            Some((separator, rest)) => (Some(separator), rest.split_once('\n').map_or("", |(_, rest)| rest)),
            None => (None, text),
        };
        let n_lines_before = usize::from(named.is_some());
        let separator = named.filter(char::is_ascii).unwrap_or_else(|| separator_of(text));
        let mut reader = ReaderBuilder::new()
            .delimiter(u8::try_from(separator).unwrap_or(b','))
            .has_headers(false)
            .flexible(true)
            .from_reader(text.as_bytes());
        let line = |at: Option<&csv::Position>| n_lines_before + at.map_or(0, |at| at.line() as usize);
        let mut rows = Vec::new();
        for row in reader.records() {
            let row =
                row.map_err(|error| PlanFileError::Table { line: line(error.position()), why: error.to_string() })?;
            if row.iter().any(|cell| !cell.trim().is_empty()) {
                rows.push(row);
            }
            if rows.len() > MAX_ROWS {
                return Err(PlanFileError::TooMany { max: MAX_ROWS, what: "rows" });
            }
        }
        if rows.is_empty() {
            return Err(PlanFileError::Table { line: 1, why: "it has no row".to_owned() });
        }
        let heading = rows.remove(0);
        let columns = Columns::of(&heading.iter().collect::<Vec<_>>(), options, line(heading.position()))?;
        let lines = rows.iter().map(|row| line(row.position())).collect();
        Ok(Self { columns, rows, lines, sheet: None, uids: Vec::new() }.with_uids())
    }

    /// The rows of a sheet of a workbook, none of them empty, with their numbers from 1.
    pub(crate) fn of_sheet(sheet: &str, columns: Columns, rows: Vec<(usize, StringRecord)>) -> Self {
        let (lines, rows) = rows.into_iter().unzip();
        Self { columns, rows, lines, sheet: Some(sheet.to_owned()), uids: Vec::new() }.with_uids()
    }

    fn with_uids(mut self) -> Self {
        let place = if self.sheet.is_some() { "row" } else { "line" };
        let uid = |row: usize| {
            let named = [CsvColumn::Id, CsvColumn::Code].map(|column| self.cell(row, column));
            let name = named.into_iter().find(|cell| !cell.is_empty());
            name.map_or_else(|| format!("{place} {}", self.lines[row]), str::to_owned)
        };
        self.uids = (0..self.len()).map(uid).collect();
        self
    }

    /// What is added to a message about a cell: its place in a workbook; nothing for a CSV, whose task says it.
    pub(super) fn place(&self, row: usize, column: CsvColumn) -> String {
        let at = self.sheet.as_ref().zip(self.columns.index_of(column));
        at.map_or_else(String::new, |(sheet, k)| {
            format!(" (cell {}{} of sheet {sheet:?})", letters(k), self.lines[row])
        })
    }

    /// Number of rows.
    pub(super) fn len(&self) -> usize {
        self.rows.len()
    }

    /// Identity of the task of a row.
    pub(super) fn uid(&self, row: usize) -> &str {
        &self.uids[row]
    }

    /// A cell without spaces around it; empty if there is none.
    pub(super) fn cell(&self, row: usize, column: CsvColumn) -> &str {
        self.columns.index_of(column).and_then(|k| self.rows[row].get(k)).map_or("", |cell| text_of(cell.trim()))
    }

    /// Heading of a column.
    pub(super) fn heading(&self, column: CsvColumn) -> &str {
        self.columns.heading(column)
    }

    /// The unit of the lengths of a column that say none, where its heading says it; empty for days.
    pub(super) fn unit(&self, column: CsvColumn) -> &'static str {
        let heading = self.heading(column).to_lowercase();
        let is_in = |words: &[&str]| heading.split(|c: char| !c.is_alphanumeric()).any(|word| words.contains(&word));
        if is_in(&["week", "weeks", "wks", "wochen"]) {
            "w"
        } else if is_in(&["hour", "hours", "hrs", "stunden"]) {
            "h"
        } else {
            ""
        }
    }

    /// The cells of a column.
    pub(super) fn cells(&self, column: CsvColumn) -> impl Iterator<Item = &str> {
        (0..self.len()).map(move |row| self.cell(row, column))
    }

    /// Headings and cells that are fields.
    pub(super) fn fields(&self, row: usize) -> impl Iterator<Item = (&str, &str)> {
        self.columns
            .fields
            .iter()
            .map(move |(k, name)| (name.as_str(), self.rows[row].get(*k).map_or("", |cell| text_of(cell.trim()))))
    }

    /// True if a row has cells behind the last column.
    pub(super) fn is_too_long(&self, row: usize) -> bool {
        self.rows[row].iter().skip(self.columns.len()).any(|cell| !cell.trim().is_empty())
    }

    /// What the numbers of a column are shares of: 100, or 1 where none is larger and one is neither 0 nor 1.
    pub(super) fn percent(&self, column: CsvColumn) -> f64 {
        let numbers = || self.cells(column).filter_map(number);
        let is_share = self.cells(column).all(|cell| !cell.contains('%'))
            && numbers().all(|value| (0.0..=1.0).contains(&value))
            && numbers().any(|value| 0.0 < value && value < 1.0);
        if is_share { 1.0 } else { 100.0 }
    }

    /// Identity of the task that each is nested in.
    pub(super) fn parents(&self) -> Vec<Option<String>> {
        if self.columns.index_of(CsvColumn::Parent).is_some() {
            let parent = |cell: &str| (!cell.is_empty()).then(|| cell.to_owned());
            return self.cells(CsvColumn::Parent).map(parent).collect();
        }
        if self.columns.index_of(CsvColumn::OutlineLevel).is_some() {
            return self.parents_by_level();
        }
        self.parents_by_wbs()
    }

    fn parents_by_level(&self) -> Vec<Option<String>> {
        let mut line: Vec<(u32, &str)> = Vec::new();
        let mut parents = Vec::with_capacity(self.len());
        for (row, cell) in self.cells(CsvColumn::OutlineLevel).enumerate() {
            let level = cell.parse().unwrap_or(1);
            while line.pop_if(|(above, _)| *above >= level).is_some() {}
            parents.push(line.last().map(|(_, uid)| (*uid).to_owned()));
            line.push((level, self.uid(row)));
        }
        parents
    }

    fn parents_by_wbs(&self) -> Vec<Option<String>> {
        let mut by_wbs = HashMap::new();
        for (row, wbs) in self.cells(CsvColumn::Wbs).enumerate().filter(|(_, wbs)| !wbs.is_empty()) {
            if by_wbs.insert(wbs, row).is_some() {
                return vec![None; self.len()];
            }
        }
        let parent = |wbs: &str| {
            let above = wbs.rmatch_indices('.').take(MAX_LEVELS).map(|(at, _)| &wbs[..at]);
            above.filter_map(|above| by_wbs.get(above)).next().map(|row| self.uid(*row).to_owned())
        };
        self.cells(CsvColumn::Wbs).map(parent).collect()
    }
}

/// Letters of a column of a sheet, from `A`.
pub(crate) fn letters(column: usize) -> String {
    let mut letters = Vec::new();
    let mut rest = column + 1;
    while rest > 0 {
        letters.push(char::from(b'A' + ((rest - 1) % 26) as u8));
        rest = (rest - 1) / 26;
    }
    letters.into_iter().rev().collect()
}

/// Levels of a work breakdown that are looked for.
const MAX_LEVELS: usize = 64;

/// The separator by which the heading has most columns; the first of those with equally many.
fn separator_of(text: &str) -> char {
    let heading = text.lines().find(|line| !line.trim().is_empty()).unwrap_or("");
    let n_columns = |separator: char| {
        let mut is_quoted = false;
        let is_separator = |c: &char| {
            is_quoted ^= *c == '"';
            *c == separator && !is_quoted
        };
        heading.chars().filter(is_separator).count()
    };
    let most = SEPARATORS.iter().map(|separator| n_columns(*separator)).max().unwrap_or(0);
    SEPARATORS.into_iter().find(|separator| n_columns(*separator) == most).unwrap_or(',')
}
