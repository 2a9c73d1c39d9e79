//! Points of bodies that are seen: not within another body nor touched by one, each once, with normals that look outwards.

use crate::error::CloudError;
use crate::lattice::{Meeting, Seen};
use crate::options::CloudOptions;
use crate::point::Point;
use geometry::{MeshView, unit_normal};
use rayon::prelude::*;

/// How far in front of a point it has to be clear, in tenths of a millimetre.
const CLEAR_TENTHS: i32 = 50;
/// Faces that look the same way and lie this near to each other are one, in tenths of a millimetre.
const SAME_TENTHS: i32 = 10;

/// A mesh part of an element.
pub(crate) struct Body<'a> {
    /// Its triangles.
    pub(crate) mesh: MeshView<'a>,
    /// Index of the element among those that have points.
    pub(crate) element: u32,
    /// Class id.
    pub(crate) class: u8,
}

/// A triangle that is not seen edge on.
struct Face {
    body: u32,
    /// +1 if it looks along the axis, else -1.
    sign: i8,
    /// True if no other axis sees more of it.
    has_points: bool,
    /// Unit normal as it is wound.
    normal: [f32; 3],
}

/// A line of the lattice meets a face.
struct Met {
    meeting: Meeting,
    face: u32,
}

/// A stretch of a line within a closed body.
struct Inside {
    body: u32,
    from: i32,
    to: i32,
}

/// A point that a face may have.
struct Candidate {
    depth: i32,
    /// The side that it looks to along the axis.
    looks: i32,
    face: u32,
}

/// The points of bodies along all three axes.
///
/// # Errors
/// Too many of them.
pub(crate) fn points(bodies: &[Body<'_>], options: &CloudOptions) -> Result<Vec<Point>, CloudError> {
    check_number(bodies, options)?;
    Ok((0..3).flat_map(|axis| points_along(bodies, axis, options.half_spacing_tenths)).collect())
}

/// Triangles of a mesh by their corners.
fn triangles<'a>(mesh: &MeshView<'a>) -> impl Iterator<Item = [[i32; 3]; 3]> + use<'a> {
    let MeshView { vertices, triangles, .. } = *mesh;
    triangles.iter().map(move |corners| corners.map(|k| vertices[k as usize]))
}

