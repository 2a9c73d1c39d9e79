//! Doors of small models: what closes them is said truly, and what is passable is a way of free cells on the map.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

use end_to_end::house::{House, PLAIN};
use end_to_end::{FREE, Maps, OCCUPIED, convert};
use proptest::prelude::*;
use serde_json::Value;

/// The wall between the two rooms stands from here to there.
const WALL_Y: [f64; 2] = [3.0, 3.2];

/// Where the way of most models is.
const WAY_X: [f64; 2] = [2.5, 3.5];

/// A leaf in the middle of the wall.
const LEAF_Y: [f64; 2] = [3.08, 3.12];

/// Attributes of a door: its OverallWidth and OperationType.
fn door(width_m: f64, operation: &str) -> String {
    format!("$,2.1,{width_m:?},.DOOR.,.{operation}.,$")
}

fn swing() -> String {
    door(1.0, "SINGLE_SWING_LEFT")
}

fn boxed([x0, x1]: [f64; 2], [y0, y1]: [f64; 2], [z0, z1]: [f64; 2]) -> [[f64; 3]; 2] {
    [[x0, y0, z0], [x1, y1, z1]]
}

/// Two rooms on a slab, one behind the other, and the wall between them.
fn two_rooms() -> (House, usize) {
    let mut house = House::new("IFC4");
    house.add_walls([0.0, 0.0, 6.0, 6.2], [0.0, 3.0]);
    house.add("IFCSLAB", "Slab", PLAIN, [[-0.2, -0.2, -0.2], [6.2, 6.4, 0.0]]);
    house.add_room("A", boxed([0.0, 6.0], [0.0, 3.0], [0.0, 3.0]));
    house.add_room("B", boxed([0.0, 6.0], [3.2, 6.2], [0.0, 3.0]));
    let wall = house.add("IFCWALL", "Between", PLAIN, boxed([0.0, 6.0], WALL_Y, [0.0, 3.0]));
    (house, wall)
}

/// The opening of the way, which reaches out of its wall on both sides.
fn opening(house: &mut House, wall: usize) -> usize {
    house.add_opening(wall, boxed(WAY_X, [2.95, 3.25], [0.0, 2.1]))
}

/// Two rooms whose way has a door with these attributes and a leaf.
fn with_door(rest: &str) -> (House, usize) {
    let (mut house, wall) = two_rooms();
    let opening = opening(&mut house, wall);
    let door = house.add("IFCDOOR", "Door", rest, boxed(WAY_X, LEAF_Y, [0.0, 2.1]));
    house.fill(opening, door);
    (house, door)
}

fn converted_with(house: &House, more: &[&str]) -> Maps {
    let home = tempfile::tempdir().unwrap();
    let maps = convert(&house.write(home.path()), more);
    let semantic = maps.json("semantic.json");
    let doors =
        semantic["elements"].as_object().unwrap().values().filter(|e| e["attributes"]["passage"]["0"] == "passable");
    for door in doors {
        let plan = |k: usize| ["min", "max"].map(|end| door["aabb_m"][end][k].as_f64().unwrap());
        assert!(joins_sides(&maps, plan(0)), "a passable door without a way: {door}");
    }
    maps
}

fn converted(house: &House) -> Maps {
    converted_with(house, &[])
}

/// True if free cells join both sides of the wall between these places along it.
fn joins_sides(maps: &Maps, [x0, x1]: [f64; 2]) -> bool {
    let storey = maps.storey(0);
    let step = maps.manifest["resolution_m"].as_f64().unwrap() / 2.0;
    let [columns, rows] = [x1 - x0, WALL_Y[1] - WALL_Y[0] + 0.4].map(|size: f64| (size / step) as usize + 1);
    let place = |at: usize| {
        let [column, row] = [at % columns, at / columns];
        [x0 + column as f64 * step, WALL_Y[0] - 0.2 + row as f64 * step]
    };
    let is_free = |at: usize| storey.planning(place(at)[0], place(at)[1]) == FREE;
    let mut open: Vec<usize> = (0..columns).filter(|&at| is_free(at)).collect();
    let mut seen = vec![false; columns * rows];
    while let Some(at) = open.pop() {
        if std::mem::replace(&mut seen[at], true) || !is_free(at) {
            continue;
        }
        if at / columns == rows - 1 {
            return true;
        }
        let [column, row] = [at % columns, at / columns];
        open.extend((column > 0).then(|| at - 1));
        open.extend((column + 1 < columns).then(|| at + 1));
        open.extend((row > 0).then(|| at - columns));
        open.extend((row + 1 < rows).then(|| at + columns));
    }
    false
}

