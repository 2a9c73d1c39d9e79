//! Work breakdown, activities and relationships of an XER file.

use super::tables::{Row, Tables};
use crate::PlanFileError;
use crate::assemble::{References, WrittenPlan};
use crate::p6::{
    self, ActivityColumns, AssignmentColumns, LinkColumns, Record, activity, assignment, node_uid, read_link,
};
use crate::plan::{FindingKind, PlanTask, PlanTaskKind};
use crate::resources::WrittenResources;
use std::collections::HashSet;

const ACTIVITY: ActivityColumns = ActivityColumns {
    uid: "task_id",
    code: "task_code",
    name: "task_name",
    kind: "task_type",
    status: "status_code",
    duration: "target_drtn_hr_cnt",
    remaining: "remain_drtn_hr_cnt",
    total_float: "total_float_hr_cnt",
    free_float: "free_float_hr_cnt",
    // Not written: they follow from the others.
    current_dates: ["", ""],
    planned_dates: ["target_start_date", "target_end_date"],
    early_dates: ["early_start_date", "early_end_date"],
    late_dates: ["late_start_date", "late_end_date"],
    actual_dates: ["act_start_date", "act_end_date"],
    remaining_dates: ["restart_date", "reend_date"],
    expected_finish: "expect_end_date",
    constraints: [["cstr_type", "cstr_date"], ["cstr_type2", "cstr_date2"]],
    percent_type: "complete_pct_type",
    physical_percent: "phys_complete_pct",
    percent_whole: 100.0,
    actual_units: ["act_work_qty", "act_equip_qty"],
    remaining_units: ["remain_work_qty", "remain_equip_qty"],
};

const ASSIGNMENT: AssignmentColumns = AssignmentColumns {
    task: "task_id",
    resource: "rsrc_id",
    units: "target_qty",
    units_per_hour: "target_qty_per_hr",
};

const LINK: LinkColumns =
    LinkColumns { predecessor: "pred_task_id", successor: "task_id", kind: "pred_type", lag: "lag_hr_cnt" };

/// Nodes of the work breakdown. That of a project is at the top: what is above it are folders of the database.
///
/// # Errors
/// A column that is needed and not there; too many nodes.
pub(super) fn read_nodes(tables: &Tables<'_>, plan: &mut WrittenPlan) -> Result<(), PlanFileError> {
    tables.require("PROJWBS", &["wbs_id", "parent_wbs_id"])?;
    let outside = outside(plan);
    let is_of_plan = |row: &Row<'_, '_>| !outside.contains(row.get("proj_id"));
    let ids: HashSet<_> = tables.rows("PROJWBS").filter(is_of_plan).map(|row| row.get("wbs_id")).collect();
    for row in tables.rows("PROJWBS") {
        let parent = row.get("parent_wbs_id");
        let is_top = parent.is_empty() || row.cell("proj_node_flag") == "Y" && !ids.contains(parent);
        let node = PlanTask {
            uid: node_uid(row.cell("wbs_id")),
            code: row.cell("wbs_short_name").to_owned(),
            name: row.text("wbs_name").into_owned(),
            kind: PlanTaskKind::Summary,
            ..Default::default()
        };
        plan.push(
            node,
            References { parent: (!is_top).then(|| node_uid(parent)), calendar: None, project: project_of(&row) },
        )?;
    }
    Ok(())
}

/// Activities.
///
/// # Errors
/// A column that is needed and not there; too many activities.
pub(super) fn read_activities(tables: &Tables<'_>, plan: &mut WrittenPlan) -> Result<(), PlanFileError> {
    tables.require("TASK", &[ACTIVITY.uid, ACTIVITY.kind])?;
    if tables.lacks("TASK", ACTIVITY.status) {
        let message = format!("TASK has no column {}: activities with an actual finish are complete", ACTIVITY.status);
        plan.find(None, FindingKind::NotUnderstood, message);
    }
    for row in tables.rows("TASK") {
        let task = activity(&row, &ACTIVITY, plan);
        let (parent, calendar) = (row.given("wbs_id").map(node_uid), row.given("clndr_id").map(str::to_owned));
        plan.push(task, References { parent, calendar, project: project_of(&row) })?;
    }
    Ok(())
}

/// Resources that work, and their work on activities that go by them.
///
/// # Errors
/// A column that is needed and not there; too much work.
pub(super) fn read_resources(tables: &Tables<'_>, plan: &mut WrittenPlan) -> Result<WrittenResources, PlanFileError> {
    let mut resources = WrittenResources::default();
    for row in tables.rows("TASK").filter(|row| p6::goes_by_resources(row.cell(ACTIVITY.kind))) {
        resources.let_decide(row.cell(ACTIVITY.uid));
    }
    for row in tables.rows("RSRC").filter(|row| p6::works(row.cell("rsrc_type"))) {
        resources.add(row.cell("rsrc_id"), row.cell("clndr_id"));
    }
    for row in tables.rows("TASKRSRC") {
        if resources.decide(row.cell(ASSIGNMENT.task)) {
            resources.assign(assignment(&row, &ASSIGNMENT, plan))?;
        }
    }
    Ok(resources)
}

/// Relationships, other than those of projects outside the plan with each other.
///
/// # Errors
/// A column that is needed and not there; too many relationships.
pub(super) fn read_relationships(tables: &Tables<'_>, plan: &mut WrittenPlan) -> Result<(), PlanFileError> {
    tables.require("TASKPRED", &[LINK.predecessor, LINK.successor, LINK.kind])?;
    let outside = outside(plan);
    for row in tables.rows("TASKPRED") {
        if ["pred_proj_id", "proj_id"].iter().all(|column| outside.contains(row.get(column))) {
            continue;
        }
        let link = read_link(&row, &LINK, plan);
        plan.link(link)?;
    }
    Ok(())
}

/// Identities of the projects outside the plan.
fn outside(plan: &WrittenPlan) -> HashSet<String> {
    plan.projects.iter().filter(|project| project.is_outside).map(|project| project.uid.clone()).collect()
}

fn project_of(row: &Row<'_, '_>) -> Option<String> {
    row.given("proj_id").map(str::to_owned)
}
