//! Activity codes and user-defined fields of an XER file.

use super::tables::Tables;
use crate::PlanFileError;
use crate::assemble::WrittenPlan;
use crate::p6::{Record, node_uid};
use crate::plan::FindingKind;
use std::collections::HashMap;

/// Adds activity codes to their activities: the name of the code, and the short value.
///
/// # Errors
/// A column that is needed and not there; too many codes.
pub(super) fn read_codes(tables: &Tables<'_>, plan: &mut WrittenPlan) -> Result<(), PlanFileError> {
    tables.require("ACTVTYPE", &["actv_code_type_id", "actv_code_type"])?;
    tables.require("ACTVCODE", &["actv_code_id", "actv_code_type_id", "short_name"])?;
    tables.require("TASKACTV", &["task_id", "actv_code_id"])?;
    let mut names = HashMap::new();
    for row in tables.rows("ACTVTYPE") {
        names.entry(row.get("actv_code_type_id")).or_insert(row.text("actv_code_type").into_owned());
    }
    let mut values = HashMap::new();
    for row in tables.rows("ACTVCODE") {
        let value = (row.get("actv_code_type_id"), row.text("short_name").into_owned());
        values.entry(row.get("actv_code_id")).or_insert(value);
    }
    for row in tables.rows("TASKACTV") {
        let Some(task) = plan.index_of(row.cell("task_id")) else { continue };
        let id = row.cell("actv_code_id");
        let field = values.get(id).and_then(|(code, value)| Some((names.get(code)?, value)));
        match field {
            Some((name, value)) => plan.add_field(task, name, value)?,
            None => {
                let message = format!("its activity code {id:?} is not in the file");
                plan.find(Some(task), FindingKind::MissingReference, message);
                plan.check_findings()?;
            }
        }
    }
    Ok(())
}

/// Adds user-defined fields to activities and nodes of the work breakdown: the title of the field, and the value as it is written.
///
/// # Errors
/// A column that is needed and not there; too many fields.
pub(super) fn read_user_defined(tables: &Tables<'_>, plan: &mut WrittenPlan) -> Result<(), PlanFileError> {
    tables.require("UDFTYPE", &["udf_type_id", "table_name", "udf_type_label"])?;
    tables.require("UDFVALUE", &["udf_type_id", "fk_id"])?;
    let mut types = HashMap::new();
    for row in tables.rows("UDFTYPE") {
        let label = row.text("udf_type_label").into_owned();
        types.entry(row.get("udf_type_id")).or_insert((row.get("table_name"), label));
    }
    let mut codes = HashMap::new();
    for row in tables.rows("UDFCODE") {
        codes.entry(row.get("udf_code_id")).or_insert(row.text("short_name").into_owned());
    }
    for row in tables.rows("UDFVALUE") {
        let Some((table, label)) = types.get(row.cell("udf_type_id")) else { continue };
        let task = match *table {
            "TASK" => plan.index_of(row.cell("fk_id")),
            "PROJWBS" => plan.index_of(&node_uid(row.cell("fk_id"))),
            _ => None,
        };
        let Some(task) = task else { continue };
        let text = row.text("udf_text");
        let written = [&*text, row.cell("udf_number"), row.cell("udf_date")].into_iter().find(|cell| !cell.is_empty());
        let value = written.or_else(|| codes.get(row.cell("udf_code_id")).map(String::as_str));
        plan.add_field(task, label, value.unwrap_or(""))?;
    }
    Ok(())
}
