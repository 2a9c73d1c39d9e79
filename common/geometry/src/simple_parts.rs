//! Regions as simple polygons: without holes, and with outlines that touch themselves nowhere.

use crate::overlay::{FillRule, difference, intersection, union};
use crate::polygon::{Bounds, MultiPolygon, Point, Polygon, Ring};
use std::cmp::Ordering;

/// Counter-clockwise outlines that cover the region and nothing else, overlap nowhere, and share no points with themselves.
///
/// What has a hole, or a corner in which it touches itself, is cut in two through the middle one of them, along the axis on
/// which these lie farther apart, and so on: as many cuts as holes, and few that meet others.
pub fn simple_parts(region: &MultiPolygon) -> Vec<Ring> {
    let mut found = Vec::new();
    let mut waiting: Vec<Polygon> = region.0.iter().rev().cloned().collect();
    while let Some(polygon) = waiting.pop() {
        match cut_through(&polygon) {
            None => found.push(polygon.exterior),
            Some(half) => {
                let whole = MultiPolygon(vec![polygon]);
                let halves = [intersection(&whole, &half), difference(&whole, &half)];
                waiting.extend(halves.into_iter().rev().flat_map(|half| half.0.into_iter().rev()));
            }
        }
    }
    found
}

/// The part of the plane on one side of a cut that takes a polygon nearer to simple ones; `None` for a simple one.
fn cut_through(polygon: &Polygon) -> Option<MultiPolygon> {
    let middle = |ring: &Ring| {
        let Bounds { min, max } = Bounds::of(ring.iter().copied())?;
        Some([0, 1].map(|k| min[k] + (max[k] - min[k]) / 2))
    };
    let mut places: Vec<Point> = polygon.holes.iter().filter_map(middle).collect();
    places.extend(repeated(&polygon.exterior));
    let spread = Bounds::of(places.iter().copied())?;
    let extent = |k: usize| i64::from(spread.max[k]) - i64::from(spread.min[k]);
    let axis = match extent(0).cmp(&extent(1)) {
        Ordering::Less => 1,
        Ordering::Equal | Ordering::Greater => 0,
    };
    places.sort_unstable_by_key(|place| (place[axis], place[1 - axis]));
    let at = places[places.len() / 2][axis];
    let Bounds { min, mut max } = Bounds::of(polygon.exterior.iter().copied())?;
    max[axis] = at;
    let half = vec![min, [max[0], min[1]], max, [min[0], max[1]]];
    Some(union(&[half], FillRule::NonZero))
}

/// Corners in which a ring is twice.
fn repeated(ring: &Ring) -> Vec<Point> {
    let mut corners = ring.clone();
    corners.sort_unstable();
    let mut twice: Vec<Point> = corners.windows(2).filter(|pair| pair[0] == pair[1]).map(|pair| pair[0]).collect();
    twice.dedup();
    twice
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::polygon::ring_area_doubled;
    use crate::simple_rings::region_of_simple_rings;
    use proptest::prelude::*;

    fn cell(x: i32, y: i32) -> Ring {
        let [x, y] = [x * 500, y * 500];
        vec![[x, y], [x + 500, y], [x + 500, y + 500], [x, y + 500]]
    }

    fn region(cells: &[[i32; 2]]) -> MultiPolygon {
        union(&cells.iter().map(|&[x, y]| cell(x, y)).collect::<Vec<_>>(), FillRule::NonZero)
    }

    #[test]
    fn a_frame_is_cut_once() {
        let frame: Vec<[i32; 2]> =
            (0..5).flat_map(|x| (0..5).map(move |y| [x, y])).filter(|&[x, y]| [x, y] != [2, 2]).collect();
        let parts = simple_parts(&region(&frame));
        assert_eq!(parts.len(), 2);
        assert!(parts.iter().all(|part| part.len() == 8), "{parts:?}");
    }

    #[test]
    fn what_touches_itself_in_a_corner_is_cut_there() {
        // A ring of cells that meets its own end across a corner.
        let parts = simple_parts(&region(&[[1, 0], [2, 0], [2, 1], [2, 2], [1, 2], [0, 2], [0, 1]]));
        assert!(parts.iter().all(|part| repeated(part).is_empty()), "{parts:?}");
        assert!(parts.len() > 1);
    }

    proptest! {
        #[test]
        fn parts_are_simple_and_cover_the_cells_once(bits in prop::collection::vec(0..4u8, 100)) {
            let cells: Vec<[i32; 2]> =
                (0..100).filter(|&k| bits[k as usize] != 0).map(|k| [k % 10, k / 10]).collect();
            let parts = simple_parts(&region(&cells));
            let area: i128 = parts.iter().map(|part| ring_area_doubled(part)).sum();
            prop_assert_eq!(area, 2 * 500 * 500 * cells.len() as i128);
            for part in &parts {
                prop_assert!(ring_area_doubled(part) > 0);
                prop_assert!(repeated(part).is_empty());
                if part.len() <= 32 {
                    prop_assert!(region_of_simple_rings(std::slice::from_ref(part)).is_some(), "{:?}", part);
                }
            }
            let covered = union(&parts, FillRule::NonZero);
            prop_assert_eq!(difference(&region(&cells), &covered), MultiPolygon::default());
        }
    }
}
