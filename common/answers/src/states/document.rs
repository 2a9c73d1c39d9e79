//! States at a date as JSON.

use super::probability::StateProbabilities;
use crate::named::date_text;
use export::{ScheduleFindings, ScheduleReport};
use messages::{ScheduleState, ScheduleStateHead, Site, SpaceState};
use schedule::Period;
use serde::Serialize;
use std::collections::BTreeMap;

/// What `groundplan states --json` prints of a date.
#[derive(Debug, Serialize)]
pub struct States<'s> {
    at: String,
    /// End of the period whose union these states are, exclusive; null for an instant.
    until: Option<String>,
    elements: BTreeMap<&'s str, &'static str>,
    spaces: BTreeMap<&'s str, Space>,
    /// Where the date has no time: what differs in the union over its day.
    #[serde(skip_serializing_if = "Option::is_none")]
    whole_day: Option<WholeDay<'s>>,
    /// With `--probability`.
    #[serde(skip_serializing_if = "Option::is_none")]
    probability: Option<StateProbabilities<'s>>,
    report: Report<'s>,
}

/// What `convert` draws differently for a date without a time, which is a whole day there and midnight here.
#[derive(Debug, Serialize)]
pub struct WholeDay<'s> {
    pub(crate) until: String,
    pub(crate) elements: BTreeMap<&'s str, &'static str>,
    pub(crate) spaces: BTreeMap<&'s str, Space>,
}

#[derive(Debug, PartialEq, Serialize)]
pub(crate) struct Space {
    state: &'static str,
    why: Vec<String>,
}

#[derive(Debug, Serialize)]
struct Report<'s> {
    /// Last change at or before the date.
    valid_from: Option<String>,
    /// Next change after it.
    valid_until: Option<String>,
    /// Open spaces that will be blocked soon, and when.
    closing: BTreeMap<&'s str, String>,
    /// Number of elements by state.
    counts: BTreeMap<&'static str, usize>,
    #[serde(flatten)]
    schedule: ScheduleReport,
    findings: ScheduleFindings,
}

/// What differs in the union over a day from its midnight.
pub fn whole_day<'s>(
    site: &'s Site<'_>,
    midnight: &ScheduleState<'_>,
    day: Period,
    of_day: &ScheduleState<'_>,
) -> WholeDay<'s> {
    let elements = (0..site.elements.len()).filter(|k| of_day.effective(*k) != midnight.effective(*k));
    let spaces = (0..site.spaces.len()).map(|k| (k, space_of(of_day, k)));
    let spaces = spaces.filter(|(k, space)| *space != space_of(midnight, *k));
    WholeDay {
        until: day.until_s.map(date_text).unwrap_or_default(),
        elements: elements.map(|k| (site.text(site.elements[k].global_id), of_day.effective(k).name())).collect(),
        spaces: spaces.map(|(k, space)| (site.text(site.spaces[k].global_id), space)).collect(),
    }
}

/// The states at a date, or over a period.
pub fn states<'s>(
    site: &'s Site<'_>,
    schedule_state: &ScheduleState<'_>,
    period: Period,
    whole_day: Option<WholeDay<'s>>,
    probability: Option<StateProbabilities<'s>>,
) -> States<'s> {
    let elements = site.elements.iter().enumerate();
    let spaces = site.spaces.iter().enumerate();
    let closing = spaces.clone().filter(|(k, _)| schedule_state.spaces[*k].closes_at_s != ScheduleStateHead::NO_TIME);
    let time = |seconds: i64| messages::plan_time(seconds).map(|t| t.to_string());
    States {
        at: date_text(period.from_s),
        until: period.until_s.map(date_text),
        whole_day,
        probability,
        elements: elements.map(|(k, e)| (site.text(e.global_id), schedule_state.effective(k).name())).collect(),
        spaces: spaces.map(|(k, s)| (site.text(s.global_id), space_of(schedule_state, k))).collect(),
        report: Report {
            valid_from: time(schedule_state.head.valid_from_s),
            valid_until: time(schedule_state.head.valid_until_s),
            closing: closing
                .map(|(k, s)| (site.text(s.global_id), date_text(schedule_state.spaces[k].closes_at_s)))
                .collect(),
            counts: counts(schedule_state),
            schedule: ScheduleReport::of(site, schedule_state),
            findings: ScheduleFindings::of(site, schedule_state),
        },
    }
}

fn space_of(schedule_state: &ScheduleState<'_>, space: usize) -> Space {
    let state = if schedule_state.is_blocked(space) { SpaceState::Blocked } else { SpaceState::Open };
    Space { state: state.name(), why: schedule_state.why(space).map(str::to_owned).collect() }
}

pub(crate) fn counts(schedule_state: &ScheduleState<'_>) -> BTreeMap<&'static str, usize> {
    let mut counts = BTreeMap::new();
    for k in 0..schedule_state.n_elements() {
        *counts.entry(schedule_state.effective(k).name()).or_default() += 1;
    }
    counts
}
