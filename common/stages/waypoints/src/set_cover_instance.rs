//! The set-cover instance of a storey: a set of visible faces for each scan pose, and the number of faces to cover.
//!
//! There is a goal for all faces and one for each group of faces (a space), so that the uncovered share is never a whole
//! room.

/// A partial set-cover problem with goals per group.
#[derive(Debug, Default)]
pub struct SetCoverInstance {
    /// Faces of each set, ascending.
    pub sets: Vec<Vec<u32>>,
    /// Group of each face.
    pub groups: Vec<u32>,
    /// Faces that must be covered.
    pub goal: usize,
    /// Faces that must be covered of each group.
    pub group_goals: Vec<usize>,
}

impl SetCoverInstance {
    /// Builds an instance from sets of faces and the group of each face. The goals are `share` of the faces in any set, and
    /// `group_share` of those of each group.
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
        let mut covered = CoverCounts::new(self);
        sets.iter().for_each(|&set| covered.add(set));
        covered.reaches_goals()
    }

    /// Removes redundant sets, those with the fewest faces of their own first.
    pub(crate) fn remove_redundant(&self, chosen: &mut Vec<u32>) {
        let mut covered = CoverCounts::new(self);
        chosen.iter().for_each(|&set| covered.add(set));
        loop {
            let own = |set: u32| self.sets[set as usize].iter().filter(|&&f| covered.count[f as usize] == 1).count();
            let mut order: Vec<(usize, usize)> = chosen.iter().enumerate().map(|(at, &set)| (own(set), at)).collect();
            order.sort_unstable();
            let redundant = order.iter().map(|o| o.1).find(|&at| {
                covered.remove(chosen[at]);
                let still = covered.reaches_goals();
                if !still {
                    covered.add(chosen[at]);
                }
                still
            });
            let Some(at) = redundant else { return };
            chosen.remove(at);
        }
    }
}

/// Cover counts of the faces, and the goals not reached yet.
pub(crate) struct CoverCounts<'a> {
    instance: &'a SetCoverInstance,
    pub(crate) count: Vec<u16>,
    /// Number of covered faces.
    pub(crate) n: usize,
    of_group: Vec<usize>,
    /// Number of groups below their goal.
    pub(crate) n_short_groups: usize,
}

impl<'a> CoverCounts<'a> {
    pub(crate) fn new(instance: &'a SetCoverInstance) -> Self {
        Self {
            instance,
            count: vec![0; instance.groups.len()],
            n: 0,
            of_group: vec![0; instance.group_goals.len()],
            n_short_groups: instance.group_goals.iter().filter(|g| **g > 0).count(),
        }
    }

    /// True if all goals are reached.
    pub(crate) fn reaches_goals(&self) -> bool {
        self.n >= self.instance.goal && self.n_short_groups == 0
    }

    /// True if the group of the face is below its goal.
    pub(crate) fn is_group_short(&self, face: u32) -> bool {
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

    /// Returns the new cover count of the face.
    pub(crate) fn add_face(&mut self, face: u32) -> u16 {
        let count = &mut self.count[face as usize];
        *count += 1;
        if *count == 1 {
            let group = self.instance.groups[face as usize] as usize;
            self.n += 1;
            self.of_group[group] += 1;
            self.n_short_groups -= usize::from(self.of_group[group] == self.instance.group_goals[group]);
        }
        *count
    }

    /// Returns the new cover count of the face.
    pub(crate) fn remove_face(&mut self, face: u32) -> u16 {
        let count = &mut self.count[face as usize];
        *count -= 1;
        if *count == 0 {
            let group = self.instance.groups[face as usize] as usize;
            self.n -= 1;
            self.n_short_groups += usize::from(self.of_group[group] == self.instance.group_goals[group]);
            self.of_group[group] -= 1;
        }
        *count
    }
}
