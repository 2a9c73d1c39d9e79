//! Candidate poses by voting of similar corner pairs.

use crate::corners::Corner;
use crate::pose::Pose;
use crate::thresholds::N_VOTED;
use frames::wrapped;
use std::f64::consts::PI;

/// Corners of the reference that each corner of the SLAM map is taken for.
const N_ALIKE: usize = 12;
const SAME_ANGLE_RAD: f64 = PI / 9.0;
const COST_SCALE: f64 = 0.18;
const BIN_M: f64 = 0.25;
const N_PEAKS: usize = 12;
/// Votes so near to a peak make it.
const PEAK_M: f64 = 0.6;
const CLEARED: i64 = 3;
const MIN_PAIRS: usize = 3;

/// A pair of corners.
struct Pair {
    slam: [f64; 2],
    reference: [f64; 2],
    turn_rad: f64,
    weight: f64,
}

/// The poses with the most votes, for the given turns.
pub(crate) fn voted(slam: &[Corner], reference: &[Corner], turns: &[f64]) -> Vec<Pose> {
    let pairs = pairs(slam, reference);
    let mut poses: Vec<(f64, Pose)> = Vec::new();
    for &turn in turns {
        let turned = Pose::new([0.0; 2], turn);
        let votes: Vec<([f64; 2], f64)> = pairs
            .iter()
            .filter(|p| wrapped(p.turn_rad - turn).abs() < SAME_ANGLE_RAD)
            .map(|p| {
                let [x, y] = turned.rotate(p.slam);
                ([p.reference[0] - x, p.reference[1] - y], p.weight)
            })
            .collect();
        if votes.len() >= MIN_PAIRS {
            poses.extend(peaks(&votes).into_iter().map(|(strength, t)| (strength, Pose::new(t, turn))));
        }
    }
    poses.sort_by(|a, b| b.0.total_cmp(&a.0));
    poses.truncate(N_VOTED);
    poses.into_iter().map(|p| p.1).collect()
}

fn pairs(slam: &[Corner], reference: &[Corner]) -> Vec<Pair> {
    let mut pairs = Vec::new();
    let mut costs: Vec<(f32, usize)> = Vec::new();
    for s in slam {
        costs.clear();
        costs.extend(reference.iter().map(|r| s.cost(r)).zip(0..));
        if costs.len() > N_ALIKE {
            costs.select_nth_unstable_by(N_ALIKE - 1, |a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            costs.truncate(N_ALIKE);
            costs.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        }
        for &(cost, r) in &costs {
            let r = &reference[r];
            let turn_rad = wrapped(r.angle_rad - s.angle_rad);
            pairs.push(Pair {
                slam: s.at,
                reference: r.at,
                turn_rad,
                weight: libm::exp(-f64::from(cost) / COST_SCALE),
            });
        }
    }
    pairs
}

/// Peaks of the votes: strength and place.
fn peaks(votes: &[([f64; 2], f64)]) -> Vec<(f64, [f64; 2])> {
    let (mut lo, mut hi) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    for (t, _) in votes {
        for k in 0..2 {
            (lo[k], hi[k]) = (lo[k].min(t[k]), hi[k].max(t[k]));
        }
    }
    let size = [0, 1].map(|k| ((hi[k] - lo[k]) / BIN_M) as usize + 1);
    let mut bins = vec![0.0f32; size[0] * size[1]];
    let bin_of = |t: &[f64; 2]| {
        let [x, y] = [0, 1].map(|k| (((t[k] - lo[k]) / BIN_M) as usize).min(size[k] - 1));
        y * size[0] + x
    };
    votes.iter().for_each(|(t, weight)| bins[bin_of(t)] += *weight as f32);
    let mut bins = crate::image::Image::new(size[0], bins).blurred(1.0).values;
    let mut found = Vec::new();
    for _ in 0..N_PEAKS {
        let best = (0..bins.len()).max_by(|&a, &b| bins[a].total_cmp(&bins[b]).then(b.cmp(&a)));
        let Some(best) = best.filter(|&b| bins[b] > 0.0) else { break };
        let (x, y) = ((best % size[0]) as i64, (best / size[0]) as i64);
        let middle = [lo[0] + (x as f64 + 0.5) * BIN_M, lo[1] + (y as f64 + 0.5) * BIN_M];
        let (mut sum, mut weight) = ([0.0; 2], 0.0);
        for (t, w) in votes.iter().filter(|(t, _)| libm::hypot(t[0] - middle[0], t[1] - middle[1]) < PEAK_M) {
            sum = [sum[0] + w * t[0], sum[1] + w * t[1]];
            weight += w;
        }
        if weight > 0.0 {
            found.push((f64::from(bins[best]), sum.map(|s| s / weight)));
        }
        for row in (y - CLEARED).max(0)..(y + CLEARED + 1).min(size[1] as i64) {
            for column in (x - CLEARED).max(0)..(x + CLEARED + 1).min(size[0] as i64) {
                bins[row as usize * size[0] + column as usize] = 0.0;
            }
        }
    }
    found
}