/// Passage of the door of this record, and its first reason in words.
fn passage(maps: &Maps, door: usize) -> (String, String) {
    let semantic = maps.json("semantic.json");
    let found = semantic["elements"][id(door)]["attributes"]["passage"]["0"].as_str().unwrap().to_owned();
    let report = maps.json("report.json");
    let entry = report["doors"].as_array().unwrap().iter().find(|d| d["global_id"] == id(door).as_str());
    let reason = entry.and_then(|entry| entry["reasons"][0]["text"].as_str());
    (found, reason.unwrap_or_default().to_owned())
}

fn clear_width_m(maps: &Maps, door: usize) -> f64 {
    maps.json("semantic.json")["elements"][id(door)]["attributes"]["clear_width_m"].as_f64().unwrap()
}

/// GlobalId of an element: the number of the record before its own.
fn id(element: usize) -> String {
    format!("{:0>22}", element - 1)
}

/// The diagnostics of this code.
fn diagnostics(maps: &Maps, code: &str) -> Vec<Value> {
    maps.json("report.json")["diagnostics"].as_array().unwrap().iter().filter(|d| d["code"] == code).cloned().collect()
}

#[test]
fn a_wall_is_cut_by_its_door_where_the_opening_only_touches_it() {
    let with = |opening_y: [f64; 2], leaf_y: [f64; 2]| {
        let (mut house, wall) = two_rooms();
        let opening = house.add_opening(wall, boxed(WAY_X, opening_y, [0.0, 2.1]));
        let door = house.add("IFCDOOR", "Door", &swing(), boxed(WAY_X, leaf_y, [0.0, 2.1]));
        house.fill(opening, door);
        (converted(&house), opening, door)
    };
    for beside in [[3.2, 3.4], [2.8, 3.0], [2.5, 2.9]] {
        let (maps, opening, door) = with(beside, LEAF_Y);
        assert_eq!(passage(&maps, door).0, "passable", "{beside:?}");
        assert_eq!(maps.storey(0).planning(3.0, 3.02), FREE, "the wall is cut through");
        assert_eq!(maps.storey(0).planning(2.3, 3.1), OCCUPIED, "no more of it is");
        let told = diagnostics(&maps, "opening_beside_wall");
        assert_eq!((told.len(), told[0]["global_id"].as_str()), (1, Some(id(door).as_str())), "{told:?}");
        assert!(told[0]["message"].as_str().unwrap().contains(&id(opening)), "{told:?}");
    }
    let (maps, _, door) = with([3.2, 3.4], [3.25, 3.3]);
    assert_eq!(passage(&maps, door), ("wall_uncut".to_owned(), "its opening touches the wall from outside".to_owned()));
    assert_eq!(maps.storey(0).planning(3.0, 3.1), OCCUPIED);
    assert!(diagnostics(&maps, "opening_beside_wall").is_empty());
}

#[test]
fn a_threshold_is_the_reason_where_the_opening_begins_above_the_floor() {
    let (mut house, wall) = two_rooms();
    let opening = house.add_opening(wall, boxed(WAY_X, [2.95, 3.25], [0.12, 2.1]));
    let door = house.add("IFCDOOR", "Door", &swing(), boxed(WAY_X, LEAF_Y, [0.12, 2.1]));
    house.fill(opening, door);
    let maps = converted(&house);
    assert_eq!(passage(&maps, door), ("threshold".to_owned(), "a threshold of 0.12 m stands in it".to_owned()));
}

#[test]
fn a_door_of_frame_and_leaf_is_a_door_whichever_of_them_fills_the_opening() {
    for part_fills in [false, true] {
        let (mut house, wall) = two_rooms();
        let opening = opening(&mut house, wall);
        let door = house.add_bodiless("IFCDOOR", "Door", &swing());
        let leaf = house.add("IFCBUILDINGELEMENTPROXY", "Leaf", PLAIN, boxed([2.55, 3.45], LEAF_Y, [0.0, 2.05]));
        let frame = house.add("IFCMEMBER", "Frame", PLAIN, boxed([2.5, 2.55], [3.0, 3.2], [0.0, 2.1]));
        house.aggregate(door, &[leaf, frame]);
        house.fill(opening, if part_fills { frame } else { door });
        let maps = converted(&house);
        assert_eq!(passage(&maps, door).0, "passable", "{part_fills}");
        assert!(diagnostics(&maps, "door_without_body").is_empty());
    }
}

#[test]
fn parts_of_windows_and_stairs_have_their_class_whatever_their_entity() {
    for (entity, rest, class) in [("IFCWINDOW", "$,$,$,$,$,$", "window"), ("IFCSTAIR", PLAIN, "stair")] {
        let (mut house, _) = two_rooms();
        let whole = house.add_bodiless(entity, "Whole", rest);
        let part = house.add("IFCBUILDINGELEMENTPROXY", "Part", PLAIN, boxed([1.0, 1.5], [1.0, 1.5], [0.0, 1.0]));
        house.aggregate(whole, &[part]);
        let semantic = converted(&house).json("semantic.json");
        assert_eq!(semantic["elements"][id(part)]["class"], class, "{entity}");
    }
}

