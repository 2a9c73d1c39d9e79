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
use crate::set_cover_instance::{CoverCounts, SetCoverInstance};

/// The smallest cover found within `steps` exchanges per set; `chosen` must reach the goal.
pub(crate) fn tabu_search(instance: &SetCoverInstance, chosen: Vec<u32>, steps: u32) -> Vec<u32> {
    let mut search = TabuSearch::new(instance, &chosen);
    let steps = steps.saturating_mul(chosen.len() as u32);
    let mut best = chosen;
    for step in 1..=steps {
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

/// Every this many exchanges on average a random set is removed.
const RANDOM_REMOVAL_INTERVAL: usize = 20;

struct TabuSearch<'a> {
    instance: &'a SetCoverInstance,
    /// Sets that contain each face: `owners[first[f]..first[f + 1]]`.
    owners: Vec<u32>,
    first: Vec<u32>,
    covered: CoverCounts<'a>,
    /// Exclusive or of the indices of the chosen sets that contain the face; for a single set, its index.
    sole: Vec<u32>,
    weight: Vec<i32>,
    /// For a chosen set the weight that it alone covers; for another the weight that it would add.
    score: Vec<i32>,
    chosen: Vec<u32>,
    is_chosen: Vec<bool>,
    /// Step at which each set was last added or removed.
    changed: Vec<u32>,
    /// Step until which each set must stay as it is.
    tabu: Vec<u32>,
    random: RandomGenerator,
}

impl<'a> TabuSearch<'a> {
    fn new(instance: &'a SetCoverInstance, chosen: &[u32]) -> Self {
        let (n_sets, n_faces) = (instance.sets.len(), instance.groups.len());
        let mut first = vec![0u32; n_faces + 1];
        instance.sets.iter().flatten().for_each(|&f| first[f as usize + 1] += 1);
        for k in 1..first.len() {
            first[k] += first[k - 1];
        }
        let mut next = first.clone();
        let mut owners = vec![0u32; first[n_faces] as usize];
        for (set, faces) in instance.sets.iter().enumerate() {
            for &f in faces {
                owners[next[f as usize] as usize] = set as u32;
                next[f as usize] += 1;
            }
        }
        let mut search = Self {
            instance,
            owners,
            first,
            covered: CoverCounts::new(instance),
            sole: vec![0; n_faces],
            weight: vec![1; n_faces],
            score: instance.sets.iter().map(|faces| faces.len() as i32).collect(),
            chosen: Vec::new(),
            is_chosen: vec![false; n_sets],
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
        for &face in &self.instance.sets[set as usize] {
            let f = face as usize;
            let weight = self.weight[f];
            match self.covered.add_face(face) {
                1 => {
                    for k in self.first[f]..self.first[f + 1] {
                        let other = self.owners[k as usize] as usize;
                        self.score[other] -= weight;
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
        for &face in &self.instance.sets[set as usize] {
            let f = face as usize;
            self.sole[f] ^= set;
            let weight = self.weight[f];
            match self.covered.remove_face(face) {
                0 => {
                    for k in self.first[f]..self.first[f + 1] {
                        let other = self.owners[k as usize] as usize;
                        self.score[other] += weight;
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

    /// Adds the set that covers the most weight.
    fn add_best(&mut self, step: u32) {
        let mut best: Option<usize> = None;
        for set in 0..self.score.len() {
            if self.is_chosen[set] || self.tabu[set] >= step {
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
        let next = || (0..self.score.len()).filter(|&s| !self.is_chosen[s]).min_by_key(|&s| (self.tabu[s], s));
        if let Some(set) = best.or_else(next) {
            self.add(set as u32, step);
            self.tabu[set] = step + 1 + self.random.below(self.chosen.len() / 4 + 2) as u32;
        }
    }

    /// Raises the weights of uncovered faces in groups below their goal.
    fn raise_weights(&mut self) {
        if self.covered.n_short_groups == 0 {
            return;
        }
        for face in 0..self.weight.len() {
            if self.covered.count[face] == 0 && self.covered.is_group_short(face as u32) {
                self.weight[face] += 1;
                for k in self.first[face]..self.first[face + 1] {
                    self.score[self.owners[k as usize] as usize] += 1;
                }
            }
        }
    }
}
