//! Floors of small models, and warnings where the model has none.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

use end_to_end::house::{House, PLAIN};
use end_to_end::{FREE, Maps, OCCUPIED, UNKNOWN, convert};
use proptest::prelude::*;

fn converted(house: &House) -> Maps {
    let home = tempfile::tempdir().unwrap();
    convert(&house.write(home.path()), &[])
}

/// The lines about an assumed floor.
fn warnings(maps: &Maps) -> Vec<&str> {
    maps.stdout.lines().map(str::trim).filter(|line| line.contains("floor is assumed")).collect()
}

#[test]
fn an_assumed_floor_is_reported_once_with_its_source_and_area() {
    let mut house = House::new("IFC4");
    house.add_walls([0.0, 0.0, 6.0, 4.0], [0.0, 3.0]);
    house.add_room("Hall", [[0.0, 0.0, 0.0], [6.0, 4.0, 3.0]]);
    let maps = converted(&house);
    let expected = "warning: floor is assumed where the model has none (slabs, coverings, ramps): \
                    \"Ground\" 1 room: Hall 24.0 m2";
    assert_eq!(warnings(&maps), [expected], "{}", maps.stdout);
    assert_eq!(maps.manifest["storeys"][0]["floor"], "assumed");
    assert_eq!(maps.json("report.json")["assumed_rooms"][0]["name"], "Hall");
    assert_eq!(maps.storey(0).planning(3.0, 2.0), FREE);

    let mut house = House::new("IFC4");
    house.add_walls([0.0, 0.0, 6.0, 4.0], [0.0, 3.0]);
    let maps = converted(&house);
    let (what, area) = warnings(&maps)[0].split_once("): ").unwrap();
    assert_eq!((warnings(&maps).len(), what), (1, expected.split_once("): ").unwrap().0));
    let area_m2: f64 = area.strip_prefix("\"Ground\" ").unwrap().split_once(' ').unwrap().0.parse().unwrap();
    assert!((24.0..=6.5 * 4.5).contains(&area_m2), "what the walls enclose, and the walls: {area}");
    assert!(area.ends_with(" m2 that its walls enclose"), "{area}");

    house.add("IFCSLAB", "Slab", PLAIN, [[0.0, 0.0, -0.2], [6.0, 4.0, 0.0]]);
    let maps = converted(&house);
    assert_eq!((warnings(&maps).len(), &maps.manifest["storeys"][0]["floor"]), (0, &"built".into()));
}

#[test]
fn a_model_of_beams_alone_says_that_nothing_is_free_because_it_holds_no_floor() {
    let mut house = House::new("IFC4");
    for y in [0.0, 3.0] {
        house.add("IFCBEAM", "Beam", PLAIN, [[0.0, y, 0.5], [6.0, y + 0.2, 0.8]]);
    }
    let maps = converted(&house);
    let expected = "warning: the model holds no floor (slab, covering, ramp), no space and no wall: its maps show obstacles, \
                    no cell is free and there are no waypoints";
    assert_eq!(warnings(&maps), Vec::<&str>::new(), "nothing is assumed");
    assert_eq!(maps.stdout.matches(expected).count(), 1, "{}", maps.stdout);
    let line = maps.stdout.lines().find(|line| line.starts_with("storey  0")).unwrap();
    assert!(line.contains("0.0 m2 free, 2 obstacles, 0 waypoints, no floor in the model"), "{line}");
    assert!(!maps.stdout.contains("yet"), "{}", maps.stdout);
    assert_eq!(maps.manifest["storeys"][0]["status"], "no_floor");
    let storey = maps.storey(0);
    assert_eq!([storey.planning(3.0, 0.1), storey.planning(3.0, 1.5)], [OCCUPIED, UNKNOWN]);
    assert_eq!(maps.json("waypoints.json")["waypoints"], serde_json::json!([]));
}

