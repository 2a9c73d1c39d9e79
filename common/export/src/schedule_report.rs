//! Schedule section of `report.json` and `states`: sources of dates and schedule diagnostics.

use crate::diagnostics::{Diagnostic, phase_diagnostics};
use messages::{DateSource, DiagnosticCode, Phase, Site};
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
    /// Objects that have a word where a date should be.
    placeholders: Vec<String>,
    /// Objects with a date that could not be used.
    unreadable: Vec<String>,
    /// Tasks without dates.
    undated_tasks: Vec<String>,
    /// Elements that are to be demolished or temporary, but nothing says when.
    status_without_date: Vec<String>,
}

impl ScheduleReport {
    /// Of a phase that carries the schedule.
    pub fn of(site: &Site<'_>, phase: &Phase<'_>) -> Self {
        use DiagnosticCode::*;
        let mut sources: BTreeMap<&'static str, usize> = BTreeMap::new();
        let mut undated = Vec::new();
        for (element, record) in site.elements.iter().zip(phase.schedule) {
            let source = record.source.get();
            *sources.entry(source.name()).or_default() += 1;
            if source == DateSource::None && phase.head.n_changes > 0 {
                undated.push(site.text(element.global_id).to_owned());
            }
        }
        let of_code = |codes: &[DiagnosticCode]| {
            let found = phase.diagnostics.iter().filter(|d| codes.contains(&d.code.get()));
            found.map(|d| phase.text(d.global_id).to_owned()).filter(|id| !id.is_empty()).collect()
        };
        Self {
            n_changes: phase.head.n_changes,
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
    /// Of a phase that carries the schedule.
    pub fn of(site: &Site<'_>, phase: &Phase<'_>) -> Self {
        Self(phase_diagnostics(site, phase).collect())
    }
}
