//! Convex pieces of element bodies; bodies that differ by a translation share one decomposition.

use convex::{Piece, PieceOptions, convex_pieces};
use frames::metres;
use geometry::{BodyShape, MeshView};
use rayon::prelude::*;
use std::collections::HashMap;

/// The convex pieces of each body.
pub(super) fn pieces_of<'a>(
    bodies: impl Iterator<Item = Vec<MeshView<'a>>>,
    options: &PieceOptions,
) -> Vec<Vec<Piece>> {
    let bodies: Vec<BodyShape<'a>> = bodies.map(BodyShape).collect();
    let mut first: HashMap<&BodyShape<'_>, usize> = HashMap::new();
    let mut cut: Vec<&BodyShape<'_>> = Vec::new();
    let which: Vec<usize> = bodies
        .iter()
        .map(|body| {
            *first.entry(body).or_insert_with(|| {
                cut.push(body);
                cut.len() - 1
            })
        })
        .collect();
    let pieces: Vec<Vec<Piece>> = cut.par_iter().map(|body| convex_pieces(body.0.iter().copied(), options)).collect();
    let moved = |(body, which): (&BodyShape<'_>, usize)| {
        let [from, to] = [cut[which], body].map(BodyShape::origin);
        let shift_m = [0, 1, 2].map(|k| metres(to[k]) - metres(from[k]));
        pieces[which].iter().map(|p| p.shifted(shift_m)).collect()
    };
    bodies.iter().zip(which).map(moved).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::options::WorldOptions;

    #[test]
    fn copies_have_the_pieces_of_the_first_where_they_stand_and_others_their_own() {
        let triangles = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
        let body = |at: i32, height: i32| [[at, 0, 0], [at + 10_000, 0, 0], [at, 10_000, 0], [at, 0, height]];
        let corners = [body(0, 5_000), body(70_000, 5_000), body(70_000, 6_000)];
        let meshes = corners.iter().map(|vertices| vec![MeshView { vertices, triangles: &triangles, closed: true }]);
        let options = WorldOptions::default().piece_options();
        let found = pieces_of(meshes, &options);
        let bounds = |k: usize| found[k][0].shape.hull().bounds_m();
        assert_eq!(bounds(0), [[0.0; 3], [1.0, 1.0, 0.5]]);
        assert_eq!(bounds(1), [[7.0, 0.0, 0.0], [8.0, 1.0, 0.5]]);
        assert_eq!(bounds(2), [[7.0, 0.0, 0.0], [8.0, 1.0, 0.6]]);
    }
}
