//! Element bodies for `semantic.json`: vertices, faces and feature edges.

use frames::metres;
use geometry::{MeshView, unit_normal};
use schemars::JsonSchema;
use serde::Serialize;
use std::collections::BTreeMap;

/// Faces whose normals differ by less than about two degrees look like one.
const SMOOTH: f64 = 0.9994;

/// A body: vertices in `map` metres, triangles, and the edges between faces that are not in one plane.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct Geometry {
    /// Corners of the triangles, each once.
    vertices: Vec<[f64; 3]>,
    /// Triangles: three vertices each, counter-clockwise from outside.
    faces: Vec<[u32; 3]>,
    /// Edges between faces that are not in one plane, and edges of one face alone: two vertices each.
    edges: Vec<[u32; 2]>,
}

impl Geometry {
    pub(crate) fn of<'a>(meshes: impl Iterator<Item = MeshView<'a>>) -> Self {
        let mut known: BTreeMap<[i32; 3], u32> = BTreeMap::new();
        let (mut vertices, mut faces) = (Vec::new(), Vec::new());
        let mut sides: BTreeMap<[u32; 2], Vec<[f64; 3]>> = BTreeMap::new();
        for triangle in meshes.flat_map(MeshView::corners) {
            let Some(normal) = unit_normal(&triangle) else { continue };
            let face = triangle.map(|v| {
                *known.entry(v).or_insert_with(|| {
                    vertices.push(v.map(metres));
                    vertices.len() as u32 - 1
                })
            });
            for (a, b) in [(face[0], face[1]), (face[1], face[2]), (face[2], face[0])] {
                sides.entry([a.min(b), a.max(b)]).or_default().push(normal);
            }
            faces.push(face);
        }
        let seen = |normals: &[[f64; 3]]| match normals {
            [a, b] => (0..3).map(|k| a[k] * b[k]).sum::<f64>() < SMOOTH,
            _ => true,
        };
        let edges = sides.into_iter().filter(|(_, normals)| seen(normals)).map(|(edge, _)| edge).collect();
        Self { vertices, faces, edges }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_square_of_two_triangles_has_four_edges() {
        let vertices = [[0, 0, 0], [10_000, 0, 0], [10_000, 10_000, 0], [0, 10_000, 0]];
        let mesh = MeshView { vertices: &vertices, triangles: &[[0, 1, 2], [0, 2, 3]], closed: false };
        let geometry = Geometry::of([mesh].into_iter());
        assert_eq!((geometry.vertices.len(), geometry.faces.len(), geometry.edges.len()), (4, 2, 4));
    }
}
