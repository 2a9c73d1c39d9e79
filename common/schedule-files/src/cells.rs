//! Cells of tables that spreadsheets open: texts of models that would be formulas are written as texts.
//!
//! # Source
//! OWASP, CSV Injection: cells that begin with `=`, `+`, `-`, `@`, a tab or a carriage return, also in full width.

use std::borrow::Cow;

/// What spreadsheets write before a text so that it stays one.
const MARK: char = '\'';
/// A cell that begins with one of these may be a formula.
const STARTS: [char; 8] = ['=', '+', '-', '@', '＝', '＋', '－', '＠'];

/// A text as a cell; [`text_of`] takes it back.
pub fn cell_of(text: &str) -> Cow<'_, str> {
    if needs_mark(text) { Cow::Owned(format!("{MARK}{text}")) } else { Cow::Borrowed(text) }
}

/// The text of a cell.
pub fn text_of(cell: &str) -> &str {
    cell.strip_prefix(MARK).filter(|text| needs_mark(text)).unwrap_or(cell)
}

/// True for what may be a formula, and for the same with marks before it: these are texts of their own.
fn needs_mark(text: &str) -> bool {
    text.starts_with(['\t', '\r'])
        || text.trim_start_matches(|c: char| c == MARK || c.is_whitespace()).starts_with(STARTS)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn formulas_become_texts_and_all_texts_come_back() {
        for formula in ["=1+1", "+49", "-1020", "@SUM(A1)", " =HYPERLINK(\"x\")", "\t=1", "＝1"] {
            assert!(cell_of(formula).starts_with(MARK), "{formula}");
        }
        for text in ["", "A-1020", "'quoted'", "=1", "'=1", "''=1", "' =1", "1=1", "\tx"] {
            assert_eq!(text_of(&cell_of(text)), text);
        }
    }
}
