//! Fits a part of a SLAM map to the reference near a predicted pose, and tells what bears the fit out.

use crate::features::Features;
use crate::map_parts::MapParts;
use crate::pose::{Pose, moved};
use crate::score::IN_FRONT_M;
use crate::wall_points::WallPoint;
use frames::wrapped;
use nalgebra::{Matrix2, Matrix3, Vector3};
use occupancy::CELL_M;
use std::collections::BTreeMap;

/// Scales of the residual from coarse to fine, in metres, and how often each is taken.
const SCALES_M: [f64; 4] = [0.3, 0.2, 0.12, 0.1];
const TIMES: usize = 2;
/// A wall point is explained by a face that is this close, with about the same normal.
const EXPLAINED_M: f64 = 0.12;
const AGREEMENT: f64 = 0.8;
/// A wall of a SLAM map is as rough as this, in metres.
const NOISE_M: f64 = 0.03;
/// Neighbouring wall points are not independent, and those of linked parts are counted in each: as many tell as much as one.
const POINTS_PER_MEASUREMENT: f64 = 48.0;
/// Wall points of a part that are compared.
const MAX_POINTS: usize = 240;

/// A part is borne out if the reference has so much of the walls that it shows: in metres, and as a share. With a share of 0.45 parts of
/// maps of Karto and MRPT were that lie up to 0.5 m elsewhere; on their maps a part has either more than 0.7 or next to nothing.
const MIN_EXPLAINED_M: f64 = 1.0;
const MIN_EXPLAINED_SHARE: f64 = 0.6;
/// Or if it shows so much of the reference's walls that were in sight, whatever furniture it shows beside them.
const MIN_RECALLED_M: f64 = 1.5;
const MIN_RECALLED_SHARE: f64 = 0.7;

/// A prediction that is known less well than this is searched from several starts, in metres.
const VAGUE_M: f64 = 0.2;
/// Distance of these starts, and how far they go.
const STEP_M: f64 = 0.3;
const MAX_REACH_M: f64 = 1.2;
/// Log odds for a place by each metre of wall that it explains, and those by which one must be ahead of all others.
const LOG_ODDS_PER_M: f64 = 3.0;
const CLEAR_LOG_ODDS: f64 = 3.0;

/// Squares by which walls of the reference are found, in metres.
const NEAR_M: f64 = 2.5;

/// Two maps, of which parts are fitted.
pub(crate) struct FittedMaps<'a> {
    pub(crate) reference: &'a Features,
    slam: &'a Features,
    pub(crate) map: &'a MapParts,
    /// Of each part the walls of its own, and with them those of the parts around it, by which it is fitted: those of 3 m alone
    /// fit in many places.
    own: Vec<Vec<WallPoint>>,
    around: Vec<Vec<WallPoint>>,
    /// Wall points of the reference by square.
    near: BTreeMap<[i64; 2], Vec<u32>>,
}

/// A pose of a part, with its uncertainty.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Prediction {
    pub(crate) pose: Pose,
    /// Of where its centre lies, and of yaw.
    pub(crate) covariance: Matrix3<f64>,
}

impl Prediction {
    /// Standard deviation of the place in the direction that is known worst, in metres.
    pub(crate) fn worst_m(&self) -> f64 {
        let of_place: Matrix2<f64> = self.covariance.fixed_view::<2, 2>(0, 0).into_owned();
        of_place.symmetric_eigenvalues().max().max(0.0).sqrt()
    }
}

/// Walls of a part that the reference has.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Explained {
    /// Length of the part's own walls, weighted as walls are, and of those that the reference has.
    pub(crate) walls_m: f64,
    pub(crate) explained_m: f64,
    /// True if that bears the pose out, or what the part shows of the reference's walls does.
    pub(crate) is_borne_out: bool,
}

/// A part in its place.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PartFit {
    pub(crate) placed: Prediction,
    pub(crate) explained: Explained,
    /// Log odds for the fit against the prediction alone.
    pub(crate) log_odds: f64,
    /// Length of the walls around that are explained, less what the way from the prediction costs, as log odds.
    worth: f64,
}

/// Normal equations of a motion around the placed centre of a part.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Measurement {
    pub(crate) information: Matrix3<f64>,
    pub(crate) gradient: Vector3<f64>,
}

