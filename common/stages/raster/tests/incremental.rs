//! Incremental redraw equals a full redraw byte for byte, and Nav2's keep-out filter frees no unknown cell.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

mod support;

use grid::Class;
use messages::*;
use proptest::prelude::*;
use raster::Rasterizer;
use support::{House, assert_filter_frees_nothing, t};

const SLAB: usize = 4;

/// A box of a class, or one with an upper face at floor level.
#[derive(Debug, Clone)]
struct BoxElement {
    class: Class,
    min: [f64; 3],
    size: [f64; 3],
    is_floor: bool,
    /// What its upper face rises along x; a box if that is zero.
    rise: f64,
}

fn box_element() -> impl Strategy<Value = BoxElement> {
    let class = prop::sample::select(vec![Class::Wall, Class::Furniture, Class::Column, Class::Railing, Class::Mep]);
    let place = (-1.0f64..4.5, -1.0f64..3.5);
    let obstacle = (class, place.clone(), 0.05f64..2.0, 0.05f64..1.0, prop::sample::select(vec![0.0, 0.3, 2.2]));
    let obstacle = obstacle.prop_map(|(class, (x, y), w, d, z)| BoxElement {
        class,
        min: [x, y, z],
        size: [w, d, 0.5],
        is_floor: false,
        rise: 0.0,
    });
    let top = prop::sample::select(vec![0.0, 0.02, -0.4]);
    let floor = (place.clone(), 0.3f64..3.0, 0.3f64..3.0, top).prop_map(|((x, y), w, d, top)| BoxElement {
        class: Class::Slab,
        min: [x, y, top - 0.2],
        size: [w, d, 0.2],
        is_floor: true,
        rise: 0.0,
    });
    let foot = prop::sample::select(vec![0.0, 0.02, -0.1]);
    let ramp = (place, 2.0f64..6.0, 0.5f64..3.0, foot, -0.12f64..0.12).prop_map(|((x, y), w, d, foot, slope)| {
        BoxElement { class: Class::Ramp, min: [x, y, foot], size: [w, d, 0.0], is_floor: true, rise: slope * w }
    });
    let top = prop::sample::select(vec![0.15, 0.17, 0.3, 0.34, 0.51]);
    let tread = ((-1.0f64..4.5, -1.0f64..3.5), 0.25f64..0.6, 0.6f64..1.5, top).prop_map(|((x, y), w, d, top)| {
        BoxElement { class: Class::Stair, min: [x, y, top - 0.2], size: [w, d, 0.2], is_floor: false, rise: 0.0 }
    });
    prop_oneof![3 => obstacle, 2 => floor, 2 => ramp, 2 => tread]
}

/// The house with floor under its walls or not, more pieces, an opening in its first wall, a door of one or two leaves
/// that hangs in the second, and two rooms.
fn house(boxes: &[BoxElement], floor: FloorKind, is_floor_in_opening: bool, n_leaves: usize) -> ArchiveBuffer {
    let mut house = House::new();
    if !is_floor_in_opening {
        house.builder.elements[SLAB].n_parts = 0;
        house.slab([0.0, 0.0], [4.0, 3.0], 0.0);
        house.slab([0.0, -1.5], [4.0, -0.2], 0.0);
    }
    for box_element in boxes {
        let max = [0, 1, 2].map(|k| box_element.min[k] + box_element.size[k]);
        if box_element.rise != 0.0 {
            let [x, y, foot] = box_element.min;
            house.ramp([x, y], [max[0], max[1]], [foot, foot + box_element.rise]);
            continue;
        }
        if box_element.class == Class::Stair {
            house.tread(box_element.min, max);
            continue;
        }
        let element = house.add(box_element.class, box_element.min, max);
        house.builder.elements[element].flags = if box_element.is_floor { element_flags::FLOOR } else { 0 };
    }
    house.opening(0);
    let door = match n_leaves {
        1 => house.door(0.8, DoorCapability::Swing),
        _ => house.leaves([DoorCapability::Swing, DoorCapability::Sliding])[0],
    };
    let hung = OpeningRecord { host: 1, filling: door as u32, bottom_z_tenths: t(0.5), ..house.builder.openings[0] };
    house.builder.openings.push(hung);
    house.builder.doors.iter_mut().for_each(|door| door.opening = 1);
    house.space([0.0, 0.0], [2.0, 3.0]);
    house.space([1.5, 0.0], [4.0, 3.0]);
    house.builder.spaces.iter_mut().for_each(|s| s.map_storey = 0);
    let name = house.builder.texts.add("Ground");
    house.builder.map_storeys.push(MapStoreyRecord {
        global_id: Text::default(),
        name,
        floor_z_tenths: 0,
        floor: floor.into(),
        bounds_tenths: [t(-2.0), t(-2.0), t(7.0), t(7.0)],
    });
    house.builder.finish()
}

