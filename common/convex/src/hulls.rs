//! Convex hulls, approximate convex decomposition and its error. The only module of this crate that uses parry.

use crate::lattice_hull::{LATTICE_PER_M, LatticeHull, lattice_hull};
use crate::piece::{Hull, length, sub};
use crate::soundness::is_closed_and_convex;
use frames::TENTHS_PER_M;
use geometry::MeshView;
use parry3d_f64::math::Vector;
use parry3d_f64::query::PointQuery;
use parry3d_f64::shape::{ConvexPolyhedron, TriMesh, TriMeshFlags};
use parry3d_f64::transformation::try_convex_hull;
use parry3d_f64::transformation::vhacd::{VHACD, VHACDParameters};
use std::collections::BTreeMap;

/// Preferred edge of the voxels of a decomposition, in metres.
const VOXEL_M: f64 = 0.02;

/// Minimum and maximum number of voxels along the longest side of a body.
const VOXELS: [f64; 2] = [16.0, 64.0];

/// Maximum number of hulls of a decomposition.
const MAX_HULLS: u32 = 24;

/// Minimum volume of a hull: a cubic millimetre.
const MIN_VOLUME_M3: f64 = 1e-9;

/// Spacing of the points for comparing surfaces, in metres.
const SPACING_M: f64 = 0.05;

/// Maximum depth of subdividing a triangle into four.
const MAX_SUBDIVISIONS: usize = 5;

/// The convex hull of points in metres, each corner on the lattice of files; `None` if they lie in a plane.
///
/// The library merges triangles of one plane to faces, but for flat bodies it may return a hull that is open or not convex.
/// Then the points are scaled to a cube, which does not change the topology of the hull; what is not sound either is computed
/// by exact integers.
pub(crate) fn hull_of(points_m: &[[f64; 3]]) -> Option<Hull> {
    let mut points: Vec<[f64; 3]> = points_m.iter().map(|p| p.map(on_lattice)).collect();
    points.sort_by(|a, b| a.partial_cmp(b).unwrap_or(std::cmp::Ordering::Equal));
    points.dedup();
    let sides = sides_m(&points).map(|side| side.max(1.0 / LATTICE_PER_M));
    let scales = [[1.0; 3], sides.map(|s| 1.0 / s)];
    let sound = scales.into_iter().find_map(|scale| {
        let plain = triangulated(&points, scale)?;
        let triangles: Vec<[u32; 3]> = plain.faces.iter().map(|f| [f[0], f[1], f[2]]).collect();
        let merged = ConvexPolyhedron::from_convex_mesh(vectors(&plain.vertices_m), &triangles).map(hull);
        merged.into_iter().chain([plain]).find(is_sound)
    });
    sound.or_else(|| exact_hull(&points)).filter(|hull| hull.volume_m3() > MIN_VOLUME_M3)
}

fn on_lattice(metres: f64) -> f64 {
    (metres * LATTICE_PER_M).round() / LATTICE_PER_M
}

/// The hull of scaled points; its faces are triangles.
fn triangulated(points_m: &[[f64; 3]], scale: [f64; 3]) -> Option<Hull> {
    let scaled: Vec<Vector> = points_m.iter().map(|p| Vector::from([0, 1, 2].map(|k| p[k] * scale[k]))).collect();
    let (vertices, triangles) = try_convex_hull(&scaled).ok()?;
    let back = |v: &Vector| [0, 1, 2].map(|k| on_lattice([v.x, v.y, v.z][k] / scale[k]));
    let faces = triangles.iter().map(|t| t.to_vec()).collect();
    Some(Hull { vertices_m: vertices.iter().map(back).collect(), faces })
}

/// The hull of points on the lattice by exact integers; `None` if they lie in a plane.
fn exact_hull(points_m: &[[f64; 3]]) -> Option<Hull> {
    let LatticeHull { vertices, triangles } = lattice_hull(&on_lattice_of(points_m))?;
    let metres = |v: &[i64; 3]| v.map(|c| c as f64 / LATTICE_PER_M);
    Some(Hull {
        vertices_m: vertices.iter().map(metres).collect(),
        faces: triangles.iter().map(|t| t.to_vec()).collect(),
    })
}

/// True if a hull with corners on the lattice is closed and convex there.
fn is_sound(hull: &Hull) -> bool {
    is_closed_and_convex(&on_lattice_of(&hull.vertices_m), &hull.faces)
}

fn on_lattice_of(points_m: &[[f64; 3]]) -> Vec<[i64; 3]> {
    points_m.iter().map(|p| p.map(|c| (c * LATTICE_PER_M).round() as i64)).collect()
}

