//! A motion of the plane that differs from place to place: a rigid motion at each of some places, blended between them.

use crate::{Rigid2, wrapped};
use std::iter;

/// Places nearer to each other than about this have the same motion, in metres.
const BLEND_M: f64 = 2.5;
/// A place is found back when it is moved to within this of where it belongs, in metres.
const FOUND_M: f64 = 1e-6;
/// Steps in which it is found, where the motion stretches the plane by less than a half.
const MAX_STEPS: usize = 60;

/// Motion of the plane taking `From` coordinates to `To` coordinates by rigid motions that were found at places of it.
///
/// Each of them counts with the weight 1 / (s² (d² + b²)⁴) at the distance d, where s is its deviation and b is 2.5 m. So it is smooth
/// everywhere, near places are moved by their own motion whatever happens far from them, and what lies outside of all is moved by
/// those at the border.
///
/// # Source
/// D. Shepard, "A two-dimensional interpolation function for irregularly-spaced data", 1968.
#[derive(Debug, Clone)]
pub struct BentMotion<To, From> {
    knots: Vec<Knot<To, From>>,
}

#[derive(Debug, Clone)]
struct Knot<To, From> {
    at_m: [f64; 2],
    motion: Rigid2<To, From>,
    /// Inverse variance.
    weight: f64,
}

impl<To, From> BentMotion<To, From> {
    /// From places in `From`, in metres, the motion at each, and the deviation of where that puts the place, in metres and more than 0; `None`
    /// without any.
    pub fn of(motions: impl IntoIterator<Item = ([f64; 2], Rigid2<To, From>, f64)>) -> Option<Self> {
        let knot =
            |(at_m, motion, deviation_m): (_, _, f64)| Knot { at_m, motion, weight: 1.0 / (deviation_m * deviation_m) };
        let knots: Vec<Knot<To, From>> = motions.into_iter().map(knot).collect();
        (!knots.is_empty()).then_some(Self { knots })
    }

    /// A rigid motion.
    pub fn rigid(motion: Rigid2<To, From>) -> Self {
        Self { knots: vec![Knot { at_m: [0.0; 2], motion, weight: 1.0 }] }
    }

    /// Moves a place, in metres.
    pub fn apply(&self, p_from_m: [f64; 2]) -> [f64; 2] {
        self.moved(p_from_m).0
    }

    /// The rigid motion that is nearest to this one around a place in `From`, in metres: it moves the place alike.
    pub fn around(&self, p_from_m: [f64; 2]) -> Rigid2<To, From> {
        let (at, yaw_rad) = self.moved(p_from_m);
        let turned = Rigid2::<To, From>::new([0.0; 2], yaw_rad).apply(p_from_m);
        Rigid2::new([0, 1].map(|k| at[k] - turned[k]), yaw_rad)
    }

    /// The place that is moved to one in `To`, in metres; `None` where the motion folds the plane so much that it is not found.
    pub fn apply_inverse(&self, p_to_m: [f64; 2]) -> Option<[f64; 2]> {
        let by_knots = self.knots.iter().map(|knot| (knot.at_m, knot.motion.apply_inverse(p_to_m)));
        let far_m = |(at, place): &([f64; 2], [f64; 2])| libm::hypot(place[0] - at[0], place[1] - at[1]);
        let (_, start) = by_knots.min_by(|a, b| far_m(a).total_cmp(&far_m(b)))?;
        let step = |place: &[f64; 2]| {
            let ([x, y], yaw_rad) = self.moved(*place);
            let off = [p_to_m[0] - x, p_to_m[1] - y];
            let by = Rigid2::<From, To>::new([0.0; 2], -yaw_rad).rotate(off);
            (libm::hypot(off[0], off[1]) > FOUND_M).then_some([place[0] + by[0], place[1] + by[1]])
        };
        let found = iter::successors(Some(start), step).take(MAX_STEPS).last()?;
        step(&found).is_none().then_some(found)
    }

