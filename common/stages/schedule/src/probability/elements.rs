//! Probabilities of element states: elements with the same tasks share a count over the runs.

use super::{Probabilities, Samples};
use crate::element_timeline::ElementTimeline;
use crate::rules::Undated;
use crate::task_effects::Effect;
use crate::timeline::{Period, Steps, Timeline, union_of};
use messages::{ElementState, NONE};
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Probabilities of an element, each from 0 to 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ElementProbability {
    /// It stands: built, over a period throughout.
    pub stands: f64,
    /// It is there at all, an obstacle: in progress, built or being removed; over a period at any instant.
    pub there: f64,
    /// It has been there and is gone.
    pub removed: f64,
}

/// Elements whose states follow from the same effects of tasks.
pub(super) struct ElementGroups {
    /// Effects of each group; the dates of those that a task makes are its own in every run, and 0 here.
    effects: Vec<Vec<Effect>>,
    /// The group of each element; `None` for elements without tasks, which do not vary.
    of_element: Vec<Option<u32>>,
}

/// In how many runs the elements of a group stand, are there and are removed.
type Counts = [u32; 3];

impl ElementGroups {
    pub(super) fn of(timeline: &Timeline) -> Self {
        let mut groups: BTreeMap<Vec<Effect>, u32> = BTreeMap::new();
        let undated = |e: &Effect| if e.task == NONE { *e } else { Effect { start_s: 0, finish_s: 0, ..*e } };
        let of_element = timeline.effects.iter().map(|effects| {
            let next = groups.len() as u32;
            let varies = effects.iter().any(|e| e.task != NONE);
            varies.then(|| *groups.entry(effects.iter().map(undated).collect()).or_insert(next))
        });
        let of_element = of_element.collect();
        let mut effects = vec![Vec::new(); groups.len()];
        groups.into_iter().for_each(|(of_group, group)| effects[group as usize] = of_group);
        Self { effects, of_element }
    }
}

impl Probabilities<'_> {
    /// Probabilities of all elements at an instant, or over a period.
    pub fn elements(&self, period: Period) -> Vec<ElementProbability> {
        let runs = self.uncertainty.runs;
        let none = || vec![[0; 3]; self.groups.effects.len()];
        let of_run = |mut sums: Vec<Counts>, run: u32| {
            let mut effects = Vec::new();
            for (sum, group) in sums.iter_mut().zip(&self.groups.effects) {
                let state = state_in_run(&self.samples, group, run, period, &mut effects);
                add(sum, counts_of(state));
            }
            sums
        };
        let all = |mut sums: Vec<Counts>, others: Vec<Counts>| {
            sums.iter_mut().zip(others).for_each(|(sum, other)| add(sum, other));
            sums
        };
        let counts = (0..runs).into_par_iter().fold(none, of_run).reduce(none, all);
        let certain = |element| counts_of(self.timeline.element_over(element, period)).map(|n| n * runs);
        let of_element = self.groups.of_element.iter().enumerate().map(|(element, group)| {
            let counts = group.map_or_else(|| certain(element), |group| counts[group as usize]);
            let [stands, there, removed] = counts.map(|n| f64::from(n) / f64::from(runs));
            ElementProbability { stands, there, removed }
        });
        of_element.collect()
    }
}

fn counts_of(state: ElementState) -> Counts {
    [state == ElementState::Built, state.is_obstacle(), state == ElementState::Removed].map(u32::from)
}

fn add(sum: &mut Counts, other: Counts) {
    sum.iter_mut().zip(other).for_each(|(sum, other)| *sum += other);
}

/// The state of the elements of a group in a run, over a period the union; `effects` is room for those of the run.
fn state_in_run(
    samples: &Samples,
    group: &[Effect],
    run: u32,
    period: Period,
    effects: &mut Vec<Effect>,
) -> ElementState {
    let dated = |effect: &Effect| match effect.task {
        NONE => *effect,
        task => {
            let [start_s, finish_s] = samples.dates_s(run, task);
            Effect { start_s, finish_s, ..*effect }
        }
    };
    let end_s = period.until_s.unwrap_or(period.from_s.saturating_add(1));
    if group.iter().all(|effect| !effect.removes) {
        // The usual case: from the first start on it is there, from the last finish on it stands.
        let (start_s, finish_s) = group.iter().map(dated).fold((i64::MAX, i64::MIN), |(start_s, finish_s), effect| {
            (start_s.min(effect.start_s), finish_s.max(effect.finish_s))
        });
        return match () {
            () if finish_s <= period.from_s => ElementState::Built,
            () if end_s <= start_s => ElementState::NotStarted,
            () => ElementState::InProgress,
        };
    }
    effects.clear();
    effects.extend(group.iter().map(dated));
    effects.sort_unstable();
    let element_timeline = ElementTimeline { effects: std::mem::take(effects), source: None };
    let (first, steps) = element_timeline.steps(Undated::Existing);
    *effects = element_timeline.effects;
    let mut of_element = Steps::default();
    of_element.push(first, steps.into_iter());
    union_of(of_element.within(0, period))
}
