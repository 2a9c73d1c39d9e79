//! Candidate rotations from histograms of wall normals.

use crate::wall_points::WallPoint;
use frames::wrapped;
use std::f64::consts::TAU;

/// Half a degree each, over the full circle: walls have two sides.
pub(crate) const N_BINS: usize = 720;
const SIGMA_BINS: f64 = 1.5;
/// A turn is the best of its neighbours on either side.
const WINDOW: usize = 6;
const MIN_SHARE: f64 = 0.45;
const MAX_TURNS: usize = 8;

/// Share of the wall points that look in each direction.
pub(crate) fn directions(wall_points: &[WallPoint]) -> [f64; N_BINS] {
    let mut counted = [0.0; N_BINS];
    for wall_point in wall_points {
        let angle = libm::atan2(wall_point.normal[1], wall_point.normal[0]) / TAU * N_BINS as f64;
        // Between two bins.
        let at = libm::floor(angle);
        let share = angle - at;
        let bin = (at as i64).rem_euclid(N_BINS as i64) as usize;
        counted[bin] += wall_point.weight * (1.0 - share);
        counted[(bin + 1) % N_BINS] += wall_point.weight * share;
    }
    let reach = (4.0 * SIGMA_BINS) as i64;
    let weight = |k: i64| libm::exp(-((k * k) as f64) / (2.0 * SIGMA_BINS * SIGMA_BINS));
    let mut blurred = [0.0; N_BINS];
    for (bin, sum) in blurred.iter_mut().enumerate() {
        *sum = (-reach..=reach).map(|k| weight(k) * counted[(bin as i64 + k).rem_euclid(N_BINS as i64) as usize]).sum();
    }
    let length = blurred.iter().map(|b| b * b).sum::<f64>().sqrt();
    if length > 0.0 {
        blurred.iter_mut().for_each(|b| *b /= length);
    }
    blurred
}

/// Turns from a SLAM map to the reference that bring directions together, best first, in radians.
pub(crate) fn turns(slam: &[f64; N_BINS], reference: &[f64; N_BINS]) -> Vec<f64> {
    let fit = |turn: usize| (0..N_BINS).map(|bin| slam[bin] * reference[(bin + turn) % N_BINS]).sum::<f64>();
    let fits: Vec<f64> = (0..N_BINS).map(fit).collect();
    let best = fits.iter().copied().fold(0.0, f64::max);
    let around = |turn: usize, by: i64| fits[(turn as i64 + by).rem_euclid(N_BINS as i64) as usize];
    let is_peak = |&turn: &usize| {
        let w = WINDOW as i64;
        fits[turn] > MIN_SHARE * best
            && (1..=w).all(|by| fits[turn] > around(turn, -by) && fits[turn] >= around(turn, by))
    };
    let mut peaks: Vec<usize> = (0..N_BINS).filter(is_peak).collect();
    peaks.sort_by(|&a, &b| fits[b].total_cmp(&fits[a]).then(a.cmp(&b)));
    peaks.truncate(MAX_TURNS);
    let exact = |turn: usize| {
        let (l, m, r) = (around(turn, -1), fits[turn], around(turn, 1));
        let bend = l - 2.0 * m + r;
        turn as f64 + if bend < 0.0 { (l - r) / (2.0 * bend) } else { 0.0 }
    };
    peaks.into_iter().map(|turn| wrapped(exact(turn) * TAU / N_BINS as f64)).collect()
}
