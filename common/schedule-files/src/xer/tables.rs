//! The tables of an XER file, as text.

use crate::plan::{Finding, FindingKind, PlanDate};
use crate::values;
use std::borrow::Cow;
use std::collections::HashMap;

/// All tables of a file.
#[derive(Debug, Default)]
pub(super) struct Tables<'a> {
    /// Version of P6 that wrote it.
    pub(super) version: &'a str,
    tables: HashMap<&'a str, Table<'a>>,
}

/// One table. Rows are split when they are read, so that a large file is held once.
#[derive(Debug, Default)]
pub(super) struct Table<'a> {
    columns: HashMap<&'a str, usize>,
    rows: Vec<&'a str>,
}

/// One row, with the columns of its table.
pub(super) struct Row<'t, 'a> {
    columns: &'t HashMap<&'a str, usize>,
    cells: Vec<&'a str>,
}

impl<'a> Tables<'a> {
    /// The tables of a text; `None` if it is no XER file.
    pub(super) fn of(text: &'a str) -> Option<Self> {
        let header = text.lines().next()?.strip_prefix("ERMHDR")?;
        let mut tables = Self { version: header.split('\t').nth(1).unwrap_or(""), tables: HashMap::new() };
        let mut name = "";
        // Where the row that may go on starts, as texts with line breaks do.
        let mut start = None;
        let mut at = 0;
        for line in text.split_inclusive('\n') {
            let (from, marker) = (at, line.get(..2).filter(|_| line.starts_with('%')));
            at += line.len();
            let line = line.trim_end_matches(['\r', '\n']);
            let rest = line.get(3..).unwrap_or("");
            match marker {
                Some("%T") => (name, start) = (rest.trim(), None),
                Some("%F") => {
                    let columns = rest.split('\t').enumerate().map(|(k, column)| (column.trim(), k)).collect();
                    tables.tables.entry(name).or_insert_with(|| Table { columns, rows: Vec::new() });
                }
                Some("%R") => {
                    start = Some(from + 3);
                    if let Some(table) = tables.tables.get_mut(name) {
                        table.rows.push(rest);
                    }
                }
                Some("%E") => break,
                _ => {
                    if let (Some(start), Some(table)) = (start, tables.tables.get_mut(name)) {
                        let row = table.rows.last_mut().expect("a row was started");
                        *row = &text[start..from + line.len()];
                    }
                }
            }
        }
        Some(tables)
    }

    /// True if the file has a table of this name.
    pub(super) fn has(&self, name: &str) -> bool {
        self.tables.contains_key(name)
    }

    /// Number of rows of a table.
    pub(super) fn n_rows(&self, name: &str) -> usize {
        self.tables.get(name).map_or(0, |table| table.rows.len())
    }

    /// The rows of a table; none if the file does not have it.
    pub(super) fn rows<'t>(&'t self, name: &str) -> impl Iterator<Item = Row<'t, 'a>> {
        let table = self.tables.get(name);
        let row = |table: &'t Table<'a>| {
            let row = |line: &&'a str| Row { columns: &table.columns, cells: line.split('\t').collect() };
            table.rows.iter().map(row)
        };
        table.into_iter().flat_map(row)
    }
}

impl<'a> Row<'_, 'a> {
    /// The cell without spaces around it; empty if there is none.
    pub(super) fn cell(&self, column: &str) -> &'a str {
        self.columns.get(column).and_then(|k| self.cells.get(*k)).map_or("", |cell| cell.trim())
    }

    /// A text for people: P6 writes line breaks as the character 7F.
    pub(super) fn text(&self, column: &str) -> Cow<'a, str> {
        let cell = self.cell(column);
        if cell.contains('\u{7f}') { cell.replace('\u{7f}', "\n").into() } else { cell.into() }
    }

    /// A date with time of day.
    pub(super) fn date(&self, column: &str, task: usize, findings: &mut Vec<Finding>) -> Option<PlanDate> {
        self.read(column, task, findings, values::date)
    }

    /// Hours as seconds.
    pub(super) fn hours(&self, column: &str, task: usize, findings: &mut Vec<Finding>) -> Option<i64> {
        self.read(column, task, findings, |text| values::seconds(values::number(text)?, 3600.0))
    }

    /// A share of 100.
    pub(super) fn percent(&self, column: &str, task: usize, findings: &mut Vec<Finding>) -> Option<f64> {
        self.read(column, task, findings, |text| Some((values::number(text)? / 100.0).clamp(0.0, 1.0)))
    }

    fn read<T>(
        &self,
        column: &str,
        task: usize,
        findings: &mut Vec<Finding>,
        read: impl Fn(&str) -> Option<T>,
    ) -> Option<T> {
        let text = self.cell(column);
        if text.is_empty() {
            return None;
        }
        let value = read(text);
        if value.is_none() {
            let message = format!("its {column} {text:?} cannot be read");
            findings.push(Finding { task: Some(task), kind: FindingKind::UnreadableValue, message });
        }
        value
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_row_goes_on_over_line_breaks() {
        let text =
            "ERMHDR\t19.12\t2024\r\n%T\tA\r\n%F\tx\ty\r\n%R\t1\ttwo\r\nlines\r\n%R\t2\t\u{7f}b\r\n%E\r\n%R\t3\r\n";
        let tables = Tables::of(text).unwrap();
        assert_eq!(tables.version, "19.12");
        let rows: Vec<_> = tables.rows("A").map(|r| (r.cell("x"), r.text("y").into_owned(), r.cell("z"))).collect();
        assert_eq!(rows, [("1", "two\r\nlines".into(), ""), ("2", "\nb".into(), "")]);
        assert_eq!(tables.rows("B").count(), 0);
    }

    #[test]
    fn rows_without_a_table_are_passed_over() {
        assert!(Tables::of("%T\tA").is_none());
        let tables = Tables::of("ERMHDR\n%R\t1\ngoes on\n%T\tA\n%R\t1\n%").unwrap();
        assert!(!tables.has("A") && tables.n_rows("A") == 0);
    }
}
