//! The tasks of a schedule with their dates, what they act on, and what is wrong with them.

use crate::named::date_text;
use messages::{Diagnostic, NONE, Severity, Site, TaskRecord};
use schedule::{TaskDates, TaskTargets, Timeline};
use schemars::JsonSchema;
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};

/// What `groundplan tasks --json` prints.
#[derive(Debug, Serialize, JsonSchema)]
pub struct TaskList<'s> {
    /// Plan time of the status; null if none was asked for.
    pub at: Option<String>,
    /// The tasks: each before those that are nested in it, else in the order of schedule files, or of starts in models.
    pub tasks: Vec<TaskEntry<'s>>,
}

/// A task.
#[derive(Debug, Serialize, JsonSchema)]
pub struct TaskEntry<'s> {
    /// GlobalId.
    pub global_id: &'s str,
    /// Identification, e.g. a number of the work breakdown structure; null if absent.
    pub identification: Option<&'s str>,
    /// Name; null if absent.
    pub name: Option<&'s str>,
    /// Base name of the schedule file that it is of; null for a task of the models.
    pub file: Option<&'s str>,
    /// GlobalId of the task that it is nested in; null at the top.
    pub parent: Option<&'s str>,
    /// Number of tasks above it.
    pub depth: usize,
    /// True if tasks are nested in it.
    pub is_summary: bool,
    /// PredefinedType, or ObjectType where that says USERDEFINED; null if absent.
    pub predefined_type: Option<&'s str>,
    /// Start at the site; null if the task has no dates that can be used.
    pub start: Option<String>,
    /// Finish at the site, exclusive.
    pub finish: Option<String>,
    /// Where the dates come from: `task_actual`, `task_schedule`, `task_early`, `task_computed`; null without dates.
    pub dates_from: Option<&'static str>,
    /// Total float in hours; null for a task that has others nested in it, or has no dates.
    pub total_float_h: Option<f64>,
    /// Completion as the file has it, from 0 to 1; null if absent.
    pub completion: Option<f64>,
    /// `not_started`, `in_progress` or `finished` at the plan time; null without one, or without dates.
    pub status: Option<&'static str>,
    /// Elements that it acts on.
    pub elements: Vec<ElementEntry<'s>>,
    /// Spaces that are closed while it is at work.
    pub spaces: Vec<SpaceEntry<'s>>,
    /// What is wrong with it.
    pub warnings: Vec<WarningEntry>,
}

/// An element that a task acts on.
#[derive(Debug, Serialize, JsonSchema)]
pub struct ElementEntry<'s> {
    /// GlobalId.
    pub global_id: &'s str,
    /// Name; null if absent.
    pub name: Option<&'s str>,
    /// Entity, e.g. `IfcWall`.
    #[serde(rename = "type")]
    pub ifc_type: &'s str,
    /// `constructs`, `removes`, or `no_effect`: the task has no dates, is of another kind, or another source goes before it.
    pub operation: &'static str,
    /// Rule, or row of the table of links, that links it; null for links of the models.
    pub rule: Option<&'s str>,
}

/// A space that a task acts on.
#[derive(Debug, Serialize, JsonSchema)]
pub struct SpaceEntry<'s> {
    /// GlobalId.
    pub global_id: &'s str,
    /// Name; null if absent.
    pub name: Option<&'s str>,
    /// Long name; null if absent.
    pub long_name: Option<&'s str>,
}

/// What is wrong with a task.
#[derive(Debug, Serialize, JsonSchema)]
pub struct WarningEntry {
    /// Stable word for programs.
    pub code: &'static str,
    /// `warning` or `error`.
    pub severity: &'static str,
    /// For people.
    pub message: String,
}

/// The tasks that are wanted, or all without a choice.
pub fn list<'s>(site: &'s Site<'_>, timeline: &Timeline, at_s: Option<i64>, wanted: Option<&[usize]>) -> TaskList<'s> {
    let targets = timeline.task_targets(site);
    let order =
        nested_order(site.schedule.tasks).into_iter().filter(|(k, _)| wanted.is_none_or(|wanted| wanted.contains(k)));
    let about = About::of(site, timeline);
    let entry =
        |(k, depth): (usize, usize)| TaskEntry { depth, ..entry_of(site, timeline, at_s, k, &targets[k], &about) };
    TaskList { at: at_s.map(date_text), tasks: order.map(entry).collect() }
}

/// Every task with its depth, behind the one that it is nested in.
pub(super) fn nested_order(tasks: &[TaskRecord]) -> Vec<(usize, usize)> {
    let mut children: Vec<Vec<usize>> = vec![Vec::new(); tasks.len()];
    let mut stack = Vec::new();
    for (k, task) in tasks.iter().enumerate() {
        match task.parent {
            NONE => stack.push((k, 0)),
            parent => children[parent as usize].push(k),
        }
    }
    stack.reverse();
    let mut order = Vec::with_capacity(tasks.len());
    while let Some((k, depth)) = stack.pop() {
        order.push((k, depth));
        stack.extend(children[k].iter().rev().map(|child| (*child, depth + 1)));
    }
    order
}

