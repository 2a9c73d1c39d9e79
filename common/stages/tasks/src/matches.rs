//! Fit of a schedule and a model: tasks without elements, elements without tasks, and the nearest misses.

use crate::link_rules::LinkRules;
use crate::link_table::described;
use crate::links::{Links, Target, targets};
use crate::schedule_file::ScheduleFile;
use crate::selector::Selector;
use crate::target_values::TargetValue;
use crate::task_values::{PlannedTask, TaskValue, all_tasks, is_work, task_ids};
use diagnostics::nearest_names;
use messages::{NONE, Site};
use std::collections::{BTreeMap, BTreeSet};

/// Most tasks without elements whose values are compared by their spelling.
pub const MAX_COMPARED_TASKS: usize = 200;
/// Most values that each is compared with.
pub const MAX_COMPARED_VALUES: usize = 1000;

/// How well a schedule and a model fit together.
#[derive(Debug, Clone, Default)]
pub struct Matches {
    /// Tasks that are linked with something, by index over all files.
    pub linked_tasks: Vec<usize>,
    /// How many tasks are work: no summaries, milestones or spans, and not switched off.
    pub n_work: usize,
    /// Tasks that are work and linked with nothing.
    pub unlinked_tasks: Vec<usize>,
    /// Elements without a task, their own or that of the element they are a part of.
    pub unlinked_elements: Vec<u32>,
    /// Links by class and storey of their elements.
    pub shares: Vec<ClassShare>,
    /// Values of elements that name no task, beside the value of a task without elements that they may mean.
    pub near_misses: Vec<NearMiss>,
    /// The same for tasks without elements that have no near miss: values that are spelt alike. Only the first
    /// [`MAX_COMPARED_TASKS`] of them are compared, with the first [`MAX_COMPARED_VALUES`] values of a rule.
    pub similar: Vec<NearMiss>,
    /// Names of all tasks, as in the `tasks` archive.
    pub task_ids: Vec<String>,
}

/// How many elements of a class on a storey have a task.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ClassShare {
    /// Entity.
    pub class: String,
    /// Name of the storey; empty for elements that are in none.
    pub storey: String,
    /// Elements with a task.
    pub linked: usize,
    /// All elements.
    pub all: usize,
}

/// Two values, without case, that may mean the same: they differ in spaces, signs and leading zeros only, or are spelt alike.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct NearMiss {
    /// Name of the rule that compares them.
    pub rule: String,
    /// The value of the task.
    pub task: String,
    /// That of the element.
    pub element: String,
    /// How many elements have it.
    pub n_elements: usize,
}

/// Compares tasks and elements after [`crate::link`].
pub fn matches(site: &Site<'_>, plans: &[ScheduleFile], rules: &LinkRules, links: &Links) -> Matches {
    let tasks = all_tasks(plans);
    let mut is_linked = vec![false; tasks.len()];
    links.links.iter().for_each(|link| is_linked[link.task] = true);
    let is_work = is_work(&tasks, plans);
    let has_task = with_task(site, links);
    let of = |wanted: &dyn Fn(usize) -> bool| (0..tasks.len()).filter(|k| wanted(*k)).collect::<Vec<_>>();
    let unlinked_tasks = of(&|k| is_work[k] && !is_linked[k]);
    let unlinked: Vec<PlannedTask<'_>> = unlinked_tasks.iter().map(|k| tasks[*k]).collect();
    let [near_misses, similar] = near_misses(site, rules, &tasks, &unlinked);
    Matches {
        linked_tasks: of(&|k| is_linked[k]),
        n_work: is_work.iter().filter(|is_work| **is_work).count(),
        unlinked_elements: (0..site.elements.len() as u32).filter(|k| !has_task[*k as usize]).collect(),
        shares: shares(site, &has_task),
        near_misses,
        similar,
        task_ids: task_ids(plans),
        unlinked_tasks,
    }
}

/// Elements that have a task, or are a part of one that has.
fn with_task(site: &Site<'_>, links: &Links) -> Vec<bool> {
    let mut has_task = vec![false; site.elements.len()];
    for link in &links.links {
        if let Target::Element(k) = link.target {
            has_task[k as usize] = true;
        }
    }
    let own = has_task.clone();
    for (k, element) in site.elements.iter().enumerate() {
        // Wholes that are parts of themselves end after a round.
        let next = |whole: &u32| Some(site.elements[*whole as usize].whole).filter(|whole| *whole != NONE);
        let first = Some(element.whole).filter(|whole| *whole != NONE);
        has_task[k] |= std::iter::successors(first, next).take(64).any(|whole| own[whole as usize]);
    }
    has_task
}

