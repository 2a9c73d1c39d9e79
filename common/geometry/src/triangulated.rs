//! Triangles of regions; the only module of this crate that uses i_triangle.

use crate::polygon::{MultiPolygon, Point, Ring, ring_area_doubled};
use i_triangle::i_overlay::i_float::int::point::IntPoint;
use i_triangle::i_overlay::i_shape::int::shape::IntShape;
use i_triangle::int::triangulatable::IntTriangulatable;

/// Triangles, counter-clockwise, that cover the region and nothing else, with corners of the region only.
pub fn triangulated(region: &MultiPolygon) -> Vec<[Point; 3]> {
    let mut found = Vec::new();
    for polygon in &region.0 {
        let contour = |ring: &Ring| ring.iter().map(|p| IntPoint::new(p[0], p[1])).collect();
        let shape: IntShape<i32> = polygon.rings().map(contour).collect();
        let triangulation = shape.triangulate().into_triangulation::<u32>();
        let corner = |i: u32| {
            let p = triangulation.points[i as usize];
            [p.x, p.y]
        };
        let (triangles, _) = triangulation.indices.as_chunks::<3>();
        found.extend(triangles.iter().map(|t| t.map(corner)).filter_map(|[a, b, c]| {
            match ring_area_doubled(&[a, b, c]) {
                0 => None,
                area if area < 0 => Some([a, c, b]),
                _ => Some([a, b, c]),
            }
        }));
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{FillRule, difference, union};

    #[test]
    fn a_frame_is_covered_and_its_hole_is_not() {
        let square = |lo: i32, hi: i32| union(&[vec![[lo, lo], [hi, lo], [hi, hi], [lo, hi]]], FillRule::NonZero);
        let triangles = triangulated(&difference(&square(0, 1_000), &square(300, 600)));
        let area: i64 = triangles.iter().map(|t| ring_area_doubled(t) as i64).sum();
        assert_eq!(area, 2 * (1_000 * 1_000 - 300 * 300));
        assert!(triangulated(&MultiPolygon::default()).is_empty());
    }
}
