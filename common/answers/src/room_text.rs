//! A room for people.

use crate::room::{DoorOfRoom, RoomAnswer, RoomPeriod};
use messages::DoorPassage;
use std::fmt::Write;

impl RoomAnswer {
    /// For people.
    pub fn text(&self) -> String {
        let mut out = String::new();
        let storey = self.storey.as_ref().map_or("on no map storey".to_owned(), |storey| {
            format!("storey {} {:?}, floor at {:.2} m", storey.index, storey.name, storey.floor_z_m)
        });
        let [x_m, y_m] = self.centroid_m;
        // Writing to a string does not fail.
        let _ = writeln!(out, "{} ({})", self.room.label(), self.room.global_id);
        let _ = writeln!(out, "  {storey}; {:.1} m2 around x {x_m:.2} m, y {y_m:.2} m", self.area_m2);
        let may = match self.may_enter {
            Some(true) => "this robot may enter it",
            Some(false) => "this robot may not enter it",
            None => "whether this robot may enter it is not known",
        };
        let why = self.why_not.as_ref().map_or(String::new(), |why| format!(": {why}"));
        let _ = writeln!(out, "  {may}{why}");
        if let Some(changes) = &self.changes {
            let other = if self.may_enter == Some(true) { "it may not be entered" } else { "it may be entered" };
            let _ = writeln!(out, "  {}", changes.text(other));
        }
        for period in self.periods.iter().flatten() {
            let _ = writeln!(out, "  {}", period.line());
        }
        for door in &self.doors {
            let _ = writeln!(out, "  {}", door.line());
        }
        if !self.scans.is_empty() {
            let _ = writeln!(out, "  scans: {}", self.scans.len());
        }
        for scan in &self.scans {
            let [x_m, y_m, z_m] = scan.at_m;
            let _ = writeln!(out, "    waypoint {} at x {x_m:.2} m, y {y_m:.2} m, z {z_m:.2} m", scan.id);
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

impl RoomPeriod {
    fn line(&self) -> String {
        let when = match (&self.from, &self.until) {
            (None, None) => "at all times".to_owned(),
            (None, Some(until)) => format!("until {until}"),
            (Some(from), None) => format!("from {from} on"),
            (Some(from), Some(until)) => format!("from {from} until {until}"),
        };
        let why: Vec<String> = self.closed_by.iter().map(|why| why.text()).collect();
        let why = if why.is_empty() { String::new() } else { format!(": {}", why.join("; ")) };
        format!("{} by the schedule {when}{why}", self.state)
    }
}

impl DoorOfRoom {
    fn line(&self) -> String {
        let to = self.leads_to.as_ref().map_or(String::new(), |room| format!(" to {}", room.label()));
        let passage = match (self.can_pass, self.passage) {
            (Some(true), Some(passage)) if passage == DoorPassage::Absent.name() => {
                "it does not hang yet, this robot can pass the opening".to_owned()
            }
            (Some(true), _) => "this robot can pass it".to_owned(),
            (Some(false), passage) => {
                format!("closed to this robot: {}", passage.unwrap_or_default().replace('_', " "))
            }
            (None, Some(_)) => "it does not hang".to_owned(),
            (None, None) => "it is on no map".to_owned(),
        };
        format!("door {}{to}: {passage}", self.element.label())
    }
}
