//! By how much a task can slip: the backward pass.
//!
//! # Source
//! Kelley and Walker, "Critical-Path Planning and Scheduling", 1959.

use super::resolve::dependencies;
use super::{TaskDates, Tasks, ends, with_ancestors};
use messages::SequenceRecord;

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
    let mut outgoing: Vec<Vec<&SequenceRecord>> = vec![Vec::new(); site.schedule.tasks.len()];
    for sequence in site.schedule.sequences {
        outgoing[sequence.predecessor as usize].push(sequence);
    }
    // Latest start and finish, by task.
    let mut late: Vec<Option<[i64; 2]>> = vec![None; site.schedule.tasks.len()];
    for (group, is_cycle) in dependencies(site).groups().rev() {
        let k = group[0] as usize;
        let Some(own) = dates[k].filter(|_| !is_cycle) else { continue };
        let clock = tasks.calendars.clock(tasks.task_times[k].clock);
        let duration_s = clock.between(own.start_s, own.finish_s);
        let (mut late_finish_s, mut free_s) = (end_s, clock.between(own.finish_s, end_s));
        for (sequence, is_own) in sequences_behind(tasks, &outgoing, k) {
            let (from_start, to_start) = ends(sequence);
            let successor = sequence.successor as usize;
            let (Some(next), Some(next_late)) = (dates[successor], late[successor]) else { continue };
            // What hangs on the start of a summary hangs on its first task alone.
            if from_start && !is_own {
                continue;
            }
            let Some((lag_s, lag_clock)) = tasks.lag(sequence, own) else { continue };
            let before = |s: i64| lag_clock.add(s, -lag_s).unwrap_or(s);
            let (next_s, next_late_s) =
                if to_start { (next.start_s, next_late[0]) } else { (next.finish_s, next_late[1]) };
            let (now_s, limit_s) = (if from_start { own.start_s } else { own.finish_s }, before(next_late_s));
            free_s = free_s.min(clock.between(now_s, before(next_s)));
            let finish_limit_s = if from_start { clock.add(limit_s, duration_s).unwrap_or(limit_s) } else { limit_s };
            late_finish_s = late_finish_s.min(finish_limit_s);
        }
        let late_start_s = clock.add(late_finish_s, -duration_s).unwrap_or(late_finish_s);
        late[k] = Some([late_start_s, late_finish_s]);
        if !tasks.is_summary(k) {
            floats[k] = Some(Floats { total_s: clock.between(own.finish_s, late_finish_s), free_s });
        }
    }
    floats
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
