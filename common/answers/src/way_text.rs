//! The way from a place to another for people.

use crate::named::label;
use crate::way::{DoorOnWay, WayAnswer, WayLegAnswer};
use std::fmt::Write;

impl WayAnswer {
    /// For people: a line for each leg, or for each thing that is missing.
    pub fn text(&self) -> String {
        let mut out = String::new();
        let (from, to) = (self.from.label(), self.to.label());
        // Writing to a string does not fail.
        let _ = match self.length_m {
            Some(length_m) => {
                let heights = heights(self.climb_m.unwrap_or(0.0), self.descent_m.unwrap_or(0.0));
                writeln!(out, "way from {from} to {to}: {length_m:.1} m{heights}{}", self.costs())
            }
            None => writeln!(out, "no way from {from} to {to}"),
        };
        for leg in &self.legs {
            let _ = writeln!(out, "  {}", leg.line());
        }
        for missing in &self.missing {
            let _ = writeln!(out, "  {}", missing.line());
        }
        if !self.exists && self.missing.is_empty() {
            out.push_str(
                "  no door or room that is closed, and no stair, ramp or lift before which this robot can stand, leads there\n",
            );
        }
        if let Some(changes) = &self.changes {
            let _ = writeln!(out, "  {}", changes.text("there is a way"));
        }
        let _ = writeln!(out, "{}", self.circumstances);
        out
    }

    fn costs(&self) -> String {
        let Some(duration_s) = self.duration_s else { return String::new() };
        let energy = self.energy_wh.map_or(String::new(), |energy_wh| format!(", {energy_wh:.1} Wh"));
        let chosen = match self.chosen_by {
            Some("time") => ", the fastest way",
            Some("energy") => ", the way of least energy",
            _ => "",
        };
        format!(", {duration_s:.0} s{energy}{chosen}")
    }
}

impl WayLegAnswer {
    fn line(&self) -> String {
        if self.kind == "floor" {
            let mut parts = vec![format!("{:6.1} m over floor of storey {}", self.length_m, self.storey)];
            if !self.rooms.is_empty() {
                let rooms: Vec<&str> = self.rooms.iter().map(|room| room.label()).collect();
                parts.push(format!("through {}", rooms.join(", ")));
            }
            if !self.doors.is_empty() {
                let doors: Vec<String> = self.doors.iter().map(DoorOnWay::label).collect();
                parts.push(format!("doors {}", doors.join(", ")));
            }
            if self.slope_rad > 0.0 {
                let heights = heights(self.climb_m, self.descent_m);
                parts.push(format!("slope at most {:.0} %{heights}", 100.0 * libm::tan(self.slope_rad)));
            }
            return parts.join("; ");
        }
        if self.kind == "ground" {
            return format!("         here on to the map of storey {}", self.to_storey);
        }
        let named = self.element.as_ref().map_or(String::new(), |element| format!(" {}", element.label()));
        format!("{:6.1} m {}{named} to storey {}", self.length_m, self.kind, self.to_storey)
    }
}

/// Rises and falls, if there are any of at least a centimetre.
fn heights(climb_m: f64, descent_m: f64) -> String {
    let part = |m: f64, word: &str| if m < 0.01 { String::new() } else { format!(", {m:.1} m {word}") };
    format!("{}{}", part(climb_m, "up"), part(descent_m, "down"))
}

impl DoorOnWay {
    fn label(&self) -> String {
        let hung = if self.is_hung { "" } else { ", not hung yet" };
        format!("{}{hung}", label(self.element.name.as_deref(), &self.element.global_id))
    }
}
