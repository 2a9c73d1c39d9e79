//! Ends of a stair: the points at which it adjoins floors.

use crate::stair_traversal::{LANDING_SIZE_FACTOR, MAX_RISE, ONE_LEVEL, max_rise, touch, typical_rise};
use frames::{Map, Point2, TENTHS_PER_M};
use geometry::{Tread, treads};
use grid::Class;
use messages::Site;

/// Minimum area of a landing at a floor.
const MIN_LANDING_M2: f64 = 0.5;

/// The level faces of a stair, from low to high.
pub(crate) fn stair_treads(site: &Site<'_>, elements: &[usize]) -> Vec<Tread> {
    let parts = elements.iter().map(|&e| &site.elements[e]).filter(|e| e.class() != Class::Railing);
    treads(parts.flat_map(|e| site.element_meshes(e)))
}

/// Points of access to a stair from a floor at this height: before its lowest tread above the floor, behind its highest
/// tread below it, or around a landing at its height. Empty where the stair has no level faces there.
///
/// `levels` are heights of other floors nearby to which the stair may lead instead. With such levels there is access only
/// where the stair begins, ends or has a landing, and only from the nearest floor.
pub(crate) fn ends_at(steps: &[Tread], floor_z: i32, levels: &[i32]) -> Vec<Point2<Map>> {
    let up = |t: &Tread| t.z - floor_z;
    let leads_here = |t: &&Tread, is_up: bool| levels.is_empty() || is_end(steps, t, is_up, floor_z, levels);
    let is_landing = landings(steps);
    let at_floor = steps.iter().filter(|t| up(t).abs() <= ONE_LEVEL);
    let at_floor = at_floor.filter(|t| {
        let is_nearest = levels.iter().all(|level| up(t).abs() <= (level - t.z).abs());
        leads_here(t, true) || leads_here(t, false) || is_nearest && is_landing(t)
    });
    let corners = at_floor.flat_map(|t| t.plan.rings().flatten());
    let mut ends: Vec<Point2<Map>> = corners.map(|corner| point(corner.map(f64::from))).collect();
    let above = steps.iter().filter(|t| (ONE_LEVEL + 1..=MAX_RISE).contains(&up(t)) && leads_here(t, true));
    let below = steps.iter().filter(|t| (-MAX_RISE..-ONE_LEVEL).contains(&up(t)) && leads_here(t, false));
    for (z, is_up) in [(above.map(|t| t.z).min(), true), (below.map(|t| t.z).max(), false)] {
        for end in steps.iter().filter(|t| Some(t.z) == z && leads_here(t, is_up)) {
            let follows = |t: &&Tread| follows(end, t, is_up, MAX_RISE);
            // Half a tread beyond its middle, away from the next tread.
            ends.extend(
                steps
                    .iter()
                    .filter(follows)
                    .map(|next| point([0, 1].map(|k| end.centre[k] - (next.centre[k] - end.centre[k]) / 2.0))),
            );
        }
    }
    ends
}

/// True if any of these treads follows another, so that the ends are known.
pub(crate) fn is_flight(steps: &[Tread]) -> bool {
    let highest = max_rise(steps);
    steps.iter().any(|tread| steps.iter().any(|next| follows(tread, next, true, highest)))
}

fn point([x, y]: [f64; 2]) -> Point2<Map> {
    Point2::new(x / f64::from(TENTHS_PER_M), y / f64::from(TENTHS_PER_M))
}

/// True if `next` follows `tread`, upward or downward.
fn follows(tread: &Tread, next: &Tread, is_up: bool, highest: i32) -> bool {
    let rise = if is_up { next.z - tread.z } else { tread.z - next.z };
    (1..=highest).contains(&rise) && touch(&tread.plan, &next.plan)
}

/// True if the stair begins (`is_up`) or ends with this tread at this floor rather than at another level. The floor may be
/// flush with the tread or one rise beyond.
fn is_end(steps: &[Tread], tread: &Tread, is_up: bool, floor_z: i32, levels: &[i32]) -> bool {
    let highest = max_rise(steps);
    let beyond = tread.z + if is_up { -typical_rise(steps) } else { typical_rise(steps) };
    let far = |z: i32| (z - tread.z).abs().min((z - beyond).abs());
    let goes_on = |is_up: bool| steps.iter().any(|next| follows(tread, next, is_up, highest));
    goes_on(is_up) && !goes_on(!is_up) && levels.iter().all(|level| far(floor_z) <= far(*level))
}

