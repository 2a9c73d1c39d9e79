//! Narrow gaps between floor and walls: a lidar sees the walls across them, and where the floor is assumed from spaces a robot
//! rolls over them.
//!
//! The laboratory: two rooms of 4.0 x 3.0 m inside walls of 0.3 m, a wall with a door of 0.9 m between them. Floor or spaces
//! end before the walls, and nothing lies on a border of cells.

mod support;

use grid::{Cell, Class};
use messages::*;
use support::{Drawn, House, t};

const OCCUPIED: i8 = 100;
const FREE: i8 = 0;
const UNKNOWN: i8 = -1;

const RESOLUTIONS_M: [f64; 3] = [0.02, 0.05, 0.1];

/// Where the laboratory's lower left corner lies.
const CORNER: [f64; 2] = [0.013, 0.007];

const ROOM_M: [f64; 2] = [4.0, 3.0];
const OUTER_WALL_M: f64 = 0.3;
const DOOR_M: [f64; 2] = [1.0, 1.9];

struct Laboratory {
    house: House,
    /// Thickness of the wall between the rooms.
    wall_m: f64,
}

impl Laboratory {
    fn new(wall_m: f64, resolution_m: f64, floor: FloorKind) -> Self {
        let mut house = House::empty();
        (house.resolution_m, house.floor) = (resolution_m, floor);
        house.bounds_m = [-1.0, -1.0, 10.0, 5.0];
        let mut laboratory = Self { house, wall_m };
        let (right, top) = (2.0 * ROOM_M[0] + wall_m, ROOM_M[1]);
        for [x0, y0, x1, y1] in [
            [-OUTER_WALL_M, -OUTER_WALL_M, right + OUTER_WALL_M, 0.0],
            [-OUTER_WALL_M, top, right + OUTER_WALL_M, top + OUTER_WALL_M],
            [-OUTER_WALL_M, 0.0, 0.0, top],
            [right, 0.0, right + OUTER_WALL_M, top],
            [ROOM_M[0], 0.0, ROOM_M[0] + wall_m, DOOR_M[0]],
            [ROOM_M[0], DOOR_M[1], ROOM_M[0] + wall_m, top],
        ] {
            laboratory.add(Class::Wall, [x0, y0, 0.0], [x1, y1, 2.5]);
        }
        laboratory
    }

    /// Spaces, or slabs where the floor is built, that end before the walls.
    fn with_rooms(mut self, inset_m: f64) -> Self {
        for x in [0.0, ROOM_M[0] + self.wall_m] {
            let min = [CORNER[0] + x + inset_m, CORNER[1] + inset_m];
            let max = [CORNER[0] + x + ROOM_M[0] - inset_m, CORNER[1] + ROOM_M[1] - inset_m];
            match self.house.floor {
                FloorKind::Built => drop(self.house.slab(min, max, 0.0)),
                _ => self.house.space(min, max),
            }
        }
        self
    }

    /// A door between the rooms, in an opening or between two pieces of wall.
    fn with_door(mut self, has_opening: bool) -> Self {
        let middle = ROOM_M[0] + self.wall_m / 2.0;
        let leaf = self.add(Class::Door, [middle - 0.02, DOOR_M[0], 0.0], [middle + 0.02, DOOR_M[1], 2.1]);
        let passage = BoxRecord {
            centre: [CORNER[0] + middle, CORNER[1] + (DOOR_M[0] + DOOR_M[1]) / 2.0].map(|c| c * 10_000.0),
            axis: [0.0, 1.0],
            half: [(DOOR_M[1] - DOOR_M[0]) * 5_000.0, self.wall_m * 5_000.0],
        };
        let builder = &mut self.house.builder;
        builder.elements[leaf].door = 0;
        let opening = if has_opening { 0 } else { NONE };
        builder.doors.push(DoorRecord {
            clear_width_from: ClearWidth::Assumed.into(),
            element: leaf as u32,
            opening,
            spaces: [NONE; 2],
            opens: DoorCapability::Swing as u32,
            clear_width_m: 0.8,
            passage,
            ..bytemuck::Zeroable::zeroed()
        });
        if has_opening {
            builder.openings.push(OpeningRecord {
                global_id: Text::default(),
                host: 4,
                filling: leaf as u32,
                bottom_z_tenths: 0,
                top_z_tenths: t(2.1),
                plan: passage,
            });
        }
        self
    }

    fn add(&mut self, class: Class, min: [f64; 3], max: [f64; 3]) -> usize {
        let moved = |p: [f64; 3]| [p[0] + CORNER[0], p[1] + CORNER[1], p[2]];
        self.house.add(class, moved(min), moved(max))
    }

    fn map(self) -> Drawn {
        self.house.map()
    }
}

