//! Regions that need no overlay: most sections and plans of building elements are a few rings that meet neither themselves nor
//! each other.

use crate::polygon::{Bounds, MultiPolygon, Point, Polygon, Ring, ring_area_doubled};

/// Most corners that are looked at: edges are compared with each other.
const MAX_CORNERS: usize = 32;

/// Farther out sums of products of differences would not fit 64 bits.
const MAX_COORDINATE: u32 = 1 << 29;

/// The region that the rings enclose, if none of them meets itself and the bounds of any two lie apart; `None` if it takes an
/// overlay to tell. By every fill rule it is what the overlay gives, in the same order: polygons by their leftmost corners, the
/// corners from the one before that, and none on straight lines.
pub(crate) fn region_of_simple_rings(rings: &[Ring]) -> Option<MultiPolygon> {
    if rings.iter().map(Vec::len).sum::<usize>() > MAX_CORNERS {
        return None;
    }
    let mut polygons: Vec<Polygon> = Vec::with_capacity(rings.len());
    let mut bounds: Vec<Bounds> = Vec::with_capacity(rings.len());
    for ring in rings {
        let own = Bounds::of(ring.iter().copied())?;
        if bounds.iter().any(|other| other.meets(&own)) {
            return None;
        }
        bounds.push(own);
        polygons.push(Polygon { exterior: exterior_of(ring)?, holes: Vec::new() });
    }
    polygons.sort_unstable_by_key(|p| p.exterior[1]);
    Some(MultiPolygon(polygons))
}

/// The ring as an exterior, if it meets itself nowhere.
fn exterior_of(ring: &[Point]) -> Option<Ring> {
    if ring.iter().flatten().any(|c| c.unsigned_abs() > MAX_COORDINATE) {
        return None;
    }
    let mut corners: Ring = Vec::with_capacity(ring.len());
    let n = ring.len();
    for k in 0..n {
        let [before, at, after] = [ring[(k + n - 1) % n], ring[k], ring[(k + 1) % n]];
        if before == at {
            return None;
        }
        match turn(before, at, after) {
            0 if ahead(before, at, after) => {}
            0 => return None,
            _ => corners.push(at),
        }
    }
    let n = corners.len();
    let edge = |k: usize| [corners[k], corners[(k + 1) % n]];
    let is_simple =
        n >= 3 && (0..n).all(|a| (a + 2..n).filter(|b| (b + 1) % n != a).all(|b| are_apart(edge(a), edge(b))));
    if !is_simple {
        return None;
    }
    if ring_area_doubled(&corners) < 0 {
        corners.reverse();
    }
    let leftmost = (0..n).min_by_key(|&k| corners[k])?;
    corners.rotate_left((leftmost + n - 1) % n);
    Some(corners)
}

/// Positive where the way from `a` over `b` to `c` turns left, 0 where it goes straight.
fn turn(a: Point, b: Point, c: Point) -> i64 {
    let to = |p: Point, k: usize| i64::from(p[k]) - i64::from(a[k]);
    (to(b, 0) * to(c, 1) - to(b, 1) * to(c, 0)).signum()
}

/// True if the straight way from `a` over `b` to `c` does not come back.
fn ahead(a: Point, b: Point, c: Point) -> bool {
    let is_between = |k: usize| (a[k] <= b[k] && b[k] <= c[k]) || (c[k] <= b[k] && b[k] <= a[k]);
    b != c && is_between(0) && is_between(1)
}

/// True if the edges share no point.
fn are_apart(a: [Point; 2], b: [Point; 2]) -> bool {
    let is_beside = |[p, q]: [Point; 2], [r, s]: [Point; 2]| turn(p, q, r) * turn(p, q, s) > 0;
    let may_meet = Bounds::of(a).zip(Bounds::of(b)).is_some_and(|(a, b)| a.meets(&b));
    !may_meet || is_beside(a, b) || is_beside(b, a)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::overlay::{FillRule, overlaid};
    use proptest::prelude::*;

    /// Rings of few corners that often meet, touch and go back, at several places.
    fn rings() -> impl Strategy<Value = Vec<Ring>> {
        let ring = (0..4i32, 0..4i32, prop::collection::vec((0..7i32, 0..7i32), 3..9));
        let at =
            |(x, y, corners): (i32, i32, Vec<(i32, i32)>)| corners.iter().map(|c| [x * 8 + c.0, y * 8 + c.1]).collect();
        prop::collection::vec(ring.prop_map(at), 1..4)
    }

    /// Rings around the middle, which meet themselves nowhere.
    fn stars() -> impl Strategy<Value = Vec<Ring>> {
        let star = (0..3i32, 0..3i32, any::<bool>(), prop::collection::vec(1..1_000i32, 3..10));
        let at = |(x, y, turned, reaches): (i32, i32, bool, Vec<i32>)| {
            let n = reaches.len() as f64;
            let corner = |(k, reach): (usize, &i32)| {
                let angle = std::f64::consts::TAU * k as f64 / n;
                let middle = [x, y].map(|c| f64::from(c * 2_001));
                [
                    (middle[0] + f64::from(*reach) * libm::cos(angle)) as i32,
                    (middle[1] + f64::from(*reach) * libm::sin(angle)) as i32,
                ]
            };
            let mut ring: Ring = reaches.iter().enumerate().map(corner).collect();
            if turned {
                ring.reverse();
            }
            ring
        };
        prop::collection::vec(star.prop_map(at), 1..4)
    }

    #[test]
    fn walls_and_corners_need_no_overlay() {
        let wall = vec![[0, 0], [0, 20], [40, 20], [60, 20], [60, 0], [20, 0]];
        let corner = vec![[100, 0], [160, 0], [160, 60], [140, 60], [140, 20], [100, 20]];
        let region = region_of_simple_rings(&[corner, wall]).unwrap();
        let exteriors: Vec<&Ring> = region.rings().collect();
        let of_corner = [[100, 20], [100, 0], [160, 0], [160, 60], [140, 60], [140, 20]];
        assert_eq!(exteriors, [&[[0, 20], [0, 0], [60, 0], [60, 20]][..], &of_corner[..]]);
    }

    #[test]
    fn what_meets_itself_or_another_does() {
        let bow = vec![[0, 0], [10, 10], [10, 0], [0, 10]];
        let touches = vec![[0, 0], [10, 0], [10, 10], [5, 0], [0, 10]];
        let spike = vec![[0, 0], [10, 0], [20, 0], [10, 0], [10, 10]];
        for ring in [bow, touches, spike] {
            assert_eq!(region_of_simple_rings(std::slice::from_ref(&ring)), None, "{ring:?}");
        }
        let square = |x: i32| vec![[x, 0], [x + 10, 0], [x + 10, 10], [x, 10]];
        assert_eq!(region_of_simple_rings(&[square(0), square(10)]), None);
        assert!(region_of_simple_rings(&[square(0), square(11)]).is_some());
    }

    proptest! {
        #[test]
        fn regions_are_those_of_the_overlay(rings in prop_oneof![rings(), stars()]) {
            if let Some(region) = region_of_simple_rings(&rings) {
                prop_assert_eq!(&region, &overlaid(&rings, FillRule::NonZero));
                prop_assert_eq!(&region, &overlaid(&rings, FillRule::EvenOdd));
            }
        }
    }
}
