//! Local distortion of a SLAM map, estimated from surfaces of surrounding elements.

use crate::thresholds::{
    ALIKE, BUILT_M, DISTORTION_CELL_M, DISTORTION_SIGMA_M, MAX_DISTORTION_M, MIN_DISTORTION_M, NOISE_M,
    PRIOR_DISTORTION_M,
};
use nalgebra::{Matrix2, Vector2};
use std::collections::BTreeMap;

/// A surface found along the normal of an element's side.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SurfaceOffset {
    pub(crate) normal: [f64; 2],
    /// Its offset along the outward normal.
    pub(crate) offset_m: f64,
    /// First element of the wall with all of its leafs, or the element.
    pub(crate) body: u32,
}

/// Local offset of the SLAM map from the model, with its covariance.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Distortion {
    pub(crate) by_m: Vector2<f64>,
    /// Of `by_m`, in m².
    covariance: Matrix2<f64>,
    pub(crate) n: usize,
}

/// Surface offsets by square, from which the distortion is estimated.
pub(crate) struct DistortionField {
    surfaces: BTreeMap<[i32; 2], Vec<SurfaceOffset>>,
    /// Standard deviation where nothing was measured.
    prior_m: f64,
    /// Root mean square over all squares.
    pub(crate) rms_m: f64,
}

/// Weights are 0 beyond this multiple of sigma.
const CUT_OFF: f64 = 2.0;
/// Scales of the robust residual, from coarse to fine, so that displaced elements have little weight.
const SCALES_M: [f64; 5] = [0.3, 0.2, 0.12, 0.08, 0.08];

impl DistortionField {
    /// `pose_m` is the standard deviation of the pose of the whole map.
    pub(crate) fn new(surfaces: impl Iterator<Item = ([f64; 2], SurfaceOffset)>, pose_m: f64) -> Self {
        let mut field =
            Self { surfaces: BTreeMap::new(), prior_m: libm::hypot(PRIOR_DISTORTION_M, pose_m), rms_m: 0.0 };
        for (at, surface) in surfaces.filter(|(_, surface)| surface.offset_m.abs() <= MAX_DISTORTION_M) {
            field.surfaces.entry(square(at)).or_default().push(surface);
        }
        let all: Vec<Distortion> = field.surfaces.keys().map(|square| field.at_square(*square, None)).collect();
        let sum: f64 = all.iter().map(|b| b.by_m.norm_squared()).sum();
        field.rms_m = (sum / all.len().max(1) as f64).sqrt();
        // Distortion elsewhere is assumed as large as where it is measured.
        field.prior_m = libm::hypot(field.rms_m.clamp(MIN_DISTORTION_M, 2.0 * PRIOR_DISTORTION_M), pose_m);
        field
    }

    /// Zero distortion with the uncertainty of an unmeasured place.
    pub(crate) fn none(&self) -> Distortion {
        let covariance = Matrix2::from_diagonal_element(self.prior_m * self.prior_m);
        Distortion { by_m: Vector2::zeros(), covariance, n: 0 }
    }

    /// The distortion at a point, estimated without one body.
    pub(crate) fn at(&self, at: [f64; 2], without: Option<u32>) -> Distortion {
        self.at_square(square(at), without)
    }

    /// Middles of all squares with surfaces, and the distortion there.
    pub(crate) fn all(&self) -> impl Iterator<Item = ([f64; 2], Distortion)> {
        self.surfaces.keys().map(|s| (s.map(|c| (f64::from(c) + 0.5) * DISTORTION_CELL_M), self.at_square(*s, None)))
    }

    fn at_square(&self, at: [i32; 2], without: Option<u32>) -> Distortion {
        let reach = (CUT_OFF * DISTORTION_SIGMA_M / DISTORTION_CELL_M).ceil() as i32;
        let mut around: Vec<(f64, SurfaceOffset)> = Vec::new();
        for (dx, dy) in (-reach..=reach).flat_map(|dy| (-reach..=reach).map(move |dx| (dx, dy))) {
            if let Some(surfaces) = self.surfaces.get(&[at[0] + dx, at[1] + dy]) {
                weigh(surfaces, [dx, dy], without, &mut around);
            }
        }
        limit_each(&mut around);
        let prior = Matrix2::from_diagonal_element(1.0 / (self.prior_m * self.prior_m));
        let mut distortion = Distortion { n: around.len(), ..self.none() };
        for scale_m in SCALES_M {
            let (mut a, mut b) = (prior, Vector2::zeros());
            for (weight, surface) in &around {
                let n = Vector2::from(surface.normal);
                let residual_m = surface.offset_m - n.dot(&distortion.by_m);
                let robust = scale_m * scale_m / (scale_m * scale_m + residual_m * residual_m);
                let weight = weight * robust * robust / (NOISE_M * NOISE_M * ALIKE);
                a += n * weight * n.transpose();
                b += n * weight * surface.offset_m;
            }
            // The prior alone is positive definite.
            let Some(covariance) = a.try_inverse() else { return self.none() };
            (distortion.covariance, distortion.by_m) = (covariance, covariance * b);
        }
        distortion
    }
}

impl Distortion {
    /// Standard deviation along a direction.
    pub(crate) fn deviation_m(&self, n: [f64; 2]) -> f64 {
        let n = Vector2::from(n);
        n.dot(&(self.covariance * n)).max(0.0).sqrt()
    }

    /// Largest standard deviation of any direction.
    pub(crate) fn worst_m(&self) -> f64 {
        self.covariance.symmetric_eigenvalues().max().max(0.0).sqrt()
    }
}

/// Limits the weight of all samples of one body, which may be displaced itself.
fn limit_each(around: &mut [(f64, SurfaceOffset)]) {
    let mut sums: BTreeMap<u32, f64> = BTreeMap::new();
    around.iter().for_each(|(weight, surface)| *sums.entry(surface.body).or_default() += weight);
    for (weight, surface) in around {
        let variance = BUILT_M * BUILT_M + NOISE_M * NOISE_M * ALIKE / sums[&surface.body];
        *weight *= NOISE_M * NOISE_M * ALIKE / sums[&surface.body] / variance;
    }
}

pub(crate) fn square(at: [f64; 2]) -> [i32; 2] {
    at.map(|c| (c / DISTORTION_CELL_M).floor() as i32)
}

/// Adds the surfaces of a square with the weight that its distance gives them.
fn weigh(surfaces: &[SurfaceOffset], [dx, dy]: [i32; 2], without: Option<u32>, around: &mut Vec<(f64, SurfaceOffset)>) {
    let far_m = libm::hypot(f64::from(dx), f64::from(dy)) * DISTORTION_CELL_M / DISTORTION_SIGMA_M;
    if far_m <= CUT_OFF {
        let weight = libm::exp(-far_m * far_m / 2.0);
        around.extend(surfaces.iter().filter(|t| Some(t.body) != without).map(|t| (weight, *t)));
    }
}
