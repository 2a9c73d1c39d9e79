//! Boolean operations on polygons; the only module that names i_overlay.
//!
//! The work of an overlay grows faster than its edges, so what lies apart is worked on apart.

use crate::clusters::clusters;
use crate::polygon::{Bounds, MultiPolygon, Point, Polygon, Ring};
use crate::simple_rings::region_of_simple_rings;
use i_overlay::core::fill_rule::FillRule as Rule;
use i_overlay::core::overlay::{Overlay, ShapeType};
use i_overlay::core::overlay_rule::OverlayRule;
use i_overlay::core::solver::{Precision, Solver, Strategy};
use i_overlay::i_float::int::angle::Angle;
use i_overlay::i_float::int::point::IntPoint;
use i_overlay::i_shape::int::shape::{IntContour, IntShape, IntShapes};
use i_overlay::mesh::int::outline::offset::IntOutlineOffset;
use i_overlay::mesh::int::style::{IntLineJoin, IntOutlineStyle};
use std::cell::Cell;

/// Fill rule: which winding numbers are inside.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FillRule {
    /// Winding numbers other than zero: overlapping rings are united.
    NonZero,
    /// Odd numbers of crossings: for rings without a defined orientation.
    EvenOdd,
}

/// Most rings that are worked on at once without a look at where they lie.
const MAX_AT_ONCE: usize = 64;

/// The sharpest corner of an offset that is not cut off, in radians; a sharper one would reach 1 / sin(angle / 2) times the
/// offset out, here ten times.
const SHARPEST_RAD: f64 = 0.2;
const FARTHEST_CORNER: i64 = 11;

/// The region that rings enclose by the fill rule.
pub fn union(rings: &[Ring], rule: FillRule) -> MultiPolygon {
    region_of_simple_rings(rings).unwrap_or_else(|| overlaid(rings, rule))
}

