//! How well a schedule and a model fit together: tasks without elements, elements without tasks, and the nearest misses.

use crate::folded::fold;
use crate::link_rules::LinkRules;
use crate::link_table::described;
use crate::links::{Links, Target, targets};
use crate::schedule_file::ScheduleFile;
use crate::selector::Selector;
use crate::target_values::TargetValue;
use crate::task_values::{PlannedTask, TaskValue, all_tasks, is_work, task_ids};
use messages::{NONE, Site};
use std::collections::{BTreeMap, BTreeSet};

/// How well a schedule and a model fit together.
#[derive(Debug, Clone, Default)]
pub struct Matches {
    /// Tasks that are linked with something, by index over all files.
    pub linked_tasks: Vec<usize>,
    /// Tasks that are work and linked with nothing.
    pub unlinked_tasks: Vec<usize>,
    /// Elements without a task, their own or that of the element they are a part of.
    pub unlinked_elements: Vec<u32>,
    /// Links by class and storey of their elements.
    pub shares: Vec<ClassShare>,
    /// Values of elements that name no task, beside the value of a task without elements that they may mean.
    pub near_misses: Vec<NearMiss>,
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

/// Two values that are the same but for spaces, signs and leading zeros.
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
    Matches {
        linked_tasks: of(&|k| is_linked[k]),
        unlinked_elements: (0..site.elements.len() as u32).filter(|k| !has_task[*k as usize]).collect(),
        shares: shares(site, &has_task),
        near_misses: near_misses(site, rules, &tasks, &unlinked),
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
fn squashed(folded: &str) -> String {
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

fn near_misses(
    site: &Site<'_>,
    rules: &LinkRules,
    tasks: &[PlannedTask<'_>],
    unlinked: &[PlannedTask<'_>],
) -> Vec<NearMiss> {
    let mut found = Vec::new();
    for rule in &rules.rules {
        let compared = rule.elements.values.iter().find_map(|(value, selector)| match selector {
            Selector::Equals(task) => Some((value, task)),
            Selector::Fits(_) => None,
        });
        if let Some((value, task)) = compared {
            found.extend(misses_of(site, &rule.name, value, task, tasks, unlinked));
        }
    }
    found.sort();
    found.dedup();
    found
}

fn misses_of(
    site: &Site<'_>,
    rule: &str,
    value: &TargetValue,
    task_value: &TaskValue,
    tasks: &[PlannedTask<'_>],
    unlinked: &[PlannedTask<'_>],
) -> Vec<NearMiss> {
    let named: BTreeSet<String> = tasks.iter().flat_map(|planned| task_value.of(planned.task)).collect();
    let mut of_elements: BTreeMap<String, usize> = BTreeMap::new();
    for text in targets(site).flat_map(|target| value.of(site, target)) {
        if !named.contains(&text) {
            *of_elements.entry(text).or_default() += 1;
        }
    }
    let mut by_squashed: BTreeMap<String, Vec<(&String, usize)>> = BTreeMap::new();
    for (text, n) in &of_elements {
        by_squashed.entry(squashed(text)).or_default().push((text, *n));
    }
    let miss = |text: String| {
        let near = by_squashed.get(&squashed(&text)).into_iter().flatten();
        let rule = rule.to_owned();
        let miss = move |&(element, n_elements): &(&String, usize)| NearMiss {
            rule: rule.clone(),
            task: text.clone(),
            element: element.clone(),
            n_elements,
        };
        near.map(miss).collect::<Vec<_>>()
    };
    unlinked.iter().flat_map(|planned| task_value.of(planned.task)).map(|t| fold(&t)).flat_map(miss).collect()
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
