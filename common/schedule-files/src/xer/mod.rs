//! XER files of Primavera P6: tables with tabs between cells.
//!
//! - `%T` names a table, `%F` its columns, `%R` is a row, `%E` the end. Versions differ in the columns and tables that they write:
//!   columns are found by name, and tables that are not needed are passed over.
//! - Text is in the Windows code page of the computer that wrote it, mostly 1252, or in UTF-8. A row goes on over line breaks in its
//!   texts, which P6 itself writes as the character 7F.
//! - Numbers have the decimal separator of that computer: point or comma. Durations, lags and floats are hours.
//! - Nodes of the work breakdown and activities count apart; a node has the uid `wbs:` and its id. The node of the project is at the top.
//! - A file has several projects where planners export several, each with its own values. Those that have no `export_flag` `Y` beside
//!   some that have are there for relationships with others alone, and no part of the plan.
//! - Relationships with activities of projects that are not in the file are found and left out, as the file has only their number.
//! - Baselines are projects of their own and are not written into the file.
//! - What holds for P6 XML, too, is in [`crate::p6`]; the text of calendars in [`calendar_data`].

mod activities;
mod calendar_data;
mod calendars;
mod fields;
mod projects;
mod tables;
#[cfg(test)]
mod tests;

use crate::assemble::WrittenPlan;
use crate::plan::{FindingKind, LagCalendar, PlanFile};
use crate::resources::OwnCalendar;
use crate::{PlanFileError, p6};
use tables::Tables;

/// Reads an XER file.
///
/// # Errors
/// A table without a column that is needed; more of something than a schedule has.
pub(crate) fn read(text: &str) -> Result<PlanFile, PlanFileError> {
    let tables = Tables::of(text).ok_or_else(|| PlanFileError::NoSchedule("it is no XER file".to_owned()))?;
    let mut plan = WrittenPlan::default();
    if tables.is_cut {
        let message = "the mark at the end of the file is missing; it may be cut off".to_owned();
        plan.find(None, FindingKind::NotUnderstood, message);
    }
    let mut file = PlanFile { written_by: format!("Primavera P6 {}", tables.version), ..Default::default() };
    projects::read(&tables, &mut plan)?;
    (file.lag_calendar, file.is_primavera) = (LagCalendar::Predecessor, true);
    file.calendars = calendars::read(&tables, &mut plan)?;
    activities::read_nodes(&tables, &mut plan)?;
    activities::read_activities(&tables, &mut plan)?;
    activities::read_relationships(&tables, &mut plan)?;
    let resources = activities::read_resources(&tables, &mut plan)?;
    fields::read_codes(&tables, &mut plan)?;
    fields::read_user_defined(&tables, &mut plan)?;
    plan.into_file(&mut file);
    resources.add_to(&mut file, OwnCalendar::Ignored);
    p6::fill_wbs(&mut file);
    Ok(file)
}
