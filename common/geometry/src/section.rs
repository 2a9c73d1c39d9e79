//! The horizontal cross-section of a mesh.

use crate::mesh::MeshView;
use crate::overlay::{FillRule, union};
use crate::polygon::{MultiPolygon, Point, Ring};
use crate::slab::crossing;
use std::collections::HashMap;

/// Maximum distance of line ends that are joined: 2 mm, the size of gaps at T-junctions and in single-precision meshes.
const MAX_GAP: i64 = 20;

/// The section of a mesh with a horizontal plane.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Section {
    /// The solid's interior.
    pub area: MultiPolygon,
    /// Lines that enclose nothing: sheets without thickness, or the rims of meshes with holes.
    pub lines: Vec<[Point; 2]>,
}

/// The cross-section at half a unit above `z` (tenths of a millimetre), where no vertex can lie.
///
/// A closed mesh whose faces all look outward is exact, parts that overlap or touch included. Where faces are turned
/// the wrong way, even-odd decides; where the mesh has gaps wider than 2 mm, open lines are returned beside the area.
pub fn section(mesh: MeshView<'_>, z: i32) -> Section {
    let segments = segments(mesh, 2 * i64::from(z) + 1);
    if segments.is_empty() {
        return Section::default();
    }
    let (mut closed, open) = trails(segments);
    if open.is_empty() {
        return Section { area: union(&closed, FillRule::NonZero), lines: Vec::new() };
    }
    let (joined, open) = join(open, TrailDirection::Directed);
    closed.extend(joined);
    if open.is_empty() {
        return Section { area: union(&closed, FillRule::NonZero), lines: Vec::new() };
    }
    let (joined, open) = join(open, TrailDirection::Either);
    closed.extend(joined);
    let lines = open.iter().flat_map(|line| line.windows(2).map(|w| [w[0], w[1]])).collect();
    Section { area: union(&closed, FillRule::EvenOdd), lines }
}

/// The directed lines in which triangles meet the plane, material on the left.
fn segments(mesh: MeshView<'_>, plane_doubled: i64) -> Vec<[Point; 2]> {
    let mut out = Vec::new();
    for t in mesh.corners() {
        let above = t.map(|v| 2 * i64::from(v[2]) > plane_doubled);
        if above[0] == above[1] && above[1] == above[2] {
            continue;
        }
        // Outward faces are counter-clockwise: the line runs from the edge that goes down to the one that goes up.
        let edge = |from_above: bool| (0..3).find(|&k| above[k] == from_above && above[(k + 1) % 3] != from_above);
        let (Some(down), Some(up)) = (edge(true), edge(false)) else { continue };
        let at = |k: usize| crossing(t[k], t[(k + 1) % 3], plane_doubled);
        let line = [at(down), at(up)];
        if line[0] != line[1] {
            out.push(line);
        }
    }
    out
}

/// Joins lines head to tail: (closed rings, open trails).
pub(crate) fn trails(mut lines: Vec<[Point; 2]>) -> (Vec<Ring>, Vec<Vec<Point>>) {
    lines.sort_by_key(|line| line[0]);
    let mut points: Vec<Point> = lines.iter().flatten().copied().collect();
    points.sort_unstable();
    points.dedup();
    let index = |p: &Point| points.partition_point(|q| q < p);
    let ends: Vec<usize> = lines.iter().map(|line| index(&line[1])).collect();
    // The lines that leave a point and are not followed yet, and by how many they are more than those that arrive.
    let mut leaving = vec![0..0; points.len()];
    let mut surplus = vec![0i32; points.len()];
    for (k, line) in lines.iter().enumerate() {
        let start = index(&line[0]);
        if leaving[start].is_empty() {
            leaving[start] = k..k;
        }
        leaving[start].end = k + 1;
        surplus[start] += 1;
        surplus[ends[k]] -= 1;
    }
    let mut follow = |start: usize| {
        let mut trail = vec![points[start]];
        let mut at = start;
        while let Some(line) = leaving[at].next_back() {
            at = ends[line];
            trail.push(points[at]);
        }
        trail
    };
    // Open trails first, from points where more lines leave than arrive; the remaining lines form closed rings.
    let mut open = Vec::new();
    for (point, &surplus) in surplus.iter().enumerate() {
        open.extend((0..surplus).map(|_| follow(point)));
    }
    let mut closed = Vec::new();
    for point in 0..points.len() {
        loop {
            let mut ring = follow(point);
            if ring.len() < 2 {
                break;
            }
            ring.pop();
            closed.push(ring);
        }
    }
    (closed, open)
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum TrailDirection {
    /// Heads meet tails only.
    Directed,
    /// Trails may be reversed.
    Either,
}

/// Joins trails whose ends nearly meet, greedily with the nearest first: (rings, open trails).
fn join(trails: Vec<Vec<Point>>, sense: TrailDirection) -> (Vec<Ring>, Vec<Vec<Point>>) {
    let (mut rings, mut open) = (Vec::new(), Vec::new());
    let mut ends = TrailEnds::of(&trails, sense);
    let mut trails: Vec<Option<Vec<Point>>> = trails.into_iter().map(Some).collect();
    for last in (0..trails.len()).rev() {
        let Some(mut trail) = trails[last].take() else { continue };
        loop {
            let tail = trail[trail.len() - 1];
            let own = distance(tail, trail[0]);
            match ends.nearest(tail, |index| trails[index].is_some()) {
                Some((d, index, turned)) if d < own || trail.len() < 3 => {
                    let Some(mut next) = trails[index].take() else { break };
                    if turned {
                        next.reverse();
                    }
                    trail.extend(next);
                }
                _ => break,
            }
        }
        if trail.len() > 2 && distance(trail[0], trail[trail.len() - 1]) <= MAX_GAP {
            rings.push(trail);
        } else {
            open.push(trail);
        }
    }
    (rings, open)
}

/// Ends of trails by place, in squares with sides of [`MAX_GAP`].
struct TrailEnds {
    /// Index of the trail, and whether this end is its tail.
    by_square: HashMap<[i32; 2], Vec<(Point, usize, bool)>>,
}

impl TrailEnds {
    /// Heads of the trails; with [`TrailDirection::Either`] tails as well.
    fn of(trails: &[Vec<Point>], sense: TrailDirection) -> Self {
        let mut by_square: HashMap<_, Vec<_>> = HashMap::new();
        for (index, trail) in trails.iter().enumerate() {
            let mut add = |p: Point, turned| by_square.entry(square(p)).or_default().push((p, index, turned));
            add(trail[0], false);
            if sense == TrailDirection::Either {
                add(trail[trail.len() - 1], true);
            }
        }
        Self { by_square }
    }

    /// The nearest end of a trail that is left, at most [`MAX_GAP`] away: distance, trail, and whether it must be turned.
    fn nearest(&mut self, tail: Point, is_left: impl Fn(usize) -> bool) -> Option<(i64, usize, bool)> {
        let [column, row] = square(tail);
        let mut best = None;
        for beside in (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| [column + dx, row + dy])) {
            let Some(ends) = self.by_square.get_mut(&beside) else { continue };
            ends.retain(|(_, index, _)| is_left(*index));
            let near = ends.iter().map(|(p, index, turned)| (distance(tail, *p), *index, *turned));
            best = near.filter(|end| end.0 <= MAX_GAP).chain(best).min();
        }
        best
    }
}

