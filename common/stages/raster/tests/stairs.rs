//! Stairs as floor of robots that drive on them: which treads are free, at which heights, and where they break off.

mod support;

use grid::Class;
use messages::*;
use proptest::prelude::*;
use support::{Drawn, House};

const FREE: i8 = 0;
const OCCUPIED: i8 = 100;
const UNKNOWN: i8 = -1;

/// A robot in whose maps stairs are floor.
const CLIMBER: RobotProfile = RobotProfile { climbs_stairs: 1, stair_cost: 60, ..RobotProfile::DEFAULT };

const TREADS: u32 = 12;
const GOING_M: f64 = 0.3;

/// A floor of 6 m by 6 m, and a flight 2 m wide that leaves it to the east at x = 6, of solid steps that rise by `riser_m` each.
fn flight(riser_m: f64) -> House {
    let mut house = House { bounds_m: [-1.0, -1.0, 12.0, 7.0], ..House::empty() };
    house.slab([0.0, 0.0], [6.0, 6.0], 0.0);
    for k in 0..TREADS {
        let (x, top) = (6.0 + f64::from(k) * GOING_M, f64::from(k + 1) * riser_m);
        house.tread([x, 2.0, -0.2], [x + GOING_M, 4.0, top]);
    }
    house
}

/// Planning value, class and height in metres in the middle of each tread.
fn along(drawn: &Drawn) -> Vec<(i8, Class, Option<f64>)> {
    let at = |k: u32| drawn.at(6.0 + (f64::from(k) + 0.5) * GOING_M, 3.05);
    let grid = drawn.grid();
    let class = |cell: usize| Class::ALL[usize::from(grid.class[cell])];
    (0..TREADS).map(at).map(|c| (grid.planning[c], class(c), grid.height_tenths(c).map(frames::metres))).collect()
}

#[test]
fn each_tread_is_free_at_its_height_and_shows_that_it_is_a_stair() {
    let drawn = flight(0.17).map_at(|_| {}, &CLIMBER);
    for (k, (planning, class, height_m)) in (1u32..).zip(along(&drawn)) {
        assert_eq!((planning, class), (FREE, Class::Stair), "tread {k}");
        assert!((height_m.unwrap() - 0.17 * f64::from(k)).abs() < 1e-9, "tread {k}: {height_m:?}");
    }
    let way: Vec<i8> = (0..90).map(|k| drawn.planning(0.55 + f64::from(k) * 0.1, 3.05)).collect();
    assert!(way.iter().all(|&p| p == FREE), "no riser is in the way: {way:?}");
}

#[test]
fn for_other_robots_a_stair_is_an_obstacle() {
    for robot in [RobotProfile::DEFAULT, RobotProfile { stair_cost: 0, ..CLIMBER }] {
        let drawn = flight(0.17).map_at(|_| {}, &robot);
        // What is above the robot's head is none of its business.
        let low = along(&drawn).into_iter().take(7);
        assert!(low.into_iter().all(|(planning, class, _)| (planning, class) == (OCCUPIED, Class::Stair)));
        assert!(drawn.grid().elevation.is_empty());
    }
}

#[test]
fn a_lidar_on_the_floor_meets_the_risers_of_a_stair_on_which_the_robot_drives() {
    let drawn = flight(0.17).map_at(|_| {}, &CLIMBER);
    let seen: Vec<i8> = (0..12).map(|k| drawn.localization(5.55 + f64::from(k) * 0.1, 3.05)).collect();
    // The second riser, at x = 6.3, is the first above the lidar's 0.3 m.
    assert_eq!(seen, [0, 0, 0, 0, 0, 0, 0, 0, 100, 100, -1, -1]);
}

#[test]
fn treads_of_a_closed_room_are_no_obstacles_that_show_a_stair() {
    let mut house = flight(0.17);
    house.space([6.0, 0.0], [9.6, 6.0]);
    let closed = |state: &mut ScheduleStateBuilder| state.spaces[0].state = SpaceState::Blocked.into();
    let drawn = house.map_at(closed, &CLIMBER);
    assert!(along(&drawn).iter().all(|&(planning, class, _)| (planning, class) == (OCCUPIED, Class::None)));
}

#[test]
fn a_door_before_a_flight_stays_open() {
    // The door of the house leads south onto treads that go down along the whole wall.
    let planned = |robot: &RobotProfile| {
        let mut house = House::new();
        house.door(0.8, DoorCapability::Swing);
        for k in 0..5 {
            let (y, top) = (-0.2 - f64::from(k) * GOING_M, -f64::from(k + 1) * 0.17);
            house.tread([0.0, y - GOING_M, top - 0.3], [4.0, y, top]);
        }
        house.map_at(|_| {}, robot).passage()
    };
    assert_eq!(planned(&CLIMBER), DoorPassage::Passable);
}

#[test]
fn risers_that_are_too_high_lead_nowhere() {
    let drawn = flight(0.26).map_at(|_| {}, &CLIMBER);
    assert!(along(&drawn).iter().take(4).all(|&(planning, ..)| planning == OCCUPIED));
}

