//! Closedness and convexity of meshes on the lattice of files.

use crate::lattice_hull::{LATTICE_PER_M, LatticeHull, lattice_hull};
use crate::piece::{Hull, length, sub};
use std::collections::BTreeMap;

/// Error of a corner that is rounded to the lattice, in metres.
const ROUNDED_M: f64 = 2.0 / LATTICE_PER_M;

/// Least share of its hull that a convex mesh fills: thin plates lose a little by rounding.
const MIN_FILL: f64 = 0.98;

/// True if a mesh is closed however readers split its faces, of one piece, outward, and convex except for rounding.
///
/// Faces are counter-clockwise from outside. Each edge is used once in each direction, and two faces have an edge, a corner
/// or nothing in common; no corner lies before a face, no face bends inward, and the mesh fills the hull of its corners.
pub fn is_closed_and_convex(vertices: &[[i64; 3]], faces: &[Vec<u32>]) -> bool {
    is_closed(vertices.len(), faces) && is_convex(&in_metres(vertices, faces)) && fills_its_hull(vertices, faces)
}

/// How far the corners of a mesh lie before its faces at most, in metres: the depth of the dents that its hull closes.
///
/// Faces narrower than the rounding of corners have no plane.
pub fn dents_m(vertices: &[[i64; 3]], faces: &[Vec<u32>]) -> f64 {
    let hull = in_metres(vertices, faces);
    let planes = hull.planes().filter(|plane| plane.width_m > ROUNDED_M);
    let depth_m = planes.flat_map(|plane| hull.vertices_m.iter().map(move |v| plane.before_m(*v)));
    depth_m.fold(0.0, f64::max)
}

/// The mesh with corners in metres from its first corner, so that differences keep their digits.
fn in_metres(vertices: &[[i64; 3]], faces: &[Vec<u32>]) -> Hull {
    let first = vertices.first().copied().unwrap_or_default();
    let metres = |v: &[i64; 3]| [0, 1, 2].map(|k| (v[k] - first[k]) as f64 / LATTICE_PER_M);
    Hull { vertices_m: vertices.iter().map(metres).collect(), faces: faces.to_vec() }
}

fn is_closed(n_vertices: usize, faces: &[Vec<u32>]) -> bool {
    let mut left_of: BTreeMap<(u32, u32), usize> = BTreeMap::new();
    let mut around: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
    for (at, face) in faces.iter().enumerate() {
        if face.len() < 3 {
            return false;
        }
        for (a, b) in face.iter().zip(face.iter().cycle().skip(1)) {
            let is_new = left_of.insert((*a, *b), at).is_none();
            let here = around.entry(*a).or_default();
            if a == b || !is_new || here.last() == Some(&at) {
                return false;
            }
            here.push(at);
        }
    }
    if !left_of.keys().all(|(a, b)| left_of.contains_key(&(*b, *a))) {
        return false;
    }
    // Each edge is all that its two faces share, and no other two faces share two corners.
    let mut shared: BTreeMap<(usize, usize), usize> = BTreeMap::new();
    for here in around.values() {
        for (k, a) in here.iter().enumerate() {
            here[k + 1..].iter().for_each(|b| *shared.entry((*a, *b)).or_default() += 1);
        }
    }
    let n_edges = left_of.len() / 2;
    let n_neighbours = shared.values().filter(|n| **n == 2).count();
    shared.values().all(|n| *n <= 2)
        && n_neighbours == n_edges
        && around.len() == n_vertices
        && n_vertices + faces.len() == n_edges + 2
}

fn is_convex(hull: &Hull) -> bool {
    let [low, high] = hull.bounds_m();
    let extent_m = length(sub(high, low));
    hull.faces.iter().all(|face| {
        let Some(plane) = hull.plane_of(face) else { return true };
        // The plane of a narrow face is known less well.
        let max_m = (1.0 + extent_m / plane.width_m) * ROUNDED_M;
        let corner = |k: usize| hull.vertices_m[face[k % face.len()] as usize];
        let bulges = (0..face.len()).map(|k| plane.bulge_m([corner(k), corner(k + 1), corner(k + 2)]));
        bulges.fold(f64::INFINITY, f64::min) >= -ROUNDED_M
            && hull.vertices_m.iter().all(|v| plane.before_m(*v) <= max_m)
    })
}

fn fills_its_hull(vertices: &[[i64; 3]], faces: &[Vec<u32>]) -> bool {
    let Some(LatticeHull { vertices: corners, triangles }) = lattice_hull(vertices) else { return false };
    let triangles: Vec<Vec<u32>> = triangles.iter().map(|t| t.to_vec()).collect();
    let hull_m3 = in_metres(&corners, &triangles).volume_m3();
    in_metres(vertices, faces).volume_m3() >= MIN_FILL * hull_m3
}

#[cfg(test)]
mod tests {
    use super::*;

    const CUBE: [[u32; 4]; 6] = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];

    fn cube() -> (Vec<[i64; 3]>, Vec<Vec<u32>>) {
        let corner = |bits: i64| [bits & 1, bits >> 1 & 1, bits >> 2 & 1].map(|c| c * 100_000);
        ((0..8).map(corner).collect(), CUBE.map(|f| f.to_vec()).to_vec())
    }

    #[test]
    fn a_cube_is_sound_and_one_that_is_open_turned_dented_or_doubled_is_not() {
        let (vertices, faces) = cube();
        assert!(is_closed_and_convex(&vertices, &faces));
        assert!(!is_closed_and_convex(&vertices, &faces[1..]), "open");
        let inward: Vec<Vec<u32>> = faces.iter().map(|f| f.iter().rev().copied().collect()).collect();
        assert!(!is_closed_and_convex(&vertices, &inward), "inward");
        let mut turned = faces.clone();
        turned[0].reverse();
        assert!(!is_closed_and_convex(&vertices, &turned), "one face inward");
        let mut dented = vertices.clone();
        dented[7] = [30_000; 3];
        assert!(!is_closed_and_convex(&dented, &faces), "dented");
        let doubled = [faces.clone(), faces.clone()].concat();
        assert!(!is_closed_and_convex(&vertices, &doubled), "doubled");
        let mut loose = vertices.clone();
        loose.push([1, 2, 3]);
        assert!(!is_closed_and_convex(&loose, &faces), "a corner of no face");
    }

    #[test]
    fn a_face_that_has_a_corner_twice_or_two_faces_that_share_more_than_an_edge_are_not_sound() {
        // A pillow: two squares back to back.
        let square = vec![[0, 0, 0], [9, 0, 0], [9, 9, 0], [0, 9, 1]];
        assert!(!is_closed_and_convex(&square, &[vec![0, 1, 2, 3], vec![3, 2, 1, 0]]));
        let (vertices, mut faces) = cube();
        faces[0] = vec![0, 2, 3, 1, 3, 2];
        assert!(!is_closed_and_convex(&vertices, &faces));
    }
}
