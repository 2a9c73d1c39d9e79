//! The document of `groundplan link`: what is linked by which rule, and what fits nothing.

use crate::args::ScheduleInput;
use ::tasks::{LinkOrigin, Links, Matches, NearMiss, Target, contradictions, matches};
use messages::Site;
use schedule::Timeline;
use schemars::JsonSchema;
use serde::Serialize;
use std::collections::BTreeSet;

/// What `groundplan link --json` prints.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct LinkReport {
    /// The schedule files.
    pub(super) files: Vec<FileEntry>,
    /// Numbers of tasks.
    pub(super) tasks: TaskCounts,
    /// Numbers of elements; parts of an element with a task have it too.
    pub(super) elements: Counts,
    /// Links by what made them: the table, then the rules in their order.
    pub(super) rules: Vec<RuleEntry>,
    /// Tasks that are work and linked with nothing.
    pub(super) unlinked_tasks: Vec<TaskEntry>,
    /// Elements without a task.
    pub(super) unlinked_elements: Vec<ElementEntry>,
    /// Elements whose tasks contradict each other.
    pub(super) contradictions: Vec<ContradictionEntry>,
    /// How many elements have a task, by class and storey.
    pub(super) shares: Vec<ShareEntry>,
    /// Values that are the same but for spaces, signs and leading zeros.
    pub(super) near_misses: Vec<NearMissEntry>,
    /// Values of the other tasks without elements, beside those that are spelt alike.
    pub(super) similar: Vec<NearMissEntry>,
    /// Rows of the table of links that name no task or nothing of the models.
    pub(super) unmatched_rows: Vec<RowEntry>,
    /// Tasks whose effect no word of `[link_words]` tells.
    pub(super) untold_effects: Vec<TaskEntry>,
}

/// A schedule file.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct FileEntry {
    /// Base name.
    pub(super) file: String,
    /// Program that wrote it, as the file says; null if it does not.
    pub(super) written_by: Option<String>,
    /// Number of its tasks.
    pub(super) tasks: usize,
}

/// Numbers of tasks.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct TaskCounts {
    /// All.
    pub(super) all: usize,
    /// That are work: no summaries, milestones or spans, and not switched off.
    pub(super) work: usize,
    /// That are linked with an element or space.
    pub(super) linked: usize,
}

/// Numbers of elements.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct Counts {
    /// All.
    pub(super) all: usize,
    /// With a task.
    pub(super) linked: usize,
}

/// Links of a rule, or of the table.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct RuleEntry {
    /// Name of the rule; null for the table.
    pub(super) rule: Option<String>,
    /// Number of its links.
    pub(super) links: usize,
    /// Number of tasks in them.
    pub(super) tasks: usize,
    /// Number of elements and spaces in them.
    pub(super) targets: usize,
}

/// A task.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub(super) struct TaskEntry {
    /// Its name in archives: the code, unless several tasks share it.
    pub(super) task: String,
    /// Name; null if it has none.
    pub(super) name: Option<String>,
    /// Its file.
    pub(super) file: String,
}

/// An element.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct ElementEntry {
    /// GlobalId.
    pub(super) global_id: String,
    /// Entity.
    pub(super) class: String,
    /// Name; null if it has none.
    pub(super) name: Option<String>,
    /// Name of the storey that contains it; null if none does.
    pub(super) storey: Option<String>,
}

/// An element whose tasks contradict each other.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct ContradictionEntry {
    /// The element.
    pub(super) element: ElementEntry,
    /// `two_effects`, `built_while_removed` or `removed_before_built`.
    pub(super) kind: &'static str,
    /// The tasks; one if it has two effects.
    pub(super) tasks: Vec<TaskEntry>,
}

/// Elements of a class on a storey.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct ShareEntry {
    /// Entity.
    pub(super) class: String,
    /// Name of the storey; null for elements that are in none.
    pub(super) storey: Option<String>,
    /// With a task.
    pub(super) linked: usize,
    /// All.
    pub(super) all: usize,
}

/// Two values, in lower case, that may mean the same.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct NearMissEntry {
    /// Name of the rule that compares them.
    pub(super) rule: String,
    /// The value of the task.
    pub(super) task: String,
    /// That of elements or spaces.
    pub(super) element: String,
    /// How many have it.
    pub(super) elements: usize,
}

/// A row of the table.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct RowEntry {
    /// Its line, from 1.
    pub(super) line: u64,
    /// What it names that does not exist.
    pub(super) why: String,
}

