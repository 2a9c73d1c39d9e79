//! Local distortion of a SLAM map beside its frame, estimated from surfaces of surrounding elements.
//!
//! The distortion is a Gaussian process of which each piece of a side shows one component, with noise. Where pieces are
//! dense it follows them; away from them it returns to the prior: errors of the pose and drift of the map.
//!
//! # Source
//! Rasmussen and Williams, "Gaussian Processes for Machine Learning", 2006, chapters 2 and 5; weights of Geman and McClure.

use crate::distortion_prior::DistortionPrior;
use crate::surface_pieces::{SurfaceOffset, SurfacePiece, middle_of, square_of, surface_pieces};
use crate::thresholds::{
    AHEAD_SCALE, BUILT_M, DISTORTION_CELL_M, DISTORTION_REACH_M, DRIFTS_M, HIDDEN_SHARE, MAX_DISTORTION_M, MAX_PIECES,
    MAX_SCORED, NOISE_M, ROBUST_M,
};
use frames::PoseCovariance;
use nalgebra::{Cholesky, DMatrix, DVector, Dyn, Matrix2, MatrixXx2, Vector2};
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::f64::consts::TAU;

/// Local offset of the SLAM map from the model, with its covariance.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Distortion {
    pub(crate) by_m: Vector2<f64>,
    /// Of `by_m`, in m².
    pub(crate) covariance: Matrix2<f64>,
    /// Samples that it was estimated from.
    pub(crate) n: usize,
}

/// Pieces of sides by square, from which the distortion is estimated.
pub(crate) struct DistortionField {
    pieces: BTreeMap<[i32; 2], Vec<SurfacePiece>>,
    prior: DistortionPrior,
}

/// Scales of the robust residual relative to the last, so that displaced elements and furniture have little weight.
const SCALES: [f64; 4] = [4.0, 2.5, 1.5, 1.0];
/// A piece of less weight than that is as good as none.
const MIN_WEIGHT: f64 = 1e-4;

impl DistortionField {
    /// `pose` is the covariance of the pose of the whole map, for the place `about_m` in `map`; places drift by `least_drift_m` or more.
    pub(crate) fn new(
        offsets: impl Iterator<Item = SurfaceOffset>,
        about_m: [f64; 2],
        pose: &PoseCovariance,
        least_drift_m: f64,
    ) -> Self {
        let mut pieces: BTreeMap<[i32; 2], Vec<SurfacePiece>> = BTreeMap::new();
        for piece in surface_pieces(offsets) {
            pieces.entry(square_of(piece.at)).or_default().push(piece);
        }
        let with = |drift_m: f64| DistortionPrior::new(about_m, pose, drift_m.max(least_drift_m));
        let mut field = Self { pieces, prior: with(DRIFTS_M[0]) };
        let scored = field.scored_pieces();
        let score = |drift_m: &f64| -> f64 {
            let prior = with(*drift_m);
            scored.iter().map(|piece| field.score(&prior, piece)).sum()
        };
        let scores: Vec<f64> = DRIFTS_M.par_iter().map(score).collect();
        let best = (0..DRIFTS_M.len()).rev().max_by(|a, b| scores[*a].total_cmp(&scores[*b])).unwrap_or(0);
        field.prior = with(DRIFTS_M[best]);
        field
    }

    /// Zero distortion with the uncertainty of an unmeasured place.
    pub(crate) fn none(&self, at: [f64; 2]) -> Distortion {
        Distortion { by_m: Vector2::zeros(), covariance: self.prior.covariance(at, at), n: 0 }
    }

    /// Variance of the turn of the map at any place, in rad².
    pub(crate) fn turn_variance(&self) -> f64 {
        self.prior.turn_variance()
    }

    /// The distortion at a place, estimated without one body.
    pub(crate) fn at(&self, at: [f64; 2], without: Option<u32>) -> Distortion {
        self.estimate(&self.prior, at, without)
    }

    /// Middles of all squares with surfaces, and the distortion there.
    pub(crate) fn all(&self) -> Vec<([f64; 2], Distortion)> {
        self.pieces.par_iter().map(|(square, _)| (middle_of(*square), self.at(middle_of(*square), None))).collect()
    }

    /// Every second piece and no more than [`MAX_SCORED`], spread over the storey.
    fn scored_pieces(&self) -> Vec<SurfacePiece> {
        let all: Vec<SurfacePiece> = self.pieces.values().flatten().copied().collect();
        let step = all.len().div_ceil(MAX_SCORED).max(2);
        all.into_iter().step_by(step).collect()
    }

