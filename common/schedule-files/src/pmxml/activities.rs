//! Work breakdown, activities and relationships of P6 XML.

use super::element::Element;
use super::fields::Assigned;
use crate::PlanFileError;
use crate::assemble::{References, WrittenPlan};
use crate::p6::{self, ActivityColumns, AssignmentColumns, LinkColumns, Record, activity, node_uid};
use crate::plan::{PlanTask, PlanTaskKind};
use crate::resources::WrittenResources;
use crate::xml::Xml;

const ACTIVITY: ActivityColumns = ActivityColumns {
    uid: "ObjectId",
    code: "Id",
    name: "Name",
    kind: "Type",
    status: "Status",
    duration: "PlannedDuration",
    remaining: "RemainingDuration",
    total_float: "TotalFloat",
    free_float: "FreeFloat",
    current_dates: ["StartDate", "FinishDate"],
    planned_dates: ["PlannedStartDate", "PlannedFinishDate"],
    // Early and late dates are those of what remains: P6 writes no others.
    early_dates: ["RemainingEarlyStartDate", "RemainingEarlyFinishDate"],
    late_dates: ["RemainingLateStartDate", "RemainingLateFinishDate"],
    actual_dates: ["ActualStartDate", "ActualFinishDate"],
    remaining_dates: ["RemainingEarlyStartDate", "RemainingEarlyFinishDate"],
    expected_finish: "ExpectedFinishDate",
    constraints: [
        ["PrimaryConstraintType", "PrimaryConstraintDate"],
        ["SecondaryConstraintType", "SecondaryConstraintDate"],
    ],
    percent_type: "PercentCompleteType",
    physical_percent: "PhysicalPercentComplete",
    percent_whole: 1.0,
    actual_units: ["ActualLaborUnits", "ActualNonLaborUnits"],
    remaining_units: ["RemainingLaborUnits", "RemainingNonLaborUnits"],
};

pub(super) const ASSIGNMENT: AssignmentColumns = AssignmentColumns {
    task: "ActivityObjectId",
    resource: "ResourceObjectId",
    units: "PlannedUnits",
    units_per_hour: "PlannedUnitsPerTime",
};

pub(super) const LINK: LinkColumns = LinkColumns {
    predecessor: "PredecessorActivityObjectId",
    successor: "SuccessorActivityObjectId",
    kind: "Type",
    lag: "Lag",
};

/// Reads a node of the work breakdown.
///
/// # Errors
/// XML that is not well-formed; too many nodes.
pub(super) fn read_node<'a>(
    xml: &mut Xml<'a>,
    plan: &mut WrittenPlan,
    assigned: &mut Vec<Assigned<'a>>,
) -> Result<(), PlanFileError> {
    let (node, fields) = read_with_fields(xml, &["UDF"])?;
    let task = PlanTask {
        uid: node_uid(node.cell("ObjectId")),
        code: node.cell("Code").to_owned(),
        name: node.cell("Name").to_owned(),
        kind: PlanTaskKind::Summary,
        ..Default::default()
    };
    let parent = node.given("ParentObjectId").map(node_uid);
    let references = References { parent, calendar: None, project: node.given("ProjectObjectId").map(str::to_owned) };
    push(task, references, fields, plan, assigned)
}

/// Reads an activity.
///
/// # Errors
/// XML that is not well-formed; too many activities.
pub(super) fn read_activity<'a>(
    xml: &mut Xml<'a>,
    plan: &mut WrittenPlan,
    assigned: &mut Vec<Assigned<'a>>,
    resources: &mut WrittenResources,
) -> Result<(), PlanFileError> {
    let (element, fields) = read_with_fields(xml, &["UDF", "Code"])?;
    if p6::goes_by_resources(element.cell(ACTIVITY.kind)) {
        resources.let_decide(element.cell(ACTIVITY.uid));
    }
    let task = activity(&element, &ACTIVITY, plan);
    let owned = |name| element.given(name).map(str::to_owned);
    let (calendar, project) = (owned("CalendarObjectId"), owned("ProjectObjectId"));
    let references = References { parent: element.given("WBSObjectId").map(node_uid), calendar, project };
    push(task, references, fields, plan, assigned)
}

/// An element, and its children of these names, which assign codes and fields to it.
fn read_with_fields<'a>(xml: &mut Xml<'a>, names: &[&str]) -> Result<(Element<'a>, Vec<Assigned<'a>>), PlanFileError> {
    let mut fields = Vec::new();
    let element = Element::read(xml, |name, xml| {
        let is_field = names.contains(&name);
        if is_field {
            fields.push(Assigned::read(xml)?);
        }
        Ok(is_field)
    })?;
    Ok((element, fields))
}

fn push<'a>(
    task: PlanTask,
    references: References,
    fields: Vec<Assigned<'a>>,
    plan: &mut WrittenPlan,
    assigned: &mut Vec<Assigned<'a>>,
) -> Result<(), PlanFileError> {
    if let Some(task) = plan.push(task, references)? {
        for mut field in fields {
            field.task = task;
            assigned.push(field);
        }
    }
    Ok(())
}
