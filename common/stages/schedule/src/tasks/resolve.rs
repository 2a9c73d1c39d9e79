//! Dates of tasks: as written, rolled up, inherited, or computed by the forward pass.
//!
//! # Source
//! Kelley and Walker, "Critical-Path Planning and Scheduling", 1959; precedence diagrams with lags after Fondahl, 1961.

use super::floats::{free_float_s, outgoing};
use super::graph::{Order, decides, dependencies, edges, label, nesting};
use super::read_date::read_date;
use super::span::{SpanBounds, sequences_of_spans, span_links};
use super::task_times::inherited;
use super::{TaskDates, TaskTimes, Tasks, ends, with_ancestors};
use crate::diagnostics::{Entity, ScheduleDiagnostics};
use messages::{DateSource, DiagnosticCode, NONE, ScheduleDateKind, SequenceRecord, Severity, Site};

/// Task names in a diagnostic about a cycle.
const MAX_NAMES: usize = 8;

/// Dates or duration that a task has in the file.
enum Written {
    Dates(TaskDates),
    /// A duration without dates, which are to be computed.
    Duration(i64),
    /// Neither, with the reason.
    Nothing(&'static str),
}

/// Computes the dates of all tasks; `None` for tasks without.
pub(crate) fn resolve(tasks: &Tasks<'_>, diagnostics: &mut ScheduleDiagnostics<'_>) -> Vec<Option<TaskDates>> {
    let mut pass = Pass::new(tasks, diagnostics);
    pass.report_cycles();
    let order = pass.order();
    for (group, is_cycle) in order.groups() {
        if is_cycle {
            pass.in_cycle(group);
        } else {
            pass.task(group[0] as usize);
        }
    }
    pass.move_late(&order);
    pass.inherit();
    pass.report_undated();
    pass.dates
}

/// The sequences that let a task start last.
#[derive(Clone, Copy)]
struct Driving {
    /// The latest start that they ask for.
    bound_s: i64,
    /// Where work goes on from there.
    working_s: i64,
    /// The finish that stands by the first of them.
    finish_s: Option<i64>,
}

struct Pass<'t, 'a, 'f, 's> {
    tasks: &'t Tasks<'a>,
    diagnostics: &'f mut ScheduleDiagnostics<'s>,
    written: Vec<Written>,
    /// Sequences by successor, without those behind spans.
    incoming: Vec<Vec<u32>>,
    /// Sequences by the span that they bound.
    of_spans: Vec<Vec<&'a SequenceRecord>>,
    starts: WorkStarts,
    dates: Vec<Option<TaskDates>>,
    /// Why a task has no dates.
    why: Vec<Option<String>>,
}

impl<'t, 'a, 'f, 's> Pass<'t, 'a, 'f, 's> {
    fn new(tasks: &'t Tasks<'a>, diagnostics: &'f mut ScheduleDiagnostics<'s>) -> Self {
        let site = tasks.site;
        let n = site.schedule.tasks.len();
        let mut incoming = vec![Vec::new(); n];
        for (k, sequence) in (0..).zip(site.schedule.sequences).filter(|(_, s)| decides(site, s)) {
            incoming[sequence.successor as usize].push(k);
        }
        let starts = WorkStarts::of(site, tasks, diagnostics);
        let written = (0..n).map(|k| written(tasks, k)).collect();
        let of_spans = sequences_of_spans(site);
        Self { tasks, diagnostics, written, incoming, of_spans, starts, dates: vec![None; n], why: vec![None; n] }
    }

    /// Summary tasks depend on what is nested in them, computed ones on their predecessors, spans on what they span.
    fn order(&self) -> Order {
        let site = self.tasks.site;
        let edges = edges(site).filter(|(k, _)| self.is_computed(*k as usize));
        Order::of(site.schedule.tasks.len(), nesting(site).chain(edges))
    }

    /// Its dates are not written.
    fn is_computed(&self, k: usize) -> bool {
        let is_span = self.tasks.task_times[k].is_span;
        !self.tasks.is_summary(k)
            && match self.written[k] {
                Written::Duration(_) => true,
                Written::Nothing(_) => is_span,
                Written::Dates(_) => false,
            }
    }

