//! Elements whose tasks contradict each other.

use crate::effect::Effect;
use crate::links::{Link, Links, Target};
use std::collections::BTreeMap;

/// How tasks of an element contradict each other.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum ContradictionKind {
    /// One task has two effects on it.
    TwoEffects,
    /// A task removes it while another builds it.
    BuiltWhileRemoved,
    /// A task removes it before another builds it, and none built it before.
    RemovedBeforeBuilt,
}

impl ContradictionKind {
    /// Its name in documents.
    pub fn name(self) -> &'static str {
        match self {
            Self::TwoEffects => "two_effects",
            Self::BuiltWhileRemoved => "built_while_removed",
            Self::RemovedBeforeBuilt => "removed_before_built",
        }
    }
}

/// An element whose tasks contradict each other.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Contradiction {
    /// The element.
    pub element: u32,
    /// How.
    pub kind: ContradictionKind,
    /// The first two tasks that do, by index over all files; the same one twice if it has two effects.
    pub tasks: [usize; 2],
}

/// When a task builds or removes an element.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Work {
    start_s: i64,
    finish_s: i64,
    task: usize,
    removes: bool,
}

/// The contradictions of all elements, at most one of each kind for an element; `dates_s` are start and finish of a task, `None` if
/// it has none.
pub fn contradictions(links: &Links, dates_s: impl Fn(usize) -> Option<[i64; 2]>) -> Vec<Contradiction> {
    let mut by_element: BTreeMap<u32, Vec<&Link>> = BTreeMap::new();
    for link in &links.links {
        if let Target::Element(element) = link.target {
            by_element.entry(element).or_default().push(link);
        }
    }
    let of_element = |(element, links): (u32, Vec<&Link>)| {
        let work = |link: &&Link| {
            let removes = match link.effect {
                Effect::Builds => false,
                Effect::Removes => true,
                Effect::WorksIn | Effect::Uses => return None,
            };
            let [start_s, finish_s] = dates_s(link.task)?;
            Some(Work { start_s, finish_s, task: link.task, removes })
        };
        let mut works: Vec<Work> = links.iter().filter_map(work).collect();
        works.sort_unstable();
        let found = [
            (ContradictionKind::TwoEffects, two_effects(&links)),
            (ContradictionKind::BuiltWhileRemoved, built_while_removed(&works)),
            (ContradictionKind::RemovedBeforeBuilt, removed_before_built(&works)),
        ];
        found.into_iter().filter_map(move |(kind, tasks)| Some(Contradiction { element, kind, tasks: tasks? }))
    };
    by_element.into_iter().flat_map(of_element).collect()
}

/// A task with two effects; links are sorted by task.
fn two_effects(links: &[&Link]) -> Option<[usize; 2]> {
    let twice = links.windows(2).find(|pair| pair[0].task == pair[1].task && pair[0].effect != pair[1].effect)?;
    Some([twice[0].task, twice[1].task])
}

/// The first two tasks of which one builds and the other removes at the same time; works are sorted by start.
fn built_while_removed(works: &[Work]) -> Option<[usize; 2]> {
    let mut last: [Option<Work>; 2] = [None; 2];
    for work in works {
        let other = last[usize::from(!work.removes)].filter(|other: &Work| {
            other.task != work.task && work.start_s < other.finish_s && work.start_s < work.finish_s
        });
        if let Some(other) = other {
            return Some([other.task, work.task]);
        }
        let same = &mut last[usize::from(work.removes)];
        if same.is_none_or(|same| same.finish_s < work.finish_s) {
            *same = Some(*work);
        }
    }
    None
}

/// The first removal, if it has ended before the first construction begins.
fn removed_before_built(works: &[Work]) -> Option<[usize; 2]> {
    let first = works.first().filter(|first| first.removes)?;
    let built = works.iter().find(|work| !work.removes).filter(|built| built.start_s >= first.finish_s)?;
    Some([first.task, built.task])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::links::LinkOrigin;

    fn check(works: &[(usize, Effect, [i64; 2])], expect: &[(ContradictionKind, [usize; 2])]) {
        let link = |(task, effect, _): &(usize, Effect, [i64; 2])| Link {
            task: *task,
            target: Target::Element(7),
            effect: *effect,
            origin: LinkOrigin::Rule(0),
        };
        let links = Links { links: works.iter().map(link).collect(), ..Links::default() };
        let dates_s = |task: usize| works.iter().find(|work| work.0 == task).map(|work| work.2);
        let found = contradictions(&links, dates_s);
        let found: Vec<_> = found.iter().map(|found| (found.kind, found.tasks)).collect();
        assert_eq!(found, expect, "{works:?}");
    }

    #[test]
    fn tasks_that_follow_each_other_do_not_contradict() {
        use Effect::{Builds, Removes, Uses, WorksIn};
        check(&[(0, Builds, [0, 10]), (1, Removes, [10, 20]), (2, Builds, [20, 30])], &[]);
        check(&[(0, Builds, [0, 10]), (1, Builds, [5, 20]), (2, WorksIn, [0, 30]), (3, Uses, [0, 30])], &[]);
        check(&[(0, Removes, [0, 10])], &[]);
    }

    #[test]
    fn contradictions_name_their_tasks() {
        use ContradictionKind::{BuiltWhileRemoved, RemovedBeforeBuilt, TwoEffects};
        use Effect::{Builds, Removes};
        check(&[(0, Builds, [0, 10]), (1, Removes, [9, 20])], &[(BuiltWhileRemoved, [0, 1])]);
        check(&[(0, Builds, [0, 30]), (1, Builds, [1, 2]), (2, Removes, [9, 20])], &[(BuiltWhileRemoved, [0, 2])]);
        check(&[(0, Removes, [0, 10]), (1, Builds, [10, 20])], &[(RemovedBeforeBuilt, [0, 1])]);
        check(&[(0, Builds, [0, 10]), (0, Removes, [0, 10])], &[(TwoEffects, [0, 0])]);
    }
}
