//! `dates/KEY.json`: states, maps, waypoints and ways at a date.

use crate::source::ContentName;
use messages::{ElementState, SpaceState};
use serde::Serialize;
use serde_json::{Map, Value, json};
use std::collections::BTreeMap;

/// The document.
#[derive(Debug, Serialize)]
pub(crate) struct DateDocument {
    #[serde(flatten)]
    head: DateHead,
    /// States of elements that are not built.
    elements: BTreeMap<String, Value>,
    /// State of each space, why no way leads there, and what robots get there.
    spaces: Map<String, Value>,
    /// How doors can be passed, by storey.
    passages: BTreeMap<String, Value>,
    /// Closed doors with their reasons.
    doors: Value,
    waypoints: Value,
    /// The mission as a whole.
    mission: Map<String, Value>,
    /// How the robot comes to each storey, by its index.
    entries: BTreeMap<String, Value>,
    graph: Value,
}

/// What a manifest says of a date.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct DateHead {
    /// Names the document.
    pub(crate) key: String,
    /// Plan time; `None` where everything is built.
    pub(crate) at: Option<String>,
    /// The next change.
    pub(crate) until: Option<String>,
    /// The storeys that have maps.
    pub(crate) storeys: Vec<StoreyAtDate>,
    /// What stands, as a model.
    pub(crate) model: Option<ContentName>,
}

/// A storey at a date.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct StoreyAtDate {
    pub(crate) index: u32,
    /// Whether there is floor to drive on.
    pub(crate) status: String,
    /// Its layers by name.
    pub(crate) layers: BTreeMap<&'static str, ContentName>,
}

/// The documents of a date that robots get, as they are published.
#[derive(Debug, Default)]
pub(crate) struct Published {
    pub(crate) semantic: Value,
    pub(crate) waypoints: Value,
    pub(crate) site_graph: Value,
    pub(crate) report: Value,
}

impl DateDocument {
    /// Of what is published at a date.
    pub(crate) fn of(head: DateHead, published: Published) -> Self {
        let Published { semantic, mut waypoints, mut site_graph, mut report } = published;
        let (mut elements, mut passages) = (BTreeMap::new(), BTreeMap::new());
        for (id, element) in entries(&semantic, "elements") {
            let state = element_state(element);
            if state != ElementState::Built.name() {
                elements.insert(id.clone(), Value::from(state));
            }
            if let Some(passage) = element["attributes"].get("passage") {
                passages.insert(id.clone(), passage.clone());
            }
        }
        let mut spaces = Map::new();
        for (id, space) in entries(&semantic, "spaces") {
            let of_mission = &waypoints["spaces"][id];
            let value = json!({
                "state": space_state(space, of_mission), "why": space["why"], "no_way": of_mission["access_reason"],
                "coverage": of_mission["coverage"], "reason": of_mission["reason"], "door": of_mission["door"],
            });
            spaces.insert(id.clone(), value);
        }
        let outcomes = waypoints["storeys"].as_array().into_iter().flatten();
        let entries = outcomes.map(|storey| (storey["storey"].to_string(), storey["entry"].clone())).collect();
        let of_mission =
            ["coverage", "coverage_goal", "curve", "scans", "connecting_scans", "mission_s", "driving_s", "scanning_s"];
        Self {
            head,
            elements,
            spaces,
            passages,
            doors: report["doors"].take(),
            mission: of_mission.map(|key| (key.to_owned(), waypoints[key].take())).into_iter().collect(),
            entries,
            waypoints: waypoints["waypoints"].take(),
            graph: json!({"nodes": site_graph["nodes"].take(), "edges": site_graph["edges"].take()}),
        }
    }
}

/// The state of an element of `semantic.json`: without a plan time everything is built.
pub(super) fn element_state(element: &Value) -> &str {
    element["schedule"]["state"].as_str().unwrap_or(ElementState::Built.name())
}

/// The state of a space of `semantic.json` for the robot, with its outcome in `waypoints.json`.
pub(super) fn space_state<'a>(space: &'a Value, of_mission: &'a Value) -> &'a str {
    let by_schedule = space["state"].as_str().unwrap_or(SpaceState::Open.name());
    answers::state_for_robot(by_schedule, of_mission["access"].as_str())
}

/// The entries of an object in a document.
pub(super) fn entries<'a>(document: &'a Value, key: &str) -> impl Iterator<Item = (&'a String, &'a Value)> + use<'a> {
    document.get(key).and_then(Value::as_object).into_iter().flatten()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_is_not_built_is_listed_and_a_closed_room_names_its_door() {
        let head = DateHead { key: "3".into(), at: None, until: None, storeys: Vec::new(), model: None };
        let element = |state: &str| json!({"schedule": {"state": state}, "attributes": {"passage": {"0": state}}});
        let published = Published {
            semantic: json!({"elements": {"a": element("built"), "b": element("in_progress"), "c": {"schedule": {}}},
                "spaces": {"s": {"state": "blocked", "why": ["private"]}, "t": {"state": "open", "why": []},
                    "u": {"state": "open", "why": []}, "v": {"state": "open", "why": []}}}),
            waypoints: json!({"waypoints": [{"id": 0}], "coverage": 0.5, "storeys": [{"storey": 2, "entry": "placed"}],
                "spaces": {"s": {"coverage": null, "reason": "it is closed", "door": "b", "access": "closed"},
                    "u": {"access": "no_way", "access_reason": "its door b is closed"}, "v": {"access": "reached"}}}),
            site_graph: json!({"nodes": [1], "edges": []}),
            report: json!({"doors": [{"global_id": "b"}]}),
        };
        let document = serde_json::to_value(DateDocument::of(head, published)).unwrap();
        assert_eq!(document["elements"], json!({"b": "in_progress"}));
        assert_eq!(document["passages"], json!({"a": {"0": "built"}, "b": {"0": "in_progress"}}));
        assert_eq!(document["spaces"]["s"]["door"], "b");
        assert_eq!(
            document["spaces"]["t"],
            json!({"state": "open", "why": [], "no_way": null, "coverage": null, "reason": null, "door": null})
        );
        let states = ["s", "t", "u", "v"].map(|space| document["spaces"][space]["state"].as_str().unwrap().to_owned());
        assert_eq!(states, ["blocked", "open", "no_way", "reached"]);
        assert_eq!(document["spaces"]["u"]["no_way"], "its door b is closed");
        assert_eq!(document["entries"], json!({"2": "placed"}));
        assert_eq!((&document["doors"][0]["global_id"], &document["graph"]["nodes"]), (&json!("b"), &json!([1])));
        assert_eq!((&document["mission"]["coverage"], &document["waypoints"][0]["id"]), (&json!(0.5), &json!(0)));
    }
}
