//! Tasks of the schedule that work on something, with their dates.

use crate::named::{TaskRef, optional_date_text};
use crate::situation::Situation;
use schedule::{TaskTargets, Timeline};
use schemars::JsonSchema;
use serde::Serialize;

/// A task with its dates.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct DatedTask {
    /// The task.
    #[serde(flatten)]
    pub task: TaskRef,
    /// Start; null if it has no dates that can be used.
    pub start: Option<String>,
    /// Finish, exclusive.
    pub finish: Option<String>,
}

/// The tasks whose targets fit, by start.
pub(crate) fn tasks_of(
    situation: &Situation<'_>,
    timeline: &Timeline,
    fits: impl Fn(&TaskTargets) -> bool,
) -> Vec<DatedTask> {
    let targets = timeline.task_targets(situation.site);
    let mut found: Vec<usize> = (0..targets.len()).filter(|task| fits(&targets[*task])).collect();
    found.sort_by_key(|task| (timeline.task(*task).map_or(i64::MAX, |dates| dates.start_s), *task));
    let task = |k: usize| {
        let dates = timeline.task(k);
        DatedTask {
            task: TaskRef::of(situation.site, k),
            start: dates.and_then(|dates| optional_date_text(dates.start_s)),
            finish: dates.and_then(|dates| optional_date_text(dates.finish_s)),
        }
    };
    found.into_iter().map(task).collect()
}

impl DatedTask {
    /// For people.
    pub(crate) fn line(&self) -> String {
        let dates = match (&self.start, &self.finish) {
            (Some(start), Some(finish)) => format!("{start} until {finish}"),
            _ => "no dates".to_owned(),
        };
        format!("task {:?}: {dates}", self.task.label())
    }
}