/// Convex hulls whose union approximates the body.
pub(crate) fn decomposed(mesh: MeshView<'_>) -> Vec<Hull> {
    let points_m: Vec<[f64; 3]> = mesh.vertices.iter().map(|v| metres(*v)).collect();
    let points = vectors(&points_m);
    let resolution = (longest_m(&points_m) / VOXEL_M).clamp(VOXELS[0], VOXELS[1]) as u32;
    let parameters =
        VHACDParameters { resolution, concavity: 0.005, max_convex_hulls: MAX_HULLS, ..Default::default() };
    let parts = VHACD::decompose(&parameters, &points, mesh.triangles, true);
    let hulls = parts.compute_exact_convex_hulls(&points, mesh.triangles).into_iter();
    hulls.filter_map(|(points, _)| hull_of(&points.iter().map(|p| [p.x, p.y, p.z]).collect::<Vec<_>>())).collect()
}

/// Edge of the finest voxels that a decomposition uses for these points.
pub(crate) fn voxel_m(points_m: &[[f64; 3]]) -> f64 {
    longest_m(points_m) / VOXELS[1]
}

/// Longest side of the axis-aligned box around points.
pub(crate) fn longest_m(points_m: &[[f64; 3]]) -> f64 {
    sides_m(points_m).into_iter().fold(0.0, f64::max)
}

/// Sides of the axis-aligned box around points.
pub(crate) fn sides_m(points_m: &[[f64; 3]]) -> [f64; 3] {
    [0, 1, 2].map(|k| {
        let along = || points_m.iter().map(|p| p[k]);
        along().fold(f64::NEG_INFINITY, f64::max) - along().fold(f64::INFINITY, f64::min)
    })
}

/// A body with which pieces are compared.
pub(crate) struct ComparedBody {
    mesh: TriMesh,
    points_m: Vec<[f64; 3]>,
}

impl ComparedBody {
    /// `None` without triangles.
    pub(crate) fn of(mesh: MeshView<'_>) -> Option<Self> {
        let points_m: Vec<[f64; 3]> = mesh.vertices.iter().map(|v| metres(*v)).collect();
        let flags = if mesh.closed { TriMeshFlags::ORIENTED } else { TriMeshFlags::empty() };
        let surface = TriMesh::with_flags(vectors(&points_m), mesh.triangles.to_vec(), flags);
        // A surface that is not orientable has no inside.
        let surface = surface.or_else(|_| TriMesh::new(vectors(&points_m), mesh.triangles.to_vec())).ok()?;
        let middles = mesh.corners().map(|t| [0, 1, 2].map(|k| t.iter().map(|v| metres(*v)[k]).sum::<f64>() / 3.0));
        let points_m = points_m.iter().copied().chain(middles).collect();
        Some(Self { mesh: surface, points_m })
    }

    /// For each hull the maximum distance of its surface outside of the body; for the first also that of the body's surface
    /// outside of all hulls.
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

    /// Maximum distance of a hull's surface outside of the body; `None` if more than `max_m`.
    ///
    /// A triangle is subdivided into four until the distance of its middle and its size bound the distance of all its
    /// points, at most [`MAX_SUBDIVISIONS`] times.
    pub(crate) fn outside_up_to_m(&self, hull: &Hull, max_m: f64) -> Option<f64> {
        let mut worst_m: f64 = 0.0;
        let mut level: Vec<[[f64; 3]; 3]> = triangles_of(hull).collect();
        // Coarse triangles first, so that large distances are found early.
        for cut in 0..=MAX_SUBDIVISIONS {
            let mut finer = Vec::new();
            for corners in level {
                let [a, b, c] = corners;
                let middle = [0, 1, 2].map(|k| (a[k] + b[k] + c[k]) / 3.0);
                let reach_m = corners.map(|p| length(sub(p, middle))).into_iter().fold(0.0, f64::max);
                let outside_m = self.outside_m(middle);
                if outside_m > max_m {
                    return None;
                }
                worst_m = worst_m.max(outside_m);
                let is_known = outside_m + reach_m <= max_m || reach_m <= SPACING_M.max(max_m / 2.0) / 2.0;
                if !is_known && cut < MAX_SUBDIVISIONS {
                    let half = |p: [f64; 3], q: [f64; 3]| [0, 1, 2].map(|k| (p[k] + q[k]) / 2.0);
                    let (ab, bc, ca) = (half(a, b), half(b, c), half(c, a));
                    finer.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
                }
            }
            level = finer;
        }
        Some(worst_m)
    }

    /// Distance of a point outside of the body; 0 inside.
    pub(crate) fn outside_m(&self, p: [f64; 3]) -> f64 {
        self.mesh.distance_to_local_point(Vector::from(p), true)
    }
}

