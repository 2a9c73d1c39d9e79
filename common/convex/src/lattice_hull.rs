//! Convex hulls of points on the lattice of files, by exact integers.

use std::collections::BTreeMap;

/// Points of the lattice per metre: hundredths of a millimetre, the resolution of files.
pub const LATTICE_PER_M: f64 = 1e5;

/// Half the thickness of a plate, in units of the lattice: 1 mm.
const HALF_PLATE: i64 = 100;

/// Thickness of the plate that stands for points in a plane, in metres.
pub const PLATE_M: f64 = 2.0 * HALF_PLATE as f64 / LATTICE_PER_M;

/// The convex hull of points on the lattice.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LatticeHull {
    /// Corners; some may lie on straight edges or in plane faces.
    pub vertices: Vec<[i64; 3]>,
    /// Triangles that have an area, counter-clockwise from outside; each edge is used once in each direction.
    pub triangles: Vec<[u32; 3]>,
}

/// The convex hull of points whose distances are below 2^40 units; `None` if they lie in a plane.
///
/// Signs of volumes are exact, and a face is seen from a point only if the point lies truly before it: the faces that are
/// seen are then one disk, and none of the triangles that replace them is without an area.
///
/// # Source
/// Barber, Dobkin and Huhdanpaa, "The Quickhull Algorithm for Convex Hulls", ACM TOMS 22, 1996.
pub fn lattice_hull(points: &[[i64; 3]]) -> Option<LatticeHull> {
    let mut points = points.to_vec();
    points.sort_unstable();
    points.dedup();
    let mut growing = GrowingHull::of(&points)?;
    while let Some((face, point)) = growing.next_point() {
        growing.add(face, point);
    }
    Some(growing.finish())
}

/// The hull of points that lie in a plane, on a line, or nowhere else, as a plate 2 mm thick; `None` without points.
///
/// Corners of points that are multiples of `step` units are multiples, too.
pub fn lattice_plate(points: &[[i64; 3]], step: i64) -> Option<LatticeHull> {
    let half = (HALF_PLATE + step - 1) / step * step;
    let offset = |bits: usize| [0, 1, 2].map(|k| if bits >> k & 1 == 1 { half } else { -half });
    let around = |p: &[i64; 3]| {
        let p = *p;
        (0..8).map(move |bits| [0, 1, 2].map(|k| p[k] + offset(bits)[k]))
    };
    lattice_hull(&points.iter().flat_map(around).collect::<Vec<_>>())
}

/// Six times the volume of a tetrahedron; positive if the last point lies before the triangle of the others.
pub(crate) fn before([a, b, c]: [[i64; 3]; 3], p: [i64; 3]) -> i128 {
    let n = normal([a, b, c]);
    let d = side(a, p);
    n[0] * d[0] + n[1] * d[1] + n[2] * d[2]
}

/// The normal of a triangle, twice its area long.
fn normal([a, b, c]: [[i64; 3]; 3]) -> [i128; 3] {
    let (u, v) = (side(a, b), side(a, c));
    [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]
}

fn side(from: [i64; 3], to: [i64; 3]) -> [i128; 3] {
    [0, 1, 2].map(|k| i128::from(to[k]) - i128::from(from[k]))
}

/// A triangle of a hull that grows, with the points before it that no earlier face has.
struct GrowingFace {
    corners: [usize; 3],
    outside: Vec<usize>,
    is_gone: bool,
}

struct GrowingHull<'a> {
    points: &'a [[i64; 3]],
    faces: Vec<GrowingFace>,
    /// The face on the left of each edge.
    left_of: BTreeMap<[usize; 2], usize>,
    /// Faces that may have points outside.
    open: Vec<usize>,
}