/// Points a millimetre inside the walls around the rooms, and the direction into the wall.
fn wall_sides(wall_m: f64) -> Vec<([f64; 2], [f64; 2])> {
    let mut sides = Vec::new();
    for x0 in [0.0, ROOM_M[0] + wall_m] {
        for k in 0..80 {
            let x = x0 + (f64::from(k) + 0.5) * ROOM_M[0] / 80.0;
            sides.extend([([x, -0.001], [0.0, -1.0]), ([x, ROOM_M[1] + 0.001], [0.0, 1.0])]);
        }
        for k in 0..60 {
            let y = (f64::from(k) + 0.5) * ROOM_M[1] / 60.0;
            sides.extend([([x0 - 0.001, y], [-1.0, 0.0]), ([x0 + ROOM_M[0] + 0.001, y], [1.0, 0.0])]);
        }
    }
    let is_at_door = |[x, y]: [f64; 2]| {
        let is_between = ROOM_M[0] - 0.01 < x && x < ROOM_M[0] + wall_m + 0.01;
        is_between && DOOR_M[0] - 0.1 < y && y < DOOR_M[1] + 0.1
    };
    sides.retain(|(at, _)| !is_at_door(*at));
    sides.into_iter().map(|(at, into)| ([at[0] + CORNER[0], at[1] + CORNER[1]], into)).collect()
}

/// Share of the sides that face rooms and are in the localization map.
fn share_of_sides_seen(map: &Drawn, wall_m: f64) -> f64 {
    let sides = wall_sides(wall_m);
    let n_seen = sides.iter().filter(|([x, y], _)| map.localization(*x, *y) == OCCUPIED).count();
    n_seen as f64 / sides.len() as f64
}

#[test]
fn the_lidar_sees_all_walls_of_rooms_whose_floor_ends_before_the_wall() {
    for resolution_m in RESOLUTIONS_M {
        for floor in [FloorKind::Built, FloorKind::AssumedFromSpaces] {
            for inset_m in [0.0, 0.01, 0.02, 0.03, 0.1, 0.19] {
                let map = Laboratory::new(0.12, resolution_m, floor).with_rooms(inset_m).map();
                let share = share_of_sides_seen(&map, 0.12);
                assert!(share >= 0.95, "{share} at {resolution_m} m, {floor:?}, {inset_m} m before the wall");
                for ([x, y], into) in wall_sides(0.12).into_iter().filter(|(at, _)| at[0] < 3.0) {
                    let behind = map.localization(x + 0.27 * into[0], y + 0.27 * into[1]);
                    assert_eq!(behind, UNKNOWN, "behind ({x}, {y}) at {resolution_m} m, {floor:?}, {inset_m} m");
                }
            }
        }
    }
}

#[test]
fn a_wall_across_a_wide_gap_is_not_seen() {
    for resolution_m in RESOLUTIONS_M {
        let map = Laboratory::new(0.12, resolution_m, FloorKind::Built).with_rooms(0.32).map();
        assert_eq!(share_of_sides_seen(&map, 0.12), 0.0, "at {resolution_m} m");
    }
}

/// True if a way over cells that are free and no keep-out leads from one room to the other.
fn rooms_are_joined(map: &Drawn, wall_m: f64) -> bool {
    let (grid, spec) = (map.grid(), map.grid().spec());
    let end = map.at(CORNER[0] + ROOM_M[0] + wall_m + 2.0, CORNER[1] + 1.45);
    let mut waiting = vec![map.at(CORNER[0] + 2.0, CORNER[1] + 1.45)];
    let mut seen = vec![false; spec.n_cells()];
    while let Some(cell) = waiting.pop() {
        if std::mem::replace(&mut seen[cell], true) || grid.planning[cell] != FREE || grid.is_keepout(cell) {
            continue;
        }
        let Cell { column, row } = spec.cell_of(cell);
        let beside = [(column + 1, row), (column - 1, row), (column, row + 1), (column, row - 1)];
        waiting.extend(beside.map(|(column, row)| spec.index(Cell { column, row })));
    }
    seen[end]
}

#[test]
fn a_door_on_an_assumed_floor_is_not_walled_off_by_keep_out() {
    for resolution_m in RESOLUTIONS_M {
        for wall_m in [0.1, 0.15, 0.25] {
            for inset_m in [0.0, 0.01, 0.02, 0.03] {
                for has_opening in [false, true] {
                    let laboratory = Laboratory::new(wall_m, resolution_m, FloorKind::AssumedFromSpaces);
                    let map = laboratory.with_rooms(inset_m).with_door(has_opening).map();
                    let case = format!("{resolution_m} m, wall {wall_m} m, inset {inset_m} m, opening {has_opening}");
                    assert_eq!(map.passage(), DoorPassage::Passable, "{case}");
                    assert!(rooms_are_joined(&map, wall_m), "{case}");
                }
            }
        }
    }
}