#[test]
fn pavements_and_courses_near_the_height_of_a_storey_are_its_floor() {
    for entity in ["IFCPAVEMENT", "IFCCOURSE"] {
        let with = |top_m: f64| {
            let mut house = House::new("IFC4X3_ADD2");
            house.add(entity, "Road", PLAIN, [[0.0, 0.0, top_m - 0.2], [6.0, 4.0, top_m]]);
            house.add("IFCSLAB", "Slab beside it", PLAIN, [[20.0, 0.0, -0.2], [22.0, 4.0, 0.0]]);
            converted(&house)
        };
        let near = with(0.1);
        let storey = &near.manifest["storeys"][0];
        assert_eq!((&storey["floor"], storey["floor_z_m"].as_f64()), (&"built".into(), Some(0.1)), "{entity}");
        assert_eq!(near.storey(0).planning(3.0, 2.0), FREE, "{entity}");
        let far = with(-2.0);
        assert_eq!(far.manifest["storeys"][0]["floor_z_m"], 0.0, "{entity}");
        assert_eq!(far.storey(0).planning(3.0, 2.0), UNKNOWN, "{entity}");
    }
}

/// Storeys, by height in centimetres, that stairs, ramps or lifts of a class lead between.
fn ways(maps: &Maps, class: &str) -> Vec<[i64; 2]> {
    let graph = maps.json("site-graph.json");
    let list = |key: &str| graph[key].as_array().unwrap().clone();
    let heights: Vec<i64> = {
        let storeys = maps.manifest["storeys"].as_array().unwrap();
        storeys.iter().map(|s| (s["floor_z_m"].as_f64().unwrap() * 100.0).round() as i64).collect()
    };
    let height = |node: &serde_json::Value| {
        let storey = list("nodes").iter().find(|n| n["id"] == *node).unwrap()["storey"].as_u64().unwrap();
        heights[storey as usize]
    };
    let of_class = list("edges").into_iter().filter(|e| e["class"] == class);
    of_class.map(|e| [height(&e["from"]), height(&e["to"])]).collect()
}

/// Outline of a flight along x in x and z: steps of 0.28 by 0.175 m above a foot.
fn flight_outline(x_m: f64, foot_m: f64, n: usize) -> Vec<[f64; 2]> {
    let corner = |k: usize| [x_m + 0.28 * k as f64, foot_m + 0.175 * k as f64];
    let mut outline = vec![[corner(n)[0], foot_m], corner(n)];
    for k in (0..n).rev() {
        outline.extend([[corner(k)[0], corner(k + 1)[1]], corner(k)]);
    }
    outline
}

#[test]
fn of_two_levels_a_foot_apart_a_stair_joins_that_at_which_it_begins() {
    // Side by side: the floor from y = 6 m on, the platform up to there, and the upper floor over both.
    let with_stair = |foot_m: f64, n: usize, y: [f64; 2]| {
        let mut house = House::new("IFC4");
        house.add("IFCSLAB", "Floor", PLAIN, [[0.0, 6.0, -0.2], [14.0, 12.0, 0.0]]);
        house.add_room("Hall", [[0.0, 6.0, 0.0], [14.0, 12.0, 2.5]]);
        house.add("IFCSLAB", "Platform", PLAIN, [[0.0, 0.0, -0.2], [14.0, 6.0, 0.3]]);
        house.add_room("Platform", [[0.0, 0.0, 0.3], [14.0, 6.0, 2.5]]);
        let top_m = 2.0 + 0.28 * n as f64;
        house.add("IFCSLAB", "Upper floor", PLAIN, [[top_m, 2.0, 2.6], [14.0, 10.0, 2.8]]);
        house.add_prism("IFCSTAIRFLIGHT", "Stair", "$,$,$,$,$,$", &flight_outline(2.0, foot_m, n), y);
        let maps = converted(&house);
        assert_eq!(maps.manifest["storeys"].as_array().unwrap().len(), 3, "{}", maps.stdout);
        let mut ends = ways(&maps, "stair");
        ends.iter_mut().for_each(|ends| ends.sort_unstable());
        ends
    };
    assert_eq!(with_stair(0.0, 15, [6.0, 8.0]), [[0, 280]]);
    assert_eq!(with_stair(0.3, 13, [4.0, 6.0]), [[30, 280]]);
}

