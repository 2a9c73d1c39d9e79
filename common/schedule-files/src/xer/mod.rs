//! XER files of Primavera P6: tables with tabs between cells.
//!
//! - `%T` names a table, `%F` its columns, `%R` is a row, `%E` the end. Versions differ in the columns and tables that they write:
//!   columns are found by name, and tables that are not needed are passed over.
//! - Text is in the Windows code page of the computer that wrote it, mostly 1252, or in UTF-8. A row goes on over line breaks in its
//!   texts, which P6 itself writes as the character 7F.
//! - Numbers have the decimal separator of that computer: point or comma. Durations, lags and floats are hours.
//! - Nodes of the work breakdown and activities count apart; a node has the uid `wbs:` and its id. The node of the project is at the top.
//! - Relationships with activities of projects that are not in the file are found and left out, as the file has only their number.
//! - Baselines are projects of their own and are not written into the file.
//! - What holds for P6 XML, too, is in [`crate::p6`]; the text of calendars in [`calendar_data`].

mod activities;
mod calendar_data;
mod calendars;
mod fields;
mod tables;
#[cfg(test)]
mod tests;

use crate::assemble::WrittenPlan;
use crate::p6::Record;
use crate::plan::{FindingKind, LagCalendar, PlanFile};
use crate::{PlanFileError, p6, values};
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
    let is_elapsed = read_project(&tables, &mut file, &mut plan)?;
    activities::read_nodes(&tables, &mut plan)?;
    activities::read_activities(&tables, &mut plan)?;
    activities::read_relationships(&tables, is_elapsed, &mut plan)?;
    fields::read_codes(&tables, &mut plan)?;
    fields::read_user_defined(&tables, &mut plan)?;
    plan.into_file(&mut file);
    p6::fill_wbs(&mut file);
    Ok(file)
}

/// Name, dates and calendars, by the first project that is exported for itself and not for relationships of others; returns whether
/// lags count day and night.
fn read_project(tables: &Tables<'_>, file: &mut PlanFile, plan: &mut WrittenPlan) -> Result<bool, PlanFileError> {
    tables.require("PROJECT", &["proj_id"])?;
    let exported = tables.rows("PROJECT").find(|row| row.cell("export_flag") != "N");
    let Some(project) = exported.or_else(|| tables.rows("PROJECT").next()) else {
        file.calendars = calendars::read(tables, "", &mut plan.findings)?;
        return Ok(false);
    };
    let id = project.cell("proj_id");
    let is_node = |row: &tables::Row<'_, '_>| row.cell("proj_id") == id && row.cell("proj_node_flag") == "Y";
    let node = tables.rows("PROJWBS").find(is_node);
    let name = node.as_ref().map_or_else(|| project.text("proj_short_name"), |node| node.text("wbs_name"));
    file.name = name.into_owned();
    file.data_date = values::date(project.cell("last_recalc_date"));
    file.start = values::date(project.cell("plan_start_date"));
    file.calendars = calendars::read(tables, project.cell("clndr_id"), &mut plan.findings)?;
    let options = tables.rows("SCHEDOPTIONS").find(|row| row.cell("proj_id") == id);
    let word = options.map_or("", |row| row.get("sched_calendar_on_relationship_lag"));
    let lag_calendar = p6::lag_calendar(word);
    file.lag_calendar = lag_calendar.unwrap_or(LagCalendar::Predecessor);
    Ok(lag_calendar.is_none())
}
