//! Inputs of the schedule computation per task, from the file and from reported progress.

use super::read_date::read_date;
use super::with_ancestors;
use crate::clock::{CalendarWork, Calendars, longest_s};
use crate::diagnostics::{Entity, ScheduleDiagnostics};
use crate::durations::WrittenDuration;
use crate::rules::Rules;
use diagnostics::counted;
use frames::written_date::WrittenDate;
use messages::{
    DateSource, DiagnosticCode, DurationKind, NONE, ScheduleDate, ScheduleDateKind, ScheduleLength, Severity, Site,
    TaskConstraintKind, TaskRecord, task_flags,
};

/// The kind of effect of a task on linked elements.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum TaskKind {
    /// It constructs them.
    Construct,
    /// It removes them.
    Remove,
    /// It brings outputs and removes inputs.
    Carry,
    /// No effect on elements; it still occupies spaces.
    Other,
}

/// Times of one task.
#[derive(Debug, Clone, Default)]
pub(crate) struct TaskTimes {
    pub(crate) actual_start: Option<WrittenDate>,
    pub(crate) actual_finish: Option<WrittenDate>,
    pub(crate) start: Option<WrittenDate>,
    pub(crate) finish: Option<WrittenDate>,
    /// Whether planned dates are scheduled or early ones.
    pub(crate) planned: Option<DateSource>,
    pub(crate) duration_s: Option<i64>,
    /// Its own calendar, or that of its ancestors.
    pub(crate) calendar: Option<usize>,
    /// The calendar in which its duration counts; day and night without one.
    pub(crate) clock: Option<usize>,
    /// Work of resources by their calendars, in the place of `clock`; of most tasks none.
    pub(crate) work: Vec<CalendarWork>,
    pub(crate) is_milestone: bool,
    /// Its dates are those of what it spans.
    pub(crate) is_span: bool,
    /// One of its values cannot be read: the task is ignored.
    pub(crate) is_faulty: bool,
    /// It has any date or duration.
    pub(crate) has_time: bool,
}

/// Dates and duration of a task as the file has them.
#[derive(Debug, Clone, Copy)]
pub(crate) struct WrittenTaskTimes<'a> {
    actual_start: Option<ScheduleDate<'a>>,
    actual_finish: Option<ScheduleDate<'a>>,
    start: Option<ScheduleDate<'a>>,
    finish: Option<ScheduleDate<'a>>,
    duration: Option<ScheduleLength<'a>>,
    planned: DateSource,
}

impl<'a> WrittenTaskTimes<'a> {
    pub(crate) fn of(site: &Site<'a>, task: usize) -> Self {
        use ScheduleDateKind::*;
        let [start, finish] = [ScheduleStart, ScheduleFinish].map(|kind| site.schedule.date(kind, task));
        let early = |kind| site.schedule.date(kind, task);
        Self {
            actual_start: site.schedule.date(ActualStart, task),
            actual_finish: site.schedule.date(ActualFinish, task),
            start: start.or_else(|| early(EarlyStart)),
            finish: finish.or_else(|| early(EarlyFinish)),
            duration: site.schedule.duration(task),
            planned: if start.or(finish).is_some() { DateSource::Schedule } else { DateSource::Early },
        }
    }

    fn dates(&self) -> [Option<ScheduleDate<'a>>; 4] {
        [self.actual_start, self.actual_finish, self.start, self.finish]
    }
}