    /// A moved place, and the angle by which its surroundings are turned.
    fn moved(&self, place: [f64; 2]) -> ([f64; 2], f64) {
        // Turns are blended as differences from the first one, the short way around.
        let first_rad = self.knots.first().map_or(0.0, |knot| knot.motion.yaw_rad());
        let (mut sum, mut at, mut turn_rad) = (0.0, [0.0; 2], 0.0);
        for Knot { at_m, motion, weight } in &self.knots {
            let (dx, dy) = (place[0] - at_m[0], place[1] - at_m[1]);
            let square_m2 = dx * dx + dy * dy + BLEND_M * BLEND_M;
            let weight = weight / (square_m2 * square_m2 * (square_m2 * square_m2));
            let [x, y] = motion.apply(place);
            (sum, at) = (sum + weight, [at[0] + weight * x, at[1] + weight * y]);
            turn_rad += weight * wrapped(motion.yaw_rad() - first_rad);
        }
        (at.map(|c| c / sum), wrapped(first_rad + turn_rad / sum))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Map, Slam};
    use proptest::prelude::*;

    /// A corridor of 60 m whose end is off by three quarters of a metre.
    fn corridor() -> BentMotion<Map, Slam> {
        let motion = |k: i32| {
            let (x_m, turn_rad) = (f64::from(k) * 3.0, f64::from(k) * 0.0013);
            ([x_m, 0.0], Rigid2::new([5.0, -0.5 * x_m * turn_rad], 0.3 + turn_rad), 0.1)
        };
        BentMotion::of((0..20).map(motion)).unwrap()
    }

    #[test]
    fn one_knot_is_a_rigid_motion() {
        let motion = Rigid2::<Map, Slam>::new([3.0, -7.0], 2.9);
        let bent = BentMotion::rigid(motion);
        for place in [[0.0, 0.0], [40.0, -3.0], [-1e4, 1e4]] {
            let (a, b) = (bent.apply(place), motion.apply(place));
            assert!(libm::hypot(a[0] - b[0], a[1] - b[1]) < 1e-9);
            assert!((bent.around(place).yaw_rad() - 2.9).abs() < 1e-12);
        }
    }

    #[test]
    fn places_are_moved_by_the_motion_around_them_whatever_lies_far_away() {
        let near = Rigid2::<Map, Slam>::new([0.1, 0.0], 0.0);
        let far = Rigid2::<Map, Slam>::new([20.0, 20.0], 0.0);
        let bent = BentMotion::of([([0.0, 0.0], near, 0.1), ([3.0, 0.0], near, 0.1), ([60.0, 0.0], far, 0.1)]).unwrap();
        let [x, y] = bent.apply([1.0, 0.5]);
        assert!((x - 1.1).abs() < 1e-6 && (y - 0.5).abs() < 1e-6, "{x} {y}");
        let beyond = bent.apply([90.0, 0.0]);
        assert!((beyond[0] - 110.0).abs() < 0.1, "what lies outside follows the border: {beyond:?}");
    }

    #[test]
    fn there_is_no_motion_of_no_places() {
        assert!(BentMotion::<Map, Slam>::of([]).is_none());
    }

    #[test]
    fn turns_are_blended_the_short_way_around() {
        let [a, b] = [3.1, -3.1].map(|yaw_rad| Rigid2::<Map, Slam>::new([0.0; 2], yaw_rad));
        let yaw_rad = BentMotion::of([([-1.0, 0.0], a, 0.1), ([1.0, 0.0], b, 0.1)]).unwrap().around([0.0; 2]).yaw_rad();
        assert!((yaw_rad.abs() - std::f64::consts::PI).abs() < 1e-9, "{yaw_rad}");
    }

    proptest! {
        #[test]
        fn a_place_is_found_back(x in -10.0..70.0_f64, y in -8.0..8.0_f64) {
            let bent = corridor();
            let back = bent.apply_inverse(bent.apply([x, y])).unwrap();
            prop_assert!(libm::hypot(back[0] - x, back[1] - y) < 1e-5);
            let rigid = bent.around([x, y]).apply([x, y]);
            let own = bent.apply([x, y]);
            prop_assert!(libm::hypot(rigid[0] - own[0], rigid[1] - own[1]) < 1e-9);
        }
    }
}
