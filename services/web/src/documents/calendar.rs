//! `calendar.json` of an output folder: the calendar of the dates that it holds.

use super::date::{element_state, entries, space_state};
use answers::changes::Calendar;
use serde_json::Value;

/// Adds `semantic.json` and `waypoints.json` at the next date; dates come in their order.
pub(crate) fn add_date(calendar: &mut Calendar, date: usize, semantic: &Value, waypoints: &Value) {
    for (id, element) in entries(semantic, "elements") {
        calendar.add_element(date, id, element_state(element));
    }
    for (id, space) in entries(semantic, "spaces") {
        calendar.add_space(date, id, space_state(space, &waypoints["spaces"][id]));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn a_date_has_the_states_of_its_documents() {
        let mut calendar = Calendar::default();
        for (date, (state, access)) in [("blocked", "closed"), ("open", "no_way")].into_iter().enumerate() {
            let semantic =
                json!({"elements": {"a": {"schedule": {"state": "built"}}}, "spaces": {"s": {"state": state}}});
            add_date(&mut calendar, date, &semantic, &json!({"spaces": {"s": {"access": access}}}));
        }
        let expected = json!({"elements": {"a": [[0, "built"]]}, "spaces": {"s": [[0, "blocked"], [1, "no_way"]]}});
        assert_eq!(serde_json::to_value(calendar).unwrap(), expected);
    }
}