#[test]
fn a_gap_beside_a_built_floor_stays_a_drop_off() {
    for resolution_m in RESOLUTIONS_M {
        let map = Laboratory::new(0.12, resolution_m, FloorKind::Built).with_rooms(0.15).map();
        let [x, y] = [CORNER[0] + 2.0, CORNER[1] + 0.11];
        assert_eq!((map.planning(x, y), map.keepout(x, y)), (UNKNOWN, OCCUPIED), "at {resolution_m} m");
    }
}

#[test]
fn a_gap_beside_an_assumed_floor_is_floor_but_over_a_stair_from_below_it_is_none() {
    for resolution_m in RESOLUTIONS_M {
        let mut laboratory = Laboratory::new(0.12, resolution_m, FloorKind::AssumedFromSpaces).with_rooms(0.15);
        let stair = laboratory.add(Class::Stair, [1.0, 2.0, -3.0], [2.0, 3.0, -0.1]);
        laboratory.house.builder.elements[stair].flags = element_flags::VERTICAL;
        let map = laboratory.map();
        let at = |x: f64| map.planning(CORNER[0] + x, CORNER[1] + 2.89);
        assert_eq!((at(1.5), at(3.0)), (UNKNOWN, FREE), "at {resolution_m} m");
    }
}

#[test]
fn a_cavity_between_walls_and_what_lies_behind_a_thin_wall_is_no_floor() {
    for resolution_m in RESOLUTIONS_M {
        let mut laboratory = Laboratory::new(0.12, resolution_m, FloorKind::AssumedFromSpaces).with_rooms(0.03);
        // A second shell 0.15 m off the northern wall, and a sheet of 5 mm around the southern one.
        laboratory.add(Class::Wall, [-0.3, 3.45, 0.0], [8.42, 3.5, 2.5]);
        laboratory.add(Class::Wall, [-0.3, -0.42, 0.0], [8.42, -0.415, 2.5]);
        let map = laboratory.map();
        let floor = |x: f64, y: f64| map.grid().floor[map.at(CORNER[0] + x, CORNER[1] + y)];
        let outside = [[2.0, 3.37], [2.0, 3.7], [2.0, -0.35], [2.0, -0.6], [-0.5, 1.5]];
        assert!(outside.iter().all(|[x, y]| floor(*x, *y) == 0), "at {resolution_m} m");
        assert_eq!(floor(2.0, 1.5), 2);
    }
}

#[test]
fn rooms_whose_spaces_meet_in_the_middle_of_a_wall_are_as_before() {
    for resolution_m in RESOLUTIONS_M {
        let map = Laboratory::new(0.12, resolution_m, FloorKind::AssumedFromSpaces).with_rooms(-0.06).map();
        assert_eq!(share_of_sides_seen(&map, 0.12), 1.0, "at {resolution_m} m");
    }
}

#[test]
fn a_doorway_beside_an_assumed_floor_is_assumed_and_one_over_a_slab_is_built() {
    const WALL_M: f64 = 0.25;
    // Values of the layer in both rooms and between them, where the second room has a slab from this place on.
    let floors = |resolution_m: f64, slab_from_m: Option<f64>| {
        let kind = if slab_from_m.is_some() { FloorKind::Built } else { FloorKind::AssumedFromSpaces };
        let mut laboratory = Laboratory::new(WALL_M, resolution_m, kind).with_door(true);
        let (second, right) = (ROOM_M[0] + WALL_M, 2.0 * ROOM_M[0] + WALL_M);
        let moved = |[x, y]: [f64; 2]| [x + CORNER[0], y + CORNER[1]];
        for [from, to] in [[0.0, ROOM_M[0]], [second, right]] {
            laboratory.house.space(moved([from, 0.0]), moved([to, ROOM_M[1]]));
        }
        if let Some(from) = slab_from_m {
            laboratory.house.slab(moved([from, 0.0]), moved([right, ROOM_M[1]]), 0.0);
            laboratory.house.builder.spaces[0].flags |= space_flags::ASSUMED_FLOOR;
        }
        let map = laboratory.map();
        let floor = |x: f64| map.grid().floor[map.at(CORNER[0] + x, CORNER[1] + 1.45)];
        [floor(2.0), floor(ROOM_M[0] + WALL_M / 2.0), floor(second + 2.0)]
    };
    for resolution_m in RESOLUTIONS_M {
        assert_eq!(floors(resolution_m, None), [2, 2, 2], "at {resolution_m} m");
        assert_eq!(floors(resolution_m, Some(ROOM_M[0] + WALL_M)), [2, 2, 1], "at {resolution_m} m");
        assert_eq!(floors(resolution_m, Some(ROOM_M[0])), [2, 1, 1], "at {resolution_m} m");
    }
}
