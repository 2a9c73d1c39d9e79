//! Dates of construction phases, as the rules have them.

use crate::rules::Rules;
use std::collections::BTreeMap;

/// Construction phases by name.
pub(crate) struct ConstructionPhases<'r> {
    /// Start and finish by name; `None` for a construction phase before all time.
    pub(crate) spans: BTreeMap<&'r str, Option<[i64; 2]>>,
}

impl<'r> ConstructionPhases<'r> {
    /// The dates that the rules give.
    pub(crate) fn of(rules: &'r Rules) -> Self {
        Self { spans: rules.construction_phases.iter().map(|p| (p.name.as_str(), p.span_s)).collect() }
    }

    /// When a construction phase ends; `None` if it is unknown or before all time.
    pub(crate) fn finish_s(&self, name: &str) -> Option<i64> {
        self.spans.get(name).copied().flatten().map(|[_, finish_s]| finish_s)
    }
}
