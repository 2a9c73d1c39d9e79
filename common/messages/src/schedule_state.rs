//! The `schedule-state` archive: states of elements and spaces at a plan time.

use crate::archive::{ArchiveError, NONE, Text, TextList};
use crate::content_hash::ContentHash;
use crate::declaration::declare_archive;
use crate::diagnostic_record::{DiagnosticRecord, check_diagnostics};
use crate::tag::{Tag, check_tags};
use bytemuck::{CheckedBitPattern, NoUninit, Pod, Zeroable};
use frames::PlanTime;

/// Head of the schedule state: one record. Times are seconds of the civil calendar since 1970-01-01T00:00.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Zeroable, Pod)]
#[repr(C)]
pub struct ScheduleStateHead {
    /// Content hash of the site it belongs to.
    pub site_hash: ContentHash,
    /// Content hash of the tasks of schedule files that it follows; 0 if it follows the schedule of the models.
    pub tasks_hash: ContentHash,
    /// The plan time; [`ScheduleStateHead::NO_TIME`] if everything is built regardless of dates.
    pub plan_time_s: i64,
    /// End of the period that the states are the union of, exclusive; [`ScheduleStateHead::NO_TIME`] for an instant.
    pub plan_until_s: i64,
    /// Last change at or before the plan time, or [`ScheduleStateHead::NO_TIME`].
    pub valid_from_s: i64,
    /// Next change after it, at or after the end of a period, or [`ScheduleStateHead::NO_TIME`].
    pub valid_until_s: i64,
    /// Number of change instants.
    pub n_changes: u32,
    /// 1 if the states follow the published prototype's rule.
    pub paper: u32,
}
const _: () = assert!(size_of::<ScheduleStateHead>() == 56);

impl ScheduleStateHead {
    /// No such time.
    pub const NO_TIME: i64 = i64::MIN;

    /// The plan time; `None` if everything is built regardless of dates.
    pub fn plan_time(&self) -> Option<PlanTime> {
        plan_time(self.plan_time_s)
    }

    /// The end of the period that the states are the union of; `None` for an instant.
    pub fn plan_until(&self) -> Option<PlanTime> {
        plan_time(self.plan_until_s)
    }

    /// The head of a schedule state in which everything is built.
    fn of_everything(site_hash: ContentHash) -> Self {
        let none = Self::NO_TIME;
        Self {
            site_hash,
            tasks_hash: ContentHash::NONE,
            plan_time_s: none,
            plan_until_s: none,
            valid_from_s: none,
            valid_until_s: none,
            n_changes: 0,
            paper: 0,
        }
    }
}

/// A time of a schedule state; `None` for [`ScheduleStateHead::NO_TIME`].
pub fn plan_time(seconds: i64) -> Option<PlanTime> {
    (seconds != ScheduleStateHead::NO_TIME).then(|| PlanTime::from_civil_seconds(seconds)).flatten()
}

/// State of an element.
#[derive(Debug, Clone, Copy, PartialEq, Eq, CheckedBitPattern, NoUninit)]
#[repr(u8)]
pub enum ElementState {
    /// Not there yet.
    NotStarted = 0,
    /// Being built.
    InProgress = 1,
    /// There.
    Built = 2,
    /// Being removed.
    BeingRemoved = 3,
    /// Gone.
    Removed = 4,
}

impl ElementState {
    /// All states.
    pub const ALL: [Self; 5] = [Self::NotStarted, Self::InProgress, Self::Built, Self::BeingRemoved, Self::Removed];

    /// True if the element is in the way: finished, or being worked on.
    pub fn is_obstacle(self) -> bool {
        matches!(self, Self::InProgress | Self::Built | Self::BeingRemoved)
    }

    /// Its name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::NotStarted => "not_started",
            Self::InProgress => "in_progress",
            Self::Built => "built",
            Self::BeingRemoved => "being_removed",
            Self::Removed => "removed",
        }
    }
}

/// State of a space.
#[derive(Debug, Clone, Copy, PartialEq, Eq, CheckedBitPattern, NoUninit)]
#[repr(u32)]
pub enum SpaceState {
    /// A robot may enter.
    Open = 0,
    /// A robot must not enter.
    Blocked = 1,
}

impl SpaceState {
    /// Both states.
    pub const ALL: [Self; 2] = [Self::Open, Self::Blocked];

    /// Its name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Open => "open",
            Self::Blocked => "blocked",
        }
    }
}

