//! Convex plates under the faces of ground: for engines that fill the hull of a mesh, and for doors that swing over it.
//!
//! The outer side of a plate is a face, or several in one plane, to a millimetre. Behind faces up to 60 degrees steep it goes straight
//! down or up, so that neighbours share their sides; behind others along the normal.

use convex::{Hull, convex_partition};
use frames::metres;
use geometry::{FillRule, Plane, Ring, ring_area_doubled, union, unit_normal};
use std::collections::BTreeMap;

/// How deep plates go: not farther than maps and worlds agree, where that is behind a body's other side or the edge of a wall.
const DEPTH_M: f64 = 0.02;

/// Cosine of the steepest slope of plates that go straight down or up.
const STEEP: f64 = 0.5;

/// Corners this near to a plane, in tenths of a millimetre, lie in it.
const FLAT: f64 = 10.0;

/// Narrower faces have no plate: engines refuse bodies without volume, and nothing falls through a gap of a millimetre.
const MIN_WIDTH: f64 = 10.0;

type Triangle = [[i32; 3]; 3];

/// The plates of faces, outward, in tenths of a millimetre.
pub(crate) fn plates(faces: &[Triangle]) -> Vec<Hull> {
    let wide = faces.iter().filter(|t| width(&t.map(|v| v.map(f64::from))) >= MIN_WIDTH);
    let normals = wide.filter_map(|t| Some((unit_normal(t)?, t)));
    let (gentle, steep): (Vec<_>, Vec<_>) = normals.partition(|(normal, _)| normal[2].abs() >= STEEP);
    let mut found = Vec::new();
    for sense in [1.0, -1.0] {
        let same_side = gentle.iter().filter(|(normal, _)| normal[2] * sense > 0.0);
        for same in by_plane(same_side.map(|(_, t)| **t)) {
            add_gentle(&same, sense, &mut found);
        }
    }
    found.extend(
        steep.into_iter().map(|(normal, t)| plate(t.map(|v| v.map(metres)).to_vec(), normal.map(|c| -c * DEPTH_M))),
    );
    found
}

/// Faces that may be in one plane, in the order of their first ones.
fn by_plane(faces: impl Iterator<Item = Triangle>) -> Vec<Vec<Triangle>> {
    let mut groups: Vec<Vec<Triangle>> = Vec::new();
    let mut known: BTreeMap<[i64; 3], usize> = BTreeMap::new();
    let mut origin = None;
    for face in faces {
        let plane = Plane::of(&face);
        let origin = *origin.get_or_insert([face[0][0], face[0][1]].map(f64::from));
        let at = *known.entry(plane.key(origin)).or_insert_with(|| {
            groups.push(Vec::new());
            groups.len() - 1
        });
        groups[at].push(face);
    }
    groups
}

/// Adds the plates of gentle faces that may be in one plane; `sense` is 1 if they look up, -1 if down.
fn add_gentle(faces: &[Triangle], sense: f64, found: &mut Vec<Hull>) {
    let Some(largest) = faces.iter().max_by_key(|t| plan_area_doubled(t)) else { return };
    let plane = Plane::of(largest);
    let height = |p: [i32; 2]| plane.z(p.map(f64::from));
    let lies_in = |t: &&Triangle| t.iter().all(|v| (height([v[0], v[1]]) - f64::from(v[2])).abs() <= FLAT);
    let (same, others): (Vec<&Triangle>, Vec<&Triangle>) = faces.iter().partition(lies_in);
    let inward_m = [0.0, 0.0, -sense * DEPTH_M];
    found.extend(others.into_iter().map(|t| plate(t.map(|v| v.map(metres)).to_vec(), inward_m)));
    if let [only] = same.as_slice() {
        found.push(plate(only.map(|v| v.map(metres)).to_vec(), inward_m));
        return;
    }
    let rings: Vec<Ring> = same.iter().map(|t| t.map(|v| [v[0], v[1]]).to_vec()).collect();
    for ring in convex_partition(&union(&rings, FillRule::NonZero)) {
        let scale = metres(1);
        let mut top: Vec<[f64; 3]> = ring.iter().map(|p| [metres(p[0]), metres(p[1]), height(*p) * scale]).collect();
        if sense < 0.0 {
            top.reverse();
        }
        found.push(plate(top, inward_m));
    }
}

fn plan_area_doubled(t: &Triangle) -> i128 {
    ring_area_doubled(&t.map(|v| [v[0], v[1]])).abs()
}

/// The least height of a triangle.
fn width(t: &[[f64; 3]; 3]) -> f64 {
    let side = |k: usize| [0, 1, 2].map(|i| t[(k + 1) % 3][i] - t[k][i]);
    let [u, v, w] = [0, 1, 2].map(side);
    let length = |v: [f64; 3]| v.iter().map(|c| c * c).sum::<f64>().sqrt();
    let normal = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    let longest = [u, v, w].map(length).into_iter().fold(0.0, f64::max);
    if longest > 0.0 { length(normal) / longest } else { 0.0 }
}

