//! All findings by kind: errors, warnings, assumptions, substitutions and what is on no map, each with what it is about.

use super::document::{Entry, ReportDocument, WaypointsDocument};
use crate::circumstances::Circumstances;
use crate::named::label;
use crate::situation::Situation;
use export::{Report, Waypoints};
use schemars::JsonSchema;
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::fmt::Write;

/// Findings of one kind that are listed; the rest is counted.
const MAX_LISTED: usize = 500;

/// All that was found, with what it was found of.
#[derive(Debug, Serialize, JsonSchema)]
pub struct FindingsAnswer {
    /// What the answer is made of.
    pub circumstances: Circumstances,
    /// What was found.
    #[serde(flatten)]
    pub findings: Findings,
}

/// What was found, by kind.
#[derive(Debug, Default, PartialEq, Serialize, JsonSchema)]
pub struct Findings {
    /// What is missing in the result.
    pub errors: ListedFindings,
    /// What should be checked.
    pub warnings: ListedFindings,
    /// Floors and widths that the model does not give.
    pub assumptions: ListedFindings,
    /// Boxes in place of bodies that could not be made.
    pub substitutions: ListedFindings,
    /// Rooms and storeys on no map.
    pub left_out: ListedFindings,
}

/// Findings of one kind.
#[derive(Debug, Default, PartialEq, Serialize, JsonSchema)]
pub struct ListedFindings {
    /// How many there are, listed or not.
    pub n: usize,
    /// The first of them.
    pub list: Vec<NamedFinding>,
}

/// A finding with what it is about.
#[derive(Debug, PartialEq, Serialize, JsonSchema)]
pub struct NamedFinding {
    /// Stable code for programs.
    pub code: String,
    /// One sentence; null where the code says all.
    pub text: Option<String>,
    /// GlobalId of the element, space or task that it is about.
    pub global_id: Option<String>,
    /// Its name.
    pub name: Option<String>,
    /// The file, or the STEP id of the entity, where it has no GlobalId.
    pub place: Option<String>,
}

/// All findings of a situation: those that `report.json` and `waypoints.json` have.
pub fn findings(situation: &Situation<'_>) -> FindingsAnswer {
    let (input, circumstances) = (situation.export_input(), situation.circumstances);
    let (report, waypoints) = (as_read(&Report::of(&input)), as_read(&Waypoints::of(&input)));
    FindingsAnswer { circumstances: circumstances.clone(), findings: Findings::of(report, waypoints) }
}

/// A document as a reader of its file gets it.
fn as_read<T: DeserializeOwned>(document: &impl Serialize) -> T {
    let value = serde_json::to_value(document).expect("keys are texts, and numbers are finite");
    T::deserialize(value).expect("its lists have the keys that are read")
}

impl Findings {
    /// Of the two documents that tell of findings.
    pub fn of(report: ReportDocument, waypoints: WaypointsDocument) -> Self {
        let mut findings = Self::default();
        if report.schedule_ignored {
            findings.warnings.add("schedule_ignored", None, Entry::default());
        }
        for mut entry in report.diagnostics {
            let kind = match entry.severity.as_deref() {
                Some("error") => &mut findings.errors,
                Some("warning") => &mut findings.warnings,
                _ => continue,
            };
            kind.add(&entry.code.take().unwrap_or_default(), entry.message.take(), entry);
        }
        for mut entry in waypoints.notices {
            findings.warnings.add(&entry.code.take().unwrap_or_default(), entry.message.take(), entry);
        }
        for room in report.assumed_rooms {
            findings.assumptions.add("assumed_floor", None, room);
        }
        for door in report.doors.into_iter().filter(|door| door.clear_width_from.as_deref() == Some("assumed")) {
            let width = door.clear_width_m.map(|width_m| format!("{width_m:.2} m"));
            findings.assumptions.add("assumed_clear_width", width, door);
        }
        for mut element in report.failed_geometry {
            findings.substitutions.add(&element.drawn_as.take().unwrap_or_default(), None, element);
        }
        let left_out =
            [("spaces_not_mapped", report.spaces_not_mapped), ("storeys_not_mapped", report.storeys_not_mapped)];
        for (code, list) in left_out {
            for mut entry in list {
                findings.left_out.add(code, entry.reason.take(), entry);
            }
        }
        findings
    }
}