/// State of a space and why.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Zeroable, Pod)]
#[repr(C)]
pub struct SpaceStateRecord {
    /// Whether a robot may enter.
    pub state: Tag<SpaceState>,
    /// Zero.
    pub reserved: u32,
    /// Why it is blocked; none if open.
    pub reasons: TextList,
    /// When an open space that is closing soon will be blocked, or [`ScheduleStateHead::NO_TIME`].
    pub closes_at_s: i64,
}
const _: () = assert!(size_of::<SpaceStateRecord>() == 24);

/// When an element is built and removed, independent of the plan time. Missing times are
/// [`ScheduleStateHead::NO_TIME`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Zeroable, Pod)]
#[repr(C)]
pub struct ElementScheduleRecord {
    /// When work on it begins; missing where only the finish is known.
    pub start_s: i64,
    /// When it is finished.
    pub finish_s: i64,
    /// When its removal begins.
    pub removal_start_s: i64,
    /// When it is gone.
    pub removal_finish_s: i64,
    /// Working seconds by which its last task can slip without moving the end of the schedule.
    pub total_float_s: i64,
    /// Working seconds by which its last task can slip without moving any other.
    pub free_float_s: i64,
    /// Where the dates come from.
    pub source: Tag<DateSource>,
    /// The last task that builds it, else the last that removes it, or `NONE`.
    pub task: u32,
}
const _: () = assert!(size_of::<ElementScheduleRecord>() == 56);

impl ElementScheduleRecord {
    /// No date: the element exists.
    pub const NOTHING: Self = Self {
        start_s: ScheduleStateHead::NO_TIME,
        finish_s: ScheduleStateHead::NO_TIME,
        removal_start_s: ScheduleStateHead::NO_TIME,
        removal_finish_s: ScheduleStateHead::NO_TIME,
        total_float_s: ScheduleStateHead::NO_TIME,
        free_float_s: ScheduleStateHead::NO_TIME,
        source: Tag::numbered(DateSource::None as u32),
        task: NONE,
    };
}

/// Where an element's dates come from; the lower number wins.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, CheckedBitPattern, NoUninit)]
#[repr(u32)]
pub enum DateSource {
    /// No date: the element exists.
    None = 0,
    /// Progress that was reported for the element itself.
    Reported = 1,
    /// Actual dates of a task.
    Actual = 2,
    /// Scheduled dates of a task.
    Schedule = 3,
    /// Early dates of a task.
    Early = 4,
    /// Dates of a task, computed from sequence, durations and calendars.
    Computed = 5,
    /// A property with an actual date.
    PropertyActual = 6,
    /// A property with a planned date.
    PropertyPlanned = 7,
    /// The construction phase that a property names.
    ConstructionPhase = 8,
    /// A status without a date.
    Status = 9,
}

impl DateSource {
    /// Its name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Reported => "reported",
            Self::Actual => "task_actual",
            Self::Schedule => "task_schedule",
            Self::Early => "task_early",
            Self::Computed => "task_computed",
            Self::PropertyActual => "property_actual",
            Self::PropertyPlanned => "property",
            Self::ConstructionPhase => "phase",
            Self::Status => "status",
        }
    }
}

declare_archive! {
    /// States at a plan time, read in place.
    view ScheduleState;
    /// Records of a `schedule-state` archive to be.
    owned ScheduleStateBuilder;
    sections {
        /// Head of the schedule state.
        pub head: one(1, ScheduleStateHead),
        /// Planned state of each element of the site.
        planned: many(3, Tag<ElementState>),
        /// Effective state of each element of the site.
        effective: many(4, Tag<ElementState>),
        /// One record per space of the site.
        pub spaces: many(5, SpaceStateRecord),
        /// One record per element of the site; empty without a schedule.
        pub schedule: many(6, ElementScheduleRecord),
        /// Diagnostics of the schedule; entities are those of the site.
        pub diagnostics: many(7, DiagnosticRecord),
        /// All texts.
        texts: texts(2, listed 8),
    }
}