#[test]
fn a_door_without_a_body_is_listed_and_closed_if_operation_or_width_say_so() {
    for (rest, expected, pixel) in [
        (swing(), "passable", FREE),
        (door(1.0, "REVOLVING"), "operation", OCCUPIED),
        (door(0.5, "SINGLE_SWING_LEFT"), "too_narrow", OCCUPIED),
    ] {
        let (mut house, wall) = two_rooms();
        let opening = opening(&mut house, wall);
        let door = house.add_bodiless("IFCDOOR", "Door", &rest);
        house.fill(opening, door);
        let maps = converted(&house);
        assert_eq!((passage(&maps, door).0.as_str(), maps.storey(0).planning(3.0, 3.1)), (expected, pixel), "{rest}");
        assert_eq!(diagnostics(&maps, "door_without_body").len(), 1);
    }
    let (mut house, _) = two_rooms();
    house.add_bodiless("IFCDOOR", "Door", &swing());
    let told = diagnostics(&converted(&house), "door_without_body");
    assert!(told[0]["message"].as_str().unwrap().ends_with("it is on no map"), "{told:?}");
}

#[test]
fn what_fills_an_opening_to_the_floor_and_is_no_door_is_named() {
    let with = |entity: &str, rest: &str, bottom_m: f64| {
        let (mut house, wall) = two_rooms();
        let opening = opening(&mut house, wall);
        let filling = house.add(entity, "Filling", rest, boxed(WAY_X, LEAF_Y, [bottom_m, 2.1]));
        house.fill(opening, filling);
        let maps = converted(&house);
        assert_eq!(maps.storey(0).planning(3.0, 3.1), OCCUPIED);
        (diagnostics(&maps, "opening_filled"), id(filling), id(opening))
    };
    let (told, filling, opening) = with("IFCBUILDINGELEMENTPROXY", PLAIN, 0.0);
    assert_eq!((told.len(), told[0]["global_id"].as_str()), (1, Some(filling.as_str())));
    let message = told[0]["message"].as_str().unwrap();
    assert!(message.contains(&opening) && message.ends_with("it closes the way"), "{message}");
    assert!(with("IFCWINDOW", "$,$,$,$,$,$", 0.0).0.is_empty());
    assert!(with("IFCBUILDINGELEMENTPROXY", PLAIN, 0.9).0.is_empty(), "a parapet is above the floor");
}

#[test]
fn the_smaller_width_counts_and_one_that_cannot_be_is_told() {
    let with = |width_m: f64, x: [f64; 2]| {
        let (mut house, wall) = two_rooms();
        let opening = house.add_opening(wall, boxed(x, [2.95, 3.25], [0.0, 2.1]));
        let door = house.add("IFCDOOR", "Door", &door(width_m, "SINGLE_SWING_LEFT"), boxed(x, LEAF_Y, [0.0, 2.1]));
        house.fill(opening, door);
        let maps = converted(&house);
        let n_told = diagnostics(&maps, "door_width_implausible").len();
        (passage(&maps, door).0, clear_width_m(&maps, door), n_told)
    };
    let narrow = [2.5, 3.2];
    for width_m in [2.1, 999.0, 0.001] {
        assert_eq!(with(width_m, narrow), ("too_narrow".to_owned(), 0.6, 1), "{width_m}");
        assert_eq!(with(width_m, WAY_X).0, "passable", "a metre is measured");
    }
    assert_eq!(with(0.6, WAY_X), ("too_narrow".to_owned(), 0.5, 0));
}

