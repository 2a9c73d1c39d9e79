//! Footprint of a solid: the union of its horizontal sections between two heights.

use crate::mesh::MeshView;
use crate::overlay::{FillRule, union};
use crate::polygon::{Bounds, MultiPolygon, Point, Ring, ring_area_doubled};
use crate::section::section;
use crate::slab::{Slab, clip_to_slab};

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

/// The union over all heights of the slab of the parts' horizontal cross-sections.
///
/// A point belongs to it if the upright line through it meets the surface inside the slab (then it lies in the plan of
/// a clipped triangle) or stays in the solid all through (then it lies in the section at the slab's bottom). So one
/// section is enough for a closed mesh. A mesh with gaps is cut at several levels, and its sheets are returned as lines.
pub fn footprint<'a>(parts: impl IntoIterator<Item = MeshView<'a>>, slab: Slab) -> Footprint {
    let (mut areas, mut plans, mut lines) = (Vec::new(), Vec::new(), Vec::new());
    for mesh in parts {
        let Some((z_min, z_max)) = mesh.z_range() else { continue };
        if !slab.meets(z_min, z_max) {
            continue;
        }
        project(mesh, slab, &mut plans);
        let (bottom, top) = (slab.lo.max(z_min), slab.hi.min(z_max));
        let n_levels = if mesh.closed { 1 } else { OPEN_MESH_SECTIONS.min(top - bottom) };
        for k in 0..n_levels {
            let cut = section(
                mesh,
                bottom + ((i64::from(top) - i64::from(bottom)) * i64::from(k) / i64::from(n_levels)) as i32,
            );
            lines.extend(cut.lines);
            if !cut.area.is_empty() && areas.last() != Some(&cut.area) {
                areas.push(cut.area);
            }
        }
    }
    lines.sort_unstable();
    lines.dedup();
    if plans.is_empty() && areas.len() <= 1 {
        return Footprint { area: areas.pop().unwrap_or_default(), lines };
    }
    plans.extend(areas.into_iter().flat_map(|area| area.0).flat_map(|p| std::iter::once(p.exterior).chain(p.holes)));
    Footprint { area: union(&plans, FillRule::NonZero), lines }
}

/// Horizontal projections of the triangles' parts in the slab, counter-clockwise; none for upright triangles.
fn project(mesh: MeshView<'_>, slab: Slab, plans: &mut Vec<Ring>) {
    let mut plan = Vec::new();
    for triangle in mesh.corners() {
        let z = triangle.map(|v| v[2]);
        if !slab.meets(z[0].min(z[1]).min(z[2]), z[0].max(z[1]).max(z[2])) {
            continue;
        }
        clip_to_slab(&triangle, slab, &mut plan);
        match ring_area_doubled(&plan).signum() {
            0 => {}
            1 => plans.push(plan.clone()),
            _ => plans.push(plan.iter().rev().copied().collect()),
        }
    }
}

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

    proptest! {
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