#[test]
fn a_sloped_slab_that_meets_floor_at_both_ends_is_a_ramp() {
    let with = |slope: &[[f64; 2]], kind: &str| {
        let mut house = House::new("IFC4");
        house.add("IFCSLAB", "Floor", PLAIN, [[0.0, 0.0, -0.2], [6.0, 6.0, 0.0]]);
        house.add_room("Hall", [[0.0, 0.0, 0.0], [6.0, 6.0, 2.5]]);
        house.add("IFCSLAB", "Platform", PLAIN, [[11.0, 0.0, 0.2], [17.0, 6.0, 0.4]]);
        let outline: Vec<[f64; 2]> =
            slope.iter().copied().chain(slope.iter().rev().map(|[x, z]| [*x, z - 0.2])).collect();
        house.add_prism("IFCSLAB", "Sloped slab", kind, &outline, [2.0, 4.0]);
        converted(&house)
    };
    let ramp = [[6.0, 0.0], [11.0, 0.4]];
    for kind in [PLAIN, "$,.FLOOR."] {
        let maps = with(&ramp, kind);
        assert_eq!(ways(&maps, "ramp"), [[0, 40]], "{}", maps.stdout);
        let graph = maps.json("site-graph.json");
        let edge = graph["edges"].as_array().unwrap().iter().find(|e| e["class"] == "ramp").unwrap().clone();
        let [slope_rad, rise_m, length_m] = ["slope_rad", "rise_m", "length_m"].map(|key| edge[key].as_f64().unwrap());
        assert!((slope_rad - libm::atan(0.4 / 5.0)).abs() < 1e-3 && (0.39..=0.4).contains(&rise_m), "{edge}");
        assert!(5.0 < length_m && length_m < 7.0 && edge["usable"] == true, "{edge}");
    }
    let n_levels = |maps: &Maps| maps.manifest["storeys"].as_array().unwrap().len();
    // A roof beside the hall that ends nowhere, one that ends above the platform, and a slope that is too steep.
    for slope in [[[6.0, 0.0], [10.0, 0.32]], [[6.0, 0.15], [11.0, 0.55]], [[7.0, 0.0], [11.0, 0.45]]] {
        let maps = with(&slope, "$,.ROOF.");
        assert_eq!((ways(&maps, "ramp").len(), n_levels(&maps)), (0, 1), "{slope:?}: {}", maps.stdout);
    }
}

#[test]
fn rooms_without_floor_under_them_are_listed_with_area_and_reason() {
    let mut house = House::new("IFC4");
    house.add_walls([0.0, 0.0, 12.0, 4.0], [0.0, 3.0]);
    house.add("IFCSLAB", "Floor", PLAIN, [[0.0, 0.0, -0.2], [8.0, 4.0, 0.0]]);
    house.add_room("Hall", [[0.0, 0.0, 0.0], [8.0, 4.0, 2.5]]);
    house.add_room("Void", [[8.0, 0.0, 0.0], [12.0, 4.0, 2.5]]);
    house.add_room("Attic", [[0.0, 0.0, 1.8], [5.0, 1.0, 2.5]]);
    let maps = converted(&house);
    for line in [
        "on no map: 1 room, 5.0 m2: Attic 5.0 m2\n",
        "on no map, without floor under them: 1 room, 16.0 m2: Void 16.0 m2\n",
    ] {
        assert_eq!(maps.stdout.matches(line).count(), 1, "{line}: {}", maps.stdout);
    }
    let report = maps.json("report.json");
    let rooms: Vec<_> = report["spaces_not_mapped"].as_array().unwrap().iter().collect();
    let facts: Vec<_> = rooms.iter().map(|r| (r["name"].as_str().unwrap(), r["area_m2"].as_f64().unwrap())).collect();
    assert_eq!(facts, [("Void", 16.0), ("Attic", 5.0)]);
    let reasons =
        ["there is no floor (slab, covering) under it at the level of its map storey", "its floor is on no map storey"];
    assert_eq!([&rooms[0]["reason"], &rooms[1]["reason"]], reasons);
}

