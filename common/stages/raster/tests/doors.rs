//! Door passages of a small house: a door of 0.9 m in the south wall, see `layers.rs`.

mod support;

use grid::{Cell, Class};
use messages::*;
use proptest::prelude::*;
use support::{Drawn, House};

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

/// A house with floor on both sides of its door.
fn with_floor_outside() -> House {
    let mut house = House::new();
    house.slab([-1.0, -2.0], [5.0, -0.2], 0.0);
    house
}

/// Adds an opening in the wall `host`, from a height, and lets the door of the house fill it.
fn fill_opening(house: &mut House, host: usize, bottom_m: f64) {
    house.opening(host);
    house.builder.openings[0].bottom_z_tenths = support::t(bottom_m);
    house.builder.doors[0].opening = 0;
}

#[test]
fn a_passage_that_lies_against_the_wall_leads_through_nothing() {
    for resolution_m in [0.02, 0.05, 0.1] {
        let mut house = with_floor_outside();
        house.resolution_m = resolution_m;
        house.door(0.8, DoorCapability::Swing);
        let wall = house.add(Class::Wall, [1.5, -0.2, 0.0], [2.4, 0.0, 2.5]);
        fill_opening(&mut house, wall, 0.0);
        for plan in [&mut house.builder.openings[0].plan, &mut house.builder.doors[0].passage] {
            (plan.centre[1], plan.half[1]) = (100.0, 0.0);
        }
        let map = house.map();
        let door = map.doors()[0];
        assert_eq!((map.passage(), door.obstacle), (DoorPassage::WallUncut, wall as u32), "{resolution_m}");
        assert_eq!(door.needed_resolution_m, 0.0);
        assert_eq!(map.planning(1.95, -0.1), OCCUPIED);
    }
}

#[test]
fn a_second_wall_behind_a_door_is_named() {
    let mut house = with_floor_outside();
    house.door(0.8, DoorCapability::Swing);
    let facade = house.add(Class::Wall, [-0.2, -0.4, 0.0], [4.2, -0.25, 2.5]);
    let map = house.map();
    let door = map.doors()[0];
    assert_eq!((map.passage(), door.obstacle), (DoorPassage::NoOpening, facade as u32));
}

#[test]
fn an_opening_above_the_floor_leaves_a_threshold() {
    let mut house = with_floor_outside();
    house.door(0.8, DoorCapability::Swing);
    let wall = house.add(Class::Wall, [1.5, -0.2, 0.0], [2.4, 0.0, 0.12]);
    fill_opening(&mut house, wall, 0.12);
    assert_eq!(house.map().passage(), DoorPassage::Threshold);
}

#[test]
fn a_fixed_leaf_stays_closed_beside_the_one_that_moves() {
    let mut house = with_floor_outside();
    house.resolution_m = 0.05;
    house.door(0.6, DoorCapability::Swing);
    let door = &mut house.builder.doors[0];
    door.operation = house.builder.texts.add("SWING_FIXED_LEFT");
    (door.passage.centre[0], door.passage.half[0]) = (18_250.0, 3_250.0);
    let robot = RobotProfile { radius_m: 0.2, ..RobotProfile::DEFAULT };
    let map = house.map_at(|_| {}, &robot);
    assert_eq!(map.passage(), DoorPassage::Passable, "{:?}", map.doors()[0]);
    assert_eq!([1.8, 2.3].map(|x| map.planning(x, -0.1)), [FREE, OCCUPIED]);
}

/// True if free cells whose middles lie in the door's outline join its sides, as far as 0.3 m beyond the wall.
fn free_cells_join_the_sides(map: &Drawn) -> bool {
    let grid = map.grid();
    let spec = grid.spec();
    let is_free = |cell: Cell| {
        let p = spec.centre_of(cell);
        let is_within = (1.5..=2.4).contains(&p.x_m()) && (-0.5..=0.3).contains(&p.y_m());
        is_within && grid.planning[spec.index(cell)] == FREE
    };
    let cells = || (0..grid.planning.len()).map(|k| spec.cell_of(k)).filter(|c| is_free(*c));
    let mut reached: Vec<Cell> = cells().filter(|c| spec.centre_of(*c).y_m() < -0.2).collect();
    let mut k = 0;
    while let Some(&Cell { column, row }) = reached.get(k) {
        if spec.centre_of(reached[k]).y_m() > 0.0 {
            return true;
        }
        let beside = |c: &Cell| c.column.abs_diff(column) + c.row.abs_diff(row) == 1;
        let next: Vec<Cell> = cells().filter(|c| beside(c) && !reached.contains(c)).collect();
        reached.extend(next);
        k += 1;
    }
    false
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]
    #[test]
    fn a_passable_door_joins_free_cells_on_its_sides(
        boxes in prop::collection::vec((1.2..2.4f64, 0.02..1.0f64, -0.5..0.3f64, 0.02..0.4f64), 0..4),
        (middle_m, half_depth_m) in (-0.2..0.0f64, 0.0..0.1f64),
        resolution_m in prop::sample::select(vec![0.05, 0.1]),
    ) {
        let mut house = with_floor_outside();
        house.resolution_m = resolution_m;
        house.door(0.8, DoorCapability::Swing);
        let passage = &mut house.builder.doors[0].passage;
        (passage.centre[1], passage.half[1]) = (middle_m * 1e4, half_depth_m * 1e4);
        for (x, width, y, depth) in boxes {
            house.add(Class::Wall, [x, y, 0.0], [x + width, y + depth, 2.5]);
        }
        let map = house.map();
        if map.passage() == DoorPassage::Passable {
            prop_assert!(free_cells_join_the_sides(&map), "{:?}", map.doors()[0]);
        }
        let needed_m = map.doors()[0].needed_resolution_m;
        prop_assert!(needed_m < resolution_m, "{needed_m}");
    }
}
