//! Tabu search for a cover with fewer sets than the greedy one.
//!
//! Starting with one set less than the best cover, each step removes the set that alone covers the least weight and adds the
//! set that covers the most, until the goal is reached. Sets just added must not be removed, and sets just removed must not
//! be added again. Weights of uncovered faces in groups below their goal increase.
//!
//! # Source
//! Glover, "Tabu search, part I", ORSA Journal on Computing 1, 1989; the weights after Gao, Weise, Li, "RWLS: row weighting
//! local search for the unicost set covering problem", Applied Soft Computing 34, 2015.

use crate::random_generator::RandomGenerator;
use crate::set_cover_instance::{CoverCounts, FaceOwners, SetCoverInstance};

/// The smallest cover found within `steps` exchanges per set; `chosen` must reach the goal.
pub(crate) fn fewer_sets(instance: &SetCoverInstance, chosen: Vec<u32>, steps: u32) -> Vec<u32> {
    let mut search = TabuSearch::new(instance, &chosen);
    let steps = steps.saturating_mul(chosen.len() as u32);
    let (mut best, least) = (chosen, instance.least_sets());
    for step in 1..=steps {
        if best.len() <= least {
            break;
        }
        while search.covered.reaches_goals() {
            best.clone_from(&search.chosen);
            if best.len() < 2 {
                return best;
            }
            search.remove_cheapest(step);
        }
        search.remove_cheapest(step);
        search.add_best(step);
        search.raise_weights();
    }
    instance.remove_redundant(&mut best);
    best.sort_unstable();
    best
}

/// As many sets that cover the most faces found within `steps` exchanges per set, of those that `fits` accepts; `chosen` must
/// be accepted.
pub(crate) fn more_faces(
    instance: &SetCoverInstance,
    chosen: Vec<u32>,
    steps: u32,
    fits: impl Fn(&[u32]) -> bool,
) -> Vec<u32> {
    let mut search = TabuSearch::new(instance, &chosen);
    let steps = steps.saturating_mul(chosen.len() as u32);
    let (mut best, mut most) = (chosen, search.covered.n);
    for step in 1..=steps {
        search.remove_cheapest(step);
        while search.chosen.len() < best.len() && search.add_best(step) {}
        if search.covered.n > most && search.chosen.len() == best.len() && fits(&search.chosen) {
            most = search.covered.n;
            best.clone_from(&search.chosen);
        }
    }
    best
}

/// Every this many exchanges on average a random set is removed.
const RANDOM_REMOVAL_INTERVAL: usize = 20;

struct TabuSearch<'a> {
    instance: &'a SetCoverInstance,
    owners: FaceOwners,
    covered: CoverCounts<'a>,
    /// Exclusive or of the indices of the chosen sets that contain the face; for a single set, its index.
    sole: Vec<u32>,
    weight: Vec<i32>,
    /// For a chosen set the weight that it alone covers; for another the weight that it would add.
    score: Vec<i32>,
    chosen: Vec<u32>,
    is_chosen: Vec<bool>,
    /// Number of chosen sets that each set is in conflict with.
    n_conflicts: Vec<u16>,
    /// Step at which each set was last added or removed.
    changed: Vec<u32>,
    /// Step until which each set must stay as it is.
    tabu: Vec<u32>,
    random: RandomGenerator,
}

impl<'a> TabuSearch<'a> {
    fn new(instance: &'a SetCoverInstance, chosen: &[u32]) -> Self {
        let (n_sets, n_faces) = (instance.sets.len(), instance.groups.len());
        let mut search = Self {
            instance,
            owners: instance.owners(),
            covered: CoverCounts::new(instance),
            sole: vec![0; n_faces],
            weight: vec![1; n_faces],
            score: instance.sets.iter().map(|faces| faces.len() as i32).collect(),
            chosen: Vec::new(),
            is_chosen: vec![false; n_sets],
            n_conflicts: vec![0; n_sets],
            changed: vec![0; n_sets],
            tabu: vec![0; n_sets],
            random: RandomGenerator::default(),
        };
        chosen.iter().for_each(|&set| search.add(set, 0));
        search
    }

