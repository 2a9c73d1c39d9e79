//! Door passages of a small house: a door of 0.9 m in the south wall, see `layers.rs`.

mod support;

use grid::Class;
use messages::*;
use support::House;

const OCCUPIED: i8 = 100;
const FREE: i8 = 0;
const SLAB: usize = 4;
const IN_LEAVES: [[f64; 2]; 2] = [[1.75, -0.1], [2.15, -0.1]];

fn at_date(house: House, change: impl Fn(&mut ScheduleStateBuilder)) -> support::Drawn {
    house.map_at(change, &RobotProfile::DEFAULT)
}

#[test]
fn leaves_of_one_opening_are_passable_together() {
    let mut house = House::new();
    house.leaves([DoorCapability::Swing, DoorCapability::Swing]);
    let map = house.map();
    assert_eq!(map.passages(), [DoorPassage::Passable; 2]);
    assert_eq!(IN_LEAVES.map(|[x, y]| map.planning(x, y)), [FREE; 2]);
    for door in map.doors() {
        // Both leaves less what one frame takes; the way is the whole opening.
        assert!((door.clear_width_m - 0.8).abs() < 1e-9, "{door:?}");
        assert_eq!((door.way.centre[0], door.way.half[0]), (19_500.0, 4_500.0));
    }
}

#[test]
fn a_leaf_that_does_not_open_leaves_the_other_one_alone() {
    let mut house = House::new();
    house.leaves([DoorCapability::Swing, DoorCapability::Revolving]);
    let map = house.map();
    assert_eq!(map.passages(), [DoorPassage::TooNarrow, DoorPassage::CannotOpen]);
    assert_eq!(IN_LEAVES.map(|[x, y]| map.planning(x, y)), [OCCUPIED; 2]);
}

#[test]
fn a_leaf_that_is_not_hung_yet_leaves_its_width_to_the_other() {
    let with = |state: ElementState| {
        let mut house = House::new();
        let [_, second] = house.leaves([DoorCapability::Swing, DoorCapability::Swing]);
        house.opening(0);
        at_date(house, |p| p.set_element(second, state, state)).passages()
    };
    assert_eq!(with(ElementState::NotStarted), [DoorPassage::Passable, DoorPassage::Absent]);
    assert_eq!(with(ElementState::Built), [DoorPassage::Passable; 2]);
    assert_eq!(with(ElementState::InProgress), [DoorPassage::TooNarrow, DoorPassage::InProgress]);
}

#[test]
fn a_door_without_floor_on_either_side_says_so() {
    let mut house = House::new();
    house.builder.elements[SLAB].n_parts = 0;
    house.door(0.8, DoorCapability::Swing);
    assert_eq!(house.map().passage(), DoorPassage::NoFloor);
}

#[test]
fn a_door_in_a_wall_without_an_opening_says_so() {
    let mut house = House::new();
    house.door(0.8, DoorCapability::Swing);
    let wall = house.add(Class::Wall, [1.5, -0.2, 0.0], [2.4, 0.0, 2.5]);
    let map = house.map();
    assert_eq!((map.passage(), map.doors()[0].obstacle), (DoorPassage::NoOpening, wall as u32));
}

#[test]
fn what_stands_in_a_doorway_is_named_with_the_width_that_it_leaves() {
    let mut house = House::new();
    house.door(0.8, DoorCapability::Swing);
    let column = house.add(Class::Column, [1.5, -0.2, 0.0], [2.0, 0.0, 2.5]);
    let map = house.map();
    let door = map.doors()[0];
    assert_eq!((map.passage(), door.obstacle), (DoorPassage::Obstructed, column as u32));
    assert!((door.width_between_obstacles_m - 0.4).abs() < 0.011, "{door:?}");
}

#[test]
fn every_reason_is_told() {
    let mut house = House::new();
    house.builder.elements[SLAB].n_parts = 0;
    house.door(0.5, DoorCapability::Revolving);
    let reasons: Vec<DoorPassage> = house.map().doors()[0].closed_by().collect();
    assert_eq!(reasons, [DoorPassage::NoFloor, DoorPassage::CannotOpen, DoorPassage::TooNarrow]);
}

#[test]
fn at_the_resolution_that_a_door_needs_it_is_open() {
    for (low, high) in [(1.61, 2.31), (1.61, 2.35), (1.51, 2.19)] {
        let map = |resolution_m: f64| {
            let mut house = House::new();
            house.resolution_m = resolution_m;
            house.door(0.8, DoorCapability::Swing);
            house.add(Class::Wall, [1.5, -0.2, 0.0], [low, 0.0, 2.5]);
            house.add(Class::Wall, [high, -0.2, 0.0], [2.4, 0.0, 2.5]);
            house.map()
        };
        let coarse = map(0.2);
        assert_eq!(coarse.passage(), DoorPassage::ClosedByResolution, "{low} {high}");
        let needed_m = coarse.doors()[0].needed_resolution_m;
        assert!(0.01 < needed_m && needed_m < 0.2, "{needed_m}");
        assert_eq!(map(needed_m).passage(), DoorPassage::Passable);
    }
}