fn shares(site: &Site<'_>, has_task: &[bool]) -> Vec<ClassShare> {
    let mut counts: BTreeMap<(u32, &str), (usize, usize)> = BTreeMap::new();
    for (element, has_task) in site.elements.iter().zip(has_task) {
        let (linked, all) = counts.entry((element.storey, site.text(element.ifc_type))).or_default();
        *linked += usize::from(*has_task);
        *all += 1;
    }
    let share = |((storey, class), (linked, all)): ((u32, &str), (usize, usize))| ClassShare {
        class: class.to_owned(),
        storey: site.storeys.get(storey as usize).map_or("", |s| site.text(s.name)).to_owned(),
        linked,
        all,
    };
    counts.into_iter().map(share).collect()
}

/// A value without anything but letters and digits, and without leading zeros of numbers.
pub(crate) fn squashed(folded: &str) -> String {
    let mut out = String::with_capacity(folded.len());
    let mut is_in_number = false;
    for c in folded.chars().filter(|c| c.is_alphanumeric()) {
        if c == '0' && !is_in_number {
            continue;
        }
        is_in_number = c.is_ascii_digit();
        out.push(c);
    }
    out
}

/// Near misses of all rules, and values that are spelt alike.
fn near_misses(
    site: &Site<'_>,
    rules: &LinkRules,
    tasks: &[PlannedTask<'_>],
    unlinked: &[PlannedTask<'_>],
) -> [Vec<NearMiss>; 2] {
    let mut found = [Vec::new(), Vec::new()];
    for rule in &rules.rules {
        let compared = rule.elements.values.iter().find_map(|(value, selector)| match selector {
            Selector::Equals(task) => Some((value, task)),
            Selector::Fits(_) => None,
        });
        if let Some((value, task_value)) = compared {
            let wanted: BTreeSet<String> = unlinked.iter().flat_map(|planned| task_value.of(planned.task)).collect();
            let unnamed = unnamed_values(site, value, task_value, tasks);
            found[0].extend(misses_of(&rule.name, &wanted, &unnamed));
            let missed: BTreeSet<String> = found[0].iter().map(|miss: &NearMiss| miss.task.clone()).collect();
            let rest = wanted.iter().filter(|text| !missed.contains(*text));
            found[1].extend(similar_of(&rule.name, rest, &unnamed));
        }
    }
    for list in &mut found {
        list.sort();
        list.dedup();
    }
    found
}

/// Values of elements and spaces that no task has, and how many have each.
fn unnamed_values(
    site: &Site<'_>,
    value: &TargetValue,
    task_value: &TaskValue,
    tasks: &[PlannedTask<'_>],
) -> BTreeMap<String, usize> {
    let named: BTreeSet<String> = tasks.iter().flat_map(|planned| task_value.of(planned.task)).collect();
    let mut unnamed: BTreeMap<String, usize> = BTreeMap::new();
    for text in targets(site).flat_map(|target| value.of(site, target)).filter(|text| !named.contains(text)) {
        *unnamed.entry(text).or_default() += 1;
    }
    unnamed
}

fn misses_of(rule: &str, wanted: &BTreeSet<String>, unnamed: &BTreeMap<String, usize>) -> Vec<NearMiss> {
    let mut by_squashed: BTreeMap<String, Vec<(&String, usize)>> = BTreeMap::new();
    for (text, n) in unnamed {
        by_squashed.entry(squashed(text)).or_default().push((text, *n));
    }
    // A value of signs only is near to nothing.
    by_squashed.remove("");
    let near = |text: &String| by_squashed.get(&squashed(text)).cloned().unwrap_or_default();
    let miss =
        |task: &String| near(task).into_iter().map(|(element, n)| NearMiss::of(rule, task, element, n)).collect();
    wanted.iter().flat_map(|task| -> Vec<NearMiss> { miss(task) }).collect()
}

fn similar_of<'t>(
    rule: &str,
    wanted: impl Iterator<Item = &'t String>,
    unnamed: &BTreeMap<String, usize>,
) -> Vec<NearMiss> {
    let miss = |task: &String| -> Vec<NearMiss> {
        let names = unnamed.keys().map(String::as_str).take(MAX_COMPARED_VALUES);
        let near = nearest_names(task, names).into_iter();
        near.map(|element| NearMiss::of(rule, task, element, unnamed[element])).collect()
    };
    wanted.take(MAX_COMPARED_TASKS).flat_map(miss).collect()
}

impl NearMiss {
    fn of(rule: &str, task: &str, element: &str, n_elements: usize) -> Self {
        let [rule, task, element] = [rule, task, element].map(str::to_owned);
        Self { rule, task, element, n_elements }
    }
}

impl Matches {
    /// Entity and name of an element, for people.
    pub fn element<'s>(site: &Site<'s>, element: u32) -> [&'s str; 2] {
        described(site, Target::Element(element))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn signs_spaces_and_leading_zeros_are_near_misses() {
        let alike = ["a-1020", "a1020", "a 01020", "a.1020"];
        assert!(alike.iter().all(|text| squashed(text) == "a1020"));
        assert_ne!(squashed("a1020"), squashed("a10200"));
        assert_eq!(squashed("a1002"), "a1002");
    }
}
