//! The layers of a small house, drawn as text and looked at cell by cell.
//!
//! The house: a room of 4.0 x 3.0 m inside walls of 0.2 m, a floor slab under all of it, a door of 0.9 m in the south
//! wall, all on a raster of 0.1 m whose origin is the inner corner of the room.

mod support;

use grid::Class;
use messages::*;
use support::box_part::add_box_part;
use support::{House, assert_filter_frees_nothing, t};

const WALLS: std::ops::Range<usize> = 0..4;
const SLAB: usize = 4;

const OCCUPIED: i8 = 100;
const FREE: i8 = 0;
const UNKNOWN: i8 = -1;

#[test]
fn walls_are_occupied_floor_is_free_and_outside_is_unknown() {
    let map = House::new().map();
    assert_eq!(
        (map.planning(0.05, 0.05), map.planning(-0.05, 1.0), map.planning(-0.55, 1.0)),
        (FREE, OCCUPIED, UNKNOWN)
    );
    assert_eq!(map.grid().class[map.at(-0.05, 1.0)], Class::Wall.id());
    assert_eq!(map.planning(1.95, -0.1), FREE, "an opening in a wall is free where the slab goes through");
}

#[test]
fn a_hole_in_the_floor_is_unknown_and_forbidden_with_a_margin() {
    let mut house = House::new();
    house.builder.elements[SLAB].n_parts = 0;
    house.slab([-0.2, -0.2], [2.0, 3.2], 0.0);
    house.slab([3.0, -0.2], [4.2, 3.2], 0.0);
    house.opening(0);
    let map = house.map();
    assert_eq!((map.planning(2.5, 1.5), map.keepout(2.5, 1.5)), (UNKNOWN, OCCUPIED));
    assert_eq!((map.planning(1.8, 1.5), map.keepout(1.8, 1.5)), (FREE, OCCUPIED), "within the edge margin");
    assert_eq!((map.planning(1.0, 1.5), map.keepout(1.0, 1.5)), (FREE, UNKNOWN));
}

#[test]
fn the_keep_out_filter_makes_no_unknown_cell_free() {
    let robot = RobotProfile::DEFAULT;
    assert_filter_frees_nothing(&House::new().map().grid());
    let mut hole = House::new();
    hole.builder.elements[SLAB].n_parts = 0;
    hole.slab([-0.2, -0.2], [2.0, 3.2], 0.0);
    hole.slab([3.0, -0.2], [4.2, 3.2], 0.0);
    hole.opening(0);
    assert_filter_frees_nothing(&hole.map().grid());
    let mut door = House::new();
    door.door(0.8, DoorCapability::Swing);
    door.space([0.0, 0.0], [4.0, 3.0]);
    assert_filter_frees_nothing(&door.map_at(|p| p.block_space(0, &["private"]), &robot).grid());
    let in_progress =
        |p: &mut ScheduleStateBuilder| p.set_element(1, ElementState::InProgress, ElementState::InProgress);
    assert_filter_frees_nothing(&House::new().map_at(in_progress, &robot).grid());
    let nothing = |p: &mut ScheduleStateBuilder| {
        WALLS.chain([SLAB, 5]).for_each(|e| p.set_element(e, ElementState::NotStarted, ElementState::NotStarted));
        p.head.plan_time_s = 0;
    };
    assert_filter_frees_nothing(&House::new().map_at(nothing, &robot).grid());
}

#[test]
fn a_margin_does_not_leak_through_a_wall() {
    let mut house = House::new();
    house.builder.elements[SLAB].n_parts = 0;
    house.slab([-0.2, -0.2], [2.0, 3.2], 0.0);
    house.add(Class::Wall, [1.9, 0.0, 0.0], [2.0, 3.0, 2.5]);
    house.opening(0);
    let map = house.map();
    assert_eq!((map.keepout(2.5, 1.5), map.keepout(1.85, 1.5)), (OCCUPIED, UNKNOWN));
}

