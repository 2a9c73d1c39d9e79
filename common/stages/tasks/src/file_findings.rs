//! Findings about a schedule file: those of its reader, and contradictions of its tasks.

use crate::task_values::{shown_dates, three_point_record};
use diagnostics::counted;
use messages::*;
use schedule_files::{FindingKind, PlanDate, PlanFile, PlanTask, PlanTaskKind};
use std::collections::BTreeMap;

/// Most names in a diagnostic.
const MAX_NAMES: usize = 5;

/// Adds what the reader of a schedule file found, and what its tasks say that cannot be.
pub(crate) fn add_findings(builder: &mut TasksBuilder, plan: &PlanFile, source: u32, ids: &[String]) {
    let mut report = Report::default();
    // Circles of dependencies are reported with the dates that they leave open, when the schedule is evaluated.
    for finding in plan.findings.iter().filter(|finding| finding.kind != FindingKind::Circle) {
        let code = match finding.kind {
            FindingKind::UnreadableValue => DiagnosticCode::ScheduleFileValue,
            FindingKind::DuplicateTask => DiagnosticCode::ScheduleFileDuplicateTask,
            FindingKind::MissingReference => DiagnosticCode::ScheduleFileReference,
            FindingKind::NestedInItself => DiagnosticCode::ScheduleFileNesting,
            FindingKind::EndsBeforeStart => DiagnosticCode::TaskReversed,
            FindingKind::Circle => DiagnosticCode::TaskCycle,
            FindingKind::NotUnderstood => DiagnosticCode::ScheduleFileNotUnderstood,
        };
        let entity = finding.task.map(|k| named(&ids[k], &plan.tasks[k].name));
        let (severity, message) = (Severity::Warning, finding.message.clone());
        report.push(Diagnostic { severity, code, entity, source: Some(source), message });
    }
    report_data_dates(&mut report, plan, source, ids);
    for (task, id) in plan.tasks.iter().zip(ids) {
        if three_point_record(task, 0).is_some_and(|record| !record.is_ascending()) {
            report.push(Diagnostic {
                severity: Severity::Warning,
                code: DiagnosticCode::ScheduleFileValue,
                entity: Some(named(id, &task.name)),
                source: Some(source),
                message: "its optimistic, likely and pessimistic durations do not ascend; they are not used".to_owned(),
            });
        }
    }
    for diagnostic in report.finish() {
        builder.diagnostics.push(DiagnosticRecord::of(&diagnostic, &mut builder.texts));
    }
}

/// Reports work that is still ahead although the file plans it before its data date, one line for each data date: it is shown where it is
/// planned, which is past.
fn report_data_dates(report: &mut Report, plan: &PlanFile, source: u32, ids: &[String]) {
    // Tasks that have not begun, and tasks that have begun and go on, by data date.
    let mut late: BTreeMap<i64, [Vec<usize>; 2]> = BTreeMap::new();
    for (k, task) in plan.tasks.iter().enumerate() {
        let has_begun = usize::from(task.dates.actual[0].is_some());
        if let Some(data_date) = plan.data_date_of(task).filter(|date| is_before(task, has_begun, *date)) {
            late.entry(data_date.at.civil_seconds()).or_default()[has_begun].push(k);
        }
    }
    for (at_s, tasks) in late {
        let at = plan_time(at_s).map(|at| at.to_string()).unwrap_or_default();
        let what = [
            "planned to begin before the data date {} and not begun",
            "begun and planned to finish before the data date {}",
        ];
        for (what, tasks) in what.into_iter().zip(tasks).filter(|(_, tasks)| !tasks.is_empty()) {
            let (n, names, what) = (counted(tasks.len(), "task"), first_names(&tasks, ids), what.replace("{}", &at));
            let message = format!("{n} {what}: {names}; shown as planned");
            let (severity, code) = (Severity::Warning, DiagnosticCode::TaskBeforeDataDate);
            report.push(Diagnostic { severity, code, entity: None, source: Some(source), message });
        }
    }
}

/// Whether the start or the finish that is still ahead of a task is planned before the data date.
fn is_before(task: &PlanTask, end: usize, data_date: PlanDate) -> bool {
    let is_ahead = task.kind != PlanTaskKind::Summary && !task.is_inactive && task.dates.actual[1].is_none();
    let is_before = |planned: PlanDate| match planned.is_day || data_date.is_day {
        true => planned.at.0.date() < data_date.at.0.date(),
        false => planned.at < data_date.at,
    };
    is_ahead && shown_dates(task)[end].is_some_and(is_before)
}

/// The first names of tasks, with a mark if there are more.
pub(crate) fn first_names(tasks: &[usize], ids: &[String]) -> String {
    let names: Vec<&str> = tasks.iter().take(MAX_NAMES).map(|k| ids[*k].as_str()).collect();
    let more = if tasks.len() > MAX_NAMES { ", .." } else { "" };
    format!("{}{more}", names.join(", "))
}

/// A task as the entity of a diagnostic.
pub(crate) fn named(id: &str, name: &str) -> Named {
    Named { step_id: 0, global_id: id.to_owned(), name: name.to_owned() }
}
