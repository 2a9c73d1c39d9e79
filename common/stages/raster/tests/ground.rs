//! Ramps as floor of a storey: where they are free, what stands on them, where they break off.

mod support;

use grid::Class;
use messages::*;
use proptest::prelude::*;
use support::{Drawn, House};

const FREE: i8 = 0;
const OCCUPIED: i8 = 100;
const UNKNOWN: i8 = -1;

/// A yard of 6 m by 6 m, and a ramp 3 m wide that leaves it to the east and rises by `rise` over 10 m.
fn yard(rise: f64) -> House {
    let mut house = House { bounds_m: [-1.0, -1.0, 18.0, 7.0], ..House::empty() };
    house.slab([0.0, 0.0], [6.0, 6.0], 0.0);
    house.ramp([6.0, 1.5], [16.0, 4.5], [0.0, rise]);
    house
}

fn planning_along(drawn: &Drawn, y: f64) -> Vec<i8> {
    (0..100).map(|k| drawn.planning(6.05 + f64::from(k) * 0.1, y)).collect()
}

#[test]
fn a_ramp_within_the_limit_is_free_from_its_foot_to_its_head() {
    for rise in [0.8, -0.8] {
        let drawn = yard(rise).map();
        assert!(planning_along(&drawn, 3.0).iter().all(|&p| p == FREE), "{rise}: {:?}", planning_along(&drawn, 3.0));
        assert_eq!(drawn.planning(16.5, 3.0), UNKNOWN, "nothing is known behind its head");
        assert_eq!((drawn.keepout(15.95, 3.0), drawn.keepout(11.0, 3.0)), (100, -1), "it breaks off at its head alone");
        assert_eq!((drawn.keepout(11.0, 1.55), drawn.keepout(6.1, 3.0)), (100, -1), "and at its sides");
    }
}

#[test]
fn a_robot_that_may_not_climb_it_has_an_obstacle_there() {
    assert!(planning_along(&yard(1.4).map(), 3.0)[10..].iter().all(|&p| p == OCCUPIED), "14 % is too steep");
    let robot = RobotProfile { max_slope_rad: 0.05, ..RobotProfile::DEFAULT };
    let along = planning_along(&yard(0.8).map_at(|_| {}, &robot), 3.0);
    assert!(along[10..].iter().all(|&p| p == OCCUPIED), "{along:?}");
    let robot = RobotProfile { max_slope_rad: 0.2, ..RobotProfile::DEFAULT };
    assert!(planning_along(&yard(1.4).map_at(|_| {}, &robot), 3.0).iter().all(|&p| p == FREE));
}

#[test]
fn what_stands_on_a_ramp_is_in_the_way_by_its_height_above_the_ramp() {
    let mut house = yard(0.8);
    // At x = 14 the ramp is at 0.64 m: a beam at 1.5 m hangs 0.86 m above it, one at 2.0 m leaves room for the robot.
    house.add(Class::Beam, [14.0, 1.5, 1.5], [14.2, 4.5, 1.7]);
    house.add(Class::Beam, [12.0, 1.5, 2.0], [12.2, 4.5, 2.2]);
    // A kerb of 3 cm is a step that the robot takes, one of 10 cm is not.
    house.add(Class::Furniture, [9.0, 2.0, 0.2], [9.2, 2.6, 0.27]);
    house.add(Class::Furniture, [9.0, 3.5, 0.2], [9.2, 4.1, 0.356]);
    let drawn = house.map();
    let at = |x: f64, y: f64| (drawn.planning(x, y), Class::ALL[usize::from(drawn.grid().class[drawn.at(x, y)])]);
    assert_eq!(at(14.1, 3.0), (OCCUPIED, Class::Beam));
    assert_eq!(at(12.1, 3.0), (FREE, Class::None));
    assert_eq!(at(9.15, 2.3), (FREE, Class::None));
    assert_eq!(at(9.15, 3.8), (OCCUPIED, Class::Furniture));
}