#[test]
fn a_door_is_passable_only_for_a_robot_that_fits_and_can_open_it() {
    let door = |width: f64, opens: DoorCapability| {
        let mut house = House::new();
        house.door(width, opens);
        let map = house.map();
        (map.planning(1.95, -0.1), map.passage())
    };
    assert_eq!(door(0.8, DoorCapability::Swing), (FREE, DoorPassage::Passable));
    assert_eq!(door(0.7, DoorCapability::Sliding), (FREE, DoorPassage::Passable), "exactly diameter and margin");
    assert_eq!(door(0.69, DoorCapability::Swing), (OCCUPIED, DoorPassage::TooNarrow));
    assert_eq!(door(0.8, DoorCapability::Revolving), (OCCUPIED, DoorPassage::CannotOpen));
}

#[test]
fn a_door_without_floor_beyond_stays_free_and_what_lies_beyond_is_forbidden() {
    let mut house = House::new();
    house.door(0.8, DoorCapability::Swing);
    let map = house.map();
    assert_eq!((map.planning(1.95, -0.1), map.planning(1.95, -0.35)), (FREE, UNKNOWN));
    assert_eq!(map.keepout(1.95, -0.35), OCCUPIED);
    let grids = Grids::open(map.index.bytes()).unwrap();
    assert_eq!(grids.doors[0].sides_with_floor, 1);
}

#[test]
fn a_leaf_that_stands_open_and_a_threshold_outside_are_no_floor() {
    let mut house = House::new();
    let door = house.door(0.8, DoorCapability::Swing);
    house.opening(0);
    house.builder.doors[0].opening = 0;
    house.builder.openings[0].filling = door as u32;
    // The door's body reaches 0.9 m out of the house, beyond the slab, and 0.3 m into it.
    let b = &mut house.builder;
    let (min, max) = ([t(1.5), t(-1.1), 0], [t(2.4), t(0.3), t(2.1)]);
    let first_part = add_box_part(b, min, max);
    b.elements[door] = ElementRecord { first_part, min_tenths: min, max_tenths: max, ..b.elements[door] };
    let map = house.map();
    assert_eq!((map.planning(1.95, -0.1), map.planning(1.95, 0.15)), (FREE, FREE), "the passage, and floor");
    assert_eq!((map.planning(1.95, -0.65), map.keepout(1.95, -0.65)), (UNKNOWN, OCCUPIED));
    assert_eq!(map.grid().class[map.at(1.95, -0.65)], Class::Door.id(), "it is still shown");
}

#[test]
fn an_opening_is_floor_where_floor_lies_on_both_sides() {
    let with_rooms = |second: bool| {
        let mut house = House::new();
        house.builder.elements[SLAB].n_parts = 0;
        house.slab([0.0, 0.0], [4.0, 3.0], 0.0);
        if second {
            house.slab([0.0, -1.5], [4.0, -0.2], 0.0);
        }
        house.opening(0);
        house.map().planning(1.95, -0.1)
    };
    assert_eq!((with_rooms(true), with_rooms(false)), (FREE, UNKNOWN));
}

#[test]
fn a_door_whose_wall_is_not_built_is_not_there() {
    let mut house = House::new();
    let door = house.door(0.69, DoorCapability::Swing);
    house.opening(0);
    house.builder.doors[0].opening = 0;
    house.builder.openings[0].filling = door as u32;
    let not_built = |p: &mut ScheduleStateBuilder| p.set_element(0, ElementState::NotStarted, ElementState::NotStarted);
    let map = house.map_at(not_built, &RobotProfile::DEFAULT);
    assert_eq!((map.planning(1.95, -0.1), map.passage()), (FREE, DoorPassage::Absent));
    assert_eq!(map.planning(0.5, -0.1), FREE, "nor is the wall");
}

#[test]
fn blocking_a_space_closes_it_for_planning_and_changes_nothing_for_the_lidar() {
    let house = || {
        let mut house = House::new();
        house.space([0.0, 0.0], [4.0, 3.0]);
        house
    };
    let (open, blocked) = (house().map(), house().map_at(|p| p.block_space(0, &["private"]), &RobotProfile::DEFAULT));
    assert_eq!((open.planning(1.0, 1.0), blocked.planning(1.0, 1.0)), (FREE, OCCUPIED));
    assert_eq!((open.keepout(1.0, 1.0), blocked.keepout(1.0, 1.0)), (UNKNOWN, OCCUPIED));
    assert_eq!(open.grid().localization, blocked.grid().localization);
}

