//! Convex hulls, approximate convex decompositions, and how far they are off. With `surfaces` the only module that names parry.

use crate::mesh::MeshView;
use crate::piece::Hull;
use frames::TENTHS_PER_M;
use parry3d_f64::math::Vector;
use parry3d_f64::query::PointQuery;
use parry3d_f64::shape::{ConvexPolyhedron, TriMesh, TriMeshFlags};
use parry3d_f64::transformation::try_convex_hull;
use parry3d_f64::transformation::vhacd::{VHACD, VHACDParameters};

/// Edge of the voxels of a decomposition, in metres, as far as their number allows.
const VOXEL_M: f64 = 0.02;

/// Voxels along the longest side of a body.
const VOXELS: [f64; 2] = [16.0, 64.0];

/// Hulls that a body becomes at most.
const HULLS_MAX: u32 = 24;

/// A hull with less volume is flat: a cubic millimetre.
const LEAST_M3: f64 = 1e-9;

/// Distance between the points at which a surface is compared with another, in metres.
const SPACING_M: f64 = 0.05;

/// The convex hull of points in metres; `None` if they lie in a plane.
pub(crate) fn hull_of(points_m: &[[f64; 3]]) -> Option<Hull> {
    let (vertices, triangles) = try_convex_hull(&vectors(points_m)).ok()?;
    let found = hull(ConvexPolyhedron::from_convex_mesh(vertices, &triangles)?);
    (found.volume_m3() > LEAST_M3).then_some(found)
}

/// Convex hulls that together are nearly the body.
pub(crate) fn decomposed(mesh: MeshView<'_>) -> Vec<Hull> {
    let points_m: Vec<[f64; 3]> = mesh.vertices.iter().map(|v| metres(*v)).collect();
    let points = vectors(&points_m);
    let resolution = (longest_m(&points_m) / VOXEL_M).clamp(VOXELS[0], VOXELS[1]) as u32;
    let parameters =
        VHACDParameters { resolution, concavity: 0.005, max_convex_hulls: HULLS_MAX, ..Default::default() };
    let parts = VHACD::decompose(&parameters, &points, mesh.triangles, true);
    let hulls = parts.compute_exact_convex_hulls(&points, mesh.triangles).into_iter();
    hulls.filter_map(|(points, _)| hull_of(&points.iter().map(|p| [p.x, p.y, p.z]).collect::<Vec<_>>())).collect()
}

/// Edge of the voxels in which a decomposition sees points, if it sees them as finely as it may.
pub(crate) fn voxel_m(points_m: &[[f64; 3]]) -> f64 {
    longest_m(points_m) / VOXELS[1]
}

/// Longest side of the upright box around points.
fn longest_m(points_m: &[[f64; 3]]) -> f64 {
    let extent = |k: usize| {
        let side = || points_m.iter().map(|p| p[k]);
        side().fold(f64::NEG_INFINITY, f64::max) - side().fold(f64::INFINITY, f64::min)
    };
    (0..3).map(extent).fold(0.0, f64::max)
}

/// A body to compare pieces with.
pub(crate) struct Body {
    mesh: TriMesh,
    points_m: Vec<[f64; 3]>,
}

impl Body {
    /// `None` without triangles.
    pub(crate) fn of(mesh: MeshView<'_>) -> Option<Self> {
        let points_m: Vec<[f64; 3]> = mesh.vertices.iter().map(|v| metres(*v)).collect();
        let flags = if mesh.closed { TriMeshFlags::ORIENTED } else { TriMeshFlags::empty() };
        let surface = TriMesh::with_flags(vectors(&points_m), mesh.triangles.to_vec(), flags);
        // A surface that cannot be oriented has no inside.
        let surface = surface.or_else(|_| TriMesh::new(vectors(&points_m), mesh.triangles.to_vec())).ok()?;
        let middles = mesh.corners().map(|t| [0, 1, 2].map(|k| t.iter().map(|v| metres(*v)[k]).sum::<f64>() / 3.0));
        let points_m = points_m.iter().copied().chain(middles).collect();
        Some(Self { mesh: surface, points_m })
    }

