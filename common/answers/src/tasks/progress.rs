//! Progress of a running site: dates as planned, as people reported them, and as robots observed them.

use crate::named::optional_date_text;
use messages::{ArchiveError, ScheduleState, Site};
use schedule::{Actual, Timeline, find_task};
use serde::Serialize;
use std::collections::{BTreeMap, HashMap};

/// What is planned, reported and observed, by GlobalId.
#[derive(Debug, Default, Serialize)]
pub struct Progress<'s> {
    /// Every task that has planned or reported dates.
    pub tasks: BTreeMap<&'s str, TaskProgress>,
    /// Elements of which something was reported or observed.
    pub elements: BTreeMap<&'s str, ElementProgress>,
}

/// Dates of a task.
#[derive(Debug, Default, PartialEq, Eq, Serialize)]
pub struct TaskProgress {
    /// As if nothing had been reported; null without dates.
    pub planned: Option<ProgressDates>,
    /// As it was reported; null if it was not.
    pub reported: Option<ProgressDates>,
}

/// Dates of an element.
#[derive(Debug, Default, PartialEq, Eq, Serialize)]
pub struct ElementProgress {
    /// As if nothing had been reported or observed.
    pub planned: ProgressDates,
    /// As it was reported; null if it was not.
    pub reported: Option<ProgressDates>,
    /// As a robot observed it; null if none did.
    pub observed: Option<ProgressDates>,
}

/// Start and finish: plan times, or texts of a table of progress as they are written there.
#[derive(Debug, Default, Clone, PartialEq, Eq, Serialize)]
pub struct ProgressDates {
    /// Null if not known; `absent` for an element that is not there.
    pub start: Option<String>,
    /// Null if not known, or while work goes on.
    pub finish: Option<String>,
}

impl ProgressDates {
    fn of_row(row: &Actual) -> Self {
        let written = |text: &str| Some(text.to_owned()).filter(|text| !text.is_empty());
        Self { start: written(&row.start), finish: written(&row.finish) }
    }
}

/// The progress in force; `planned` is the schedule without it. Rows about what the site does not have are left out.
///
/// # Errors
/// A timeline of another site.
pub fn progress<'s>(
    site: &'s Site<'_>,
    planned: &Timeline,
    reported: &[Actual],
    observed: &[Actual],
) -> Result<Progress<'s>, ArchiveError> {
    let state = planned.schedule_state_at(None).finish();
    let state = ScheduleState::open(state.bytes())?;
    let by_id: HashMap<&str, usize> =
        site.elements.iter().enumerate().map(|(k, element)| (site.text(element.global_id), k)).collect();
    let mut progress = Progress::default();
    for (k, task) in site.schedule.tasks.iter().enumerate() {
        if let Some(dates) = planned.task(k) {
            let [start, finish] = [dates.start_s, dates.finish_s].map(optional_date_text);
            let planned = Some(ProgressDates { start, finish });
            progress.tasks.insert(site.schedule.text(task.global_id), TaskProgress { planned, reported: None });
        }
    }
    for (rows, is_observed) in [(reported, false), (observed, true)] {
        for row in rows {
            if let Some((&id, &k)) = by_id.get_key_value(row.id.as_str()) {
                let of_element = progress.elements.entry(id).or_insert_with(|| {
                    let dates = state.schedule_of(k);
                    let [start, finish] = [dates.start_s, dates.finish_s].map(optional_date_text);
                    ElementProgress { planned: ProgressDates { start, finish }, ..ElementProgress::default() }
                });
                let told = Some(ProgressDates::of_row(row));
                if is_observed { of_element.observed = told } else { of_element.reported = told }
            } else if let Ok(task) = find_task(site, &row.id) {
                let id = site.schedule.text(site.schedule.tasks[task].global_id);
                progress.tasks.entry(id).or_default().reported = Some(ProgressDates::of_row(row));
            }
        }
    }
    Ok(progress)
}
