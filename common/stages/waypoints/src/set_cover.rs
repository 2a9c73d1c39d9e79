//! Few sets that together hold enough: which places to scan from.
//!
//! Every place is the set of the faces that it sees. The goal is a number of faces, and a number in each group of faces (a
//! space), so that the share that may be left out is never a whole room.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// What is to be covered with what.
#[derive(Debug, Default)]
pub struct Instance {
    /// Faces of each set, ascending.
    pub sets: Vec<Vec<u32>>,
    /// Group of each face.
    pub groups: Vec<u32>,
    /// Faces that must be covered.
    pub goal: usize,
    /// Faces that must be covered of each group.
    pub group_goals: Vec<usize>,
}

impl Instance {
    /// From sets of faces and the group of each face: `share` of the faces that any set holds, and `group_share` of those of
    /// each group.
    pub(crate) fn new(sets: Vec<Vec<u32>>, groups: Vec<u32>, share: f64, group_share: f64) -> Self {
        let n_groups = groups.iter().max().map_or(0, |g| *g as usize + 1);
        let mut held = vec![false; groups.len()];
        sets.iter().flatten().for_each(|&f| held[f as usize] = true);
        let mut n_held = vec![0usize; n_groups];
        for (&group, _) in groups.iter().zip(&held).filter(|(_, held)| **held) {
            n_held[group as usize] += 1;
        }
        let part = |share: f64, n: usize| ((share * n as f64 - 1e-9).ceil().max(0.0) as usize).min(n);
        let goal = part(share, n_held.iter().sum());
        let group_goals = n_held.iter().map(|&n| part(group_share.min(share), n)).collect();
        Self { sets, groups, goal, group_goals }
    }

    /// True if the sets reach the goals.
    pub fn is_covered_by(&self, sets: &[u32]) -> bool {
        let mut covered = Covered::new(self);
        sets.iter().for_each(|&set| covered.add(set));
        covered.is_enough()
    }

    /// Numbers of chosen sets that reach the goal, ascending. `steps` exchanges for each set look for fewer than a greedy choice
    /// gives.
    pub fn cover(&self, steps: u32) -> Vec<u32> {
        let mut chosen = self.greedy();
        self.drop_needless(&mut chosen);
        chosen.sort_unstable();
        if steps > 0 && chosen.len() > 1 { crate::search::fewer(self, chosen, steps) } else { chosen }
    }

    /// The set with the most new faces again and again, of equals the first; then those that reach the goals of groups.
    fn greedy(&self) -> Vec<u32> {
        let mut covered = Covered::new(self);
        let mut chosen = Vec::new();
        for only_lacking in [false, true] {
            // Gains only fall: a set whose gain was counted again and is still the largest is the largest.
            let gain = |covered: &Covered<'_>, set: u32| {
                let is_new = |&&f: &&u32| covered.count[f as usize] == 0 && (!only_lacking || covered.is_lacking(f));
                self.sets[set as usize].iter().filter(is_new).count()
            };
            let mut heap: BinaryHeap<(usize, Reverse<u32>)> =
                (0..self.sets.len() as u32).map(|set| (gain(&covered, set), Reverse(set))).collect();
            while let Some((most, Reverse(set))) = heap.pop() {
                let done = if only_lacking { covered.n_lacking == 0 } else { covered.n >= self.goal };
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

    /// Takes out sets without which the goal is still reached, those with the fewest faces of their own first.
    pub(crate) fn drop_needless(&self, chosen: &mut Vec<u32>) {
        let mut covered = Covered::new(self);
        chosen.iter().for_each(|&set| covered.add(set));
        loop {
            let own = |set: u32| self.sets[set as usize].iter().filter(|&&f| covered.count[f as usize] == 1).count();
            let mut order: Vec<(usize, usize)> = chosen.iter().enumerate().map(|(at, &set)| (own(set), at)).collect();
            order.sort_unstable();
            let needless = order.iter().map(|o| o.1).find(|&at| {
                covered.remove(chosen[at]);
                let still = covered.is_enough();
                if !still {
                    covered.add(chosen[at]);
                }
                still
            });
            let Some(at) = needless else { return };
            chosen.remove(at);
        }
    }
}

/// How often each face is covered, and what is missing.
pub(crate) struct Covered<'a> {
    instance: &'a Instance,
    pub(crate) count: Vec<u16>,
    /// Faces that are covered.
    pub(crate) n: usize,
    of_group: Vec<usize>,
    /// Groups that have not reached their goal.
    pub(crate) n_lacking: usize,
}

impl<'a> Covered<'a> {
    pub(crate) fn new(instance: &'a Instance) -> Self {
        Self {
            instance,
            count: vec![0; instance.groups.len()],
            n: 0,
            of_group: vec![0; instance.group_goals.len()],
            n_lacking: instance.group_goals.iter().filter(|g| **g > 0).count(),
        }
    }

    /// True if all goals are reached.
    pub(crate) fn is_enough(&self) -> bool {
        self.n >= self.instance.goal && self.n_lacking == 0
    }

    /// True if the face's group has not reached its goal.
    pub(crate) fn is_lacking(&self, face: u32) -> bool {
        let group = self.instance.groups[face as usize] as usize;
        self.of_group[group] < self.instance.group_goals[group]
    }

    pub(crate) fn add(&mut self, set: u32) {
        for &face in &self.instance.sets[set as usize] {
            self.add_face(face);
        }
    }

    pub(crate) fn remove(&mut self, set: u32) {
        for &face in &self.instance.sets[set as usize] {
            self.remove_face(face);
        }
    }

    /// Returns how often the face is covered now.
    pub(crate) fn add_face(&mut self, face: u32) -> u16 {
        let count = &mut self.count[face as usize];
        *count += 1;
        if *count == 1 {
            let group = self.instance.groups[face as usize] as usize;
            self.n += 1;
            self.of_group[group] += 1;
            self.n_lacking -= usize::from(self.of_group[group] == self.instance.group_goals[group]);
        }
        *count
    }

    /// Returns how often the face is covered now.
    pub(crate) fn remove_face(&mut self, face: u32) -> u16 {
        let count = &mut self.count[face as usize];
        *count -= 1;
        if *count == 0 {
            let group = self.instance.groups[face as usize] as usize;
            self.n -= 1;
            self.n_lacking += usize::from(self.of_group[group] == self.instance.group_goals[group]);
            self.of_group[group] -= 1;
        }
        *count
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
        let instance = Instance::new(sets, vec![0; 8], 1.0, 1.0);
        assert_eq!(instance.greedy().len(), 3);
        assert_eq!(instance.cover(100), [1, 2]);
    }

    #[test]
    fn the_share_that_may_be_left_out_is_never_a_whole_room() {
        // A hall of 98 faces, and a closet of two.
        let sets = vec![(0..98).collect(), vec![98, 99]];
        let groups: Vec<u32> = (0..100).map(|f| u32::from(f >= 98)).collect();
        assert_eq!(Instance::new(sets.clone(), groups.clone(), 0.95, 0.0).cover(10), [0]);
        assert_eq!(Instance::new(sets, groups, 0.95, 0.5).cover(10), [0, 1]);
    }

    /// The fewest sets that reach the goal, by trying all.
    fn fewest(instance: &Instance) -> usize {
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
            let instance = Instance::new(sets, groups, share, 0.6);
            let chosen = instance.cover(300);
            prop_assert!(instance.is_covered_by(&chosen));
            prop_assert!(chosen.len() <= fewest(&instance) + usize::from(fewest(&instance) > 4));
        }
    }
}
