//! Squared distances in space of points and segments from triangles. Triangles without area are their sides.

/// A place in space.
pub(crate) type Vec3 = [f64; 3];

pub(crate) fn difference(a: Vec3, b: Vec3) -> Vec3 {
    [0, 1, 2].map(|k| a[k] - b[k])
}

pub(crate) fn dot(a: Vec3, b: Vec3) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(crate) fn cross(a: Vec3, b: Vec3) -> Vec3 {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// `a + share * b`.
fn moved(a: Vec3, share: f64, b: Vec3) -> Vec3 {
    [0, 1, 2].map(|k| a[k] + share * b[k])
}

fn squared(a: Vec3) -> f64 {
    dot(a, a)
}

/// The sides of a triangle.
fn sides([a, b, c]: &[Vec3; 3]) -> [[Vec3; 2]; 3] {
    [[*a, *b], [*b, *c], [*c, *a]]
}

/// Squared distance of a point from a segment.
fn point_to_segment(p: Vec3, [a, b]: [Vec3; 2]) -> f64 {
    let (along, off) = (difference(b, a), difference(p, a));
    let length = squared(along);
    let share = if length > 0.0 { (dot(off, along) / length).clamp(0.0, 1.0) } else { 0.0 };
    squared(moved(off, -share, along))
}

/// Squared distance of a point from a triangle.
///
/// The least of the distances from its sides, and from its plane where the point lies above or below its inside.
pub(crate) fn point_to_triangle(p: Vec3, triangle: &[Vec3; 3]) -> f64 {
    let from_sides = sides(triangle).map(|side| point_to_segment(p, side));
    let nearest = from_sides[0].min(from_sides[1]).min(from_sides[2]);
    let normal = normal_of(triangle);
    if !is_over(p, triangle, normal) {
        return nearest;
    }
    let height = dot(difference(p, triangle[0]), normal);
    nearest.min(height * height / squared(normal))
}

fn normal_of([a, b, c]: &[Vec3; 3]) -> Vec3 {
    cross(difference(*b, *a), difference(*c, *a))
}

/// True if the plumb line of a point on the plane of a triangle meets the triangle.
fn is_over(p: Vec3, triangle: &[Vec3; 3], normal: Vec3) -> bool {
    let is_inward = |[a, b]: [Vec3; 2]| dot(cross(difference(b, a), difference(p, a)), normal) >= 0.0;
    squared(normal) > 0.0 && sides(triangle).into_iter().all(is_inward)
}

/// Squared distance of a segment from a triangle; 0 if it meets it.
///
/// Where they do not meet, one of the nearest places is on a side of the triangle, or is an end of the segment.
pub(crate) fn segment_to_triangle(ends: [Vec3; 2], triangle: &[Vec3; 3]) -> f64 {
    if crosses(ends, triangle) {
        return 0.0;
    }
    let from_ends = ends.map(|end| point_to_triangle(end, triangle));
    let from_sides = sides(triangle).map(|side| segment_to_segment(ends, side));
    from_sides.into_iter().chain(from_ends).fold(f64::INFINITY, f64::min)
}

/// True if a segment goes through the inside of a triangle from one side of its plane to the other.
fn crosses([from, to]: [Vec3; 2], triangle: &[Vec3; 3]) -> bool {
    let normal = normal_of(triangle);
    let [low, high] = [from, to].map(|end| dot(difference(end, triangle[0]), normal));
    // Equal heights: the segment is parallel to the plane, and its ends and the sides tell.
    if low * high > 0.0 || low == high {
        return false;
    }
    is_over(moved(from, low / (low - high), difference(to, from)), triangle, normal)
}

/// Squared distance of two segments.
///
/// # Source
/// Ericson, "Real-Time Collision Detection", 2005, section 5.1.9. Ends are looked at for themselves: of segments that are nearly
/// parallel the nearest places in their insides are not exact.
fn segment_to_segment(p: [Vec3; 2], q: [Vec3; 2]) -> f64 {
    let from_ends =
        [point_to_segment(p[0], q), point_to_segment(p[1], q), point_to_segment(q[0], p), point_to_segment(q[1], p)];
    let nearest = from_ends.into_iter().fold(f64::INFINITY, f64::min);
    let (u, v, between) = (difference(p[1], p[0]), difference(q[1], q[0]), difference(p[0], q[0]));
    let (uu, uv, vv, ub, vb) = (squared(u), dot(u, v), squared(v), dot(u, between), dot(v, between));
    let denominator = uu * vv - uv * uv;
    if denominator <= 0.0 {
        return nearest;
    }
    let s = ((uv * vb - ub * vv) / denominator).clamp(0.0, 1.0);
    let t = ((uv * s + vb) / vv).clamp(0.0, 1.0);
    let s = ((uv * t - ub) / uu).clamp(0.0, 1.0);
    nearest.min(squared(difference(moved(p[0], s, u), moved(q[0], t, v))))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const TRIANGLE: [Vec3; 3] = [[0.0, 0.0, 0.0], [10.0, 0.0, 0.0], [0.0, 10.0, 0.0]];

    #[test]
    fn the_nearest_place_is_a_corner_a_side_or_the_inside() {
        for (p, squared) in [
            ([2.0, 2.0, 3.0], 9.0),
            ([-3.0, -4.0, 0.0], 25.0),
            ([5.0, -2.0, 1.0], 5.0),
            ([8.0, 8.0, 0.0], 18.0),
            ([1.0, 1.0, 0.0], 0.0),
        ] {
            assert!((point_to_triangle(p, &TRIANGLE) - squared).abs() < 1e-9, "{p:?}");
        }
        let line = [[0.0, 0.0, 0.0], [10.0, 0.0, 0.0], [4.0, 0.0, 0.0]];
        assert_eq!(point_to_triangle([5.0, 3.0, 0.0], &line), 9.0);
        assert_eq!(point_to_triangle([5.0, 3.0, 0.0], &[[5.0, 0.0, 0.0]; 3]), 9.0);
    }

    #[test]
    fn a_segment_through_a_triangle_has_no_distance_from_it_and_one_beside_it_has() {
        for (ends, squared) in [
            ([[2.0, 2.0, -5.0], [2.0, 2.0, 5.0]], 0.0),
            ([[2.0, 2.0, 3.0], [4.0, 4.0, 3.0]], 9.0),
            ([[-4.0, 5.0, -5.0], [-4.0, 5.0, 5.0]], 16.0),
            ([[20.0, 2.0, 0.0], [14.0, 2.0, 0.0]], 20.0),
            ([[-9.0, 3.0, 2.0], [20.0, 3.0, 2.0]], 4.0),
            ([[-1.0, 3.0, 0.0], [20.0, 3.0, 0.0]], 0.0),
        ] {
            assert!((segment_to_triangle(ends, &TRIANGLE) - squared).abs() < 1e-9, "{ends:?}");
        }
    }

    fn place() -> impl Strategy<Value = Vec3> {
        proptest::array::uniform3(-50i32..50).prop_map(|p| p.map(f64::from))
    }

    fn distance_of_samples(ends: [Vec3; 2], triangle: &[Vec3; 3], n: usize) -> f64 {
        let share = |k: usize| k as f64 / n as f64;
        let [a, b, c] = *triangle;
        let mut least = f64::INFINITY;
        for i in 0..=n {
            let at = moved(ends[0], share(i), difference(ends[1], ends[0]));
            for j in 0..=n {
                for k in 0..=n - j {
                    let on = moved(moved(a, share(j), difference(b, a)), share(k), difference(c, a));
                    least = least.min(squared(difference(at, on)));
                }
            }
        }
        least.sqrt()
    }

    proptest! {
        #[test]
        fn distances_are_those_of_the_nearest_of_many_places(
            ends in [place(), place()],
            triangle in [place(), place(), place()],
        ) {
            const N: usize = 24;
            let longest = sides(&triangle).map(|[a, b]| squared(difference(a, b)).sqrt()).into_iter().fold(0.0, f64::max);
            let length = squared(difference(ends[0], ends[1])).sqrt();
            let found = segment_to_triangle(ends, &triangle).sqrt();
            let sampled = distance_of_samples(ends, &triangle, N);
            // A sample is as near to any place as half the spacing of samples on both.
            let spacing = (longest + length / 2.0) / N as f64;
            prop_assert!(found <= sampled + 1e-6 && sampled <= found + spacing + 1e-6, "{found} {sampled}");
            let point = point_to_triangle(ends[0], &triangle).sqrt();
            let sampled = distance_of_samples([ends[0]; 2], &triangle, N);
            prop_assert!(point <= sampled + 1e-6 && sampled <= point + longest / N as f64 + 1e-6, "{point} {sampled}");
            prop_assert!(found <= point + 1e-6);
        }
    }
}
