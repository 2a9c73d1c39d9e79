//! Mesh store of the world: repeated meshes that differ by translation and quarter turns are stored once.

use convex::LATTICE_PER_M;
use std::collections::BTreeMap;
use std::fmt::Write;

/// Units per metre of the coordinates here: hundredths of a millimetre.
pub(crate) const UNITS_PER_M: f64 = LATTICE_PER_M;

/// A mesh at its own origin.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Solid {
    pub(crate) vertices: Vec<[i64; 3]>,
    /// Faces as corners, counter-clockwise from outside; plane and convex, and fanned by readers from their first corners.
    pub(crate) faces: Vec<Vec<u32>>,
}

/// Placement of a stored mesh: rotated by quarter turns about z, then shifted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct PlacedMesh {
    /// Number of the mesh.
    pub(crate) mesh: usize,
    pub(crate) shift_m: [f64; 3],
    pub(crate) quarters: u8,
}

impl PlacedMesh {
    pub(crate) fn yaw_rad(&self) -> f64 {
        f64::from(self.quarters) * std::f64::consts::FRAC_PI_2
    }
}

/// All meshes, in the order in which they came.
#[derive(Debug, Default)]
pub(crate) struct MeshStore {
    known: BTreeMap<Solid, usize>,
    pub(crate) meshes: Vec<Solid>,
}

impl MeshStore {
    /// Adds a mesh, or finds an equal one.
    pub(crate) fn place(&mut self, mut solid: Solid) -> PlacedMesh {
        let first = solid.vertices.first().copied().unwrap_or_default();
        for vertex in &mut solid.vertices {
            *vertex = [0, 1, 2].map(|k| vertex[k] - first[k]);
        }
        // Copies have their corners in the same order: the one farthest from the first in plan, turned into the first quarter of
        // the plane, gives them the same yaw.
        let reach = |v: &[i64; 3]| i128::from(v[0]).pow(2) + i128::from(v[1]).pow(2);
        let mut farthest = [0; 3];
        for vertex in &solid.vertices {
            if reach(vertex) > reach(&farthest) {
                farthest = *vertex;
            }
        }
        let mut quarters = 0;
        while !(farthest[0] > 0 && farthest[1] >= 0) && reach(&farthest) > 0 {
            farthest = [farthest[1], -farthest[0], 0];
            quarters += 1;
        }
        for _ in 0..quarters {
            solid.vertices.iter_mut().for_each(|v| *v = [v[1], -v[0], v[2]]);
        }
        let next = self.meshes.len();
        let mesh = *self.known.entry(solid.clone()).or_insert(next);
        if mesh == next {
            self.meshes.push(solid);
        }
        PlacedMesh { mesh, shift_m: first.map(|c| c as f64 / UNITS_PER_M), quarters }
    }
}

impl Solid {
    /// Number of triangles of its faces.
    pub(crate) fn n_triangles(&self) -> usize {
        self.faces.iter().map(|f| f.len() - 2).sum()
    }

    /// The mesh as an OBJ file.
    pub(crate) fn obj(&self, material: Option<&str>) -> String {
        let mut out = String::new();
        if let Some(material) = material {
            writeln!(out, "mtllib materials.mtl\nusemtl {material}").expect("memory does not fail");
        }
        for v in &self.vertices {
            let [x, y, z] = v.map(|c| number(c as f64 / UNITS_PER_M));
            writeln!(out, "v {x} {y} {z}").expect("memory does not fail");
        }
        for face in &self.faces {
            out.push('f');
            face.iter().for_each(|k| write!(out, " {}", k + 1).expect("memory does not fail"));
            out.push('\n');
        }
        out
    }
}

/// A length or an angle with as many decimals as are known: a hundredth of a millimetre, a millionth of a radian.
pub(crate) fn number(value: f64) -> String {
    let rounded = (value * 1e6).round() / 1e6;
    // No negative zero in files.
    if rounded == 0.0 { "0".to_owned() } else { format!("{rounded}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn solid(vertices: Vec<[i64; 3]>) -> Solid {
        Solid { vertices, faces: vec![vec![0, 1, 2, 3]] }
    }

    #[test]
    fn copies_that_are_shifted_and_turned_are_one_mesh() {
        let base = vec![[0, 0, 0], [300_000, 100_000, 0], [200_000, 400_000, 0], [0, 100_000, 70_000]];
        let mut store = MeshStore::default();
        for quarters in 0..4 {
            let mut turned = base.clone();
            for _ in 0..quarters {
                turned.iter_mut().for_each(|v| *v = [-v[1], v[0], v[2]]);
            }
            let shifted = turned.iter().map(|v| [v[0] + 12_345, v[1] - 777, v[2] + 5]).collect();
            let placed = store.place(solid(shifted));
            assert_eq!(placed.mesh, 0);
            // The pose takes the mesh back to where it came from.
            for (vertex, expected) in store.meshes[0].vertices.iter().zip(&turned) {
                let mut v = *vertex;
                for _ in 0..placed.quarters {
                    v = [-v[1], v[0], v[2]];
                }
                assert_eq!(v, *expected);
            }
        }
        store.place(solid(base.iter().map(|v| [v[0], v[1], 2 * v[2]]).collect()));
        assert_eq!(store.meshes.len(), 2);
    }

    #[test]
    fn numbers_are_short() {
        assert_eq!(number(-0.000_000_1), "0");
        assert_eq!(number(1.5), "1.5");
        assert_eq!(number(0.1 + 0.2), "0.3");
    }
}
