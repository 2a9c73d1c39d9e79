//! Reduces the number of convex pieces of a body by merging neighbours into their convex hulls.

use crate::components::Mesh;
use crate::hulls::{ComparedBody, hull_of, longest_m, sides_m};
use crate::options::PieceOptions;
use crate::piece::{FacePlane, Hull, Made, Piece, Shape, cross, length, sub};
use geometry::unit_normal;

/// Maximum distance in metres of points inside a hull from the body, so that hulls do not fill spaces in which a person
/// could stand.
const MAX_HOLLOW_M: f64 = 0.3;

/// Factor on the tolerance for bodies that bound no solid, such as foliage.
const SURFACE_FACTOR: f64 = 8.0;

/// The tolerance of the first attempt is the maximum divided by this.
const INITIAL_DIVISOR: f64 = 4.0;

/// Maximum side of a hull of several pieces, in metres, so that the samples find any doorway in it.
const MAX_MERGED_SIDE_M: f64 = 4.0;

/// A face is level up to this angle: cosine of 37 degrees.
const LEVEL: f64 = 0.8;

/// Samples along each side of a hull.
const SAMPLES_PER_SIDE: usize = 12;

/// Merges the pieces of a body, whose parts have outward faces, to at most `options.element_max`, if hulls of neighbours lie
/// within `options.joined_m` of the body; else to as few as possible.
///
/// Each attempt bisects the pieces recursively at the widest gap between their centres, until the hull of each group is near
/// enough. Ground keeps its pieces, because hulls would fill its hollows.
pub(crate) fn merge_pieces(pieces: Vec<Piece>, parts: Vec<Mesh>, options: &PieceOptions) -> Vec<Piece> {
    if pieces.len() <= options.element_max || is_ground(&parts) {
        return pieces;
    }
    let whole = Mesh::joined(parts);
    let Some(body) = ComparedBody::of(whole.view()) else { return pieces };
    let n_sheets = pieces.iter().filter(|p| p.made == Made::Sheet).count();
    let bounds_nothing = !whole.closed || whole.view().volume_m3() <= 0.0;
    let is_foliage = bounds_nothing && 2 * n_sheets > pieces.len();
    let max_m = if is_foliage { SURFACE_FACTOR * options.joined_m } else { options.joined_m };
    let mut tolerance_m = max_m / INITIAL_DIVISOR;
    loop {
        let joined = joined(&pieces, &body, tolerance_m);
        if joined.len() <= options.element_max || tolerance_m >= max_m {
            return joined;
        }
        tolerance_m = (2.0 * tolerance_m).min(max_m);
    }
}

/// True if more than half of the surface is level.
fn is_ground(parts: &[Mesh]) -> bool {
    let (mut level, mut all) = (0.0, 0.0);
    for corners in parts.iter().flat_map(|p| p.view().corners()) {
        let [a, b, c] = corners.map(|p| p.map(f64::from));
        let area = length(cross(sub(b, a), sub(c, a)));
        all += area;
        if unit_normal(&corners).is_some_and(|n| n[2].abs() > LEVEL) {
            level += area;
        }
    }
    2.0 * level > all
}

/// Merges pieces in groups whose hulls are near enough.
fn joined(pieces: &[Piece], body: &ComparedBody, tolerance_m: f64) -> Vec<Piece> {
    let middle = |p: &Piece| {
        let [low, high] = p.shape.hull().bounds_m();
        [0, 1, 2].map(|k| (low[k] + high[k]) / 2.0)
    };
    let mut out = Vec::new();
    let mut open: Vec<Vec<([f64; 3], &Piece)>> = vec![pieces.iter().map(|p| (middle(p), p)).collect()];
    while let Some(mut group) = open.pop() {
        if let [(_, only)] = group.as_slice() {
            out.push((*only).clone());
            continue;
        }
        if let Some(piece) = common_hull(&group, body, tolerance_m) {
            out.push(piece);
            continue;
        }
        let spreads = sides_m(&group.iter().map(|(middle, _)| *middle).collect::<Vec<_>>());
        let (axis, spread) = (0..3).zip(spreads).max_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or_default();
        group.sort_by(|a, b| a.0[axis].total_cmp(&b.0[axis]));
        // At the widest gap between neighbours if it is significant, else in the middle.
        let n = group.len();
        let gap = |k: usize| group[k].0[axis] - group[k - 1].0[axis];
        let widest = (1..n).max_by(|a, b| gap(*a).total_cmp(&gap(*b))).unwrap_or(1);
        let cut = if gap(widest) * 4.0 > spread { widest } else { n / 2 };
        let rest = group.split_off(cut);
        open.extend([rest, group]);
    }
    out
}

/// The hull of several pieces, if all of it lies near the body.
fn common_hull(group: &[([f64; 3], &Piece)], body: &ComparedBody, tolerance_m: f64) -> Option<Piece> {
    let points_m: Vec<[f64; 3]> = group.iter().flat_map(|(_, p)| p.shape.hull().vertices_m).collect();
    if longest_m(&points_m) > MAX_MERGED_SIDE_M {
        return None;
    }
    let hull = hull_of(&points_m)?;
    let outside_m = body.outside_up_to_m(&hull, tolerance_m)?;
    if !is_filled(&hull, body, tolerance_m.max(MAX_HOLLOW_M)) {
        return None;
    }
    let deviation_m = group.iter().map(|(_, p)| p.deviation_m).fold(outside_m, f64::max);
    Some(Piece { shape: Shape::of(hull), made: Made::Hull, deviation_m })
}