#[test]
fn an_assumed_floor_ends_where_the_floor_of_another_level_is_built() {
    let with = |[bottom_m, top_m]: [f64; 2]| {
        let mut house = House::new("IFC4");
        house.add_walls([0.0, 0.0, 10.0, 10.0], [-0.7, 3.0]);
        house.add_room("Hall", [[0.0, 0.0, 0.0], [10.0, 10.0, 2.5]]);
        house.add("IFCSLAB", "Level", PLAIN, [[6.0, 6.0, bottom_m], [9.0, 9.0, top_m]]);
        house.add_room("Level", [[6.0, 6.0, top_m], [9.0, 9.0, 2.5]]);
        let maps = converted(&house);
        let floors: Vec<&str> =
            maps.manifest["storeys"].as_array().unwrap().iter().map(|s| s["floor"].as_str().unwrap()).collect();
        assert_eq!(floors, ["assumed", "built"], "{}", maps.stdout);
        (maps.storey(0), maps.storey(1))
    };
    // A pit is a drop-off of the hall, and a platform is in its way.
    for heights in [[-0.65, -0.45], [0.25, 0.45]] {
        let (hall, level) = with(heights);
        hall.assert_forbidden([6.1, 6.1, 8.9, 8.9]);
        assert_eq!((hall.planning(3.0, 3.0), level.planning(7.5, 7.5)), (FREE, FREE), "{heights:?}");
    }
    // Under a gallery with headroom for the robot the hall's floor goes on.
    let mut house = House::new("IFC4");
    house.add_walls([0.0, 0.0, 10.0, 10.0], [0.0, 3.0]);
    house.add_room("Hall", [[0.0, 0.0, 0.0], [10.0, 10.0, 2.5]]);
    house.add("IFCSLAB", "Gallery", PLAIN, [[6.0, 6.0, 1.3], [9.0, 9.0, 1.45]]);
    assert_eq!(converted(&house).storey(0).planning(7.5, 7.5), FREE);
}

/// A slab from corner to corner at a height, with a square hole of a metre in the middle if wanted.
fn add_slab(house: &mut House, [x0, y0, x1, y1]: [f64; 4], top: f64, has_hole: bool) {
    let mut part = |plan: [f64; 4]| {
        house.add("IFCSLAB", "Slab", PLAIN, [[plan[0], plan[1], top - 0.2], [plan[2], plan[3], top]]);
    };
    if !has_hole {
        return part([x0, y0, x1, y1]);
    }
    let [x, y] = [(x0 + x1) / 2.0, (y0 + y1) / 2.0];
    part([x0, y0, x1, y - 0.5]);
    part([x0, y + 0.5, x1, y1]);
    part([x0, y - 0.5, x - 0.5, y + 0.5]);
    part([x + 0.5, y - 0.5, x1, y + 0.5]);
}

/// Two rooms of 6 by 6 m on slabs, that of the first with a hole at (3, 3); between them is no wall.
fn house_with_a_hole() -> House {
    let mut house = House::new("IFC4");
    house.add_walls([0.0, 0.0, 12.0, 6.0], [0.0, 3.0]);
    for (name, x, has_hole) in [("A", 0.0, true), ("B", 6.0, false)] {
        add_slab(&mut house, [x, 0.0, x + 6.0, 6.0], 0.0, has_hole);
        house.add_room(name, [[x, 0.0, 0.0], [x + 6.0, 6.0, 3.0]]);
    }
    house
}

const HOLE: [f64; 4] = [2.55, 2.55, 3.45, 3.45];

#[test]
fn a_garden_without_floor_frees_no_hole_and_is_no_floor_itself() {
    let mut house = house_with_a_hole();
    house.add_space("Garden", "EXTERNAL", [[0.0, -20.0, 0.0], [12.0, -0.5, 3.0]]);
    let maps = converted(&house);
    assert_eq!((warnings(&maps).len(), &maps.manifest["storeys"][0]["floor"]), (0, &"built".into()));
    let storey = maps.storey(0);
    storey.assert_drop_off(HOLE);
    assert_eq!([storey.planning(1.0, 1.0), storey.planning(6.0, -10.0)], [FREE, UNKNOWN]);
}