    /// Names the tasks of every cycle, also of those whose written dates stand.
    fn report_cycles(&mut self) {
        let site = self.tasks.site;
        let order = dependencies(site);
        let mut cycles: Vec<&[u32]> =
            order.groups().filter(|(_, is_cycle)| *is_cycle).map(|(group, _)| group).collect();
        cycles.sort_unstable();
        for group in cycles {
            let names: Vec<String> = group.iter().take(MAX_NAMES).map(|k| label(site, *k as usize)).collect();
            let more = group.len().saturating_sub(MAX_NAMES);
            let more = if more > 0 { format!(" and {more} more") } else { String::new() };
            let message = format!(
                "tasks wait for each other in a circle: {}{more}; written dates stand, none are computed",
                names.join(", ")
            );
            let first = &site.schedule.tasks[group[0] as usize];
            self.diagnostics.add(Severity::Error, DiagnosticCode::TaskCycle, Some(Entity::task(first)), message);
        }
    }

    /// Dates of tasks that wait for each other: written ones stand, summaries follow what is nested in them.
    fn in_cycle(&mut self, group: &[u32]) {
        let mut group: Vec<usize> = group.iter().map(|k| *k as usize).collect();
        // Deeper ones first, so that a summary finds what is nested in it.
        group.sort_by_key(|k| std::cmp::Reverse(depth(self.tasks.site, *k)));
        for k in group {
            if !self.is_computed(k) {
                self.task(k);
            } else {
                self.why[k] = Some("it waits for itself".to_owned());
            }
        }
    }

    fn task(&mut self, k: usize) {
        let nested: Vec<TaskDates> = self.tasks.children[k].iter().filter_map(|c| self.dates[*c as usize]).collect();
        let found = match &self.written[k] {
            _ if self.tasks.task_times[k].is_faulty && nested.is_empty() => Err(None),
            _ if !nested.is_empty() => Ok(roll_up(&nested)),
            Written::Dates(dates) => Ok(*dates),
            Written::Duration(_) | Written::Nothing(_) if self.tasks.is_summary(k) => {
                Err(Some("no task nested in it has any".to_owned()))
            }
            _ if self.tasks.task_times[k].is_span => self.span(k).map_err(Some),
            Written::Duration(duration_s) => self.compute(k, *duration_s).map_err(Some),
            Written::Nothing(why) => Err(Some((*why).to_owned())),
        };
        match found {
            Ok(dates) if dates.finish_s < dates.start_s => {
                let text = |s: i64| messages::plan_time(s).map(|t| t.to_string()).unwrap_or_default();
                let message = format!(
                    "the task finishes {} before it starts {}; it is ignored",
                    text(dates.finish_s),
                    text(dates.start_s)
                );
                self.diagnostics.add(
                    Severity::Error,
                    DiagnosticCode::TaskReversed,
                    Some(Entity::task(&self.tasks.site.schedule.tasks[k])),
                    message,
                );
            }
            Ok(dates) => self.dates[k] = Some(dates),
            Err(why) => self.why[k] = why,
        }
    }

    /// From the first start to the last finish of what a span without dates is linked with, or of what stands beside a WBS summary.
    fn span(&self, k: usize) -> Result<TaskDates, String> {
        let links = span_links(self.tasks, k, &self.of_spans[k], &self.dates);
        let ends_s = |task: usize| self.dates[task].map(|dates| [dates.start_s, dates.finish_s]);
        let bounds = SpanBounds::of(&links, ends_s);
        let clock = self.tasks.clock(k);
        let first_s = || clock.next_working(self.starts.of_task(self.tasks.site, k)?);
        let start_s = bounds.start_s.or_else(first_s).ok_or("no task that it spans has any")?;
        let finish_s = bounds.finish_s.map_or(start_s, |finish_s| finish_s.max(start_s));
        Ok(TaskDates { start_s, finish_s, source: DateSource::Computed })
    }