#[test]
fn what_stands_on_a_tread_is_in_the_way_and_what_hangs_over_it_too() {
    let mut house = flight(0.17);
    // On the third tread, at 0.51 m; over the tenth, at 1.7 m.
    house.add(Class::Furniture, [6.65, 2.0, 0.5], [6.85, 2.6, 0.7]);
    house.add(Class::Beam, [8.75, 2.0, 2.8], [8.95, 4.0, 3.0]);
    house.add(Class::Railing, [6.0, 3.9, 0.0], [9.6, 4.0, 3.0]);
    let drawn = house.map_at(|_| {}, &CLIMBER);
    assert_eq!([2.3, 3.3].map(|y| drawn.planning(6.75, y)), [OCCUPIED, FREE]);
    assert_eq!([2.3, 3.3].map(|y| drawn.planning(8.85, y)), [OCCUPIED; 2], "1.1 m are too low for it");
    assert!((0..TREADS).all(|k| drawn.planning(6.15 + f64::from(k) * GOING_M, 3.95) == OCCUPIED));
}

#[test]
fn a_flight_that_leads_down_begins_at_the_edge_of_the_floor() {
    // The edge runs through a cell.
    let mut house = House { bounds_m: [-1.0, -1.0, 12.0, 7.0], ..House::empty() };
    house.slab([0.0, 0.0], [6.03, 6.0], 0.0);
    for k in 0..TREADS {
        let (x, top) = (6.03 + f64::from(k) * GOING_M, -f64::from(k + 1) * 0.17);
        house.tread([x, 2.0, top - 0.3], [x + GOING_M, 4.0, top]);
    }
    let drawn = house.map_at(|_| {}, &CLIMBER);
    let way: Vec<i8> = (0..90).map(|k| drawn.planning(0.55 + f64::from(k) * 0.1, 3.05)).collect();
    assert!(way.iter().all(|&p| p == FREE), "{way:?}");
    let height = |x: f64| drawn.grid().height_tenths(drawn.at(x, 3.05));
    assert_eq!([height(6.05), height(6.15), height(9.55)], [Some(0), Some(-1_700), Some(-20_400)]);
}

#[test]
fn beside_floor_a_flight_breaks_off_where_it_is_higher_than_a_riser() {
    let mut house = flight(0.17);
    house.slab([6.0, 0.0], [11.0, 6.0], 0.0);
    let drawn = house.map_at(|_| {}, &CLIMBER);
    let side = |k: u32| drawn.planning(6.15 + f64::from(k) * GOING_M, 2.05);
    assert_eq!([side(0), side(2), side(5)], [FREE, UNKNOWN, UNKNOWN], "one steps off the first tread");
    assert_eq!([2.25, 2.55].map(|y| drawn.keepout(7.65, y)), [100, -1], "with the margin of an edge");
}

#[test]
fn a_flight_that_is_not_built_yet_leads_nowhere_and_one_without_its_lower_part_neither() {
    let planned = |missing: std::ops::Range<usize>| {
        flight(0.17).map_at(
            |state| {
                state.head.plan_time_s = 7;
                missing.clone().for_each(|k| state.effective[1 + k] = ElementState::NotStarted.into());
            },
            &CLIMBER,
        )
    };
    assert!(along(&planned(0..12)).iter().all(|&(planning, ..)| planning == UNKNOWN));
    let upper = along(&planned(0..3));
    assert!(upper[..3].iter().all(|&(planning, ..)| planning == UNKNOWN), "{upper:?}");
    assert_eq!(upper[6].0, FREE, "it is floor, and no way leads there");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]
    /// Against the height of the highest tread under the middle of each cell, without polygons or patches.
    #[test]
    fn cells_of_a_flight_have_the_heights_of_its_treads(
        // In tenths of a millimetre, as sites keep lengths.
        treads in prop::collection::vec((2_500i32..5_000, 1_000i32..2_000), 3..10),
        width in 1.0f64..3.0,
        thickness in 0.05f64..0.5,
    ) {
        let mut house = House { bounds_m: [-1.0, -1.0, 12.0, 7.0], ..House::empty() };
        house.slab([0.0, 0.0], [6.0, 6.0], 0.0);
        let (mut x, mut z, mut tops) = (60_000, 0, Vec::new());
        for &(going, riser) in &treads {
            let bottom = frames::metres(z) - thickness;
            z += riser;
            house.tread([frames::metres(x), 2.0, bottom], [frames::metres(x + going), 2.0 + width, frames::metres(z)]);
            tops.push((x, x + going, z));
            x += going;
        }
        let drawn = house.map_at(|_| {}, &CLIMBER);
        let grid = drawn.grid();
        let n_rows = (width / 0.1) as u32 - 1;
        let n_columns = ((x - 60_000) / 1_000 - 1) as usize;
        for (low_x, row) in (60_000..).step_by(1_000).take(n_columns).flat_map(|x| (0..n_rows).map(move |row| (x, row))) {
            let cell = drawn.at(frames::metres(low_x) + 0.05, 2.05 + f64::from(row) * 0.1);
            // A cell over which a riser runs shows the upper tread.
            let under = tops.iter().rev().find(|(from, to, _)| *from < low_x + 1_000 && low_x < *to).unwrap();
            prop_assert_eq!(grid.planning[cell], FREE, "at {} {}", low_x, row);
            prop_assert_eq!(grid.height_tenths(cell), Some(under.2), "at {} {}", low_x, row);
        }
    }
}