impl ListedFindings {
    fn add(&mut self, code: &str, text: Option<String>, of: Entry) {
        self.n += 1;
        if self.list.len() < MAX_LISTED {
            let place: Vec<String> = [of.file, of.entity].into_iter().flatten().collect();
            self.list.push(NamedFinding {
                code: code.to_owned(),
                text,
                global_id: of.global_id.or(of.element),
                name: of.name,
                place: (!place.is_empty()).then(|| place.join(" ")),
            });
        }
    }
}

impl FindingsAnswer {
    /// True if there is neither an error nor a warning.
    pub fn is_well(&self) -> bool {
        self.findings.errors.n == 0 && self.findings.warnings.n == 0
    }

    /// For people: a line for each.
    pub fn text(&self) -> String {
        let Findings { errors, warnings, assumptions, substitutions, left_out } = &self.findings;
        let mut out = String::new();
        for (kind, found) in [
            ("error", errors),
            ("warning", warnings),
            ("assumption", assumptions),
            ("substitution", substitutions),
            ("left out", left_out),
        ] {
            for finding in &found.list {
                // Writing to a string does not fail.
                let _ = writeln!(out, "{kind}: {}", finding.line());
            }
            if found.n > found.list.len() {
                let _ = writeln!(out, "{kind}: and {} more", found.n - found.list.len());
            }
        }
        if out.is_empty() {
            out.push_str("nothing was found\n");
        }
        let _ = writeln!(out, "{}", self.circumstances);
        out
    }
}

impl NamedFinding {
    fn line(&self) -> String {
        let named = self.global_id.as_deref().map(|global_id| label(self.name.as_deref(), global_id));
        let about = named.or_else(|| self.name.clone()).or_else(|| self.place.clone());
        [Some(self.code.replace('_', " ")), about, self.text.clone()]
            .into_iter()
            .flatten()
            .collect::<Vec<_>>()
            .join(": ")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::{Value, json};

    fn found(report: Value, waypoints: Value) -> Findings {
        Findings::of(serde_json::from_value(report).unwrap(), serde_json::from_value(waypoints).unwrap())
    }

    #[test]
    fn warnings_assumptions_and_substitutions_name_what_they_are_about() {
        let report = json!({
            "schedule_ignored": true,
            "diagnostics": [
                {"severity": "warning", "code": "unit", "message": "no unit", "global_id": "w", "name": "Wall", "file": "a.ifc", "entity": "#7"},
                {"severity": "info", "code": "note", "message": "all is well"},
                {"severity": "error", "code": "lost", "message": "it is lost"}],
            "assumed_rooms": [{"global_id": "r", "name": "Hall", "area_m2": 4.0}],
            "doors": [{"global_id": "d", "clear_width_from": "assumed", "clear_width_m": 0.9},
                {"global_id": "e", "clear_width_from": "lining_and_panel", "clear_width_m": 0.8}],
            "failed_geometry": [{"global_id": "f", "name": null, "drawn_as": "bounding_box"}],
            "spaces_not_mapped": [{"global_id": "s", "reason": "it is a lift shaft"}], "storeys_not_mapped": [],
        });
        let waypoints = json!({"notices": [{"code": "start_blocked", "message": "[tour] start", "element": "x"}]});
        let found = serde_json::to_value(found(report, waypoints)).unwrap();
        let codes = |kind: &str| -> Vec<String> {
            found[kind]["list"].as_array().unwrap().iter().map(|f| f["code"].as_str().unwrap().to_owned()).collect()
        };
        assert_eq!(codes("errors"), ["lost"]);
        assert_eq!(codes("warnings"), ["schedule_ignored", "unit", "start_blocked"]);
        assert_eq!(codes("assumptions"), ["assumed_floor", "assumed_clear_width"]);
        assert_eq!(codes("substitutions"), ["bounding_box"]);
        assert_eq!(codes("left_out"), ["spaces_not_mapped"]);
        let unit = json!({"code": "unit", "text": "no unit", "global_id": "w", "name": "Wall", "place": "a.ifc #7"});
        assert_eq!(found["warnings"]["list"][1], unit);
        assert_eq!(found["warnings"]["list"][2]["global_id"], "x");
        assert_eq!(found["assumptions"]["list"][1]["text"], "0.90 m");
    }

    #[test]
    fn findings_beyond_the_limit_are_counted() {
        let one = json!({"severity": "warning", "code": "unit", "message": "no unit"});
        let found = found(json!({"diagnostics": vec![one; MAX_LISTED + 3]}), json!({}));
        assert_eq!((found.warnings.n, found.warnings.list.len()), (MAX_LISTED + 3, MAX_LISTED));
    }
}
