//! Floors of small models, and warnings where the model has none.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

mod support;

use support::house::{House, PLAIN};
use support::{FREE, Maps, OCCUPIED, UNKNOWN, convert};

fn converted(house: &House) -> Maps {
    let home = tempfile::tempdir().unwrap();
    convert(&house.write(home.path()), &[])
}

/// The lines about an assumed floor.
fn warnings(maps: &Maps) -> Vec<&str> {
    maps.stdout.lines().map(str::trim).filter(|line| line.contains("so it is assumed")).collect()
}

#[test]
fn an_assumed_floor_is_reported_once_with_its_source_and_area() {
    let mut house = House::new("IFC4");
    house.add_walls([0.0, 0.0, 6.0, 4.0], [0.0, 3.0]);
    house.add_room("Hall", [[0.0, 0.0, 0.0], [6.0, 4.0, 3.0]]);
    let maps = converted(&house);
    let expected = "warning: the model has too little floor (slabs, coverings, ramps), so it is assumed: \
                    \"Ground\" 24.0 m2 from its spaces";
    assert_eq!(warnings(&maps), [expected], "{}", maps.stdout);
    assert_eq!(maps.manifest["storeys"][0]["floor"], "assumed");
    assert_eq!(maps.storey(0).planning(3.0, 2.0), FREE);

    let mut house = House::new("IFC4");
    house.add_walls([0.0, 0.0, 6.0, 4.0], [0.0, 3.0]);
    let maps = converted(&house);
    let (what, area) = warnings(&maps)[0].rsplit_once(": ").unwrap();
    assert_eq!((warnings(&maps).len(), what), (1, expected.rsplit_once(": ").unwrap().0));
    let area_m2: f64 = area.strip_prefix("\"Ground\" ").unwrap().split_once(' ').unwrap().0.parse().unwrap();
    assert!((24.0..=6.5 * 4.5).contains(&area_m2), "what the walls enclose, and the walls: {area}");
    assert!(area.ends_with(" m2 from what its walls enclose"), "{area}");

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
        assert!((slope_rad - libm::atan(0.4 / 5.0)).abs() < 1e-3 && (rise_m - 0.4).abs() < 1e-9, "{edge}");
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
