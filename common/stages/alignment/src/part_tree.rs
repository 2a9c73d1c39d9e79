//! Estimates the poses of all parts of a SLAM map along a tree of visits: the motion from part to part is a random walk, and the walls of
//! each part that the reference has are measurements of it.
//!
//! # Source
//! Rauch, Tung and Striebel, "Maximum likelihood estimates of linear dynamic systems", AIAA Journal 3, 1965, along a tree: messages of
//! Gaussians from the leaves to the root and back.

use crate::map_parts::MapParts;
use crate::part_fit::{Measurement, Prediction, difference};
use crate::pose::{Pose, moved};
use nalgebra::{Matrix3, Vector3};

/// How a map drifts: deviations of place and yaw grow with the root of the way.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Drift {
    /// After a metre.
    pub(crate) m: f64,
}

/// Of yaw, in radians for each metre that the place drifts by.
const RAD_PER_M: f64 = 0.2;

impl Drift {
    /// The covariance that a way adds.
    pub(crate) fn over(self, length_m: f64) -> Matrix3<f64> {
        let of_place = self.m * self.m * length_m;
        Matrix3::from_diagonal(&Vector3::new(of_place, of_place, RAD_PER_M * RAD_PER_M * of_place))
    }
}

/// A part that was visited.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Visited {
    pub(crate) part: usize,
    pub(crate) placed: Prediction,
    /// From which one, by its place in the order of visits, and how far; `None` for the first.
    pub(crate) from: Option<(usize, f64)>,
    pub(crate) measurement: Measurement,
}

/// The prediction for a part from that of another one.
pub(crate) fn predicted(
    map: &MapParts,
    from: usize,
    placed: &Prediction,
    to: usize,
    length_m: f64,
    drift: Drift,
) -> Prediction {
    let jacobian = jacobian(map, &placed.pose, from, to);
    let covariance = jacobian * placed.covariance * jacobian.transpose() + drift.over(length_m);
    Prediction { pose: placed.pose, covariance }
}

/// How a small motion around the centre of a part moves the centre of another one.
fn jacobian(map: &MapParts, pose: &Pose, from: usize, to: usize) -> Matrix3<f64> {
    let (from, to) = (pose.apply(map.parts[from].centre), pose.apply(map.parts[to].centre));
    Matrix3::new(1.0, 0.0, from[1] - to[1], 0.0, 1.0, to[0] - from[0], 0.0, 0.0, 1.0)
}

/// Moves all parts by what all measurements say together; `visits` are in their order, and `start` is what is known of the first.
pub(crate) fn smooth(map: &MapParts, visits: &mut [Visited], start: &Prediction, drift: Drift) {
    let Some(first) = visits.first() else { return };
    let prior = start.covariance.try_inverse().unwrap_or_else(Matrix3::zeros);
    let away = difference(&first.placed.pose, &start.pose, map.parts[first.part].centre);
    let mut gathered: Vec<Measurement> = visits.iter().map(|visit| visit.measurement).collect();
    gathered[0].information += prior;
    gathered[0].gradient -= prior * away;
    let mut to_parent = vec![Measurement::NONE; visits.len()];
    for k in (1..visits.len()).rev() {
        let Some(edge) = Edge::to(map, visits, k, drift) else { continue };
        to_parent[k] = edge.towards_parent(&gathered[k]);
        let parent = &mut gathered[edge.parent];
        *parent = added(parent, &to_parent[k], 1.0);
    }
    for k in 1..visits.len() {
        let Some(edge) = Edge::to(map, visits, k, drift) else { continue };
        let without = added(&gathered[edge.parent], &to_parent[k], -1.0);
        gathered[k] = added(&gathered[k], &edge.towards_child(&without), 1.0);
    }
    for (visit, Measurement { information, gradient }) in visits.iter_mut().zip(gathered) {
        let Some(covariance) = information.try_inverse() else { continue };
        let about = visit.placed.pose.apply(map.parts[visit.part].centre);
        let pose = moved(&visit.placed.pose, (covariance * gradient).into(), about);
        visit.placed = Prediction { pose, covariance };
    }
}

fn added(a: &Measurement, b: &Measurement, sign: f64) -> Measurement {
    Measurement { information: a.information + sign * b.information, gradient: a.gradient + sign * b.gradient }
}

/// The way to a part: `jacobian * motion of the parent = motion of the part + apart + noise`.
struct Edge {
    parent: usize,
    jacobian: Matrix3<f64>,
    /// How far the part lies from where its parent puts it.
    apart: Vector3<f64>,
    /// Inverse of the noise's covariance.
    weight: Matrix3<f64>,
}

impl Edge {
    fn to(map: &MapParts, visits: &[Visited], k: usize, drift: Drift) -> Option<Self> {
        let child = &visits[k];
        let (parent, length_m) = child.from?;
        let of_parent = &visits[parent];
        Some(Self {
            parent,
            jacobian: jacobian(map, &of_parent.placed.pose, of_parent.part, child.part),
            apart: difference(&child.placed.pose, &of_parent.placed.pose, map.parts[child.part].centre),
            weight: drift.over(length_m).try_inverse()?,
        })
    }

    fn towards_parent(&self, child: &Measurement) -> Measurement {
        let Measurement { information, gradient } = self.loosened(child);
        let transposed = self.jacobian.transpose();
        Measurement {
            information: transposed * information * self.jacobian,
            gradient: transposed * (gradient + information * self.apart),
        }
    }

    fn towards_child(&self, parent: &Measurement) -> Measurement {
        let back = self.jacobian.try_inverse().expect("a shear can be inverted");
        let carried = Measurement {
            information: back.transpose() * parent.information * back,
            gradient: back.transpose() * parent.gradient,
        };
        let Measurement { information, gradient } = self.loosened(&carried);
        Measurement { information, gradient: gradient - information * self.apart }
    }

    /// What is known of a vector that differs from a measured one by the noise.
    fn loosened(&self, measured: &Measurement) -> Measurement {
        let sum = (measured.information + self.weight).try_inverse().expect("the weight is positive definite");
        let gain = self.weight * sum;
        Measurement { information: self.weight - gain * self.weight, gradient: gain * measured.gradient }
    }
}