#[test]
fn before_the_first_slab_there_is_no_floor() {
    let nothing = |p: &mut ScheduleStateBuilder| {
        for element in WALLS.chain([SLAB, 5]) {
            p.set_element(element, ElementState::NotStarted, ElementState::NotStarted);
        }
        p.head.plan_time_s = 0;
        p.block_space(0, &["before_room_date"]);
    };
    let mut house = House::new();
    house.space([0.0, 0.0], [4.0, 3.0]);
    house.builder.spaces[0].map_storey = 0;
    house.add(Class::Mep, [1.0, 1.0, 0.0], [1.3, 1.3, 1.0]);
    let map = house.map_at(nothing, &RobotProfile::DEFAULT);
    let grid = map.grid();
    assert!(grid.planning.iter().all(|&p| p == UNKNOWN), "even a blocked room and what has no date");
    assert!(grid.keepout.iter().all(|&k| k == OCCUPIED));
    assert!(grid.localization.iter().all(|&l| l == UNKNOWN) && grid.floor.iter().all(|&f| f == 0));
}

/// Everything as it is, but one element in this state.
fn but(element: usize, state: ElementState) -> impl Fn(&mut ScheduleStateBuilder) {
    move |p| {
        p.head.plan_time_s = 0;
        p.set_element(element, state, state);
    }
}

#[test]
fn work_overhead_forbids_what_is_below_and_is_no_obstacle() {
    let mut house = House::new();
    let duct = house.add(Class::Mep, [1.0, 1.0, 2.2], [2.0, 2.0, 2.4]);
    let robot = RobotProfile { work_margin_m: 0.3, ..RobotProfile::DEFAULT };
    let map = house.map_at(but(duct, ElementState::InProgress), &robot);
    assert_eq!((map.planning(1.5, 1.5), map.keepout(1.5, 1.5), map.keepout(2.15, 1.5)), (FREE, OCCUPIED, OCCUPIED));
    assert_eq!(map.keepout(2.6, 1.5), UNKNOWN);
}

#[test]
fn a_slab_that_is_not_poured_yet_is_a_drop_off_inside_the_storey() {
    let mut house = House::new();
    house.builder.elements[SLAB].n_parts = 0;
    house.slab([-0.2, -0.2], [2.0, 3.2], 0.0);
    let other = house.slab([2.0, -0.2], [4.2, 3.2], 0.0);
    house.opening(0);
    let map = house.map_at(but(other, ElementState::NotStarted), &RobotProfile::DEFAULT);
    assert_eq!((map.planning(1.0, 1.5), map.keepout(1.0, 1.5)), (FREE, UNKNOWN));
    assert_eq!((map.planning(3.0, 1.5), map.keepout(3.0, 1.5)), (UNKNOWN, OCCUPIED));
    assert_eq!(map.keepout(1.85, 1.5), OCCUPIED, "the margin at its edge");
}

#[test]
fn a_door_that_is_being_hung_is_closed() {
    let mut house = House::new();
    let door = house.door(0.8, DoorCapability::Swing);
    let map = house.map_at(but(door, ElementState::InProgress), &RobotProfile::DEFAULT);
    assert_eq!((map.planning(1.95, -0.1), map.passage()), (OCCUPIED, DoorPassage::InProgress));
}

#[test]
fn blocking_a_room_changes_neither_its_door_nor_what_a_lidar_sees() {
    let draw = |blocked: bool| {
        let mut house = House::new();
        house.door(0.8, DoorCapability::Swing);
        house.space([0.0, 0.0], [4.0, 3.0]);
        house.builder.spaces[0].map_storey = 0;
        house.map_at(
            move |p| {
                if blocked {
                    p.block_space(0, &["private"]);
                }
            },
            &RobotProfile::DEFAULT,
        )
    };
    let (open, blocked) = (draw(false), draw(true));
    assert_eq!((blocked.planning(2.0, 1.5), blocked.keepout(2.0, 1.5)), (OCCUPIED, OCCUPIED));
    assert_eq!((open.passage(), blocked.passage()), (DoorPassage::Passable, DoorPassage::Passable));
    assert_eq!(open.grid().localization, blocked.grid().localization);
}

