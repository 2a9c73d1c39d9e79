//! The list of tasks for people: a line per task, and what it acts on.

use super::list::{TaskEntry, TaskList};
use schedule::Timeline;
use std::fmt::Write;

/// Names of elements or spaces in a line; all are in the JSON document.
const MAX_NAMED: usize = 3;

impl TaskList<'_> {
    /// For people: a line per task, and what it acts on.
    pub fn text(&self, timeline: &Timeline, is_without_tasks: bool) -> String {
        if is_without_tasks {
            let why =
                if timeline.instants_s().is_empty() { "nothing has a date" } else { "dates are those of properties" };
            return format!("the model has no task: {why}\n");
        }
        let name = |t: &TaskEntry<'_>| {
            let words = [t.identification, t.name].into_iter().flatten().collect::<Vec<_>>().join(" ");
            let words = if words.is_empty() { t.global_id.to_owned() } else { words };
            format!("{}{words}", "  ".repeat(t.depth))
        };
        let width = self.tasks.iter().map(|t| name(t).chars().count()).max().unwrap_or(0).clamp(4, 60);
        let mut out = format!("{:width$}  {:19}  {:19}  acts on\n", "task", "start", "finish");
        for task in &self.tasks {
            let date = |date: &Option<String>| date.clone().unwrap_or_else(|| "no date".to_owned());
            let targets = if task.is_summary { "what its nested tasks act on".to_owned() } else { task.targets() };
            let status = task.status.map_or(String::new(), |s| format!("{}; ", s.replace('_', " ")));
            // Writing to a string does not fail.
            let _ = writeln!(
                out,
                "{:width$}  {:19}  {:19}  {status}{}",
                name(task),
                date(&task.start),
                date(&task.finish),
                targets
            );
            for warning in &task.warnings {
                let _ = writeln!(out, "  {}: {}: {}", warning.severity, warning.code, warning.message);
            }
        }
        out
    }
}

impl TaskEntry<'_> {
    /// Elements by what is done to them, and spaces; the first names of each.
    fn targets(&self) -> String {
        let mut parts: Vec<String> = Vec::new();
        for (word, operation) in [("builds", "constructs"), ("removes", "removes"), ("works on", "no_effect")] {
            let of_kind = self.elements.iter().filter(|e| e.operation == operation);
            let names: Vec<&str> = of_kind.map(|e| e.name.unwrap_or(e.global_id)).collect();
            if !names.is_empty() {
                parts.push(format!("{word} {}", bounded(&names)));
            }
        }
        let spaces: Vec<&str> = self.spaces.iter().map(|s| s.name.or(s.long_name).unwrap_or(s.global_id)).collect();
        if !spaces.is_empty() {
            parts.push(format!("in {}", bounded(&spaces)));
        }
        if parts.is_empty() { "nothing".to_owned() } else { parts.join("; ") }
    }
}

/// The first names, and the number of the others.
fn bounded(names: &[&str]) -> String {
    let first = names.iter().take(MAX_NAMED).copied().collect::<Vec<_>>().join(", ");
    match names.len().saturating_sub(MAX_NAMED) {
        0 => first,
        n => format!("{first} and {n} more"),
    }
}