fn square(p: Point) -> [i32; 2] {
    p.map(|c| c.div_euclid(MAX_GAP as i32))
}

fn distance(a: Point, b: Point) -> i64 {
    let d = |k: usize| (i64::from(a[k]) - i64::from(b[k])).abs();
    d(0).max(d(1))
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// Vertices and outward triangles of a box.
    pub(crate) fn cuboid(min: [i32; 3], max: [i32; 3]) -> (Vec<[i32; 3]>, Vec<[u32; 3]>) {
        let corner = |i: usize| [0, 1, 2].map(|k| if i >> k & 1 == 1 { max[k] } else { min[k] });
        let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let triangles = quads.iter().flat_map(|q: &[u32; 4]| [[q[0], q[1], q[2]], [q[0], q[2], q[3]]]).collect();
        ((0..8).map(corner).collect(), triangles)
    }

    fn cut(vertices: &[[i32; 3]], triangles: &[[u32; 3]], z: i32) -> Section {
        section(MeshView { vertices, triangles, closed: true }, z)
    }

    #[test]
    fn a_box_has_a_rectangular_section() {
        let (v, t) = cuboid([0, 0, 0], [20_000, 10_000, 30_000]);
        let s = cut(&v, &t, 5_000);
        assert_eq!(s.area.area_m2(), 2.0);
        assert!(s.lines.is_empty());
        assert!(cut(&v, &t, 30_000).area.is_empty(), "above the top there is nothing");
    }

    #[test]
    fn boxes_that_overlap_or_touch_are_united() {
        let (mut v, mut t) = cuboid([0, 0, 0], [10_000, 10_000, 10_000]);
        for (min, max) in [([5_000, 0, 0], [15_000, 10_000, 10_000]), ([15_000, 0, 0], [20_000, 10_000, 10_000])] {
            let (more, triangles) = cuboid(min, max);
            t.extend(triangles.iter().map(|i| i.map(|k| k + v.len() as u32)));
            v.extend(more);
        }
        assert_eq!(cut(&v, &t, 100).area.area_m2(), 2.0);
    }

    #[test]
    fn an_inner_shell_is_a_cavity() {
        let (mut v, mut t) = cuboid([0, 0, 0], [40_000, 40_000, 10_000]);
        let (inner, triangles) = cuboid([10_000, 10_000, -1], [30_000, 30_000, 10_001]);
        t.extend(triangles.iter().map(|i| [i[0] + 8, i[2] + 8, i[1] + 8]));
        v.extend(inner);
        assert_eq!(cut(&v, &t, 100).area.area_m2(), 12.0);
    }

    #[test]
    fn faces_turned_inside_out_do_not_empty_the_section() {
        let (v, mut t) = cuboid([0, 0, 0], [10_000, 10_000, 10_000]);
        for triangle in t.iter_mut() {
            triangle.swap(1, 2);
        }
        assert_eq!(cut(&v, &t, 100).area.area_m2(), 1.0);
        for triangle in t.iter_mut().skip(6) {
            triangle.swap(1, 2);
        }
        assert_eq!(cut(&v, &t, 100).area.area_m2(), 1.0, "some faces turned");
    }

    #[test]
    fn a_gap_of_a_millimetre_is_closed() {
        let (mut v, mut t) = cuboid([0, 0, 0], [10_000, 10_000, 10_000]);
        // The side x = max gets corners of its own, 1 mm off.
        for triangle in t.iter_mut().skip(10) {
            *triangle = triangle.map(|i| {
                let [x, y, z] = v[i as usize];
                v.push([x + 10, y, z]);
                v.len() as u32 - 1
            });
        }
        let s = cut(&v, &t, 100);
        assert!(s.lines.is_empty());
        assert!((s.area.area_m2() - 1.0).abs() < 0.01);
    }

    #[test]
    fn a_sheet_is_a_line() {
        let v = [[0, 0, 0], [10_000, 0, 0], [10_000, 0, 10_000], [0, 0, 10_000]];
        let s = cut(&v, &[[0, 1, 2], [0, 2, 3]], 100);
        assert!(s.area.is_empty());
        assert!(!s.lines.is_empty());
    }
}
