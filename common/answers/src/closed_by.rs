//! Tasks, dates and work by which the schedule closes a room.

use crate::named::{TaskRef, date_text};
use crate::situation::{Situation, task_called};
use messages::{ScheduleState, Site};
use schedule::Timeline;
use schemars::JsonSchema;
use serde::Serialize;

/// A reason why a room is closed.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct ClosedBy {
    /// `task`, `before_room_date`, `no_room_date`, or what the rules say, e.g. `private`.
    pub code: String,
    /// The task that works in it; null if it is none.
    pub task: Option<TaskRef>,
    /// When that task is finished; null if it is none, or not known.
    pub until: Option<String>,
}

impl ClosedBy {
    /// Of a reason as schedule states have it: `task:GlobalId`, or a word.
    pub(crate) fn of(site: &Site<'_>, timeline: Option<&Timeline>, why: &str) -> Self {
        let Some(id) = why.strip_prefix("task:") else {
            return Self { code: why.to_owned(), task: None, until: None };
        };
        let found = task_called(site, id);
        let dates = timeline.zip(found).and_then(|(timeline, task)| timeline.task(task));
        let unnamed = || TaskRef { global_id: id.to_owned(), identification: None, name: None };
        Self {
            code: "task".to_owned(),
            task: Some(found.map_or_else(unnamed, |task| TaskRef::of(site, task))),
            until: dates.map(|dates| date_text(dates.finish_s)),
        }
    }

    /// Why a space is closed at the plan time; none if it is open.
    pub(crate) fn all_of(situation: &Situation<'_>, space: usize) -> Vec<Self> {
        Self::all_in(situation.site, situation.timeline, situation.schedule_state, space)
    }

    /// The same by a schedule state, without maps.
    pub(crate) fn all_in(
        site: &Site<'_>,
        timeline: Option<&Timeline>,
        schedule_state: &ScheduleState<'_>,
        space: usize,
    ) -> Vec<Self> {
        schedule_state.why(space).map(|why| Self::of(site, timeline, why)).collect()
    }

    /// For people.
    pub(crate) fn text(&self) -> String {
        match (&self.task, &self.until) {
            (Some(task), Some(until)) => format!("task {:?} works in it until {until}", task.label()),
            (Some(task), None) => format!("task {:?} works in it", task.label()),
            (None, _) => self.code.replace('_', " "),
        }
    }
}
