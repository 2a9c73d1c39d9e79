//! Displacement of an element, by agreement of the surfaces on its sides.

use crate::probed_sample::ProbedSample;
use crate::thresholds::*;

/// The displacement of an element.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Displacement {
    /// Displacement in `map`; 0 along directions without surfaces.
    pub(crate) by_m: [f64; 2],
    /// Along the normal that most samples have.
    pub(crate) offset_m: f64,
    pub(crate) is_displaced: bool,
}

impl Displacement {
    pub(crate) fn along(&self, n: [f64; 2]) -> f64 {
        n[0] * self.by_m[0] + n[1] * self.by_m[1]
    }
}

/// Minimum cosine between normal and axis.
const SAME_AXIS: f64 = 0.9;
/// Minimum share of all samples in the second direction.
const MIN_OF_ALL: f64 = 0.25;
const BIN_M: f64 = 0.02;

/// The displacement on which the surfaces around an element agree; significant from `least_m` on.
pub(crate) fn displacement(probed_samples: &[ProbedSample], least_m: f64) -> Displacement {
    let axis = main_axis(probed_samples.iter().map(|s| s.normal)).unwrap_or([1.0, 0.0]);
    let mut displacement = Displacement::default();
    for (k, axis) in [axis, [-axis[1], axis[0]]].into_iter().enumerate() {
        let votes = Votes::along(probed_samples, axis);
        if k == 1 && (votes.probed_samples.len() as f64) < MIN_OF_ALL * probed_samples.len() as f64 {
            continue;
        }
        let Some((by_m, counts)) = votes.agreed(least_m) else { continue };
        displacement.by_m = [0, 1].map(|c| displacement.by_m[c] + axis[c] * by_m);
        displacement.is_displaced |= counts;
        if k == 0 {
            displacement.offset_m = by_m * votes.main_sign();
        }
    }
    displacement
}

/// The dominant direction of normals, independent of sign; `None` of nothing.
pub(crate) fn main_axis(normals: impl Iterator<Item = [f64; 2]> + Clone) -> Option<[f64; 2]> {
    let (n, doubled) = normals.clone().fold((0, [0.0; 2]), |(n, sum): (usize, [f64; 2]), [x, y]| {
        (n + 1, [sum[0] + x * x - y * y, sum[1] + 2.0 * x * y])
    });
    if libm::hypot(doubled[0], doubled[1]) < 0.05 * n as f64 {
        // Without a dominant direction, as on a column, any side is used.
        return normals.clone().next();
    }
    let (sin, cos) = libm::sincos(libm::atan2(doubled[1], doubled[0]) / 2.0);
    (n > 0).then_some([cos, sin])
}

/// Samples with normals along an axis, with their sign.
struct Votes<'l> {
    probed_samples: Vec<(f64, &'l ProbedSample)>,
}

impl<'l> Votes<'l> {
    fn along(probed_samples: &'l [ProbedSample], axis: [f64; 2]) -> Self {
        let with = probed_samples.iter().filter_map(|probed_sample| {
            let dot = probed_sample.normal[0] * axis[0] + probed_sample.normal[1] * axis[1];
            (dot.abs() >= SAME_AXIS).then_some((dot.signum(), probed_sample))
        });
        Self { probed_samples: with.collect() }
    }

    /// The sign of the normals of the side with the most surfaces.
    fn main_sign(&self) -> f64 {
        let sum: f64 = self.probed_samples.iter().filter(|(_, l)| !l.offsets_m.is_empty()).map(|(sign, _)| sign).sum();
        if sum < 0.0 { -1.0 } else { 1.0 }
    }

    /// The offset along the axis on which most surfaces agree, and whether it is a displacement of at least `least_m`.
    fn agreed(&self, least_m: f64) -> Option<(f64, bool)> {
        let peak_m = self.peak()?;
        let support = self.support(peak_m);
        let by_m = median(support.iter().map(|(sign, d)| sign * d).collect())?;
        let (support, in_place) = (self.support(by_m), self.support(0.0));
        // Samples that see through the element without a surface at the offset contradict it, as do those in place.
        let against = self.probed_samples.iter().filter(|(sign, l)| l.through && !is_met(l, sign * by_m)).count();
        let enough = support.len() >= MIN_SUPPORT
            && support.len() as f64 >= SUPPORT_RATIO * in_place.len() as f64
            && support.len() as f64 >= SUPPORT_SHARE * (support.len() + against) as f64
            && self.is_uncovered(&support, by_m, in_place.len());
        if by_m.abs() >= least_m && enough {
            return Some((by_m, true));
        }
        // In its place: how far off, within what counts as that.
        let nearest = self.probed_samples.iter().filter_map(|(sign, l)| l.nearest(0.0).map(|d| sign * d));
        median(nearest.filter(|d| d.abs() <= least_m.max(SAME_SIDE_M)).collect()).map(|by_m| (by_m, false))
    }

    /// True if the place in the model was visible, or a surface nearer to the robot covers the side as only a wall does.
    fn is_uncovered(&self, support: &[(f64, f64)], by_m: f64, n_in_place: usize) -> bool {
        let behind = support.iter().filter(|(_, d)| *d < 0.0).count();
        if behind as f64 >= BEHIND_SHARE * support.len() as f64 {
            return true;
        }
        let sign = support.iter().map(|(sign, _)| sign).sum::<f64>().signum();
        let of_side = self.probed_samples.iter().filter(|(s, _)| *s == sign).count();
        n_in_place < MIN_SUPPORT
            && by_m.abs() <= MAX_COVERING_M
            && support.len() >= MIN_COVERING
            && support.len() as f64 >= COVERING_SHARE * of_side as f64
    }

    /// Samples with a surface near to a displacement: sign and offset.
    fn support(&self, by_m: f64) -> Vec<(f64, f64)> {
        let near = self.probed_samples.iter().filter(|(sign, l)| is_met(l, sign * by_m));
        near.filter_map(|(sign, l)| Some((*sign, l.nearest(sign * by_m)?))).collect()
    }

    /// Offset with the most surfaces.
    fn peak(&self) -> Option<f64> {
        let n_bins = (2.0 * REACH_M / BIN_M).ceil() as usize + 1;
        let mut bins = vec![0u32; n_bins];
        for (sign, probed_sample) in &self.probed_samples {
            for d in &probed_sample.offsets_m {
                let bin = ((sign * d + REACH_M) / BIN_M).round() as usize;
                bins[bin.min(n_bins - 1)] += 1;
            }
        }
        let around = |k: usize| bins[k.saturating_sub(2)..(k + 3).min(n_bins)].iter().sum::<u32>();
        // Of equal peaks the one nearest to the place in the model.
        let far = |k: usize| (2 * k).abs_diff(n_bins - 1);
        let best = (0..n_bins).max_by_key(|k| (around(*k), std::cmp::Reverse(far(*k))))?;
        (around(best) > 0).then_some(best as f64 * BIN_M - REACH_M)
    }
}

fn is_met(probed_sample: &ProbedSample, out_m: f64) -> bool {
    probed_sample.nearest(out_m).is_some_and(|d| (d - out_m).abs() <= SUPPORT_M)
}

/// The middle value; `None` of nothing.
fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied()
}
