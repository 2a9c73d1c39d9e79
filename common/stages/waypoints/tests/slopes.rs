//! Time and energy of ways and tours over slopes, and ways that are chosen by them.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

mod support;

use frames::Point2;
use messages::{DriveModel, WayCost, WaypointKind};
use proptest::prelude::*;
use support::planned::with_finder;
use support::{GROUND, House, quick};
use waypoints::{Driven, FloorLeg, MissionPlanOptions, Way, WayEnd, WayLeg};

/// A hall of 12 m by 6 m.
const HALL: &str = "
##############################################################
#aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa#
#aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa#
#aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa#
#aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa#
#aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa#
#aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa#
#aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa#
#aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa#
#aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa#
#aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa#
#aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa#
#aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa#
#aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa#
#aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa#
#aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa#
#aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa#
#aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa#
#aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa#
#aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa#
#aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa#
#aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa#
#aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa#
#aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa#
#aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa#
#aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa#
#aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa#
#aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa#
#aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa#
#aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa#
##############################################################";

const GRAVITY_M_S2: f64 = 9.806_65;

/// Five metres of 8 %, level before and behind.
fn ramp([x, _]: [f64; 2]) -> f64 {
    0.08 * (x - 3.0).clamp(0.0, 5.0)
}

/// A ridge across the hall, 0.4 m high, through which a pass leads at the north.
fn ridge([x, y]: [f64; 2]) -> f64 {
    0.4 * (1.0 - (x - 6.0).abs() / 2.5).max(0.0) * ((4.8 - y) / 2.0).clamp(0.0, 1.0)
}

/// A dish: the straight way through the middle falls and climbs.
fn dish([x, y]: [f64; 2]) -> f64 {
    0.03 * ((x - 6.0) * (x - 6.0) + (y - 3.0) * (y - 3.0)).min(16.0)
}

/// A plane that rises to the north-east.
fn plane([x, y]: [f64; 2]) -> f64 {
    0.08 * x + 0.05 * y
}

const RELIEFS: [fn([f64; 2]) -> f64; 4] = [ramp, ridge, dish, plane];

/// Of a robot of 100 kg that needs ten seconds more for each metre of climb.
const DRIVE: DriveModel = DriveModel { climb_s_per_m: 10.0, mass_kg: 100.0, idle_w: 20.0, ..DriveModel::DEFAULT };

fn by(cost: WayCost) -> DriveModel {
    DriveModel { cost: cost.into(), ..DRIVE }
}

fn hall(relief: fn([f64; 2]) -> f64) -> House {
    House { relief: Some(relief), ..House::drawn(&[HALL]) }
}

fn way(house: &House, drive: DriveModel, [from, to]: [[f64; 2]; 2]) -> Way {
    let options = MissionPlanOptions { kinds: [WaypointKind::Centre].into(), drive, ..quick() };
    let end = |[x, y]: [f64; 2]| WayEnd::Point { map_storey: 0, at: Point2::new(x, y) };
    with_finder(house, &options, |finder, _, _| finder.way(end(from), end(to)).unwrap())
}

fn only_leg(way: &Way) -> &FloorLeg {
    let [WayLeg::Floor(leg)] = &way.legs[..] else { panic!("{way:?}") };
    leg
}

fn measured(cost: WayCost, way: &Way) -> f64 {
    match cost {
        WayCost::Length => way.length_m,
        WayCost::Time => way.driven.duration_s,
        WayCost::Energy => way.driven.energy_j,
    }
}

#[test]
fn a_way_up_a_ramp_of_8_percent_takes_what_its_length_and_climb_say() {
    let up = way(&hall(ramp), DRIVE, [[1.05, 3.05], [11.05, 3.05]]);
    let leg = only_leg(&up);
    assert!((leg.climb_m - 0.4).abs() < 1e-9 && leg.descent_m == 0.0, "{leg:?}");
    assert!((leg.length_m - (5.0 + libm::hypot(5.0, 0.4))).abs() < 1e-3, "{leg:?}");
    assert!((up.driven.duration_s - (leg.length_m / 0.5 + 4.0)).abs() < 1e-9, "{up:?}");
    let work_j = 100.0 * GRAVITY_M_S2 * (0.4 + 0.02 * 10.0);
    assert!((up.driven.energy_j - (work_j / 0.7 + 20.0 * up.driven.duration_s)).abs() < 1e-6, "{up:?}");
    // Down the ramp the slope of 8 % drives it, which rolls at 2 %.
    let down = way(&hall(ramp), DRIVE, [[11.05, 3.05], [1.05, 3.05]]);
    assert!((down.driven.duration_s - leg.length_m / 0.5).abs() < 1e-9, "{down:?}");
    let level_j = 100.0 * GRAVITY_M_S2 * 0.02 * 5.0 / 0.7;
    // The cells at foot and head slope half as much.
    assert!((down.driven.energy_j - (level_j + 20.0 * down.driven.duration_s)).abs() < 5.0, "{down:?}");
}

