//! Ends of a stair: the places at which it joins floors.

use crate::climb::{LANDING, MAX_RISE, ONE_LEVEL, highest_rise, touch, usual_rise};
use frames::{Map, Point2, TENTHS_PER_M};
use geometry::{Tread, treads};
use grid::Class;
use messages::Site;

/// A landing at a floor is at least so large.
const LEAST_LANDING_M2: f64 = 0.5;

/// The level faces of a stair, from low to high.
pub(crate) fn stair_treads(site: &Site<'_>, elements: &[usize]) -> Vec<Tread> {
    let parts = elements.iter().map(|&e| &site.elements[e]).filter(|e| e.class() != Class::Railing);
    treads(parts.flat_map(|e| site.element_meshes(e)))
}

/// Where one steps onto a stair from a floor of this height, or off it: before its lowest tread above the floor and behind its
/// highest below, or all around a landing at the floor's height. None where it has no level faces there.
///
/// `levels` are the heights of other floors that are so near that the stair may lead to them instead: where there are any,
/// one gets onto the stair only where it begins, ends or has a landing, and only from the floor that is nearest to that end.
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
            // Half a tread beyond its middle, away from the next.
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

/// True if one steps from any of these treads to another: a stair whose ends are known.
pub(crate) fn is_flight(steps: &[Tread]) -> bool {
    let highest = highest_rise(steps);
    steps.iter().any(|tread| steps.iter().any(|next| follows(tread, next, true, highest)))
}

fn point([x, y]: [f64; 2]) -> Point2<Map> {
    Point2::new(x / f64::from(TENTHS_PER_M), y / f64::from(TENTHS_PER_M))
}

/// True if `next` is the tread that one steps onto from `tread`, upward or downward.
fn follows(tread: &Tread, next: &Tread, is_up: bool, highest: i32) -> bool {
    let rise = if is_up { next.z - tread.z } else { tread.z - next.z };
    (1..=highest).contains(&rise) && touch(&tread.plan, &next.plan)
}

/// True if the stair begins with this tread (`is_up`) or ends with it, and the floor there is this one rather than another
/// level: the floor may be flush with the tread, or a rise beyond it.
fn is_end(steps: &[Tread], tread: &Tread, is_up: bool, floor_z: i32, levels: &[i32]) -> bool {
    let highest = highest_rise(steps);
    let beyond = tread.z + if is_up { -usual_rise(steps) } else { usual_rise(steps) };
    let far = |z: i32| (z - tread.z).abs().min((z - beyond).abs());
    let goes_on = |is_up: bool| steps.iter().any(|next| follows(tread, next, is_up, highest));
    goes_on(is_up) && !goes_on(!is_up) && levels.iter().all(|level| far(floor_z) <= far(*level))
}

/// Tells landings from treads.
fn landings(steps: &[Tread]) -> impl Fn(&Tread) -> bool {
    let mut areas: Vec<f64> = steps.iter().map(|t| t.plan.area_m2()).collect();
    areas.sort_by(f64::total_cmp);
    let least_m2 = areas.get(areas.len() / 2).map_or(0.0, |usual| LANDING * usual).max(LEAST_LANDING_M2);
    move |t| t.plan.area_m2() >= least_m2
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::climb::tests::{GOING_M, Stairwell};
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
            assert!((ends[0].x_m - x_m).abs() < 1e-3 && (ends[0].y_m - 0.5).abs() < 1e-3, "{ends:?}");
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
