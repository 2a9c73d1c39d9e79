//! Finds the elements and spaces that tasks work on, by a table and by rules.
//!
//! Linear in tasks, targets and links: targets are indexed by the values that the task has to have.

use crate::effect::Effect;
use crate::folded::fold;
use crate::link_rules::{EffectChoice, LinkRule, LinkRules};
use crate::link_table::TableLink;
use crate::links::{Link, LinkOrigin, Links, Target, targets};
use crate::schedule_file::ScheduleFile;
use crate::selector::Selector;
use crate::target_values::{global_id, place_m};
use crate::task_values::{PlannedTask, TaskValue, all_tasks};
use messages::Site;
use schedule_files::PlanTask;
use std::collections::{BTreeMap, BTreeSet, HashMap};

/// Most links of a site.
const MAX_LINKS: usize = 4_000_000;

/// Links that cannot be made.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum LinkError {
    /// More than a site may have.
    #[error("{origin} links more than {MAX_LINKS} pairs of tasks and elements; say more about its tasks or elements")]
    TooMany {
        /// The rule or table.
        origin: String,
    },
}

/// Links the tasks of schedule files with a site.
///
/// A row of the table, or a rule, counts for a target only if none before it names this target. Tasks that the planner switched
/// off work on nothing.
///
/// # Errors
/// Too many links.
pub fn link(
    site: &Site<'_>,
    plans: &[ScheduleFile],
    rules: &LinkRules,
    table: &[TableLink],
) -> Result<Links, LinkError> {
    let tasks = all_tasks(plans);
    let targets: Vec<Target> = targets(site).collect();
    let mut links = Links::default();
    let mut taken: BTreeSet<Target> = BTreeSet::new();
    link_by_table(site, &tasks, &targets, table, &mut links);
    taken.extend(links.links.iter().map(|link| link.target));
    for (k, rule) in rules.rules.iter().enumerate() {
        let candidates = candidates(site, rule, &targets);
        let free = candidates.into_iter().filter(|target| !taken.contains(target)).collect();
        let found = Candidates::of(site, rule, free);
        let before = links.links.len();
        for (task, planned) in tasks.iter().enumerate().filter(|(_, t)| selects(rule, plans, t)) {
            let targets = found.of_task(planned.task);
            if targets.is_empty() {
                continue;
            }
            if links.links.len() + targets.len() > MAX_LINKS {
                return Err(LinkError::TooMany { origin: rule.name.clone() });
            }
            let effect = effect_of(rule, rules, planned.task).unwrap_or_else(|| {
                links.untold_effects.push((task, k));
                Effect::WorksIn
            });
            let link = |target| Link { task, target, effect, origin: LinkOrigin::Rule(k) };
            links.links.extend(targets.into_iter().map(link));
        }
        taken.extend(links.links[before..].iter().map(|link| link.target));
    }
    links.links.sort_by_key(|link| (link.task, link.target, link.effect, link.origin));
    links.links.dedup_by_key(|link| (link.task, link.target, link.effect));
    Ok(links)
}

fn effect_of(rule: &LinkRule, rules: &LinkRules, task: &PlanTask) -> Option<Effect> {
    match &rule.effect {
        EffectChoice::Fixed(effect) => Some(*effect),
        EffectChoice::Told(by) => by.0.of(task).iter().find_map(|text| rules.words.effect_of(text)),
    }
}

fn selects(rule: &LinkRule, plans: &[ScheduleFile], planned: &PlannedTask<'_>) -> bool {
    let fits_file = rule.task.file.as_ref().is_none_or(|file| file.fits(&fold(&plans[planned.file].file)));
    fits_file
        && !planned.task.is_inactive
        && rule.task.values.iter().all(|(value, pattern)| value.of(planned.task).iter().any(|text| pattern.fits(text)))
}

/// Targets that fit what a rule says of them, whatever the task is.
fn candidates(site: &Site<'_>, rule: &LinkRule, targets: &[Target]) -> Vec<Target> {
    let fits = |target: &Target| {
        let has_place = rule
            .elements
            .region_m
            .as_ref()
            .is_none_or(|region_m| place_m(site, *target).is_some_and(|at_m| is_inside(region_m, at_m)));
        has_place
            && rule.elements.values.iter().all(|(value, selector)| match selector {
                Selector::Fits(pattern) => value.of(site, *target).iter().any(|text| pattern.fits(text)),
                Selector::Equals(_) => true,
            })
    };
    targets.iter().copied().filter(fits).collect()
}

/// Targets of a rule by the values that the task has to have.
pub(crate) struct Candidates<'r> {
    /// By their values for `keys`, joined.
    by_values: HashMap<String, Vec<usize>>,
    targets: Vec<Target>,
    keys: Vec<&'r TaskValue>,
    /// Values of each target for each further value that the task has to have.
    further: Vec<(&'r TaskValue, Vec<Vec<String>>)>,
}