impl<'a> GrowingHull<'a> {
    /// A tetrahedron of points that are sorted and distinct.
    fn of(points: &'a [[i64; 3]]) -> Option<Self> {
        let last = points.len().checked_sub(1).filter(|last| *last > 0)?;
        let area = |k: usize| {
            let n = normal([points[0], points[last], points[k]]).map(|c| c as f64);
            n[0] * n[0] + n[1] * n[1] + n[2] * n[2]
        };
        let third = (0..=last).rev().max_by(|i, j| area(*i).total_cmp(&area(*j))).filter(|k| area(*k) > 0.0)?;
        let off = |k: usize| before([points[0], points[last], points[third]], points[k]);
        let fourth = (0..=last).rev().max_by_key(|k| off(*k).abs()).filter(|k| off(*k) != 0)?;
        // The fourth lies behind the first three.
        let [a, b, c, d] = if off(fourth) < 0 { [0, last, third, fourth] } else { [last, 0, third, fourth] };
        let mut hull = Self { points, faces: Vec::new(), left_of: BTreeMap::new(), open: Vec::new() };
        for corners in [[a, b, c], [b, a, d], [c, b, d], [a, c, d]] {
            hull.push(corners);
        }
        let all: Vec<usize> = (0..=last).collect();
        hull.distribute(&all, 0);
        Some(hull)
    }

    fn push(&mut self, corners: [usize; 3]) {
        let face = self.faces.len();
        for k in 0..3 {
            self.left_of.insert([corners[k], corners[(k + 1) % 3]], face);
        }
        self.faces.push(GrowingFace { corners, outside: Vec::new(), is_gone: false });
        self.open.push(face);
    }

    fn before(&self, face: usize, point: usize) -> i128 {
        before(self.faces[face].corners.map(|k| self.points[k]), self.points[point])
    }

    /// Gives each point to the first face from `first` on that it lies before; the others are inside.
    fn distribute(&mut self, points: &[usize], first: usize) {
        for point in points {
            if let Some(face) = (first..self.faces.len()).find(|face| self.before(*face, *point) > 0) {
                self.faces[face].outside.push(*point);
            }
        }
    }

    /// A face with points outside, and the farthest of them.
    fn next_point(&mut self) -> Option<(usize, usize)> {
        while let Some(face) = self.open.pop() {
            if self.faces[face].is_gone {
                continue;
            }
            let outside = self.faces[face].outside.iter().copied();
            if let Some(point) = outside.rev().max_by_key(|point| self.before(face, *point)) {
                return Some((face, point));
            }
        }
        None
    }

    /// Replaces the faces that a point sees by those between it and their rim.
    fn add(&mut self, face: usize, point: usize) {
        let (mut waiting, mut rim, mut outside) = (vec![face], Vec::new(), Vec::new());
        self.faces[face].is_gone = true;
        while let Some(seen) = waiting.pop() {
            outside.append(&mut self.faces[seen].outside);
            let corners = self.faces[seen].corners;
            for [a, b] in [0, 1, 2].map(|k| [corners[k], corners[(k + 1) % 3]]) {
                let neighbour = self.left_of[&[b, a]];
                if self.faces[neighbour].is_gone {
                    continue;
                }
                if self.before(neighbour, point) > 0 {
                    self.faces[neighbour].is_gone = true;
                    waiting.push(neighbour);
                } else {
                    rim.push([a, b]);
                }
            }
        }
        let first = self.faces.len();
        rim.into_iter().for_each(|[a, b]| self.push([a, b, point]));
        outside.retain(|p| *p != point);
        self.distribute(&outside, first);
    }

