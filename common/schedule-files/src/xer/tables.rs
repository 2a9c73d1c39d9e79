//! The tables of an XER file, as text.

use crate::PlanFileError;
use crate::p6::Record;
use std::borrow::Cow;
use std::collections::HashMap;

/// All tables of a file.
#[derive(Debug, Default)]
pub(super) struct Tables<'a> {
    /// Version of P6 that wrote it.
    pub(super) version: &'a str,
    /// Its end mark was not found: it may be cut off.
    pub(super) is_cut: bool,
    tables: HashMap<&'a str, Table<'a>>,
}

/// One table. Rows are split when they are read, so that a large file is held once.
#[derive(Debug, Default)]
pub(super) struct Table<'a> {
    /// Line of the names of its columns, from 1.
    line: usize,
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
        let version = header.split('\t').nth(1).unwrap_or("");
        let mut tables = Self { version, is_cut: true, tables: HashMap::new() };
        let mut name = "";
        // Where the row that may go on starts, as texts with line breaks do.
        let mut start = None;
        let mut at = 0;
        for (number, line) in (1..).zip(text.split_inclusive('\n')) {
            let (from, marker) = (at, line.get(..2).filter(|_| line.starts_with('%')));
            at += line.len();
            let line = line.trim_end_matches(['\r', '\n']);
            let rest = line.get(3..).unwrap_or("");
            match marker {
                Some("%T") => (name, start) = (rest.trim(), None),
                Some("%F") => {
                    start = None;
                    let columns = rest.split('\t').enumerate().map(|(k, column)| (column.trim(), k)).collect();
                    tables.tables.entry(name).or_insert_with(|| Table { line: number, columns, rows: Vec::new() });
                }
                Some("%R") => {
                    start = Some(from + line.len() - rest.len());
                    if let Some(table) = tables.tables.get_mut(name) {
                        table.rows.push(rest);
                    }
                }
                Some("%E") => {
                    tables.is_cut = false;
                    break;
                }
                _ => {
                    let row = tables.tables.get_mut(name).and_then(|table| table.rows.last_mut());
                    if let (Some(start), Some(row)) = (start, row) {
                        *row = &text[start..from + line.len()];
                    }
                }
            }
        }
        Some(tables)
    }

    /// Checks that a table has columns, if the file has the table.
    ///
    /// # Errors
    /// A column that is not there.
    pub(super) fn require(&self, name: &str, columns: &[&str]) -> Result<(), PlanFileError> {
        let Some(table) = self.tables.get(name) else { return Ok(()) };
        match columns.iter().find(|column| !table.columns.contains_key(**column)) {
            Some(column) => {
                Err(PlanFileError::Table { line: table.line, why: format!("{name} has no column {column}") })
            }
            None => Ok(()),
        }
    }

    /// True if the file has the table, and the table no such column.
    pub(super) fn lacks(&self, name: &str, column: &str) -> bool {
        self.tables.get(name).is_some_and(|table| !table.columns.contains_key(column))
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
    pub(super) fn get(&self, column: &str) -> &'a str {
        self.columns.get(column).and_then(|k| self.cells.get(*k)).map_or("", |cell| cell.trim())
    }
}

impl Record for Row<'_, '_> {
    fn cell(&self, name: &str) -> &str {
        self.get(name)
    }

    /// P6 writes line breaks as the character 7F, and quotes twice.
    fn text(&self, name: &str) -> Cow<'_, str> {
        let cell = self.get(name);
        if cell.contains(['\u{7f}', '"']) {
            cell.replace('\u{7f}', "\n").replace("\"\"", "\"").into()
        } else {
            cell.into()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_row_goes_on_over_line_breaks() {
        let text = "ERMHDR\t19.12\t2024\r\n%T\tA\r\n%F\tx\ty\r\n%R\t1\ttwo\r\nlines\r\n%R\t2\t\u{7f}\"\"b\"\r\n%E\r\n%R\t3\r\n";
        let tables = Tables::of(text).unwrap();
        assert_eq!(tables.version, "19.12");
        let rows: Vec<_> = tables.rows("A").map(|r| (r.get("x"), r.text("y").into_owned(), r.get("z"))).collect();
        assert_eq!(rows, [("1", "two\r\nlines".into(), ""), ("2", "\n\"b\"".into(), "")]);
        assert_eq!(tables.rows("B").count(), 0);
    }

    #[test]
    fn rows_without_a_table_are_passed_over() {
        assert!(Tables::of("%T\tA").is_none());
        let tables = Tables::of("ERMHDR\n%R\t1\ngoes on\n%T\tA\n%R\t1\n%").unwrap();
        assert!(tables.rows("A").count() == 0 && tables.is_cut);
        assert_eq!(Tables::of("ERMHDR\n%T\tA\n%R\t1\n%F\tx\ngoes on").unwrap().rows("A").count(), 0);
        let tables = Tables::of("ERMHDR\n%T\tA\n%F\tx\n%Ró\ngoes on").unwrap();
        assert_eq!(tables.rows("A").map(|row| row.get("x")).collect::<Vec<_>>(), ["goes on"]);
    }

    #[test]
    fn a_table_without_a_column_that_is_needed_is_an_error_with_its_line() {
        let tables = Tables::of("ERMHDR\n%T\tA\n%F\tx\ty\n%E\n").unwrap();
        assert!(tables.require("A", &["y", "x"]).is_ok() && tables.require("B", &["x"]).is_ok());
        assert_eq!(tables.require("A", &["x", "z"]).unwrap_err().to_string(), "line 3: A has no column z");
    }
}