/// States of elements and spaces, drawn from few numbers; every fourth schedule state has no plan time.
fn schedule_state_of(site: &Site<'_>, states: &[u8], before: Option<&ScheduleStateBuilder>) -> ScheduleStateBuilder {
    let n = site.elements.len();
    let mut schedule_state = ScheduleStateBuilder::everything_built(site.content_hash(), n, site.spaces.len());
    if let Some(before) = before {
        schedule_state.effective.clone_from(&before.effective);
        schedule_state.spaces.clone_from(&before.spaces);
    }
    for (k, pair) in states.chunks_exact(2).enumerate() {
        let place = usize::from(pair[0]) % (n + site.spaces.len());
        match schedule_state.effective.get_mut(place) {
            Some(state) => *state = ElementState::ALL[usize::from(pair[1] % 5)].into(),
            None => schedule_state.spaces[place - n].state = SpaceState::ALL[usize::from(pair[1] % 2)].into(),
        }
        schedule_state.head.plan_time_s = if k % 4 == 3 && pair[1] > 200 { ScheduleStateHead::NO_TIME } else { 7 };
    }
    schedule_state
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]
    #[test]
    fn incremental_draws_of_a_sequence_of_schedule_states_equal_full_draws(
        boxes in prop::collection::vec(box_element(), 0..8),
        floor in prop::sample::select(vec![
            FloorKind::Built,
            FloorKind::Built,
            FloorKind::AssumedFromSpaces,
            FloorKind::AssumedFromEnclosure,
        ]),
        steps in prop::collection::vec(prop::collection::vec(any::<u8>(), 2..8), 1..8),
        work_margin_m in prop::sample::select(vec![0.0, 0.4, 1.5]),
        edge_margin_m in prop::sample::select(vec![0.0, 0.3, 0.77]),
        is_floor_in_opening in any::<bool>(),
        resolution_m in prop::sample::select(vec![0.1, 0.05]),
        n_leaves in 1usize..3,
        stair_cost in prop::sample::select(vec![0, 60]),
    ) {
        let site = house(&boxes, floor, is_floor_in_opening, n_leaves);
        let site = Site::open(site.bytes()).unwrap();
        let robot =
            RobotProfile { work_margin_m, edge_margin_m, climbs_stairs: 1, stair_cost, ..RobotProfile::DEFAULT };
        let mut incremental = Rasterizer::new(&site, &robot, resolution_m).unwrap();
        let mut before: Option<ScheduleStateBuilder> = None;
        // Memory in which grids are published in turn.
        let mut memories: [Option<ArchiveBuffer>; 3] = Default::default();
        for states in &steps {
            let builder = schedule_state_of(&site, states, before.as_ref());
            let schedule_state = builder.finish();
            let schedule_state = ScheduleState::open(schedule_state.bytes()).unwrap();
            incremental.draw(&site, &schedule_state);
            let mut full = Rasterizer::new(&site, &robot, resolution_m).unwrap();
            full.draw(&site, &schedule_state);
            compare(&incremental, &full)?;
            let drawn = incremental.drawn().next().unwrap();
            let memory = memories[usize::from(states[0]) % 3].get_or_insert(ArchiveBuffer::zeroed(drawn.archive.len()));
            drawn.copy_into(memory.bytes_mut());
            prop_assert!(memory.bytes() == drawn.archive, "a copy of an earlier version is one of this");
            incremental.drawn().for_each(|drawn| assert_filter_frees_nothing(&Grid::open(drawn.archive).unwrap()));
            let [redrawn, anew] = [&mut incremental, &mut full].map(|r| r.index(&site, &schedule_state, "r", &[], &SafetyRules::default()).finish());
            prop_assert_eq!(redrawn.bytes(), anew.bytes());
            before = Some(builder);
        }
    }
}

