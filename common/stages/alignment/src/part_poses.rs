//! Finds the pose of each part of a SLAM map: a map bends, so that no one pose is right for all of it.

use crate::features::Features;
use crate::map_parts::{MapParts, PartLink};
use crate::part_fit::{Explained, FittedMaps, Measurement, Prediction};
use crate::part_tree::{Drift, Visited, predicted, smooth};
use crate::pose::Pose;
use nalgebra::{Matrix3, Vector3};
use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// How far the part that fits best may lie from the pose of the whole map: deviations of place and yaw.
const START_M: f64 = 0.15;
const START_RAD: f64 = 0.02;
/// Drifts with which the parts are visited; that counts by which most is explained, less what the freedom costs. A map of a robot
/// that closed its loops has the first, Karto's maps of long corridors have the last.
const DRIFTS: [Drift; 3] = [Drift { m: 0.01 }, Drift { m: 0.025 }, Drift { m: 0.06 }];
/// The drift by which the uncertainty grows beyond parts that are borne out, whatever was chosen: a map that is straight where the
/// model has its walls tells nothing about where it has none. Seven maps of Karto drift by 0.02 to 0.08 m after a metre.
const UNSEEN_DRIFT: Drift = Drift { m: 0.05 };
/// What every part is off by beside all that: half a cell, thick walls, walls as built; in metres.
const LEAST_DEVIATION_M: f64 = 0.05;
const N_SWEEPS: usize = 2;

/// The pose of a part of a SLAM map.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PartPose {
    /// With the uncertainty of where the centre lies.
    pub(crate) placed: Prediction,
    pub(crate) explained: Explained,
}

/// The poses of all parts, from a pose of the whole map; `None` for parts that no link leads to.
pub(crate) fn part_poses(reference: &Features, slam: &Features, map: &MapParts, whole: &Pose) -> Vec<Option<PartPose>> {
    let maps = FittedMaps::of(reference, slam, map);
    let mut found = vec![None; map.parts.len()];
    let starts = start_fits(&maps, whole);
    let tried = DRIFTS.map(|drift| visited(&maps, whole, drift, &starts));
    let best = tried.into_iter().zip(DRIFTS).reduce(|a, b| if b.0.log_odds > a.0.log_odds { b } else { a });
    let Some((Visits { mut visits, mut explained, .. }, drift)) = best else { return found };
    let start = start(whole);
    for _ in 0..N_SWEEPS {
        measure(&maps, &mut visits, &mut explained);
        smooth(map, &mut visits, &start, drift);
    }
    measure(&maps, &mut visits, &mut explained);
    // What is known, at the poses that were found.
    visits.iter_mut().for_each(|visit| visit.measurement.gradient = Vector3::zeros());
    let poses: Vec<Pose> = visits.iter().map(|visit| visit.placed.pose).collect();
    smooth(map, &mut visits, &Prediction { pose: poses.first().copied().unwrap_or(*whole), ..start }, UNSEEN_DRIFT);
    let least = LEAST_DEVIATION_M * LEAST_DEVIATION_M;
    for ((visit, pose), explained) in visits.iter().zip(poses).zip(explained) {
        let covariance = visit.placed.covariance + Matrix3::from_diagonal(&Vector3::new(least, least, 0.0));
        found[visit.part] = Some(PartPose { placed: Prediction { pose, covariance }, explained });
    }
    found
}

fn start(whole: &Pose) -> Prediction {
    let of_place = START_M * START_M;
    let covariance = Matrix3::from_diagonal(&Vector3::new(of_place, of_place, START_RAD * START_RAD));
    Prediction { pose: *whole, covariance }
}

/// For each part what it explains near the pose of the whole map.
fn start_fits(maps: &FittedMaps<'_>, whole: &Pose) -> Vec<f64> {
    let start = start(whole);
    let worth = |part: usize| {
        let Explained { walls_m, explained_m, is_borne_out } = maps.fitted(part, &start).explained;
        if is_borne_out { explained_m * explained_m / walls_m } else { 0.0 }
    };
    (0..maps.map.parts.len()).map(worth).collect()
}

/// Visits to all parts that links lead to, with a drift.
struct Visits {
    visits: Vec<Visited>,
    explained: Vec<Explained>,
    /// For this drift.
    log_odds: f64,
}

/// Visits the parts from that which fits best, those first that are known best, each searched no farther than it may have drifted.
fn visited(maps: &FittedMaps<'_>, whole: &Pose, drift: Drift, starts: &[f64]) -> Visits {
    let map = maps.map;
    let mut found = Visits { visits: Vec::new(), explained: Vec::new(), log_odds: 0.0 };
    let Some(root) = (0..starts.len()).max_by(|a, b| starts[*a].total_cmp(&starts[*b])) else { return found };
    let mut is_visited = vec![false; map.parts.len()];
    let mut queue = BinaryHeap::from([Wanted::new(root, start(whole), None)]);
    while let Some(Wanted { part, predicted: expected, from, .. }) = queue.pop() {
        if std::mem::replace(&mut is_visited[part], true) {
            continue;
        }
        let fit = maps.fitted(part, &expected);
        let is_borne_out = fit.explained.is_borne_out;
        let placed = if is_borne_out { fit.placed } else { expected };
        found.log_odds += if is_borne_out { fit.log_odds } else { 0.0 };
        let visit = found.visits.len();
        found.visits.push(Visited { part, placed, from, measurement: Measurement::NONE });
        found.explained.push(fit.explained);
        for &PartLink { to, length_m } in map.links[part].iter().filter(|link| !is_visited[link.to]) {
            let predicted = predicted(map, part, &placed, to, length_m, drift);
            queue.push(Wanted::new(to, predicted, Some((visit, length_m))));
        }
    }
    found
}

/// Measures the visited parts that are borne out where they lie by now; none becomes so later.
fn measure(maps: &FittedMaps<'_>, visits: &mut [Visited], explained: &mut [Explained]) {
    for (visit, explained) in visits.iter_mut().zip(explained) {
        let now = maps.explained(visit.part, &visit.placed.pose);
        *explained = Explained { is_borne_out: now.is_borne_out && explained.is_borne_out, ..now };
        visit.measurement = match explained.is_borne_out {
            true => maps.measured(visit.part, &visit.placed.pose),
            false => Measurement::NONE,
        };
    }
}

/// A part that is to be visited; that which is known best comes first.
struct Wanted {
    part: usize,
    predicted: Prediction,
    deviation_m: f64,
    from: Option<(usize, f64)>,
}

impl Wanted {
    fn new(part: usize, predicted: Prediction, from: Option<(usize, f64)>) -> Self {
        Self { part, predicted, deviation_m: predicted.worst_m(), from }
    }
}

impl Ord for Wanted {
    fn cmp(&self, other: &Self) -> Ordering {
        other.deviation_m.total_cmp(&self.deviation_m).then(other.part.cmp(&self.part))
    }
}

impl PartialOrd for Wanted {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Wanted {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Wanted {}
