//! CSV of spreadsheets and of the tables of planners' tools.
//!
//! - Separators are comma, semicolon, tab or bar, by which the heading has most columns; Excel's first line `sep=;` says it as well.
//! - The first row has the headings. Columns are known by usual headings in English and German, or by the options; all others are
//!   fields of the tasks, as is the type, since some tools write there what a task does.
//! - Numbers have a decimal point or comma. Dates are ISO 8601, or day, month and year in the order of the options, else in the only
//!   one in which all of them are dates; with names of months, days of the week, years of two digits (of this century) and P6's marks.
//! - A day is 8 working hours, a week 40, a month 160. Where a file has lengths it gets a calendar with these, Monday to Friday, as it
//!   has none itself.
//! - The mark before a text that would be a formula (`'=A`) is no part of it.
//! - A heading may say the unit of lengths without one: `Duration (weeks)`.
//! - A task without an id has its code, else the number of its line.
//! - Nesting is by the id of the parent, else by outline level, else by work breakdown (`1.2` holds `1.2.3`) if no two tasks share one.
//! - Progress is a share of 100; of 1 where no number of the column is larger and one is neither 0 nor 1.

mod dates;
mod headings;
mod lengths;
mod rows;
mod table;

pub(crate) use dates::{COLUMNS as DATE_COLUMNS, date, decided};
pub(crate) use headings::Columns;
pub(crate) use table::{Table, letters};

use crate::assemble::{References, WrittenLink, WrittenPlan};
use crate::calendars::USUAL_DAY_S;
use crate::options::CsvColumn;
use crate::plan::{FindingKind, PlanCalendar, PlanFile};
use crate::{PlanFileError, ReadOptions};
use std::collections::HashMap;

/// Reads a table of tasks.
///
/// # Errors
/// A table without headings that are known; dates that can be read in two orders; more rows than a schedule has.
pub(crate) fn read(text: &str, options: &ReadOptions) -> Result<PlanFile, PlanFileError> {
    read_table(&Table::of(text, options)?, options, &[])
}

/// Something about a table that is found beside what its cells say.
#[derive(Debug)]
pub(crate) struct Remark {
    /// Index of the row whose task it is about.
    pub(crate) row: Option<usize>,
    /// The sentence.
    pub(crate) message: String,
}

/// Reads the tasks of a table whose columns are known.
///
/// # Errors
/// Dates that can be read in two orders; more of something than a schedule has.
pub(crate) fn read_table(table: &Table, options: &ReadOptions, remarks: &[Remark]) -> Result<PlanFile, PlanFileError> {
    let order = match options.date_format {
        Some(order) => order,
        None => dates::decided(dates::COLUMNS.as_flattened().iter().flat_map(|column| table.cells(*column)))?,
    };
    let percent = [CsvColumn::PercentComplete, CsvColumn::PhysicalPercentComplete].map(|column| table.percent(column));
    let mut plan = WrittenPlan::default();
    let mut at_row = Vec::with_capacity(table.len());
    for (row, parent) in table.parents().into_iter().enumerate() {
        let next = plan.next_task();
        let task = rows::task(table, row, order, percent, &mut plan);
        plan.push(task, References { parent, ..Default::default() })?;
        let is_new = plan.next_task() > next;
        at_row.push(is_new.then_some(next));
        for (name, value) in table.fields(row).filter(|_| is_new) {
            plan.add_field(next, name, value)?;
        }
    }
    let has_lags = add_links(table, &at_row, &mut plan)?;
    for Remark { row, message } in remarks {
        plan.find(row.and_then(|row| at_row[row]), FindingKind::NotUnderstood, message.clone());
    }
    let mut file = PlanFile::default();
    plan.into_file(&mut file);
    if has_lags || file.tasks.iter().any(|task| task.duration.or(task.remaining).is_some()) {
        file.calendars.push(usual_calendar());
    }
    Ok(file)
}

/// Adds the dependencies of all tasks; true if one has a lag.
fn add_links(table: &Table, at_row: &[Option<usize>], plan: &mut WrittenPlan) -> Result<bool, PlanFileError> {
    // Predecessors are named by the column of ids, or where there is none by what stands for it.
    let mut uids: HashMap<&str, &str> = HashMap::new();
    for row in 0..table.len() {
        uids.entry(table.uid(row)).or_insert(table.uid(row));
    }
    for row in 0..table.len() {
        uids.entry(table.cell(row, CsvColumn::Code)).or_insert(table.uid(row));
    }
    uids.remove("");
    let mut has_lags = false;
    for (row, task) in at_row.iter().enumerate() {
        let Some(task) = *task else { continue };
        for entry in lengths::entries(table.cell(row, CsvColumn::Predecessors)) {
            let Some(read) = lengths::predecessor(entry, |id| uids.contains_key(id)) else {
                let message = format!("its predecessor {entry:?} names no task of the file, or cannot be read");
                plan.find(Some(task), FindingKind::MissingReference, message);
                continue;
            };
            has_lags |= read.lag.is_some();
            let (predecessor, successor) = (uids[read.id].to_owned(), table.uid(row).to_owned());
            plan.link(WrittenLink { predecessor, successor, kind: read.kind, lag: read.lag })?;
        }
    }
    Ok(has_lags)
}

/// Monday to Friday, 8 to 12 and 13 to 17: what lengths in days mean.
fn usual_calendar() -> PlanCalendar {
    PlanCalendar {
        uid: "usual".to_owned(),
        name: "usual working days".to_owned(),
        is_default: true,
        week: std::array::from_fn(|k| if k < 5 { USUAL_DAY_S.to_vec() } else { Vec::new() }),
        exceptions: Vec::new(),
    }
}

#[cfg(test)]
mod tests;
