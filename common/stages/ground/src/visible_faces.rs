//! The triangles of faces that no cover hides.

use crate::plane::{Triangle, double_area};
use geometry::{FillRule, MultiPolygon, Plane, Ring, difference, triangulated, union};

/// The triangle, or triangles of the parts of it that none of the rings covers.
pub(crate) fn uncovered(face: &Triangle, covers: &[&Ring]) -> Vec<Triangle> {
    if covers.is_empty() {
        return vec![*face];
    }
    let rings: Vec<Ring> = covers.iter().map(|ring| (*ring).clone()).collect();
    let plan = union(&[face.iter().map(|v| [v[0], v[1]]).collect()], FillRule::NonZero);
    let left: MultiPolygon = difference(&plan, &union(&rings, FillRule::NonZero));
    let plane = Plane::of(face);
    let raised = |p: [i32; 2]| {
        let corner = face.iter().find(|v| [v[0], v[1]] == p);
        corner.copied().unwrap_or_else(|| [p[0], p[1], plane.z(p.map(f64::from)).round() as i32])
    };
    triangulated(&left).into_iter().map(|t| t.map(raised)).filter(|t| double_area(t) > 0).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_hole_in_a_slope_leaves_its_height_and_the_area_around_it() {
        let face = [[0, 0, 0], [10_000, 0, 1_000], [0, 10_000, 0]];
        let hole: Ring = vec![[1_000, 1_000], [2_000, 1_000], [2_000, 2_000], [1_000, 2_000]];
        let left = uncovered(&face, &[&hole]);
        let area: i64 = left.iter().map(double_area).sum();
        assert_eq!(area, 100_000_000 - 2_000_000);
        assert!(left.iter().flatten().all(|v| (v[2] - v[0] / 10).abs() <= 1), "{left:?}");
        assert!(uncovered(&face, &[&vec![[-5, -5], [20_000, -5], [-5, 20_000]]]).is_empty());
        assert_eq!(uncovered(&face, &[]), [face]);
    }
}
