//! Registration of scans with each other: by which the scans of a plan can be put into one frame, and the joining scans that
//! are added where that fails.
//!
//! A scan registers if the scans registered before it, in any order, saw enough of its faces. The first scan of each part of
//! the floor needs none.

use crate::scan_growth::n_needed;
use crate::set_cover_instance::{FaceOwners, SetCoverInstance};

/// A scan of a plan.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct RegisteredScan {
    pub(crate) set: u32,
    /// Share of its faces that the scans registered before it saw.
    pub(crate) overlap: f64,
    /// True if it registers, or is the first of its part.
    pub(crate) registers: bool,
    /// For a joining scan, what it is there for.
    pub(crate) joins: Option<Joined>,
}

/// A scan that does not register without a joining scan.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Joined {
    pub(crate) set: u32,
    /// Share of its faces that the scans that register without the joining scan saw.
    pub(crate) overlap_without: f64,
}

/// Registers the scans of a storey.
pub(crate) struct Registration<'a> {
    pub(crate) instance: &'a SetCoverInstance,
    /// Of all sets.
    pub(crate) owners: &'a FaceOwners,
    /// Part of each set.
    pub(crate) parts: &'a [u32],
    pub(crate) overlap: f64,
}

impl Registration<'_> {
    /// The scans of a plan in the order in which they register, with joining scans between them.
    pub(crate) fn joined(&self, chosen: &[u32]) -> Vec<RegisteredScan> {
        let mut all = chosen.to_vec();
        let mut joins = Vec::new();
        while let Some(join) = self.missing_join(&all) {
            all.push(join);
            joins.push(join);
        }
        // A later one may have made an earlier one needless.
        let mut state = State::new(self, &all);
        let n_unregistered = |order: &[RegisteredScan]| order.iter().filter(|scan| !scan.registers).count();
        let n_left = n_unregistered(&state.order(&[]));
        let mut needless = Vec::new();
        for at in (chosen.len()..all.len()).rev() {
            needless.push(at);
            if n_unregistered(&state.order(&needless)) > n_left {
                needless.pop();
            }
        }
        let is_kept = |set: &u32| !needless.iter().any(|&at| all[at] == *set);
        joins.retain(is_kept);
        let kept: Vec<u32> = all.iter().copied().filter(is_kept).collect();
        self.with_reasons(&kept, &joins)
    }

    /// The scans in the order in which they register; `joins` among them with the scan that each is there for.
    pub(crate) fn with_reasons(&self, all: &[u32], joins: &[u32]) -> Vec<RegisteredScan> {
        let mut state = State::new(self, all);
        let mut scans = state.order(&[]);
        for scan in scans.iter_mut().filter(|scan| joins.contains(&scan.set)) {
            let without: Vec<usize> = (0..all.len()).filter(|&at| all[at] == scan.set).collect();
            let unregistered = state.order(&without).into_iter().find(|scan| !scan.registers);
            scan.joins = unregistered.map(|other| Joined { set: other.set, overlap_without: other.overlap });
        }
        scans
    }

    pub(crate) fn n_unregistered(&self, chosen: &[u32]) -> usize {
        State::new(self, chosen).order(&[]).iter().filter(|scan| !scan.registers).count()
    }

    /// The scan that lets one more register: it registers itself, keeps its distance, and shares the most with the other.
    fn missing_join(&self, chosen: &[u32]) -> Option<u32> {
        let mut state = State::new(self, chosen);
        while let Some((at, true)) = state.next() {
            state.register(at);
        }
        let n_sets = self.instance.sets.len();
        let mut is_excluded = vec![false; n_sets];
        for &set in chosen {
            is_excluded[set as usize] = true;
            self.instance.conflicts[set as usize].iter().for_each(|&near| is_excluded[near as usize] = true);
        }
        let mut n_shared = vec![0u32; n_sets];
        let mut left = state.left.clone();
        left.sort_by(|&a, &b| state.overlap(b).total_cmp(&state.overlap(a)).then(a.cmp(&b)));
        for at in left {
            let faces = &self.instance.sets[chosen[at] as usize];
            let mut sharing = Vec::new();
            for &face in faces.iter().filter(|face| !state.is_seen[**face as usize]) {
                for &owner in self.owners.of_face(face) {
                    if n_shared[owner as usize] == 0 {
                        sharing.push(owner);
                    }
                    n_shared[owner as usize] += 1;
                }
            }
            let n_missing = n_needed(self.overlap, faces.len()).saturating_sub(state.n_seen[at] as usize);
            let joins = |&&set: &&u32| {
                let own = &self.instance.sets[set as usize];
                let n_seen = || own.iter().filter(|&&face| state.is_seen[face as usize]).count();
                !is_excluded[set as usize]
                    && n_shared[set as usize] as usize >= n_missing
                    && n_seen() >= n_needed(self.overlap, own.len())
            };
            let best =
                sharing.iter().filter(joins).max_by_key(|&&set| (n_shared[set as usize], std::cmp::Reverse(set)));
            if let Some(&best) = best {
                return Some(best);
            }
            sharing.iter().for_each(|&set| n_shared[set as usize] = 0);
        }
        None
    }
}