    /// The forward pass for one task: the earliest start that schedule and predecessors allow.
    fn compute(&self, k: usize, duration_s: i64) -> Result<TaskDates, String> {
        let clock = self.tasks.clock(k);
        let schedule_s = self.starts.of_task(self.tasks.site, k);
        let driving = self.driving(k, duration_s, schedule_s)?;
        let start_s = driving.map(|driving| driving.bound_s).into_iter().chain(schedule_s).max();
        let start_s = self.tasks.limits[k].start_s(start_s, duration_s, clock);
        let start_s = start_s.ok_or("neither its work schedule nor a predecessor says when it can start")?;
        let ended = "its calendar has no working time left";
        let start_s = if duration_s == 0 { Some(start_s) } else { clock.next_working(start_s) }.ok_or(ended)?;
        let finish_s = clock.add(start_s, duration_s).ok_or(ended)?;
        let driving = driving.filter(|driving| driving.working_s == start_s && duration_s > 0);
        let finish_s = driving.and_then(|driving| driving.finish_s).unwrap_or(finish_s);
        // Nothing is expected of an instant, nor of a finish that a predecessor asks for.
        let sequences = self.tasks.site.schedule.sequences;
        let is_open = duration_s > 0 && self.incoming[k].iter().all(|s| ends(&sequences[*s as usize]).1);
        let expected_s = self.tasks.limits[k].expected_finish_s(start_s).filter(|_| is_open);
        let finish_s = expected_s.unwrap_or_else(|| self.tasks.limits[k].finish_s(start_s, finish_s));
        Ok(TaskDates { start_s, finish_s, source: DateSource::Computed })
    }

    /// Of the sequences before a task of this duration, those that let it start last; `None` if there are none.
    fn driving(&self, k: usize, duration_s: i64, schedule_s: Option<i64>) -> Result<Option<Driving>, String> {
        let site = self.tasks.site;
        let clock = self.tasks.clock(k);
        let mut driving: Option<Driving> = None;
        for &sequence in &self.incoming[k] {
            let sequence = &site.schedule.sequences[sequence as usize];
            let predecessor = sequence.predecessor as usize;
            let dates = self.dates[predecessor]
                .ok_or_else(|| format!("its predecessor {} has no dates", label(site, predecessor)))?;
            let bound_s = self
                .tasks
                .bound_s(sequence, dates, duration_s)
                .ok_or_else(|| format!("the lag behind {} cannot be worked out", label(site, predecessor)))?;
            let working_s = clock.next_working(bound_s).unwrap_or(bound_s);
            match &mut driving {
                Some(last) if working_s < last.working_s => {}
                Some(last) if working_s == last.working_s => {
                    last.bound_s = last.bound_s.max(bound_s);
                }
                _ => {
                    let is_early = schedule_s.is_some_and(|s| bound_s < s);
                    let finish_s = self.tasks.held_finish_s(sequence, dates).filter(|_| !is_early);
                    driving = Some(Driving { bound_s, working_s, finish_s });
                }
            }
        }
        Ok(driving)
    }

    /// Computed tasks that are to be as late as possible use up their free float, the last of them first.
    fn move_late(&mut self, order: &Order) {
        let tasks = self.tasks;
        let is_late = |k: usize| tasks.limits[k].is_late && !tasks.is_summary(k);
        let end_s = self.dates.iter().flatten().map(|d| d.finish_s).max();
        let Some(end_s) = end_s.filter(|_| (0..self.dates.len()).any(is_late)) else { return };
        let outgoing = outgoing(tasks.site);
        for k in order.groups().rev().filter(|(_, is_cycle)| !is_cycle).map(|(group, _)| group[0] as usize) {
            let (Some(own), Written::Duration(duration_s)) = (self.dates[k], &self.written[k]) else { continue };
            let clock = tasks.clock(k);
            let free_s = free_float_s(tasks, &outgoing, &self.dates, k, end_s);
            if !is_late(k) || free_s <= 0 {
                continue;
            }
            let Some(finish_s) = clock.add(own.finish_s, free_s) else { continue };
            let finish_s = tasks.limits[k].late_finish_s(finish_s, *duration_s, clock).max(own.finish_s);
            if let Some(start_s) = clock.add(finish_s, -duration_s) {
                self.dates[k] = Some(TaskDates { start_s, finish_s, ..own });
            }
        }
        for (group, _) in order.groups() {
            for k in group.iter().map(|k| *k as usize) {
                let nested: Vec<TaskDates> = tasks.children[k].iter().filter_map(|c| self.dates[*c as usize]).collect();
                if !nested.is_empty() {
                    self.dates[k] = Some(roll_up(&nested));
                } else if tasks.task_times[k].is_span && self.is_computed(k) {
                    self.dates[k] = self.span(k).ok();
                }
            }
        }
    }

