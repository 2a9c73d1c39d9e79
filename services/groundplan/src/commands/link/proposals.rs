//! What `groundplan link --propose` prints: rules that fit, with the counts that speak for them, and what is not proposed.

use super::document::TaskEntry;
use crate::args::ScheduleInput;
use ::tasks::{NotProposed, Proposal, WhyNot, propose};
use diagnostics::counted;
use messages::Site;
use schemars::JsonSchema;
use serde::Serialize;
use std::fmt::Write;

/// Tasks that are named in a comment; the JSON document has all.
const MAX_NAMED: usize = 5;

/// The JSON document of `groundplan link --propose`.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct ProposalReport {
    /// How many pairs of a value of elements and one of tasks were compared.
    compared: usize,
    /// Bits that shared texts have to count for: 20, and those that tell the compared pairs apart.
    needed_bits: f64,
    /// Number of tasks that are work: no summaries, milestones or spans, and not switched off.
    work: usize,
    /// All proposed rules as TOML; empty without any.
    toml: String,
    /// Links of all proposed rules together, in their order.
    links: usize,
    /// The rules, best first.
    proposals: Vec<ProposalEntry>,
    /// What looked alike and is not proposed.
    not_proposed: Vec<NotProposedEntry>,
}

/// A proposed rule.
#[derive(Debug, Serialize, JsonSchema)]
struct ProposalEntry {
    /// What is equal.
    what: String,
    /// The rule as `[[link]]`.
    toml: String,
    /// Links of this rule alone.
    links: usize,
    /// Tasks in them.
    tasks: usize,
    /// Tasks in them that are work.
    work: usize,
    /// Elements and spaces in them.
    targets: usize,
    /// Elements and spaces in them that no proposal before it names.
    new_targets: usize,
    /// Elements and spaces that have the value.
    with_value: usize,
    /// Those of them that name a task by it.
    named: usize,
    /// Those of them that differ from a task's value in spaces, signs, leading zeros or what follows a sign.
    near: usize,
    /// Texts that tasks and elements share.
    shared: usize,
    /// What these count for.
    evidence_bits: f64,
    /// Some of them.
    examples: Vec<ExampleEntry>,
    /// Tasks that are work and stay without elements.
    unlinked: Vec<TaskEntry>,
    /// Linked tasks whose names have words of another effect than building, which the rule says.
    other_effects: usize,
}

/// A text that tasks and elements share.
#[derive(Debug, Serialize, JsonSchema)]
struct ExampleEntry {
    /// The text, in lower case.
    text: String,
    /// Tasks with it.
    tasks: usize,
    /// Elements and spaces with it.
    targets: usize,
}

/// An equality that is not proposed.
#[derive(Debug, Serialize, JsonSchema)]
struct NotProposedEntry {
    /// What is equal.
    what: String,
    /// `chance`, `ambiguous`, `covered` or `near`.
    reason: &'static str,
    /// For people.
    why: String,
    /// Elements and spaces that name a task by it.
    targets: usize,
    /// Texts that tasks and elements share.
    shared: usize,
}

impl ProposalReport {
    /// The rules that fit a site and a schedule.
    pub(super) fn of(site: &Site<'_>, schedule: &ScheduleInput) -> Self {
        let found = propose(site, schedule.plans(), &schedule.link_rules().words);
        let of_files =
            schedule.plans().iter().flat_map(|plan| plan.plan.tasks.iter().map(|task| (&plan.file, &task.name)));
        let tasks: Vec<TaskEntry> = of_files
            .zip(&found.task_ids)
            .map(|((file, name), id)| TaskEntry {
                task: id.clone(),
                name: Some(name.clone()).filter(|name| !name.is_empty()),
                file: file.clone(),
            })
            .collect();
        Self {
            compared: found.n_compared,
            needed_bits: rounded(found.needed_bits),
            work: found.n_work,
            toml: found.proposals.iter().map(|proposal| proposal.toml.as_str()).collect::<Vec<_>>().join("\n"),
            links: found.n_links,
            proposals: found.proposals.iter().map(|proposal| ProposalEntry::of(proposal, &tasks)).collect(),
            not_proposed: found.not_proposed.iter().map(|not| NotProposedEntry::of(not, found.needed_bits)).collect(),
        }
    }

