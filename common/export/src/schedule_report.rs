//! Schedule section of `report.json` and `states`: sources of dates and schedule diagnostics.

use crate::diagnostics::{Diagnostic, schedule_diagnostics};
use messages::{DateSource, DiagnosticCode, ScheduleState, Site};
use schemars::JsonSchema;
use serde::Serialize;
use std::collections::BTreeMap;

/// Where dates come from, and what is wrong with them. Lists are of GlobalIds.
#[derive(Debug, Serialize, JsonSchema)]
pub struct ScheduleReport {
    /// Number of instants at which anything changes.
    n_changes: u32,
    /// Number of elements by where their dates come from; `none`: they exist.
    sources: BTreeMap<&'static str, usize>,
    /// Elements without any date, on sites where others have one.
    undated: Vec<String>,
    /// Objects whose date fits two orders; other dates of the file decided.
    ambiguous: Vec<String>,
    /// Objects with a placeholder in place of a date.
    placeholders: Vec<String>,
    /// Objects with a date that could not be used.
    unreadable: Vec<String>,
    /// Tasks without dates.
    undated_tasks: Vec<String>,
    /// Elements that are to be demolished or temporary, without a date.
    status_without_date: Vec<String>,
}

impl ScheduleReport {
    /// Of a schedule state that carries the schedule.
    pub fn of(site: &Site<'_>, schedule_state: &ScheduleState<'_>) -> Self {
        use DiagnosticCode::*;
        let mut sources: BTreeMap<&'static str, usize> = BTreeMap::new();
        let mut undated = Vec::new();
        for (element, record) in site.elements.iter().zip(schedule_state.schedule) {
            let source = record.source.get();
            *sources.entry(source.name()).or_default() += 1;
            if source == DateSource::None && schedule_state.head.n_changes > 0 {
                undated.push(site.text(element.global_id).to_owned());
            }
        }
        let of_code = |codes: &[DiagnosticCode]| {
            let found = schedule_state.diagnostics.iter().filter(|d| codes.contains(&d.code.get()));
            found.map(|d| schedule_state.text(d.global_id).to_owned()).filter(|id| !id.is_empty()).collect()
        };
        Self {
            n_changes: schedule_state.head.n_changes,
            sources,
            undated,
            ambiguous: of_code(&[DateAmbiguous]),
            placeholders: of_code(&[DatePlaceholder]),
            unreadable: of_code(&[DateUnreadable, DateOrder, DateZone, TaskDateUnreadable]),
            undated_tasks: of_code(&[TaskUndated, TaskReversed, TaskDateUnreadable]),
            status_without_date: of_code(&[StatusWithoutDate]),
        }
    }
}

/// What is wrong with the schedule, one by one.
#[derive(Debug, Serialize)]
pub struct ScheduleFindings(Vec<Diagnostic>);

impl ScheduleFindings {
    /// Of a schedule state that carries the schedule.
    pub fn of(site: &Site<'_>, schedule_state: &ScheduleState<'_>) -> Self {
        Self(schedule_diagnostics(site, schedule_state).collect())
    }
}
