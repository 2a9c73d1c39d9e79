//! Chooses few scan poses that together see enough faces: greedy set cover, then tabu search.

use crate::set_cover_instance::{CoverCounts, SetCoverInstance};
use crate::tabu_search::tabu_search;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Chosen sets that reach the goals, ascending. The greedy cover is improved by `steps` exchanges per set.
pub fn cover(instance: &SetCoverInstance, steps: u32) -> Vec<u32> {
    let mut chosen = greedy(instance);
    instance.remove_redundant(&mut chosen);
    chosen.sort_unstable();
    if steps > 0 && chosen.len() > 1 { tabu_search(instance, chosen, steps) } else { chosen }
}

/// Greedy cover: repeatedly the set with the most new faces, of equals the first; then sets for the goals of groups.
fn greedy(instance: &SetCoverInstance) -> Vec<u32> {
    let mut covered = CoverCounts::new(instance);
    let mut chosen = Vec::new();
    for only_lacking in [false, true] {
        // Gains only decrease: a set whose updated gain is still the largest is the best one.
        let gain = |covered: &CoverCounts<'_>, set: u32| {
            let is_new = |&&f: &&u32| covered.count[f as usize] == 0 && (!only_lacking || covered.is_group_short(f));
            instance.sets[set as usize].iter().filter(is_new).count()
        };
        let mut heap: BinaryHeap<(usize, Reverse<u32>)> =
            (0..instance.sets.len() as u32).map(|set| (gain(&covered, set), Reverse(set))).collect();
        while let Some((most, Reverse(set))) = heap.pop() {
            let done = if only_lacking { covered.n_short_groups == 0 } else { covered.n >= instance.goal };
            if most == 0 || done {
                break;
            }
            let now = gain(&covered, set);
            if heap.peek().is_some_and(|(next, Reverse(other))| (now, Reverse(set)) < (*next, Reverse(*other))) {
                heap.push((now, Reverse(set)));
            } else if now > 0 {
                covered.add(set);
                chosen.push(set);
            }
        }
    }
    chosen
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn the_search_finds_the_two_sets_that_greed_does_not() {
        // The largest set is a trap: it leaves a face on either side.
        let sets = vec![vec![1, 2, 3, 4, 5, 6], vec![0, 1, 2, 3], vec![4, 5, 6, 7]];
        let instance = SetCoverInstance::new(sets, vec![0; 8], 1.0, 1.0);
        assert_eq!(greedy(&instance).len(), 3);
        assert_eq!(cover(&instance, 100), [1, 2]);
    }

    #[test]
    fn the_share_that_may_be_left_out_is_never_a_whole_room() {
        // A hall of 98 faces, and a closet of two.
        let sets = vec![(0..98).collect(), vec![98, 99]];
        let groups: Vec<u32> = (0..100).map(|f| u32::from(f >= 98)).collect();
        assert_eq!(cover(&SetCoverInstance::new(sets.clone(), groups.clone(), 0.95, 0.0), 10), [0]);
        assert_eq!(cover(&SetCoverInstance::new(sets, groups, 0.95, 0.5), 10), [0, 1]);
    }

    /// The fewest sets that reach the goal, by trying all.
    fn fewest(instance: &SetCoverInstance) -> usize {
        let n = instance.sets.len();
        let of = |mask: u32| (0..n as u32).filter(|k| mask & (1 << k) != 0).collect::<Vec<_>>();
        (0..1u32 << n)
            .filter(|&mask| instance.is_covered_by(&of(mask)))
            .map(|m| m.count_ones() as usize)
            .min()
            .unwrap_or(0)
    }

    proptest! {
        #[test]
        fn covers_reach_the_goal_and_are_nearly_the_fewest(
            sets in prop::collection::vec(prop::collection::btree_set(0u32..24, 1..7), 1..11),
            share in 0.5f64..1.0,
        ) {
            let sets: Vec<Vec<u32>> = sets.into_iter().map(|s| s.into_iter().collect()).collect();
            let groups = (0..24).map(|f| f / 8).collect();
            let instance = SetCoverInstance::new(sets, groups, share, 0.6);
            let chosen = cover(&instance, 300);
            prop_assert!(instance.is_covered_by(&chosen));
            prop_assert!(chosen.len() <= fewest(&instance) + usize::from(fewest(&instance) > 4));
        }
    }
}
