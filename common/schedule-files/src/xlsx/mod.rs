//! Workbooks of spreadsheets (.xlsx, .xlsm): the sheet that has a table of tasks, read as a CSV of it would be.
//!
//! - The sheet is the only visible one whose headings name tasks and say when they are, or the one that the options name. Headings may
//!   stand below titles, and in two rows, of which merged cells are the upper (`Actual` over `Start` and `Finish`).
//! - Columns, dates that are texts, lengths and predecessors are those of CSV (`src/csv/mod.rs`); so are the options.
//! - Dates are serial numbers in the system of 1900 or 1904, also without a date's format where their column is one of dates. Numbers have
//!   the leading zeros, units and percent signs of their format. Formulas have the values that were saved with them.
//! - A merged cell counts in all rows and columns that it covers, but says only once which task a row is. A row whose name is merged over
//!   further columns is a title and no task. Rows without an id, code or name are left out; hidden ones are read. All of it is found.
//! - Crosses below days are dates: a task begins on the first day with one and ends with the last, if it has no dates of its own. Days may
//!   be weeks by their first day. Gaps are found.
//! - Sizes are checked before anything is read by what a file states of itself (`src/xlsx/parts.rs`).

mod cell_text;
mod layout;
mod parts;
mod rows;
mod sheet;
mod sheet_notes;

use crate::csv::{Table, read_table};
use crate::plan::PlanFile;
use crate::{PlanFileError, ReadOptions};
use calamine::{Reader, SheetType, SheetVisible, Xlsx};
use layout::Layout;
pub(crate) use parts::OTHER_SPREADSHEETS;
use parts::Parts;
use sheet::Sheet;
use std::io::Cursor;

/// Reads a workbook.
///
/// # Errors
/// No workbook, or a damaged one; none or several sheets with a table of tasks; dates that can be read in two orders; more of something
/// than a schedule has.
pub(crate) fn read(bytes: &[u8], options: &ReadOptions) -> Result<PlanFile, PlanFileError> {
    let parts = Parts::of(bytes)?;
    let mut book: Xlsx<Cursor<&[u8]>> = Xlsx::new(Cursor::new(bytes))
        .map_err(|error| PlanFileError::NoSchedule(format!("its workbook cannot be read: {error}")))?;
    let (sheet, layout) = chosen(&mut book, &parts, options)?;
    let found = rows::rows_of(&sheet, &layout)?;
    let table = Table::of_sheet(&sheet.name, layout.columns, found.rows);
    read_table(&table, options, &found.remarks)
}

/// The sheet that is read, and where its table is.
fn chosen(
    book: &mut Xlsx<Cursor<&[u8]>>,
    parts: &Parts,
    options: &ReadOptions,
) -> Result<(Sheet, Layout), PlanFileError> {
    let paths = parts.sheets();
    let of_cells = |sheet: &&calamine::Sheet| sheet.typ == SheetType::WorkSheet;
    let sheets: Vec<calamine::Sheet> = book.sheets_metadata().iter().filter(of_cells).cloned().collect();
    let mut found: Option<(Sheet, Layout)> = None;
    let mut also: Vec<String> = Vec::new();
    let mut lacks: Vec<String> = Vec::new();
    for calamine::Sheet { name, visible, .. } in &sheets {
        match &options.sheet {
            Some(wanted) if wanted.trim() != name.trim() => continue,
            None if *visible != SheetVisible::Visible => {
                lacks.push(format!("{name:?}: it is hidden"));
                continue;
            }
            _ => {}
        }
        let sheet = match Sheet::read(book, name, paths.get(name).map_or("", |path| parts.text(path))) {
            Err(PlanFileError::Sheet { why, .. }) if options.sheet.is_none() => {
                lacks.push(format!("{name:?}: {why}"));
                continue;
            }
            sheet => sheet?,
        };
        match Layout::of(&sheet, options) {
            Ok(layout) if options.sheet.is_some() || layout.has_times() => match &found {
                Some(_) => also.push(format!("{name:?}")),
                None => found = Some((sheet, layout)),
            },
            Ok(layout) => lacks.push(format!(
                "{name:?}: its headings in row {} have no date, duration or predecessor",
                layout.heading_row + 1
            )),
            Err(why) => lacks.push(format!("{name:?}: {why}")),
        }
    }
    let names =
        |sheets: &[calamine::Sheet]| sheets.iter().map(|s| format!("{:?}", s.name)).collect::<Vec<_>>().join(", ");
    if let (Some((first, _)), false) = (&found, also.is_empty()) {
        let why = format!(
            "several of its sheets have a table of tasks: {:?}, {}; say which with sheet in the schedule rules",
            first.name,
            also.join(", ")
        );
        return Err(PlanFileError::NoSchedule(why));
    }
    found.ok_or_else(|| match &options.sheet {
        Some(wanted) if lacks.is_empty() => {
            PlanFileError::NoSchedule(format!("it has no sheet {wanted:?}; there are {}", names(&sheets)))
        }
        _ => PlanFileError::NoSchedule(format!("none of its sheets has a table of tasks: {}", lacks.join("; "))),
    })
}