/// The body between a convex face, counter-clockwise from outside, and the same face moved inward.
fn plate(top: Vec<[f64; 3]>, inward_m: [f64; 3]) -> Hull {
    let n = top.len() as u32;
    let moved = |p: &[f64; 3]| [0, 1, 2].map(|k| p[k] + inward_m[k]);
    let bottom: Vec<[f64; 3]> = top.iter().map(moved).collect();
    let mut faces: Vec<Vec<u32>> = vec![(0..n).collect(), (n..2 * n).rev().collect()];
    faces.extend((0..n).map(|k| vec![(k + 1) % n, k, n + k, n + (k + 1) % n]));
    Hull { vertices_m: top.into_iter().chain(bottom).collect(), faces }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::meshes::Solid;
    use convex::is_closed_and_convex;
    use proptest::prelude::*;

    /// Squares of a field of heights, two triangles each, 2 m wide.
    fn field(heights: &[[i32; 4]; 4]) -> Vec<Triangle> {
        let at = |x: usize, y: usize| [x as i32 * 20_000, y as i32 * 20_000, heights[y][x]];
        let squares = (0..3).flat_map(|y| (0..3).map(move |x| (x, y)));
        let halves = |(x, y)| [[at(x, y), at(x + 1, y), at(x + 1, y + 1)], [at(x, y), at(x + 1, y + 1), at(x, y + 1)]];
        squares.flat_map(halves).collect()
    }

    /// Height of the highest of convex bodies over a place; `None` beside them.
    fn top(hulls: &[Hull], [x, y]: [f64; 2]) -> Option<f64> {
        let faces = hulls
            .iter()
            .flat_map(|h| h.faces.iter().map(move |f| f.iter().map(|k| h.vertices_m[*k as usize]).collect::<Vec<_>>()));
        let over = |f: Vec<[f64; 3]>| {
            (1..f.len() - 1).find_map(|k| {
                let [a, b, c] = [f[0], f[k], f[k + 1]];
                let area = |p: [f64; 3], q: [f64; 3], r: [f64; 3]| {
                    (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0])
                };
                let (whole, p) = (area(a, b, c), [x, y, 0.0]);
                let shares = [area(p, b, c), area(a, p, c), area(a, b, p)].map(|part| part / whole);
                let is_in = whole.abs() > 1e-9 && shares.iter().all(|s| *s >= -1e-9);
                is_in.then(|| shares[0] * a[2] + shares[1] * b[2] + shares[2] * c[2])
            })
        };
        faces.filter_map(over).max_by(f64::total_cmp)
    }

    #[test]
    fn a_level_field_with_a_hole_is_few_plates() {
        let mut faces = field(&[[1_000; 4]; 4]);
        faces.drain(8..10);
        let found = plates(&faces);
        assert!(found.len() <= 4, "{}", found.len());
        assert_eq!(top(&found, [0.7, 0.9]), Some(0.1));
        assert_eq!(top(&found, [3.0, 3.0]), None);
    }

    #[test]
    fn a_wall_has_a_plate_behind_it_and_a_sliver_none() {
        let found = plates(&[[[0, 0, 0], [10_000, 0, 0], [0, 0, 10_000]]]);
        // Seen from -y it is counter-clockwise: what is behind it lies towards +y.
        let [low, high] = found[0].bounds_m();
        assert!((low[1], high[1]) == (0.0, DEPTH_M), "{low:?} {high:?}");
        assert!(plates(&[[[0, 0, 0], [10_000, 0, 0], [0, 9, 0]]]).is_empty());
    }

    proptest! {
        #[test]
        fn plates_are_convex_and_their_top_is_the_surface(
            heights in prop::array::uniform4(prop::array::uniform4(prop::sample::select(vec![0, 0, 0, 300, 4_000, 25_000]))),
            places in prop::collection::vec(prop::array::uniform2(0.0..6.0_f64), 20),
        ) {
            let faces = field(&heights);
            let found = plates(&faces);
            for hull in &found {
                let solid = Solid::of_piece(hull);
                prop_assert!(is_closed_and_convex(&solid.vertices, &solid.faces), "{:?}", hull);
            }
            for place in places {
                let units = place.map(|c| c * 10_000.0);
                let surface = faces.iter().find(|t| {
                    (0..3).all(|k| {
                        let [a, b] = [t[k], t[(k + 1) % 3]].map(|v| v.map(f64::from));
                        (b[0] - a[0]) * (units[1] - a[1]) - (b[1] - a[1]) * (units[0] - a[0]) >= 0.0
                    })
                });
                let expected = Plane::of(surface.unwrap()).z(units) / 10_000.0;
                // Behind a steep face its plate may reach through a neighbour. Of the steepest of these, 60.5 degrees, on both sides of a
                // ridge, it reaches (sin * tan - cos) = 1.05 times its thickness above it.
                let off = top(&found, place).unwrap() - expected;
                prop_assert!((-0.001..=1.05 * DEPTH_M).contains(&off), "{} at {:?}", off, place);
            }
        }
    }
}
