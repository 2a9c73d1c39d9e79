//! Triangles of regions; the only module of this crate that uses i_triangle.

use crate::polygon::{MultiPolygon, Point, Ring, ring_area_doubled};
use i_triangle::i_overlay::core::fill_rule::FillRule as Rule;
use i_triangle::i_overlay::core::overlay::IntOverlayOptions;
use i_triangle::i_overlay::core::solver::{Precision, Solver, Strategy};
use i_triangle::i_overlay::i_float::int::point::IntPoint;
use i_triangle::i_overlay::i_shape::int::shape::IntShape;
use i_triangle::int::triangulatable::IntTriangulatable;
use i_triangle::int::triangulator::IntTriangulator;
use i_triangle::int::validation::Validation;

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

/// Triangles, counter-clockwise, of the region in rings, the exterior first: each point of the rings is a corner, even one between
/// two others on a line.
pub(crate) fn triangulated_with_all_points(rings: &[Ring]) -> Vec<[Point; 3]> {
    let n_points = rings.iter().map(Vec::len).sum();
    let shape: IntShape<i32> =
        rings.iter().map(|ring| ring.iter().map(|p| IntPoint::new(p[0], p[1])).collect()).collect();
    let validation = Validation { fill_rule: Rule::NonZero, options: IntOverlayOptions::keep_all_points() };
    let solver = Solver { strategy: Strategy::Auto, precision: Precision::HIGH, multithreading: None };
    let triangulation = IntTriangulator::<i32, u32>::new(n_points, validation, solver).triangulate_shape(&shape);
    let corner = |i: u32| {
        let p = triangulation.points[i as usize];
        [p.x, p.y]
    };
    let (triangles, _) = triangulation.indices.as_chunks::<3>();
    let counter_clockwise =
        |[a, b, c]: [Point; 3]| if ring_area_doubled(&[a, b, c]) < 0 { [a, c, b] } else { [a, b, c] };
    triangles.iter().map(|t| counter_clockwise(t.map(corner))).collect()
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