/// What is told of each task, found once for all.
struct About<'t> {
    parents: BTreeSet<u32>,
    warnings: BTreeMap<&'t str, Vec<&'t Diagnostic>>,
}

impl<'t> About<'t> {
    fn of(site: &Site<'_>, timeline: &'t Timeline) -> Self {
        let mut warnings: BTreeMap<&str, Vec<&Diagnostic>> = BTreeMap::new();
        for diagnostic in timeline.diagnostics().iter().filter(|d| d.severity > Severity::Info) {
            warnings.entry(diagnostic.global_id()).or_default().push(diagnostic);
        }
        // Diagnostics without an entity are about no task.
        warnings.remove("");
        Self { parents: site.schedule.tasks.iter().map(|t| t.parent).collect(), warnings }
    }
}

fn entry_of<'s>(
    site: &'s Site<'_>,
    timeline: &Timeline,
    at_s: Option<i64>,
    task: usize,
    targets: &TaskTargets,
    about: &About<'_>,
) -> TaskEntry<'s> {
    let record = &site.schedule.tasks[task];
    let text = |t| Some(site.text(t)).filter(|text| !text.is_empty());
    let written = |t| Some(site.schedule.text(t)).filter(|text| !text.is_empty());
    let dates = timeline.task(task);
    let element = |(&k, operation): (&u32, &schedule::TaskOperation)| {
        let element = &site.elements[k as usize];
        ElementEntry {
            global_id: site.text(element.global_id),
            name: text(element.name),
            ifc_type: site.text(element.ifc_type),
            operation: operation.name(),
            rule: export::link_rule(site, task as u32, k),
        }
    };
    let space = |k: &u32| {
        let space = &site.spaces[*k as usize];
        SpaceEntry { global_id: site.text(space.global_id), name: text(space.name), long_name: text(space.long_name) }
    };
    let global_id = site.schedule.text(record.global_id);
    TaskEntry {
        global_id,
        identification: written(record.identification),
        name: written(record.name),
        file: export::schedule_file(site, record),
        parent: (record.parent != NONE)
            .then(|| site.schedule.text(site.schedule.tasks[record.parent as usize].global_id)),
        depth: 0,
        is_summary: about.parents.contains(&(task as u32)),
        predefined_type: written(record.predefined_type),
        start: dates.map(|d| date_text(d.start_s)),
        finish: dates.map(|d| date_text(d.finish_s)),
        dates_from: dates.map(|d| d.source.name()),
        total_float_h: timeline.float(task).map(|f| (f.total_s as f64 / 36.0).round() / 100.0),
        completion: (record.completion >= 0.0).then_some(record.completion),
        status: at_s.zip(dates).map(|(at_s, dates)| status(at_s, dates)),
        elements: targets.elements.iter().map(element).collect(),
        spaces: targets.spaces.iter().map(space).collect(),
        warnings: about.warnings.get(global_id).into_iter().flatten().map(|found| WarningEntry::of(found)).collect(),
    }
}

pub(super) fn status(at_s: i64, dates: TaskDates) -> &'static str {
    if at_s >= dates.finish_s {
        "finished"
    } else if at_s >= dates.start_s {
        "in_progress"
    } else {
        "not_started"
    }
}

/// Status of a task with these dates at a date, all as documents write them: `not_started`, `in_progress` or `finished`.
pub fn status_at(at: &str, start: &str, finish: &str) -> &'static str {
    // Dates of one form are in the order of their texts.
    if at >= finish {
        "finished"
    } else if at >= start {
        "in_progress"
    } else {
        "not_started"
    }
}

impl WarningEntry {
    fn of(diagnostic: &Diagnostic) -> Self {
        Self { code: diagnostic.code.name(), severity: diagnostic.severity.name(), message: diagnostic.message.clone() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bytemuck::Zeroable;

    #[test]
    fn the_status_of_texts_is_that_of_dates() {
        let (start_s, finish_s) = (1_710_000_000, 1_710_500_000);
        let source = messages::DateSource::None;
        for at_s in [0, start_s - 1, start_s, start_s + 1, finish_s - 1, finish_s, finish_s + 90_000_000] {
            let [at, start, finish] = [at_s, start_s, finish_s].map(date_text);
            assert_eq!(status_at(&at, &start, &finish), status(at_s, TaskDates { start_s, finish_s, source }), "{at}");
        }
    }

    #[test]
    fn a_task_comes_behind_the_one_that_it_is_nested_in() {
        let task = |parent| TaskRecord { parent, ..TaskRecord::zeroed() };
        let order = nested_order(&[task(2), task(NONE), task(NONE), task(2), task(0)]);
        assert_eq!(order, [(1, 0), (2, 0), (0, 1), (4, 2), (3, 1)]);
    }
}
