//! Scans in the order in which a plan grows: each sees most of what is left and registers with those before it. The order
//! gives the coverage curve, and the scans that a budget pays for.

use crate::set_cover_instance::{FaceOwners, SetCoverInstance};
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// A scan of the growing plan.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct GrownScan {
    pub(crate) set: u32,
    /// Faces that it covers and no scan before it.
    pub(crate) n_new: u32,
    /// True if it was chosen so that the next one registers.
    pub(crate) connects: bool,
}

/// Number of faces of a set that scans before it must cover, so that it registers.
pub(crate) fn n_needed(overlap: f64, n_faces: usize) -> usize {
    (overlap * n_faces as f64 - 1e-9).ceil().max(0.0) as usize
}

/// The scans in order, until no other one covers a new face. The first of each part (`parts`, by set) needs no overlap.
/// Of a pair of which one joins the other, the faces of both count for each; of equals the lower set comes first.
pub(crate) fn grow(instance: &SetCoverInstance, owners: &FaceOwners, parts: &[u32], overlap: f64) -> Vec<GrownScan> {
    let n_sets = instance.sets.len();
    let mut growth = Growth {
        instance,
        owners,
        parts,
        overlap,
        gain_max: instance.sets.iter().map(|faces| (faces.len() - n_needed(overlap, faces.len())) as u32).collect(),
        gain: instance.sets.iter().map(|faces| faces.len() as u32).collect(),
        is_covered: vec![false; instance.groups.len()],
        is_excluded: vec![false; n_sets],
        is_deferred: vec![false; n_sets],
        has_scan: vec![false; parts.iter().max().map_or(0, |part| *part as usize + 1)],
        registrable: BinaryHeap::new(),
        others: BinaryHeap::new(),
        shared: vec![0; n_sets],
        order: Vec::new(),
    };
    (0..n_sets as u32).for_each(|set| growth.push(set));
    while growth.step() {}
    growth.order
}

struct Growth<'a> {
    instance: &'a SetCoverInstance,
    owners: &'a FaceOwners,
    /// Part of each set.
    parts: &'a [u32],
    overlap: f64,
    /// Most uncovered faces with which each set registers.
    gain_max: Vec<u32>,
    /// Uncovered faces of each set.
    gain: Vec<u32>,
    is_covered: Vec<bool>,
    /// Sets that are chosen, or too near to a chosen one.
    is_excluded: Vec<bool>,
    /// Sets that no scan joins as long as nothing more of them is covered.
    is_deferred: Vec<bool>,
    /// Parts with a scan.
    has_scan: Vec<bool>,
    /// Sets that register, by gain. Entries whose gain has changed since are replaced when they come up.
    registrable: BinaryHeap<(u32, Reverse<u32>)>,
    /// The same for sets that do not register yet.
    others: BinaryHeap<(u32, Reverse<u32>)>,
    /// Faces shared with a set, by set; zero between searches.
    shared: Vec<u32>,
    order: Vec<GrownScan>,
}

