//! Footprint of a solid: the union of its horizontal sections between two heights, and the parts that it is united from.

use crate::mesh::MeshView;
use crate::overlay::{FillRule, union, union_of};
use crate::polygon::{Bounds, MultiPolygon, Point, Ring, edges, ring_area_doubled};
use crate::section::{Section, section, trails};
use crate::slab::{Slab, clip_to_slab};
use std::sync::OnceLock;

/// Most plans that are united at once rather than cut again: that takes little longer than cutting them did.
const MAX_PLANS_AT_ONCE: usize = 24;

/// Most polygons that share few edges and are united at once.
const MAX_UNITED: usize = 256;

/// A mesh is smooth if at least so many of its edges are shared for each one that is left in its outlines.
const MIN_SHARED: usize = 4;

/// Number of sections of a mesh with gaps, whose surface does not define a solid.
const OPEN_MESH_SECTIONS: i32 = 8;

/// The horizontal projection of an element within a slab.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Footprint {
    /// Area of the solid, with its interior.
    pub area: MultiPolygon,
    /// Upright surfaces without thickness: they cover no area but are obstacles.
    pub lines: Vec<[Point; 2]>,
}

impl Footprint {
    /// True if it has neither area nor lines.
    pub fn is_empty(&self) -> bool {
        self.area.is_empty() && self.lines.is_empty()
    }

    /// Bounds of area and lines.
    pub fn bounds(&self) -> Option<Bounds> {
        let lines = Bounds::of(self.lines.iter().flatten().copied());
        match (self.area.bounds(), lines) {
            (Some(a), Some(b)) => Some(a.joined(b)),
            (a, b) => a.or(b),
        }
    }
}

/// The parts of a body within a slab, in plan, before they are united: what cells are painted from.
///
/// A point belongs to the body's footprint if the upright line through it meets the surface inside the slab (then it lies in
/// the plan of a clipped triangle) or stays in the solid all through (then it lies in the section at the slab's bottom). So
/// one section is enough for a closed mesh. A mesh with gaps is cut at several levels, and its sheets are lines.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct SlabCut {
    /// Corners of all plans of clipped triangles.
    corners: Vec<Point>,
    /// Where each plan ends in `corners`.
    ends: Vec<u32>,
    /// Sections of the parts.
    pub sections: Vec<MultiPolygon>,
    /// Upright surfaces without thickness, sorted.
    pub lines: Vec<[Point; 2]>,
}

impl SlabCut {
    /// Cuts the parts of a body. Linear in triangles, but for the order in which sections are joined.
    pub fn of<'a>(parts: impl IntoIterator<Item = MeshView<'a>>, slab: Slab) -> Self {
        let mut cut = Self::default();
        for mesh in parts {
            let Some((z_min, z_max)) = mesh.z_range() else { continue };
            if !slab.meets(z_min, z_max) {
                continue;
            }
            cut.project(mesh, slab);
            let (bottom, top) = (slab.lo.max(z_min), slab.hi.min(z_max));
            let n_levels = if mesh.closed { 1 } else { OPEN_MESH_SECTIONS.min(top - bottom) };
            for k in 0..n_levels {
                let above = (i64::from(top) - i64::from(bottom)) * i64::from(k) / i64::from(n_levels);
                let Section { area, lines } = section(mesh, bottom + above as i32);
                cut.lines.extend(lines);
                if !area.is_empty() && cut.sections.last() != Some(&area) {
                    cut.sections.push(area);
                }
            }
        }
        cut.lines.sort_unstable();
        cut.lines.dedup();
        cut
    }

    /// Plans of the triangles' parts in the slab: convex and counter-clockwise; none of upright triangles.
    pub fn plans(&self) -> impl Iterator<Item = &[Point]> {
        let starts = std::iter::once(0).chain(self.ends.iter().copied());
        starts.zip(&self.ends).map(|(start, &end)| &self.corners[start as usize..end as usize])
    }

    /// True if there is nothing of the body in the slab.
    pub fn is_empty(&self) -> bool {
        self.ends.is_empty() && self.sections.is_empty() && self.lines.is_empty()
    }

    /// True if the union is known without uniting anything.
    pub fn is_united(&self) -> bool {
        self.ends.is_empty() && self.sections.len() <= 1
    }

    /// The union of all parts.
    pub fn footprint(mut self) -> Footprint {
        if self.is_united() {
            return Footprint { area: self.sections.pop().unwrap_or_default(), lines: self.lines };
        }
        let plans = united(&mut self.plans().collect::<Vec<_>>());
        // Of a box both are the same rectangle.
        let is_all = self.sections.iter().all(|section| *section == plans);
        let area = if is_all { plans } else { union_of(self.sections.iter().chain([&plans])) };
        Footprint { area, lines: std::mem::take(&mut self.lines) }
    }

    fn project(&mut self, mesh: MeshView<'_>, slab: Slab) {
        let mut plan = Vec::new();
        for triangle in mesh.corners() {
            let z = triangle.map(|v| v[2]);
            if !slab.meets(z[0].min(z[1]).min(z[2]), z[0].max(z[1]).max(z[2])) {
                continue;
            }
            clip_to_slab(&triangle, slab, &mut plan);
            match ring_area_doubled(&plan).signum() {
                0 => continue,
                1 => self.corners.extend_from_slice(&plan),
                _ => self.corners.extend(plan.iter().rev()),
            }
            self.ends.push(self.corners.len() as u32);
        }
    }
}