    /// A task that says nothing of time and hangs in no sequence takes the written dates of its nearest ancestor.
    fn inherit(&mut self) {
        let site = self.tasks.site;
        let mut in_sequence = vec![false; site.schedule.tasks.len()];
        for sequence in site.schedule.sequences {
            in_sequence[sequence.predecessor as usize] = true;
            in_sequence[sequence.successor as usize] = true;
        }
        for (k, in_sequence) in in_sequence.into_iter().enumerate() {
            if self.dates[k].is_some() || self.tasks.task_times[k].has_time || self.tasks.is_summary(k) || in_sequence {
                continue;
            }
            let written = |at: usize| match self.written[at] {
                Written::Dates(dates) => Some(dates),
                _ => None,
            };
            let nearest = with_ancestors(site, k).skip(1).find_map(written);
            self.dates[k] = nearest.filter(|d| d.start_s <= d.finish_s);
        }
    }

    fn report_undated(&mut self) {
        for k in 0..self.dates.len() {
            let task = &self.tasks.site.schedule.tasks[k];
            if let (None, Some(why)) = (self.dates[k], &self.why[k]) {
                let message = format!("the task has no dates: {why}; it has no effect");
                self.diagnostics.add(Severity::Warning, DiagnosticCode::TaskUndated, Some(Entity::task(task)), message);
            }
            // Dates of a summary that differ from what is nested in it.
            if let (true, Some(dates), Written::Dates(own)) =
                (self.tasks.is_summary(k), self.dates[k], &self.written[k])
                && (own.start_s, own.finish_s) != (dates.start_s, dates.finish_s)
            {
                let message = "its own dates differ from those of the tasks nested in it, which count".to_owned();
                self.diagnostics.add(
                    Severity::Warning,
                    DiagnosticCode::SummaryDatesDiffer,
                    Some(Entity::task(task)),
                    message,
                );
            }
        }
    }
}

/// From the first start to the last finish of nested tasks, as trustworthy as the least of them.
pub(super) fn roll_up(nested: &[TaskDates]) -> TaskDates {
    let least = "a summary has a nested task";
    TaskDates {
        start_s: nested.iter().map(|d| d.start_s).min().expect(least),
        finish_s: nested.iter().map(|d| d.finish_s).max().expect(least),
        source: nested.iter().map(|d| d.source).max().expect(least),
    }
}

fn depth(site: &Site<'_>, task: usize) -> usize {
    with_ancestors(site, task).skip(1).count()
}

/// When work schedules begin, by control.
pub(crate) struct WorkStarts {
    starts_s: Vec<Option<i64>>,
}

impl WorkStarts {
    /// Reads the starts of all work schedules that have tasks.
    pub(crate) fn of(site: &Site<'_>, tasks: &Tasks<'_>, diagnostics: &mut ScheduleDiagnostics<'_>) -> Self {
        Self { starts_s: start_times(site, tasks, diagnostics) }
    }

