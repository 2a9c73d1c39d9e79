//! Projects of an XER file.

use super::tables::Tables;
use crate::assemble::WrittenPlan;
use crate::p6::Record;
use crate::written_project::WrittenProject;
use crate::{PlanFileError, p6, values};
use std::collections::HashMap;

/// Reads all projects with their values.
///
/// # Errors
/// A column that is needed and not there; too many projects.
pub(super) fn read(tables: &Tables<'_>, plan: &mut WrittenPlan) -> Result<(), PlanFileError> {
    tables.require("PROJECT", &["proj_id"])?;
    let flags: Vec<&str> = tables.rows("PROJECT").map(|row| row.get("export_flag")).collect();
    let is_outside = |flag: &str| match flag {
        "Y" => false,
        "N" if flags.iter().all(|flag| *flag == "N") => false,
        "N" => true,
        _ => flags.contains(&"Y"),
    };
    let mut names = HashMap::new();
    for node in tables.rows("PROJWBS").filter(|row| row.cell("proj_node_flag") == "Y") {
        names.entry(node.get("proj_id")).or_insert(node.text("wbs_name").into_owned());
    }
    let mut all_options = HashMap::new();
    for options in tables.rows("SCHEDOPTIONS") {
        let expected = options.cell("sched_use_expect_end_flag") == "Y";
        all_options
            .entry(options.get("proj_id"))
            .or_insert((options.get("sched_calendar_on_relationship_lag"), expected));
    }
    for row in tables.rows("PROJECT") {
        let id = row.cell("proj_id");
        let (lag_calendar, uses_expected_finishes) = all_options.get(id).copied().unwrap_or_default();
        plan.push_project(WrittenProject {
            uid: id.to_owned(),
            name: names.get(id).cloned().unwrap_or_else(|| row.text("proj_short_name").into_owned()),
            data_date: values::date(row.cell("last_recalc_date")),
            start: values::date(row.cell("plan_start_date")),
            calendar: row.cell("clndr_id").to_owned(),
            lag_calendar: p6::lag_calendar(lag_calendar),
            uses_expected_finishes,
            is_outside: is_outside(row.cell("export_flag")),
        })?;
    }
    Ok(())
}
