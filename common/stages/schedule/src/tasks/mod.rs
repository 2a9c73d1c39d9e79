//! Task dates: written dates, forward pass over sequences, delays, float.

mod constraints;
mod delays;
mod floats;
mod graph;
mod read_date;
mod resolve;
mod span;
mod task_times;

pub(crate) use constraints::{Limits, limits, report as report_constraints};
pub(crate) use delays::{delay, total_delay_s};
pub use floats::Floats;
pub(crate) use floats::floats;
pub(crate) use graph::{decides, dependencies};
pub(crate) use resolve::{WorkStarts, resolve};
pub(crate) use span::{SpanBounds, SpanLink, sequences_of_spans, span_dates, span_links};
pub(crate) use task_times::{TaskKind, TaskTimes, WrittenTaskTimes, kind_of, task_times, written_span_s};

use crate::clock::Calendars;
use crate::rules::Rules;
use messages::{DateSource, DurationKind, NONE, SequenceKind, SequenceRecord, Site, Tag, sequence_flags, task_flags};

/// When a task begins and ends, civil seconds since 1970: it is in progress from its start until before its finish.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TaskDates {
    /// Start.
    pub start_s: i64,
    /// Finish.
    pub finish_s: i64,
    /// Where they come from.
    pub source: DateSource,
}

/// Data of all tasks for the computation of their dates.
pub(crate) struct Tasks<'a> {
    pub(crate) site: &'a Site<'a>,
    pub(crate) rules: &'a Rules,
    pub(crate) task_times: &'a [TaskTimes],
    /// What the constraints of each task say.
    pub(crate) limits: &'a [Limits],
    pub(crate) calendars: &'a Calendars,
    /// Tasks nested in each task.
    pub(crate) children: &'a [Vec<u32>],
}

impl Tasks<'_> {
    pub(crate) fn is_summary(&self, task: usize) -> bool {
        !self.children[task].is_empty()
    }

    /// It is scheduled by hand: no other task moves it.
    pub(crate) fn is_manual(&self, task: usize) -> bool {
        self.site.schedule.tasks[task].has(task_flags::MANUAL)
    }

    /// It has actual dates: no constraint moves it.
    pub(crate) fn has_begun(&self, task: usize) -> bool {
        let task_times = &self.task_times[task];
        task_times.actual_start.is_some() || task_times.actual_finish.is_some()
    }

    /// The time in which work on a task goes on: of its calendar, or of those of its resources.
    pub(crate) fn clock(&self, task: usize) -> crate::clock::Clock<'_> {
        let task_times = &self.task_times[task];
        match &task_times.work[..] {
            [] => self.calendars.clock(task_times.clock),
            [one] => self.calendars.clock(Some(one.calendar)),
            several => crate::clock::Clock::Shared(self.calendars, several),
        }
    }

    /// Working time of a task: as written, else between its dates.
    fn duration_s(&self, task: usize, dates: TaskDates) -> i64 {
        let written_s = self.task_times[task].duration_s;
        written_s.unwrap_or_else(|| self.clock(task).between(dates.start_s, dates.finish_s))
    }

    /// The lag of a sequence in seconds, and the clock on which it passes: that of its calendar, else of the successor's.
    pub(crate) fn lag(
        &self,
        sequence: &SequenceRecord,
        predecessor: TaskDates,
    ) -> Option<(i64, crate::clock::Clock<'_>)> {
        let own = Some(sequence.lag_calendar).filter(|calendar| *calendar != NONE).map(|calendar| calendar as usize);
        let calendar = own.or(self.task_times[sequence.successor as usize].calendar);
        let is_elapsed = |kind: Tag<DurationKind>| kind == DurationKind::ElapsedTime;
        // A part of an elapsed duration is elapsed.
        let of_predecessor = || is_elapsed(self.site.schedule.tasks[sequence.predecessor as usize].duration_kind);
        let elapsed = is_elapsed(sequence.lag_kind) || sequence.lag_ratio != 0.0 && of_predecessor();
        let clock = self.calendars.clock(calendar.filter(|_| !elapsed));
        let lag_s = match self.site.schedule.lag(sequence) {
            Some(lag) => crate::durations::WrittenDuration::of(lag).ok()?.seconds(clock.day()),
            None => {
                let predecessor_s = self.duration_s(sequence.predecessor as usize, predecessor);
                (sequence.lag_ratio * predecessor_s as f64).round() as i64
            }
        };
        Some((lag_s, clock))
    }

    /// The instant from which a sequence lets the start or the finish of its successor be; `None` if it cannot be worked out.
    fn end_bound_s(&self, sequence: &SequenceRecord, predecessor: TaskDates) -> Option<i64> {
        let (from_start, to_start) = ends(sequence);
        let base_s = if from_start { predecessor.start_s } else { predecessor.finish_s };
        let (lag_s, clock) = self.lag(sequence, predecessor)?;
        let is_primavera = sequence.flags & sequence_flags::PRIMAVERA != 0;
        if is_primavera && from_start && to_start && lag_s == 0 {
            return clock.next_working(base_s);
        }
        clock.add(base_s, lag_s)
    }

    /// The finish that a sequence of Primavera P6 asks for and that stands, if the sequence decides when the successor starts.
    ///
    /// A finish without a lag that lies outside the successor's working time is moved to where that goes on. After a finish with a lag
    /// that is not negative, and a start without a lag, the finish follows from the start.
    ///
    /// # Source
    /// MPXJ's PrimaveraScheduler, which is checked against files that P6 computed.
    fn held_finish_s(&self, sequence: &SequenceRecord, predecessor: TaskDates) -> Option<i64> {
        let (from_start, to_start) = ends(sequence);
        if sequence.flags & sequence_flags::PRIMAVERA == 0 || to_start {
            return None;
        }
        let (lag_s, _) = self.lag(sequence, predecessor)?;
        let bound_s = self.end_bound_s(sequence, predecessor)?;
        match (from_start, lag_s.signum()) {
            (false, 0) => {
                let own = self.clock(sequence.successor as usize);
                let works = |s: i64| own.next_working(s) == Some(s);
                if works(bound_s) || works(bound_s - 1) { Some(bound_s) } else { own.next_working(bound_s) }
            }
            (false, 1) | (true, 0) => None,
            _ => Some(bound_s),
        }
    }

    /// The earliest start of a task of this duration that a sequence allows; `None` if it cannot be worked out.
    fn bound_s(&self, sequence: &SequenceRecord, predecessor: TaskDates, duration_s: i64) -> Option<i64> {
        let bound = self.end_bound_s(sequence, predecessor)?;
        let own = self.clock(sequence.successor as usize);
        if ends(sequence).1 { Some(bound) } else { own.add(bound, -duration_s) }
    }
}

/// A task, what it is nested in, and so on up.
pub(crate) fn with_ancestors<'s>(site: &Site<'s>, task: usize) -> impl Iterator<Item = usize> + use<'s> {
    let tasks = site.schedule.tasks;
    let parent = move |at: &usize| Some(tasks[*at].parent).filter(|p| *p != NONE).map(|p| p as usize);
    // No task is its own ancestor; the count guards against an archive that says otherwise.
    std::iter::successors(Some(task), parent).take(tasks.len())
}

/// Whether a sequence hangs on the predecessor's start, and whether it bounds the successor's start.
pub(crate) fn ends(sequence: &SequenceRecord) -> (bool, bool) {
    match sequence.kind.get() {
        SequenceKind::StartStart => (true, true),
        SequenceKind::StartFinish => (true, false),
        SequenceKind::FinishFinish => (false, false),
        SequenceKind::FinishStart => (false, true),
    }
}