/// Classifies treads as landings by their area.
fn landings(steps: &[Tread]) -> impl Fn(&Tread) -> bool {
    let mut areas: Vec<f64> = steps.iter().map(|t| t.plan.area_m2()).collect();
    areas.sort_by(f64::total_cmp);
    let min_m2 = areas.get(areas.len() / 2).map_or(0.0, |defaults| LANDING_SIZE_FACTOR * defaults).max(MIN_LANDING_M2);
    move |t| t.plan.area_m2() >= min_m2
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stair_traversal::tests::{GOING_M, Stairwell};
    use messages::NONE;

    fn steps_of(stairwell: &Stairwell) -> Vec<Tread> {
        let elements: Vec<usize> = (0..stairwell.0.elements.len()).collect();
        let site = stairwell.site();
        stair_treads(&Site::open(site.bytes()).unwrap(), &elements)
    }

    #[test]
    fn one_steps_onto_a_flight_before_its_lowest_step_and_off_it_behind_its_highest() {
        let mut stairwell = Stairwell::new();
        stairwell.flight(1.0, 1.0, 0.0, 0.0, 15);
        let steps = steps_of(&stairwell);
        for (floor_z, x_m) in [(0, 1.0), (28_000, 1.0 + 15.0 * GOING_M)] {
            let ends = ends_at(&steps, floor_z, &[]);
            assert_eq!(ends.len(), 1);
            assert!((ends[0].x_m() - x_m).abs() < 1e-3 && (ends[0].y_m() - 0.5).abs() < 1e-3, "{ends:?}");
        }
        assert!(ends_at(&steps, 50_000, &[]).is_empty());
    }

    #[test]
    fn of_levels_a_foot_apart_a_stair_leads_to_that_nearest_to_its_end() {
        let leads = |foot_m: f64, n: u32, floors: [i32; 2]| {
            let mut stairwell = Stairwell::new();
            stairwell.flight(1.0, 1.0, 0.0, foot_m, n);
            let steps = steps_of(&stairwell);
            [0, 1].map(|k| !ends_at(&steps, floors[k], &[floors[1 - k]]).is_empty())
        };
        assert_eq!(leads(0.0, 15, [0, 3_000]), [true, false], "it passes the upper level");
        assert_eq!(leads(0.3, 13, [0, 3_000]), [false, true]);
        // The highest tread is at 2.625 m, a rise below the floor, and nearer to the level below that.
        assert_eq!(leads(0.0, 15, [25_000, 28_000]), [false, true]);
        assert_eq!(leads(0.0, 15, [28_000, 31_000]), [true, false]);
        // The highest tread is flush with the floor.
        assert_eq!(leads(0.0, 16, [25_000, 28_000]), [false, true]);
        assert_eq!(leads(0.0, 16, [28_000, 31_000]), [true, false]);
    }

    #[test]
    fn landings_alone_are_no_flight() {
        let mut stairwell = Stairwell::new();
        for z in [0.0, 2.8] {
            stairwell.add(Class::Stair, NONE, Some([[1.0, 0.0, z - 0.2], [2.2, 1.0, z]]));
        }
        assert!(!is_flight(&steps_of(&stairwell)));
        stairwell.flight(2.2, 1.0, 0.0, 0.0, 7);
        assert!(is_flight(&steps_of(&stairwell)));
    }

    #[test]
    fn a_landing_at_a_level_leads_to_it_and_a_wide_tread_does_not() {
        let leads = |landing_m: f64| {
            let mut stairwell = Stairwell::new();
            stairwell.flight(1.0, 1.0, 0.0, 0.0, 7);
            let far = 1.0 + 7.0 * GOING_M;
            stairwell.add(Class::Stair, NONE, Some([[far, 0.0, 1.2], [far + landing_m, 1.0, 1.4]]));
            stairwell.flight(far + landing_m, 1.0, 0.0, 1.4, 7);
            !ends_at(&steps_of(&stairwell), 14_000, &[0, 28_000]).is_empty()
        };
        assert!(leads(1.2) && !leads(GOING_M));
    }
}