    fn add(&mut self, set: u32, step: u32) {
        self.score[set as usize] = 0;
        self.is_chosen[set as usize] = true;
        self.changed[set as usize] = step;
        self.chosen.push(set);
        self.instance.conflicts[set as usize].iter().for_each(|&near| self.n_conflicts[near as usize] += 1);
        for &face in &self.instance.sets[set as usize] {
            let f = face as usize;
            let weight = self.weight[f];
            match self.covered.add_face(face) {
                1 => {
                    for &other in self.owners.of_face(face) {
                        self.score[other as usize] -= weight;
                    }
                    // Its own weight was subtracted with those of the others.
                    self.score[set as usize] += 2 * weight;
                }
                2 => self.score[self.sole[f] as usize] -= weight,
                _ => {}
            }
            self.sole[f] ^= set;
        }
    }

    fn remove(&mut self, set: u32, step: u32) {
        self.is_chosen[set as usize] = false;
        self.changed[set as usize] = step;
        self.chosen.retain(|other| *other != set);
        self.score[set as usize] = 0;
        self.instance.conflicts[set as usize].iter().for_each(|&near| self.n_conflicts[near as usize] -= 1);
        for &face in &self.instance.sets[set as usize] {
            let f = face as usize;
            self.sole[f] ^= set;
            let weight = self.weight[f];
            match self.covered.remove_face(face) {
                0 => {
                    for &other in self.owners.of_face(face) {
                        self.score[other as usize] += weight;
                    }
                }
                1 => self.score[self.sole[f] as usize] += weight,
                _ => {}
            }
        }
    }

    /// Removes the chosen set that alone covers the least weight.
    fn remove_cheapest(&mut self, step: u32) {
        let any = (self.random.below(RANDOM_REMOVAL_INTERVAL) == 0).then(|| self.random.below(self.chosen.len()));
        let is_free = |set: u32| self.tabu[set as usize] < step;
        let key = |&&set: &&u32| (!is_free(set), self.score[set as usize], self.changed[set as usize], set);
        let set = any.map(|k| self.chosen[k]).or_else(|| self.chosen.iter().min_by_key(key).copied());
        if let Some(set) = set {
            self.remove(set, step);
            self.tabu[set as usize] = step + 2 + self.random.below(self.chosen.len() / 2 + 3) as u32;
        }
    }

    /// Adds the set that covers the most weight. False if every other set is in conflict with a chosen one.
    fn add_best(&mut self, step: u32) -> bool {
        let mut best: Option<usize> = None;
        for set in 0..self.score.len() {
            if self.is_chosen[set] || self.n_conflicts[set] > 0 || self.tabu[set] >= step {
                continue;
            }
            let is_better = best.is_none_or(|b| {
                self.score[b] < self.score[set]
                    || (self.score[b] == self.score[set] && self.changed[set] < self.changed[b])
            });
            if is_better {
                best = Some(set);
            }
        }
        // If all are tabu, the one whose tabu ends first.
        let is_open = |&set: &usize| !self.is_chosen[set] && self.n_conflicts[set] == 0;
        let next = || (0..self.score.len()).filter(is_open).min_by_key(|&s| (self.tabu[s], s));
        let Some(set) = best.or_else(next) else { return false };
        self.add(set as u32, step);
        self.tabu[set] = step + 1 + self.random.below(self.chosen.len() / 4 + 2) as u32;
        true
    }

    /// Raises the weights of uncovered faces in groups below their goal.
    fn raise_weights(&mut self) {
        if self.covered.n_short_groups == 0 {
            return;
        }
        for face in 0..self.weight.len() {
            if self.covered.count[face] == 0 && self.covered.is_group_short(face as u32) {
                self.weight[face] += 1;
                for &owner in self.owners.of_face(face as u32) {
                    self.score[owner as usize] += 1;
                }
            }
        }
    }
}
