//! Values of a task that rules compare and that effects are told by.

use crate::folded::fold;
use crate::schedule_file::ScheduleFile;
use messages::TaskUncertaintyRecord;
use schedule_files::{PlanDate, PlanTask, PlanTaskKind};
use std::collections::BTreeSet;

/// A task of one of several schedule files.
#[derive(Debug, Clone, Copy)]
pub struct PlannedTask<'a> {
    /// Index of its file.
    pub file: usize,
    /// The task.
    pub task: &'a PlanTask,
}

/// All tasks, file by file: their order is that of the `tasks` archive.
pub(crate) fn all_tasks<'a>(plans: &'a [ScheduleFile]) -> Vec<PlannedTask<'a>> {
    let of_file =
        |(file, plan): (usize, &'a ScheduleFile)| plan.plan.tasks.iter().map(move |task| PlannedTask { file, task });
    plans.iter().enumerate().flat_map(of_file).collect()
}

/// A name of each task that no other has: its code, with its id or its file where the code does not tell.
pub(crate) fn task_ids(plans: &[ScheduleFile]) -> Vec<String> {
    let mut taken = BTreeSet::new();
    let name = |planned: PlannedTask<'_>| {
        let PlanTask { uid, code, .. } = planned.task;
        let file = &plans[planned.file].file;
        let names = [code.clone(), uid.clone(), format!("{code}#{uid}"), format!("{file}:{uid}")];
        let free = names.into_iter().filter(|name| !name.is_empty()).find(|name| !taken.contains(name));
        let free = free.or_else(|| (2..).map(|n| format!("{file}:{uid}#{n}")).find(|name| !taken.contains(name)));
        let name = free.expect("a number is free");
        taken.insert(name.clone());
        name
    };
    all_tasks(plans).into_iter().map(name).collect()
}

/// Start and finish that the file plans: those of the current plan, and the actual start of what has begun.
pub(crate) fn shown_dates(task: &PlanTask) -> [Option<PlanDate>; 2] {
    let dates = &task.dates;
    let has_begun = dates.actual[0].is_some() && dates.actual[1].is_none();
    let start = if has_begun { dates.actual[0] } else { dates.current[0].or(dates.planned[0]) };
    [start, dates.current[1].or(dates.remaining[1]).or(dates.planned[1])]
}

/// The three-point durations of a task, if it has any.
pub(crate) fn three_point_record(task: &PlanTask, at: u32) -> Option<TaskUncertaintyRecord> {
    let [optimistic, likely, pessimistic] = task.three_point.filter(|_| !task.is_inactive)?;
    Some(TaskUncertaintyRecord {
        duration_optimistic_s: optimistic.seconds,
        duration_likely_s: likely.seconds,
        duration_pessimistic_s: pessimistic.seconds,
        task: at,
        is_elapsed: u32::from(likely.is_elapsed),
    })
}

/// Tasks that are work: no summaries, milestones or spans, and not switched off.
pub(crate) fn is_work(tasks: &[PlannedTask<'_>], plans: &[ScheduleFile]) -> Vec<bool> {
    let first = |file: usize| plans[..file].iter().map(|plan| plan.plan.tasks.len()).sum::<usize>();
    let firsts: Vec<usize> = (0..plans.len()).map(first).collect();
    let parents: BTreeSet<usize> = tasks.iter().filter_map(|t| Some(firsts[t.file] + t.task.parent?)).collect();
    let is_work = |(k, planned): (usize, &PlannedTask<'_>)| {
        planned.task.kind == PlanTaskKind::Task && !planned.task.is_inactive && !parents.contains(&k)
    };
    tasks.iter().enumerate().map(is_work).collect()
}

/// A value of tasks.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum TaskValue {
    Id,
    Code,
    Wbs,
    Name,
    /// An activity code, a user-defined or custom field, a column of a table.
    Field(String),
}

impl TaskValue {
    /// `id`, `code`, `wbs`, `name` or `field:NAME`.
    pub(crate) fn parse(text: &str) -> Result<Self, String> {
        Ok(match (text, text.strip_prefix("field:").map(str::trim)) {
            ("id", _) => Self::Id,
            ("code", _) => Self::Code,
            ("wbs", _) => Self::Wbs,
            ("name", _) => Self::Name,
            (_, Some(name)) if !name.is_empty() => Self::Field(fold(name)),
            _ => return Err(format!("={text} is no value of a task; write =code, =id, =wbs, =name or =field:NAME")),
        })
    }

    /// The values, folded, without empty ones: a field may have several.
    pub(crate) fn of(&self, task: &PlanTask) -> Vec<String> {
        let texts: Vec<&str> = match self {
            Self::Id => vec![&task.uid],
            Self::Code => vec![&task.code],
            Self::Wbs => vec![&task.wbs],
            Self::Name => vec![&task.name],
            Self::Field(name) => {
                task.fields.iter().filter(|(field, _)| fold(field) == *name).map(|(_, value)| value.as_str()).collect()
            }
        };
        parts(texts)
    }
}

/// Texts as they are compared, each with what separators in it divide: `A1020; A1030` is also `a1020` and `a1030`.
pub(crate) fn parts<'t>(texts: impl IntoIterator<Item = &'t str>) -> Vec<String> {
    let mut all = Vec::new();
    for text in texts {
        let whole = fold(text);
        if whole.contains([';', ',', '|', '\n']) {
            all.extend(whole.split([';', ',', '|', '\n']).map(fold).filter(|part| !part.is_empty()));
        }
        if !whole.is_empty() {
            all.push(whole);
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_text_of_several_values_is_each_of_them() {
        assert_eq!(parts(["A1020; A1030", " B ", ""]), ["a1020", "a1030", "a1020; a1030", "b"]);
    }

    #[test]
    fn values_of_tasks_are_named() {
        let task = PlanTask {
            code: "A10".into(),
            fields: vec![("Level".into(), "EG".into()), ("level ".into(), "1. OG".into())],
            ..PlanTask::default()
        };
        assert_eq!(TaskValue::parse("code").unwrap().of(&task), ["a10"]);
        assert_eq!(TaskValue::parse("field:LEVEL").unwrap().of(&task), ["eg", "1. og"]);
        assert!(TaskValue::parse("id").unwrap().of(&task).is_empty());
        assert!(TaskValue::parse("activity").unwrap_err().contains("=field:NAME"));
        assert!(TaskValue::parse("field:").is_err());
    }
}
