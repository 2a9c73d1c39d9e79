//! States at any instant or period, by lookup in sorted changes.

use crate::closures::{Closure, ClosureReason};
use crate::task_effects::Effect;
use crate::tasks::{Floats, TaskDates};
use messages::{
    ContentHash, Diagnostic, DiagnosticRecord, ElementScheduleRecord, ElementState, ScheduleStateBuilder,
    ScheduleStateHead, SpaceState, SpaceStateRecord, TextList,
};

/// All changes of elements and spaces over time, evaluated once from site and rules.
#[derive(Debug)]
pub struct Timeline {
    pub(crate) site_hash: ContentHash,
    /// 0 for the schedule of the models.
    pub(crate) tasks_hash: ContentHash,
    pub(crate) elements: Steps<ElementState>,
    /// Planned states of the elements; `None` if they equal the effective ones.
    pub(crate) planned_states: Option<PlannedStates>,
    pub(crate) spaces: Steps<SpaceState>,
    pub(crate) closures: Vec<Vec<Closure>>,
    /// Effects on each element with their tasks, sorted.
    pub(crate) effects: Vec<Vec<Effect>>,
    /// GlobalIds of the tasks, and reasons of the closing rules.
    pub(crate) task_ids: Vec<String>,
    pub(crate) closing_reasons: Vec<String>,
    pub(crate) instants_s: Vec<i64>,
    pub(crate) schedule: Vec<ElementScheduleRecord>,
    pub(crate) tasks: Vec<Option<TaskDates>>,
    pub(crate) floats: Vec<Option<Floats>>,
    pub(crate) diagnostics: Vec<Diagnostic>,
    pub(crate) closing_lead_s: i64,
    pub(crate) is_paper: bool,
}

/// The elements as they were planned.
#[derive(Debug)]
pub(crate) struct PlannedStates {
    elements: Steps<ElementState>,
    instants_s: Vec<i64>,
}

/// States of many objects over time: the first of each is before all time.
#[derive(Debug)]
pub(crate) struct Steps<S> {
    /// Where the steps of each object begin; one more than there are objects.
    offsets: Vec<u32>,
    times_s: Vec<i64>,
    states: Vec<S>,
}

/// A plan time: an instant, or all instants of a period.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Period {
    /// The instant, or the first, civil seconds since 1970.
    pub from_s: i64,
    /// The end, exclusive; `None` for an instant.
    pub until_s: Option<i64>,
}

/// What changes at an instant.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Change {
    /// When, civil seconds since 1970.
    pub at_s: i64,
    /// Element, state before and after; by element.
    pub elements: Vec<(u32, ElementState, ElementState)>,
    /// Space, whether it was blocked before and is after; by space.
    pub spaces: Vec<(u32, bool, bool)>,
}

impl<S> Default for Steps<S> {
    fn default() -> Self {
        Self { offsets: Vec::new(), times_s: Vec::new(), states: Vec::new() }
    }
}

impl<S: Copy + PartialEq> Steps<S> {
    /// Appends an object: its first state, then its changes by time; what changes nothing is dropped.
    pub(crate) fn push(&mut self, first: S, steps: impl Iterator<Item = (i64, S)>) {
        if self.offsets.is_empty() {
            self.offsets.push(0);
        }
        let begin = self.times_s.len();
        self.times_s.push(i64::MIN);
        self.states.push(first);
        for (time_s, state) in steps {
            let last = self.times_s.len() - 1;
            if self.times_s[last] == time_s {
                self.states[last] = state;
                // What the instant took back is no change.
                if last > begin && self.states[last - 1] == state {
                    self.times_s.pop();
                    self.states.pop();
                }
            } else if self.states[last] != state {
                self.times_s.push(time_s);
                self.states.push(state);
            }
        }
        self.offsets.push(self.times_s.len() as u32);
    }

    pub(crate) fn len(&self) -> usize {
        self.offsets.len().saturating_sub(1)
    }

    fn of(&self, object: usize) -> (&[i64], &[S]) {
        let span = self.offsets[object] as usize..self.offsets[object + 1] as usize;
        (&self.times_s[span.clone()], &self.states[span])
    }

