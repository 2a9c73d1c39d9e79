//! Projects of P6 XML and their baselines.

use super::element::Element;
use crate::PlanFileError;
use crate::assemble::{References, WrittenPlan};
use crate::p6::{Record, node_uid};
use crate::plan::{PlanDate, PlanTask, PlanTaskKind};
use crate::values::date;
use crate::xml::Xml;
use std::borrow::Cow;
use std::collections::HashMap;
use std::ops::Range;

/// Tasks of a project, and its baseline.
#[derive(Debug)]
pub(super) struct Project<'a> {
    pub(super) id: Cow<'a, str>,
    pub(super) tasks: Range<usize>,
    /// Identity of the baseline that it is compared with.
    pub(super) baseline: Cow<'a, str>,
    /// What it says itself of lags; its schedule options go before it.
    pub(super) lag_calendar: Cow<'a, str>,
}

/// Planned dates of activities at an earlier time, by their codes: activities of a baseline have other identities.
#[derive(Debug)]
pub(super) struct Baseline<'a> {
    id: Cow<'a, str>,
    of_project: Cow<'a, str>,
    dates: HashMap<Cow<'a, str>, [Option<PlanDate>; 2]>,
}

/// Puts the project above the tasks of it that are in none.
///
/// Real files have the node of the project neither in their work breakdown nor above it. If there is one nevertheless, by its
/// identity or because the only node at the top has the code of the project, that is the project.
///
/// # Errors
/// Too many tasks.
pub(super) fn add_root(project: &Element<'_>, from: usize, plan: &mut WrittenPlan) -> Result<(), PlanFileError> {
    let top = plan.top_tasks(from);
    let tasks = plan.tasks_mut();
    let nodes: Vec<_> = top.iter().map(|k| &tasks[*k]).filter(|task| task.kind == PlanTaskKind::Summary).collect();
    let by_id = project.given("WBSObjectId").map(node_uid);
    let root = match (by_id, &nodes[..]) {
        (_, [node]) if node.code == project.cell("Id") => node.uid.clone(),
        (Some(uid), _) => uid,
        (None, _) => format!("project:{}", project.cell("ObjectId")),
    };
    for task in top {
        if plan.tasks_mut()[task].uid != root {
            plan.nest(task, &root);
        }
    }
    if plan.index_of(&root).is_none() {
        let name = project.cell("Name").to_owned();
        let (code, kind) = (project.cell("Id").to_owned(), PlanTaskKind::Summary);
        plan.push(PlanTask { uid: root, code, name, kind, ..Default::default() }, References::default())?;
    }
    Ok(())
}

/// Reads a baseline.
///
/// # Errors
/// XML that is not well-formed.
pub(super) fn read_baseline<'a>(xml: &mut Xml<'a>) -> Result<Baseline<'a>, PlanFileError> {
    let mut dates = HashMap::new();
    let mut project = Element::read(xml, |name, xml| {
        if name != "Activity" {
            return Ok(false);
        }
        let mut activity = Element::flat(xml)?;
        let pair = ["PlannedStartDate", "PlannedFinishDate"].map(|name| date(activity.cell(name)));
        dates.entry(activity.take("Id")).or_insert(pair);
        Ok(true)
    })?;
    Ok(Baseline { id: project.take("ObjectId"), of_project: project.take("OriginalProjectObjectId"), dates })
}

/// Gives activities the dates of the baseline that their project names; if it names none, of the first that is one of it.
pub(super) fn set_baselines(projects: &[Project<'_>], baselines: &[Baseline<'_>], plan: &mut WrittenPlan) {
    for project in projects {
        let named = baselines.iter().find(|baseline| !baseline.id.is_empty() && baseline.id == project.baseline);
        let first = || baselines.iter().find(|baseline| baseline.of_project == project.id);
        let Some(baseline) = named.or_else(first) else { continue };
        for task in &mut plan.tasks_mut()[project.tasks.clone()] {
            if task.kind != PlanTaskKind::Summary
                && let Some(dates) = baseline.dates.get(task.code.as_str())
            {
                task.dates.baseline = *dates;
            }
        }
    }
}
