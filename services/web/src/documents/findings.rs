//! Findings of a conversion for the page: what the report warns of, assumes, replaces and leaves out, each with what it is about.

use serde::Serialize;
use serde_json::Value;

/// Findings of one kind that are listed; the rest is counted.
const MAX_LISTED: usize = 500;

/// What was found, by kind.
#[derive(Debug, Default, Serialize)]
pub(crate) struct Findings {
    errors: Listed,
    warnings: Listed,
    /// Floors and widths that the model does not give.
    assumptions: Listed,
    /// Boxes in place of bodies that could not be made.
    substitutions: Listed,
    /// Rooms and storeys on no map.
    left_out: Listed,
}

/// Findings of one kind.
#[derive(Debug, Default, Serialize)]
struct Listed {
    /// How many there are, listed or not.
    n: usize,
    list: Vec<Finding>,
}

/// A finding.
#[derive(Debug, Serialize)]
struct Finding {
    /// Stable code.
    code: String,
    /// One sentence; null where the code says all.
    text: Option<String>,
    /// GlobalId of the element, space or task that it is about.
    global_id: Option<String>,
    /// Its name.
    name: Option<String>,
    /// The file, or the STEP id of the entity, where it has no GlobalId.
    place: Option<String>,
}

impl Listed {
    fn add(&mut self, code: &str, text: Option<&str>, of: &Value) {
        self.n += 1;
        if self.list.len() < MAX_LISTED {
            let field = |key: &str| of[key].as_str().map(str::to_owned);
            let place: Vec<String> = [field("file"), field("entity")].into_iter().flatten().collect();
            self.list.push(Finding {
                code: code.to_owned(),
                text: text.map(str::to_owned),
                global_id: field("global_id").or_else(|| field("element")),
                name: field("name"),
                place: (!place.is_empty()).then(|| place.join(" ")),
            });
        }
    }
}

impl Findings {
    /// Of `report.json` and `waypoints.json`.
    pub(crate) fn of(report: &Value, waypoints: &Value) -> Self {
        let mut findings = Self::default();
        let list = |key: &str| report[key].as_array().into_iter().flatten();
        let message = |of: &Value| of["message"].as_str().map(str::to_owned);
        if report["schedule_ignored"] == true {
            findings.warnings.add("schedule_ignored", None, &Value::Null);
        }
        for diagnostic in list("diagnostics") {
            let kind = match diagnostic["severity"].as_str() {
                Some("error") => &mut findings.errors,
                Some("warning") => &mut findings.warnings,
                _ => continue,
            };
            kind.add(diagnostic["code"].as_str().unwrap_or_default(), message(diagnostic).as_deref(), diagnostic);
        }
        for notice in waypoints["notices"].as_array().into_iter().flatten() {
            let code = notice["code"].as_str().unwrap_or_default();
            findings.warnings.add(code, message(notice).as_deref(), notice);
        }
        for room in list("assumed_rooms") {
            findings.assumptions.add("assumed_floor", None, room);
        }
        for door in list("doors").filter(|door| door["clear_width_from"] == "assumed") {
            let text = door["clear_width_m"].as_f64().map(|width_m| format!("{width_m:.2} m"));
            findings.assumptions.add("assumed_clear_width", text.as_deref(), door);
        }
        for element in list("failed_geometry") {
            findings.substitutions.add(element["drawn_as"].as_str().unwrap_or_default(), None, element);
        }
        for key in ["spaces_not_mapped", "storeys_not_mapped"] {
            list(key).for_each(|of| findings.left_out.add(key, of["reason"].as_str(), of));
        }
        findings
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

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
        let waypoints = json!({"notices": [{"code": "start_blocked", "message": "[tour] start", "element": null}]});
        let found = serde_json::to_value(Findings::of(&report, &waypoints)).unwrap();
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
        assert_eq!(found["assumptions"]["list"][1]["text"], "0.90 m");
    }

    #[test]
    fn findings_beyond_the_limit_are_counted() {
        let one = json!({"severity": "warning", "code": "unit", "message": "no unit"});
        let report = json!({"diagnostics": vec![one; MAX_LISTED + 3]});
        let found = Findings::of(&report, &Value::Null);
        assert_eq!((found.warnings.n, found.warnings.list.len()), (MAX_LISTED + 3, MAX_LISTED));
    }
}