/// Corners of a hull, and points distributed over its faces.
fn surface_of(hull: &Hull) -> impl Iterator<Item = [f64; 3]> {
    let inner = triangles_of(hull).flat_map(|[a, b, c]| {
        let longest = [(a, b), (b, c), (c, a)].map(|(p, q)| length(sub(p, q)));
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

/// The triangles of its faces.
fn triangles_of(hull: &Hull) -> impl Iterator<Item = [[f64; 3]; 3]> {
    hull.faces.iter().flat_map(|face| {
        let at = |k: usize| hull.vertices_m[face[k] as usize];
        (1..face.len() - 1).map(move |k| [at(0), at(k), at(k + 1)])
    })
}

fn shape(hull: &Hull) -> Option<ConvexPolyhedron> {
    ConvexPolyhedron::from_convex_hull(&vectors(&hull.vertices_m))
}

/// The hull of a polyhedron, with triangles of one plane merged to a face.
fn hull(polyhedron: ConvexPolyhedron) -> Hull {
    let around = polyhedron.vertices_adj_to_face();
    let faces = polyhedron.faces().iter().map(|face| {
        let first = face.first_vertex_or_edge as usize;
        around[first..][..face.num_vertices_or_edges as usize].to_vec()
    });
    let mut faces: Vec<Vec<u32>> = faces.collect();
    // Corners on straight edges are removed.
    let mut new_index: BTreeMap<u32, u32> = faces.iter().flatten().map(|k| (*k, 0)).collect();
    new_index.values_mut().zip(0..).for_each(|(new, k)| *new = k);
    faces.iter_mut().flatten().for_each(|k| *k = new_index[k]);
    let point = |k: &u32| {
        let p = polyhedron.points()[*k as usize];
        [p.x, p.y, p.z]
    };
    Hull { vertices_m: new_index.keys().map(point).collect(), faces }
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
    use crate::testing::cuboid;
    use proptest::prelude::*;
    use std::collections::BTreeSet;

    #[test]
    fn a_hull_has_each_face_once() {
        let (v, t) = cuboid([0; 3], [10_000, 20_000, 30_000]);
        let found = hull_of(&v.iter().map(|v| metres(*v)).collect::<Vec<_>>()).unwrap();
        assert_eq!((found.vertices_m.len(), found.faces.len()), (8, 6));
        let body = ComparedBody::of(MeshView { vertices: &v, triangles: &t, closed: true }).unwrap();
        assert!(body.deviations_m(std::slice::from_ref(&found))[0] < 1e-9);
        let larger = found.mapped(|p| [p[0] * 1.1, p[1], p[2]]);
        assert!((body.deviations_m(&[larger])[0] - 0.1).abs() < 1e-6);
    }

    #[test]
    fn the_hull_of_a_thin_tilted_plate_is_closed_and_convex() {
        let points = [
            [0.0, 0.0, 0.0],
            [0.0, 2.12, 0.0],
            [0.0, 2.12, -0.001],
            [0.0, 0.0, -0.001],
            [0.5424, 2.12, -0.0069],
            [0.5424, 2.12, -0.0059],
            [1.0002, 1.613, -0.012],
            [1.0002, 1.613, -0.011],
            [1.0002, 0.5067, -0.012],
            [1.0002, 0.5067, -0.011],
            [0.5427, 0.0, -0.0069],
            [0.5427, 0.0, -0.0059],
        ];
        let found = hull_of(&points).unwrap();
        assert!(is_sound(&found), "{found:?}");
        // The area of the plan, a millimetre thick.
        assert!((found.volume_m3() - 0.00188).abs() < 0.0001, "{}", found.volume_m3());
    }

    #[test]
    fn points_in_a_plane_have_no_hull() {
        assert!(hull_of(&[[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]]).is_none());
    }

    proptest! {
        /// Few places on the axes make faces of many corners, corners on edges, and flat bodies.
        #[test]
        fn a_hull_is_closed_and_convex_and_holds_its_points(
            places in prop::collection::vec(prop::array::uniform3(0..5_i32), 4..30),
            sides in prop::array::uniform3(prop::sample::select(vec![1e-5, 0.000_3, 0.001, 0.13, 2.7])),
            tilt in prop::sample::select(vec![0.0, 0.003, 0.4]),
        ) {
            let point = |p: &[i32; 3]| {
                let [x, y, z] = [0, 1, 2].map(|k| f64::from(p[k]) * sides[k]);
                [x, y, z + tilt * x]
            };
            let points: Vec<[f64; 3]> = places.iter().map(point).collect();
            let Some(found) = hull_of(&points) else { return Ok(()) };
            let edges: Vec<(u32, u32)> = found.faces.iter().flat_map(|f| (0..f.len()).map(|k| (f[k], f[(k + 1) % f.len()]))).collect();
            let passed: BTreeSet<(u32, u32)> = edges.iter().copied().collect();
            prop_assert_eq!(passed.len(), edges.len(), "an edge is passed twice");
            prop_assert!(edges.iter().all(|(a, b)| passed.contains(&(*b, *a))), "it is open");
            prop_assert_eq!(found.vertices_m.len() + found.faces.len(), edges.len() / 2 + 2, "Euler");
            for plane in found.planes().filter(|p| p.width_m > 0.01 * longest_m(&points)) {
                prop_assert!(points.iter().all(|p| plane.before_m(*p) < 0.005 * longest_m(&points)), "{:?}", found);
            }
        }
    }
}
