//! Groups of elements whose states vary together.

use crate::task_effects::Effect;
use crate::timeline::Timeline;
use messages::NONE;
use std::collections::BTreeMap;

/// Elements whose states follow from the same effects of tasks.
pub(super) struct ElementGroups {
    /// Effects of each group; the dates of those that a task makes are its own in every run, and 0 here.
    pub(super) effects: Vec<Vec<Effect>>,
    /// The group of each element; `None` for elements without tasks, which do not vary.
    pub(super) of_element: Vec<Option<u32>>,
}

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