    /// Place of the last step at or before an instant.
    fn last_at(times_s: &[i64], at_s: i64) -> usize {
        // Few objects have more than four steps: counting beats searching.
        if times_s.len() <= 8 {
            times_s[1..].iter().take_while(|t| **t <= at_s).count()
        } else {
            times_s.partition_point(|t| *t <= at_s).max(1) - 1
        }
    }

    pub(crate) fn at(&self, object: usize, at_s: i64) -> S {
        let (times_s, states) = self.of(object);
        states[Self::last_at(times_s, at_s)]
    }

    /// All states that an object has in a period.
    pub(crate) fn within(&self, object: usize, period: Period) -> &[S] {
        let (times_s, states) = self.of(object);
        let first = Self::last_at(times_s, period.from_s);
        let last = period.until_s.map_or(first, |until_s| Self::last_at(times_s, until_s.saturating_sub(1)));
        &states[first..=last.max(first)]
    }

    /// The next change after an instant.
    fn next_after(&self, object: usize, at_s: i64) -> Option<(i64, S)> {
        let (times_s, states) = self.of(object);
        let next = Self::last_at(times_s, at_s) + 1;
        Some((*times_s.get(next)?, states[next]))
    }

    /// Every change: time, object, state before and after.
    pub(crate) fn changes(&self) -> impl Iterator<Item = (i64, u32, S, S)> {
        (0..self.len()).flat_map(|object| {
            let (times_s, states) = self.of(object);
            (1..times_s.len()).map(move |k| (times_s[k], object as u32, states[k - 1], states[k]))
        })
    }
}

impl Period {
    /// An instant.
    pub fn instant(at_s: i64) -> Self {
        Self { from_s: at_s, until_s: None }
    }
}

impl Timeline {
    /// Adds the planned states, where they differ from the effective ones.
    pub(crate) fn with_planned_states(self, planned_states: Self) -> Self {
        let mut instants_s: Vec<i64> = planned_states.elements.changes().map(|change| change.0).collect();
        instants_s.sort_unstable();
        instants_s.dedup();
        Self { planned_states: Some(PlannedStates { elements: planned_states.elements, instants_s }), ..self }
    }

    /// The instants at which anything changes, sorted, civil seconds since 1970.
    pub fn instants_s(&self) -> &[i64] {
        &self.instants_s
    }

    /// The instants at which the schedule state changes, sorted: change instants, and those at which spaces begin to be
    /// closing soon.
    pub fn update_instants_s(&self) -> Vec<i64> {
        let closing = self.spaces.changes().filter(|change| change.3 == SpaceState::Blocked);
        let closing = closing.map(|change| change.0.saturating_sub(self.closing_lead_s));
        let planned = self.planned_states.iter().flat_map(|planned_states| &planned_states.instants_s);
        let mut update_instants_s: Vec<i64> = self.instants_s.iter().chain(planned).copied().chain(closing).collect();
        update_instants_s.sort_unstable();
        update_instants_s.dedup();
        update_instants_s
    }

    /// Diagnostics of the schedule.
    pub fn diagnostics(&self) -> &[Diagnostic] {
        &self.diagnostics
    }

    /// Dates of a task of the site, if it has any.
    pub fn task(&self, task: usize) -> Option<TaskDates> {
        self.tasks[task]
    }

    /// Float of a task of the site, if it is no summary and has dates.
    pub fn float(&self, task: usize) -> Option<Floats> {
        self.floats[task]
    }

    /// State of an element at an instant.
    pub fn element(&self, element: usize, at_s: i64) -> ElementState {
        self.elements.at(element, at_s)
    }

    /// State of an element at an instant, or the union over a period.
    pub(crate) fn element_over(&self, element: usize, period: Period) -> ElementState {
        union_of(self.elements.within(element, period))
    }

    /// States of all elements at an instant.
    pub fn elements_at(&self, at_s: i64, states: &mut [ElementState]) {
        states.iter_mut().enumerate().for_each(|(k, s)| *s = self.elements.at(k, at_s));
    }

    /// True if a space must not be entered at an instant.
    pub fn is_blocked(&self, space: usize, at_s: i64) -> bool {
        self.spaces.at(space, at_s) == SpaceState::Blocked
    }