#[test]
fn a_parapet_beside_a_ramp_bounds_it_and_the_lidar_sees_it() {
    let mut house = yard(0.8);
    house.add(Class::Wall, [6.0, 4.5, 0.7], [16.0, 4.7, 1.6]);
    let drawn = house.map();
    // At the head of the ramp the parapet stands a metre high, at its foot it hangs above the robot's lidar.
    assert_eq!((drawn.planning(15.5, 4.55), drawn.localization(15.5, 4.55)), (OCCUPIED, 100));
    assert_eq!((drawn.planning(6.5, 4.55), drawn.localization(6.5, 4.55)), (OCCUPIED, -1));
    assert_eq!(drawn.keepout(13.0, 4.35), -1, "behind a parapet nobody falls");
    assert_eq!(drawn.keepout(13.0, 1.65), 100);
}

#[test]
fn floor_under_a_ramp_counts_where_the_robot_fits_below() {
    let mut house = House { bounds_m: [-1.0, -1.0, 30.0, 7.0], ..House::empty() };
    house.slab([0.0, 0.0], [28.0, 6.0], 0.0);
    house.ramp([6.0, 1.5], [26.0, 4.5], [0.0, 2.0]);
    let drawn = house.map();
    // The underside is 1.25 m above the floor at x = 20.5, and the ramp itself 1.0 m at x = 16.
    assert_eq!(drawn.planning(24.0, 3.0), FREE, "the robot fits below");
    let along: Vec<i8> = (0..150).map(|k| drawn.planning(6.05 + f64::from(k) * 0.1, 3.0)).collect();
    assert!(along[..140].iter().all(|&p| p == FREE), "it drives on the ramp to 1.45 m, where it fits below: {along:?}");
    assert_eq!(drawn.planning(16.0, 1.45), FREE, "beside the ramp is floor");
    assert_eq!(drawn.planning(16.0, 1.55), UNKNOWN, "the ramp breaks off");
    assert_eq!(drawn.keepout(16.0, 1.75), 100);
}

#[test]
fn a_ramp_that_is_not_built_yet_leads_nowhere() {
    let drawn = yard(0.8).map_at(
        |state| {
            state.head.plan_time_s = 7;
            state.effective[1] = ElementState::NotStarted.into();
        },
        &RobotProfile::DEFAULT,
    );
    assert!(planning_along(&drawn, 3.0).iter().all(|&p| p == UNKNOWN));
    assert_eq!(drawn.keepout(5.95, 3.0), 100, "the yard ends in a drop-off");
}

#[test]
fn ground_that_nothing_leads_to_is_not_on_the_map() {
    let mut house = yard(0.8);
    house.ramp([6.0, 5.0], [16.0, 6.5], [0.3, 1.1]);
    let drawn = house.map();
    assert_eq!(drawn.planning(8.0, 5.5), OCCUPIED, "its body stands there");
    assert_eq!(drawn.planning(15.5, 5.5), OCCUPIED);
}

/// Terrain that rises by 5 % over 20 m, goes on level, falls by a metre and goes on; after that by 14 %.
fn outdoors() -> House {
    let mut house = House { floor: FloorKind::Ground, bounds_m: [0.0, 0.0, 50.0, 10.0], ..House::empty() };
    house.terrain([0.0, 0.0], [20.0, 10.0], [0.0, 1.0]);
    house.terrain([20.0, 0.0], [30.0, 10.0], [1.0, 1.0]);
    house.terrain([30.0, 0.0], [40.0, 10.0], [0.0, 0.0]);
    house.terrain([40.0, 0.0], [50.0, 10.0], [0.0, 1.4]);
    house
}

#[test]
fn terrain_within_the_limit_is_free_and_where_it_falls_is_a_drop_off() {
    let drawn = outdoors().map();
    let along: Vec<i8> = (0..500).map(|k| drawn.planning(0.05 + f64::from(k) * 0.1, 5.05)).collect();
    assert!(along[..299].iter().chain(&along[300..400]).all(|&p| p == FREE), "{along:?}");
    assert_eq!(along[299], UNKNOWN, "the upper cell at the step breaks off");
    assert!(along[400..].iter().all(|&p| p == UNKNOWN), "14 % are too steep for this robot");
    assert_eq!([28.0, 29.75, 29.95, 30.15, 31.0].map(|x| drawn.keepout(x, 5.05)), [-1, 100, 100, 100, -1]);
    assert_eq!(drawn.grid().height_tenths(drawn.at(10.05, 5.05)), Some(5_025));
    let robot = RobotProfile { max_slope_rad: 0.2, ..RobotProfile::DEFAULT };
    assert_eq!(outdoors().map_at(|_| {}, &robot).planning(45.0, 5.0), FREE);
}

