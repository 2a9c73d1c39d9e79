//! Dates that bind tasks: constraints of planners' tools.
//!
//! A soft upper limit (start or finish no later than) moves no work: it counts for floats, and where it is not kept it is told. A firm
//! one goes before dependencies, as do mandatory dates.

use super::graph::{decides, label};
use super::read_date::read_date;
use super::{TaskDates, Tasks};
use crate::clock::Clock;
use crate::diagnostics::{Entity, ScheduleDiagnostics};
use frames::written_date::WrittenDate;
use messages::{
    DateSource, DiagnosticCode, ScheduleDate, Severity, TaskConstraintKind, TaskConstraintRecord, constraint_flags,
    plan_time,
};

/// What the constraints of a task say of its start and its finish, in civil seconds.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct Limits {
    /// Earliest start and finish.
    pub(crate) min_s: [Option<i64>; 2],
    /// Latest start and finish.
    max_s: [Option<i64>; 2],
    /// Start and finish that go before dependencies.
    fixed_s: [Option<i64>; 2],
    /// Latest dates go before dependencies.
    is_firm: bool,
    /// As late as its successors allow.
    pub(crate) is_late: bool,
    /// Its finish is told if it is later.
    deadline_s: Option<i64>,
    /// When it is expected to finish.
    expected_s: Option<i64>,
}

impl Limits {
    /// Takes in a constraint; what its successors allow has no date.
    pub(crate) fn add(&mut self, record: &TaskConstraintRecord, date: WrittenDate) {
        use TaskConstraintKind::*;
        let (start_s, finish_s) = (date.start_s(), date.finish_s());
        let is_firm = record.flags & constraint_flags::FIRM != 0;
        let later = |known: &mut Option<i64>, s: i64| *known = Some(known.map_or(s, |k| k.max(s)));
        let earlier = |known: &mut Option<i64>, s: i64| *known = Some(known.map_or(s, |k| k.min(s)));
        let [min_start_s, min_finish_s] = &mut self.min_s;
        let [max_start_s, max_finish_s] = &mut self.max_s;
        match record.kind.get() {
            AsLateAsPossible => self.is_late = true,
            Deadline => self.deadline_s = Some(finish_s),
            ExpectedFinish => self.expected_s = Some(finish_s),
            StartNotEarlierThan => later(min_start_s, start_s),
            FinishNotEarlierThan => later(min_finish_s, finish_s),
            StartNotLaterThan => earlier(max_start_s, start_s),
            FinishNotLaterThan => earlier(max_finish_s, finish_s),
            StartOn if !is_firm => {
                later(min_start_s, start_s);
                earlier(max_start_s, start_s);
            }
            FinishOn if !is_firm => {
                later(min_finish_s, finish_s);
                earlier(max_finish_s, finish_s);
            }
            StartOn | MandatoryStart => self.fixed_s[0] = Some(start_s),
            FinishOn | MandatoryFinish => self.fixed_s[1] = Some(finish_s),
        }
        self.is_firm |= is_firm && matches!(record.kind.get(), StartNotLaterThan | FinishNotLaterThan);
    }

    /// Where a task of this duration starts that its work schedule and its predecessors let start at `start_s`.
    pub(crate) fn start_s(&self, start_s: Option<i64>, duration_s: i64, clock: Clock<'_>) -> Option<i64> {
        if let Some(fixed_s) = start_of(self.fixed_s, duration_s, clock).into_iter().flatten().next() {
            return Some(fixed_s);
        }
        let earliest = start_of(self.min_s, duration_s, clock).into_iter().flatten().chain(start_s).max()?;
        Some(self.firm_start_s(duration_s, clock).map_or(earliest, |firm_s| firm_s.min(earliest)))
    }

    /// The finish of a task that ends at `finish_s` by its duration: a date that goes before dependencies stays as it is, also outside
    /// working time.
    pub(crate) fn finish_s(&self, start_s: i64, finish_s: i64) -> i64 {
        let fixed_s = self.fixed_s[1].filter(|s| self.fixed_s[0].is_none() && start_s <= *s);
        fixed_s.unwrap_or(finish_s)
    }

    /// When a task that starts at `start_s` is expected to finish, if that is still to come and no date goes before it.
    pub(crate) fn expected_finish_s(&self, start_s: i64) -> Option<i64> {
        self.expected_s.filter(|s| self.fixed_s[1].is_none() && !self.is_late && start_s <= *s)
    }

    /// The start behind which no predecessor pushes a task of this duration.
    pub(crate) fn firm_start_s(&self, duration_s: i64, clock: Clock<'_>) -> Option<i64> {
        let fixed = start_of(self.fixed_s, duration_s, clock).into_iter().flatten().next();
        let latest = || start_of(self.max_s, duration_s, clock).into_iter().flatten().min();
        fixed.or_else(|| if self.is_firm { latest() } else { None })
    }

    /// The latest finish of a task of this duration whose successors allow `late_finish_s`.
    pub(crate) fn late_finish_s(&self, late_finish_s: i64, duration_s: i64, clock: Clock<'_>) -> i64 {
        let finish_of = |[start, finish]: [Option<i64>; 2]| [start.and_then(|s| clock.add(s, duration_s)), finish];
        if let Some(fixed_s) = finish_of(self.fixed_s).into_iter().flatten().next() {
            return fixed_s;
        }
        finish_of(self.max_s).into_iter().flatten().fold(late_finish_s, i64::min)
    }
}