/// The same by an overlay in any case.
pub(crate) fn overlaid(rings: &[Ring], rule: FillRule) -> MultiPolygon {
    let unite = |rings: &[&Ring]| {
        let mut overlay = empty(rings.iter().map(|ring| ring.len()).sum());
        for ring in rings {
            overlay.add_path_iter(ring.iter().map(to_int), ShapeType::Subject);
        }
        from_int(overlay.overlay(OverlayRule::Subject, rule.into()))
    };
    by_place(&rings.iter().collect::<Vec<_>>(), 0, |ring| ring, unite)
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

/// The region that rings enclose without what other rings do. Rings run counter-clockwise around what they enclose; those of
/// holes clockwise.
pub(crate) fn difference_of_rings(a: &[Ring], b: &[Ring]) -> MultiPolygon {
    combine_rings(a, b, OverlayRule::Difference)
}

/// The region that rings and other rings both enclose.
pub(crate) fn intersection_of_rings(a: &[Ring], b: &[Ring]) -> MultiPolygon {
    if b.is_empty() { MultiPolygon::default() } else { combine_rings(a, b, OverlayRule::Intersect) }
}

fn combine_rings(a: &[Ring], b: &[Ring], rule: OverlayRule) -> MultiPolygon {
    let mut overlay = empty(a.iter().chain(b).map(Vec::len).sum());
    let subjects = a.iter().map(|ring| (ring, ShapeType::Subject));
    for (ring, role) in subjects.chain(b.iter().map(|ring| (ring, ShapeType::Clip))) {
        overlay.add_path_iter(ring.iter().map(to_int), role);
    }
    from_int(overlay.overlay(rule, Rule::NonZero))
}

/// The region offset outwards by `reach` (tenths of a millimetre), inwards if negative; corners stay sharp. `None` if its
/// coordinates are too large for that.
pub fn offset(region: &MultiPolygon, reach: i32) -> Option<MultiPolygon> {
    let sharpest = Angle::from_radians(SHARPEST_RAD).expect("a small positive angle");
    let style = IntOutlineStyle::new(reach).line_join(IntLineJoin::Miter(sharpest));
    let is_too_large = Cell::new(false);
    let polygons: Vec<&Polygon> = region.0.iter().collect();
    let grown = by_place(
        &polygons,
        2 * FARTHEST_CORNER * i64::from(reach.max(0)),
        |p| &p.exterior,
        |polygons| {
            let grown = to_shapes(polygons.iter().copied()).outline(&style);
            is_too_large.set(is_too_large.get() || grown.is_err());
            grown.map(from_int).unwrap_or_default()
        },
    );
    (!is_too_large.get()).then_some(grown)
}

/// The region with cracks narrower than `width` (tenths of a millimetre) closed: grown and shrunk again.
pub fn close_gaps(region: &MultiPolygon, width: i32) -> MultiPolygon {
    let reach = width / 2 + 1;
    offset(region, reach).and_then(|grown| offset(&grown, -reach)).unwrap_or_else(|| region.clone())
}

fn combine(a: &MultiPolygon, b: &MultiPolygon, rule: OverlayRule) -> MultiPolygon {
    let subjects = a.0.iter().map(|polygon| (polygon, ShapeType::Subject));
    let clips = b.0.iter().map(|polygon| (polygon, ShapeType::Clip));
    by_place(
        &subjects.chain(clips).collect::<Vec<_>>(),
        0,
        |(polygon, _)| &polygon.exterior,
        |polygons| {
            let mut overlay = empty(polygons.iter().flat_map(|(polygon, _)| polygon.rings()).map(Vec::len).sum());
            for (polygon, role) in polygons {
                for ring in polygon.rings() {
                    overlay.add_path_iter(ring.iter().map(to_int), *role);
                }
            }
            from_int(overlay.overlay(rule, Rule::NonZero))
        },
    )
}

/// Works on what lies apart by more than `gap` (tenths of a millimetre) one after the other.
fn by_place<T: Copy>(
    parts: &[T],
    gap: i64,
    ring: impl Fn(&T) -> &Ring,
    work: impl Fn(&[T]) -> MultiPolygon,
) -> MultiPolygon {
    if parts.len() <= MAX_AT_ONCE {
        return work(parts);
    }
    let (parts, bounds): (Vec<T>, Vec<Bounds>) =
        parts.iter().filter_map(|part| Some((*part, Bounds::of(ring(part).iter().copied())?))).unzip();
    let groups = clusters(&bounds, gap);
    MultiPolygon(groups.iter().flat_map(|group| work(&group.iter().map(|&k| parts[k]).collect::<Vec<_>>()).0).collect())
}

/// Single-threaded: callers process many elements in parallel.
fn empty(capacity: usize) -> Overlay<i32> {
    let solver = Solver { strategy: Strategy::Auto, precision: Precision::HIGH, multithreading: None };
    Overlay::new_custom(capacity, Default::default(), solver)
}

fn to_int(p: &Point) -> IntPoint<i32> {
    IntPoint::new(p[0], p[1])
}

fn to_shapes<'a>(polygons: impl Iterator<Item = &'a Polygon>) -> IntShapes<i32> {
    polygons.map(|p| p.rings().map(|r| r.iter().map(to_int).collect()).collect()).collect()
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
    use proptest::prelude::*;

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

    proptest! {
        #[test]
        fn what_is_worked_on_by_place_is_what_is_worked_on_at_once(
            places in prop::collection::vec((0..40, 0..40, 1..4, 1..4), 65..160),
        ) {
            let all: Vec<Ring> = places.iter().map(|&(x, y, w, h)| rectangle(x * 90, y * 90, (x + w) * 90, (y + h) * 90)).collect();
            let at_once = all.chunks(MAX_AT_ONCE).map(region).fold(MultiPolygon::default(), |a, b| {
                let mut overlay = empty(0);
                for ring in a.rings().chain(b.rings()) {
                    overlay.add_path_iter(ring.iter().map(to_int), ShapeType::Subject);
                }
                from_int(overlay.overlay(OverlayRule::Subject, Rule::NonZero))
            });
            let (places, squares) = (region(&all), region(&[rectangle(0, 0, 2_000, 4_000)]));
            let is_same = |a: &MultiPolygon, b: &MultiPolygon| (a.area_m2() - b.area_m2()).abs() < 1e-9;
            prop_assert!(is_same(&places, &at_once));
            prop_assert!(difference(&places, &at_once).is_empty());
            let parts = intersection(&places, &squares).area_m2() + difference(&places, &squares).area_m2();
            prop_assert!((parts - places.area_m2()).abs() < 1e-9);
            let (grown, grown_at_once) = (offset(&places, 4).unwrap(), to_shapes(places.0.iter()));
            let style = IntOutlineStyle::new(4).line_join(IntLineJoin::Miter(Angle::from_radians(SHARPEST_RAD).unwrap()));
            prop_assert!(is_same(&grown, &from_int(grown_at_once.outline(&style).unwrap())));
        }
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
