//! Probabilities of element states: elements with the same tasks share a count over the runs.

use super::probabilities::Probabilities;
use super::samples::Samples;
use crate::element_timeline::ElementTimeline;
use crate::rules::Undated;
use crate::task_effects::Effect;
use crate::timeline::{Period, Steps, union_of};
use messages::{ElementState, NONE};

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

impl Probabilities<'_> {
    /// Probabilities of all elements at an instant, or over a period.
    pub fn elements(&self, period: Period) -> Vec<ElementProbability> {
        let groups = &self.groups.effects;
        let counts = self.samples.sums(3 * groups.len(), |run, sums| {
            let mut effects = Vec::new();
            for (sums, group) in sums.chunks_exact_mut(3).zip(groups) {
                let is_so = certainties(state_in_run(&self.samples, group, run, period, &mut effects));
                sums.iter_mut().zip(is_so).for_each(|(sum, is_so)| *sum += u32::from(is_so));
            }
        });
        let certain =
            |element| certainties(self.timeline.element_over(element, period)).map(|is_so| f64::from(u8::from(is_so)));
        let of_group = |group: u32| [0, 1, 2].map(|k| self.samples.share(counts[3 * group as usize + k]));
        let of_element = self.groups.of_element.iter().enumerate().map(|(element, group)| {
            let [stands, there, removed] = group.map_or_else(|| certain(element), of_group);
            ElementProbability { stands, there, removed }
        });
        of_element.collect()
    }
}

/// Whether an element in this state stands, is there, and is removed.
fn certainties(state: ElementState) -> [bool; 3] {
    [state == ElementState::Built, state.is_obstacle(), state == ElementState::Removed]
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