/// First and last written date of all tasks and work schedules; what cannot be read is left to those who use it.
pub(crate) fn written_span_s(
    site: &Site<'_>,
    rules: &Rules,
    written: &[WrittenTaskTimes<'_>],
) -> Option<std::ops::Range<i64>> {
    let schedule = &site.schedule;
    let of_tasks = written.iter().flat_map(WrittenTaskTimes::dates).flatten();
    let starts = (0..schedule.work_controls.len()).filter_map(|k| schedule.date(ScheduleDateKind::WorkStart, k));
    let finishes = schedule.work_controls.iter().map(|c| schedule.text(c.finish)).filter(|text| !text.is_empty());
    let of_constraints = schedule.constraints.iter().filter(|c| c.kind != TaskConstraintKind::AsLateAsPossible);
    let of_constraints = of_constraints.map(|c| ScheduleDate::Civil(c.date()));
    let dates = of_tasks.chain(starts).chain(finishes.map(ScheduleDate::Text)).chain(of_constraints);
    let mut seconds = dates.filter_map(|date| read_date(date, rules).ok()).map(WrittenDate::start_s);
    let first = seconds.next()?;
    Some(seconds.fold(first..first + 1, |span, s| span.start.min(s)..span.end.max(s + 1)))
}

/// Reads the times of all tasks.
pub(crate) fn task_times(
    site: &Site<'_>,
    rules: &Rules,
    written: &[WrittenTaskTimes<'_>],
    calendars: &Calendars,
    diagnostics: &mut ScheduleDiagnostics<'_>,
) -> Vec<TaskTimes> {
    let mut reader =
        TaskTimeReader { site, rules, calendars, diagnostics, days_of: Vec::new(), without_calendar: Vec::new() };
    let task_times = (0..site.schedule.tasks.len()).map(|k| reader.task(k, &written[k])).collect();
    reader.report_days();
    task_times
}

struct TaskTimeReader<'a, 'f, 's> {
    site: &'a Site<'a>,
    rules: &'a Rules,
    calendars: &'a Calendars,
    diagnostics: &'f mut ScheduleDiagnostics<'s>,
    /// Tasks whose length depends on what a day means.
    days_of: Vec<usize>,
    /// Tasks that count working time without a calendar.
    without_calendar: Vec<usize>,
}

impl TaskTimeReader<'_, '_, '_> {
    fn task(&mut self, index: usize, written: &WrittenTaskTimes<'_>) -> TaskTimes {
        let task = &self.site.schedule.tasks[index];
        let calendar = inherited(self.site, index, |t| (t.calendar != NONE).then_some(t.calendar as usize));
        let elapsed = task.duration_kind == DurationKind::ElapsedTime;
        let clock = calendar.filter(|_| !elapsed);
        let mut task_times = TaskTimes {
            calendar,
            clock,
            is_milestone: task.has(task_flags::MILESTONE),
            is_span: task.has(task_flags::SPAN),
            has_time: written.duration.is_some() || written.dates().iter().any(Option::is_some),
            ..TaskTimes::default()
        };
        let duration = self.read(task, "ScheduleDuration", written.duration, &mut task_times.is_faulty, |length| {
            WrittenDuration::of(length).map_err(|e| e.to_string())
        });
        task_times.work = work_of(self.site, index);
        let by_resources_s = longest_s(&task_times.work);
        task_times.duration_s = by_resources_s.or_else(|| duration.map(|d| self.length_s(index, d, clock)));
        let rules = self.rules;
        let mut date = |what: &str, date: Option<ScheduleDate<'_>>| {
            self.read(task, what, date, &mut task_times.is_faulty, |d| read_date(d, rules).map_err(|e| e.to_string()))
        };
        task_times.actual_start = date("ActualStart", written.actual_start);
        task_times.actual_finish = date("ActualFinish", written.actual_finish);
        task_times.start = date("the planned start", written.start);
        task_times.finish = date("the planned finish", written.finish);
        task_times.planned = task_times.start.or(task_times.finish).map(|_| written.planned);
        self.report_completion(task, &task_times);
        task_times
    }

    /// Reports progress that contradicts the actual finish.
    fn report_completion(&mut self, task: &TaskRecord, task_times: &TaskTimes) {
        let (code, message) = match task_times.actual_finish {
            None if task.completion >= 1.0 => (
                DiagnosticCode::CompletionWithoutFinish,
                "the task is complete, but has no ActualFinish; its planned finish counts",
            ),
            Some(_) if task.completion == 0.0 => (
                DiagnosticCode::FinishWithoutCompletion,
                "the task has an actual finish, but is 0 per cent complete; its actual finish counts",
            ),
            _ => return,
        };
        self.diagnostics.add(Severity::Warning, code, Some(Entity::task(task)), message.to_owned());
    }

    /// Reads a value; one that cannot be read makes the task faulty.
    fn read<W, T>(
        &mut self,
        task: &TaskRecord,
        what: &str,
        written: Option<W>,
        is_faulty: &mut bool,
        read: impl Fn(W) -> Result<T, String>,
    ) -> Option<T> {
        match read(written?) {
            Ok(value) => Some(value),
            Err(why) => {
                *is_faulty = true;
                let message = format!("{what}: {why}; the task is ignored");
                self.diagnostics.add(
                    Severity::Error,
                    DiagnosticCode::TaskDateUnreadable,
                    Some(Entity::task(task)),
                    message,
                );
                None
            }
        }
    }

    fn length_s(&mut self, index: usize, duration: WrittenDuration, clock: Option<usize>) -> i64 {
        let task = &self.site.schedule.tasks[index];
        if duration.counts_days() && clock.is_some() {
            self.days_of.push(index);
        }
        if task.duration_kind == DurationKind::WorkTime && clock.is_none() {
            self.without_calendar.push(index);
        }
        duration.seconds(self.calendars.clock(clock).day())
    }

    /// One diagnostic each for what many tasks have in common.
    fn report_days(&mut self) {
        if let Some(&first) = self.days_of.first() {
            let means = match self.rules.duration_day {
                crate::rules::DurationDay::WorkingDay => "the working hours of a day",
                crate::rules::DurationDay::Hours24 => "24 working hours",
            };
            let message = format!(
                "{} with durations in days; a day means {means} (duration_day)",
                counted(self.days_of.len(), "task")
            );
            let entity = Entity::task(&self.site.schedule.tasks[first]);
            self.diagnostics.add(Severity::Info, DiagnosticCode::DurationInDays, Some(entity), message);
        }
        if let Some(&first) = self.without_calendar.first() {
            let n = self.without_calendar.len();
            let message =
                format!("{} with working time and without a calendar; a day has 24 hours", counted(n, "task"));
            let entity = Entity::task(&self.site.schedule.tasks[first]);
            self.diagnostics.add(Severity::Warning, DiagnosticCode::CalendarMissing, Some(entity), message);
        }
    }
}