#[test]
fn a_hall_without_a_slab_is_assumed_for_itself_and_frees_no_hole_of_its_neighbour() {
    let mut house = house_with_a_hole();
    house.add_walls([12.2, 0.0, 40.0, 6.0], [0.0, 3.0]);
    house.add_room("Hall", [[12.2, 0.0, 0.0], [40.0, 6.0, 3.0]]);
    let maps = converted(&house);
    assert_eq!(warnings(&maps).len(), 1, "{}", maps.stdout);
    assert!(warnings(&maps)[0].ends_with("\"Ground\" 1 room: Hall 166.8 m2"), "{}", maps.stdout);
    let rooms = maps.manifest["storeys"][0]["assumed_rooms"].as_array().unwrap().len();
    assert_eq!((rooms, &maps.manifest["storeys"][0]["floor"]), (1, &"assumed".into()));
    let storey = maps.storey(0);
    storey.assert_drop_off(HOLE);
    assert_eq!([storey.planning(1.0, 1.0), storey.planning(20.0, 3.0)], [FREE, FREE]);
}

#[test]
fn a_room_without_a_slab_above_another_room_is_a_void() {
    let mut house = house_with_a_hole();
    house.add_storey("First", 3.0);
    house.add_walls([0.0, 0.0, 12.0, 6.0], [3.0, 6.0]);
    add_slab(&mut house, [0.0, 0.0, 6.0, 6.0], 3.0, false);
    house.add_room("Office", [[0.0, 0.0, 3.0], [6.0, 6.0, 6.0]]);
    house.add_room("Atrium void", [[6.0, 1.0, 3.0], [12.0, 6.0, 6.0]]);
    let maps = converted(&house);
    assert_eq!(warnings(&maps), Vec::<&str>::new());
    let first = maps.storey(1);
    first.assert_drop_off([6.5, 1.5, 11.5, 5.5]);
    assert_eq!(first.planning(3.0, 3.0), FREE);
}

#[test]
fn a_void_above_walls_alone_is_a_drop_off() {
    let mut house = House::new("IFC4");
    house.add_storey("First", 3.0);
    for z in [0.0, 3.0] {
        house.add_walls([0.0, 0.0, 12.0, 6.0], [z, z + 3.0]);
    }
    add_slab(&mut house, [0.0, 0.0, 8.0, 6.0], 3.0, false);
    house.add_room("Office", [[0.0, 0.0, 3.0], [8.0, 6.0, 6.0]]);
    house.add_room("Atrium", [[8.0, 0.0, 3.0], [12.0, 6.0, 6.0]]);
    let maps = converted(&house);
    assert_eq!(maps.manifest["storeys"].as_array().unwrap().len(), 2);
    maps.storey(1).assert_drop_off([8.5, 0.5, 11.5, 5.5]);
}

#[test]
fn a_court_that_walls_enclose_is_no_floor_of_the_storey_above() {
    let mut house = House::new("IFC4");
    house.add_storey("First", 3.0);
    for z in [0.0, 3.0] {
        house.add_walls([0.0, 0.0, 20.0, 20.0], [z, z + 3.0]);
        house.add_walls([7.0, 7.0, 13.0, 13.0], [z, z + 3.0]);
    }
    add_slab(&mut house, [0.0, 0.0, 1.5, 1.5], 0.0, false);
    house.add_space("Court", "EXTERNAL", [[7.0, 7.0, 0.0], [13.0, 13.0, 3.0]]);
    let maps = converted(&house);
    let first = maps.storey(1);
    first.assert_drop_off([7.5, 7.5, 12.5, 12.5]);
}

#[test]
fn foundations_make_no_storey() {
    let mut house = house_with_a_hole();
    house.add_storey("Foundation", -1.6);
    house.add_walls([0.0, 0.0, 12.0, 6.0], [-1.6, -0.2]);
    assert_eq!(converted(&house).manifest["storeys"].as_array().unwrap().len(), 1);
}