/// The footprint of a body within a slab. That of a fine mesh is united when it is first asked for.
#[derive(Debug, Clone)]
pub struct LazyFootprint {
    slab: Slab,
    /// Number of parts that it is united from.
    n_parts: usize,
    united: OnceLock<Footprint>,
}

impl LazyFootprint {
    /// Of a body that was cut at the slab. Fine meshes are cut again later: few of them are asked for.
    pub fn of(cut: SlabCut, slab: Slab) -> Self {
        let united = OnceLock::new();
        let n_parts = cut.ends.len() + cut.sections.len();
        if cut.ends.len() <= MAX_PLANS_AT_ONCE {
            let _ = united.set(cut.footprint());
        }
        Self { slab, n_parts, united }
    }

    /// The slab in which it is.
    pub fn slab(&self) -> Slab {
        self.slab
    }

    /// Number of plans of triangles and sections that it is united from, whether it was already or not.
    pub fn n_parts(&self) -> usize {
        self.n_parts
    }

    /// The footprint of the body with these parts.
    pub fn get<'a, I: IntoIterator<Item = MeshView<'a>>>(&self, parts: impl FnOnce() -> I) -> &Footprint {
        self.united.get_or_init(|| footprint(parts(), self.slab))
    }
}

impl From<Footprint> for LazyFootprint {
    fn from(footprint: Footprint) -> Self {
        Self { slab: Slab { lo: 0, hi: 0 }, n_parts: 0, united: footprint.into() }
    }
}

/// The union over all heights of the slab of the parts' horizontal cross-sections.
pub fn footprint<'a>(parts: impl IntoIterator<Item = MeshView<'a>>, slab: Slab) -> Footprint {
    SlabCut::of(parts, slab).footprint()
}

/// The union of counter-clockwise polygons.
fn united(polygons: &mut [&[Point]]) -> MultiPolygon {
    let rings = outlines(polygons.iter().copied());
    let n_left: usize = rings.iter().map(Vec::len).sum();
    let n_edges: usize = polygons.iter().map(|p| p.len()).sum();
    if n_left * MIN_SHARED <= n_edges { union(&rings, FillRule::NonZero) } else { united_by_place(polygons) }
}

/// The union of counter-clockwise polygons that share few edges.
///
/// The cost of a union grows with the number of edges that cross, most of which lie inside the union in the end: leaves of a
/// plant, say. So neighbours are united first, and the regions after that. The order depends on places only.
fn united_by_place(polygons: &mut [&[Point]]) -> MultiPolygon {
    let bounds = Bounds::of(polygons.iter().map(|p| p[0])).filter(|_| polygons.len() > MAX_UNITED);
    let Some(bounds) = bounds else { return union(&outlines(polygons.iter().copied()), FillRule::NonZero) };
    let side = |k: usize| i64::from(bounds.max[k]) - i64::from(bounds.min[k]);
    let across = usize::from(side(1) > side(0));
    let middle = polygons.len() / 2;
    polygons.select_nth_unstable_by_key(middle, |p| (p[0][across], *p));
    let (first, second) = polygons.split_at_mut(middle);
    union_of([&united_by_place(first), &united_by_place(second)])
}

