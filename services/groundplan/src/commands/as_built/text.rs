//! The list of changes, for people.

use as_built::{ChangeList, LineChangeKind};
use diagnostics::counted;
use std::collections::BTreeMap;
use std::fmt::Write;

/// Observations that are listed one by one.
const LISTED_MAX: usize = 20;

/// What was written, in numbers, and what was not.
pub(super) fn text(changes: &ChangeList) -> String {
    let mut kinds: BTreeMap<&str, usize> = BTreeMap::new();
    for observation in &changes.observations {
        *kinds.entry(&observation.kind).or_default() += 1;
    }
    let kinds: Vec<String> = kinds.iter().map(|(kind, n)| format!("{n} {}", kind.replace('_', " "))).collect();
    let added = changes.lines.iter().filter(|line| line.change == LineChangeKind::Added).count();
    let changed = changes.lines.len() - added;
    let (file, schema) = (&changes.as_built.file, &changes.schema);
    let lines = format!("{} changed, {added} new", counted(changed, "line"));
    let mut out = format!("{file} ({schema}): {}; {lines}\n", kinds.join(", "));
    for observation in changes.observations.iter().filter(|observation| !observation.notes.is_empty()).take(LISTED_MAX)
    {
        // Writing to a string does not fail.
        let _ = writeln!(out, "  {}: {}", observation.global_id, observation.notes.join("; "));
    }
    if !changes.not_written.is_empty() {
        out.push_str("not written");
        out.push_str(&not_written(changes));
        out.push('\n');
    }
    out
}

/// What was not written, each with its reason, behind a colon; nothing if there is nothing.
pub(super) fn not_written(changes: &ChangeList) -> String {
    let all = &changes.not_written;
    let mut out = String::from(if all.is_empty() { "" } else { ":" });
    for one in all.iter().take(LISTED_MAX) {
        let file = changes.sources.get(one.source).map_or("", |source| source.file.as_str());
        let id = one.id.as_deref().filter(|id| *id != one.row).map_or(String::new(), |id| format!(" ({id})"));
        let _ = write!(out, "\n  {file}, {}{id}: {}", one.row, one.reason);
    }
    if all.len() > LISTED_MAX {
        let _ = write!(out, "\n  and {} more: see --changes", all.len() - LISTED_MAX);
    }
    out
}