    /// StartTime of the work schedule that controls the task, or of the first that has tasks.
    pub(crate) fn of_task(&self, site: &Site<'_>, k: usize) -> Option<i64> {
        let own = inherited(site, k, |t| (t.control != NONE).then_some(t.control as usize));
        let of_own = own.and_then(|control| self.starts_s[control]);
        let first = || {
            let source = site.schedule.tasks[k].source;
            let same_file = |c: &&usize| site.schedule.work_controls[**c].source == source;
            let used: Vec<usize> = (0..self.starts_s.len()).filter(|c| self.starts_s[*c].is_some()).collect();
            used.iter().find(same_file).or(used.first()).and_then(|c| self.starts_s[*c])
        };
        of_own.or_else(first)
    }
}

fn start_times(site: &Site<'_>, tasks: &Tasks<'_>, diagnostics: &mut ScheduleDiagnostics<'_>) -> Vec<Option<i64>> {
    let mut used = vec![false; site.schedule.work_controls.len()];
    for task in site.schedule.tasks.iter().filter(|t| t.control != NONE) {
        used[task.control as usize] = true;
    }
    let times = site.schedule.work_controls.iter().enumerate().zip(used).map(|((k, control), used)| {
        let entity = Entity::of_schedule(control.global_id, control.name, control.step_id, control.source);
        if !used && control.is_plan == 0 {
            let message = "the work schedule has no task".to_owned();
            diagnostics.add(Severity::Warning, DiagnosticCode::ScheduleEmpty, Some(entity), message);
        }
        let start = site.schedule.date(ScheduleDateKind::WorkStart, k).filter(|_| used)?;
        match read_date(start, tasks.rules) {
            Ok(date) => Some(date.start_s()),
            Err(why) => {
                diagnostics.add(
                    Severity::Error,
                    DiagnosticCode::ScheduleStartUnreadable,
                    Some(entity),
                    format!("StartTime: {why}"),
                );
                None
            }
        }
    });
    times.collect()
}

/// Dates or duration of a task in the file.
fn written(tasks: &Tasks<'_>, k: usize) -> Written {
    let task_times = &tasks.task_times[k];
    let TaskTimes { start, finish, duration_s, .. } = *task_times;
    let clock = tasks.clock(k);
    let start_s = start.map(|d| d.start_s());
    let finish_s = finish.map(|d| d.finish_s());
    let dates = |start_s, finish_s, source| Written::Dates(TaskDates { start_s, finish_s, source });
    let planned = task_times.planned.unwrap_or(DateSource::Schedule);
    let ended = Written::Nothing("its calendar has no working time left");
    // A milestone with one date has both.
    let duration_s = duration_s.or((task_times.is_milestone && (start.is_some() || finish.is_some())).then_some(0));
    if let Some(actual) = task_times.actual_start {
        let actual_s = actual.start_s();
        if let Some(finish) = task_times.actual_finish {
            return dates(actual_s, finish.finish_s(), DateSource::Actual);
        }
        // The finish of work that goes on is written: no calendar moves it.
        if let Some(finish_s) = finish_s.filter(|f| start_s == Some(actual_s) && actual_s <= *f) {
            return dates(actual_s, finish_s, DateSource::Actual);
        }
        let between = start_s.zip(finish_s).map(|(s, f)| clock.between(s, f));
        let Some(duration_s) = duration_s.or(between) else {
            return Written::Nothing("it has an actual start, but neither a finish nor a duration");
        };
        return clock.add(actual_s, duration_s).map_or(ended, |finish_s| dates(actual_s, finish_s, DateSource::Actual));
    }
    if let Some(actual) = task_times.actual_finish {
        let actual_s = actual.finish_s();
        let by_duration = duration_s.and_then(|d| clock.add(actual_s, -d));
        let start_s = start_s.filter(|s| *s <= actual_s).or(by_duration).unwrap_or(actual_s);
        return dates(start_s, actual_s, DateSource::Actual);
    }
    match (start_s, finish_s, duration_s) {
        (Some(start_s), Some(finish_s), _) => dates(start_s, finish_s, planned),
        (Some(start_s), None, Some(d)) => clock.add(start_s, d).map_or(ended, |f| dates(start_s, f, planned)),
        (None, Some(finish_s), Some(d)) => clock.add(finish_s, -d).map_or(ended, |s| dates(s, finish_s, planned)),
        (None, None, Some(duration_s)) => Written::Duration(duration_s),
        (Some(_), None, None) => Written::Nothing("it has a start, but neither a finish nor a duration"),
        (None, Some(_), None) => Written::Nothing("it has a finish, but neither a start nor a duration"),
        (None, None, None) => Written::Nothing("it has neither dates nor a duration"),
    }
}