#[test]
fn terrain_steeper_than_a_robot_may_stand_across_the_way_is_no_floor_and_a_ramp_as_steep_is() {
    let robot = RobotProfile { max_cross_slope_rad: 0.04, ..RobotProfile::DEFAULT };
    let drawn = outdoors().map_at(|_| {}, &robot);
    assert_eq!([10.0, 25.0].map(|x| drawn.planning(x, 5.0)), [UNKNOWN, FREE], "5 % and level");
    let wide = RobotProfile { max_cross_slope_rad: 0.06, ..RobotProfile::DEFAULT };
    assert_eq!(outdoors().map_at(|_| {}, &wide).planning(10.0, 5.0), FREE);
    let ramp = planning_along(&yard(0.8).map_at(|_| {}, &robot), 3.0);
    assert!(ramp.iter().all(|&p| p == FREE), "one drives along it: {ramp:?}");
}

#[test]
fn what_stands_on_terrain_is_in_the_way_by_its_height_above_the_terrain() {
    let mut house = outdoors();
    house.add(Class::Wall, [10.0, 3.0, -1.0], [10.5, 4.0, 2.0]);
    // Its top is 4 cm above the ground: a step that the robot takes.
    house.add(Class::Furniture, [24.0, 3.0, 0.8], [24.5, 4.0, 1.04]);
    house.add(Class::Beam, [26.0, 3.0, 2.0], [26.5, 4.0, 2.2]);
    house.add(Class::Beam, [34.0, 3.0, 2.0], [34.5, 4.0, 2.2]);
    // A level slab that one gets to from the terrain is ground, and one in the air is not.
    house.slab([30.0, 6.0], [36.0, 9.0], 0.03);
    house.slab([41.0, 6.0], [49.0, 9.0], 5.0);
    let drawn = house.map();
    let at = |x: f64| (drawn.planning(x, 3.55), Class::ALL[usize::from(drawn.grid().class[drawn.at(x, 3.55)])]);
    assert_eq!(at(10.25), (OCCUPIED, Class::Wall));
    assert_eq!([at(24.25), at(34.25)], [(FREE, Class::None); 2]);
    assert_eq!(at(26.25), (OCCUPIED, Class::Beam));
    assert_eq!(drawn.localization(10.05, 3.55), 100);
    assert_eq!(drawn.grid().height_tenths(drawn.at(33.0, 7.0)), Some(300));
    assert_eq!(drawn.planning(45.0, 7.0), UNKNOWN);
}

/// Terrain south of a wall that ends at y = 0, a slab 3 cm higher north of it, and a door in the wall, which begins at `bottom`.
fn house_in_the_yard(bottom: f64, opens: DoorCapability) -> House {
    let mut house = House { floor: FloorKind::Ground, bounds_m: [-5.0, -5.0, 9.0, 6.0], ..House::empty() };
    house.terrain([-5.0, -5.0], [9.0, 6.0], [0.0, 0.0]);
    house.slab([0.0, -0.2], [6.0, 5.0], 0.03);
    house.add(Class::Wall, [0.0, -0.2, 0.0], [1.5, 0.0, 2.5]);
    house.add(Class::Wall, [2.4, -0.2, 0.0], [6.0, 0.0, 2.5]);
    let door = house.door(0.9, opens);
    house.builder.elements[door].min_tenths[2] = support::t(bottom);
    house
}

