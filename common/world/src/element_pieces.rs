//! Convex pieces of element bodies; bodies that differ by a translation share one decomposition.

use convex::{Piece, PieceOptions, convex_pieces};
use frames::metres;
use geometry::MeshView;
use rayon::prelude::*;
use std::collections::HashMap;
use std::hash::{Hash, Hasher};

/// A body; bodies are equal if they differ by a translation only.
struct ElementBody<'a>(Vec<MeshView<'a>>);

impl ElementBody<'_> {
    fn origin(&self) -> [i32; 3] {
        self.0.iter().flat_map(|m| m.vertices.first()).next().copied().unwrap_or_default()
    }

    fn vertices(&self) -> impl Iterator<Item = [i64; 3]> {
        let origin = self.origin().map(i64::from);
        self.0.iter().flat_map(|m| m.vertices).map(move |v| [0, 1, 2].map(|k| i64::from(v[k]) - origin[k]))
    }

    fn triangles(&self) -> impl Iterator<Item = &[[u32; 3]]> {
        self.0.iter().map(|m| m.triangles)
    }

    fn sizes(&self) -> impl Iterator<Item = (usize, bool)> {
        self.0.iter().map(|m| (m.vertices.len(), m.closed))
    }
}

impl Hash for ElementBody<'_> {
    fn hash<H: Hasher>(&self, state: &mut H) {
        self.vertices().for_each(|v| v.hash(state));
        self.triangles().for_each(|t| t.len().hash(state));
    }
}

impl PartialEq for ElementBody<'_> {
    fn eq(&self, other: &Self) -> bool {
        self.sizes().eq(other.sizes()) && self.triangles().eq(other.triangles()) && self.vertices().eq(other.vertices())
    }
}

impl Eq for ElementBody<'_> {}

/// The convex pieces of each body.
pub(super) fn pieces_of<'a>(
    bodies: impl Iterator<Item = Vec<MeshView<'a>>>,
    options: &PieceOptions,
) -> Vec<Vec<Piece>> {
    let bodies: Vec<ElementBody<'a>> = bodies.map(ElementBody).collect();
    let mut first: HashMap<&ElementBody<'_>, usize> = HashMap::new();
    let mut cut: Vec<&ElementBody<'_>> = Vec::new();
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
    let moved = |(body, which): (&ElementBody<'_>, usize)| {
        let [from, to] = [cut[which], body].map(ElementBody::origin);
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