/// Rings around counter-clockwise polygons, without the edges at which neighbours meet: by the rule of non-zero winding
/// numbers they enclose what the polygons cover.
///
/// Two neighbours run along their common edge in opposite directions, so its windings cancel. Of a mesh that is fine and
/// smooth little more than the silhouette is left.
fn outlines<'a>(polygons: impl Iterator<Item = &'a [Point]>) -> Vec<Ring> {
    // Each edge from its smaller end, as one number, with the direction in which it is run along.
    let mut all: Vec<(u128, bool)> = polygons
        .flat_map(edges)
        .filter(|(a, b)| a != b)
        .map(|(a, b)| if a < b { (number_of([a, b]), true) } else { (number_of([b, a]), false) })
        .collect();
    all.sort_unstable_by_key(|edge| edge.0);
    let mut left = Vec::new();
    for same in all.chunk_by(|x, y| x.0 == y.0) {
        let n_forward = same.iter().filter(|edge| edge.1).count();
        let n_backward = same.len() - n_forward;
        let [a, b] = edge_of(same[0].0);
        left.extend(std::iter::repeat_n([a, b], n_forward.saturating_sub(n_backward)));
        left.extend(std::iter::repeat_n([b, a], n_backward.saturating_sub(n_forward)));
    }
    // As many edges leave each point as arrive at it, so all trails are closed.
    trails(left).0
}

/// An edge as a number: edges are in the order of their numbers.
fn number_of(edge: [Point; 2]) -> u128 {
    edge.as_flattened().iter().fold(0, |number, &c| number << 32 | u128::from(c.cast_unsigned() ^ SIGN))
}

/// The edge of a number.
fn edge_of(number: u128) -> [Point; 2] {
    let coordinate = |shift: u32| ((number >> shift) as u32 ^ SIGN).cast_signed();
    [[coordinate(96), coordinate(64)], [coordinate(32), coordinate(0)]]
}

