//! A check for people: one page of text.

use crate::document::{Issue, IssueElement, ModelCheck};
use diagnostics::counted;
use std::fmt::Write;

/// Elements of an issue that are named on the page; programs get more.
const MAX_NAMED: usize = 6;
/// Columns of the page.
const COLUMNS: usize = 110;

impl ModelCheck {
    /// The verdict in a sentence.
    pub fn verdict(&self) -> String {
        let robot = format!("robot {}, radius {:.2} m", self.circumstances.robot, self.circumstances.robot_radius_m);
        let wrong = self.issues.iter().filter(|issue| issue.kind == "maps").count();
        match (wrong, self.issues.len()) {
            (0, 0) => format!("fit: nothing was found that is wrong for {robot}"),
            (0, n) => format!("fit: no map is wrong for {robot}; {} in the data", counted(n, "issue")),
            (wrong, _) => format!("not fit: maps are wrong for {robot}: {}", counted(wrong, "issue")),
        }
    }

    /// What the model holds, in a line.
    pub fn figures_line(&self) -> String {
        let m = &self.model;
        let closed =
            if m.closed_doors > 0 { format!(", {} closed to the robot", m.closed_doors) } else { String::new() };
        let unreachable =
            if m.unreachable_rooms > 0 { format!(", {} unreachable", m.unreachable_rooms) } else { String::new() };
        format!(
            "{}, {}{closed}, {}{unreachable}; the robot gets to {:.0} of {:.0} m2",
            counted(m.storeys, "storey"),
            counted(m.doors, "door"),
            counted(m.rooms, "room"),
            m.reached_m2,
            m.standing_m2
        )
    }

    /// For people.
    pub fn text(&self) -> String {
        let mut out = String::new();
        // Writing to a string does not fail.
        let _ = writeln!(out, "{}", self.verdict());
        let _ = writeln!(out, "{}", self.circumstances);
        let _ = writeln!(out, "{}", self.figures_line());
        let mut number = 0;
        let sections = [
            ("wrong on maps", self.issues.iter().filter(|issue| issue.kind == "maps").collect::<Vec<_>>()),
            (
                "wrong or missing in the data, maps are right",
                self.issues.iter().filter(|issue| issue.kind == "data").collect(),
            ),
            ("no fault of the model: what this robot cannot pass", self.building.iter().collect()),
        ];
        for (heading, issues) in sections.into_iter().filter(|(_, issues)| !issues.is_empty()) {
            let _ = writeln!(out, "\n{heading}");
            for issue in issues {
                number += 1;
                write_issue(&mut out, number, issue);
            }
        }
        let _ = writeln!(out);
        for not in &self.not_checked {
            let _ = writeln!(out, "not checked: {}: {}", not.what, not.why);
        }
        out
    }
}

fn write_issue(out: &mut String, number: usize, issue: &Issue) {
    let _ = writeln!(out, "{number:3}. {} [{}]", issue.title, issue.code);
    for element in issue.elements.iter().take(MAX_NAMED) {
        let _ = writeln!(out, "       {}", element.line());
    }
    if issue.n > MAX_NAMED {
        let _ = writeln!(out, "       and {} more", issue.n - MAX_NAMED);
    }
    let rooms: Vec<&str> = issue.effect.rooms.iter().filter(|room| room.unreachable).map(|room| room.label()).collect();
    if !rooms.is_empty() {
        let more =
            if rooms.len() > MAX_NAMED { format!(" and {} more", rooms.len() - MAX_NAMED) } else { String::new() };
        wrapped(out, &format!("unreachable: {}{more}", rooms[..rooms.len().min(MAX_NAMED)].join(", ")));
    }
    wrapped(out, issue.cause);
    wrapped(out, issue.advice);
}

/// A sentence in lines of the page.
fn wrapped(out: &mut String, text: &str) {
    let mut line = String::from("     ");
    for word in text.split(' ') {
        if line.len() + 1 + word.len() > COLUMNS {
            let _ = writeln!(out, "{line}");
            line = String::from("     ");
        }
        line.push_str(if line.trim().is_empty() { "" } else { " " });
        line.push_str(word);
    }
    let _ = writeln!(out, "{line}");
}

impl IssueElement {
    /// What it is, where, and what is wrong with it.
    pub fn line(&self) -> String {
        let named = match (&self.name, self.global_id.as_str()) {
            (Some(name), "") => name.clone(),
            (Some(name), id) => format!("{name} ({id})"),
            (None, id) => id.to_owned(),
        };
        let mut line =
            [self.ifc_type.as_str(), &named].into_iter().filter(|w| !w.is_empty()).collect::<Vec<_>>().join(" ");
        if let Some(storey) = &self.storey {
            line += &format!(", {storey}");
        }
        if !self.text.is_empty() {
            line += &format!(": {}", self.text);
        }
        line
    }
}

impl crate::document::AffectedRoom {
    /// Its name, else its GlobalId.
    pub fn label(&self) -> &str {
        self.name.as_deref().unwrap_or(&self.global_id)
    }
}
