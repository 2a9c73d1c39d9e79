//! A work schedule in an archive: tasks, calendars, dependencies, and what tasks work on.

use crate::archive::{ArchiveError, NONE};
use crate::content_hash::ContentHash;
use crate::declaration::declare_sections;
use crate::diagnostic_record::{DiagnosticRecord, check_diagnostics};
use crate::schedule_dates::{ScheduleDateRecord, ScheduleLength, TaskDurationRecord};
use crate::schedule_records::*;
use crate::spans::{fits, optional};
use crate::tag::check_tags;
use crate::text_pool::Texts;

declare_sections! {
    /// A work schedule, read in place: of the models in a `site` archive, or of schedule files in a `tasks` archive.
    ///
    /// All indices inside were checked when its archive was opened, so slicing by them does not panic.
    view WorkSchedule |archive| {
        pub(crate) texts: Texts<'a> = Texts::of(archive, 2)?,
        /// Hash of the `tasks` archive that it is from; 0 for the schedule of the models.
        pub tasks_hash: ContentHash = ContentHash::NONE,
        /// Schedule files that it is from; empty for the schedule of the models, whose files are those of the site.
        pub sources: &'a [ScheduleSourceRecord] = &[],
        /// The rule that made each link; empty for the schedule of the models, which have the links themselves.
        pub link_rules: &'a [ScheduleText] = &[],
        /// What is wrong with schedule files and links; empty for the schedule of the models. Files are those of `sources`.
        pub diagnostics: &'a [DiagnosticRecord] = &[],
    };
    /// Records of a work schedule to be. Their texts are in the pool of their archive.
    owned WorkScheduleRecords;
    // Of those that most schedules have none of, an archive has no section without records: there are archives from before each.
    sections {
        /// Work plans and schedules.
        pub work_controls: many(32, WorkControlRecord),
        /// Calendars.
        pub calendars: many(33, CalendarRecord),
        /// Times of calendars.
        pub work_times: many(34, WorkTimeRecord),
        /// Periods of work times: `[from, to)` in seconds of the day; an end that is not after its start lies on the next day.
        pub periods_s: many(35, [u32; 2]),
        /// Tasks.
        pub tasks: many(36, TaskRecord),
        /// Dependencies between tasks.
        pub sequences: many(37, SequenceRecord),
        /// What tasks work on.
        pub task_links: many(38, TaskLinkRecord),
        /// Three-point durations of tasks, ascending by task; of most schedules none.
        pub uncertainties: if_any(39, TaskUncertaintyRecord),
        /// Dates that bind tasks, in the order of the tasks; of most schedules none.
        pub constraints: if_any(42, TaskConstraintRecord),
        /// Dates of planners' files by kind and owner; [`WorkSchedule::date`] finds them. Of the schedule of the models none.
        pub dates: if_any(43, ScheduleDateRecord),
        /// Planned lengths of tasks of planners' files, ascending by task; [`WorkSchedule::duration`] finds them.
        pub durations: if_any(44, TaskDurationRecord),
        /// Work of resources by their calendars, ascending by task and calendar; of most tasks none.
        pub assignments: if_any(45, TaskAssignmentRecord),
    }
}

/// Numbers of what tasks may work on.
#[derive(Debug, Clone, Copy)]
pub(crate) struct LinkTargets {
    pub(crate) elements: usize,
    pub(crate) spaces: usize,
    pub(crate) storeys: usize,
}