    /// Why a space is blocked at an instant, or at any in a period; sorted, empty if it is open.
    pub fn why(&self, space: usize, period: Period) -> Vec<String> {
        let until_s = period.until_s.unwrap_or(period.from_s.saturating_add(1));
        let begun = &self.closures[space];
        let begun = &begun[..begun.partition_point(|c| c.start_s < until_s)];
        let mut reasons: Vec<(ClosureReason, String)> =
            begun.iter().filter(|c| period.from_s < c.finish_s).map(|c| (c.why, self.reason(c.why))).collect();
        // Tasks by GlobalId, then what is not a task.
        reasons.sort_by(|(a, x), (b, y)| {
            (!matches!(a, ClosureReason::Task(_)), x).cmp(&(!matches!(b, ClosureReason::Task(_)), y))
        });
        let mut reasons: Vec<String> = reasons.into_iter().map(|(_, text)| text).collect();
        reasons.dedup();
        reasons
    }

    fn reason(&self, why: ClosureReason) -> String {
        match why {
            ClosureReason::Task(task) => format!("task:{}", self.task_ids[task as usize]),
            ClosureReason::BeforeRoomDate => "before_room_date".to_owned(),
            ClosureReason::NoRoomDate => "no_room_date".to_owned(),
            ClosureReason::Closed(rule) => self.closing_reasons[rule as usize].clone(),
        }
    }

    /// All changes by time.
    pub fn changes(&self) -> Vec<Change> {
        let empty = |at_s: &i64| Change { at_s: *at_s, elements: Vec::new(), spaces: Vec::new() };
        let mut changes: Vec<Change> = self.instants_s.iter().map(empty).collect();
        let place = |at_s: i64| self.instants_s.binary_search(&at_s).expect("every change is an instant");
        for (at_s, element, before, after) in self.elements.changes() {
            changes[place(at_s)].elements.push((element, before, after));
        }
        for (at_s, space, before, after) in self.spaces.changes() {
            changes[place(at_s)].spaces.push((space, before == SpaceState::Blocked, after == SpaceState::Blocked));
        }
        changes
    }

    /// The schedule state at an instant, or the union over a period.
    ///
    /// In a union a space is blocked if it is at any instant. An element that is in progress at any instant, or not
    /// built throughout, is in progress: an obstacle, but no floor.
    ///
    /// It is valid until the next change of an effective or planned state.
    pub fn schedule_state(&self, period: Period) -> ScheduleStateBuilder {
        let mut builder =
            ScheduleStateBuilder::everything_built(self.site_hash, self.elements.len(), self.spaces.len());
        builder.head.tasks_hash = self.tasks_hash;
        let none = ScheduleStateHead::NO_TIME;
        let end_s = period.until_s.unwrap_or(period.from_s.saturating_add(1));
        let changes =
            || [Some(&self.instants_s), self.planned_states.as_ref().map(|p| &p.instants_s)].into_iter().flatten();
        let last = |s: &Vec<i64>| s.partition_point(|s| *s <= period.from_s).checked_sub(1).map(|k| s[k]);
        let next = |s: &Vec<i64>| s.get(s.partition_point(|s| *s < end_s)).copied();
        builder.head = ScheduleStateHead {
            plan_time_s: period.from_s,
            plan_until_s: period.until_s.unwrap_or(none),
            valid_from_s: changes().filter_map(last).max().unwrap_or(none),
            valid_until_s: changes().filter_map(next).min().unwrap_or(none),
            n_changes: self.instants_s.len() as u32,
            paper: u32::from(self.is_paper),
            ..builder.head
        };
        for (k, effective) in builder.effective.iter_mut().enumerate() {
            *effective = self.element_over(k, period).into();
        }
        match &self.planned_states {
            Some(planned_states) => {
                for (k, planned) in builder.planned.iter_mut().enumerate() {
                    *planned = union_of(planned_states.elements.within(k, period)).into();
                }
            }
            None => builder.planned.copy_from_slice(&builder.effective),
        }
        for space in 0..self.spaces.len() {
            builder.spaces[space] = self.space_state(&mut builder.texts, space, period);
        }
        self.describe(&mut builder);
        builder
    }