    /// For each hull, the farthest that its surface lies outside of the body; the first also counts how far the body's own
    /// surface lies outside of all hulls.
    pub(crate) fn deviations_m(&self, hulls: &[Hull]) -> Vec<f64> {
        let mut found: Vec<f64> =
            hulls.iter().map(|hull| surface_of(hull).map(|p| self.outside_m(p)).fold(0.0, f64::max)).collect();
        let shapes: Vec<ConvexPolyhedron> = hulls.iter().filter_map(shape).collect();
        let uncovered = self.points_m.iter().map(|p| {
            let p = Vector::from(*p);
            shapes.iter().map(|s| s.distance_to_local_point(p, true)).fold(f64::INFINITY, f64::min)
        });
        if let Some(first) = found.first_mut() {
            *first = uncovered.fold(*first, f64::max);
        }
        found
    }

    fn outside_m(&self, p: [f64; 3]) -> f64 {
        self.mesh.distance_to_local_point(Vector::from(p), true)
    }
}

/// Corners of a hull and points spread over its faces.
fn surface_of(hull: &Hull) -> impl Iterator<Item = [f64; 3]> {
    let fans = hull.faces.iter().flat_map(|face| {
        let at = |k: usize| hull.vertices_m[face[k] as usize];
        (1..face.len() - 1).map(move |k| [at(0), at(k), at(k + 1)])
    });
    let inner = fans.flat_map(|[a, b, c]| {
        let longest = [(a, b), (b, c), (c, a)].map(|(p, q)| crate::piece::length(crate::piece::sub(p, q)));
        let n = (longest.into_iter().fold(0.0, f64::max) / SPACING_M).ceil().clamp(1.0, 40.0) as usize;
        (0..=n).flat_map(move |i| {
            (0..=n - i).map(move |j| {
                let [s, t] = [i, j].map(|k| k as f64 / n as f64);
                [0, 1, 2].map(|k| a[k] + s * (b[k] - a[k]) + t * (c[k] - a[k]))
            })
        })
    });
    hull.vertices_m.iter().copied().chain(inner)
}

fn shape(hull: &Hull) -> Option<ConvexPolyhedron> {
    ConvexPolyhedron::from_convex_hull(&vectors(&hull.vertices_m))
}

/// The faces of a polyhedron, each once however many triangles it has.
fn hull(polyhedron: ConvexPolyhedron) -> Hull {
    let around = polyhedron.vertices_adj_to_face();
    let faces = polyhedron.faces().iter().map(|face| {
        let first = face.first_vertex_or_edge as usize;
        around[first..][..face.num_vertices_or_edges as usize].to_vec()
    });
    let faces: Vec<Vec<u32>> = faces.collect();
    let vertices_m = polyhedron.points().iter().map(|p| [p.x, p.y, p.z]).collect();
    Hull { vertices_m, faces }
}

fn vectors(points_m: &[[f64; 3]]) -> Vec<Vector> {
    points_m.iter().map(|p| Vector::from(*p)).collect()
}

fn metres(v: [i32; 3]) -> [f64; 3] {
    v.map(|c| f64::from(c) / f64::from(TENTHS_PER_M))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::section::tests::cuboid;

    #[test]
    fn a_hull_has_each_face_once() {
        let (v, t) = cuboid([0; 3], [10_000, 20_000, 30_000]);
        let found = hull_of(&v.iter().map(|v| metres(*v)).collect::<Vec<_>>()).unwrap();
        assert_eq!((found.vertices_m.len(), found.faces.len()), (8, 6));
        let body = Body::of(MeshView { vertices: &v, triangles: &t, closed: true }).unwrap();
        assert!(body.deviations_m(std::slice::from_ref(&found))[0] < 1e-9);
        let larger = found.mapped(|p| [p[0] * 1.1, p[1], p[2]]);
        assert!((body.deviations_m(&[larger])[0] - 0.1).abs() < 1e-6);
    }

    #[test]
    fn points_in_a_plane_have_no_hull() {
        assert!(hull_of(&[[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]]).is_none());
    }
}
