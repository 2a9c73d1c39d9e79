//! Collision meshes as files have them: closed, and convex except for rounding.

use crate::meshes::Solid;
use crate::triangle_fans::fans;
use convex::{Hull, LATTICE_PER_M, LatticeHull, PLATE_M, dents_m, is_closed_and_convex, lattice_hull, lattice_plate};
use std::collections::BTreeMap;

/// Readers keep corners in single precision: so many steps of the lattice, as a power of two, are told apart.
const SINGLE_BITS: u32 = 22;

/// The mesh of a convex piece.
#[derive(Debug)]
pub(crate) struct CollisionMesh {
    pub(crate) solid: Solid,
    /// What stands in for a piece that is not sound with the corners of a file.
    pub(crate) replaced: Option<Replacement>,
    /// How much farther from its body it is than the piece.
    pub(crate) more_deviation_m: f64,
}

/// What stands in for a piece.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Replacement {
    /// The hull of its corners.
    Hull,
    /// A plate of 2 mm around its corners, which lie in a plane.
    Plate,
}

impl CollisionMesh {
    /// The mesh of a piece; `None` if it has no corners.
    ///
    /// Corners are rounded to those of files, faces are split as readers fan them, and the result is checked. What is not closed
    /// and convex then is replaced by the hull of its corners.
    pub(crate) fn of(piece: &Hull) -> Option<Self> {
        let solid = Solid::of_piece(piece);
        if is_closed_and_convex(&solid.vertices, &solid.faces) {
            return Some(Self { solid, replaced: None, more_deviation_m: 0.0 });
        }
        let of = |hull: LatticeHull, replacement, more_deviation_m| Self {
            solid: Solid { vertices: hull.vertices, faces: hull.triangles.iter().map(|t| t.to_vec()).collect() },
            replaced: Some(replacement),
            more_deviation_m,
        };
        let Solid { vertices, faces } = &solid;
        let hull = lattice_hull(vertices).map(|hull| of(hull, Replacement::Hull, dents_m(vertices, faces)));
        hull.or_else(|| lattice_plate(vertices, step(piece)).map(|plate| of(plate, Replacement::Plate, PLATE_M)))
    }
}

impl Solid {
    /// The corners and faces of a file: corners that are one when they are rounded become one, faces that lose their area go,
    /// and the others are as readers fan them.
    pub(crate) fn of_piece(piece: &Hull) -> Self {
        let step = step(piece);
        let rounded = |v: &[f64; 3]| v.map(|c| (c * LATTICE_PER_M / step as f64).round() as i64 * step);
        let mut known = BTreeMap::new();
        let mut vertices = Vec::new();
        let mut place = |v: &[f64; 3]| {
            *known.entry(rounded(v)).or_insert_with(|| {
                vertices.push(rounded(v));
                vertices.len() as u32 - 1
            })
        };
        let places: Vec<u32> = piece.vertices_m.iter().map(&mut place).collect();
        let mut faces = Vec::new();
        for face in &piece.faces {
            let mut face: Vec<u32> = face.iter().map(|k| places[*k as usize]).collect();
            face.dedup();
            if face.len() > 1 && face.first() == face.last() {
                face.pop();
            }
            if face.len() >= 3 {
                faces.extend(fans(&face, |k| vertices[k as usize]));
            }
        }
        Self { vertices, faces }
    }
}