impl<'r> Candidates<'r> {
    pub(crate) fn of(site: &Site<'_>, rule: &'r LinkRule, targets: Vec<Target>) -> Self {
        let mut equal = Vec::new();
        for (value, selector) in &rule.elements.values {
            if let Selector::Equals(task) = selector {
                equal.push((task, targets.iter().map(|target| value.of(site, *target)).collect::<Vec<_>>()));
            }
        }
        let further = equal.split_off(n_keys(&equal));
        let mut by_values: HashMap<String, Vec<usize>> = HashMap::new();
        for k in 0..targets.len() {
            let values = equal.iter().map(|(_, of_targets)| of_targets[k].as_slice());
            combined(values).into_iter().for_each(|key| by_values.entry(key).or_default().push(k));
        }
        Self { by_values, targets, keys: equal.into_iter().map(|(task, _)| task).collect(), further }
    }

    /// What a task works on, each once.
    pub(crate) fn of_task(&self, task: &PlanTask) -> Vec<Target> {
        let values: Vec<Vec<String>> = self.keys.iter().map(|key| key.of(task)).collect();
        let keys = combined(values.iter().map(Vec::as_slice));
        let mut found: Vec<usize> = keys.iter().filter_map(|key| self.by_values.get(key)).flatten().copied().collect();
        for (value, of_targets) in &self.further {
            let wanted = value.of(task);
            found.retain(|k| of_targets[*k].iter().any(|text| wanted.contains(text)));
        }
        found.sort_unstable();
        found.dedup();
        found.into_iter().map(|k| self.targets[k]).collect()
    }
}

/// How many of the values are combined into keys: so many that there are no more keys than links.
fn n_keys(equal: &[(&TaskValue, Vec<Vec<String>>)]) -> usize {
    let Some((_, first)) = equal.first() else { return 0 };
    let mut n_of_targets = vec![1_usize; first.len()];
    for (k, (_, of_targets)) in equal.iter().enumerate() {
        n_of_targets.iter_mut().zip(of_targets).for_each(|(n, values)| *n = n.saturating_mul(values.len()));
        if k > 0 && n_of_targets.iter().fold(0_usize, |all, n| all.saturating_add(*n)) > MAX_LINKS {
            return k;
        }
    }
    equal.len()
}

/// Every way to take one value of each list, joined with their lengths before them; one empty text of no list.
fn combined<'v>(lists: impl Iterator<Item = &'v [String]>) -> Vec<String> {
    lists.fold(vec![String::new()], |keys, values| {
        keys.iter().flat_map(|key| values.iter().map(move |value| format!("{key}{}:{value}", value.len()))).collect()
    })
}

fn link_by_table(
    site: &Site<'_>,
    tasks: &[PlannedTask<'_>],
    targets: &[Target],
    table: &[TableLink],
    links: &mut Links,
) {
    if table.is_empty() {
        return;
    }
    let by_id: HashMap<&str, Target> = targets.iter().map(|target| (global_id(site, *target), *target)).collect();
    let mut by_task: BTreeMap<String, Vec<usize>> = BTreeMap::new();
    for (k, planned) in tasks.iter().enumerate().filter(|(_, planned)| !planned.task.is_inactive) {
        let names: BTreeSet<String> = [&planned.task.code, &planned.task.uid].into_iter().map(|t| fold(t)).collect();
        names.into_iter().filter(|name| !name.is_empty()).for_each(|name| by_task.entry(name).or_default().push(k));
    }
    for row in table {
        let Some(&target) = by_id.get(row.global_id.as_str()) else {
            links.unmatched_rows.push((row.line, format!("no element or space has the GlobalId {:?}", row.global_id)));
            continue;
        };
        match by_task.get(&fold(&row.task)).map(Vec::as_slice) {
            Some(&[task]) => {
                links.links.push(Link { task, target, effect: row.effect, origin: LinkOrigin::Table(row.line) });
            }
            Some(several) => {
                let why = format!("{} tasks are called {:?}", several.len(), row.task);
                links.unmatched_rows.push((row.line, why));
            }
            None => links.unmatched_rows.push((row.line, format!("no task has the code or id {:?}", row.task))),
        }
    }
}

/// True if a place lies in a polygon: its border crosses the way to the right an odd number of times.
fn is_inside(corners: &[[f64; 2]], [x, y]: [f64; 2]) -> bool {
    let next = corners.iter().cycle().skip(1);
    let crosses = |(a, b): (&[f64; 2], &[f64; 2])| {
        (a[1] > y) != (b[1] > y) && x < (b[0] - a[0]) * (y - a[1]) / (b[1] - a[1]) + a[0]
    };
    corners.iter().zip(next).filter(|edge| crosses(*edge)).count() % 2 == 1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_place_is_inside_an_outline_with_a_notch_or_not() {
        let outline = [[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [2.0, 1.0], [0.0, 4.0]];
        assert!(is_inside(&outline, [0.5, 1.0]) && is_inside(&outline, [3.5, 2.0]));
        assert!(!is_inside(&outline, [2.0, 3.0]) && !is_inside(&outline, [5.0, 1.0]));
    }
}
