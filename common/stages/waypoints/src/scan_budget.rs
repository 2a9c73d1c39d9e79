//! Shares a number of scans or minutes among the storeys of a mission plan.

use crate::options::MissionPlanOptions;
use crate::scan_growth::GrownScan;
use crate::storey_planner::PlannedStorey;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// The scans of all storeys in the order in which the mission plan grows, each with its storey: those that see most first.
/// A scan that joins another comes right before it, and both count together.
pub(crate) fn merged<'a>(growths: &[&'a [GrownScan]]) -> Vec<(usize, &'a GrownScan)> {
    let mut heap: BinaryHeap<(Ratio, Reverse<usize>)> = BinaryHeap::new();
    let mut next = vec![0; growths.len()];
    let ratio =
        |at: usize, first: usize| step(&growths[at][first..]).map(|n| Ratio::of(&growths[at][first..first + n]));
    heap.extend((0..growths.len()).filter_map(|at| Some((ratio(at, 0)?, Reverse(at)))));
    let mut order = Vec::with_capacity(growths.iter().map(|growth| growth.len()).sum());
    while let Some((_, Reverse(at))) = heap.pop() {
        let first = next[at];
        next[at] += step(&growths[at][first..]).unwrap_or(0);
        order.extend(growths[at][first..next[at]].iter().map(|scan| (at, scan)));
        heap.extend(ratio(at, next[at]).map(|ratio| (ratio, Reverse(at))));
    }
    order
}

/// Number of scans that are chosen together at the beginning of a growth; `None` at its end.
fn step(growth: &[GrownScan]) -> Option<usize> {
    (!growth.is_empty())
        .then(|| growth.iter().take_while(|scan| scan.connects).count() + 1)
        .map(|n| n.min(growth.len()))
}

/// New faces per scan, exactly.
#[derive(Debug, Clone, Copy)]
struct Ratio {
    n_new: u64,
    n_scans: u64,
}

impl Ratio {
    fn of(scans: &[GrownScan]) -> Self {
        Self { n_new: scans.iter().map(|scan| u64::from(scan.n_new)).sum(), n_scans: scans.len() as u64 }
    }
}

impl Ord for Ratio {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        (self.n_new * other.n_scans).cmp(&(other.n_new * self.n_scans))
    }
}

impl PartialOrd for Ratio {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Ratio {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Ratio {}

/// Driving time and scanning time of all tours, in seconds.
pub(crate) fn mission_s(options: &MissionPlanOptions, planned_storeys: &[&PlannedStorey]) -> [f64; 2] {
    let stops = planned_storeys.iter().flat_map(|planned| &planned.stops);
    let n_scans = stops.filter(|stop| stop.scan().is_some()).count();
    let driven_m: f64 = planned_storeys.iter().map(|planned| planned.tour_m).sum();
    let climbed_m: f64 = planned_storeys.iter().map(|planned| planned.tour_climb_m).sum();
    let drive = &options.drive;
    [driven_m / drive.speed_m_s + climbed_m * drive.climb_s_per_m, n_scans as f64 * options.scan_s]
}

/// Energy of driving and scanning on all tours, in joules; 0 if the mass of the robot is unknown.
pub(crate) fn mission_j(options: &MissionPlanOptions, planned_storeys: &[&PlannedStorey]) -> f64 {
    let [_, scanning_s] = mission_s(options, planned_storeys);
    let driving_j: f64 = planned_storeys.iter().map(|planned| planned.tour_j).sum();
    if options.drive.has_energy() { driving_j + scanning_s * options.drive.idle_w } else { 0.0 }
}

/// The plans of all storeys with as many scans as the budget allows. `plan` makes them for numbers of scans by storey.
pub(crate) fn within_budget(
    options: &MissionPlanOptions,
    growths: &[&[GrownScan]],
    plan: impl Fn(&[usize]) -> Vec<PlannedStorey>,
) -> Vec<PlannedStorey> {
    let order = merged(growths);
    let with = |n: usize| {
        let mut counts = vec![0; growths.len()];
        // A scan that joins another is of no use without it.
        let n = n - usize::from(n > 0 && order[n - 1].1.connects);
        order[..n].iter().for_each(|(at, _)| counts[*at] += 1);
        plan(&counts)
    };
    let n_max = options.scans_max.map_or(order.len(), |n| order.len().min(n as usize));
    let mut best = with(n_max);
    let Some(minutes_max) = options.minutes_max else { return best };
    let fits = |planned: &[PlannedStorey]| {
        mission_s(options, &planned.iter().collect::<Vec<_>>()).iter().sum::<f64>() <= minutes_max * 60.0
    };
    if fits(&best) {
        return best;
    }
    best = with(0);
    // The best plan has `lo` scans, and one of `hi` takes too long.
    let (mut lo, mut hi) = (0, n_max);
    while lo + 1 < hi {
        let middle = lo.midpoint(hi);
        let planned = with(middle);
        if fits(&planned) {
            (best, lo) = (planned, middle);
        } else {
            hi = middle;
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;

    fn growth(scans: &[(u32, bool)]) -> Vec<GrownScan> {
        scans.iter().zip(0..).map(|(&(n_new, connects), set)| GrownScan { set, n_new, connects }).collect()
    }

    #[test]
    fn scans_that_see_more_come_first_and_those_of_a_storey_stay_in_their_order() {
        let [low, high] = [growth(&[(50, false), (20, false), (1, false)]), growth(&[(60, false), (30, false)])];
        let order: Vec<(usize, u32)> = merged(&[&low, &high]).into_iter().map(|(at, scan)| (at, scan.n_new)).collect();
        assert_eq!(order, [(1, 60), (0, 50), (1, 30), (0, 20), (0, 1)]);
    }

    #[test]
    fn a_joining_scan_counts_together_with_the_scan_that_it_joins() {
        // Two scans for 42 faces are worth more than two for 20 each, one for 25 more than both.
        let [low, high] = [growth(&[(2, true), (40, false)]), growth(&[(25, false), (20, false)])];
        let order: Vec<(usize, u32)> = merged(&[&low, &high]).into_iter().map(|(at, scan)| (at, scan.n_new)).collect();
        assert_eq!(order, [(1, 25), (0, 2), (0, 40), (1, 20)]);
    }
}