/// Steps of the lattice between corners that stay apart in single precision: one up to 42 m.
fn step(piece: &Hull) -> i64 {
    let [low, high] = piece.bounds_m();
    let extent = (0..3).map(|k| (high[k] - low[k]) * LATTICE_PER_M).fold(1.0, f64::max);
    let bits = u64::BITS - (extent.ceil() as u64).leading_zeros();
    1 << bits.saturating_sub(SINGLE_BITS)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::meshes::MeshStore;
    use proptest::prelude::*;
    use std::collections::BTreeSet;

    /// Corners and triangles of an OBJ file, fanned from the first corners of its faces.
    fn parsed(obj: &str) -> (Vec<[f64; 3]>, Vec<[usize; 3]>) {
        let words = |mark: &str| -> Vec<Vec<f64>> {
            let lines = obj.lines().filter_map(|l| l.strip_prefix(mark));
            lines.map(|l| l.split_whitespace().map(|w| w.parse().unwrap()).collect()).collect()
        };
        let corners = words("v ").iter().map(|v| [v[0], v[1], v[2]]).collect();
        let faces = words("f ");
        let fan = |f: &Vec<f64>| (1..f.len() - 1).map(|k| [0, k, k + 1].map(|i| f[i] as usize - 1)).collect::<Vec<_>>();
        (corners, faces.iter().flat_map(fan).collect())
    }

    /// Asserts that the file is closed when equal corners are merged, in double and in single precision, and that its volume is
    /// that of a body behind all of its faces.
    fn check(solid: &Solid) {
        let mut store = MeshStore::default();
        store.place(solid.clone());
        let (corners, triangles) = parsed(&store.meshes[0].obj(None));
        let single = |p: &[f64; 3]| p.map(|c| (c as f32).to_bits());
        let distinct: BTreeSet<[u32; 3]> = corners.iter().map(single).collect();
        assert_eq!(distinct.len(), corners.len(), "corners that are one for some readers");
        let edges: Vec<[usize; 2]> =
            triangles.iter().flat_map(|t| [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]]).collect();
        let passed: BTreeSet<[usize; 2]> = edges.iter().copied().collect();
        assert_eq!(passed.len(), edges.len(), "an edge is passed twice");
        assert!(edges.iter().all(|[a, b]| passed.contains(&[*b, *a])), "it is open");
        assert_eq!(corners.len() + triangles.len(), edges.len() / 2 + 2, "Euler");
        let vertices: Vec<[i64; 3]> = corners.iter().map(|c| c.map(|c| (c * LATTICE_PER_M).round() as i64)).collect();
        let hull = lattice_hull(&vertices).expect("it has a volume");
        let volume = |vertices: &[[i64; 3]], triangles: &mut dyn Iterator<Item = [usize; 3]>| -> f64 {
            let at = |k: usize| [0, 1, 2].map(|i| (vertices[k][i] - vertices[0][i]) as f64);
            triangles
                .map(|t| {
                    let [a, b, c] = t.map(at);
                    a[0] * (b[1] * c[2] - b[2] * c[1])
                        + a[1] * (b[2] * c[0] - b[0] * c[2])
                        + a[2] * (b[0] * c[1] - b[1] * c[0])
                })
                .sum()
        };
        let own = volume(&vertices, &mut triangles.iter().copied());
        let of_hull = volume(&hull.vertices, &mut hull.triangles.iter().map(|t| t.map(|k| k as usize)));
        assert!(own > 0.0 && own >= 0.95 * of_hull, "{own} of {of_hull}");
    }

    #[test]
    fn a_wedge_whose_edge_is_lost_to_rounding_is_a_mesh_without_the_face() {
        let vertices_m =
            vec![[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 1e-6, 1.0]];
        let faces = vec![vec![0, 3, 2, 1], vec![0, 1, 4], vec![1, 2, 5, 4], vec![2, 3, 5], vec![3, 0, 4, 5]];
        let mesh = CollisionMesh::of(&Hull { vertices_m, faces }).unwrap();
        assert_eq!((mesh.solid.vertices.len(), mesh.solid.faces.len(), mesh.replaced), (5, 5, None));
        check(&mesh.solid);
    }

    #[test]
    fn an_open_piece_is_its_hull_and_one_without_thickness_a_plate() {
        let vertices_m = vec![[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0], [0.5, 0.5, 1.0]];
        let open = Hull { vertices_m, faces: vec![vec![0, 3, 2, 1], vec![0, 1, 4]] };
        let mesh = CollisionMesh::of(&open).unwrap();
        assert_eq!(mesh.replaced, Some(Replacement::Hull));
        check(&mesh.solid);
        let flat = Hull { vertices_m: open.vertices_m[..4].to_vec(), faces: vec![vec![0, 1, 2, 3]] };
        let mesh = CollisionMesh::of(&flat).unwrap();
        assert_eq!(mesh.replaced, Some(Replacement::Plate));
        check(&mesh.solid);
        assert!(CollisionMesh::of(&Hull::default()).is_none());
    }

    proptest! {
        /// Corners near the lattice on few places of each axis, in bodies from a tenth of a millimetre to a kilometre.
        #[test]
        fn what_is_written_is_closed_and_convex_whatever_the_piece(
            places in prop::collection::vec(prop::array::uniform3(0..4_i32), 1..16),
            sides in prop::array::uniform3(prop::sample::select(vec![0.0, 3e-6, 1e-5, 1e-4, 0.002, 0.13, 2.7, 400.0])),
            noise_m in prop::sample::select(vec![0.0, 4e-6, 2e-5]),
            faces in prop::collection::vec(prop::collection::vec(0..16_u32, 3..6), 0..12),
            at_m in prop::sample::select(vec![0.0, 1_234.567_891]),
        ) {
            let n = places.len() as u32;
            let vertices_m = places.iter().enumerate().map(|(i, p)| {
                let noise = |k: usize| noise_m * f64::from((i * 7 + k * 5) as u32 % 3);
                [0, 1, 2].map(|k| at_m + f64::from(p[k]) * sides[k] + noise(k))
            });
            let faces = faces.into_iter().map(|f| f.into_iter().map(|k| k % n).collect()).collect();
            check(&CollisionMesh::of(&Hull { vertices_m: vertices_m.collect(), faces }).unwrap().solid);
        }

        /// Prisms between tilted planes whose ends nearly meet, as cut from stairs and landings.
        #[test]
        fn prisms_with_ends_that_nearly_meet_are_written_closed_and_convex(
            radii in prop::collection::vec(0.05..3.0_f64, 3..12),
            slopes in prop::array::uniform4(-0.5..0.5_f64),
            thickness_m in prop::sample::select(vec![0.0, 5e-6, 2e-5, 1e-3, 0.2]),
            turn in prop::array::uniform2(0.0..6.0_f64),
        ) {
            let n = radii.len();
            let (mut vertices_m, mut low, mut high) = (Vec::new(), Vec::new(), Vec::new());
            let (s, c) = libm::sincos(turn[0]);
            let (t, d) = libm::sincos(turn[1]);
            let turned = |[x, y, z]: [f64; 3]| [c * x - s * (d * y - t * z), s * x + c * (d * y - t * z), t * y + d * z];
            for k in 0..n {
                let (sin, cos) = libm::sincos(std::f64::consts::TAU * k as f64 / n as f64);
                let [x, y] = [radii[0] * cos, radii[0] * sin];
                let z = slopes[0] * x + slopes[1] * y;
                let up = thickness_m + ((slopes[2] - slopes[0]) * x + (slopes[3] - slopes[1]) * y).max(0.0);
                low.push(vertices_m.len() as u32);
                vertices_m.push(turned([x, y, z]));
                high.push(vertices_m.len() as u32);
                vertices_m.push(turned([x, y, z + up]));
            }
            let mut faces = vec![low.iter().rev().copied().collect(), high.clone()];
            faces.extend((0..n).map(|k| vec![low[k], low[(k + 1) % n], high[(k + 1) % n], high[k]]));
            check(&CollisionMesh::of(&Hull { vertices_m, faces }).unwrap().solid);
        }
    }
}