impl LinkReport {
    /// Tells how well the schedule files and a site with their tasks fit together.
    pub(super) fn of(site: &Site<'_>, timeline: &Timeline, schedule: &ScheduleInput, links: &Links) -> Self {
        let plans = schedule.plans();
        let found = matches(site, plans, schedule.link_rules(), links);
        let tasks = task_entries(schedule, &found);
        let dates_s = |task: usize| timeline.task(task).map(|dates| [dates.start_s, dates.finish_s]);
        let contradiction = |found: ::tasks::Contradiction| {
            let mut of: Vec<usize> = found.tasks.to_vec();
            of.dedup();
            let tasks = of.into_iter().map(|k| tasks[k].clone()).collect();
            ContradictionEntry { element: element_entry(site, found.element), kind: found.kind.name(), tasks }
        };
        let all_of = |wanted: &[usize]| wanted.iter().map(|k| tasks[*k].clone()).collect();
        let untold: BTreeSet<usize> = links.untold_effects.iter().map(|(task, _)| *task).collect();
        let file = |plan: &::tasks::ScheduleFile| FileEntry {
            file: plan.file.clone(),
            written_by: some(&plan.plan.written_by),
            tasks: plan.plan.tasks.len(),
        };
        Self {
            files: plans.iter().map(file).collect(),
            tasks: TaskCounts { all: tasks.len(), work: found.n_work, linked: found.linked_tasks.len() },
            elements: Counts { all: site.elements.len(), linked: site.elements.len() - found.unlinked_elements.len() },
            rules: rule_entries(schedule, links),
            unlinked_tasks: all_of(&found.unlinked_tasks),
            unlinked_elements: found.unlinked_elements.iter().map(|k| element_entry(site, *k)).collect(),
            contradictions: contradictions(links, dates_s).into_iter().map(contradiction).collect(),
            shares: found.shares.iter().map(ShareEntry::of).collect(),
            near_misses: found.near_misses.iter().map(NearMissEntry::of).collect(),
            similar: found.similar.iter().map(NearMissEntry::of).collect(),
            unmatched_rows: links
                .unmatched_rows
                .iter()
                .map(|(line, why)| RowEntry { line: *line, why: why.clone() })
                .collect(),
            untold_effects: all_of(&untold.into_iter().collect::<Vec<_>>()),
        }
    }
}

fn some(text: &str) -> Option<String> {
    Some(text.to_owned()).filter(|text| !text.is_empty())
}

/// All tasks, in the order of the archive.
fn task_entries(schedule: &ScheduleInput, found: &Matches) -> Vec<TaskEntry> {
    let of_files = schedule.plans().iter().flat_map(|plan| plan.plan.tasks.iter().map(|task| (&plan.file, &task.name)));
    let entry = |((file, name), id): ((&String, &String), &String)| TaskEntry {
        task: id.clone(),
        name: some(name),
        file: file.clone(),
    };
    of_files.zip(&found.task_ids).map(entry).collect()
}

fn rule_entries(schedule: &ScheduleInput, links: &Links) -> Vec<RuleEntry> {
    let rules = &schedule.link_rules().rules;
    // The table, then the rules.
    let mut found: Vec<(usize, BTreeSet<usize>, BTreeSet<Target>)> = vec![Default::default(); rules.len() + 1];
    for link in &links.links {
        let (n, tasks, targets) = &mut found[match link.origin {
            LinkOrigin::Table(_) => 0,
            LinkOrigin::Rule(k) => k + 1,
        }];
        *n += 1;
        tasks.insert(link.task);
        targets.insert(link.target);
    }
    let names = std::iter::once(None).chain(rules.iter().map(|rule| Some(rule.name.clone())));
    let entry = |(rule, (links, tasks, targets)): (Option<String>, (usize, BTreeSet<usize>, BTreeSet<Target>))| {
        RuleEntry { rule, links, tasks: tasks.len(), targets: targets.len() }
    };
    let entries = names.zip(found).map(entry);
    entries.filter(|entry| entry.rule.is_some() || entry.links > 0).collect()
}

fn element_entry(site: &Site<'_>, element: u32) -> ElementEntry {
    let record = &site.elements[element as usize];
    ElementEntry {
        global_id: site.text(record.global_id).to_owned(),
        class: site.text(record.ifc_type).to_owned(),
        name: some(site.text(record.name)),
        storey: site.storeys.get(record.storey as usize).and_then(|storey| some(site.text(storey.name))),
    }
}

impl ShareEntry {
    fn of(share: &::tasks::ClassShare) -> Self {
        let ::tasks::ClassShare { class, storey, linked, all } = share.clone();
        Self { class, storey: some(&storey), linked, all }
    }
}

impl NearMissEntry {
    fn of(miss: &NearMiss) -> Self {
        let NearMiss { rule, task, element, n_elements } = miss.clone();
        Self { rule, task, element, elements: n_elements }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shipped_schema::assert_shipped_schema;

    #[test]
    fn the_shipped_schema_is_that_of_the_document() {
        let settings = schemars::generate::SchemaSettings::draft2020_12().for_serialize();
        assert_shipped_schema("link", &settings.into_generator().into_root_schema_for::<LinkReport>());
    }
}
