//! Local distortion of a SLAM map, estimated from surfaces of surrounding elements.

use crate::thresholds::{ALIKE, BEND_CELL_M, BEND_SIGMA_M, BENT_M, BUILT_M, LEAST_BENT_M, MOST_BENT_M, NOISE_M};
use nalgebra::{Matrix2, Vector2};
use std::collections::BTreeMap;

/// A surface that was met beside the side of an element.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Tie {
    pub(crate) normal: [f64; 2],
    /// How far out of the side it lies.
    pub(crate) offset_m: f64,
    pub(crate) cut: u32,
}

/// By how much the map is off at a place, SLAM less model.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Bend {
    pub(crate) by_m: Vector2<f64>,
    /// Of `by_m`, in m².
    covariance: Matrix2<f64>,
    pub(crate) n: usize,
}

/// Surfaces by place.
pub(crate) struct Bends {
    ties: BTreeMap<[i32; 2], Vec<Tie>>,
    /// Deviation of what nobody has measured.
    prior_m: f64,
    /// Root mean square over all squares.
    pub(crate) rms_m: f64,
}

/// Weights end at this multiple of their sigma.
const CUT_OFF: f64 = 2.0;
/// Scales of the residual, from coarse to fine: what was built elsewhere does not pull.
const SCALES_M: [f64; 5] = [0.3, 0.2, 0.12, 0.08, 0.08];

impl Bends {
    /// `pose_m` is what the pose of the whole map is uncertain by.
    pub(crate) fn new(ties: impl Iterator<Item = ([f64; 2], Tie)>, pose_m: f64) -> Self {
        let mut bends = Self { ties: BTreeMap::new(), prior_m: libm::hypot(BENT_M, pose_m), rms_m: 0.0 };
        for (at, tie) in ties.filter(|(_, tie)| tie.offset_m.abs() <= MOST_BENT_M) {
            bends.ties.entry(square(at)).or_default().push(tie);
        }
        let all: Vec<Bend> = bends.ties.keys().map(|square| bends.at_square(*square, None)).collect();
        let sum: f64 = all.iter().map(|b| b.by_m.norm_squared()).sum();
        bends.rms_m = (sum / all.len().max(1) as f64).sqrt();
        // A map that is straight where it can be measured is straight elsewhere, too.
        bends.prior_m = libm::hypot(bends.rms_m.clamp(LEAST_BENT_M, 2.0 * BENT_M), pose_m);
        bends
    }

    /// No bend, and as uncertain as where nothing is known.
    pub(crate) fn none(&self) -> Bend {
        let covariance = Matrix2::from_diagonal_element(self.prior_m * self.prior_m);
        Bend { by_m: Vector2::zeros(), covariance, n: 0 }
    }

    /// The bend at a place, as others than this element say.
    pub(crate) fn at(&self, at: [f64; 2], without: Option<u32>) -> Bend {
        self.at_square(square(at), without)
    }

    /// Middles of all squares with surfaces in them, and the bend there.
    pub(crate) fn all(&self) -> impl Iterator<Item = ([f64; 2], Bend)> {
        self.ties.keys().map(|s| (s.map(|c| (f64::from(c) + 0.5) * BEND_CELL_M), self.at_square(*s, None)))
    }

    fn at_square(&self, at: [i32; 2], without: Option<u32>) -> Bend {
        let reach = (CUT_OFF * BEND_SIGMA_M / BEND_CELL_M).ceil() as i32;
        let mut around: Vec<(f64, Tie)> = Vec::new();
        for (dx, dy) in (-reach..=reach).flat_map(|dy| (-reach..=reach).map(move |dx| (dx, dy))) {
            if let Some(ties) = self.ties.get(&[at[0] + dx, at[1] + dy]) {
                weigh(ties, [dx, dy], without, &mut around);
            }
        }
        limit_each(&mut around);
        let prior = Matrix2::from_diagonal_element(1.0 / (self.prior_m * self.prior_m));
        let mut bend = Bend { n: around.len(), ..self.none() };
        for scale_m in SCALES_M {
            let (mut a, mut b) = (prior, Vector2::zeros());
            for (weight, tie) in &around {
                let n = Vector2::from(tie.normal);
                let residual_m = tie.offset_m - n.dot(&bend.by_m);
                let robust = scale_m * scale_m / (scale_m * scale_m + residual_m * residual_m);
                let weight = weight * robust * robust / (NOISE_M * NOISE_M * ALIKE);
                a += n * weight * n.transpose();
                b += n * weight * tie.offset_m;
            }
            // The prior alone is positive definite.
            let Some(covariance) = a.try_inverse() else { return self.none() };
            (bend.covariance, bend.by_m) = (covariance, covariance * b);
        }
        bend
    }
}

impl Bend {
    /// Standard deviation along a direction.
    pub(crate) fn deviation_m(&self, n: [f64; 2]) -> f64 {
        let n = Vector2::from(n);
        n.dot(&(self.covariance * n)).max(0.0).sqrt()
    }

    /// Standard deviation in the direction that is held worst.
    pub(crate) fn worst_m(&self) -> f64 {
        self.covariance.symmetric_eigenvalues().max().max(0.0).sqrt()
    }
}

/// Of one element all samples together weigh no more than a surface that may have been built elsewhere: one wall bends no map.
fn limit_each(around: &mut [(f64, Tie)]) {
    let mut sums: BTreeMap<u32, f64> = BTreeMap::new();
    around.iter().for_each(|(weight, tie)| *sums.entry(tie.cut).or_default() += weight);
    for (weight, tie) in around {
        let variance = BUILT_M * BUILT_M + NOISE_M * NOISE_M * ALIKE / sums[&tie.cut];
        *weight *= NOISE_M * NOISE_M * ALIKE / sums[&tie.cut] / variance;
    }
}

pub(crate) fn square(at: [f64; 2]) -> [i32; 2] {
    at.map(|c| (c / BEND_CELL_M).floor() as i32)
}

/// Adds the surfaces of a square with the weight that its distance gives them.
fn weigh(ties: &[Tie], [dx, dy]: [i32; 2], without: Option<u32>, around: &mut Vec<(f64, Tie)>) {
    let far_m = libm::hypot(f64::from(dx), f64::from(dy)) * BEND_CELL_M / BEND_SIGMA_M;
    if far_m <= CUT_OFF {
        let weight = libm::exp(-far_m * far_m / 2.0);
        around.extend(ties.iter().filter(|t| Some(t.cut) != without).map(|t| (weight, *t)));
    }
}