impl Measurement {
    pub(crate) const NONE: Self = Self {
        information: Matrix3::new(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
        gradient: Vector3::new(0.0, 0.0, 0.0),
    };
}

impl<'a> FittedMaps<'a> {
    pub(crate) fn of(reference: &'a Features, slam: &'a Features, map: &'a MapParts) -> Self {
        let own = map.parts.iter().map(|part| thinned(part.wall_points.iter())).collect();
        let around = (0..map.parts.len()).map(|k| {
            let linked = map.links[k].iter().flat_map(|link| &map.parts[link.to].wall_points);
            thinned(map.parts[k].wall_points.iter().chain(linked))
        });
        let mut near: BTreeMap<[i64; 2], Vec<u32>> = BTreeMap::new();
        for (wall_point, k) in reference.wall_points().iter().zip(0..) {
            near.entry(square(wall_point.at)).or_default().push(k);
        }
        Self { reference, slam, map, own, around: around.collect(), near }
    }

    /// Fits a part near a prediction; where that is vague from several starts, and only if one place is clearly better than all others.
    pub(crate) fn fitted(&self, part: usize, predicted: &Prediction) -> PartFit {
        let near = self.fitted_from(part, predicted, &predicted.pose);
        let deviation_m = predicted.worst_m();
        if deviation_m < VAGUE_M {
            return near;
        }
        let centre = self.map.parts[part].centre;
        let about = predicted.pose.apply(centre);
        let n = ((2.0 * deviation_m).min(MAX_REACH_M) / STEP_M).ceil() as i32;
        let steps = || (-n..=n).map(|k| f64::from(k) * STEP_M);
        let starts = steps().flat_map(|y| steps().map(move |x| [x, y, 0.0]));
        let mut fits: Vec<PartFit> =
            starts.map(|start| self.fitted_from(part, predicted, &moved(&predicted.pose, start, about))).collect();
        fits.push(near);
        let best = fits.iter().copied().reduce(|a, b| if b.worth > a.worth { b } else { a }).unwrap_or(near);
        let place = best.placed.pose.apply(centre);
        let is_elsewhere = |fit: &&PartFit| {
            let other = fit.placed.pose.apply(centre);
            libm::hypot(other[0] - place[0], other[1] - place[1]) > STEP_M
        };
        let is_clear = fits.iter().filter(is_elsewhere).all(|other| other.worth < best.worth - CLEAR_LOG_ODDS);
        let is_borne_out = best.explained.is_borne_out && is_clear;
        PartFit { explained: Explained { is_borne_out, ..best.explained }, ..best }
    }

    /// Gauss-Newton from a start, with the prediction as a prior.
    fn fitted_from(&self, part: usize, predicted: &Prediction, start: &Pose) -> PartFit {
        let centre = self.map.parts[part].centre;
        let prior = predicted.covariance.try_inverse().unwrap_or_else(Matrix3::zeros);
        let away = |pose: &Pose| difference(pose, &predicted.pose, centre);
        let (mut pose, mut covariance) = (*start, predicted.covariance);
        for scale_m in SCALES_M {
            for _ in 0..TIMES {
                let Measurement { information, gradient } = self.measured_at(part, &pose, scale_m);
                let Some(inverse) = (information + prior).try_inverse() else { break };
                let step = inverse * (gradient - prior * away(&pose));
                pose = moved(&pose, step.into(), pose.apply(centre));
                covariance = inverse;
            }
        }
        let explained = self.explained(part, &pose);
        let surprise = (away(&pose).transpose() * prior * away(&pose))[0] / 2.0;
        let narrowed = libm::log((predicted.covariance.determinant() / covariance.determinant()).max(1.0)) / 2.0;
        let explained_around_m = explained_m(self.reference, &self.around[part], &pose);
        PartFit {
            placed: Prediction { pose, covariance },
            explained,
            log_odds: LOG_ODDS_PER_M * explained.explained_m - surprise - narrowed,
            worth: LOG_ODDS_PER_M * explained_around_m - surprise,
        }
    }

    /// What the walls around a part say about its pose.
    pub(crate) fn measured(&self, part: usize, pose: &Pose) -> Measurement {
        self.measured_at(part, pose, SCALES_M[SCALES_M.len() - 1])
    }