#[test]
fn a_fixed_leaf_is_no_way_on_maps_and_stays_in_worlds() {
    let x = [2.0, 4.0];
    let with = |operation: &str, panels: &[(&str, &str, f64)]| {
        let (mut house, wall) = two_rooms();
        let opening = house.add_opening(wall, boxed(x, [2.95, 3.25], [0.0, 2.1]));
        let door = house.add("IFCDOOR", "Door", &door(2.0, operation), boxed(x, LEAF_Y, [0.0, 2.1]));
        house.fill(opening, door);
        house.add_panels(door, panels);
        let maps = converted_with(&house, &["--world"]);
        let pixels = [2.5, 3.5].map(|x| maps.storey(0).planning(x, 3.1));
        let world = maps.json("world/lookup.json");
        let in_world = &world["doors"][id(door)];
        assert!(in_world.is_null() || in_world["width_m"] == 2.0, "the whole door: {in_world}");
        let leaves = in_world["leaves"].as_array().cloned().unwrap_or_default();
        let kinds: Vec<String> = leaves.iter().map(|leaf| leaf["kind"].as_str().unwrap().to_owned()).collect();
        let passed = passage(&maps, door);
        let unreached = maps.json("report.json")["spaces_without_waypoint"].to_string();
        assert!(passed.1.is_empty() || unreached.contains(&passed.1), "{passed:?} {unreached}");
        (passed, clear_width_m(&maps, door), pixels, kinds)
    };
    let moving_left = ["revolute".to_owned(), "fixed".to_owned()];
    let (passed, clear_m, pixels, kinds) = with("SWING_FIXED_LEFT", &[]);
    assert_eq!((passed.0.as_str(), clear_m, pixels), ("passable", 0.9, [FREE, OCCUPIED]));
    assert_eq!(kinds, moving_left);
    let panels = [("SWINGING", "LEFT", 0.5), ("FIXEDPANEL", "RIGHT", 0.5)];
    let (passed, clear_m, pixels, kinds) = with("DOUBLE_DOOR_SINGLE_SWING", &panels);
    assert_eq!((passed.0.as_str(), clear_m, pixels), ("passable", 0.9, [FREE, OCCUPIED]));
    assert_eq!(kinds, moving_left);
    let (_, _, pixels, kinds) = with("SWING_FIXED_RIGHT", &[]);
    assert_eq!((pixels, kinds), ([OCCUPIED, FREE], moving_left.iter().rev().cloned().collect()));
    let (passed, clear_m, pixels, kinds) =
        with("NOTDEFINED", &[("FIXEDPANEL", "LEFT", 0.5), ("FIXEDPANEL", "RIGHT", 0.5)]);
    assert_eq!(passed, ("operation".to_owned(), "all its leaves are fixed".to_owned()));
    assert_eq!((clear_m, pixels, kinds.len()), (0.0, [OCCUPIED; 2], 0));
}

#[test]
fn each_filling_of_an_opening_has_its_own_width() {
    let (mut house, wall) = two_rooms();
    let opening = house.add_opening(wall, boxed([2.5, 4.5], [2.95, 3.25], [0.0, 2.1]));
    let leaf = house.add("IFCDOOR", "Door", &swing(), boxed(WAY_X, LEAF_Y, [0.0, 2.1]));
    let side = house.add("IFCWINDOW", "Side", "$,$,$,$,$,$", boxed([3.5, 4.5], LEAF_Y, [0.0, 2.1]));
    house.fill(opening, leaf);
    house.fill(opening, side);
    let maps = converted(&house);
    assert_eq!((passage(&maps, leaf).0.as_str(), clear_width_m(&maps, leaf)), ("passable", 0.9));
    assert_eq!([3.0, 4.0].map(|x| maps.storey(0).planning(x, 3.1)), [FREE, OCCUPIED]);
}

#[test]
fn a_trapdoor_is_called_one() {
    let (house, door) = with_door("$,2.1,1.,.TRAPDOOR.,.SINGLE_SWING_LEFT.,$");
    assert_eq!(passage(&converted(&house), door), ("operation".to_owned(), "it is a trapdoor".to_owned()));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]
    /// Openings and leaves of any place and size at any resolution: `converted_with` asserts that what is passable is a way.
    #[test]
    fn a_passable_door_is_a_way_of_free_cells(
        opening_y in (2.6..3.3f64, 0.05..0.5f64),
        leaf_y in (2.8..3.3f64, 0.03..0.2f64),
        x in (2.0..3.0f64, 0.5..1.5f64),
        width_m in 0.5..1.6f64,
        bottom_m in prop::sample::select(vec![0.0, 0.0, 0.02, 0.12]),
        resolution in prop::sample::select(vec!["0.02", "0.05", "0.09"]),
        has_body in prop::bool::weighted(0.8),
    ) {
        let (mut house, wall) = two_rooms();
        let x = [x.0, x.0 + x.1];
        let opening = house.add_opening(wall, boxed(x, [opening_y.0, opening_y.0 + opening_y.1], [bottom_m, 2.1]));
        let rest = door(width_m, "SINGLE_SWING_LEFT");
        let leaf_y = [leaf_y.0, leaf_y.0 + leaf_y.1];
        let leaf = match has_body {
            true => house.add("IFCDOOR", "Door", &rest, boxed(x, leaf_y, [bottom_m, 2.1])),
            false => house.add_bodiless("IFCDOOR", "Door", &rest),
        };
        house.fill(opening, leaf);
        let maps = converted_with(&house, &["--resolution", resolution]);
        let used: f64 = resolution.parse().unwrap();
        for entry in maps.json("report.json")["doors"].as_array().unwrap() {
            for reason in entry["reasons"].as_array().unwrap() {
                prop_assert!(reason["needed_resolution_m"].as_f64().is_none_or(|needed_m| needed_m < used), "{}", reason);
            }
        }
    }
}
