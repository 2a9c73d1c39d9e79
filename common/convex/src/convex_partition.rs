//! Partition of polygons into few convex polygons; the only module that uses i_triangle.

use geometry::OrientedBox;
use geometry::{MultiPolygon, Point, Polygon, Ring, edges, ring_area_doubled};
use i_triangle::i_overlay::i_float::int::point::IntPoint;
use i_triangle::i_overlay::i_shape::int::shape::IntShape;
use i_triangle::int::triangulatable::IntTriangulatable;

/// Corners within this distance of a straight line are on it: 0.2 mm, the rounding error of rotated walls.
const STRAIGHT_TOLERANCE: f64 = 2.0;

/// Coordinates within this distance are equal: 0.3 mm.
const SAME_COORDINATE: i32 = 3;

/// Convex polygons, counter-clockwise, whose union is the region; slivers narrower than half a millimetre are left out.
///
/// Regions with right angles only, at any yaw, become rectangles.
pub fn convex_partition(region: &MultiPolygon) -> Vec<Ring> {
    region.0.iter().flat_map(partition_one).filter(|ring| !is_sliver(ring)).collect()
}

fn partition_one(polygon: &Polygon) -> Vec<Ring> {
    let rings: Vec<Ring> = polygon.rings().map(|r| straightened(r)).filter(|r| r.len() >= 3).collect();
    match rings.as_slice() {
        [] => Vec::new(),
        [only] if is_convex(only) => rings,
        _ => rectangles(&rings).unwrap_or_else(|| convex_polygons(rings)),
    }
}

/// The ring without corners that lie on the line between their neighbours.
fn straightened(ring: &[Point]) -> Ring {
    let mut ring = ring.to_vec();
    let mut k = 0;
    while ring.len() > 3 && k < ring.len() {
        let n = ring.len();
        let [a, b, c] = [ring[(k + n - 1) % n], ring[k], ring[(k + 1) % n]];
        if distance_to_line(b, a, c) <= STRAIGHT_TOLERANCE {
            ring.remove(k);
            k = k.saturating_sub(1);
        } else {
            k += 1;
        }
    }
    ring
}

/// Distance of a point from the line through two others, or from one of them if they are equal.
fn distance_to_line(p: Point, a: Point, b: Point) -> f64 {
    let [ab, ap] = [difference(a, b), difference(a, p)];
    let length = libm::hypot(ab[0], ab[1]);
    if length == 0.0 { libm::hypot(ap[0], ap[1]) } else { (ab[0] * ap[1] - ab[1] * ap[0]).abs() / length }
}

fn difference(a: Point, b: Point) -> [f64; 2] {
    [0, 1].map(|k| f64::from(b[k]) - f64::from(a[k]))
}

/// True if a counter-clockwise ring has no corner that points inward by more than rounding.
fn is_convex(ring: &[Point]) -> bool {
    let n = ring.len();
    (0..n).all(|k| {
        let [a, b, c] = [ring[k], ring[(k + 1) % n], ring[(k + 2) % n]];
        let (ab, bc) = (difference(a, b), difference(b, c));
        ab[0] * bc[1] - ab[1] * bc[0] >= 0.0 || distance_to_line(b, a, c) <= STRAIGHT_TOLERANCE
    })
}

/// True if a ring is nowhere wider than half a millimetre.
fn is_sliver(ring: &[Point]) -> bool {
    OrientedBox::smallest_around(ring).is_none_or(|b| b.half[0].min(b.half[1]) <= 2.5)
}

/// Rectangles, if all edges run along one direction or across it.
fn rectangles(rings: &[Ring]) -> Option<Vec<Ring>> {
    let longest = rings.iter().flat_map(|r| edges(r)).map(|(a, b)| difference(a, b));
    let longest = longest.max_by(|a, b| libm::hypot(a[0], a[1]).total_cmp(&libm::hypot(b[0], b[1])))?;
    let length = libm::hypot(longest[0], longest[1]);
    let axis = longest.map(|c| c / length);
    let along = |v: [f64; 2]| [axis[0] * v[0] + axis[1] * v[1], axis[0] * v[1] - axis[1] * v[0]];
    let is_right = |(a, b)| along(difference(a, b)).iter().any(|c| c.abs() <= f64::from(SAME_COORDINATE));
    if !rings.iter().flat_map(|r| edges(r)).all(is_right) {
        return None;
    }
    let origin = rings[0][0];
    let local = |p: Point| along(difference(origin, p)).map(|c| c.round() as i32);
    let mut turned: Vec<Ring> = rings.iter().map(|r| r.iter().map(|p| local(*p)).collect()).collect();
    snap(&mut turned);
    let flipped: Vec<Ring> = turned.iter().map(|r| r.iter().map(|p| [p[1], p[0]]).collect()).collect();
    let (by_u, by_v) = (strips(&turned)?, strips(&flipped)?);
    let found = if by_u.len() <= by_v.len() {
        by_u
    } else {
        by_v.into_iter().map(|[u0, v0, u1, v1]| [v0, u0, v1, u1]).collect()
    };
    let back = |u: i32, v: i32| {
        let [u, v] = [f64::from(u), f64::from(v)];
        let turned = [axis[0] * u - axis[1] * v, axis[1] * u + axis[0] * v];
        [0, 1].map(|k| origin[k] + turned[k].round() as i32)
    };
    let ring = |[u0, v0, u1, v1]: [i32; 4]| vec![back(u0, v0), back(u1, v0), back(u1, v1), back(u0, v1)];
    Some(found.into_iter().map(ring).collect())
}