    fn measured_at(&self, part: usize, pose: &Pose, scale_m: f64) -> Measurement {
        let about = pose.apply(self.map.parts[part].centre);
        let mut sum = Measurement::NONE;
        for point in &self.around[part] {
            let (at, normal) = (pose.apply(point.at), pose.rotate(point.normal));
            let Some((nearest, squared)) = self.reference.nearest(at) else { continue };
            if squared > 9.0 * scale_m * scale_m || dot(normal, nearest.normal) < AGREEMENT {
                continue;
            }
            let [nx, ny] = nearest.normal;
            let residual_m = dot([at[0] - nearest.at[0], at[1] - nearest.at[1]], nearest.normal);
            let robust = scale_m * scale_m / (scale_m * scale_m + residual_m * residual_m);
            let weight = point.weight * robust * robust;
            let slopes = Vector3::new(nx, ny, ny * (at[0] - about[0]) - nx * (at[1] - about[1]));
            sum.information += weight * slopes * slopes.transpose();
            sum.gradient -= weight * residual_m * slopes;
        }
        let noise_m = (scale_m / 3.0).max(NOISE_M);
        let factor = 1.0 / (noise_m * noise_m * POINTS_PER_MEASUREMENT);
        Measurement { information: sum.information * factor, gradient: sum.gradient * factor }
    }

    /// The walls of a part that the reference has.
    pub(crate) fn explained(&self, part: usize, pose: &Pose) -> Explained {
        let points = &self.own[part];
        let walls_m = points.iter().map(|point| point.weight).sum::<f64>() * CELL_M;
        let explained_m = explained_m(self.reference, points, pose);
        let by_its_walls = explained_m >= MIN_EXPLAINED_M && explained_m >= MIN_EXPLAINED_SHARE * walls_m;
        Explained { walls_m, explained_m, is_borne_out: by_its_walls || self.is_recalled(part, pose) }
    }

    /// True if a part shows most of the reference's walls that were in sight from it.
    fn is_recalled(&self, part: usize, pose: &Pose) -> bool {
        let (mut n_seen, mut n_found) = (0usize, 0usize);
        let [column, row] = square(pose.apply(self.map.parts[part].centre));
        let squares = (row - 1..=row + 1).flat_map(|row| (column - 1..=column + 1).map(move |column| [column, row]));
        for &k in squares.filter_map(|square| self.near.get(&square)).flatten() {
            let wall_point = &self.reference.wall_points()[k as usize];
            let before = [0, 1].map(|k| wall_point.at[k] + IN_FRONT_M * wall_point.normal[k]);
            let seen_from = self.slam.raster.index_at(pose.apply_inverse(before)).and_then(|c| self.map.of_cell(c));
            if seen_from != Some(part) {
                continue;
            }
            n_seen += 1;
            let nearest = self.slam.nearest(pose.apply_inverse(wall_point.at));
            n_found += usize::from(nearest.is_some_and(|(nearest, squared)| {
                squared <= EXPLAINED_M * EXPLAINED_M && dot(pose.rotate(nearest.normal), wall_point.normal) > AGREEMENT
            }));
        }
        let found_m = n_found as f64 * CELL_M;
        found_m >= MIN_RECALLED_M && n_found as f64 >= MIN_RECALLED_SHARE * n_seen as f64
    }
}

/// The motion from a pose to another one: of where a point comes to lie, and of yaw.
pub(crate) fn difference(pose: &Pose, from: &Pose, point: [f64; 2]) -> Vector3<f64> {
    let (at, before) = (pose.apply(point), from.apply(point));
    Vector3::new(at[0] - before[0], at[1] - before[1], wrapped(pose.yaw_rad() - from.yaw_rad()))
}

/// Every so many wall points, each with the weight of those that are left out.
fn thinned<'w>(wall_points: impl Iterator<Item = &'w WallPoint>) -> Vec<WallPoint> {
    let all: Vec<WallPoint> = wall_points.copied().collect();
    let step = all.len().div_ceil(MAX_POINTS).max(1);
    all.iter().step_by(step).map(|w| WallPoint { weight: w.weight * step as f64, ..*w }).collect()
}

/// Length of the walls that the reference has, by weight.
fn explained_m(reference: &Features, points: &[WallPoint], pose: &Pose) -> f64 {
    points.iter().filter(|point| is_explained(reference, point, pose)).map(|point| point.weight).sum::<f64>() * CELL_M
}

/// True if the reference has a wall of the SLAM map where the pose puts it.
pub(crate) fn is_explained(reference: &Features, point: &WallPoint, pose: &Pose) -> bool {
    let normal = pose.rotate(point.normal);
    reference.nearest(pose.apply(point.at)).is_some_and(|(nearest, squared)| {
        squared <= EXPLAINED_M * EXPLAINED_M && dot(normal, nearest.normal) > AGREEMENT
    })
}

fn square(at: [f64; 2]) -> [i64; 2] {
    at.map(|c| (c / NEAR_M).floor() as i64)
}

fn dot(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}