    /// The schedule state at an instant; without one everything is built.
    pub fn schedule_state_at(&self, at_s: Option<i64>) -> ScheduleStateBuilder {
        at_s.map_or_else(|| self.everything_built(), |at_s| self.schedule_state(Period::instant(at_s)))
    }

    /// The schedule state in which everything is built, with the dates and diagnostics of the schedule.
    pub fn everything_built(&self) -> ScheduleStateBuilder {
        let mut builder =
            ScheduleStateBuilder::everything_built(self.site_hash, self.elements.len(), self.spaces.len());
        builder.head.tasks_hash = self.tasks_hash;
        builder.head.n_changes = self.instants_s.len() as u32;
        self.describe(&mut builder);
        builder
    }

    /// Schedule and diagnostics, which do not depend on the plan time.
    fn describe(&self, builder: &mut ScheduleStateBuilder) {
        builder.schedule.clone_from(&self.schedule);
        builder.diagnostics = self.diagnostics.iter().map(|f| DiagnosticRecord::of(f, &mut builder.texts)).collect();
    }

    fn space_state(&self, texts: &mut messages::TextPool, space: usize, period: Period) -> SpaceStateRecord {
        let open = SpaceStateRecord {
            state: SpaceState::Open.into(),
            reserved: 0,
            reasons: TextList::default(),
            closes_at_s: ScheduleStateHead::NO_TIME,
        };
        if self.spaces.within(space, period).contains(&SpaceState::Blocked) {
            let why = self.why(space, period);
            let reasons = texts.add_list(why.iter().map(String::as_str).filter(|reason| !reason.is_empty()));
            return SpaceStateRecord { state: SpaceState::Blocked.into(), reasons, ..open };
        }
        let last_s = period.until_s.map_or(period.from_s, |until_s| until_s.saturating_sub(1));
        match self.spaces.next_after(space, last_s) {
            Some((closes_at_s, _)) if closes_at_s <= last_s.saturating_add(self.closing_lead_s) => {
                SpaceStateRecord { closes_at_s, ..open }
            }
            _ => open,
        }
    }
}

/// The state over a period, from all states in it.
pub(crate) fn union_of(states: &[ElementState]) -> ElementState {
    match states {
        [one] => *one,
        // It changes: within the period the robot meets the element or the work on it.
        _ => ElementState::InProgress,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn steps(first: u8, changes: &[(i64, u8)]) -> Steps<u8> {
        let mut steps = Steps::default();
        steps.push(first, changes.iter().copied());
        steps
    }

    #[test]
    fn a_state_holds_from_its_instant_until_before_the_next() {
        let steps = steps(0, &[(10, 1), (20, 2)]);
        assert_eq!([9, 10, 19, 20, i64::MAX].map(|t| steps.at(0, t)), [0, 1, 1, 2, 2]);
        let many: Vec<(i64, u8)> = (0..20).map(|k| (k * 10, (k % 2) as u8 + 1)).collect();
        let many = super::tests::steps(0, &many);
        assert_eq!([-1, 0, 15, 199].map(|t| many.at(0, t)), [0, 1, 2, 2]);
    }

    #[test]
    fn what_changes_nothing_is_no_step() {
        let steps = steps(2, &[(5, 2), (10, 3), (10, 2), (12, 4), (12, 1)]);
        assert_eq!(steps.changes().collect::<Vec<_>>(), [(12, 0, 2, 1)]);
    }

    #[test]
    fn a_period_has_all_states_between_its_ends() {
        let steps = steps(0, &[(10, 1), (20, 2)]);
        let within = |from_s, until_s| steps.within(0, Period { from_s, until_s: Some(until_s) }).to_vec();
        assert_eq!(
            (within(0, 10), within(0, 11), within(15, 30), within(20, 99)),
            (vec![0], vec![0, 1], vec![1, 2], vec![2])
        );
        assert_eq!(
            union_of(&[ElementState::NotStarted, ElementState::Built]),
            ElementState::InProgress,
            "floor that appears at noon is no floor in the morning"
        );
        assert_eq!(union_of(&[ElementState::Removed]), ElementState::Removed);
    }
}
