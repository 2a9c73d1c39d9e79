//! The network of tasks, prepared for many forward passes with drawn durations.

use super::three_point::{TaskStream, ThreePoint};
use super::uncertainty::Uncertainty;
use crate::clock::Clock;
use crate::tasks::{
    Limits, SpanBounds, SpanLink, TaskDates, Tasks, WorkStarts, decides, dependencies, ends, sequences_of_spans,
    span_dates, span_links, total_delay_s,
};
use messages::DateSource;

/// A date beyond all working time: what is drawn so long that no calendar holds it never happens.
pub(crate) const NEVER_S: i64 = i64::MAX / 4;

/// What a forward pass goes through, in the order in which dates depend on each other.
pub(crate) struct Network<'t> {
    planned_s: Vec<[i64; 2]>,
    steps: Vec<Step<'t>>,
}

/// A step of the forward pass.
#[expect(clippy::large_enum_variant, reason = "almost all steps are tasks")]
enum Step<'t> {
    Task(UncertainTask<'t>),
    /// A task that spans others.
    Span(Span<'t>),
    /// A summary task and what is nested in it.
    Summary(usize, Vec<u32>),
}

/// A task that may take longer or shorter, or be pushed.
struct UncertainTask<'t> {
    task: usize,
    clock: Clock<'t>,
    planned: TaskDates,
    /// Time between the planned dates on its clock.
    planned_s: i64,
    duration: ThreePoint,
    /// How much of the duration is still ahead: 1 without progress.
    left: f64,
    stream: TaskStream,
    /// It begins no earlier, whatever its predecessors do.
    earliest_s: i64,
    /// It ends no earlier.
    finish_min_s: Option<i64>,
    /// Dates that go before its predecessors.
    limits: Limits,
    incoming: Vec<Bound<'t>>,
}

/// A span, and what it spans.
struct Span<'t> {
    task: usize,
    planned_s: [i64; 2],
    has_begun: bool,
    links: Vec<SpanLink<'t>>,
    /// What these demand as planned.
    before: SpanBounds,
}

/// What a predecessor demands of the start of its successor.
struct Bound<'t> {
    predecessor: usize,
    from_start: bool,
    to_start: bool,
    lag_s: i64,
    lag_clock: Clock<'t>,
    /// How much earlier than the plan allows the planned start is; it stays so.
    lead_s: i64,
}

impl<'t> Network<'t> {
    /// Prepares the tasks that have dates; those that are finished are not among the steps.
    pub(crate) fn of(
        tasks: &'t Tasks<'_>,
        dates: &[Option<TaskDates>],
        delay_s: &[i64],
        starts: &WorkStarts,
        rules: &Uncertainty,
    ) -> Self {
        let site = tasks.site;
        let mut incoming = vec![Vec::new(); dates.len()];
        for sequence in site.schedule.sequences.iter().filter(|s| decides(site, s)) {
            incoming[sequence.successor as usize].push(sequence);
        }
        let of_spans = sequences_of_spans(site);
        let mut steps = Vec::new();
        for (group, is_cycle) in dependencies(site).groups() {
            let members = || group.iter().map(|k| *k as usize);
            for k in members().filter(|k| !tasks.is_summary(*k)) {
                let Some(planned) = dates[k].filter(|_| tasks.task_times[k].actual_finish.is_none()) else { continue };
                if tasks.task_times[k].is_span && !is_cycle {
                    steps.push(Step::Span(Span::of(tasks, k, planned, &of_spans[k], dates)));
                    continue;
                }
                let mut task = UncertainTask::of(tasks, k, planned, rules);
                // Work that has begun is not pushed, nor what is scheduled by hand, and in a cycle there is no order for it.
                if tasks.task_times[k].actual_start.is_none() && !is_cycle && !tasks.is_manual(k) {
                    let bound = |s: &&messages::SequenceRecord| task.bound(tasks, s, dates[s.predecessor as usize]?);
                    task.incoming = incoming[k].iter().filter_map(bound).collect();
                    let is_computed = planned.source == DateSource::Computed && total_delay_s(tasks, delay_s, k) == 0;
                    if is_computed && !task.incoming.is_empty() {
                        task.free_start(starts.of_task(site, k));
                    }
                }
                steps.push(Step::Task(task));
            }
            for k in members().filter(|k| tasks.is_summary(*k) && dates[*k].is_some()) {
                let nested = tasks.children[k].iter().copied().filter(|c| dates[*c as usize].is_some());
                steps.push(Step::Summary(k, nested.collect()));
            }
        }
        let planned_s = dates.iter().map(|d| d.map_or([NEVER_S; 2], |d| [d.start_s, d.finish_s])).collect();
        Self { planned_s, steps }
    }