#[test]
fn work_that_ends_while_there_is_no_floor_leaves_no_margin_behind() {
    let site = house(&[], FloorKind::Built, true, 1);
    let site = Site::open(site.bytes()).unwrap();
    let schedule_state = |wall: ElementState, slab: ElementState| {
        let mut schedule_state =
            ScheduleStateBuilder::everything_built(site.content_hash(), site.elements.len(), site.spaces.len());
        schedule_state.head.plan_time_s = 7;
        (schedule_state.effective[0], schedule_state.effective[SLAB]) = (wall.into(), slab.into());
        schedule_state.finish()
    };
    let mut incremental = Rasterizer::new(&site, &RobotProfile::DEFAULT, 0.1).unwrap();
    let mut last = Vec::new();
    for (wall, slab) in [
        (ElementState::InProgress, ElementState::Built),
        (ElementState::InProgress, ElementState::NotStarted),
        (ElementState::Built, ElementState::NotStarted),
        (ElementState::Built, ElementState::Built),
    ] {
        let schedule_state = schedule_state(wall, slab);
        incremental.draw(&site, &ScheduleState::open(schedule_state.bytes()).unwrap());
        last = incremental.drawn().next().unwrap().archive.to_vec();
    }
    let mut full = Rasterizer::new(&site, &RobotProfile::DEFAULT, 0.1).unwrap();
    let built = schedule_state(ElementState::Built, ElementState::Built);
    full.draw(&site, &ScheduleState::open(built.bytes()).unwrap());
    assert!(last == full.drawn().next().unwrap().archive);
    // Who draws once is given the same, whatever was drawn before, and nothing of it is kept but the index.
    let built = ScheduleState::open(built.bytes()).unwrap();
    let given = incremental.draw_once(&site, &built, |archive| archive);
    assert!(given.len() == 1 && last == given[0].bytes());
    assert_eq!(incremental.drawn().len(), 0);
    let index =
        |rasterizer: &Rasterizer| rasterizer.index(&site, &built, "robot", &[], &SafetyRules::default()).finish();
    assert_eq!(index(&incremental).bytes(), index(&full).bytes());
}

/// A piece of a site outdoors.
#[derive(Debug, Clone)]
enum Outdoors {
    /// Terrain that is built and removed as an element.
    Earth {
        min: [f64; 2],
        size: [f64; 2],
        z: [f64; 2],
    },
    Floor {
        min: [f64; 2],
        size: [f64; 2],
        top: f64,
    },
    Ramp {
        min: [f64; 2],
        size: [f64; 2],
        z: [f64; 2],
    },
    Obstacle {
        class: Class,
        min: [f64; 3],
        size: [f64; 3],
    },
}

