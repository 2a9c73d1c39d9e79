//! The overlap in plan of a triangle with another below it, within a range of heights.

use crate::plane::Triangle;
use geometry::{Plane, Ring, ring_area_doubled};

/// The part of `lower` in plan over which `upper` lies at least `least` and at most `most` tenths of a millimetre higher: a convex
/// ring, counter-clockwise; `None` if it has no area.
pub(crate) fn overlap(lower: &Triangle, upper: &Triangle, least: f64, most: f64) -> Option<Ring> {
    let plan = |v: [i32; 3]| [f64::from(v[0]), f64::from(v[1])];
    let mut ring: Vec<[f64; 2]> = lower.iter().map(|v| plan(*v)).collect();
    for k in 0..3 {
        let (a, b) = (plan(upper[k]), plan(upper[(k + 1) % 3]));
        ring = clipped(&ring, |p| (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]));
    }
    let (below, above) = (Plane::of(lower), Plane::of(upper));
    ring = clipped(&ring, |p| above.z(p) - below.z(p) - least);
    ring = clipped(&ring, |p| most - (above.z(p) - below.z(p)));
    let mut ring: Ring = ring.iter().map(|p| p.map(|c| c.round() as i32)).collect();
    ring.dedup();
    while ring.len() > 1 && ring.first() == ring.last() {
        ring.pop();
    }
    (ring.len() >= 3 && ring_area_doubled(&ring) > 0).then_some(ring)
}

/// The part of a convex ring where a function that is linear in the plane is not negative.
fn clipped(ring: &[[f64; 2]], side: impl Fn([f64; 2]) -> f64) -> Vec<[f64; 2]> {
    let mut kept = Vec::with_capacity(ring.len() + 1);
    for (k, &p) in ring.iter().enumerate() {
        let q = ring[(k + 1) % ring.len()];
        let (of_p, of_q) = (side(p), side(q));
        if of_p >= 0.0 {
            kept.push(p);
        }
        if (of_p >= 0.0) != (of_q >= 0.0) {
            let share = of_p / (of_p - of_q);
            kept.push([0, 1].map(|i| p[i] + (q[i] - p[i]) * share));
        }
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    const LOWER: Triangle = [[0, 0, 0], [10_000, 0, 0], [0, 10_000, 0]];

    #[test]
    fn a_triangle_at_another_height_or_beside_does_not_lie_over() {
        let at = |x: i32, z: i32| LOWER.map(|v| [v[0] + x, v[1], v[2] + z]);
        assert_eq!(overlap(&LOWER, &at(0, 100), 2.0, 200.0).map(|r| ring_area_doubled(&r)), Some(100_000_000));
        assert_eq!(overlap(&LOWER, &at(5_000, 100), 2.0, 200.0).map(|r| ring_area_doubled(&r)), Some(25_000_000));
        assert_eq!(overlap(&LOWER, &at(0, 201), 2.0, 200.0), None);
        assert_eq!(overlap(&LOWER, &at(0, 1), 2.0, 200.0), None);
        assert_eq!(overlap(&LOWER, &at(10_000, 100), 2.0, 200.0), None);
    }

    #[test]
    fn of_planes_that_cross_only_the_upper_side_counts() {
        let tilted = [[0, 0, -100], [10_000, 0, 100], [0, 10_000, -100]];
        let ring = overlap(&LOWER, &tilted, 0.0, 200.0).unwrap();
        assert!(ring.iter().all(|p| p[0] >= 5_000), "{ring:?}");
        assert_eq!(ring_area_doubled(&ring), 25_000_000);
    }
}
