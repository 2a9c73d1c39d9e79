//! Activities and relationships, from records whose cells have the names of one format.

use super::{Record, constraint_kind, dependency_kind, task_kind};
use crate::assemble::{WrittenLink, WrittenPlan};
use crate::plan::{
    Constraint, ConstraintKind, DependencyKind, FindingKind, Length, PlanDates, PlanLag, PlanTask, PlanTaskKind,
};
use crate::resources::WrittenAssignment;
use crate::values::seconds;

/// Units for each hour below which P6 sees none.
const MIN_UNITS: f64 = 0.000_01;

/// Names of the cells of an activity; start and finish of each kind of date.
pub(crate) struct ActivityColumns {
    pub(crate) uid: &'static str,
    pub(crate) code: &'static str,
    pub(crate) name: &'static str,
    pub(crate) kind: &'static str,
    pub(crate) status: &'static str,
    pub(crate) duration: &'static str,
    pub(crate) remaining: &'static str,
    pub(crate) total_float: &'static str,
    pub(crate) free_float: &'static str,
    pub(crate) current_dates: [&'static str; 2],
    pub(crate) planned_dates: [&'static str; 2],
    pub(crate) early_dates: [&'static str; 2],
    pub(crate) late_dates: [&'static str; 2],
    pub(crate) actual_dates: [&'static str; 2],
    pub(crate) remaining_dates: [&'static str; 2],
    pub(crate) expected_finish: &'static str,
    /// Kind and date of the first and the second.
    pub(crate) constraints: [[&'static str; 2]; 2],
    /// Which percentage it goes by.
    pub(crate) percent_type: &'static str,
    pub(crate) physical_percent: &'static str,
    /// What is a whole in percentages.
    pub(crate) percent_whole: f64,
    /// Units of people and of machines.
    pub(crate) actual_units: [&'static str; 2],
    pub(crate) remaining_units: [&'static str; 2],
}

/// The activity of a record, which is the next of the plan.
pub(crate) fn activity(record: &impl Record, columns: &ActivityColumns, plan: &mut WrittenPlan) -> PlanTask {
    let at = Some(plan.next_task());
    let (kind, is_finish_milestone) =
        known(record, columns.kind, task_kind(record.cell(columns.kind)), plan).unwrap_or_default();
    let is_complete = match record.cell(columns.status) {
        "TK_NotStart" | "TK_Active" | "Not Started" | "In Progress" => Some(false),
        "TK_Complete" | "Completed" => Some(true),
        "" => Some(record.given(columns.actual_dates[1]).is_some()),
        _ => None,
    };
    let is_complete = known(record, columns.status, is_complete, plan).unwrap_or(false);
    let findings = &mut plan.findings;
    let mut length = |name| record.hours(name, at, findings).map(|seconds| Length { seconds, is_elapsed: false });
    let (duration, remaining) = (length(columns.duration), length(columns.remaining));
    let mut task = PlanTask {
        uid: record.cell(columns.uid).to_owned(),
        code: record.cell(columns.code).to_owned(),
        name: record.text(columns.name).into_owned(),
        kind,
        duration,
        remaining,
        total_float_s: record.hours(columns.total_float, at, findings),
        free_float_s: record.hours(columns.free_float, at, findings),
        dates: dates(record, columns, plan),
        constraints: constraints(record, columns, plan),
        expected_finish: record.date(columns.expected_finish, at, &mut plan.findings),
        ..Default::default()
    };
    task.complete = Some(duration_complete(&task, is_complete));
    task.physical_complete = match record.cell(columns.percent_type) {
        "CP_Phys" | "Physical" => {
            let percent = record.number(columns.physical_percent, at, &mut plan.findings);
            Some((percent.unwrap_or(0.0) / columns.percent_whole).clamp(0.0, 1.0))
        }
        "CP_Units" | "Units" => Some(units_complete(record, columns, plan)),
        _ => None,
    };
    fill_current(&mut task, is_finish_milestone);
    task
}

/// Names of the cells of an assignment.
pub(crate) struct AssignmentColumns {
    pub(crate) task: &'static str,
    pub(crate) resource: &'static str,
    pub(crate) units: &'static str,
    pub(crate) units_per_hour: &'static str,
}

/// The work of a resource on an activity, planned hours of it for each hour.
pub(crate) fn assignment(
    record: &impl Record,
    columns: &AssignmentColumns,
    plan: &mut WrittenPlan,
) -> WrittenAssignment {
    let task = plan.index_of(record.cell(columns.task));
    let mut number = |name| record.number(name, task, &mut plan.findings);
    let (units, per_hour) = (number(columns.units), number(columns.units_per_hour));
    let hours =
        units.zip(per_hour).filter(|(_, per_hour)| *per_hour >= MIN_UNITS).map(|(units, per_hour)| units / per_hour);
    let [task, resource] = [columns.task, columns.resource].map(|name| record.cell(name).to_owned());
    WrittenAssignment { task, resource, length_s: hours.and_then(|hours| seconds(hours, 3600.0)) }
}

/// What a word of the products means; a finding if it is none of theirs.
fn known<T>(record: &impl Record, column: &str, meaning: Option<T>, plan: &mut WrittenPlan) -> Option<T> {
    if meaning.is_none() {
        let message = format!("its {column} {:?} is not known", record.cell(column));
        plan.find(Some(plan.next_task()), FindingKind::NotUnderstood, message);
    }
    meaning
}

fn dates(record: &impl Record, columns: &ActivityColumns, plan: &mut WrittenPlan) -> PlanDates {
    let at = Some(plan.next_task());
    let mut pair = |names: [&str; 2]| names.map(|name| record.date(name, at, &mut plan.findings));
    PlanDates {
        current: pair(columns.current_dates),
        planned: pair(columns.planned_dates),
        early: pair(columns.early_dates),
        late: pair(columns.late_dates),
        actual: pair(columns.actual_dates),
        remaining: pair(columns.remaining_dates),
        ..Default::default()
    }
}

fn constraints(record: &impl Record, columns: &ActivityColumns, plan: &mut WrittenPlan) -> Vec<Constraint> {
    let at = Some(plan.next_task());
    let mut constraints = Vec::new();
    for [kind_column, date_column] in columns.constraints {
        let Some(word) = record.given(kind_column) else { continue };
        let date = record.date(date_column, at, &mut plan.findings);
        match known(record, kind_column, constraint_kind(word), plan) {
            Some(kind) if date.is_some() || kind == ConstraintKind::AsLateAsPossible => {
                constraints.push(Constraint { kind, date });
            }
            Some(_) => {
                let message = format!("its constraint {word:?} has no date");
                plan.find(at, FindingKind::NotUnderstood, message);
            }
            None => {}
        }
    }
    constraints
}

/// Actual units of those and what remains.
fn units_complete(record: &impl Record, columns: &ActivityColumns, plan: &mut WrittenPlan) -> f64 {
    let at = Some(plan.next_task());
    let mut sum = |names: [&str; 2]| -> f64 {
        names.into_iter().filter_map(|name| record.number(name, at, &mut plan.findings)).sum()
    };
    let (actual, remaining) = (sum(columns.actual_units), sum(columns.remaining_units));
    if actual > 0.0 && remaining >= 0.0 { actual / (actual + remaining) } else { 0.0 }
}

/// Progress of the duration from 0 to 1, from the planned and the remaining one: where there is no duration, whether it is complete.
fn duration_complete(task: &PlanTask, is_complete: bool) -> f64 {
    match (task.duration, task.remaining) {
        (Some(planned), Some(remaining)) if planned.seconds > 0 => {
            (1.0 - remaining.seconds as f64 / planned.seconds as f64).clamp(0.0, 1.0)
        }
        _ => f64::from(u8::from(is_complete)),
    }
}

/// Start and finish of the current plan, where the file does not say them; and the same date at both ends of a milestone.
fn fill_current(task: &mut PlanTask, is_finish_milestone: bool) {
    let PlanDates { actual, remaining, planned, .. } = task.dates;
    let current = &mut task.dates.current;
    for end in 0..2 {
        current[end] = current[end].or(actual[end]).or(remaining[end]).or(planned[end]);
    }
    if task.kind == PlanTaskKind::Milestone {
        let end = usize::from(is_finish_milestone);
        let at = current[end].or(current[1 - end]);
        *current = [at, at];
    }
}

/// Names of the cells of a relationship.
pub(crate) struct LinkColumns {
    pub(crate) predecessor: &'static str,
    pub(crate) successor: &'static str,
    pub(crate) kind: &'static str,
    pub(crate) lag: &'static str,
}

/// The relationship of a record; its project says at the end whether its lag counts day and night.
pub(crate) fn read_link(record: &impl Record, columns: &LinkColumns, plan: &mut WrittenPlan) -> WrittenLink {
    let [predecessor, successor] = [columns.predecessor, columns.successor].map(|name| record.cell(name).to_owned());
    let task = plan.index_of(&successor).or(plan.index_of(&predecessor));
    let word = record.cell(columns.kind);
    let kind = dependency_kind(word).unwrap_or_else(|| {
        let message = format!("its {} {word:?} is not known; it counts as finish to start", columns.kind);
        plan.find(task, FindingKind::NotUnderstood, message);
        DependencyKind::FinishStart
    });
    let seconds = record.hours(columns.lag, task, &mut plan.findings).filter(|seconds| *seconds != 0);
    let lag = seconds.map(|seconds| PlanLag::Length(Length { seconds, is_elapsed: false }));
    WrittenLink { predecessor, successor, kind, lag }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn progress_is_that_of_the_duration() {
        let check = |planned, remaining, is_complete, expected| {
            let length = |seconds| Some(Length { seconds, is_elapsed: false });
            let task = PlanTask { duration: length(planned), remaining: length(remaining), ..Default::default() };
            assert_eq!(duration_complete(&task, is_complete), expected);
        };
        check(100, 25, false, 0.75);
        check(100, 150, false, 0.0);
        check(0, 0, false, 0.0);
        check(0, 0, true, 1.0);
    }
}
