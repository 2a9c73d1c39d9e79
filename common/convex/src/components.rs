//! The connected parts of a mesh.

use geometry::{MeshView, is_closed};
use std::collections::BTreeMap;

/// An owned mesh.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(crate) struct Mesh {
    pub(crate) vertices: Vec<[i32; 3]>,
    pub(crate) triangles: Vec<[u32; 3]>,
    pub(crate) closed: bool,
}

impl Mesh {
    pub(crate) fn view(&self) -> MeshView<'_> {
        MeshView { vertices: &self.vertices, triangles: &self.triangles, closed: self.closed }
    }

    /// Merges equal corners to one vertex and drops degenerate triangles.
    pub(crate) fn welded(mesh: MeshView<'_>) -> Self {
        let mut known: BTreeMap<[i32; 3], u32> = BTreeMap::new();
        let mut vertices = Vec::new();
        let mut triangles = Vec::new();
        for corners in mesh.corners() {
            let t = corners.map(|p| {
                *known.entry(p).or_insert_with(|| {
                    vertices.push(p);
                    vertices.len() as u32 - 1
                })
            });
            if t[0] != t[1] && t[1] != t[2] && t[2] != t[0] {
                triangles.push(t);
            }
        }
        let closed = is_closed(&vertices, &triangles);
        Self { vertices, triangles, closed }
    }

    /// The mesh with all faces reversed.
    pub(crate) fn flipped(mut self) -> Self {
        self.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        self
    }

    /// Joins meshes to one.
    pub(crate) fn joined(meshes: Vec<Self>) -> Self {
        let mut all = Self::default();
        for mesh in meshes {
            let first = all.vertices.len() as u32;
            all.vertices.extend(mesh.vertices);
            all.triangles.extend(mesh.triangles.iter().map(|t| t.map(|k| first + k)));
        }
        all.closed = is_closed(&all.vertices, &all.triangles);
        all
    }
}

/// Connected components of a welded mesh by vertices, in the order of their first triangles.
pub(crate) fn components(mesh: &Mesh) -> Vec<Mesh> {
    let mut parents: Vec<u32> = (0..mesh.vertices.len() as u32).collect();
    for t in &mesh.triangles {
        let roots = t.map(|v| root(&mut parents, v));
        let least = roots[0].min(roots[1]).min(roots[2]);
        for r in roots {
            parents[r as usize] = least;
        }
    }
    let mut places: BTreeMap<u32, usize> = BTreeMap::new();
    let mut new_index: Vec<u32> = vec![u32::MAX; mesh.vertices.len()];
    let mut found: Vec<Mesh> = Vec::new();
    for t in &mesh.triangles {
        let place = *places.entry(root(&mut parents, t[0])).or_insert(found.len());
        if place == found.len() {
            found.push(Mesh::default());
        }
        let part = &mut found[place];
        let t = t.map(|v| {
            let new_index = &mut new_index[v as usize];
            if *new_index == u32::MAX {
                *new_index = part.vertices.len() as u32;
                part.vertices.push(mesh.vertices[v as usize]);
            }
            *new_index
        });
        part.triangles.push(t);
    }
    for part in &mut found {
        part.closed = is_closed(&part.vertices, &part.triangles);
    }
    found
}

/// Components of a welded mesh in which two faces meet at each edge, each with consistently oriented faces.
///
/// An edge of four faces is where two bodies touch; they are separated there.
pub(crate) fn shells(mesh: &Mesh) -> Vec<Mesh> {
    let mut around: BTreeMap<[u32; 2], Vec<usize>> = BTreeMap::new();
    let edges = |t: &[u32; 3]| [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]];
    for (k, t) in mesh.triangles.iter().enumerate() {
        edges(t).into_iter().for_each(|[a, b]| around.entry([a.min(b), a.max(b)]).or_default().push(k));
    }
    let mut turned: Vec<Option<bool>> = vec![None; mesh.triangles.len()];
    let mut found = Vec::new();
    for first in 0..mesh.triangles.len() {
        if turned[first].is_some() {
            continue;
        }
        turned[first] = Some(false);
        let (mut waiting, mut own) = (vec![first], Vec::new());
        while let Some(at) = waiting.pop() {
            let is_turned = turned[at] == Some(true);
            let mut t = mesh.triangles[at];
            if is_turned {
                t.swap(1, 2);
            }
            own.push(t);
            for [a, b] in edges(&t) {
                let [x, y] = around[&[a.min(b), a.max(b)]][..] else { continue };
                let next = if x == at { y } else { x };
                if turned[next].is_none() {
                    // Consistently oriented neighbours use their edge in opposite directions.
                    turned[next] = Some(edges(&mesh.triangles[next]).contains(&[a, b]));
                    waiting.push(next);
                }
            }
        }
        found.push(part_of(mesh, own));
    }
    found
}

/// The mesh of some triangles, with the vertices that they use.
fn part_of(mesh: &Mesh, triangles: Vec<[u32; 3]>) -> Mesh {
    let mut new_index: BTreeMap<u32, u32> = BTreeMap::new();
    let mut part = Mesh::default();
    for t in triangles {
        let t = t.map(|v| {
            *new_index.entry(v).or_insert_with(|| {
                part.vertices.push(mesh.vertices[v as usize]);
                part.vertices.len() as u32 - 1
            })
        });
        part.triangles.push(t);
    }
    part.closed = is_closed(&part.vertices, &part.triangles);
    part
}

/// Root of a vertex in the union-find forest, with path compression.
fn root(parents: &mut [u32], mut vertex: u32) -> u32 {
    while parents[vertex as usize] != vertex {
        let above = parents[parents[vertex as usize] as usize];
        parents[vertex as usize] = above;
        vertex = above;
    }
    vertex
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::cuboid;

    #[test]
    fn two_boxes_apart_are_two_parts_and_corners_are_welded() {
        let (mut v, mut t) = cuboid([0; 3], [10; 3]);
        let (w, s) = cuboid([20; 3], [30; 3]);
        t.extend(s.iter().map(|t| t.map(|k| k + v.len() as u32)));
        v.extend(w);
        // The first triangle gets corners of its own.
        let own: Vec<[i32; 3]> = t[0].iter().map(|k| v[*k as usize]).collect();
        t[0] = [0, 1, 2].map(|k| v.len() as u32 + k);
        v.extend(own);
        let welded = Mesh::welded(MeshView { vertices: &v, triangles: &t, closed: true });
        assert_eq!(welded.vertices.len(), 16);
        let parts = components(&welded);
        assert_eq!(parts.len(), 2);
        assert!(parts.iter().all(|p| p.closed && p.triangles.len() == 12));
        assert_eq!(Mesh::joined(parts).triangles.len(), 24);
    }

    #[test]
    fn boxes_that_touch_along_an_edge_and_look_both_ways_are_two_closed_shells() {
        let (mut v, mut t) = cuboid([0; 3], [10; 3]);
        let (w, s) = cuboid([10, 10, 0], [20, 20, 10]);
        t.extend(s.iter().map(|t| t.map(|k| k + v.len() as u32)));
        v.extend(w);
        t[3].swap(1, 2);
        t[14].swap(0, 1);
        let welded = Mesh::welded(MeshView { vertices: &v, triangles: &t, closed: false });
        assert!(!welded.closed);
        let found = shells(&welded);
        assert_eq!(found.len(), 2);
        assert!(found.iter().all(|p| p.closed && p.view().volume_m3().abs() > 0.9e-9));
    }
}