/// The bit of a coordinate that makes the order of unsigned numbers that of signed ones.
const SIGN: u32 = 1 << 31;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::section::tests::cuboid;
    use proptest::prelude::*;

    fn of_boxes(boxes: &[([i32; 3], [i32; 3])], slab: Slab) -> Footprint {
        let meshes: Vec<_> = boxes.iter().map(|(min, max)| cuboid(*min, *max)).collect();
        footprint(meshes.iter().map(|(v, t)| MeshView { vertices: v, triangles: t, closed: true }), slab)
    }

    const SLAB: Slab = Slab { lo: 500, hi: 12_500 };

    #[test]
    fn a_wall_through_the_slab_is_solid() {
        let f = of_boxes(&[([0, 0, 0], [50_000, 3_000, 28_000])], SLAB);
        assert_eq!(f.area.area_m2(), 1.5);
    }

    #[test]
    fn tops_at_the_step_and_bottoms_at_the_head_do_not_count() {
        assert!(of_boxes(&[([0, 0, 0], [10_000, 10_000, 500])], SLAB).is_empty());
        assert!(of_boxes(&[([0, 0, 12_500], [10_000, 10_000, 20_000])], SLAB).is_empty());
        assert!(!of_boxes(&[([0, 0, 0], [10_000, 10_000, 501])], SLAB).is_empty());
    }

    #[test]
    fn a_table_covers_its_top() {
        let f = of_boxes(&[([0, 0, 7_000], [10_000, 10_000, 7_500]), ([0, 0, 0], [500, 500, 7_000])], SLAB);
        assert_eq!(f.area.area_m2(), 1.0);
    }

    #[test]
    fn a_slope_is_cut_at_the_slabs_faces() {
        // A wedge from z = 0 at x = 0 to z = 1 m at x = 1 m, 1 m deep.
        let v = [
            [0, 0, 0],
            [10_000, 0, 0],
            [10_000, 0, 10_000],
            [0, 10_000, 0],
            [10_000, 10_000, 0],
            [10_000, 10_000, 10_000],
        ];
        let t = [[0, 1, 2], [3, 5, 4], [0, 3, 4], [0, 4, 1], [1, 4, 5], [1, 5, 2], [0, 2, 5], [0, 5, 3]];
        let f = footprint([MeshView { vertices: &v, triangles: &t, closed: true }], Slab { lo: 2_500, hi: 20_000 });
        assert!((f.area.area_m2() - 0.75).abs() < 1e-3, "{}", f.area.area_m2());
    }

    /// A heap of closed surfaces whose faces cross: corners in fours.
    fn tetrahedra(corners: &[[[i32; 3]; 4]]) -> (Vec<[i32; 3]>, Vec<[u32; 3]>) {
        let faces = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
        let triangles = (0..corners.len() as u32).flat_map(|k| faces.map(|t| t.map(|i: u32| 4 * k + i)));
        (corners.as_flattened().to_vec(), triangles.collect())
    }

    #[test]
    fn edges_are_ordered_as_their_numbers_are() {
        let corners = [i32::MIN, -7, -1, 0, 1, 9, i32::MAX];
        let points = || corners.into_iter().flat_map(|x| corners.map(|y| [x, y]));
        let edges: Vec<[Point; 2]> = points().flat_map(|a| points().map(move |b| [a, b])).collect();
        let numbers: Vec<u128> = edges.iter().map(|edge| number_of(*edge)).collect();
        assert!(numbers.is_sorted());
        assert!(numbers.into_iter().map(edge_of).eq(edges));
    }

    #[test]
    fn of_a_fine_ball_the_rim_is_left() {
        let n = 40;
        let at = |i: u32, j: u32| {
            let angle = |k: u32, n: u32| std::f64::consts::PI * f64::from(k) / f64::from(n);
            let (r, z) = (5_000.0 * libm::sin(angle(i, n)), 5_000.0 * libm::cos(angle(i, n)));
            let around = 2.0 * angle(j % (2 * n), 2 * n);
            [r * libm::cos(around), r * libm::sin(around), z].map(|c| c.round() as i32)
        };
        let quads =
            || (0..n).flat_map(|i| (0..2 * n).map(move |j| [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]));
        let vertices: Vec<[i32; 3]> = quads().flatten().collect();
        let triangles: Vec<[u32; 3]> =
            (0..4 * n * n / 2).flat_map(|k| [[4 * k, 4 * k + 1, 4 * k + 2], [4 * k, 4 * k + 2, 4 * k + 3]]).collect();
        let mesh = MeshView { vertices: &vertices, triangles: &triangles, closed: true };
        let cut = SlabCut::of([mesh], Slab { lo: -6_000, hi: 6_000 });
        assert!(cut.plans().count() > 5_000);
        let n_edges: usize = outlines(cut.plans()).iter().map(Vec::len).sum();
        assert!(n_edges <= 4 * 80, "{n_edges} edges are left");
        assert!((cut.footprint().area.area_m2() - 0.7846).abs() < 1e-3);
    }

    proptest! {
        #[test]
        fn outlines_enclose_what_all_triangles_cover(
            corners in prop::collection::vec(
                prop::array::uniform4([-9_000..9_000i32, -9_000..9_000i32, -3_000..3_000i32]), 1..8),
        ) {
            let (vertices, triangles) = tetrahedra(&corners);
            let mesh = MeshView { vertices: &vertices, triangles: &triangles, closed: true };
            let cut = SlabCut::of([mesh], Slab { lo: -1_000, hi: 1_000 });
            let plans: Vec<Ring> = cut.plans().map(<[Point]>::to_vec).collect();
            let (all, outlined) = (union(&plans, FillRule::NonZero), union(&outlines(cut.plans()), FillRule::NonZero));
            // Both round the points where edges cross.
            let differs = |a: &MultiPolygon, b: &MultiPolygon| crate::difference(a, &crate::offset(b, 3).unwrap()).area_m2();
            prop_assert!(differs(&all, &outlined) == 0.0 && differs(&outlined, &all) == 0.0);
        }

        #[test]
        fn boxes_agree_with_their_rectangles(
            boxes in prop::collection::vec(((-9_000..9_000i32, -9_000..9_000i32, -3_000..3_000i32), (1..9_000i32, 1..9_000i32, 1..9_000i32)), 1..6),
            point in (-9_000..18_000i32, -9_000..18_000i32),
        ) {
            let slab = Slab { lo: 0, hi: 2_000 };
            let boxes: Vec<_> = boxes.iter().map(|&((x, y, z), (w, d, h))| ([x, y, z], [x + w, y + d, z + h])).collect();
            let f = of_boxes(&boxes, slab);
            let p = [f64::from(point.0) + 0.5, f64::from(point.1) + 0.5];
            let expected = boxes.iter().any(|(min, max)| slab.meets(min[2], max[2])
                && (0..2).all(|k| f64::from(min[k]) < p[k] && p[k] < f64::from(max[k])));
            prop_assert_eq!(f.area.contains(p), expected);
        }
    }
}
