//! List of the change instants of a schedule, each with the tasks that cause it.

use crate::named::{TaskRef, date_text};
use messages::{ElementState, Site, SpaceState};
use schedule::{Cause, Change, Timeline};
use schemars::JsonSchema;
use serde::Serialize;
use std::collections::BTreeMap;
use std::fmt::Write;

/// What `groundplan changes --json` prints.
#[derive(Debug, Serialize)]
pub struct Changes<'s> {
    change_instants: Vec<String>,
    changes: Vec<ChangeJson<'s>>,
    /// The tasks that make each change, in the same order; none where properties, rules or reports do.
    causes: Vec<Causes<'s>>,
}

/// The tasks that make a change.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Causes<'s> {
    /// When.
    pub(crate) at: String,
    /// The tasks.
    pub(crate) tasks: Vec<CauseJson<'s>>,
}

impl Causes<'_> {
    /// True if no task makes the change.
    pub fn is_empty(&self) -> bool {
        self.tasks.is_empty()
    }
}

/// A task that starts or finishes, and what changes with it.
#[derive(Debug, Serialize, JsonSchema)]
#[schemars(rename = "Cause")]
pub(crate) struct CauseJson<'s> {
    /// GlobalId.
    pub(crate) global_id: &'s str,
    /// Identification; empty if it has none.
    pub(crate) identification: &'s str,
    /// Name; empty if it has none.
    pub(crate) name: &'s str,
    /// `starts` or `finishes`.
    pub(crate) event: &'static str,
    /// GlobalIds of elements that it acts on.
    pub(crate) elements: Vec<&'s str>,
    /// GlobalIds of spaces that it closes or opens.
    pub(crate) spaces: Vec<&'s str>,
}

#[derive(Debug, Serialize)]
struct ChangeJson<'s> {
    at: String,
    elements: BTreeMap<&'s str, [&'static str; 2]>,
    spaces: BTreeMap<&'s str, [&'static str; 2]>,
}

/// The tasks that make a change.
pub fn causes_of<'s>(site: &'s Site<'_>, timeline: &Timeline, change: &Change) -> Causes<'s> {
    let cause = |cause: Cause| {
        let task = &site.schedule.tasks[cause.task as usize];
        CauseJson {
            global_id: site.schedule.text(task.global_id),
            identification: site.schedule.text(task.identification),
            name: site.schedule.text(task.name),
            event: if cause.starts { "starts" } else { "finishes" },
            elements: cause.elements.iter().map(|k| site.text(site.elements[*k as usize].global_id)).collect(),
            spaces: cause.spaces.iter().map(|k| site.text(site.spaces[*k as usize].global_id)).collect(),
        }
    };
    Causes { at: date_text(change.at_s), tasks: timeline.causes(change).into_iter().map(cause).collect() }
}

/// All changes of a schedule.
pub fn document<'s>(site: &'s Site<'_>, timeline: &Timeline, changes: &[Change]) -> Changes<'s> {
    let blocked = |b: bool| if b { SpaceState::Blocked } else { SpaceState::Open }.name();
    let change = |c: &Change| ChangeJson {
        at: date_text(c.at_s),
        elements: c
            .elements
            .iter()
            .map(|(k, before, after)| (site.text(site.elements[*k as usize].global_id), [before.name(), after.name()]))
            .collect(),
        spaces: c
            .spaces
            .iter()
            .map(|(k, before, after)| {
                (site.text(site.spaces[*k as usize].global_id), [blocked(*before), blocked(*after)])
            })
            .collect(),
    };
    Changes {
        change_instants: changes.iter().map(|c| date_text(c.at_s)).collect(),
        changes: changes.iter().map(change).collect(),
        causes: changes.iter().map(|change| causes_of(site, timeline, change)).collect(),
    }
}

/// For people: a line per instant.
pub fn text(site: &Site<'_>, timeline: &Timeline, changes: &[Change]) -> String {
    let mut out = String::new();
    for change in changes {
        let mut kinds: BTreeMap<&'static str, usize> = BTreeMap::new();
        for (_, _, after) in &change.elements {
            let word = match after {
                ElementState::NotStarted => "not started",
                ElementState::InProgress => "begun",
                ElementState::Built => "built",
                ElementState::BeingRemoved => "being removed",
                ElementState::Removed => "removed",
            };
            *kinds.entry(word).or_default() += 1;
        }
        let mut parts: Vec<String> = kinds.into_iter().map(|(word, n)| format!("{n} {word}")).collect();
        for (word, wanted) in [("blocked", true), ("opened", false)] {
            let spaces = change.spaces.iter().filter(|(_, _, after)| *after == wanted);
            let names: Vec<&str> = spaces.map(|(k, _, _)| site.text(site.spaces[*k as usize].name)).collect();
            if !names.is_empty() {
                parts.push(format!("{word}: {}", names.join(", ")));
            }
        }
        let _ = writeln!(out, "{}  {}", date_text(change.at_s), parts.join("; "));
        for cause in timeline.causes(change) {
            let event = if cause.starts { "start of" } else { "finish of" };
            let _ = writeln!(out, "    {event} {}", TaskRef::of(site, cause.task as usize).label());
        }
    }
    if changes.is_empty() {
        out.push_str("nothing of the model has a date, so nothing ever changes\n");
    }
    out
}
