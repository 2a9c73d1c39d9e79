//! Splits convex faces into triangle fans without degenerate triangles, for OBJ readers.

/// A triangle that is nowhere wider has no area: two hundredths of a millimetre, in the units of the meshes.
const FLAT: f64 = 2.0;

/// A convex face as one or more faces that readers can fan from their first corners without a triangle that has no area: on a
/// straight run of corners such a triangle would have its longest edge in common with one of the next face, and the mesh would
/// no longer be closed.
pub(super) fn fans(face: &[u32], corner: impl Fn(u32) -> [i64; 3]) -> Vec<Vec<u32>> {
    let width = |a: u32, b: u32, c: u32| width([a, b, c].map(&corner));
    let n = face.len();
    let thinnest = |start: usize| {
        let at = |k: usize| face[(start + k) % n];
        (1..n - 1).map(|k| width(at(0), at(k), at(k + 1))).fold(f64::INFINITY, f64::min)
    };
    // Of equal ones the first.
    let widest = (0..n).rev().max_by(|&a, &b| thinnest(a).total_cmp(&thinnest(b))).unwrap_or(0);
    if thinnest(widest) > FLAT {
        return vec![face[widest..].iter().chain(&face[..widest]).copied().collect()];
    }
    // No fan will do: corners are cut off one by one, the narrowest first, so that what is left keeps its area.
    let mut left = face.to_vec();
    let mut triangles = Vec::with_capacity(n - 2);
    while left.len() > 3 {
        let n = left.len();
        let cut = |k: usize| [left[(k + n - 1) % n], left[k], left[(k + 1) % n]];
        let width_at = |k: usize| {
            let [a, b, c] = cut(k);
            width(a, b, c)
        };
        let narrowest = (0..n).filter(|k| width_at(*k) > FLAT).min_by(|a, b| width_at(*a).total_cmp(&width_at(*b)));
        // A face without area has nothing to cut off that has one.
        let k = narrowest.unwrap_or(0);
        triangles.push(cut(k).to_vec());
        left.remove(k);
    }
    triangles.push(left);
    triangles
}

/// The least height of a triangle.
fn width([a, b, c]: [[i64; 3]; 3]) -> f64 {
    let between = |p: [i64; 3], q: [i64; 3]| [0, 1, 2].map(|k| (q[k] - p[k]) as f64);
    let length = |v: [f64; 3]| v.iter().map(|c| c * c).sum::<f64>().sqrt();
    let [u, v, w] = [between(a, b), between(a, c), between(b, c)];
    let normal = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    let longest = [u, v, w].map(length).into_iter().fold(0.0, f64::max);
    if longest == 0.0 { 0.0 } else { length(normal) / longest }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// The face through points in a plane, and its fans as triangles.
    fn triangles(points: &[[i64; 2]]) -> Vec<[[i64; 3]; 3]> {
        let face: Vec<u32> = (0..points.len() as u32).collect();
        let corner = |k: u32| [points[k as usize][0], points[k as usize][1], 7];
        let fan = |f: Vec<u32>| (1..f.len() - 1).map(move |k| [f[0], f[k], f[k + 1]]).collect::<Vec<_>>();
        fans(&face, corner).into_iter().flat_map(fan).map(|t| t.map(corner)).collect()
    }

    #[test]
    fn a_face_without_straight_runs_stays_one() {
        assert_eq!(
            fans(&[4, 5, 6, 7], |k| [[0, 0, 0], [900, 0, 0], [900, 900, 0], [0, 900, 0]][k as usize - 4]).len(),
            1
        );
    }

    #[test]
    fn a_face_begins_where_no_triangle_is_without_area() {
        let corners = [[0, 0, 0], [100, 0, 0], [200, 0, 0], [200, 200, 0]];
        let found = fans(&[0, 1, 2, 3], |k| corners[k as usize]);
        assert!(found.len() == 1 && [1, 3].contains(&found[0][0]), "{found:?}");
    }

    proptest! {
        #[test]
        fn no_triangle_of_a_face_is_without_area_however_many_corners_lie_on_its_sides(on_sides in prop::array::uniform4(0..6_i64)) {
            let [a, b, c, d] = [[0, 0], [9_000, 100], [8_000, 7_000], [-500, 6_000]];
            let side = |p: [i64; 2], q: [i64; 2], n: i64| {
                // Corners on a line but for rounding.
                (0..=n).map(move |k| [0, 1].map(|i| p[i] + (q[i] - p[i]) * k / (n + 1)))
            };
            let sides = [(a, b), (b, c), (c, d), (d, a)].into_iter().zip(on_sides);
            let points: Vec<[i64; 2]> = sides.flat_map(|((p, q), n)| side(p, q, n)).collect();
            let found = triangles(&points);
            prop_assert_eq!(found.len(), points.len() - 2);
            prop_assert!(found.iter().all(|t| width(*t) > FLAT));
            let area = |[p, q, r]: [[i64; 3]; 3]| (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]);
            let whole: i64 = (1..points.len() - 1).map(|k| area([points[0], points[k], points[k + 1]].map(|[x, y]| [x, y, 7]))).sum();
            prop_assert_eq!(found.iter().map(|t| area(*t)).sum::<i64>(), whole);
        }
    }
}
