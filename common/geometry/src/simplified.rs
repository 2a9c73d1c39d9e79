//! Regions with fewer corners: the algorithm of Douglas and Peucker, ring by ring.

use crate::overlay::{FillRule, union};
use crate::polygon::{MultiPolygon, Point, Ring, ring_area_doubled};

/// The region with those corners of its outlines only from which straight lines deviate more than `tolerance` tenths of a
/// millimetre. Holes that lose their area are filled; exteriors that would lose theirs keep more corners.
pub fn simplified(region: &MultiPolygon, tolerance: i32) -> MultiPolygon {
    let mut rings: Vec<Ring> = Vec::new();
    for polygon in &region.0 {
        rings.push(exterior(&polygon.exterior, tolerance));
        rings.extend(polygon.holes.iter().map(|hole| corners_kept(hole, tolerance)).filter(has_area));
    }
    if rings.iter().map(Vec::len).sum::<usize>() == region.rings().map(Vec::len).sum() {
        return region.clone();
    }
    // Lines that are moved may cross where the region is narrow.
    union(&rings, FillRule::NonZero)
}

/// A thin plate has an area, however large the tolerance.
fn exterior(ring: &Ring, tolerance: i32) -> Ring {
    let mut tolerance = tolerance;
    while tolerance > 0 {
        let kept = corners_kept(ring, tolerance);
        if ring_area_doubled(&kept) > 0 {
            return kept;
        }
        tolerance /= 2;
    }
    ring.clone()
}

fn has_area(ring: &Ring) -> bool {
    ring_area_doubled(ring) != 0
}

/// The ring between its first corner and the one farthest from it, and between that and the first.
fn corners_kept(ring: &Ring, tolerance: i32) -> Ring {
    let Some(&first) = ring.first() else { return Ring::new() };
    let squared = |p: &Point| (0..2).map(|k| (i128::from(p[k]) - i128::from(first[k])).pow(2)).sum::<i128>();
    // Of equal ones the first.
    let farthest = (0..ring.len()).rev().max_by_key(|&k| squared(&ring[k])).unwrap_or(0);
    let mut is_kept = vec![false; ring.len() + 1];
    is_kept[0] = true;
    is_kept[farthest] = true;
    let closed: Ring = ring.iter().copied().chain([first]).collect();
    let mut waiting = vec![(0, farthest), (farthest, ring.len())];
    while let Some((start, end)) = waiting.pop() {
        let off = |k: usize| distance(closed[k], [closed[start], closed[end]]);
        let Some(worst) = (start + 1..end).max_by(|&a, &b| off(a).total_cmp(&off(b))) else { continue };
        if off(worst) > f64::from(tolerance) {
            is_kept[worst] = true;
            waiting.extend([(start, worst), (worst, end)]);
        }
    }
    ring.iter().zip(is_kept).filter(|(_, kept)| *kept).map(|(p, _)| *p).collect()
}

/// Distance of a point from a line between two others.
fn distance(p: Point, [a, b]: [Point; 2]) -> f64 {
    let between = |from: Point, to: Point| [0, 1].map(|k| f64::from(to[k]) - f64::from(from[k]));
    let (along, to_point) = (between(a, b), between(a, p));
    let squared = along[0] * along[0] + along[1] * along[1];
    let place = if squared == 0.0 { 0.0 } else { (along[0] * to_point[0] + along[1] * to_point[1]) / squared };
    let place = place.clamp(0.0, 1.0);
    let off = [0, 1].map(|k| to_point[k] - place * along[k]);
    (off[0] * off[0] + off[1] * off[1]).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::polygon::Polygon;

    fn region(exterior: Ring, holes: Vec<Ring>) -> MultiPolygon {
        MultiPolygon(vec![Polygon { exterior, holes }])
    }

    #[test]
    fn a_circle_of_many_corners_keeps_few_and_stays_within_the_tolerance() {
        let angle = |k: i32| std::f64::consts::TAU * f64::from(k) / 2_000.0;
        let at = |k: i32| [libm::cos(angle(k)), libm::sin(angle(k))].map(|c| (5_000.0 * c).round() as i32);
        let circle: Ring = (0..2_000).map(at).collect();
        let found = simplified(&region(circle.clone(), Vec::new()), 50);
        let [polygon] = &found.0[..] else { panic!("{found:?}") };
        assert!(polygon.exterior.len() < 40, "{}", polygon.exterior.len());
        let n = polygon.exterior.len();
        let off = |p: &Point| {
            (0..n).map(|k| distance(*p, [polygon.exterior[k], polygon.exterior[(k + 1) % n]])).fold(f64::MAX, f64::min)
        };
        assert!(circle.iter().all(|p| off(p) <= 51.0));
    }

    #[test]
    fn a_thin_plate_stays_and_a_pinhole_goes() {
        let plate = vec![[0, 0], [20_000, 0], [20_000, 10], [0, 10]];
        assert_eq!(simplified(&region(plate.clone(), Vec::new()), 50).area_m2(), 0.002);
        let square = vec![[0, 0], [20_000, 0], [20_000, 20_000], [0, 20_000]];
        let pinhole = vec![[500, 500], [500, 510], [510, 510], [510, 500]];
        assert_eq!(simplified(&region(square, vec![pinhole]), 50).area_m2(), 4.0);
    }
}