impl<'a> ScheduleState<'a> {
    fn check(&self) -> Result<(), ArchiveError> {
        check_tags(self.planned.iter().chain(self.effective).copied(), "state of an element")?;
        check_tags(self.spaces.iter().map(|s| s.state), "state of a space")?;
        check_tags(self.schedule.iter().map(|s| s.source), "source of dates")?;
        check_diagnostics(self.diagnostics)?;
        let diagnostics = self.diagnostics.iter().flat_map(DiagnosticRecord::texts);
        let mut texts = self.texts.listed().iter().copied().chain(diagnostics);
        // Spaces that share their reasons would be walked again and again.
        let n_reasons: u64 = self.spaces.iter().map(|s| u64::from(s.reasons.count)).sum();
        let n_elements = self.planned.len();
        let fits =
            n_elements == self.effective.len() && (self.schedule.is_empty() || self.schedule.len() == n_elements);
        let listed =
            self.spaces.iter().all(|s| self.texts.has_list(s.reasons)) && n_reasons <= self.texts.listed().len() as u64;
        if fits && listed && texts.all(|text| self.texts.has(text)) {
            Ok(())
        } else {
            Err(ArchiveError::Index { what: "a state" })
        }
    }

    /// The same schedule state as if nothing had been reported or observed: the effective states are the planned ones.
    pub fn as_planned(&self) -> Self {
        Self { effective: self.planned, ..*self }
    }

    /// State of an element of the site, as planned or as observed, whichever counts.
    pub fn effective(&self, element: usize) -> ElementState {
        self.effective[element].get()
    }

    /// Planned state of an element of the site.
    pub fn planned(&self, element: usize) -> ElementState {
        self.planned[element].get()
    }

    /// Planned and effective state of all elements.
    pub fn states(&self) -> [&'a [Tag<ElementState>]; 2] {
        [self.planned, self.effective]
    }

    /// Number of elements.
    pub fn n_elements(&self) -> usize {
        self.effective.len()
    }

    /// True if a robot must not enter the space.
    pub fn is_blocked(&self, space: usize) -> bool {
        self.spaces[space].state == SpaceState::Blocked
    }

    /// When and from what an element is built.
    pub fn schedule_of(&self, element: usize) -> ElementScheduleRecord {
        self.schedule.get(element).copied().unwrap_or(ElementScheduleRecord::NOTHING)
    }

    /// The text of a diagnostic.
    pub fn text(&self, text: Text) -> &'a str {
        self.texts.get(text)
    }

    /// Why a space is blocked; empty if it is open.
    pub fn why(&self, space: usize) -> impl Iterator<Item = &'a str> + use<'a> {
        self.texts.list(self.spaces[space].reasons)
    }
}

impl ScheduleStateBuilder {
    /// The schedule state in which every element is built and every space is open.
    pub fn everything_built(site_hash: ContentHash, n_elements: usize, n_spaces: usize) -> Self {
        let open = SpaceStateRecord {
            state: SpaceState::Open.into(),
            reserved: 0,
            reasons: TextList::default(),
            closes_at_s: ScheduleStateHead::NO_TIME,
        };
        Self {
            head: ScheduleStateHead::of_everything(site_hash),
            planned: vec![ElementState::Built.into(); n_elements],
            effective: vec![ElementState::Built.into(); n_elements],
            spaces: vec![open; n_spaces],
            ..Self::default()
        }
    }

    /// Sets the planned and the effective state of an element.
    pub fn set_element(&mut self, element: usize, planned: ElementState, effective: ElementState) {
        self.planned[element] = planned.into();
        self.effective[element] = effective.into();
    }

    /// Blocks a space for these reasons.
    pub fn block_space(&mut self, space: usize, why: &[&str]) {
        let reasons = self.texts.add_list(why.iter().copied());
        let closes_at_s = ScheduleStateHead::NO_TIME;
        self.spaces[space] = SpaceStateRecord { state: SpaceState::Blocked.into(), reserved: 0, reasons, closes_at_s };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn states_and_reasons_come_back() {
        let mut builder = ScheduleStateBuilder::everything_built(ContentHash::from_bits(7), 2, 2);
        builder.set_element(1, ElementState::Built, ElementState::InProgress);
        builder.block_space(0, &["task:abc", "private"]);
        let buffer = builder.finish();
        let schedule_state = ScheduleState::open(buffer.bytes()).unwrap();
        assert_eq!(
            (schedule_state.planned(1), schedule_state.effective(1)),
            (ElementState::Built, ElementState::InProgress)
        );
        assert_eq!(schedule_state.why(0).collect::<Vec<_>>(), ["task:abc", "private"]);
        assert_eq!(schedule_state.as_planned().effective(1), ElementState::Built);
        assert!(
            schedule_state.is_blocked(0) && !schedule_state.is_blocked(1) && schedule_state.why(1).next().is_none()
        );
        assert_eq!(schedule_state.head.plan_time(), None);
    }
}