/// Which scans of a plan are registered, and what they saw.
struct State<'a> {
    registration: &'a Registration<'a>,
    chosen: &'a [u32],
    /// Indices among the chosen by face.
    owners: FaceOwners,
    /// Faces of each chosen set, and how many of them must be seen before it registers.
    n_faces: Vec<usize>,
    n_needed: Vec<usize>,
    /// Indices of those that are not registered, ascending.
    left: Vec<usize>,
    is_seen: Vec<bool>,
    /// Faces of each chosen set that are seen.
    n_seen: Vec<u32>,
    /// Parts with a registered scan.
    has_scan: Vec<bool>,
}

impl<'a> State<'a> {
    fn new(registration: &'a Registration<'a>, chosen: &'a [u32]) -> Self {
        let instance = registration.instance;
        let faces = (0..).zip(chosen.iter().map(|&set| instance.sets[set as usize].as_slice()));
        let n_parts = registration.parts.iter().max().map_or(0, |part| *part as usize + 1);
        let n_faces: Vec<usize> = chosen.iter().map(|&set| instance.sets[set as usize].len()).collect();
        Self {
            owners: FaceOwners::of(instance.groups.len(), faces),
            n_needed: n_faces.iter().map(|&n| n_needed(registration.overlap, n)).collect(),
            n_faces,
            left: (0..chosen.len()).collect(),
            is_seen: vec![false; instance.groups.len()],
            n_seen: vec![0; chosen.len()],
            has_scan: vec![false; n_parts],
            registration,
            chosen,
        }
    }

    /// The scans in the order in which they register, those with the largest overlap first, without those at some indices. Where
    /// none registers, the largest of a part without scans is next, then the one with the largest overlap.
    fn order(&mut self, without: &[usize]) -> Vec<RegisteredScan> {
        self.left.clear();
        self.left.extend((0..self.chosen.len()).filter(|at| !without.contains(at)));
        self.is_seen.fill(false);
        self.n_seen.fill(0);
        self.has_scan.fill(false);
        let mut scans = Vec::with_capacity(self.left.len());
        while let Some((at, registers)) = self.next() {
            scans.push(RegisteredScan { set: self.chosen[at], overlap: self.overlap(at), registers, joins: None });
            self.register(at);
        }
        scans
    }

    fn part(&self, at: usize) -> usize {
        self.registration.parts[self.chosen[at] as usize] as usize
    }

    fn overlap(&self, at: usize) -> f64 {
        f64::from(self.n_seen[at]) / self.n_faces[at].max(1) as f64
    }

    /// The next scan, and whether it registers or is the first of its part.
    fn next(&self) -> Option<(usize, bool)> {
        // Shares are compared exactly, as products; of equals the first counts.
        let share = |at: usize| [self.n_seen[at] as usize, self.n_faces[at].max(1)];
        let is_more = |at: usize, than: Option<usize>| {
            than.is_none_or(|than| share(at)[0] * share(than)[1] > share(than)[0] * share(at)[1])
        };
        let (mut registering, mut largest, mut nearest) = (None, None, None);
        for &at in &self.left {
            if !self.has_scan[self.part(at)] {
                let is_larger = largest.is_none_or(|than: usize| self.n_faces[at] > self.n_faces[than]);
                largest = if is_larger { Some(at) } else { largest };
            } else if self.n_seen[at] as usize >= self.n_needed[at] && is_more(at, registering) {
                registering = Some(at);
            }
            nearest = if is_more(at, nearest) { Some(at) } else { nearest };
        }
        registering.or(largest).map(|at| (at, true)).or_else(|| nearest.map(|at| (at, false)))
    }

    fn register(&mut self, at: usize) {
        self.left.retain(|other| *other != at);
        let part = self.part(at);
        self.has_scan[part] = true;
        for &face in &self.registration.instance.sets[self.chosen[at] as usize] {
            if !std::mem::replace(&mut self.is_seen[face as usize], true) {
                self.owners.of_face(face).iter().for_each(|&other| self.n_seen[other as usize] += 1);
            }
        }
    }
}
