//! Selects the observations that may change the maps: additions if configured, absences only after confirmation by an operator.

use messages::{DeviationVerdict, Deviations, Observation, ScheduleStateHead, Site, plan_time};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;

/// Elements by GlobalId whose observed state differs from the planned one.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AppliedObservations {
    /// Early elements, with the plan time at which they were first seen.
    early: BTreeMap<String, i64>,
    /// Absent elements, confirmed by an operator.
    absent: BTreeSet<String>,
}

impl AppliedObservations {
    /// Adds early elements from a comparison, and removes absent ones that are seen again. Apparent absences have no effect.
    #[must_use]
    pub fn with_additions(&self, site: &Site<'_>, deviations: &Deviations<'_>) -> Self {
        let mut observed = self.clone();
        let at_s = deviations.head.plan_time_s;
        for record in deviations.elements {
            let is = |observation: Observation| record.observation == observation;
            let id = site.text(site.elements[record.element as usize].global_id);
            if is(Observation::Observed) || is(Observation::Displaced) {
                observed.absent.remove(id);
            }
            // Without a plan time everything is planned to stand.
            if record.verdict == DeviationVerdict::Early && at_s != ScheduleStateHead::NO_TIME {
                let first_s = observed.early.entry(id.to_owned()).or_insert(at_s);
                *first_s = at_s.min(*first_s);
            }
        }
        observed
    }

    /// Adds absences that an operator confirmed, of elements that the robot saw through.
    #[must_use]
    pub fn with_absent(&self, ids: &[String]) -> Self {
        let mut observed = self.clone();
        for id in ids {
            observed.early.remove(id);
            observed.absent.insert(id.clone());
        }
        observed
    }

    /// Takes absences back.
    #[must_use]
    pub fn without_absent(&self, ids: &[String]) -> Self {
        let mut observed = self.clone();
        observed.absent.retain(|id| !ids.contains(id));
        observed
    }

    /// GlobalIds of the absent elements.
    pub fn absent(&self) -> &BTreeSet<String> {
        &self.absent
    }

    /// The table for schedule evaluation; `applies` says whether additions are in it.
    pub fn table(&self, applies: bool) -> String {
        let mut table = "id,start,finish\n".to_owned();
        for (id, at_s) in self.early.iter().filter(|_| applies) {
            if let Some(at) = plan_time(*at_s) {
                // Writing to a string does not fail.
                let _ = writeln!(table, "{id},,{at}");
            }
        }
        for id in &self.absent {
            let _ = writeln!(table, "{id},absent,");
        }
        table
    }
}