#[test]
fn a_door_at_the_height_of_the_ground_leads_from_the_yard_into_the_house() {
    let along = |house: House| -> Vec<i8> {
        let drawn = house.map();
        (0..20).map(|k| drawn.planning(1.95, -0.95 + f64::from(k) * 0.1)).collect()
    };
    assert!(along(house_in_the_yard(0.03, DoorCapability::Swing)).iter().all(|&p| p == FREE));
    let closed = along(house_in_the_yard(0.03, DoorCapability::Revolving));
    assert!(closed.contains(&OCCUPIED), "a door that the robot does not open: {closed:?}");
    let high = along(house_in_the_yard(0.6, DoorCapability::Swing));
    assert!(high.contains(&OCCUPIED), "a door of another height is in the way: {high:?}");
}

#[test]
fn of_floors_above_each_other_the_ground_outdoors_shows_what_is_nearest_to_the_terrain() {
    let mut house = House { floor: FloorKind::Ground, bounds_m: [0.0, 0.0, 60.0, 10.0], ..House::empty() };
    house.terrain([0.0, 0.0], [60.0, 10.0], [0.0, 0.0]);
    // One gets from the terrain over a ramp to a deck 3 m above it, and to a floor of 3 cm below the deck.
    house.ramp([0.0, 2.0], [40.0, 6.0], [0.0, 3.0]);
    house.slab([40.0, 0.0], [60.0, 10.0], 3.0);
    house.slab([45.0, 2.0], [55.0, 8.0], 0.03);
    let drawn = house.map();
    let height = |x: f64| drawn.grid().height_tenths(drawn.at(x, 5.05));
    assert_eq!([height(10.05), height(42.05), height(50.05)], [Some(7_538), Some(0), Some(300)]);
    assert_eq!([10.05, 42.05, 50.05].map(|x| drawn.planning(x, 5.05)), [FREE; 3]);
}

#[test]
fn in_a_hole_of_the_terrain_the_ground_outdoors_shows_what_is_nearest_to_the_terrain_beside_it() {
    let mut house = House { floor: FloorKind::Ground, bounds_m: [0.0, 0.0, 60.0, 10.0], ..House::empty() };
    house.terrain([0.0, 0.0], [30.0, 10.0], [0.0, 0.0]);
    house.terrain([30.0, 0.0], [50.0, 10.0], [0.0, 1.6]);
    house.terrain([50.0, 0.0], [60.0, 2.0], [1.6, 1.6]);
    house.terrain([50.0, 8.0], [60.0, 10.0], [1.6, 1.6]);
    house.terrain([50.0, 2.0], [52.0, 8.0], [1.6, 1.6]);
    // The floor of the house, and a passage below it that begins where the terrain is as high as the storey.
    house.slab([52.0, 2.0], [60.0, 8.0], 1.6);
    house.slab([28.0, 4.0], [58.0, 6.0], 0.0);
    let drawn = house.map();
    let height = |x: f64, y: f64| drawn.grid().height_tenths(drawn.at(x, y));
    assert_eq!([height(55.05, 3.05), height(55.05, 5.05), height(29.05, 5.05)], [Some(16_000), Some(16_000), Some(0)]);
}

#[test]
fn an_excavation_is_there_once_its_earth_is_removed() {
    let at = |state: ElementState, x: f64| {
        let mut house = House { floor: FloorKind::Ground, bounds_m: [0.0, 0.0, 20.0, 10.0], ..House::empty() };
        house.terrain([0.0, 0.0], [8.0, 10.0], [0.0, 0.0]);
        house.terrain([8.0, 0.0], [20.0, 10.0], [-2.0, -2.0]);
        let earth = house.add(Class::Other, [8.0, 0.0, -2.0], [20.0, 10.0, 0.0]);
        house.builder.elements[earth].ground = GroundClass::Terrain.into();
        let drawn = house.map_at(|builder| builder.effective[earth] = state.into(), &RobotProfile::DEFAULT);
        (drawn.planning(x, 5.05), drawn.keepout(x, 5.05), drawn.grid().height_tenths(drawn.at(x, 5.05)))
    };
    assert_eq!(at(ElementState::Built, 12.05), (FREE, -1, Some(0)), "it is level ground");
    assert_eq!(at(ElementState::Built, 7.95), (FREE, -1, Some(0)));
    assert_eq!(at(ElementState::Removed, 12.05), (FREE, -1, Some(-20_000)), "the pit has a floor");
    assert_eq!(at(ElementState::Removed, 7.95), (UNKNOWN, 100, None), "and an edge");
    assert_eq!(at(ElementState::Removed, 7.75).1, 100);
    assert_eq!(at(ElementState::BeingRemoved, 12.05).1, 100, "while they dig nobody drives there");
}

