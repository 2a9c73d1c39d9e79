//! The report of `groundplan link` for people.

use super::document::{ElementEntry, LinkReport, NearMissEntry, TaskEntry};
use diagnostics::counted;
use std::fmt::Write;

/// Most lines of a list; all are in the JSON document.
const MAX_LINES: usize = 10;

impl LinkReport {
    /// For people: counts, what fits nothing, and a table of shares.
    pub(super) fn text(&self) -> String {
        let mut out = String::new();
        // Writing to a string does not fail.
        for file in &self.files {
            let by = file.written_by.as_deref().map_or(String::new(), |by| format!(", written by {by}"));
            let _ = writeln!(out, "{}: {}{by}", file.file, counted(file.tasks, "task"));
        }
        let _ = writeln!(
            out,
            "linked: {}, {} of {}",
            counted(self.tasks.linked, "task"),
            self.elements.linked,
            counted(self.elements.all, "element"),
        );
        for rule in &self.rules {
            let name = rule.rule.as_deref().unwrap_or("table of links");
            let _ = writeln!(out, "  {name}: {}, {}", counted(rule.tasks, "task"), counted(rule.links, "link"));
        }
        list(&mut out, "tasks without elements", self.unlinked_tasks.iter().map(TaskEntry::text));
        list(&mut out, "near misses", self.near_misses.iter().map(NearMissEntry::text));
        list(&mut out, "values that are spelt alike", self.similar.iter().map(NearMissEntry::text));
        let contradictions = self.contradictions.iter().map(|found| {
            let tasks: Vec<String> = found.tasks.iter().map(TaskEntry::text).collect();
            format!("{}: {}: {}", found.element.text(), found.kind.replace('_', " "), tasks.join(" / "))
        });
        list(&mut out, "elements with contradicting tasks", contradictions);
        list(&mut out, "tasks whose effect no word tells", self.untold_effects.iter().map(TaskEntry::text));
        let rows = self.unmatched_rows.iter().map(|row| format!("line {}: {}", row.line, row.why));
        list(&mut out, "rows of the table of links that fit nothing", rows);
        list(&mut out, "elements without tasks", self.unlinked_elements.iter().map(ElementEntry::text));
        self.add_shares(&mut out);
        out
    }

    fn add_shares(&self, out: &mut String) {
        let storey = |name: &Option<String>| name.clone().unwrap_or_else(|| "(no storey)".to_owned());
        let widest = |texts: &mut dyn Iterator<Item = usize>| texts.max().unwrap_or(0).clamp(6, 60);
        let storeys = widest(&mut self.shares.iter().map(|share| storey(&share.storey).chars().count()));
        let classes = widest(&mut self.shares.iter().map(|share| share.class.chars().count()));
        let _ =
            writeln!(out, "{:storeys$}  {:classes$}  {:>8}  {:>8}  {:>5}", "storey", "class", "linked", "all", "share");
        for share in &self.shares {
            let percent = share.linked as f64 / share.all as f64 * 100.0;
            let _ = writeln!(
                out,
                "{:storeys$}  {:classes$}  {:>8}  {:>8}  {percent:>3.0} %",
                storey(&share.storey),
                share.class,
                share.linked,
                share.all
            );
        }
    }
}

/// A heading with the number of lines, and the first of them; nothing for an empty list.
fn list(out: &mut String, what: &str, lines: impl ExactSizeIterator<Item = String>) {
    let n = lines.len();
    if n == 0 {
        return;
    }
    let _ = writeln!(out, "{what}: {n}");
    for line in lines.take(MAX_LINES) {
        let _ = writeln!(out, "  {line}");
    }
    if n > MAX_LINES {
        let _ = writeln!(out, "  .. and {} more; --json lists all", n - MAX_LINES);
    }
}

impl TaskEntry {
    pub(super) fn text(&self) -> String {
        [Some(&self.task), self.name.as_ref()].into_iter().flatten().cloned().collect::<Vec<_>>().join(" ")
    }
}

impl ElementEntry {
    fn text(&self) -> String {
        let name = self.name.as_ref().map_or(String::new(), |name| format!(" {name:?}"));
        format!("{} {}{name}", self.global_id, self.class)
    }
}

impl NearMissEntry {
    fn text(&self) -> String {
        let elements = counted(self.elements, "element");
        format!("{}: task {:?}, {elements} {:?}", self.rule, self.task, self.element)
    }
}