#[test]
fn a_way_leads_over_the_ridge_or_through_the_pass_as_its_cost_is() {
    let (house, ends) = (hall(ridge), [[1.05, 1.55], [11.05, 1.55]]);
    let by_cost = |cost: WayCost| way(&house, DriveModel { climb_s_per_m: 60.0, ..by(cost) }, ends);
    let northmost = |way: &Way| only_leg(way).line.iter().map(|p| p.y_m()).fold(0.0, f64::max);
    let [shortest, fastest, least] = WayCost::ALL.map(by_cost);
    assert!(northmost(&shortest) < 1.7 && only_leg(&shortest).climb_m > 0.39, "{shortest:?}");
    assert!(northmost(&fastest) > 4.0 && only_leg(&fastest).climb_m < 0.1, "{fastest:?}");
    assert!(only_leg(&least).climb_m < 0.3, "{least:?}");
    assert!(fastest.length_m > shortest.length_m + 0.5);
    assert!(fastest.driven.duration_s < shortest.driven.duration_s - 10.0, "{fastest:?} {shortest:?}");
    assert!(least.driven.energy_j < 0.95 * shortest.driven.energy_j, "{least:?} {shortest:?}");
}

#[test]
fn tours_and_edges_take_time_and_energy_of_their_slopes_and_flat_ones_what_they_took() {
    let plan = |house: &House, drive: DriveModel| {
        let planned = house.planned(&MissionPlanOptions { kinds: [WaypointKind::Centre].into(), drive, ..quick() });
        let plan = planned.mission_plan();
        let (head, storey, edges) = (*plan.head, plan.storeys[0], plan.edges.to_vec());
        (head, storey, edges)
    };
    let mut house = House::drawn(&[GROUND]);
    let (flat, flat_storey, _) = plan(&house, DriveModel::DEFAULT);
    let (asked, ..) = plan(&house, by(WayCost::Time));
    assert_eq!(flat.mission_s, [flat_storey.tour_m / 0.5, 0.0]);
    assert_eq!((flat.mission_s, flat.mission_j), (asked.mission_s, 0.0), "nothing climbs");
    let rolls_j = 100.0 * GRAVITY_M_S2 * 0.02 / 0.7 * flat_storey.tour_m;
    assert!((asked.mission_j - (rolls_j + 20.0 * asked.mission_s[0])).abs() < 1e-6, "{asked:?}");

    house.relief = Some(plane);
    let (usual, storey, _) = plan(&house, DriveModel::DEFAULT);
    assert_eq!(usual.mission_s[0], storey.tour_m / 0.5);
    assert!(storey.tour_m > flat_storey.tour_m, "it is as long as the slope");
    let (sloped, _, edges) = plan(&house, DRIVE);
    assert!(sloped.mission_s[0] > usual.mission_s[0]);
    for edge in edges.iter().filter(|edge| edge.usable == 1 && edge.length_m > 0.0) {
        // On a plane each way climbs the one way and falls the other.
        let [there_s, back_s] = edge.duration_s;
        let climb_m = (there_s + back_s - 2.0 * edge.length_m / 0.5) / 10.0;
        assert!(there_s.min(back_s) >= edge.length_m / 0.5 - 1e-9 && climb_m >= -1e-9, "{edge:?}");
        assert!(climb_m <= edge.length_m * libm::sin(edge.slope_rad) + 0.02, "{edge:?}");
        assert!(edge.energy_j.iter().all(|energy_j| *energy_j > 0.0), "{edge:?}");
    }
}

#[test]
fn a_budget_of_minutes_pays_for_climbing() {
    let mut house = House::drawn(&[GROUND]);
    house.relief = Some(plane);
    let scans = |climb_s_per_m: f64| {
        let drive = DriveModel { climb_s_per_m, ..DriveModel::DEFAULT };
        let options = MissionPlanOptions { minutes_max: Some(4.0), coverage: 1.0, drive, ..quick() };
        let planned = house.planned(&options);
        let minutes = planned.mission_plan().head.mission_s.iter().sum::<f64>() / 60.0;
        assert!(planned.scans().is_empty() || minutes <= 4.0, "{minutes}");
        planned.scans().len()
    };
    assert!(scans(0.0) > scans(200.0), "{} {}", scans(0.0), scans(200.0));
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, ..ProptestConfig::default() })]

    /// By length nothing depends on the drive; by time or energy a way takes no more of it than the shortest.
    #[test]
    fn a_way_takes_no_more_than_the_shortest_and_the_shortest_is_that_of_before(
        relief in 0usize..4, from in (0.6..11.6_f64, 0.6..5.4_f64), to in (0.6..11.6_f64, 0.6..5.4_f64), climb_s_per_m in 0.0..80.0_f64,
    ) {
        let (house, ends) = (hall(RELIEFS[relief]), [[from.0, from.1], [to.0, to.1]]);
        let without_costs = |mut way: Way| {
            way.driven = Driven::default();
            for leg in &mut way.legs {
                match leg {
                    WayLeg::Floor(leg) => leg.driven = Driven::default(),
                    WayLeg::Portal(leg) => leg.driven = Driven::default(),
                }
            }
            way
        };
        let before = without_costs(way(&house, DriveModel::DEFAULT, ends));
        let shortest = way(&house, DriveModel { climb_s_per_m, ..DRIVE }, ends);
        for cost in [WayCost::Time, WayCost::Energy] {
            let found = way(&house, DriveModel { climb_s_per_m, ..by(cost) }, ends);
            prop_assert!(measured(cost, &found) <= measured(cost, &shortest), "{found:?} {shortest:?}");
            prop_assert!(found.length_m >= before.length_m - 0.2, "{found:?}");
        }
        prop_assert_eq!(without_costs(shortest), before);
    }
}
