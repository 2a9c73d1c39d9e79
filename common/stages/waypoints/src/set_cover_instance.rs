//! The set-cover instance of a storey: a set of visible faces for each scan pose, and the number of faces to cover.
//!
//! There is a goal for all faces and one for each group of faces (a space), so that the uncovered share is never a whole
//! room.

/// A partial set-cover problem with goals per group, and sets that exclude each other.
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
    /// For each set those that are chosen beside it only if a group cannot reach its goal otherwise.
    pub conflicts: Vec<Vec<u32>>,
    /// Window of each set: a search exchanges sets of one window at a time.
    pub windows: Vec<u32>,
}

/// The sets that contain each face.
#[derive(Default)]
pub(crate) struct FaceOwners {
    sets: Vec<u32>,
    /// First owner of each face.
    first: Vec<u32>,
}

impl FaceOwners {
    /// The owners of each of `n_faces` faces among some sets: numbers with their faces.
    pub(crate) fn of<'a>(n_faces: usize, sets: impl Iterator<Item = (u32, &'a [u32])> + Clone) -> Self {
        let mut first = vec![0u32; n_faces + 1];
        sets.clone().flat_map(|(_, faces)| faces).for_each(|&face| first[face as usize + 1] += 1);
        for k in 1..first.len() {
            first[k] += first[k - 1];
        }
        let (mut next, mut owners) = (first.clone(), vec![0u32; first[n_faces] as usize]);
        for (set, faces) in sets {
            for &face in faces {
                let at = &mut next[face as usize];
                owners[*at as usize] = set;
                *at += 1;
            }
        }
        Self { sets: owners, first }
    }

    /// The sets with a face, ascending if they were given so.
    pub(crate) fn of_face(&self, face: u32) -> &[u32] {
        &self.sets[self.first[face as usize] as usize..self.first[face as usize + 1] as usize]
    }
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
        let (conflicts, windows) = (vec![Vec::new(); sets.len()], vec![0; sets.len()]);
        Self { sets, groups, goal, group_goals, conflicts, windows }
    }

    /// The sets that contain each face.
    pub(crate) fn owners(&self) -> FaceOwners {
        FaceOwners::of(self.groups.len(), (0..).zip(self.sets.iter().map(Vec::as_slice)))
    }

    /// True if the sets reach the goals.
    pub fn is_covered_by(&self, sets: &[u32]) -> bool {
        let mut covered = CoverCounts::new(self);
        sets.iter().for_each(|&set| covered.add(set));
        covered.reaches_goals()
    }

    /// Number of faces in any of the sets.
    pub(crate) fn n_covered_by(&self, sets: &[u32]) -> usize {
        let mut covered = CoverCounts::new(self);
        sets.iter().for_each(|&set| covered.add(set));
        covered.n
    }

    /// No choice that reaches the goal for all faces has fewer sets.
    pub(crate) fn least_sets(&self) -> usize {
        let mut sizes: Vec<usize> = self.sets.iter().map(Vec::len).collect();
        sizes.sort_unstable_by(|a, b| b.cmp(a));
        let mut n_left = self.goal;
        let is_needed = |size: &&usize| {
            let is_needed = n_left > 0;
            n_left = n_left.saturating_sub(**size);
            is_needed
        };
        sizes.iter().take_while(is_needed).count()
    }

    /// Removes redundant sets, those with the fewest faces of their own first.
    pub(crate) fn remove_redundant(&self, chosen: &mut Vec<u32>) {
        let mut covered = CoverCounts::new(self);
        chosen.iter().for_each(|&set| covered.add(set));
        let own = |set: u32| self.sets[set as usize].iter().filter(|&&f| covered.count[f as usize] == 1).count();
        let mut order: Vec<(usize, u32)> = chosen.iter().map(|&set| (own(set), set)).collect();
        order.sort_unstable();
        let mut redundant = Vec::new();
        // A set that is needed stays needed when others are gone.
        for (_, set) in order {
            covered.remove(set);
            if covered.reaches_goals() {
                redundant.push(set);
            } else {
                covered.add(set);
            }
        }
        chosen.retain(|set| !redundant.contains(set));
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

    /// Faces that each group lacks.
    pub(crate) fn group_goals_left(&self) -> Vec<usize> {
        self.instance.group_goals.iter().zip(&self.of_group).map(|(goal, n)| goal.saturating_sub(*n)).collect()
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
