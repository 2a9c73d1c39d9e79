//! Connecting scans: added so that each scan overlaps enough with earlier ones to be registered.

use crate::options::MissionPlanOptions;
use crate::scans::ScanSelection;
use crate::space_centre::StoreyInputs;
use crate::tour_stops::{TourGoal, goal_of};
use frames::{Map, Point2};

/// Measures the overlap of the scans of a tour. Goals are given in the order of the tour, with their index among the places
/// of the distances.
pub(crate) struct ScanConnector<'a> {
    pub(crate) storey: &'a StoreyInputs<'a>,
    pub(crate) options: &'a MissionPlanOptions,
    pub(crate) scans: &'a ScanSelection,
    /// Faces seen before the tour.
    pub(crate) seen_before: &'a [bool],
}

impl ScanConnector<'_> {
    /// Removes connecting scans without which as many scans are connected. Returns true if there were any.
    pub(crate) fn remove_redundant(&self, goals: &mut Vec<(usize, TourGoal)>) -> bool {
        let n_before = goals.len();
        let mut n_unconnected = self.n_unconnected(goals);
        for at in (0..goals.len()).rev() {
            if goals[at].1.connects {
                let goal = goals.remove(at);
                let now = self.n_unconnected(goals);
                if now <= n_unconnected {
                    n_unconnected = now;
                } else {
                    goals.insert(at, goal);
                }
            }
        }
        goals.len() < n_before
    }

    /// Connecting scans that are missing, each with the index in the tour before which it belongs.
    pub(crate) fn missing_connections(&self, goals: &[(usize, TourGoal)]) -> Vec<(usize, TourGoal)> {
        let mut seen = self.seen_before.to_vec();
        let mut missing_connections = Vec::new();
        let mut is_first = true;
        for (k, (_, goal)) in goals.iter().enumerate() {
            let Some(pose) = goal.pose else { continue };
            if !is_first
                && self.overlap(&seen, pose) < self.options.overlap
                && let Some(between) = self.connecting(&seen, goals[k - 1].1.at, goal)
            {
                self.mark_seen(&mut seen, between);
                missing_connections.push((k, goal_of(self.storey, self.scans, between, true)));
            }
            self.mark_seen(&mut seen, pose);
            is_first = false;
        }
        missing_connections
    }

    /// Number of scans, except for the first, that overlap too little with earlier ones.
    pub(crate) fn n_unconnected(&self, goals: &[(usize, TourGoal)]) -> usize {
        let mut seen = self.seen_before.to_vec();
        let mut is_unconnected = |pose: usize| {
            let unconnected = self.overlap(&seen, pose) < self.options.overlap;
            self.mark_seen(&mut seen, pose);
            unconnected
        };
        goals
            .iter()
            .filter_map(|g| g.1.pose)
            .map(&mut is_unconnected)
            .skip(1)
            .filter(|unconnected| *unconnected)
            .count()
    }

    /// Share of the faces of a pose that were seen before.
    fn overlap(&self, seen: &[bool], pose: usize) -> f64 {
        let faces = self.scans.seen(pose);
        faces.iter().filter(|&&f| seen[f as usize]).count() as f64 / faces.len().max(1) as f64
    }

    fn mark_seen(&self, seen: &mut [bool], pose: usize) {
        self.scans.seen(pose).iter().for_each(|&f| seen[f as usize] = true);
    }

    /// The connecting pose with the shortest detour before a scan: it overlaps enough with the faces seen so far, and the
    /// scan does after it.
    fn connecting(&self, seen: &[bool], before: Point2<Map>, goal: &TourGoal) -> Option<usize> {
        let (options, scans) = (self.options, self.scans);
        let faces_of_goal = scans.seen(goal.pose?);
        let mut is_goal = vec![false; scans.faces.all.len()];
        faces_of_goal.iter().for_each(|&f| is_goal[f as usize] = true);
        let n_known = faces_of_goal.iter().filter(|&&f| seen[f as usize]).count();
        let needed = |n: usize| (options.overlap * n as f64).ceil() as usize;
        let far = |a: Point2<Map>, b: Point2<Map>| a.distance_m(&b);
        let joins = |&pose: &usize| {
            let faces = scans.seen(pose);
            let n_old = faces.iter().filter(|&&f| seen[f as usize]).count();
            let n_new = faces.iter().filter(|&&f| !seen[f as usize] && is_goal[f as usize]).count();
            n_old >= needed(faces.len()) && n_known + n_new >= needed(faces_of_goal.len())
        };
        let near = |pose: &usize| {
            let place = scans.place(*pose);
            // Beyond this distance two poses have no faces in common.
            place.part == goal.part && far(place.at, goal.at) <= 2.0 * options.sensor.range_m
        };
        let detour = |pose: usize| far(before, scans.place(pose).at) + far(scans.place(pose).at, goal.at);
        let poses = (0..scans.poses.len()).filter(near).filter(joins);
        poses.min_by(|&a, &b| detour(a).total_cmp(&detour(b)).then(a.cmp(&b)))
    }
}
