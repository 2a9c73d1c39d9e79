//! Tasks that span others: level of effort and hammocks what they are linked with, WBS summaries what stands beside them.
//!
//! A span decides the dates of no other task: a relationship behind it says when it ends.
//!
//! # Source
//! Oracle Primavera P6 Professional Help, "Activity types"; MPXJ's PrimaveraScheduler.

use super::graph::{decides, is_span};
use super::{TaskDates, Tasks, ends};
use crate::clock::Clock;
use messages::{DateSource, NONE, SequenceRecord, Site, task_flags};

/// What bounds an end of a span: an end of another task, and a lag from there.
#[derive(Clone, Copy)]
pub(crate) struct SpanLink<'t> {
    task: usize,
    from_start: bool,
    to_start: bool,
    lag_s: i64,
    lag_clock: Clock<'t>,
}

impl SpanLink<'_> {
    /// Where the span begins or ends for these dates of the other task.
    fn bound_s(&self, [start_s, finish_s]: [i64; 2]) -> i64 {
        let base_s = if self.from_start { start_s } else { finish_s };
        self.lag_clock.add(base_s, self.lag_s).unwrap_or(base_s)
    }
}

/// The sequences that bound each span, by task; of all other tasks none.
pub(crate) fn sequences_of_spans<'s>(site: &Site<'s>) -> Vec<Vec<&'s SequenceRecord>> {
    let mut of_spans = vec![Vec::new(); site.schedule.tasks.len()];
    for sequence in site.schedule.sequences {
        if is_span(site, sequence.successor) {
            of_spans[sequence.successor as usize].push(sequence);
        } else if !decides(site, sequence) {
            of_spans[sequence.predecessor as usize].push(sequence);
        }
    }
    of_spans
}

/// What bounds a span: its sequences, and for a WBS summary the tasks that are nested in the same task.
pub(crate) fn span_links<'t>(
    tasks: &'t Tasks<'_>,
    k: usize,
    sequences: &[&SequenceRecord],
    dates: &[Option<TaskDates>],
) -> Vec<SpanLink<'t>> {
    let records = tasks.site.schedule.tasks;
    let is_wbs = |task: usize| records[task].has(task_flags::WBS_SUMMARY);
    if is_wbs(k) {
        let beside = Some(records[k].parent).filter(|parent| *parent != NONE);
        let beside = beside.into_iter().flat_map(|parent| &tasks.children[parent as usize]).map(|c| *c as usize);
        let link = |task, is_start| SpanLink {
            task,
            from_start: is_start,
            to_start: is_start,
            lag_s: 0,
            lag_clock: Clock::Elapsed,
        };
        return beside.filter(|c| !is_wbs(*c)).flat_map(|c| [link(c, true), link(c, false)]).collect();
    }
    let link = |sequence: &&SequenceRecord| {
        let (from_start, to_start) = ends(sequence);
        let predecessor = sequence.predecessor as usize;
        // A span without dates has no length that a lag could be a part of.
        let unknown = TaskDates { start_s: 0, finish_s: 0, source: DateSource::Computed };
        let of = dates[predecessor].or((predecessor == k).then_some(unknown))?;
        let (lag_s, lag_clock) = tasks.lag(sequence, of)?;
        Some(if predecessor == k {
            let task = sequence.successor as usize;
            SpanLink { task, from_start: to_start, to_start: from_start, lag_s: -lag_s, lag_clock }
        } else {
            SpanLink { task: predecessor, from_start, to_start, lag_s, lag_clock }
        })
    };
    sequences.iter().filter_map(link).collect()
}

/// What others demand of the ends of a span: it begins with the first and ends with the last of them.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct SpanBounds {
    /// The earliest of what bounds its start.
    pub(crate) start_s: Option<i64>,
    /// The latest of what bounds its finish.
    pub(crate) finish_s: Option<i64>,
}

impl SpanBounds {
    /// The bounds for these dates of the other tasks; those without dates bound nothing.
    pub(crate) fn of(links: &[SpanLink<'_>], dates_s: impl Fn(usize) -> Option<[i64; 2]>) -> Self {
        let mut bounds = Self::default();
        for link in links {
            dates_s(link.task).into_iter().for_each(|dates_s| bounds.add(link.to_start, link.bound_s(dates_s)));
        }
        bounds
    }

    /// Takes in a bound of its start, or of its finish.
    fn add(&mut self, is_start: bool, bound_s: i64) {
        match is_start {
            true => self.start_s = Some(self.start_s.map_or(bound_s, |s| s.min(bound_s))),
            false => self.finish_s = Some(self.finish_s.map_or(bound_s, |s| s.max(bound_s))),
        }
    }
}

/// Start and finish of a span once others have moved: each end follows what bounds it, later only, and keeps the lead that the
/// plan gives it.
pub(crate) fn span_dates(planned_s: [i64; 2], before: SpanBounds, after: SpanBounds) -> [i64; 2] {
    let end = |planned_s: i64, before: Option<i64>, after: Option<i64>| match (before, after) {
        (Some(before_s), Some(after_s)) => {
            planned_s.max(after_s.saturating_sub(before_s.saturating_sub(planned_s).max(0)))
        }
        _ => planned_s,
    };
    let start_s = end(planned_s[0], before.start_s, after.start_s);
    [start_s, end(planned_s[1], before.finish_s, after.finish_s).max(start_s)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_end_follows_its_own_bounds() {
        let bounds = |starts: &[i64], finishes: &[i64]| {
            let mut bounds = SpanBounds::default();
            starts.iter().for_each(|s| bounds.add(true, *s));
            finishes.iter().for_each(|s| bounds.add(false, *s));
            bounds
        };
        let before = bounds(&[10, 30], &[40, 60]);
        assert_eq!(span_dates([10, 60], before, bounds(&[10, 35], &[40, 75])), [10, 75], "the last one ends later");
        assert_eq!(span_dates([10, 60], before, bounds(&[20, 30], &[50, 60])), [20, 60], "the first one begins later");
        assert_eq!(span_dates([10, 70], before, bounds(&[10], &[65])), [10, 70], "its float is used up first");
        assert_eq!(span_dates([10, 60], bounds(&[], &[]), bounds(&[], &[])), [10, 60]);
        assert_eq!(span_dates([5, 60], before, bounds(&[15], &[60])), [10, 60], "it keeps its lead");
    }
}
