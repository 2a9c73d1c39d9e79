//! `calendar.json`: from which date on each element and space has which state.

use super::date::{element_state, entries, space_state};
use serde::Serialize;
use serde_json::Value;
use std::collections::BTreeMap;

/// The document. A list has the first state and every change, each with the number of its date.
#[derive(Debug, Default, Serialize)]
pub(crate) struct Calendar {
    elements: BTreeMap<String, Vec<(usize, String)>>,
    spaces: BTreeMap<String, Vec<(usize, String)>>,
}

impl Calendar {
    /// Adds `semantic.json` and `waypoints.json` at the next date; dates come in their order.
    pub(crate) fn add(&mut self, date: usize, semantic: &Value, waypoints: &Value) {
        for (id, element) in entries(semantic, "elements") {
            self.add_element(date, id, element_state(element));
        }
        for (id, space) in entries(semantic, "spaces") {
            self.add_space(date, id, space_state(space, &waypoints["spaces"][id]));
        }
    }

    /// Adds the state of an element at the next date.
    pub(crate) fn add_element(&mut self, date: usize, global_id: &str, state: &str) {
        add(&mut self.elements, date, global_id, state);
    }

    /// Adds the state of a space at the next date.
    pub(crate) fn add_space(&mut self, date: usize, global_id: &str, state: &str) {
        add(&mut self.spaces, date, global_id, state);
    }
}

fn add(list: &mut BTreeMap<String, Vec<(usize, String)>>, date: usize, id: &str, state: &str) {
    let states = match list.get_mut(id) {
        Some(states) => states,
        None => list.entry(id.to_owned()).or_default(),
    };
    if states.last().is_none_or(|(_, last)| last != state) {
        states.push((date, state.to_owned()));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn only_changes_are_listed() {
        let mut calendar = Calendar::default();
        for (date, (element, space, access)) in [
            ("not_started", "blocked", "closed"),
            ("built", "blocked", "closed"),
            ("built", "open", "no_way"),
            ("built", "open", "reached"),
        ]
        .into_iter()
        .enumerate()
        {
            let semantic =
                json!({"elements": {"a": {"schedule": {"state": element}}}, "spaces": {"s": {"state": space}}});
            calendar.add(date, &semantic, &json!({"spaces": {"s": {"access": access}}}));
        }
        let expected = json!({"elements": {"a": [[0, "not_started"], [1, "built"]]}, "spaces": {"s": [[0, "blocked"], [2, "no_way"], [3, "reached"]]}});
        assert_eq!(serde_json::to_value(calendar).unwrap(), expected);
    }
}
