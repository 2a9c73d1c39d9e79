//! Connecting scans, so that each scan overlaps enough with earlier ones to be registered.

use crate::centre::Storey;
use crate::options::PlanOptions;
use crate::scans::Scans;
use crate::stops::{Goal, goal_of};
use frames::{Map, Point2};

/// What the scans of a tour are judged by. Goals come with their numbers among the ways, in the order of the tour.
pub(crate) struct Joining<'a> {
    pub(crate) storey: &'a Storey<'a>,
    pub(crate) options: &'a PlanOptions,
    pub(crate) scans: &'a Scans,
    /// Faces that were seen before the tour.
    pub(crate) seen_before: &'a [bool],
}

impl Joining<'_> {
    /// Takes out scans that join others without which as many scans are joined. Returns true if there were any.
    pub(crate) fn drop_needless(&self, goals: &mut Vec<(usize, Goal)>) -> bool {
        let n_before = goals.len();
        let mut n_alone = self.n_alone(goals);
        for at in (0..goals.len()).rev() {
            if goals[at].1.connects {
                let goal = goals.remove(at);
                let now = self.n_alone(goals);
                if now <= n_alone {
                    n_alone = now;
                } else {
                    goals.insert(at, goal);
                }
            }
        }
        goals.len() < n_before
    }

    /// Scans that join others where one sees too little, each with the place in the tour before which it comes.
    pub(crate) fn missing(&self, goals: &[(usize, Goal)]) -> Vec<(usize, Goal)> {
        let mut seen = self.seen_before.to_vec();
        let mut missing = Vec::new();
        let mut is_first = true;
        for (k, (_, goal)) in goals.iter().enumerate() {
            let Some(pose) = goal.pose else { continue };
            if !is_first
                && self.overlap(&seen, pose) < self.options.overlap
                && let Some(between) = self.connecting(&seen, goals[k - 1].1.at, goal)
            {
                self.look(&mut seen, between);
                missing.push((k, goal_of(self.storey, self.scans, between, true)));
            }
            self.look(&mut seen, pose);
            is_first = false;
        }
        missing
    }

    /// Scans but the first that see too little of what earlier ones saw.
    pub(crate) fn n_alone(&self, goals: &[(usize, Goal)]) -> usize {
        let mut seen = self.seen_before.to_vec();
        let mut is_alone = |pose: usize| {
            let alone = self.overlap(&seen, pose) < self.options.overlap;
            self.look(&mut seen, pose);
            alone
        };
        goals.iter().filter_map(|g| g.1.pose).map(&mut is_alone).skip(1).filter(|alone| *alone).count()
    }

    /// Share of what a pose sees that was seen already.
    fn overlap(&self, seen: &[bool], pose: usize) -> f64 {
        let faces = self.scans.seen(pose);
        faces.iter().filter(|&&f| seen[f as usize]).count() as f64 / faces.len().max(1) as f64
    }

    fn look(&self, seen: &mut [bool], pose: usize) {
        self.scans.seen(pose).iter().for_each(|&f| seen[f as usize] = true);
    }

    /// A pose on the way to a scan that sees enough of what was seen so far, and after which the scan does, too: the one with
    /// the least detour.
    fn connecting(&self, seen: &[bool], before: Point2<Map>, goal: &Goal) -> Option<usize> {
        let (options, scans) = (self.options, self.scans);
        let faces_of_goal = scans.seen(goal.pose?);
        let mut is_goal = vec![false; scans.faces.all.len()];
        faces_of_goal.iter().for_each(|&f| is_goal[f as usize] = true);
        let n_known = faces_of_goal.iter().filter(|&&f| seen[f as usize]).count();
        let needed = |n: usize| (options.overlap * n as f64).ceil() as usize;
        let far = |a: Point2<Map>, b: Point2<Map>| libm::hypot(a.x_m - b.x_m, a.y_m - b.y_m);
        let joins = |&pose: &usize| {
            let faces = scans.seen(pose);
            let n_old = faces.iter().filter(|&&f| seen[f as usize]).count();
            let n_new = faces.iter().filter(|&&f| !seen[f as usize] && is_goal[f as usize]).count();
            n_old >= needed(faces.len()) && n_known + n_new >= needed(faces_of_goal.len())
        };
        let near = |pose: &usize| {
            let place = scans.place(*pose);
            // Beyond this the two see nothing in common.
            place.part == goal.part && far(place.at, goal.at) <= 2.0 * options.sensor.range_m
        };
        let detour = |pose: usize| far(before, scans.place(pose).at) + far(scans.place(pose).at, goal.at);
        let poses = (0..scans.poses.len()).filter(near).filter(joins);
        poses.min_by(|&a, &b| detour(a).total_cmp(&detour(b)).then(a.cmp(&b)))
    }
}