    /// TOML to be pasted, with the counts as comments.
    pub(super) fn text(&self) -> String {
        let mut out = String::new();
        // Writing to a string does not fail.
        match &*self.proposals {
            [] => out += "# no rule is proposed: no value of elements is that of tasks in a way that is no chance\n",
            [_] => {}
            several => {
                let _ = writeln!(out, "# {} rules, together {}\n", several.len(), counted(self.links, "link"));
            }
        }
        for proposal in &self.proposals {
            proposal.add_text(&mut out, self.work);
        }
        if !self.not_proposed.is_empty() {
            out += "# not proposed:\n";
        }
        for not in &self.not_proposed {
            let _ = writeln!(out, "# - {}: {}", one_line(&not.what), not.why);
        }
        out
    }
}

impl ProposalEntry {
    fn of(proposal: &Proposal, tasks: &[TaskEntry]) -> Self {
        let example = |example: &::tasks::ProposalExample| ExampleEntry {
            text: example.text.clone(),
            tasks: example.n_tasks,
            targets: example.n_targets,
        };
        Self {
            what: proposal.what.clone(),
            toml: proposal.toml.clone(),
            links: proposal.n_links,
            tasks: proposal.n_tasks[0],
            work: proposal.n_tasks[1],
            targets: proposal.n_targets,
            new_targets: proposal.n_new_targets,
            with_value: proposal.n_with_value[0],
            named: proposal.n_with_value[1],
            near: proposal.n_near,
            shared: proposal.n_shared,
            evidence_bits: rounded(proposal.bits),
            examples: proposal.examples.iter().map(example).collect(),
            unlinked: proposal.unlinked_work.iter().map(|k| tasks[*k].clone()).collect(),
            other_effects: proposal.n_other_effects,
        }
    }

    fn add_text(&self, out: &mut String, work: usize) {
        let mut line = |text: String| {
            let _ = writeln!(out, "# {}", one_line(&text));
        };
        line(format!("{}: {} of {work} tasks that are work", self.what, self.work));
        line(format!(
            "  {} with {} elements or rooms; {} of {} with the value name a task; {} count for {:.0} bits",
            counted(self.links, "link"),
            self.targets,
            self.named,
            self.with_value,
            counted(self.shared, "shared text"),
            self.evidence_bits
        ));
        for example in &self.examples {
            line(format!(
                "  {:?}: {}, {} elements or rooms",
                example.text,
                counted(example.tasks, "task"),
                example.targets
            ));
        }
        if self.near > 0 {
            line(format!("  {} more differ in spaces, signs, leading zeros or what follows a sign", self.near));
        }
        if self.new_targets < self.targets {
            line(format!("  {} of them are named by no rule before", self.new_targets));
        }
        if self.other_effects > 0 {
            line(format!(
                "  check the effect: {} have words of other effects than building in their names",
                counted(self.other_effects, "task")
            ));
        }
        if !self.unlinked.is_empty() {
            let names: Vec<String> = self.unlinked.iter().take(MAX_NAMED).map(TaskEntry::text).collect();
            let more = self.unlinked.len().saturating_sub(MAX_NAMED);
            let more = if more > 0 { format!(" and {more} more") } else { String::new() };
            line(format!("  without elements: {}{more}", names.join("; ")));
        }
        out.push_str(&self.toml);
        out.push('\n');
    }
}

impl NotProposedEntry {
    fn of(not: &NotProposed, needed_bits: f64) -> Self {
        let shared = counted(not.n_shared, "shared text");
        let (reason, why) = match not.why {
            WhyNot::Coincidence(bits) => {
                ("chance", format!("{shared} may be by chance: {bits:.0} bits of the {needed_bits:.0} that are needed"))
            }
            WhyNot::Ambiguous(mean) => {
                ("ambiguous", format!("it does not tell tasks apart: an element has {mean:.1} of them"))
            }
            WhyNot::Covered => ("covered", "it names no element that a rule above does not".to_owned()),
            WhyNot::Near(n) => {
                let why = format!(
                    "{n} elements or rooms differ from a task's value in spaces, signs, leading zeros or what follows a sign"
                );
                ("near", why)
            }
        };
        Self { what: not.what.clone(), reason, why, targets: not.n_targets, shared: not.n_shared }
    }
}

/// A comment is a line.
fn one_line(text: &str) -> String {
    text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect()
}

fn rounded(bits: f64) -> f64 {
    (bits * 10.0).round() / 10.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shipped_schema::assert_shipped_schema;

    #[test]
    fn the_shipped_schema_is_that_of_the_document() {
        let settings = schemars::generate::SchemaSettings::draft2020_12().for_serialize();
        assert_shipped_schema("link-proposals", &settings.into_generator().into_root_schema_for::<ProposalReport>());
    }
}