fn outdoors() -> impl Strategy<Value = Outdoors> {
    let place = || [-1.0..29.0f64, -1.0..13.0f64];
    let size = || [1.0..16.0f64, 1.0..12.0f64];
    let earth = (place(), size(), prop::sample::select(vec![[0.0, 0.0], [0.0, 0.3], [1.2, 1.2]]));
    let floor = (place(), size(), prop::sample::select(vec![0.0, 0.03, 0.25, 1.2, 1.23, 2.7]));
    let ramp =
        (place(), 1.0..5.0f64, prop::sample::select(vec![[0.0, 1.2], [1.2, 0.0], [0.0, 2.7], [1.2, 2.7], [0.0, -0.5]]));
    let class = prop::sample::select(vec![Class::Wall, Class::Furniture, Class::Slab, Class::Mep]);
    let bottom = prop::sample::select(vec![0.0, 0.4, 1.2, 2.7]);
    let obstacle = (class, place(), [0.1..4.0f64, 0.1..4.0f64], bottom);
    prop_oneof![
        2 => earth.prop_map(|(min, size, z)| Outdoors::Earth { min, size, z }),
        4 => floor.prop_map(|(min, size, top)| Outdoors::Floor { min, size, top }),
        2 => ramp.prop_map(|(min, depth, z)| Outdoors::Ramp { min, size: [12.0, depth], z }),
        2 => obstacle.prop_map(|(class, [x, y], [w, d], z)| Outdoors::Obstacle {
            class,
            min: [x, y, z],
            size: [w, d, 1.0]
        }),
    ]
}

/// A site outdoors: a strip of terrain that is always there, and pieces.
fn outdoor_site(pieces: &[Outdoors]) -> ArchiveBuffer {
    let mut house = House { floor: FloorKind::Ground, bounds_m: [0.0, 0.0, 30.0, 12.0], ..House::empty() };
    house.terrain([0.0, 0.0], [30.0, 4.0], [0.0, 0.0]);
    let end = |min: [f64; 2], size: [f64; 2]| [min[0] + size[0], min[1] + size[1]];
    for piece in pieces {
        match *piece {
            Outdoors::Earth { min, size, z } => {
                let element = house.ramp(min, end(min, size), z);
                let element = &mut house.builder.elements[element];
                (element.flags, element.ground) = (0, GroundClass::Terrain.into());
            }
            Outdoors::Floor { min, size, top } => {
                house.slab(min, end(min, size), top);
            }
            Outdoors::Ramp { min, size, z } => {
                house.ramp(min, end(min, size), z);
            }
            Outdoors::Obstacle { class, min, size } => {
                house.add(class, min, [0, 1, 2].map(|k| min[k] + size[k]));
            }
        }
    }
    house.site()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]
    #[test]
    fn incremental_draws_of_the_ground_outdoors_equal_full_draws(
        pieces in prop::collection::vec(outdoors(), 3..14),
        steps in prop::collection::vec(prop::collection::vec(any::<u8>(), 2..8), 2..7),
    ) {
        let site = outdoor_site(&pieces);
        let site = Site::open(site.bytes()).unwrap();
        let robot = RobotProfile { max_slope_rad: 0.3, ..RobotProfile::DEFAULT };
        let mut incremental = Rasterizer::new(&site, &robot, 0.1).unwrap();
        let mut memory: Option<ArchiveBuffer> = None;
        let mut before: Option<ScheduleStateBuilder> = None;
        for states in &steps {
            let builder = schedule_state_of(&site, states, before.as_ref());
            let schedule_state = builder.finish();
            let schedule_state = ScheduleState::open(schedule_state.bytes()).unwrap();
            incremental.draw(&site, &schedule_state);
            let mut full = Rasterizer::new(&site, &robot, 0.1).unwrap();
            full.draw(&site, &schedule_state);
            compare(&incremental, &full)?;
            let drawn = incremental.drawn().next().unwrap();
            let memory = memory.get_or_insert(ArchiveBuffer::zeroed(drawn.archive.len()));
            drawn.copy_into(memory.bytes_mut());
            prop_assert!(memory.bytes() == drawn.archive, "a copy of the version before is one of this");
            before = Some(builder);
        }
    }
}

