//! What-if delays: moves tasks and their successors after float is used up.

use super::graph::dependencies;
use super::resolve::roll_up;
use super::{
    SpanBounds, SpanLink, TaskDates, Tasks, decides, sequences_of_spans, span_dates, span_links, with_ancestors,
};

/// Moves tasks by their delays, and everything that depends on them as far as it must: float is used up first.
///
/// `delay_s` holds a delay per task, in seconds of its own clock; one of a summary moves all that is nested in it. A task
/// with actual dates has happened and stays, and one that is scheduled by hand moves by its own delay alone. Nothing ever
/// becomes earlier; a successor that starts before its predecessor allows keeps that lead.
pub(crate) fn delay(tasks: &Tasks<'_>, dates: &[Option<TaskDates>], delay_s: &[i64]) -> Vec<Option<TaskDates>> {
    let site = tasks.site;
    let mut incoming = vec![Vec::new(); site.schedule.tasks.len()];
    for sequence in site.schedule.sequences.iter().filter(|s| decides(site, s)) {
        incoming[sequence.successor as usize].push(sequence);
    }
    let of_spans = sequences_of_spans(site);
    let mut moved = dates.to_vec();
    for (group, is_cycle) in dependencies(site).groups() {
        for k in group.iter().map(|k| *k as usize) {
            let Some(planned) = dates[k] else { continue };
            if tasks.is_summary(k) {
                continue;
            }
            let task_times = &tasks.task_times[k];
            if task_times.is_span && !is_cycle && task_times.actual_finish.is_none() {
                let links = span_links(tasks, k, &of_spans[k], dates);
                moved[k] = Some(moved_span(tasks, k, &links, [dates, &moved], delay_s));
                continue;
            }
            if task_times.actual_start.is_some() || task_times.actual_finish.is_some() {
                continue;
            }
            let own_s = total_delay_s(tasks, delay_s, k);
            let clock = tasks.clock(k);
            let shifted = |s: i64| clock.add(s, own_s).unwrap_or(s);
            let mut start_s = shifted(planned.start_s);
            let (own_start_s, finish_s) = (start_s, shifted(planned.finish_s));
            // In a cycle there is no order in which delays propagate.
            for sequence in incoming[k].iter().filter(|_| !is_cycle && !tasks.is_manual(k)) {
                let predecessor = sequence.predecessor as usize;
                let (Some(before), Some(after)) = (dates[predecessor], moved[predecessor]) else { continue };
                let duration_s = tasks.duration_s(k, planned);
                let bounds = (tasks.bound_s(sequence, before, duration_s), tasks.bound_s(sequence, after, duration_s));
                if let (Some(before_s), Some(after_s)) = bounds
                    && after_s > before_s
                {
                    let lead_s = (before_s - planned.start_s).max(0);
                    start_s = start_s.max(after_s - lead_s);
                }
            }
            // What depends on others does not move past a date that goes before them, but for a delay of its own.
            if let Some(firm_s) = tasks.limits[k].firm_start_s(tasks.duration_s(k, planned), clock) {
                start_s = start_s.min(firm_s.max(own_start_s));
            }
            moved[k] = Some(if start_s == planned.start_s {
                TaskDates { finish_s, ..planned }
            } else {
                let is_work = planned.start_s < planned.finish_s;
                let start_s = if is_work { clock.next_working(start_s).unwrap_or(start_s) } else { start_s };
                let worked_s = clock.between(planned.start_s, planned.finish_s);
                let pushed_s = clock.add(start_s, worked_s).unwrap_or(start_s);
                // A finish that is expected is not pushed, but for a delay of its own.
                let expected_s = tasks.limits[k].expected_finish_s(planned.start_s).filter(|s| *s == planned.finish_s);
                let is_expected = expected_s.is_some() && start_s <= finish_s;
                TaskDates { start_s, finish_s: if is_expected { finish_s } else { finish_s.max(pushed_s) }, ..planned }
            });
        }
        roll_up_group(tasks, dates, &mut moved, group);
    }
    moved
}

/// A span follows what it spans, and moves at least as far as what it is nested in; a delay of its own moves its finish.
fn moved_span(
    tasks: &Tasks<'_>,
    k: usize,
    links: &[SpanLink<'_>],
    [before, after]: [&[Option<TaskDates>]; 2],
    delay_s: &[i64],
) -> TaskDates {
    let planned = before[k].expect("only tasks with dates move");
    let bounds = |dates: &[Option<TaskDates>]| SpanBounds::of(links, |t| dates[t].map(|d| [d.start_s, d.finish_s]));
    let clock = tasks.clock(k);
    let shifted = |s: i64, by_s: i64| clock.add(s, by_s).unwrap_or(s);
    let above_s = total_delay_s(tasks, delay_s, k) - delay_s[k];
    let [start_s, finish_s] = span_dates([planned.start_s, planned.finish_s], bounds(before), bounds(after));
    let has_begun = tasks.task_times[k].actual_start.is_some();
    let start_s = if has_begun { planned.start_s } else { start_s.max(shifted(planned.start_s, above_s)) };
    let finish_s = shifted(finish_s.max(shifted(planned.finish_s, above_s)), delay_s[k]);
    TaskDates { start_s, finish_s: finish_s.max(start_s), ..planned }
}

fn roll_up_group(tasks: &Tasks<'_>, dates: &[Option<TaskDates>], moved: &mut [Option<TaskDates>], group: &[u32]) {
    for k in group.iter().map(|k| *k as usize).filter(|k| tasks.is_summary(*k) && dates[*k].is_some()) {
        let nested: Vec<TaskDates> = tasks.children[k].iter().filter_map(|c| moved[*c as usize]).collect();
        if !nested.is_empty() {
            moved[k] = Some(roll_up(&nested));
        }
    }
}

/// The delays of a task and of what it is nested in.
pub(crate) fn total_delay_s(tasks: &Tasks<'_>, delay_s: &[i64], k: usize) -> i64 {
    with_ancestors(tasks.site, k).map(|at| delay_s[at]).fold(0, i64::saturating_add)
}