#[test]
fn what_walls_enclose_is_floor_of_the_lowest_storey_and_above_ceilings_but_not_over_a_hall_or_a_stair() {
    let mut house = House::new("IFC4");
    house.add_storey("First", 3.0);
    for z in [0.0, 3.0] {
        house.add_walls([0.0, 0.0, 12.0, 6.0], [z, z + 3.0]);
    }
    house.add("IFCSLAB", "Roof", PLAIN, [[0.0, 0.0, 6.0], [12.0, 6.0, 6.2]]);
    house.add("IFCSTAIR", "Stair", "$,.STRAIGHT_RUN_STAIR.", [[3.0, 2.0, 0.0], [6.0, 4.0, 2.9]]);
    house.add("IFCCOVERING", "Ceiling", "$,.CEILING.", [[0.0, 0.0, 2.6], [8.0, 6.0, 2.7]]);
    let maps = converted(&house);
    let storeys = maps.manifest["storeys"].as_array().unwrap();
    let floors: Vec<&str> = storeys.iter().map(|s| s["floor"].as_str().unwrap()).collect();
    assert_eq!(floors[..2], ["assumed", "assumed"]);
    assert_eq!(warnings(&maps).len(), 1, "{}", maps.stdout);
    let [ground, first] = [0, 1].map(|index| maps.storey(index));
    assert_eq!([ground.planning(1.0, 3.0), first.planning(1.0, 3.0)], [FREE, FREE]);
    first.assert_drop_off([3.2, 2.2, 5.8, 3.8]);
    first.assert_drop_off([8.5, 0.5, 11.5, 5.5]);
}

#[test]
fn a_storey_is_mapped_although_its_elements_are_contained_nowhere() {
    let mut house = House::new("IFC4");
    house.add_walls([0.0, 0.0, 6.0, 4.0], [0.0, 3.0]);
    house.contain_nothing();
    let maps = converted(&house);
    assert_eq!(maps.manifest["storeys"][0]["name"], "Ground");
    assert_eq!(maps.storey(0).planning(3.0, 2.0), FREE);
}

#[test]
fn a_lift_shaft_is_on_no_map_and_no_level_although_its_pit_has_a_floor() {
    for (name, has_lift) in [("Aufzugsschacht 1", false), ("R.7", true)] {
        let mut house = house_with_a_hole();
        // The pit lies in the hole, and is larger than a level must be.
        let shaft = [[8.0, 2.0, -1.2], [10.5, 4.5, 3.0]];
        add_slab(&mut house, [8.0, 2.0, 10.5, 4.5], -1.2, false);
        house.add_space(name, "INTERNAL", shaft);
        if has_lift {
            house.add("IFCTRANSPORTELEMENT", "Car", "$,.ELEVATOR.", [[8.3, 2.3, 0.0], [10.2, 4.2, 2.2]]);
        }
        let maps = converted(&house);
        assert_eq!(maps.manifest["storeys"].as_array().unwrap().len(), 1, "the pit is no level");
        maps.storey(0).assert_forbidden([8.1, 2.1, 10.4, 4.4]);
        let room = &maps.json("report.json")["spaces_not_mapped"][0];
        assert_eq!(
            (&room["name"], &room["reason"]),
            (&name.into(), &"it is a lift shaft, a riser or a pit, where nobody walks".into())
        );
    }
}

#[test]
fn terrain_alone_makes_no_large_map() {
    let mut house = House::new("IFC4X3_ADD2");
    house.add("IFCGEOGRAPHICELEMENT", "Terrain", "$,.TERRAIN.", [[0.0, 0.0, -1.0], [600.0, 600.0, 0.5]]);
    house.add("IFCBEAM", "Beam", PLAIN, [[10.0, 10.0, 0.5], [16.0, 10.2, 0.8]]);
    let storey = &converted(&house).manifest["storeys"][0];
    let cells = |k: usize| storey["size_cells"][k].as_u64().unwrap();
    assert!(cells(0) * cells(1) < 100_000, "{storey}");
}

/// What a drawn room has.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Slab {
    Absent,
    Whole,
    Hole,
    /// The edge of a neighbour's.
    Sliver,
}

#[derive(Debug, Clone, Copy)]
struct DrawnRoom {
    slab: Slab,
    /// Name and PredefinedType of its space.
    space: Option<(&'static str, &'static str)>,
}

