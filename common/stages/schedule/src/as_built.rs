//! Reads what an as-built model says of its elements: the property set that `groundplan as-built` writes, as reported progress.

use crate::diagnostics::{Entity, ScheduleDiagnostics};
use crate::overrides::ABSENT;
use crate::rules::Rules;
use frames::written_date::{self, WrittenDate};
use messages::{DiagnosticCode, Severity, Site};
use std::collections::BTreeMap;

/// The property set.
pub const AS_BUILT_SET: &str = "Groundplan_AsBuilt";

/// Start and finish by element; `None` for one that is absent.
pub(crate) type ElementReports = BTreeMap<usize, Option<[Option<WrittenDate>; 2]>>;

/// What the model says of its elements. A date that cannot be read is a diagnostic, and counts as none.
pub(crate) fn as_built_reports(
    site: &Site<'_>,
    rules: &Rules,
    diagnostics: &mut ScheduleDiagnostics<'_>,
) -> ElementReports {
    let mut reports = ElementReports::new();
    for (k, element) in site.elements.iter().enumerate() {
        let (mut is_absent, mut dates) = (false, [None; 2]);
        for attribute in site.element_attributes(element).iter().filter(|a| site.text(a.set) == AS_BUILT_SET) {
            let value = site.text(attribute.text);
            let place = match site.text(attribute.name) {
                "Observation" => {
                    is_absent = value == ABSENT;
                    continue;
                }
                "ActualStart" => 0,
                "ActualFinish" => 1,
                _ => continue,
            };
            match written_date::parse_iso(value, rules.site_zone.as_ref()) {
                Ok(date) => dates[place] = Some(date),
                Err(why) => {
                    let entity = Entity::of(element.global_id, element.name, element.step_id, element.source);
                    let message = format!("{AS_BUILT_SET}.{}: {why}; it is skipped", site.text(attribute.name));
                    diagnostics.add(Severity::Error, DiagnosticCode::DateUnreadable, Some(entity), message);
                }
            }
        }
        if is_absent {
            reports.insert(k, None);
        } else if dates.iter().any(Option::is_some) {
            reports.insert(k, Some(dates));
        }
    }
    reports
}
