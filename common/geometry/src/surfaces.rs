//! Ray casting on triangles, and sample points on surfaces. The only module of this crate that uses parry.

use crate::mesh::{MeshView, unit_normal};
use frames::TENTHS_PER_M;
use parry3d_f64::math::Vector;
use parry3d_f64::query::{Ray, RayCast};
use parry3d_f64::shape::TriMesh;

/// Triangles of many meshes in a bounding volume hierarchy for ray casting. Lengths in metres.
pub struct Surfaces {
    /// `None` without triangles.
    mesh: Option<TriMesh>,
}

/// A point on a surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfacePoint {
    /// Position in metres.
    pub at_m: [f64; 3],
    /// Unit normal of its triangle.
    pub normal: [f64; 3],
}

impl Surfaces {
    /// Builds it from the triangles of meshes.
    pub fn of<'a>(parts: impl IntoIterator<Item = MeshView<'a>>) -> Self {
        let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
        for part in parts {
            let first = vertices.len() as u32;
            vertices.extend(part.vertices.iter().map(|v| Vector::from(metres(*v))));
            triangles.extend(part.triangles.iter().map(|t| t.map(|corner| first + corner)));
        }
        // Without flags a mesh with triangles is always made.
        Self { mesh: TriMesh::new(vertices, triangles).ok() }
    }

    /// Distance from a point along a unit vector to the first surface, if at most `reach_m`. Both sides of surfaces count.
    pub fn first_m(&self, from_m: [f64; 3], direction: [f64; 3], reach_m: f64) -> Option<f64> {
        let ray = Ray::new(Vector::from(from_m), Vector::from(direction));
        self.mesh.as_ref()?.cast_local_ray(&ray, reach_m, false)
    }
}

/// Points on the triangles of a mesh between two heights: intersections with the lines of a lattice with this spacing along
/// the main axis of a triangle's normal. Their number does not depend on the triangulation.
pub fn surface_points(
    mesh: MeshView<'_>,
    spacing_m: f64,
    [lowest_m, highest_m]: [f64; 2],
    mut found: impl FnMut(SurfacePoint),
) {
    for triangle in mesh.corners() {
        let corners = triangle.map(metres);
        let z = corners.map(|c| c[2]);
        let is_off = z.iter().all(|z| *z < lowest_m) || z.iter().all(|z| *z > highest_m);
        let Some(normal) = unit_normal(&triangle).filter(|_| !is_off) else { continue };
        points_of(&corners, normal, spacing_m, |at_m| {
            if lowest_m <= at_m[2] && at_m[2] <= highest_m {
                found(SurfacePoint { at_m, normal });
            }
        });
    }
}

fn points_of(corners: &[[f64; 3]; 3], normal: [f64; 3], spacing_m: f64, mut found: impl FnMut([f64; 3])) {
    let across = (0..3).max_by(|&a, &b| normal[a].abs().total_cmp(&normal[b].abs())).unwrap_or(2);
    let [u, v] = [(across + 1) % 3, (across + 2) % 3];
    let steps = |k: usize| {
        let ends = corners.map(|c| c[k] / spacing_m - 0.5);
        let lo = ends.iter().copied().fold(f64::INFINITY, f64::min);
        let hi = ends.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        lo.ceil() as i64..=hi.floor() as i64
    };
    for i in steps(u) {
        for j in steps(v) {
            let [p, q] = [i, j].map(|k| (k as f64 + 0.5) * spacing_m);
            // Twice the signed areas of the point with each side: equal signs if it lies inside.
            let area = |a: usize, b: usize| {
                let [a, b] = [corners[a], corners[b]];
                (a[u] - p) * (b[v] - q) - (a[v] - q) * (b[u] - p)
            };
            let areas = [area(1, 2), area(2, 0), area(0, 1)];
            let whole: f64 = areas.iter().sum();
            if whole != 0.0 && areas.iter().all(|a| a * whole >= 0.0) {
                let mut at_m = [0.0; 3];
                for k in 0..3 {
                    at_m[k] = (0..3).map(|c| corners[c][k] * areas[c] / whole).sum();
                }
                found(at_m);
            }
        }
    }
}

fn metres(v: [i32; 3]) -> [f64; 3] {
    v.map(|c| f64::from(c) / f64::from(TENTHS_PER_M))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::section::tests::cuboid;

    #[test]
    fn points_are_as_many_as_a_surface_is_large() {
        let (v, t) = cuboid([0, 0, 0], [40_000, 20_000, 30_000]);
        let mesh = MeshView { vertices: &v, triangles: &t, closed: true };
        let mut points = Vec::new();
        surface_points(mesh, 0.1, [-1.0, 4.0], |p| points.push(p));
        // 2 * (4 * 2 + 2 * 3 + 3 * 4) m2; those on the diagonal of a side may be found in both of its triangles.
        assert!((5200..5500).contains(&points.len()), "{}", points.len());
        for p in &points {
            let is_at = |k: usize, m: f64| (p.at_m[k] - m).abs() < 1e-9;
            let on_side = (0..3).any(|k| p.normal[k].abs() == 1.0 && (is_at(k, 0.0) || is_at(k, [4.0, 2.0, 3.0][k])));
            assert!(on_side, "{p:?}");
        }
        let mut low = 0;
        surface_points(mesh, 0.1, [0.5, 1.0], |p| low += i32::from(p.at_m[2] < 0.5 || p.at_m[2] > 1.0));
        assert_eq!(low, 0);
    }

    #[test]
    fn lines_end_at_the_first_surface() {
        let (v, t) = cuboid([10_000, -10_000, 0], [12_000, 10_000, 20_000]);
        let surfaces = Surfaces::of([MeshView { vertices: &v, triangles: &t, closed: true }]);
        let hit = surfaces.first_m([0.0, 0.0, 1.0], [1.0, 0.0, 0.0], 5.0).unwrap();
        assert!((hit - 1.0).abs() < 1e-9, "{hit}");
        assert_eq!(surfaces.first_m([0.0, 0.0, 1.0], [1.0, 0.0, 0.0], 0.9), None);
        assert_eq!(surfaces.first_m([0.0, 0.0, 2.5], [1.0, 0.0, 0.0], 5.0), None);
        // From inside.
        let hit = surfaces.first_m([1.1, 0.0, 1.0], [1.0, 0.0, 0.0], 5.0).unwrap();
        assert!((hit - 0.1).abs() < 1e-9, "{hit}");
        assert_eq!(Surfaces::of([]).first_m([0.0; 3], [1.0, 0.0, 0.0], 5.0), None);
    }
}