impl DrawnRoom {
    fn is_shaft(self) -> bool {
        self.space.is_some_and(|space| space.0 == "Shaft")
    }
}

fn drawn_room() -> impl Strategy<Value = DrawnRoom> {
    let slab =
        prop_oneof![3 => Just(Slab::Whole), 2 => Just(Slab::Hole), 2 => Just(Slab::Absent), 1 => Just(Slab::Sliver)];
    let space = prop_oneof![
        4 => Just(Some(("Room", "INTERNAL"))), 1 => Just(Some(("Garden", "EXTERNAL"))),
        1 => Just(Some(("Shaft", "INTERNAL"))), 1 => Just(None),
    ];
    (slab, space).prop_map(|(slab, space)| DrawnRoom { slab, space })
}

/// The level of a storey of the manifest, 3 m apart.
fn level_of(record: &serde_json::Value) -> usize {
    (record["floor_z_m"].as_f64().unwrap() / 3.0).round() as usize
}

/// Side of a drawn room, and from one to the next.
const SIDE: f64 = 4.0;
const PITCH: f64 = 4.2;

proptest! {
    #![proptest_config(ProptestConfig { cases: 40, ..ProptestConfig::default() })]

    #[test]
    fn nothing_is_free_without_built_floor_in_a_room_with_a_slab_outdoors_in_a_shaft_or_over_a_room(
        storeys in prop::collection::vec(prop::collection::vec(drawn_room(), 3), 1..3),
    ) {
        let mut house = House::new("IFC4");
        for (level, rooms) in storeys.iter().enumerate() {
            let z = 3.0 * level as f64;
            if level > 0 {
                house.add_storey("Upper", z);
            }
            for (k, room) in rooms.iter().enumerate() {
                let plan = [PITCH * k as f64, 0.0, PITCH * k as f64 + SIDE, SIDE];
                house.add_walls(plan, [z, z + 2.7]);
                match room.slab {
                    Slab::Absent => {}
                    Slab::Sliver => add_slab(&mut house, [plan[0], 0.0, plan[0] + 0.2, SIDE], z, false),
                    slab => add_slab(&mut house, plan, z, slab == Slab::Hole),
                }
                if let Some((name, kind)) = room.space {
                    house.add_space(name, kind, [[plan[0], 0.0, z], [plan[2], SIDE, z + 2.7]]);
                }
            }
        }
        let home = tempfile::tempdir().unwrap();
        let maps = convert(&house.write(home.path()), &["--resolution", "0.1", "--allow-empty"]);
        let levels: Vec<usize> = maps.manifest["storeys"].as_array().unwrap().iter().map(level_of).collect();
        let has_map = |level: usize| levels.contains(&level);
        for (index, record) in maps.manifest["storeys"].as_array().unwrap().iter().enumerate() {
            let level = level_of(record);
            let map = maps.storey(index);
            for (k, room) in storeys[level].iter().enumerate() {
                let is_over = level > 0 && record["floor"] == "built" && has_map(level - 1);
                let is_external = room.space.is_some_and(|space| space.1 == "EXTERNAL");
                let steps = || (1..40).map(|step| 0.1 * f64::from(step) + 0.05);
                for [x, y] in steps().flat_map(|x| steps().map(move |y| [x, y])) {
                    let in_hole = (x - SIDE / 2.0).abs() < 0.5 && (y - SIDE / 2.0).abs() < 0.5;
                    let is_built = match room.slab {
                        Slab::Whole => true,
                        Slab::Hole => !in_hole,
                        Slab::Sliver => x < 0.2,
                        Slab::Absent => false,
                    };
                    let has_slab = matches!(room.slab, Slab::Whole | Slab::Hole);
                    let is_danger = room.is_shaft() || !is_built && (has_slab || is_external || is_over);
                    let is_free = map.planning(PITCH * k as f64 + x, y) == FREE;
                    prop_assert!(!(is_danger && is_free), "room {k} of level {level} at {x:.2}, {y:.2}");
                }
            }
        }
    }
}