/// Merges coordinates that differ only by rounding.
fn snap(rings: &mut [Ring]) {
    for axis in 0..2 {
        let mut values: Vec<i32> = rings.iter().flatten().map(|p| p[axis]).collect();
        values.sort_unstable();
        values.dedup();
        let mut distinct = values.clone();
        distinct.dedup_by(|next, distinct| *next - *distinct <= SAME_COORDINATE);
        for point in rings.iter_mut().flatten() {
            let at = distinct.partition_point(|v| *v <= point[axis]);
            point[axis] = distinct[at - 1];
        }
    }
}

/// Rectangles [u0, v0, u1, v1] of a region whose edges are parallel to the axes: strips between neighbouring corner
/// coordinates, joined where intervals continue. `None` if the rings do not close any strip evenly.
fn strips(rings: &[Ring]) -> Option<Vec<[i32; 4]>> {
    let mut us: Vec<i32> = rings.iter().flatten().map(|p| p[0]).collect();
    us.sort_unstable();
    us.dedup();
    let mut open: Vec<[i32; 4]> = Vec::new();
    let mut done = Vec::new();
    for pair in us.windows(2) {
        let [u0, u1] = [pair[0], pair[1]];
        let level = rings.iter().flat_map(|r| edges(r)).filter(|(a, b)| a[0].min(b[0]) <= u0 && u1 <= a[0].max(b[0]));
        let mut vs: Vec<i32> = level.map(|(a, _)| a[1]).collect();
        vs.sort_unstable();
        if !vs.len().is_multiple_of(2) {
            return None;
        }
        let mut now = Vec::new();
        for interval in vs.chunks(2).filter(|i| i[0] < i[1]) {
            let goes_on = open.iter().position(|r| r[2] == u0 && r[1] == interval[0] && r[3] == interval[1]);
            let start = goes_on.map_or(u0, |k| open.swap_remove(k)[0]);
            now.push([start, interval[0], u1, interval[1]]);
        }
        done.append(&mut open);
        open = now;
    }
    done.append(&mut open);
    Some(done)
}

fn convex_polygons(rings: Vec<Ring>) -> Vec<Ring> {
    let shape: IntShape<i32> =
        rings.into_iter().map(|r| r.into_iter().map(|p| IntPoint::new(p[0], p[1])).collect()).collect();
    let polygons = shape.triangulate().into_delaunay().to_convex_polygons();
    let ring = |contour: Vec<IntPoint<i32>>| straightened(&contour.iter().map(|p| [p.x, p.y]).collect::<Ring>());
    let mut found: Vec<Ring> = polygons.into_iter().map(ring).filter(|r| r.len() >= 3).collect();
    for ring in found.iter_mut().filter(|r| ring_area_doubled(r) < 0) {
        ring.reverse();
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::{FillRule, difference as without, union, union_of};
    use proptest::prelude::*;

    fn rectangle(x0: i32, y0: i32, x1: i32, y1: i32) -> Ring {
        vec![[x0, y0], [x1, y0], [x1, y1], [x0, y1]]
    }

    fn region(rings: &[Ring]) -> MultiPolygon {
        union(rings, FillRule::NonZero)
    }

    fn turned(ring: &Ring, yaw: f64) -> Ring {
        let (sin, cos) = (libm::sin(yaw), libm::cos(yaw));
        let turn = |p: &Point| {
            let [x, y] = p.map(f64::from);
            [(cos * x - sin * y).round() as i32, (sin * x + cos * y).round() as i32]
        };
        ring.iter().map(turn).collect()
    }

    #[test]
    fn an_l_is_two_rectangles_at_any_yaw() {
        for yaw in [0.0, 0.3, 1.0] {
            let arms = [rectangle(0, 0, 50_000, 3_000), rectangle(0, 0, 3_000, 40_000)].map(|r| turned(&r, yaw));
            let parts = convex_partition(&region(&arms));
            assert_eq!(parts.len(), 2, "{yaw}");
            assert!(parts.iter().all(|p| p.len() == 4));
        }
    }

    #[test]
    fn a_slab_with_a_stair_hole_is_four_rectangles() {
        let slab =
            without(&region(&[rectangle(0, 0, 90_000, 60_000)]), &region(&[rectangle(10_000, 10_000, 40_000, 20_000)]));
        assert_eq!(convex_partition(&slab).len(), 4);
    }

    #[test]
    fn a_trapezoid_stays_whole() {
        let ring = vec![[0, 0], [50_000, 0], [47_000, 3_000], [3_000, 3_000]];
        assert_eq!(convex_partition(&region(std::slice::from_ref(&ring))).len(), 1);
    }

    proptest! {
        #[test]
        fn parts_are_convex_and_cover_the_region(
            shapes in prop::collection::vec((0..40_000i32, 0..40_000i32, 500..30_000i32, 500..30_000i32, 0..4u32), 1..6)
        ) {
            let rings: Vec<Ring> = shapes
                .iter()
                .map(|&(x, y, w, h, yaw)| turned(&rectangle(x, y, x + w, y + h), f64::from(yaw) * 0.4))
                .collect();
            let whole = region(&rings);
            let parts = convex_partition(&whole);
            for part in &parts {
                prop_assert!(is_convex(part), "{:?}", part);
            }
            let parts: Vec<MultiPolygon> = parts.iter().map(|p| region(std::slice::from_ref(p))).collect();
            let sum: f64 = parts.iter().map(MultiPolygon::area_m2).sum();
            let around: f64 = whole.rings().flat_map(|r| edges(r)).map(|(a, b)| { let d = difference(a, b); libm::hypot(d[0], d[1]) }).sum();
            // Half a millimetre along every border.
            let off = 0.0005 * around / 10_000.0 + 1e-4;
            prop_assert!((sum - whole.area_m2()).abs() < off, "{} {}", sum, whole.area_m2());
            prop_assert!((union_of(&parts).area_m2() - whole.area_m2()).abs() < off);
        }
    }
}