#[test]
fn heights_and_slopes_are_those_of_the_faces_and_a_level_storey_has_none() {
    let mut house = yard(0.8);
    // A slab 3 cm higher than the rest is level floor all the same.
    house.slab([0.0, 0.0], [2.0, 6.0], 0.03);
    let drawn = house.map();
    let grid = drawn.grid();
    let at = |x: f64, y: f64| {
        let cell = drawn.at(x, y);
        (grid.elevation[cell], grid.slope[cell])
    };
    assert_eq!([at(1.05, 3.05), at(4.05, 3.05)], [(300, 0), (0, 0)]);
    assert_eq!(at(11.05, 3.05), (4_040, 80), "8 % are 80 milliradians");
    assert_eq!(at(11.05, 6.55), (NO_HEIGHT, NO_SLOPE));
    let mut level = yard(0.8);
    level.builder.elements[1].n_parts = 0;
    assert_eq!((level.map().grid().elevation.len(), grid.height_tenths(drawn.at(11.05, 3.05))), (0, Some(4_040)));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]
    /// Against the height of the ramp in every cell, without polygons or patches.
    #[test]
    fn a_cell_of_a_ramp_is_free_if_nothing_stands_within_the_robots_height_above_it(
        // Less is level floor.
        rise in prop_oneof![-0.9f64..-0.06, 0.06f64..0.9],
        boxes in prop::collection::vec((6.2f64..15.0, 1.6f64..4.0, 0.1f64..1.0, -0.6f64..2.4, 0.05f64..0.6), 0..6),
    ) {
        let mut house = yard(rise);
        for &(x, y, side, z, height) in &boxes {
            house.add(Class::Furniture, [x, y, z], [x + side, y + side, z + height]);
        }
        let drawn = house.map();
        let [lo, hi] = RobotProfile::DEFAULT.slab_m();
        // Cells off the foot, the head and the sides of the ramp.
        for (column, row) in (2..98).flat_map(|c| (2..28).map(move |r| (c, r))) {
            let [x0, y0] = [6.0 + f64::from(column) * 0.1, 1.5 + f64::from(row) * 0.1];
            let ground = [x0, x0 + 0.1].map(|x| rise * (x - 6.0) / 10.0);
            let (low, high) = (ground[0].min(ground[1]), ground[0].max(ground[1]));
            // A millimetre more or less than the exact overlap may go either way.
            let meets = |margin: f64| boxes.iter().any(|&(x, y, side, z, height)| {
                let plan = |at: f64, from: f64| at - margin < from + side && from < at + 0.1 + margin;
                let slab = low + lo - margin < z + height && z < high + hi + margin;
                plan(x0, x) && plan(y0, y) && slab
            });
            // On the slope a box meets the slab at one side of the cell only, so that its plan decides with its height.
            let surely = boxes.iter().any(|&(x, y, side, z, height)| {
                let plan = |at: f64, from: f64| at + 0.001 < from + side && from < at + 0.099;
                plan(x0, x) && plan(y0, y) && high + lo + 0.001 < z + height && z < low + hi - 0.001
            });
            let planning = drawn.planning(x0 + 0.05, y0 + 0.05);
            let height = drawn.grid().elevation[drawn.at(x0 + 0.05, y0 + 0.05)];
            prop_assert!((f64::from(height) / 1e4 - f64::midpoint(ground[0], ground[1])).abs() < 2e-4, "{} at {}", height, x0);
            prop_assert!(planning == FREE || planning == OCCUPIED, "{} at {:?}", planning, (x0, y0));
            prop_assert!(!surely || planning == OCCUPIED, "{:?} is in the way at {:?}", boxes, (x0, y0));
            prop_assert!(meets(0.001) || planning == FREE, "nothing stands at {:?}", (x0, y0));
        }
    }
}
