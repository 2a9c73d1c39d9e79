//! By how much a task can slip: the backward pass.
//!
//! # Source
//! Kelley and Walker, "Critical-Path Planning and Scheduling", 1959.

use super::graph::{dependencies, is_span};
use super::span::{SpanBounds, sequences_of_spans, span_links};
use super::{TaskDates, Tasks, ends, with_ancestors};
use messages::{SequenceRecord, Site};

/// Float of a task in seconds of its own clock. Negative: its successors begin before it allows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Floats {
    /// Slip that does not move the end of the schedule.
    pub total_s: i64,
    /// Slip that does not move any successor.
    pub free_s: i64,
}

/// Floats of all tasks with dates that are no summaries and do not wait for themselves; the schedule ends with its last task.
pub(crate) fn floats(tasks: &Tasks<'_>, dates: &[Option<TaskDates>]) -> Vec<Option<Floats>> {
    let site = tasks.site;
    let mut floats = vec![None; site.schedule.tasks.len()];
    let Some(end_s) = dates.iter().flatten().map(|d| d.finish_s).max() else { return floats };
    let outgoing = outgoing(site);
    // Latest start and finish, by task.
    let mut late: Vec<Option<[i64; 2]>> = vec![None; site.schedule.tasks.len()];
    for (group, is_cycle) in dependencies(site).groups().rev() {
        let k = group[0] as usize;
        let is_span = tasks.task_times[k].is_span;
        let Some(own) = dates[k].filter(|_| !is_cycle && !is_span) else { continue };
        let clock = tasks.clock(k);
        let duration_s = clock.between(own.start_s, own.finish_s);
        let free_s = free_float_s(tasks, &outgoing, dates, k, end_s);
        let mut late_finish_s = end_s;
        for (sequence, is_own) in sequences_behind(tasks, &outgoing, k) {
            let (from_start, to_start) = ends(sequence);
            let successor = sequence.successor as usize;
            let (Some(_), Some(next_late)) = (dates[successor], late[successor]) else { continue };
            // What hangs on the start of a summary hangs on its first task alone.
            if from_start && !is_own {
                continue;
            }
            let Some((lag_s, lag_clock)) = tasks.lag(sequence, own) else { continue };
            let before = |s: i64| lag_clock.add(s, -lag_s).unwrap_or(s);
            let limit_s = before(if to_start { next_late[0] } else { next_late[1] });
            let finish_limit_s = if from_start { clock.add(limit_s, duration_s).unwrap_or(limit_s) } else { limit_s };
            late_finish_s = late_finish_s.min(finish_limit_s);
        }
        if !tasks.is_summary(k) && !tasks.has_begun(k) {
            late_finish_s = tasks.limits[k].late_finish_s(late_finish_s, duration_s, clock);
        }
        let late_start_s = clock.add(late_finish_s, -duration_s).unwrap_or(late_finish_s);
        late[k] = Some([late_start_s, late_finish_s]);
        if !tasks.is_summary(k) {
            floats[k] = Some(Floats { total_s: clock.between(own.finish_s, late_finish_s), free_s });
        }
    }
    floats_of_spans(tasks, dates, &late, &outgoing, end_s, &mut floats);
    floats
}

/// A span can end as late as what it spans.
fn floats_of_spans(
    tasks: &Tasks<'_>,
    dates: &[Option<TaskDates>],
    late_s: &[Option<[i64; 2]>],
    outgoing: &[Vec<&SequenceRecord>],
    end_s: i64,
    floats: &mut [Option<Floats>],
) {
    let of_spans = sequences_of_spans(tasks.site);
    for k in (0..dates.len()).filter(|k| tasks.task_times[*k].is_span) {
        let Some(own) = dates[k] else { continue };
        let clock = tasks.clock(k);
        let bounds = SpanBounds::of(&span_links(tasks, k, &of_spans[k], dates), |task| late_s[task]);
        let late_finish_s = bounds.finish_s.unwrap_or(end_s).min(end_s);
        let free_s = free_float_s(tasks, outgoing, dates, k, end_s);
        floats[k] = Some(Floats { total_s: clock.between(own.finish_s, late_finish_s), free_s });
    }
}

/// Sequences by predecessor, without those to spans, which follow whatever they span.
pub(super) fn outgoing<'s>(site: &Site<'s>) -> Vec<Vec<&'s SequenceRecord>> {
    let mut outgoing = vec![Vec::new(); site.schedule.tasks.len()];
    for sequence in site.schedule.sequences.iter().filter(|s| !is_span(site, s.successor)) {
        outgoing[sequence.predecessor as usize].push(sequence);
    }
    outgoing
}

/// Slip of a task with dates that moves no successor, nor the end of the schedule, in seconds of its own clock.
pub(super) fn free_float_s(
    tasks: &Tasks<'_>,
    outgoing: &[Vec<&SequenceRecord>],
    dates: &[Option<TaskDates>],
    k: usize,
    end_s: i64,
) -> i64 {
    let Some(own) = dates[k] else { return 0 };
    let clock = tasks.clock(k);
    let slip_s = |(sequence, is_own): (&SequenceRecord, bool)| {
        let (from_start, to_start) = ends(sequence);
        // What hangs on the start of a summary hangs on its first task alone.
        let next = dates[sequence.successor as usize].filter(|_| is_own || !from_start)?;
        let (lag_s, lag_clock) = tasks.lag(sequence, own)?;
        let next_s = if to_start { next.start_s } else { next.finish_s };
        let limit_s = lag_clock.add(next_s, -lag_s).unwrap_or(next_s);
        Some(clock.between(if from_start { own.start_s } else { own.finish_s }, limit_s))
    };
    let behind = sequences_behind(tasks, outgoing, k).into_iter().filter_map(slip_s);
    behind.fold(clock.between(own.finish_s, end_s), i64::min)
}

/// Sequences behind a task and behind what it is nested in, and whether they are its own.
fn sequences_behind<'s>(
    tasks: &Tasks<'_>,
    outgoing: &[Vec<&'s SequenceRecord>],
    k: usize,
) -> Vec<(&'s SequenceRecord, bool)> {
    let of = |at: usize| outgoing[at].iter().map(move |s| (*s, at == k));
    with_ancestors(tasks.site, k).flat_map(of).collect()
}