    /// Logarithm of the probability density of a piece, given all other bodies. Some sides are hidden, and what is found is
    /// anything.
    fn score(&self, prior: &DistortionPrior, piece: &SurfacePiece) -> f64 {
        let predicted = self.estimate(prior, piece.at, Some(piece.body));
        let variance = predicted.deviation_m(piece.normal).powi(2) + piece.variance();
        let off_m = piece.offset_m - predicted.along(piece.normal);
        let density = libm::exp(-off_m * off_m / (2.0 * variance)) / (TAU * variance).sqrt();
        libm::log((1.0 - HIDDEN_SHARE) * density + HIDDEN_SHARE / (2.0 * MAX_DISTORTION_M))
    }

    /// The pieces nearest to a place.
    fn around(&self, at: [f64; 2], without: Option<u32>) -> Vec<SurfacePiece> {
        let reach = (DISTORTION_REACH_M / DISTORTION_CELL_M).ceil() as i32;
        let [column, row] = square_of(at);
        let rows = (row - reach..=row + reach).flat_map(|y| (column - reach..=column + reach).map(move |x| [x, y]));
        let mut around: Vec<(f64, SurfacePiece)> = rows
            .filter_map(|square| self.pieces.get(&square))
            .flatten()
            .filter(|piece| Some(piece.body) != without)
            .map(|piece| (libm::hypot(piece.at[0] - at[0], piece.at[1] - at[1]), *piece))
            .filter(|(far_m, _)| *far_m <= DISTORTION_REACH_M)
            .collect();
        around.sort_by(|a, b| a.0.total_cmp(&b.0));
        around.truncate(MAX_PIECES);
        around.into_iter().map(|(_, piece)| piece).collect()
    }

    fn estimate(&self, prior: &DistortionPrior, at: [f64; 2], without: Option<u32>) -> Distortion {
        let around = self.around(at, without);
        let unseen = Distortion { by_m: Vector2::zeros(), covariance: prior.covariance(at, at), n: 0 };
        let Some((solver, solved)) = weighed(prior, &around) else { return unseen };
        let to_place = MatrixXx2::from_rows(
            &around
                .iter()
                .map(|piece| (prior.covariance(piece.at, at).transpose() * Vector2::from(piece.normal)).transpose())
                .collect::<Vec<_>>(),
        );
        Distortion {
            by_m: to_place.transpose() * solved,
            covariance: unseen.covariance - to_place.transpose() * solver.solve(&to_place),
            n: around.iter().map(|piece| piece.n).sum(),
        }
    }
}

/// The covariance of the offsets of pieces with robust weights, decomposed, and its inverse times the offsets; `None` of no
/// pieces.
fn weighed(prior: &DistortionPrior, around: &[SurfacePiece]) -> Option<(Cholesky<f64, Dyn>, DVector<f64>)> {
    let n = around.len();
    if n == 0 {
        return None;
    }
    let of_field = DMatrix::from_fn(n, n, |i, j| {
        let (a, b) = (&around[i], &around[j]);
        Vector2::from(a.normal).dot(&(prior.covariance(a.at, b.at) * Vector2::from(b.normal)))
    });
    let of_pieces = DMatrix::from_fn(n, n, |i, j| match i == j {
        true => around[i].variance(),
        false => around[i].shared_with(&around[j]),
    });
    let offsets = DVector::from_iterator(n, around.iter().map(|piece| piece.offset_m));
    let mut covariance = &of_field + &of_pieces;
    for scale in SCALES {
        let solved = covariance.clone().cholesky()?.solve(&offsets);
        let fitted = &of_field * solved;
        for (k, piece) in around.iter().enumerate() {
            let variance = of_pieces[(k, k)];
            covariance[(k, k)] =
                of_field[(k, k)] + variance / robust_weight(piece.offset_m - fitted[k], scale * ROBUST_M);
        }
    }
    let solver = covariance.cholesky()?;
    let solved = solver.solve(&offsets);
    Some((solver, solved))
}

/// Furniture stands before walls and never behind them.
fn robust_weight(residual_m: f64, scale_m: f64) -> f64 {
    let scale_m = if residual_m > 0.0 { scale_m * AHEAD_SCALE } else { scale_m };
    let robust = 1.0 / (1.0 + (residual_m / scale_m).powi(2));
    (robust * robust).max(MIN_WEIGHT)
}

impl SurfacePiece {
    /// Variance of its offset from the distorted model.
    fn variance(&self) -> f64 {
        // Samples of half a metre are alike; a metre of them is hardly better.
        let alike = (10.0 / self.n as f64).max(0.5);
        BUILT_M * BUILT_M + NOISE_M * NOISE_M * alike
    }

    /// Covariance with another piece: all of a body is off by the same.
    fn shared_with(&self, other: &Self) -> f64 {
        if self.body != other.body {
            return 0.0;
        }
        BUILT_M * BUILT_M * (self.normal[0] * other.normal[0] + self.normal[1] * other.normal[1])
    }
}

impl Distortion {
    /// The distortion along a direction.
    pub(crate) fn along(&self, n: [f64; 2]) -> f64 {
        Vector2::from(n).dot(&self.by_m)
    }

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
