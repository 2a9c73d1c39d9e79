//! Selects the observations that may change the maps: additions if configured, absences only after confirmation by an operator.

use messages::{DeviationVerdict, Deviations, Observation, ScheduleStateHead, Site, nearest_names_hint, plan_time};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;

/// Elements by GlobalId whose observed state differs from the planned one.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
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

    /// Adds absences confirmed by an operator.
    ///
    /// # Errors
    /// An element that the robot has not seen through.
    pub fn with_absent(&self, ids: &[String], site: &Site<'_>, deviations: &Deviations<'_>) -> Result<Self, String> {
        let mut observed = self.clone();
        for id in ids {
            let is_it = |e: u32| site.text(site.elements[e as usize].global_id) == id;
            let record = deviations.elements.iter().find(|record| is_it(record.element));
            match record.map(|record| record.observation.get()) {
                Some(Observation::Absent) => {
                    observed.early.remove(id);
                    observed.absent.insert(id.clone());
                }
                Some(other) => return Err(format!("{id} is {}: only what is absent can be confirmed", other.name())),
                None => {
                    let global_ids = deviations.elements.iter().map(|record| record.element as usize);
                    let global_ids = global_ids.map(|e| site.text(site.elements[e].global_id));
                    let nearest = nearest_names_hint(id, global_ids);
                    return Err(format!("{id} is not among the deviations of this storey{nearest}"));
                }
            }
        }
        Ok(observed)
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
