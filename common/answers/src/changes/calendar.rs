//! Calendar: from which date on each element and space has which state.

use messages::{Site, SpaceState};
use schedule::Timeline;
use serde::Serialize;
use std::collections::BTreeMap;

/// The calendar of some dates. A list has the first state and every change, each with the number of its date.
#[derive(Debug, Default, Serialize)]
pub struct Calendar {
    elements: BTreeMap<String, Vec<(usize, String)>>,
    spaces: BTreeMap<String, Vec<(usize, String)>>,
}

impl Calendar {
    /// Of all change instants of a schedule. Spaces are `open` or `blocked` by the schedule: whether a robot gets there is a matter of
    /// maps, which there are none of.
    pub fn of_schedule(site: &Site<'_>, timeline: &Timeline) -> Self {
        let mut calendar = Self::default();
        for (date, at_s) in timeline.instants_s().iter().enumerate() {
            for (number, record) in site.elements.iter().enumerate() {
                calendar.add_element(date, site.text(record.global_id), timeline.element(number, *at_s).name());
            }
            for (number, record) in site.spaces.iter().enumerate() {
                let is_blocked = timeline.is_blocked(number, *at_s);
                let state = if is_blocked { SpaceState::Blocked } else { SpaceState::Open };
                calendar.add_space(date, site.text(record.global_id), state.name());
            }
        }
        calendar
    }

    /// Adds the state of an element at the next date; dates come in their order.
    pub fn add_element(&mut self, date: usize, global_id: &str, state: &str) {
        add(&mut self.elements, date, global_id, state);
    }

    /// Adds the state of a space at the next date; dates come in their order.
    pub fn add_space(&mut self, date: usize, global_id: &str, state: &str) {
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

    #[test]
    fn only_changes_are_listed() {
        let mut calendar = Calendar::default();
        for (date, (element, space)) in
            [("not_started", "blocked"), ("built", "blocked"), ("built", "no_way"), ("built", "reached")]
                .into_iter()
                .enumerate()
        {
            calendar.add_element(date, "a", element);
            calendar.add_space(date, "s", space);
        }
        let expected = serde_json::json!({"elements": {"a": [[0, "not_started"], [1, "built"]]},
            "spaces": {"s": [[0, "blocked"], [2, "no_way"], [3, "reached"]]}});
        assert_eq!(serde_json::to_value(calendar).unwrap(), expected);
    }
}