impl<'a> WorkSchedule<'a> {
    /// The text.
    pub fn text(&self, text: ScheduleText) -> &'a str {
        self.texts.get(text.0)
    }

    /// The lag of a sequence; `None` if it has none, or a ratio.
    pub fn lag(&self, sequence: &SequenceRecord) -> Option<ScheduleLength<'a>> {
        match self.text(sequence.lag) {
            "" if sequence.lag_s == 0 => None,
            "" => Some(ScheduleLength::Seconds(sequence.lag_s)),
            text => Some(ScheduleLength::Text(text)),
        }
    }

    /// Checks tags, indices and texts.
    pub(crate) fn check(&self, targets: LinkTargets) -> Result<(), ArchiveError> {
        check_tags(self.work_times.iter().map(|w| w.kind), "kind of recurrence")?;
        check_tags(self.tasks.iter().map(|t| t.duration_kind), "kind of duration")?;
        check_tags(self.sequences.iter().map(|s| s.lag_kind), "kind of duration")?;
        check_tags(self.sequences.iter().map(|s| s.kind), "kind of sequence")?;
        check_tags(self.task_links.iter().map(|l| l.kind), "kind of link")?;
        check_tags(self.constraints.iter().map(|c| c.kind), "kind of constraint")?;
        check_diagnostics(self.diagnostics)?;
        self.check_indices(targets)?;
        self.check_dates()?;
        self.check_texts()
    }

    fn check_indices(&self, targets: LinkTargets) -> Result<(), ArchiveError> {
        let n_tasks = self.tasks.len();
        let task = |t: &TaskRecord| {
            optional(t.parent, n_tasks)
                && optional(t.control, self.work_controls.len())
                && optional(t.calendar, self.calendars.len())
        };
        let calendar = |c: &CalendarRecord| {
            fits(c.first_work_time, c.n_working.saturating_add(c.n_exceptions), self.work_times.len())
        };
        let link = |l: &TaskLinkRecord| {
            let n_targets = match l.kind.get() {
                LinkKind::Element => targets.elements,
                LinkKind::Space => targets.spaces,
                LinkKind::Storey => targets.storeys,
            };
            (l.task as usize) < n_tasks && (l.target as usize) < n_targets
        };
        let sequence = |s: &SequenceRecord| {
            (s.predecessor as usize) < n_tasks
                && (s.successor as usize) < n_tasks
                && optional(s.lag_calendar, self.calendars.len())
        };
        let assignment = |a: &TaskAssignmentRecord| {
            (a.task as usize) < n_tasks
                && (a.calendar as usize) < self.calendars.len()
                && (1..=TaskUncertaintyRecord::MAX_DURATION_S).contains(&a.duration_s)
        };
        let n_sources = self.sources.len();
        let whole = self.tasks.iter().all(task)
            && self.diagnostics.iter().all(|d| optional(d.source, n_sources))
            && self.calendars.iter().all(calendar)
            && self.work_times.iter().all(|w| fits(w.first_period, w.n_periods, self.periods_s.len()))
            && self.sequences.iter().all(sequence)
            && self.task_links.iter().all(link)
            && self.uncertainties.iter().all(|u| (u.task as usize) < n_tasks && u.is_elapsed <= 1 && u.is_ascending())
            && self.uncertainties.is_sorted_by(|a, b| a.task < b.task)
            && self.constraints.iter().all(|c| (c.task as usize) < n_tasks && c.is_in_calendar())
            && self.constraints.is_sorted_by_key(|c| c.task)
            && self.assignments.iter().all(assignment)
            && self.assignments.is_sorted_by(|a, b| (a.task, a.calendar) < (b.task, b.calendar))
            && is_forest(self.tasks);
        if whole { Ok(()) } else { Err(ArchiveError::Index { what: "the schedule" }) }
    }

    fn check_texts(&self) -> Result<(), ArchiveError> {
        let controls =
            self.work_controls.iter().flat_map(|c| [c.global_id, c.name, c.predefined_type, c.start, c.finish]);
        let calendars = self.calendars.iter().flat_map(|c| [c.global_id, c.name]);
        let sequences = self.sequences.iter().flat_map(|s| [s.global_id, s.lag]);
        let tasks = self.tasks.iter().flat_map(TaskRecord::texts);
        let sources = self.sources.iter().flat_map(|s| [s.file, s.written_by]);
        let diagnostics = self.diagnostics.iter().flat_map(DiagnosticRecord::texts).map(ScheduleText);
        let links = sources.chain(self.link_rules.iter().copied()).chain(diagnostics);
        let mut all = controls.chain(calendars).chain(sequences).chain(tasks).chain(links);
        if all.all(|text| self.texts.has(text.0)) { Ok(()) } else { Err(ArchiveError::Index { what: "a text" }) }
    }
}

impl TaskRecord {
    fn texts(&self) -> [ScheduleText; 13] {
        [
            self.global_id,
            self.name,
            self.identification,
            self.predefined_type,
            self.schedule_duration,
            self.schedule_start,
            self.schedule_finish,
            self.early_start,
            self.early_finish,
            self.late_start,
            self.late_finish,
            self.actual_start,
            self.actual_finish,
        ]
    }

    /// True if all of these bits of [`task_flags`] are set.
    pub fn has(&self, flags: u32) -> bool {
        self.flags & flags == flags
    }
}

/// True if no task is nested in itself. The parents of all tasks lie in the section.
fn is_forest(tasks: &[TaskRecord]) -> bool {
    // On which walk a task was met; 0 for none.
    let mut met = vec![0u32; tasks.len()];
    for (walk, start) in (1..).zip(0..tasks.len()) {
        let mut at = start;
        while met[at] == 0 {
            met[at] = walk;
            match tasks[at].parent {
                NONE => break,
                parent if met[parent as usize] == walk => return false,
                parent => at = parent as usize,
            }
        }
    }
    true
}