/// True if no point in a hull is farther from the body than `max_m`.
fn is_filled(hull: &Hull, body: &ComparedBody, max_m: f64) -> bool {
    let [low, high] = hull.bounds_m();
    let side = |k: usize| (high[k] - low[k]).max(1e-3);
    if (0..3).map(side).fold(f64::INFINITY, f64::min) <= 2.0 * max_m {
        return true;
    }
    let n = |k: usize| ((2.0 * side(k) / max_m).ceil() as usize).clamp(2, SAMPLES_PER_SIDE);
    let at = |k: usize, i: usize| low[k] + side(k) * (i as f64 + 0.5) / n(k) as f64;
    let planes: Vec<FacePlane> = hull.planes().collect();
    let is_inside = |p: [f64; 3]| planes.iter().all(|plane| plane.before_m(p) <= 0.0);
    (0..n(0)).all(|x| {
        (0..n(1)).all(|y| {
            (0..n(2)).all(|z| {
                let p = [at(0, x), at(1, y), at(2, z)];
                !is_inside(p) || body.outside_m(p) <= max_m
            })
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pieces::convex_pieces;
    use crate::testing::cuboid;

    const OPTIONS: PieceOptions =
        PieceOptions { tolerance_m: 0.02, worst_m: 0.1, exact_max: 64, element_max: 16, joined_m: 0.05 };

    fn mesh(boxes: &[([i32; 3], [i32; 3])]) -> Mesh {
        let part = |(min, max): &([i32; 3], [i32; 3])| {
            let (vertices, triangles) = cuboid(*min, *max);
            Mesh { vertices, triangles, closed: true }
        };
        Mesh::joined(boxes.iter().map(part).collect())
    }

    /// Posts of 4 cm at a distance.
    fn posts(n: i32, step: i32) -> Mesh {
        let post = |k: i32| ([k * step, 0, 0], [k * step + 400, 400, 10_000]);
        mesh(&(0..n).map(post).collect::<Vec<_>>())
    }

    #[test]
    fn posts_with_narrow_gaps_become_few_hulls_and_those_with_wide_gaps_stay() {
        let near = convex_pieces([posts(40, 1_300).view()], &OPTIONS);
        assert!(near.len() <= 16, "{}", near.len());
        assert!(near.iter().all(|p| p.deviation_m <= OPTIONS.joined_m));
        let far = convex_pieces([posts(40, 6_000).view()], &OPTIONS);
        assert_eq!(far.len(), 40);
        assert!(far.iter().all(|p| p.made == Made::Exact));
    }

    #[test]
    fn a_long_wall_of_many_boards_keeps_its_doorway() {
        let board = |k: i32| ([k * 10_000, 0, 0], [k * 10_000 + 10_000, 1_000, 30_000]);
        let lintel = ([200_000, 0, 21_000], [209_000, 1_000, 30_000]);
        let boxes: Vec<_> = (0..40).filter(|k| *k != 20).map(board).chain([lintel]).collect();
        let apart = boxes.into_iter().enumerate().map(|(k, (min, max))| {
            // Nearly the same planes, so that the boards are pieces of their own.
            let depth = 10 * (k as i32 % 3);
            ([min[0] + 5, min[1] + depth, min[2]], [max[0], max[1] + depth, max[2]])
        });
        let outward = mesh(&apart.collect::<Vec<_>>());
        let doorway = [20.45, 0.05, 1.0];
        let holds = |p: &Piece| p.shape.hull().planes().all(|plane| plane.before_m(doorway) <= 0.0);
        for wall in [outward.clone(), outward.flipped()] {
            let found = convex_pieces([wall.view()], &OPTIONS);
            assert!(found.len() < 40 && !found.iter().any(holds), "{}", found.len());
        }
    }

    #[test]
    fn few_pieces_stay_as_they_are() {
        let found = convex_pieces([posts(16, 1_300).view()], &OPTIONS);
        assert!(found.len() == 16 && found.iter().all(|p| p.made == Made::Exact));
    }

    #[test]
    fn a_closed_cabin_of_many_boards_stays_hollow() {
        let board = |k: i32| {
            let (from, to) = (k * 1_000, k * 1_000 + 1_000);
            [([from, 0, 0], [to, 500, 30_000]), ([from, 19_500, 0], [to, 20_000, 30_000])]
        };
        let mut boxes: Vec<_> = (0..20).flat_map(board).collect();
        boxes.extend([([0, 500, 0], [500, 19_500, 30_000]), ([19_500, 500, 0], [20_000, 19_500, 30_000])]);
        boxes.push(([0, 0, 30_000], [20_000, 20_000, 30_500]));
        let found = convex_pieces([mesh(&boxes).view()], &OPTIONS);
        let middle = [1.0, 1.0, 1.5];
        let holds = |p: &Piece| p.shape.hull().planes().all(|plane| plane.before_m(middle) <= 0.0);
        assert!(found.len() <= 16 && !found.iter().any(holds), "{}", found.len());
    }

    #[test]
    fn ground_keeps_its_pieces() {
        let steps: Vec<_> =
            (0..40).map(|k| ([k * 5_000, 0, -1_000], [k * 5_000 + 5_000, 50_000, 900 * (k % 2)])).collect();
        let found = convex_pieces([mesh(&steps).view()], &OPTIONS);
        assert!(found.len() > OPTIONS.element_max && found.iter().all(|p| p.made == Made::Exact));
    }
}