/// The floor of a house in a hole of the terrain, and a passage below it that begins elsewhere.
#[test]
fn what_a_hole_of_the_terrain_shows_follows_the_terrain_beside_it_when_that_is_removed() {
    let mut house = House { floor: FloorKind::Ground, bounds_m: [0.0, 0.0, 60.0, 10.0], ..House::empty() };
    house.terrain([0.0, 0.0], [30.0, 10.0], [0.0, 0.0]);
    let earth: Vec<usize> = [
        ([30.0, 0.0], [50.0, 10.0], 0.0),
        ([50.0, 0.0], [60.0, 2.0], 1.6),
        ([50.0, 8.0], [60.0, 10.0], 1.6),
        ([50.0, 2.0], [52.0, 8.0], 1.6),
    ]
    .into_iter()
    .map(|(min, max, from)| house.ramp(min, max, [from, 1.6]))
    .collect();
    for &piece in &earth {
        let element = &mut house.builder.elements[piece];
        (element.flags, element.ground) = (0, GroundClass::Terrain.into());
    }
    house.slab([52.0, 2.0], [60.0, 8.0], 1.6);
    house.slab([28.0, 4.0], [58.0, 6.0], 0.0);
    let site = house.site();
    let site = Site::open(site.bytes()).unwrap();
    let mut incremental = Rasterizer::new(&site, &RobotProfile::DEFAULT, 0.1).unwrap();
    let mut heights = Vec::new();
    for state in [ElementState::Built, ElementState::Removed] {
        let mut states = ScheduleStateBuilder::everything_built(site.content_hash(), site.elements.len(), 0);
        states.head.plan_time_s = 7;
        earth.iter().for_each(|&piece| states.effective[piece] = state.into());
        let states = states.finish();
        let states = ScheduleState::open(states.bytes()).unwrap();
        incremental.draw(&site, &states);
        let mut full = Rasterizer::new(&site, &RobotProfile::DEFAULT, 0.1).unwrap();
        full.draw(&site, &states);
        compare(&incremental, &full).unwrap();
        let drawn = Grid::open(incremental.drawn().next().unwrap().archive).unwrap();
        let cell = drawn.spec().cell_at(frames::Point2::new(55.05, 5.05)).unwrap();
        heights.push(drawn.height_tenths(drawn.spec().index(cell)));
    }
    assert_eq!(heights, [Some(16_000), Some(0)]);
}

/// Layer by layer, so that a failure names the first cell.
fn compare(incremental: &Rasterizer, full: &Rasterizer) -> Result<(), TestCaseError> {
    for (redrawn, drawn) in incremental.drawn().zip(full.drawn()) {
        let [a, b] = [redrawn, drawn].map(|d| Grid::open(d.archive).unwrap());
        let differs = |layer: &str, place: Option<usize>| {
            let cell = place.map(|place| (layer.to_owned(), a.spec().cell_of(place)));
            prop_assert_eq!(cell, None);
            Ok(())
        };
        differs("class", (0..a.class.len()).find(|&i| a.class[i] != b.class[i]))?;
        differs("floor", (0..a.floor.len()).find(|&i| a.floor[i] != b.floor[i]))?;
        differs("planning", (0..a.planning.len()).find(|&i| a.planning[i] != b.planning[i]))?;
        differs("keepout", (0..a.keepout.len()).find(|&i| a.keepout[i] != b.keepout[i]))?;
        differs("elevation", (0..a.elevation.len()).find(|&i| a.elevation[i] != b.elevation[i]))?;
        differs("slope", (0..a.slope.len()).find(|&i| a.slope[i] != b.slope[i]))?;
        differs("localization", (0..a.localization.len()).find(|&i| a.localization[i] != b.localization[i]))?;
        prop_assert_eq!((redrawn.content_hash, redrawn.input_hash), (drawn.content_hash, drawn.input_hash));
        prop_assert!(redrawn.archive == drawn.archive);
    }
    Ok(())
}