impl Growth<'_> {
    fn registers(&self, set: u32) -> bool {
        self.gain[set as usize] <= self.gain_max[set as usize] || !self.has_scan[self.parts[set as usize] as usize]
    }

    fn push(&mut self, set: u32) {
        let gain = self.gain[set as usize];
        if gain > 0 && !self.is_excluded[set as usize] {
            let entry = (gain, Reverse(set));
            if self.registers(set) { self.registrable.push(entry) } else { self.others.push(entry) }
        }
    }

    /// The best entry that is still true.
    fn best(&mut self, registers: bool) -> Option<(u32, u32)> {
        loop {
            let heap = if registers { &mut self.registrable } else { &mut self.others };
            let &(gain, Reverse(set)) = heap.peek()?;
            let is_true =
                gain == self.gain[set as usize] && !self.is_excluded[set as usize] && self.registers(set) == registers;
            if is_true {
                return Some((gain, set));
            }
            if registers {
                self.registrable.pop()
            } else {
                self.others.pop()
            };
            self.push(set);
        }
    }

    /// Chooses the next scan, or a pair. False if no scan covers anything new.
    fn step(&mut self) -> bool {
        let (alone, other) = (self.best(true), self.best(false));
        let gain_alone = alone.map_or(0, |best| best.0);
        // A pair counts as two scans.
        let pair = other.filter(|best| best.0 > 2 * gain_alone).and_then(|(_, set)| {
            let join = self.join_of(set);
            if join.is_none() && alone.is_some() {
                self.others.pop();
                self.is_deferred[set as usize] = true;
            }
            join.map(|join| (join, set))
        });
        match (pair, alone, other) {
            (Some((join, set)), _, _) => {
                self.choose(join, true);
                self.choose(set, false);
            }
            (None, Some((_, set)), _) | (None, None, Some((_, set))) => self.choose(set, false),
            (None, None, None) => return self.push_deferred(),
        }
        true
    }

    /// False if there is none.
    fn push_deferred(&mut self) -> bool {
        let deferred: Vec<u32> = (0..).zip(&self.is_deferred).filter(|(_, is)| **is).map(|(set, _)| set).collect();
        self.is_deferred.fill(false);
        deferred.iter().for_each(|&set| self.push(set));
        !deferred.is_empty()
    }

    fn choose(&mut self, set: u32, connects: bool) {
        self.order.push(GrownScan { set, n_new: self.gain[set as usize], connects });
        self.is_excluded[set as usize] = true;
        self.instance.conflicts[set as usize].iter().for_each(|&near| self.is_excluded[near as usize] = true);
        self.has_scan[self.parts[set as usize] as usize] = true;
        for &face in &self.instance.sets[set as usize] {
            if std::mem::replace(&mut self.is_covered[face as usize], true) {
                continue;
            }
            for &owner in self.owners.of_face(face) {
                self.gain[owner as usize] -= 1;
                let begins_to_register = self.gain[owner as usize] == self.gain_max[owner as usize];
                if begins_to_register || std::mem::take(&mut self.is_deferred[owner as usize]) {
                    self.push(owner);
                }
            }
        }
    }

    /// The scan after which a set registers: it registers itself, and both together cover the most.
    fn join_of(&mut self, set: u32) -> Option<u32> {
        let (faces, mut sharing) = (&self.instance.sets[set as usize], Vec::new());
        for &face in faces.iter().filter(|face| !self.is_covered[**face as usize]) {
            for &owner in self.owners.of_face(face) {
                if self.shared[owner as usize] == 0 {
                    sharing.push(owner);
                }
                self.shared[owner as usize] += 1;
            }
        }
        let gain = self.gain[set as usize] as usize;
        let n_missing = n_needed(self.overlap, faces.len()).saturating_sub(faces.len() - gain);
        let excluded_by_set = &self.instance.conflicts[set as usize];
        let joins = |&&join: &&u32| {
            join != set
                && !self.is_excluded[join as usize]
                && self.shared[join as usize] as usize >= n_missing
                && self.registers(join)
                && excluded_by_set.binary_search(&join).is_err()
        };
        let n_both = |join: u32| self.gain[join as usize] - self.shared[join as usize];
        let best = sharing.iter().filter(joins).copied().max_by_key(|&join| (n_both(join), Reverse(join)));
        sharing.into_iter().for_each(|owner| self.shared[owner as usize] = 0);
        best
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn grown(sets: Vec<Vec<u32>>, n_faces: usize, parts: &[u32], overlap: f64) -> Vec<GrownScan> {
        let instance = SetCoverInstance::new(sets, vec![0; n_faces], 1.0, 1.0);
        grow(&instance, &instance.owners(), parts, overlap)
    }

    #[test]
    fn a_scan_that_lets_a_large_one_register_comes_before_smaller_ones() {
        // The second room is seen from its door, and by little else.
        let (first, door) = ((0..10).collect(), vec![8, 9, 10, 11]);
        let (second, small) = ((10..30).collect(), vec![7, 8, 9, 30]);
        let growth = grown(vec![first, second, small, door], 31, &[0; 4], 0.1);
        let sets: Vec<(u32, bool)> = growth.iter().map(|scan| (scan.set, scan.connects)).collect();
        assert_eq!(sets, [(1, false), (3, true), (0, false), (2, false)]);
        assert_eq!(growth.iter().map(|scan| scan.n_new).collect::<Vec<_>>(), [20, 2, 8, 1]);
    }

    #[test]
    fn the_first_scan_of_a_part_needs_no_overlap() {
        let growth = grown(vec![vec![0, 1, 2], vec![3, 4]], 5, &[0, 1], 0.5);
        assert_eq!(growth.iter().map(|scan| scan.set).collect::<Vec<_>>(), [0, 1]);
    }

    proptest! {
        #[test]
        fn a_growth_covers_everything_and_counts_what_is_new(
            sets in prop::collection::vec(prop::collection::btree_set(0u32..30, 1..9), 1..12),
            overlap in 0.0f64..0.6,
        ) {
            let sets: Vec<Vec<u32>> = sets.into_iter().map(|set| set.into_iter().collect()).collect();
            let growth = grown(sets.clone(), 30, &vec![0; sets.len()], overlap);
            let mut covered = std::collections::BTreeSet::new();
            for scan in &growth {
                let n_before = covered.len();
                covered.extend(&sets[scan.set as usize]);
                prop_assert_eq!(covered.len() - n_before, scan.n_new as usize);
            }
            prop_assert_eq!(covered, sets.iter().flatten().collect::<std::collections::BTreeSet<_>>());
        }
    }
}