/// The starts that limits of start and finish mean for this duration.
fn start_of([start, finish]: [Option<i64>; 2], duration_s: i64, clock: Clock<'_>) -> [Option<i64>; 2] {
    [start, finish.and_then(|s| clock.add(s, -duration_s))]
}

/// Reads the constraints of all tasks; one that cannot be read is reported.
pub(crate) fn limits(
    site: &messages::Site<'_>,
    rules: &crate::rules::Rules,
    diagnostics: &mut ScheduleDiagnostics<'_>,
) -> Vec<Limits> {
    let mut limits = vec![Limits::default(); site.schedule.tasks.len()];
    for record in site.schedule.constraints {
        match read_date(ScheduleDate::Civil(record.date()), rules) {
            Ok(date) => limits[record.task as usize].add(record, date),
            Err(why) => {
                let message = format!("the date of its constraint: {why}; it does not count");
                let entity = Some(Entity::task(&site.schedule.tasks[record.task as usize]));
                diagnostics.add(Severity::Error, DiagnosticCode::TaskDateUnreadable, entity, message);
            }
        }
    }
    limits
}

/// Reports constraints that the dates of tasks do not keep, and those that are kept although what the task depends on ends later.
pub(crate) fn report(tasks: &Tasks<'_>, dates: &[Option<TaskDates>], diagnostics: &mut ScheduleDiagnostics<'_>) {
    let site = tasks.site;
    for (k, limits) in tasks.limits.iter().enumerate().filter(|(_, limits)| **limits != Limits::default()) {
        let Some(own) = dates[k].filter(|_| !tasks.is_summary(k) && !tasks.has_begun(k)) else { continue };
        let clock = tasks.clock(k);
        let at = |s: i64| plan_time(s).map(|at| at.to_string()).unwrap_or_default();
        let ends_s = [own.start_s, own.finish_s];
        let entity = Some(Entity::task(&site.schedule.tasks[k]));
        if let Some(deadline_s) = limits.deadline_s.filter(|s| clock.between(*s, own.finish_s) > 0) {
            let message = format!("its deadline {} is not kept: it finishes {}", at(deadline_s), at(own.finish_s));
            diagnostics.add(Severity::Warning, DiagnosticCode::ConstraintUnmet, entity, message);
        }
        let is_computed = own.source == DateSource::Computed;
        let unexpected = |s: &i64| is_computed && clock.between(*s, own.finish_s) != 0;
        if let Some(expected_s) = limits.expected_s.filter(unexpected) {
            let message =
                format!("its expected finish {} is not kept: it finishes {}", at(expected_s), at(own.finish_s));
            diagnostics.add(Severity::Warning, DiagnosticCode::ConstraintUnmet, entity, message);
        }
        for (end, [verb, verbs]) in [["start", "starts"], ["finish", "finishes"]].into_iter().enumerate() {
            let is_after = |limit_s: &i64| clock.between(*limit_s, ends_s[end]) > 0;
            let is_before = |limit_s: &i64| clock.between(*limit_s, ends_s[end]) < 0;
            let unmet = [
                (limits.max_s[end].filter(is_after), "no later than"),
                (limits.min_s[end].filter(is_before), "no earlier than"),
                (limits.fixed_s[end].filter(|s| is_after(s) || is_before(s)), "on"),
            ];
            for (limit_s, how) in unmet.into_iter().filter_map(|(limit_s, how)| Some((limit_s?, how))) {
                let message = format!(
                    "its constraint to {verb} {how} {} is not kept: it {verbs} {}",
                    at(limit_s),
                    at(ends_s[end])
                );
                diagnostics.add(Severity::Warning, DiagnosticCode::ConstraintUnmet, entity, message);
            }
        }
    }
    for sequence in site.schedule.sequences.iter().filter(|s| decides(site, s)) {
        let k = sequence.successor as usize;
        let (Some(own), Some(before)) = (dates[k], dates[sequence.predecessor as usize]) else { continue };
        let clock = tasks.clock(k);
        let duration_s = tasks.duration_s(k, own);
        let is_firm = own.source == DateSource::Computed && tasks.limits[k].firm_start_s(duration_s, clock).is_some();
        let is_manual = tasks.is_manual(k) && !tasks.has_begun(k) && !tasks.is_summary(k);
        if !is_firm && !is_manual {
            continue;
        }
        if tasks.bound_s(sequence, before, duration_s).is_some_and(|bound_s| clock.between(own.start_s, bound_s) > 0) {
            let predecessor = label(site, sequence.predecessor as usize);
            let message = match is_manual {
                true => format!("it is scheduled by hand and stays before its predecessor {predecessor} allows it"),
                false => format!(
                    "the date of its constraint goes before its predecessor {predecessor}, which allows it later only"
                ),
            };
            let entity = Some(Entity::task(&site.schedule.tasks[k]));
            diagnostics.add(Severity::Warning, DiagnosticCode::ConstraintUnmet, entity, message);
        }
    }
}
