//! A door for people.

use crate::door::DoorAnswer;
use crate::named::label;
use std::fmt::Write;

impl DoorAnswer {
    /// For people.
    pub fn text(&self) -> String {
        let mut out = String::new();
        let storey = self
            .storey
            .as_ref()
            .map_or("on no map storey".to_owned(), |storey| format!("storey {} {:?}", storey.index, storey.name));
        let [x_m, y_m] = self.at_m;
        // Writing to a string does not fail.
        let _ = writeln!(out, "{} {}", self.door.ifc_type, label(self.door.name.as_deref(), &self.door.global_id));
        let _ = writeln!(out, "  {storey}, at x {x_m:.2} m, y {y_m:.2} m");
        for side in &self.rooms {
            let _ = writeln!(out, "  leads to {} ({}): {}", side.room.label(), side.room.global_id, side.state);
        }
        let operation = self.operation.as_deref().unwrap_or("unknown operation");
        let assumed = if self.clear_width_from == "assumed" { " (assumed)" } else { "" };
        let _ = writeln!(
            out,
            "  {}; {operation}, clear width {:.2} m{assumed}, this robot needs {:.2} m",
            self.state.replace('_', " "),
            self.clear_width_m,
            self.needed_width_m
        );
        for (what, at) in [("hung", &self.built_at), ("removed", &self.removed_at)] {
            if let Some(at) = at {
                let _ = writeln!(out, "  {what} by the schedule at {at}");
            }
        }
        let reasons: Vec<&str> = self.reasons.iter().map(|reason| reason.text.as_str()).collect();
        let _ = match self.can_pass {
            Some(true) if reasons.is_empty() => writeln!(out, "  this robot can pass it"),
            Some(true) => writeln!(out, "  {}: this robot can pass its opening", reasons.join("; ")),
            Some(false) => writeln!(out, "  this robot cannot pass it: {}", reasons.join("; ")),
            None => writeln!(out, "  whether this robot can pass is not known: {}", reasons.join("; ")),
        };
        if self.can_pass == Some(true) && self.sides_with_floor.is_some_and(|sides| sides < 2) {
            out.push_str("  there is floor on one of its sides only\n");
        }
        if let Some(changes) = &self.changes {
            let other = if self.can_pass == Some(true) { "it cannot be passed" } else { "it can be passed" };
            let _ = writeln!(out, "  {}", changes.text(other));
        }
        for task in self.tasks.iter().flatten() {
            let _ = writeln!(out, "  {}", task.line());
        }
        for finding in &self.findings {
            let _ = writeln!(out, "  {}", finding.line());
        }
        let _ = writeln!(out, "{}", self.circumstances);
        out
    }
}
