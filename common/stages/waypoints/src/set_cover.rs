//! Chooses few scan poses that together see enough faces: greedy set cover, then a search in one window after the other.

use crate::set_cover_instance::{CoverCounts, SetCoverInstance};
use crate::tabu_search::fewer_sets;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Chosen sets that reach the goals as far as conflicts allow, ascending. The greedy cover is improved by `steps` exchanges
/// per set.
pub fn cover(instance: &SetCoverInstance, steps: u32) -> Vec<u32> {
    let chosen = completed(instance, Vec::new());
    if steps > 0 && instance.is_covered_by(&chosen) { search_windows(instance, chosen, steps) } else { chosen }
}

/// Adds sets greedily to some chosen ones until the goals are reached as far as conflicts allow, and removes redundant ones.
pub(crate) fn completed(instance: &SetCoverInstance, chosen: Vec<u32>) -> Vec<u32> {
    let mut chosen = greedy(instance, chosen);
    instance.remove_redundant(&mut chosen);
    chosen.sort_unstable();
    chosen
}

/// Which sets a greedy pass takes.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Pass {
    /// Until the goal for all faces is reached.
    All,
    /// For groups below their goal.
    Groups,
    /// For groups below their goal, also sets in conflict with chosen ones.
    GroupsDespiteConflicts,
}

/// Greedy cover: repeatedly the set with the most new faces, of equals the first; then sets for the goals of groups.
fn greedy(instance: &SetCoverInstance, mut chosen: Vec<u32>) -> Vec<u32> {
    let mut covered = CoverCounts::new(instance);
    let mut is_excluded = vec![false; instance.sets.len()];
    for &set in &chosen {
        covered.add(set);
        instance.conflicts[set as usize].iter().for_each(|&near| is_excluded[near as usize] = true);
    }
    for pass in [Pass::All, Pass::Groups, Pass::GroupsDespiteConflicts] {
        let is_done = |covered: &CoverCounts<'_>| match pass {
            Pass::All => covered.n >= instance.goal,
            _ => covered.n_short_groups == 0,
        };
        // Gains only decrease: a set whose updated gain is still the largest is the best one.
        let gain = |covered: &CoverCounts<'_>, set: u32| {
            let is_new =
                |&&f: &&u32| covered.count[f as usize] == 0 && (pass == Pass::All || covered.is_group_short(f));
            instance.sets[set as usize].iter().filter(is_new).count()
        };
        if is_done(&covered) {
            continue;
        }
        let mut heap: BinaryHeap<(usize, Reverse<u32>)> =
            (0..instance.sets.len() as u32).map(|set| (gain(&covered, set), Reverse(set))).collect();
        while let Some((most, Reverse(set))) = heap.pop() {
            if most == 0 || is_done(&covered) {
                break;
            }
            if is_excluded[set as usize] && pass != Pass::GroupsDespiteConflicts {
                continue;
            }
            let now = gain(&covered, set);
            if heap.peek().is_some_and(|(next, Reverse(other))| (now, Reverse(set)) < (*next, Reverse(*other))) {
                heap.push((now, Reverse(set)));
            } else if now > 0 {
                covered.add(set);
                chosen.push(set);
                instance.conflicts[set as usize].iter().for_each(|&near| is_excluded[near as usize] = true);
            }
        }
    }
    chosen
}

/// Searches for fewer sets in one window after the other, while the sets of the others stay: the effort is linear in windows.
fn search_windows(instance: &SetCoverInstance, mut chosen: Vec<u32>, steps: u32) -> Vec<u32> {
    let n_windows = instance.windows.iter().max().map_or(0, |window| *window as usize + 1);
    let mut sets_of_window: Vec<Vec<u32>> = vec![Vec::new(); n_windows];
    (0..).zip(&instance.windows).for_each(|(set, &window)| sets_of_window[window as usize].push(set));
    let mut chosen_of_window: Vec<Vec<u32>> = vec![Vec::new(); n_windows];
    let window_of = |set: u32| instance.windows[set as usize] as usize;
    chosen.iter().for_each(|&set| chosen_of_window[window_of(set)].push(set));
    let mut covered = CoverCounts::new(instance);
    chosen.iter().for_each(|&set| covered.add(set));
    let mut n_conflicts = vec![0u16; instance.sets.len()];
    let conflicts = |set: u32| instance.conflicts[set as usize].iter().map(|&near| near as usize);
    chosen.iter().flat_map(|&set| conflicts(set)).for_each(|near| n_conflicts[near] += 1);
    let mut number = vec![u32::MAX; instance.groups.len()];
    for (own, sets) in chosen_of_window.iter_mut().zip(&sets_of_window).filter(|(own, _)| own.len() > 1) {
        for &set in own.iter() {
            covered.remove(set);
            conflicts(set).for_each(|near| n_conflicts[near] -= 1);
        }
        let is_free = |set: &u32| n_conflicts[*set as usize] == 0 || own.binary_search(set).is_ok();
        let sets: Vec<u32> = sets.iter().copied().filter(is_free).collect();
        let section = section(instance, &covered, &sets, &mut number);
        let in_section = own.iter().filter_map(|set| sets.binary_search(set).ok()).map(|set| set as u32).collect();
        *own = fewer_sets(&section, in_section, steps).into_iter().map(|set| sets[set as usize]).collect();
        for &set in own.iter() {
            covered.add(set);
            conflicts(set).for_each(|near| n_conflicts[near] += 1);
        }
    }
    chosen = chosen_of_window.into_iter().flatten().collect();
    chosen.sort_unstable();
    chosen
}

/// The instance of some sets, ascending, for the faces that nothing covers yet. `number` is a buffer, one entry a face.
fn section(
    instance: &SetCoverInstance,
    covered: &CoverCounts<'_>,
    sets: &[u32],
    number: &mut [u32],
) -> SetCoverInstance {
    let mut groups = Vec::new();
    let mut faces_of = |set: &u32| {
        let open = instance.sets[*set as usize].iter().filter(|&&face| covered.count[face as usize] == 0);
        let mut renumber = |&face: &u32| {
            let number = &mut number[face as usize];
            if *number == u32::MAX {
                *number = groups.len() as u32;
                groups.push(instance.groups[face as usize]);
            }
            *number
        };
        open.map(&mut renumber).collect::<Vec<u32>>()
    };
    let sections: Vec<Vec<u32>> = sets.iter().map(&mut faces_of).collect();
    sets.iter().flat_map(|&set| &instance.sets[set as usize]).for_each(|&face| number[face as usize] = u32::MAX);
    let position = |near: &u32| sets.binary_search(near).ok().map(|near| near as u32);
    let conflicts = |&set: &u32| instance.conflicts[set as usize].iter().filter_map(position).collect();
    SetCoverInstance {
        sets: sections,
        goal: instance.goal.saturating_sub(covered.n),
        group_goals: covered.group_goals_left(),
        conflicts: sets.iter().map(conflicts).collect(),
        windows: vec![0; sets.len()],
        groups,
    }
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
        assert_eq!(greedy(&instance, Vec::new()).len(), 3);
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