#[test]
fn work_in_progress_is_an_obstacle_with_a_margin_and_unknown_to_the_lidar() {
    let mut house = House::new();
    let column = house.add(Class::Column, [1.0, 1.0, 0.0], [1.3, 1.3, 2.5]);
    let in_progress =
        |p: &mut ScheduleStateBuilder| p.set_element(column, ElementState::InProgress, ElementState::InProgress);
    let map = house.map_at(in_progress, &RobotProfile { work_margin_m: 0.5, ..RobotProfile::DEFAULT });
    assert_eq!((map.planning(1.1, 1.1), map.localization(1.05, 1.05)), (OCCUPIED, UNKNOWN));
    assert_eq!((map.keepout(1.6, 1.1), map.keepout(2.2, 1.1)), (OCCUPIED, UNKNOWN));
}

#[test]
fn the_lidar_sees_a_shell_of_two_cells_that_face_floor() {
    let mut house = House::new();
    house.add(Class::Wall, [1.0, 1.0, 0.0], [2.0, 2.0, 2.5]);
    house.add(Class::Furniture, [3.0, 1.0, 0.0], [3.5, 1.5, 0.8]);
    let map = house.map();
    assert_eq!([1.05, 1.15, 1.25].map(|x| map.localization(x, 1.45)), [OCCUPIED, OCCUPIED, UNKNOWN]);
    assert_eq!((map.localization(3.2, 1.2), map.planning(3.2, 1.2)), (UNKNOWN, OCCUPIED));
    assert_eq!(map.localization(0.5, 0.5), FREE);
}

#[test]
fn a_step_is_floor_and_a_platform_is_another_level() {
    let mut house = House::new();
    house.slab([1.0, 1.0], [2.0, 2.0], 0.03);
    house.slab([3.0, 1.0], [4.0, 2.0], 0.20);
    let map = house.map();
    assert_eq!((map.planning(1.5, 1.5), map.planning(3.5, 1.5)), (FREE, OCCUPIED));
    assert_eq!(map.keepout(3.5, 1.5), OCCUPIED, "although there is floor of this level below it");
}

#[test]
fn a_sunken_floor_is_listed_as_a_region_at_another_level() {
    let mut house = House::new();
    house.builder.elements[SLAB].n_parts = 0;
    house.slab([-0.2, -0.2], [2.0, 3.2], 0.0);
    house.slab([2.0, -0.2], [4.2, 3.2], -0.25);
    house.opening(0);
    let map = house.map();
    assert_eq!((map.planning(3.0, 1.5), map.keepout(3.0, 1.5)), (UNKNOWN, OCCUPIED));
    let grids = Grids::open(map.index.bytes()).unwrap();
    assert_eq!((grids.regions.len(), grids.regions[0].level_z_tenths), (1, -2_500));
}

#[test]
fn the_number_of_threads_changes_nothing() {
    let draw = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let mut house = House::new();
            house.door(0.8, DoorCapability::Swing);
            house.map().grid.as_ref().to_vec()
        })
    };
    assert_eq!(draw(1), draw(4));
}

#[test]
fn a_grid_that_ends_at_what_matters_has_the_cells_of_a_larger_one() {
    let mut cropped = House::new();
    cropped.bounds_m = [-0.2, -0.2, 4.2, 3.2];
    let mut large = House::new();
    large.bounds_m = [-14.0, -7.0, 9.0, 30.0];
    let (cropped, large) = (cropped.map(), large.map());
    let [own, other] = [&cropped, &large].map(|map| map.grid().spec());
    assert!(10 * own.n_cells() < other.n_cells());
    for index in 0..other.n_cells() {
        let [x, y] = other.centre_of(other.cell_of(index)).coordinates_m();
        let there = (large.planning(x, y), large.keepout(x, y), large.localization(x, y));
        let is_in = own.cell_at(frames::Point2::new(x, y)).is_some();
        let here = if is_in {
            (cropped.planning(x, y), cropped.keepout(x, y), cropped.localization(x, y))
        } else {
            (UNKNOWN, UNKNOWN, UNKNOWN)
        };
        assert_eq!(here, there, "{x} {y}");
    }
}
