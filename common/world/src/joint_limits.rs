//! Joint limits of door leaves: motion until the first collision with static elements.

use crate::static_elements::StaticElement;
use convex::Hull;

/// Tolerated penetration of leaves: rounding and gaskets.
const TOUCH_M: f64 = 0.004;

/// Convex pieces with which leaves can collide.
pub(crate) struct Obstacles {
    found: Vec<Obstacle>,
}

struct Obstacle {
    /// Index of the static element.
    owner: usize,
    bounds_m: [[f64; 3]; 2],
    hull: Hull,
}

/// A convex plan between two heights, in `map`.
#[derive(Debug, Clone)]
pub(crate) struct Prism {
    pub(crate) plan_m: Vec<[f64; 2]>,
    pub(crate) z_m: [f64; 2],
}

impl Obstacles {
    pub(crate) fn of(statics: &[StaticElement]) -> Self {
        let of = |(owner, s): (usize, &StaticElement)| {
            let hulls = s.pieces.iter().map(move |p| p.shape.hull());
            hulls.map(move |hull| Obstacle { owner, bounds_m: hull.bounds_m(), hull }).collect::<Vec<_>>()
        };
        Self { found: statics.iter().enumerate().flat_map(of).collect() }
    }

    /// Those that reach into an upright box.
    pub(crate) fn near(&self, bounds_m: [[f64; 3]; 2]) -> NearbyObstacles<'_> {
        let meets =
            |o: &&Obstacle| (0..3).all(|k| o.bounds_m[0][k] < bounds_m[1][k] && bounds_m[0][k] < o.bounds_m[1][k]);
        NearbyObstacles { found: self.found.iter().filter(meets).collect() }
    }
}

/// Obstacles near a door.
pub(crate) struct NearbyObstacles<'a> {
    found: Vec<&'a Obstacle>,
}

impl NearbyObstacles<'_> {
    /// Place of the first static that the prism cuts into by more than [`TOUCH_M`].
    pub(crate) fn meets(&self, prism: &Prism) -> Option<usize> {
        let [low, high] = [prism.z_m[0] + TOUCH_M, prism.z_m[1] - TOUCH_M];
        let hit = |o: &&&Obstacle| {
            o.bounds_m[0][2] < high
                && low < o.bounds_m[1][2]
                && depth_m(&prism.plan_m, &o.hull.plan_between(low, high)) > TOUCH_M
        };
        self.found.iter().find(hit).map(|o| o.owner)
    }

    /// Top of the highest obstacle under a plan between two heights; the lower height if there is none.
    pub(crate) fn top_under(&self, plan_m: &[[f64; 2]], [low, high]: [f64; 2]) -> f64 {
        let lies_under = |o: &&&Obstacle| {
            let top = o.bounds_m[1][2];
            low < top && top <= high && depth_m(plan_m, &o.hull.plan_between(low, high)) > TOUCH_M
        };
        self.found.iter().filter(lies_under).map(|o| o.bounds_m[1][2]).fold(low, f64::max)
    }

    /// Range of a motion from 0 towards `goal` in steps, and the index of the obstacle that ends it. `at` gives the leaf at
    /// a joint value.
    pub(crate) fn reach(&self, goal: f64, step: f64, at: impl Fn(f64) -> Prism) -> (f64, Option<usize>) {
        let n = (goal.abs() / step).ceil().max(1.0) as usize;
        let mut last = 0.0;
        for k in 0..=n {
            let q = goal * k as f64 / n as f64;
            if let Some(owner) = self.meets(&at(q)) {
                return (last, Some(owner));
            }
            last = q;
        }
        (goal, None)
    }
}

/// Penetration depth of two convex polygons; 0 or less if they are disjoint.
fn depth_m(a: &[[f64; 2]], b: &[[f64; 2]]) -> f64 {
    if a.len() < 3 || b.len() < 3 {
        return 0.0;
    }
    let normals = |p: &[[f64; 2]]| -> Vec<[f64; 2]> {
        let edge = |k: usize| {
            let (from, to) = (p[k], p[(k + 1) % p.len()]);
            let (dx, dy) = (to[0] - from[0], to[1] - from[1]);
            let length = libm::hypot(dx, dy);
            (length > 1e-9).then(|| [dy / length, -dx / length])
        };
        (0..p.len()).filter_map(edge).collect()
    };
    let range = |p: &[[f64; 2]], n: [f64; 2]| {
        let at = p.iter().map(|q| q[0] * n[0] + q[1] * n[1]);
        at.fold([f64::INFINITY, f64::NEG_INFINITY], |[lo, hi], x| [lo.min(x), hi.max(x)])
    };
    let overlap = |n: [f64; 2]| {
        let (a, b) = (range(a, n), range(b, n));
        (a[1] - b[0]).min(b[1] - a[0])
    };
    normals(a).into_iter().chain(normals(b)).map(overlap).fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;
    use grid::Class;

    #[test]
    fn polygons_that_touch_cut_by_nothing() {
        let square = |x: f64| [[x, 0.0], [x + 1.0, 0.0], [x + 1.0, 1.0], [x, 1.0]];
        assert!((depth_m(&square(0.0), &square(0.75)) - 0.25).abs() < 1e-12);
        assert!(depth_m(&square(0.0), &square(1.0)).abs() < 1e-12);
        assert!(depth_m(&square(0.0), &square(3.0)) < 0.0);
    }

    #[test]
    fn a_motion_ends_before_what_stands() {
        let wall = StaticElement::plate("wall".into(), Class::Wall, 0, [3.0, 0.5, 1.0], [1.0, 0.0], [1.0, 1.0, 2.0]);
        let obstacles = Obstacles::of(&[wall]);
        let near = obstacles.near([[0.0; 3], [5.0, 1.0, 2.0]]);
        let at = |q: f64| Prism { plan_m: vec![[q, 0.0], [q + 1.0, 0.0], [q + 1.0, 1.0], [q, 1.0]], z_m: [0.1, 1.9] };
        let (end, stopped_by) = near.reach(3.0, 0.01, at);
        assert!((1.48..1.51).contains(&end) && stopped_by == Some(0), "{end}");
        assert_eq!(near.reach(1.0, 0.01, at), (1.0, None));
    }
}