/// Work of the resources of a task by their calendars.
fn work_of(site: &Site<'_>, task: usize) -> Vec<CalendarWork> {
    let all = site.schedule.assignments;
    let first = all.partition_point(|a| (a.task as usize) < task);
    let of_task = all[first..].iter().take_while(|a| a.task as usize == task);
    of_task.map(|a| CalendarWork { calendar: a.calendar as usize, duration_s: a.duration_s }).collect()
}

/// What a task does, by its type or that of its nearest ancestor that has one.
pub(crate) fn kind_of(site: &Site<'_>, task: usize) -> TaskKind {
    let own_type =
        |t: &TaskRecord| Some(site.schedule.text(t.predefined_type)).filter(|k| !k.is_empty() && *k != "NOTDEFINED");
    match inherited(site, task, own_type) {
        None | Some("CONSTRUCTION" | "INSTALLATION") => TaskKind::Construct,
        Some("DEMOLITION" | "REMOVAL" | "DISMANTLE" | "DISPOSAL") => TaskKind::Remove,
        Some("MOVE" | "LOGISTIC") => TaskKind::Carry,
        Some(_) => TaskKind::Other,
    }
}

/// The nearest answer of a task and its ancestors.
pub(crate) fn inherited<'s, T>(site: &Site<'s>, task: usize, of: impl Fn(&'s TaskRecord) -> Option<T>) -> Option<T> {
    with_ancestors(site, task).find_map(|at| of(&site.schedule.tasks[at]))
}