    fn finish(self) -> LatticeHull {
        let faces = || self.faces.iter().filter(|face| !face.is_gone);
        let mut used: BTreeMap<usize, u32> = faces().flat_map(|face| face.corners).map(|k| (k, 0)).collect();
        used.values_mut().zip(0..).for_each(|(new, k)| *new = k);
        LatticeHull {
            vertices: used.keys().map(|k| self.points[*k]).collect(),
            triangles: faces().map(|face| face.corners.map(|k| used[&k])).collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::collections::BTreeSet;

    /// Asserts that a hull is closed, of one piece and behind each of its faces, and that it has all points.
    fn check(points: &[[i64; 3]], hull: &LatticeHull) {
        let edges: Vec<[u32; 2]> =
            hull.triangles.iter().flat_map(|t| [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]]).collect();
        let passed: BTreeSet<[u32; 2]> = edges.iter().copied().collect();
        assert_eq!(passed.len(), edges.len(), "an edge is passed twice");
        assert!(edges.iter().all(|[a, b]| passed.contains(&[*b, *a])), "it is open");
        assert_eq!(hull.vertices.len() + hull.triangles.len(), edges.len() / 2 + 2, "Euler");
        for t in &hull.triangles {
            let corners = t.map(|k| hull.vertices[k as usize]);
            assert_ne!(normal(corners), [0; 3], "a triangle has no area");
            assert!(points.iter().all(|p| before(corners, *p) <= 0), "a point lies outside");
        }
    }

    fn lie_in_a_plane(points: &[[i64; 3]]) -> bool {
        let all = || points.iter().copied();
        all().all(|b| all().all(|c| all().all(|d| before([points[0], b, c], d) == 0)))
    }

    #[test]
    fn points_on_edges_and_in_faces_are_no_harm() {
        let axis = [0, 1, 5, 10];
        let points: Vec<[i64; 3]> = (0..64).map(|k| [k % 4, k / 4 % 4, k / 16].map(|i: usize| axis[i])).collect();
        check(&points, &lattice_hull(&points).unwrap());
    }

    #[test]
    fn a_plane_a_line_and_a_point_are_plates() {
        let square = [[0, 0, 0], [90_000, 0, 0], [90_000, 90_000, 0], [0, 90_000, 0]];
        for n in 1..=4 {
            assert_eq!(lattice_hull(&square[..n]), None);
            let plate = lattice_plate(&square[..n], 1).unwrap();
            check(&square[..n], &plate);
            assert_eq!(plate.vertices.iter().map(|v| v[2].abs()).max(), Some(HALF_PLATE));
        }
        assert_eq!(lattice_plate(&[], 1), None);
    }

    proptest! {
        /// Few places on the axes make bodies that are flat, have corners on edges, or are nearly plane; large steps make them
        /// long and thin.
        #[test]
        fn a_hull_is_closed_and_convex_and_holds_its_points(
            places in prop::collection::vec(prop::array::uniform3(0..4_i64), 1..14),
            steps in prop::array::uniform3(prop::sample::select(vec![1, 7, 30_000, 1 << 34])),
            noise in prop::collection::vec(prop::array::uniform3(-1..=1_i64), 14),
            is_noisy in prop::bool::ANY,
        ) {
            let noise = |k: usize| if is_noisy { noise[k] } else { [0; 3] };
            let point = |(i, p): (usize, &[i64; 3])| [0, 1, 2].map(|k| p[k] * steps[k] + noise(i)[k]);
            let points: Vec<[i64; 3]> = places.iter().enumerate().map(point).collect();
            match lattice_hull(&points) {
                Some(hull) => check(&points, &hull),
                None => prop_assert!(lie_in_a_plane(&points)),
            }
        }

        #[test]
        fn points_of_a_ball_are_all_corners(n in 4..200_usize) {
            // A spiral: no two lie near each other.
            let at = |k: usize| {
                let z = 1.0 - (2.0 * k as f64 + 1.0) / n as f64;
                let (sin, cos) = libm::sincos(2.4 * k as f64);
                let r = libm::sqrt(1.0 - z * z);
                [r * cos, r * sin, z].map(|c| (c * 1e6).round() as i64)
            };
            let points: Vec<[i64; 3]> = (0..n).map(at).collect();
            let hull = lattice_hull(&points).unwrap();
            check(&points, &hull);
            prop_assert_eq!(hull.vertices.len(), n);
        }
    }
}
