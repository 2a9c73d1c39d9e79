//! Boolean operations on polygons; the only module that names i_overlay.

use crate::polygon::{MultiPolygon, Point, Polygon, Ring};
use i_overlay::core::fill_rule::FillRule as Rule;
use i_overlay::core::overlay::{Overlay, ShapeType};
use i_overlay::core::overlay_rule::OverlayRule;
use i_overlay::core::solver::{Precision, Solver, Strategy};
use i_overlay::i_float::int::angle::Angle;
use i_overlay::i_float::int::point::IntPoint;
use i_overlay::i_shape::int::shape::{IntContour, IntShape, IntShapes};
use i_overlay::mesh::int::outline::offset::IntOutlineOffset;
use i_overlay::mesh::int::style::{IntLineJoin, IntOutlineStyle};

/// Fill rule: which winding numbers are inside.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FillRule {
    /// Winding numbers other than zero: overlapping rings are united.
    NonZero,
    /// Odd numbers of crossings: for rings without a defined orientation.
    EvenOdd,
}

/// The region that rings enclose by the fill rule.
pub fn union(rings: &[Ring], rule: FillRule) -> MultiPolygon {
    let mut overlay = empty(rings.iter().map(Vec::len).sum());
    for ring in rings {
        overlay.add_path_iter(ring.iter().map(to_int), ShapeType::Subject);
    }
    from_int(overlay.overlay(OverlayRule::Subject, rule.into()))
}

/// The union of regions.
pub fn union_of<'a>(parts: impl IntoIterator<Item = &'a MultiPolygon>) -> MultiPolygon {
    let rings: Vec<Ring> = parts.into_iter().flat_map(|p| p.rings().cloned()).collect();
    union(&rings, FillRule::NonZero)
}

/// The intersection of two regions.
pub fn intersection(a: &MultiPolygon, b: &MultiPolygon) -> MultiPolygon {
    combine(a, b, OverlayRule::Intersect)
}

/// The region of `a` without `b`.
pub fn difference(a: &MultiPolygon, b: &MultiPolygon) -> MultiPolygon {
    combine(a, b, OverlayRule::Difference)
}

/// The region offset outwards by `reach` (tenths of a millimetre), inwards if negative; corners stay sharp. `None` if its
/// coordinates are too large for that.
pub fn offset(region: &MultiPolygon, reach: i32) -> Option<MultiPolygon> {
    let sharpest = Angle::from_radians(0.2).expect("a small positive angle");
    let style = IntOutlineStyle::new(reach).line_join(IntLineJoin::Miter(sharpest));
    to_shapes(region).outline(&style).ok().map(from_int)
}

/// The region with cracks narrower than `width` (tenths of a millimetre) closed: grown and shrunk again.
pub fn close_gaps(region: &MultiPolygon, width: i32) -> MultiPolygon {
    let reach = width / 2 + 1;
    offset(region, reach).and_then(|grown| offset(&grown, -reach)).unwrap_or_else(|| region.clone())
}

fn combine(a: &MultiPolygon, b: &MultiPolygon, rule: OverlayRule) -> MultiPolygon {
    let n_points = a.rings().chain(b.rings()).map(Vec::len).sum();
    let mut overlay = empty(n_points);
    for (region, role) in [(a, ShapeType::Subject), (b, ShapeType::Clip)] {
        for ring in region.rings() {
            overlay.add_path_iter(ring.iter().map(to_int), role);
        }
    }
    from_int(overlay.overlay(rule, Rule::NonZero))
}

/// Single-threaded: callers process many elements in parallel.
fn empty(capacity: usize) -> Overlay<i32> {
    let solver = Solver { strategy: Strategy::Auto, precision: Precision::HIGH, multithreading: None };
    Overlay::new_custom(capacity, Default::default(), solver)
}

fn to_int(p: &Point) -> IntPoint<i32> {
    IntPoint::new(p[0], p[1])
}

fn to_shapes(region: &MultiPolygon) -> IntShapes<i32> {
    region.0.iter().map(|p| p.rings().map(|r| r.iter().map(to_int).collect()).collect()).collect()
}

fn from_int(shapes: IntShapes<i32>) -> MultiPolygon {
    let ring = |c: IntContour<i32>| c.into_iter().map(|p| [p.x, p.y]).collect::<Ring>();
    let polygon = |shape: IntShape<i32>| {
        let mut rings = shape.into_iter().map(ring);
        Some(Polygon { exterior: rings.next()?, holes: rings.collect() })
    };
    MultiPolygon(shapes.into_iter().filter_map(polygon).collect())
}

impl From<FillRule> for Rule {
    fn from(rule: FillRule) -> Self {
        match rule {
            FillRule::NonZero => Self::NonZero,
            FillRule::EvenOdd => Self::EvenOdd,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rectangle(x0: i32, y0: i32, x1: i32, y1: i32) -> Ring {
        vec![[x0, y0], [x1, y0], [x1, y1], [x0, y1]]
    }

    fn region(rings: &[Ring]) -> MultiPolygon {
        union(rings, FillRule::NonZero)
    }

    #[test]
    fn exteriors_are_counter_clockwise_and_holes_clockwise() {
        let outer = region(&[rectangle(0, 0, 100, 100)]);
        let ring = difference(&outer, &region(&[rectangle(40, 40, 60, 60)]));
        assert!(crate::ring_area_doubled(&ring.0[0].exterior) > 0);
        assert!(crate::ring_area_doubled(&ring.0[0].holes[0]) < 0);
    }

    #[test]
    fn intersection_and_difference_make_up_the_whole() {
        let (a, b) = (region(&[rectangle(0, 0, 30_000, 20_000)]), region(&[rectangle(10_000, 5_000, 50_000, 9_000)]));
        assert_eq!(intersection(&a, &b).area_m2() + difference(&a, &b).area_m2(), a.area_m2());
    }

    #[test]
    fn cracks_are_closed_and_corners_stay() {
        let split = region(&[rectangle(0, 0, 10_000, 10_000), rectangle(10_003, 0, 20_000, 10_000)]);
        assert_eq!(split.0.len(), 2);
        let whole = close_gaps(&split, 10);
        assert_eq!(whole.0.len(), 1);
        assert!((whole.area_m2() - 2.0).abs() < 1e-4, "{}", whole.area_m2());
    }
}