/// Refuses more points than a cloud may have, by the area of the faces.
fn check_number(bodies: &[Body<'_>], options: &CloudOptions) -> Result<(), CloudError> {
    let spacing_m = options.spacing_m();
    let area_seen = |triangle: [[i32; 3]; 3]| {
        let side = |k: usize| [0, 1, 2].map(|i| f64::from(triangle[k][i]) - f64::from(triangle[0][i]));
        let (u, v) = (side(1), side(2));
        let n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
        n.map(f64::abs).into_iter().fold(0.0, f64::max) / 2.0
    };
    let area: f64 = bodies
        .par_iter()
        .map(|body| triangles(&body.mesh).map(area_seen).sum::<f64>())
        .collect::<Vec<_>>()
        .iter()
        .sum();
    let spacing = f64::from(2 * options.half_spacing_tenths);
    let points = (area / (spacing * spacing)) as u64;
    if points > CloudOptions::MAX_POINTS { Err(CloudError::TooManyPoints { points, spacing_m }) } else { Ok(()) }
}

/// Points of the faces that are best seen along an axis.
fn points_along(bodies: &[Body<'_>], axis: usize, half: i32) -> Vec<Point> {
    let (mut faces, mut met) = (Vec::new(), Vec::new());
    for (body, Body { mesh, .. }) in bodies.iter().enumerate() {
        for triangle in triangles(mesh) {
            let Some((seen, sign)) = Seen::of(triangle, axis) else { continue };
            let Some(normal) = unit_normal(&triangle) else { continue };
            let face = faces.len() as u32;
            let has_points = steepest(normal) == axis;
            seen.meet(half, |meeting| met.push(Met { meeting, face }));
            faces.push(Face { body: body as u32, sign, has_points, normal: normal.map(|n| n as f32) });
        }
    }
    let order = |met: &Met| (met.meeting.line, faces[met.face as usize].body, met.meeting.depth, met.face);
    met.par_sort_unstable_by_key(order);
    let lines: Vec<&[Met]> = met.chunk_by(|a, b| a.meeting.line == b.meeting.line).collect();
    let point = |(line, candidate): ([i32; 2], Candidate)| {
        let Face { body, normal, .. } = faces[candidate.face as usize];
        let Body { element, class, .. } = bodies[body as usize];
        let mut at_tenths = [0; 3];
        at_tenths[axis] = candidate.depth;
        (at_tenths[(axis + 1) % 3], at_tenths[(axis + 2) % 3]) = ((2 * line[0] + 1) * half, (2 * line[1] + 1) * half);
        let is_inwards = (normal[axis] > 0.0) != (candidate.looks > 0);
        Point { at_tenths, normal: if is_inwards { normal.map(|n| 0.0 - n) } else { normal }, class, element }
    };
    let seen = |met: &&[Met]| {
        let line = met[0].meeting.line;
        seen_on_line(met, &faces, bodies).into_iter().map(move |candidate| (line, candidate)).collect::<Vec<_>>()
    };
    lines.par_iter().flat_map_iter(seen).map(point).collect()
}

/// The axis along which most of a face is seen; of equal ones the first.
fn steepest(normal: [f64; 3]) -> usize {
    let [x, y, z] = normal.map(f64::abs);
    if x >= y && x >= z {
        0
    } else if y >= z {
        1
    } else {
        2
    }
}

/// What is seen on a line; its meetings are sorted by body and depth.
fn seen_on_line(met: &[Met], faces: &[Face], bodies: &[Body<'_>]) -> Vec<Candidate> {
    let (mut insides, mut candidates) = (Vec::new(), Vec::new());
    for of_body in met.chunk_by(|a, b| faces[a.face as usize].body == faces[b.face as usize].body) {
        let body = faces[of_body[0].face as usize].body;
        let is_closed = bodies[body as usize].mesh.closed;
        // Of a surface with gaps or with faces that are wound either way, a line that has no gap goes in and out by turns.
        let goes_through = of_body.len().is_multiple_of(2);
        let (mut depth_of_body, mut from) = (0i32, 0);
        for (place, Met { meeting, face }) in of_body.iter().enumerate() {
            let Face { sign, has_points, .. } = faces[*face as usize];
            let (before, depth) = (depth_of_body, meeting.depth);
            depth_of_body -= i32::from(sign);
            let looks = match (before == 0, depth_of_body == 0) {
                _ if !is_closed && goes_through => {
                    if place.is_multiple_of(2) {
                        -1
                    } else {
                        1
                    }
                }
                _ if !is_closed => i32::from(sign),
                (true, _) => {
                    from = depth;
                    -1
                }
                (false, true) => {
                    insides.push(Inside { body, from, to: depth });
                    1
                }
                // A face within the body.
                (false, false) => continue,
            };
            if has_points {
                candidates.push(Candidate { depth, looks, face: *face });
            }
        }
    }
    let is_hidden = |candidate: &Candidate| {
        let (body, front) =
            (faces[candidate.face as usize].body, candidate.depth.saturating_add(candidate.looks * CLEAR_TENTHS));
        insides.iter().any(|inside| inside.body != body && inside.from < front && front < inside.to)
    };
    candidates.retain(|candidate| !is_hidden(candidate));
    candidates.sort_by_key(|candidate| (candidate.looks, candidate.depth, candidate.face));
    candidates.dedup_by(|next, kept| next.looks == kept.looks && next.depth - kept.depth <= SAME_TENTHS);
    candidates
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// A box between two corners, wound outwards or inwards.
    #[derive(Debug, Clone)]
    struct Block {
        vertices: Vec<[i32; 3]>,
        triangles: Vec<[u32; 3]>,
        low: [i32; 3],
        high: [i32; 3],
    }

    fn block(low: [i32; 3], high: [i32; 3], is_inwards: bool) -> Block {
        let corner = |k: usize| [0, 1, 2].map(|axis| if k >> axis & 1 == 0 { low[axis] } else { high[axis] });
        let quads = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
        let mut triangles: Vec<[u32; 3]> = quads.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect();
        if is_inwards {
            triangles.iter_mut().for_each(|t| t.swap(1, 2));
        }
        Block { vertices: (0..8).map(corner).collect(), triangles, low, high }
    }

    fn points_of(blocks: &[Block], spacing_m: f64) -> Vec<Point> {
        let bodies: Vec<Body<'_>> = blocks
            .iter()
            .enumerate()
            .map(|(element, block)| Body {
                mesh: MeshView {
                    vertices: &block.vertices,
                    triangles: &block.triangles,
                    closed: geometry::is_closed(&block.vertices, &block.triangles),
                },
                element: element as u32,
                class: 1,
            })
            .collect();
        points(&bodies, &CloudOptions::of(Some(spacing_m), &[]).unwrap()).unwrap()
    }

    #[test]
    fn a_block_has_points_on_its_six_faces_that_look_outwards_however_it_is_wound() {
        for is_inwards in [false, true] {
            let points = points_of(&[block([0, 0, 0], [10_000, 20_000, 30_000], is_inwards)], 0.1);
            // 1 m by 2 m by 3 m, 10 cm apart.
            assert_eq!(points.len(), 2 * (10 * 20 + 20 * 30 + 10 * 30));
            for Point { at_tenths, normal, .. } in &points {
                let axis = (0..3).find(|axis| normal[*axis] != 0.0).unwrap();
                let high = [10_000, 20_000, 30_000][axis];
                assert!(at_tenths[axis] == if normal[axis] > 0.0 { high } else { 0 }, "{at_tenths:?} {normal:?}");
            }
        }
    }

    #[test]
    fn faces_that_touch_are_not_seen_and_coincident_ones_count_once() {
        let first = block([0, 0, 0], [10_000; 3], false);
        let beside = block([10_000, 0, 0], [20_000, 10_000, 10_000], false);
        assert_eq!(points_of(&[first.clone(), beside], 0.1).len(), 10 * 100, "as one block of twice the length");
        let twice = points_of(&[first.clone(), first.clone()], 0.1);
        assert_eq!(twice, points_of(&[first], 0.1), "of the first element");
    }

    #[test]
    fn a_surface_that_bounds_nothing_hides_nothing() {
        let wall = block([0, 0, 0], [10_000; 3], false);
        let mut open = block([10_000, -10_000, -10_000], [20_000; 3], false);
        open.triangles.remove(0);
        let of_wall = points_of(&[wall.clone(), open], 0.1).iter().filter(|point| point.element == 0).count();
        assert_eq!(of_wall, points_of(&[wall], 0.1).len());
    }

    #[test]
    fn a_block_of_which_faces_are_wound_either_way_looks_outwards_all_the_same() {
        let whole = block([0, 0, 0], [10_000; 3], false);
        let mut mixed = whole.clone();
        mixed.triangles.iter_mut().step_by(3).for_each(|t| t.swap(1, 2));
        let seen = |block: Block| {
            points_of(&[block], 0.1).iter().map(|p| (p.at_tenths, p.normal.map(|n| n as i32))).collect::<Vec<_>>()
        };
        assert_eq!(seen(mixed), seen(whole));
    }

    #[test]
    fn more_points_than_a_cloud_may_have_are_refused_before_they_are_made() {
        let ground = block([0, 0, 0], [10_000_000, 10_000_000, 1_000], false);
        let bodies = [Body {
            mesh: MeshView { vertices: &ground.vertices, triangles: &ground.triangles, closed: true },
            element: 0,
            class: 10,
        }];
        let why = points(&bodies, &CloudOptions::of(Some(0.05), &[]).unwrap()).map(drop).unwrap_err().to_string();
        assert!(why.starts_with("the cloud would have about 8001600") && why.contains("a larger spacing"), "{why}");
    }

    proptest! {
        #[test]
        fn what_is_seen_is_what_no_other_block_covers(
            blocks in proptest::collection::vec(
                (proptest::array::uniform3(-20i32..20), proptest::array::uniform3(1i32..15), any::<bool>()), 1..5),
        ) {
            // Corners lie on whole decimetres, points in the middle between them.
            let blocks: Vec<Block> = blocks.into_iter().map(|(low, size, is_inwards)| {
                let low = low.map(|c| c * 1_000);
                block(low, [0, 1, 2].map(|k| low[k] + size[k] * 1_000), is_inwards)
            }).collect();
            let mut seen: Vec<([i32; 3], [i32; 3], u32)> = points_of(&blocks, 0.1).iter()
                .map(|point| (point.at_tenths, point.normal.map(|n| n as i32), point.element)).collect();
            let mut wanted = Vec::new();
            let mut had = std::collections::BTreeSet::new();
            for (element, Block { low, high, .. }) in blocks.iter().enumerate() {
                for axis in 0..3 {
                    let [b, c] = [(axis + 1) % 3, (axis + 2) % 3];
                    for (side, looks) in [(low[axis], -1), (high[axis], 1)] {
                        for u in (low[b] + 500..high[b]).step_by(1_000) {
                            for v in (low[c] + 500..high[c]).step_by(1_000) {
                                let (mut at, mut normal) = ([0; 3], [0; 3]);
                                (at[axis], at[b], at[c], normal[axis]) = (side, u, v, looks);
                                let mut front = at;
                                front[axis] += 50 * looks;
                                let is_within = |other: &Block| (0..3).all(|k| other.low[k] < front[k] && front[k] < other.high[k]);
                                if !blocks.iter().any(is_within) && had.insert((at, normal)) {
                                    wanted.push((at, normal, element as u32));
                                }
                            }
                        }
                    }
                }
            }
            seen.sort();
            wanted.sort();
            prop_assert_eq!(seen, wanted);
        }
    }
}