    /// Start and finish of every task in one run; [`NEVER_S`] for tasks without dates.
    pub(crate) fn run(&self, run: u32, dates_s: &mut Vec<[i64; 2]>) {
        dates_s.clone_from(&self.planned_s);
        for step in &self.steps {
            match step {
                Step::Task(task) => dates_s[task.task] = task.dates_s(run, dates_s),
                Step::Span(span) => dates_s[span.task] = span.dates_s(dates_s),
                Step::Summary(summary, nested) => {
                    let nested = || nested.iter().map(|c| dates_s[*c as usize]);
                    let span = nested().map(|d| d[0]).min().zip(nested().map(|d| d[1]).max());
                    if let Some((start_s, finish_s)) = span {
                        dates_s[*summary] = [start_s, finish_s];
                    }
                }
            }
        }
    }

    /// The first planned instant.
    pub(crate) fn begins_s(&self) -> Option<i64> {
        self.planned_s.iter().map(|d| d[0]).filter(|s| *s < NEVER_S).min()
    }
}

impl<'t> Span<'t> {
    fn of(
        tasks: &'t Tasks<'_>,
        task: usize,
        planned: TaskDates,
        sequences: &[&messages::SequenceRecord],
        dates: &[Option<TaskDates>],
    ) -> Self {
        let planned_s = [planned.start_s, planned.finish_s];
        let has_begun = tasks.task_times[task].actual_start.is_some();
        let links = span_links(tasks, task, sequences, dates);
        let before = SpanBounds::of(&links, |k| dates[k].map(|d| [d.start_s, d.finish_s]));
        Self { task, planned_s, has_begun, links, before }
    }

    fn dates_s(&self, dates_s: &[[i64; 2]]) -> [i64; 2] {
        let drawn_s = |k: usize| Some(dates_s[k]).filter(|d| d[1] < NEVER_S);
        let [start_s, finish_s] = span_dates(self.planned_s, self.before, SpanBounds::of(&self.links, drawn_s));
        if self.has_begun { [self.planned_s[0], finish_s] } else { [start_s, finish_s] }
    }
}

impl<'t> UncertainTask<'t> {
    fn of(tasks: &'t Tasks<'_>, task: usize, planned: TaskDates, rules: &Uncertainty) -> Self {
        let record = &tasks.site.schedule.tasks[task];
        let uncertainties = tasks.site.schedule.uncertainties;
        let found = uncertainties.binary_search_by_key(&(task as u32), |u| u.task).ok().map(|k| &uncertainties[k]);
        let own = tasks.clock(task);
        let works = |clock: Clock<'_>| clock.between(planned.start_s, planned.finish_s) > 0;
        // A task between whose dates its calendar has no work lasts on the clock.
        let is_elapsed = found.is_some_and(|u| u.is_elapsed == 1);
        let clock = if is_elapsed || !works(own) { Clock::Elapsed } else { own };
        let planned_s = clock.between(planned.start_s, planned.finish_s);
        let duration = match found {
            // A milestone stays one.
            Some(u) if planned_s > 0 => ThreePoint {
                optimistic_s: u.duration_optimistic_s as f64,
                likely_s: u.duration_likely_s as f64,
                pessimistic_s: u.duration_pessimistic_s as f64,
            },
            _ => ThreePoint {
                optimistic_s: planned_s as f64 * rules.optimistic,
                likely_s: planned_s as f64,
                pessimistic_s: planned_s as f64 * rules.pessimistic,
            },
        };
        let done = Some(record.completion).filter(|c| (0.0..=1.0).contains(c)).unwrap_or(0.0);
        Self {
            task,
            clock,
            planned,
            planned_s,
            duration,
            left: 1.0 - done,
            stream: TaskStream::new(rules.seed, task),
            earliest_s: planned.start_s,
            finish_min_s: None,
            limits: tasks.limits[task],
            incoming: Vec::new(),
        }
    }

    /// Lets a computed task begin as early as its work schedule and its constraints allow.
    fn free_start(&mut self, schedule_s: Option<i64>) {
        let is_bound = self.limits.is_late || self.limits.firm_start_s(self.planned_s, self.clock).is_some();
        if !is_bound {
            let [start_min_s, finish_min_s] = self.limits.min_s;
            self.earliest_s = schedule_s.into_iter().chain(start_min_s).max().unwrap_or(i64::MIN);
            self.finish_min_s = finish_min_s;
        }
    }

    /// What a sequence demands; `None` if its lag cannot be worked out, which is a diagnostic of the schedule.
    fn bound(
        &self,
        tasks: &'t Tasks<'_>,
        sequence: &messages::SequenceRecord,
        planned: TaskDates,
    ) -> Option<Bound<'t>> {
        let mut bound = Bound::of(tasks, sequence, planned)?;
        let planned_bound_s = bound.start_s([planned.start_s, planned.finish_s], self.clock, self.planned_s);
        bound.lead_s = planned_bound_s.saturating_sub(self.planned.start_s).max(0);
        Some(bound)
    }

    fn dates_s(&self, run: u32, dates_s: &[[i64; 2]]) -> [i64; 2] {
        let drawn_s = self.duration.quantile_s(self.stream.of_run(run));
        let duration_s = (self.planned_s as f64 * (1.0 - self.left) + drawn_s * self.left).round() as i64;
        let bounds_s =
            self.incoming.iter().map(|b| b.start_s(dates_s[b.predecessor], self.clock, duration_s) - b.lead_s);
        let by_finish_s = self.finish_min_s.map(|s| add(self.clock, s, -duration_s)).filter(|s| *s < NEVER_S);
        let mut start_s = bounds_s.chain(by_finish_s).fold(self.earliest_s, i64::max);
        if let Some(firm_s) = self.limits.firm_start_s(duration_s, self.clock) {
            start_s = start_s.min(firm_s.max(self.planned.start_s));
        }
        if start_s == self.planned.start_s && duration_s == self.planned_s {
            return [start_s, self.planned.finish_s];
        }
        if start_s != self.planned.start_s && duration_s > 0 {
            start_s = self.clock.next_working(start_s).unwrap_or(NEVER_S);
        }
        // Starts that meet again where work goes on have the planned finish, too.
        if start_s == self.planned.start_s && duration_s == self.planned_s {
            return [start_s, self.planned.finish_s];
        }
        [start_s, add(self.clock, start_s, duration_s)]
    }
}

impl<'t> Bound<'t> {
    /// Of a sequence, without a lead; `None` if its lag cannot be worked out.
    fn of(tasks: &'t Tasks<'_>, sequence: &messages::SequenceRecord, predecessor: TaskDates) -> Option<Self> {
        let (from_start, to_start) = ends(sequence);
        let (lag_s, lag_clock) = tasks.lag(sequence, predecessor)?;
        Some(Self { predecessor: sequence.predecessor as usize, from_start, to_start, lag_s, lag_clock, lead_s: 0 })
    }

    /// The instant from which it lets an end of its successor be.
    fn end_s(&self, predecessor_s: [i64; 2]) -> i64 {
        let base_s = if self.from_start { predecessor_s[0] } else { predecessor_s[1] };
        add(self.lag_clock, base_s, self.lag_s)
    }

    /// The earliest start of a successor of this duration.
    fn start_s(&self, predecessor_s: [i64; 2], own: Clock<'_>, duration_s: i64) -> i64 {
        let bound_s = self.end_s(predecessor_s);
        if self.to_start { bound_s } else { add(own, bound_s, -duration_s) }
    }
}

fn add(clock: Clock<'_>, t_s: i64, duration_s: i64) -> i64 {
    if t_s >= NEVER_S { NEVER_S } else { clock.add(t_s, duration_s).unwrap_or(NEVER_S) }
}
