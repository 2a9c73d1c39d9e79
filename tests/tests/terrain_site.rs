//! A site on rolling terrain, in every form in which files have it: the ground at dates against what the site was made of.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

use end_to_end::{Maps, Storey, convert, terrain_site};
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Corners are rounded, and the foot of a ramp lies within 2 cm of what is under it.
const TOLERANCE_M2: f64 = 0.05;

/// Writes the site, 60 x 60 m, and gives what it is made of.
fn site(folder: &Path, form: &str, coordinates: &str) -> (PathBuf, Value) {
    let (model, facts) = terrain_site(folder, &["--facts", "--form", form, "--coordinates", coordinates]);
    (model, serde_json::from_slice(&facts).unwrap())
}

fn converted(model: &Path, date: Option<&str>) -> Maps {
    let mut arguments = vec!["--with-ground", "--resolution", "0.25"];
    arguments.extend(date.iter().flat_map(|date| ["--date", date]));
    convert(model, &arguments)
}

/// Area in plan by class.
fn areas(ground: &Value) -> BTreeMap<String, f64> {
    let mut areas = BTreeMap::new();
    for surface in ground["surfaces"].as_array().unwrap() {
        let class = surface["class"].as_str().unwrap().to_owned();
        *areas.entry(class).or_insert(0.0) += surface["area_m2"].as_f64().unwrap();
    }
    areas
}

/// The ground of every state of the site has the classes and areas that it is made of.
fn check(form: &str, coordinates: &str) {
    let home = tempfile::tempdir().unwrap();
    let (model, facts) = site(home.path(), form, coordinates);
    for (state, expected) in facts["ground"].as_object().unwrap() {
        let maps = converted(&model, expected["date"].as_str());
        let found = areas(&maps.json("ground.json"));
        let expected = expected["area_m2"].as_object().unwrap();
        let what = format!("{form} {coordinates} {state}: {found:?}, {expected:?}");
        assert!(found.keys().eq(expected.keys()), "{what}");
        let is_near = |(class, m2): (&String, &Value)| (found[class] - m2.as_f64().unwrap()).abs() < TOLERANCE_M2;
        assert!(expected.iter().all(is_near), "{what}");
        let floors: Vec<f64> =
            maps.manifest["storeys"].as_array().unwrap().iter().map(|s| s["floor_z_m"].as_f64().unwrap()).collect();
        let wanted = facts["floors_z_m"].as_array().unwrap();
        let is_floor = |z: &Value| floors.iter().any(|floor| (floor - z.as_f64().unwrap()).abs() < 1e-3);
        assert!(wanted.iter().all(is_floor), "{what}: {floors:?}");
    }
}

#[test]
fn a_site_on_a_geographic_element_has_its_ground_at_every_date() {
    for form in ["tin-geographic", "faces-geographic"] {
        check(form, "local");
    }
}

#[test]
fn a_site_whose_own_shape_is_the_terrain_has_its_ground_at_every_date() {
    for form in ["tin-site", "faces-site", "shell-site", "brep-site"] {
        check(form, "local");
    }
}

#[test]
fn a_site_on_strata_has_its_ground_at_every_date() {
    for form in ["tin-stratum", "faces-stratum"] {
        check(form, "local");
    }
}

#[test]
fn a_site_in_coordinates_of_a_national_grid_has_the_same_ground() {
    for form in ["tin-geographic", "tin-site", "brep-site"] {
        check(form, "national");
    }
}

/// Middles of the doors of the site, by storey.
const DOORWAYS: [[f64; 2]; 3] = [[13.2, 22.15], [22.05, 26.0], [22.05, 26.0]];
const DOOR_STOREYS: [usize; 3] = [0, 0, 1];

#[test]
fn doors_of_a_site_in_coordinates_of_a_national_grid_are_as_open_as_those_of_a_local_one() {
    let look = |form: &str, coordinates: &str| {
        let home = tempfile::tempdir().unwrap();
        let (model, _) = site(home.path(), form, coordinates);
        let maps = convert(&model, &["--resolution", "0.05"]);
        let frame = &maps.manifest["frames"]["map_from_world"];
        let of_axis = |key: &str, national: f64| {
            frame[key].as_f64().unwrap() + if coordinates == "national" { national } else { 0.0 }
        };
        let map_from_site = [of_axis("x_m", 4_467_812.0), of_axis("y_m", 5_331_234.0)];
        let planning: Vec<u8> = std::iter::zip(DOORWAYS, DOOR_STOREYS)
            .map(|([x, y], k)| maps.storey(k).planning(x + map_from_site[0], y + map_from_site[1]))
            .collect();
        let doors: Vec<(Value, Value)> = (maps.json("report.json")["doors"].as_array().unwrap().iter())
            .map(|door| (door["name"].clone(), door["passage"].clone()))
            .collect();
        let ways = [("G.1", "G.2"), ("U.1", "U.2")].map(|(from, to)| way(&model, from, to, 0.1)["exists"].clone());
        (planning, doors, ways)
    };
    for form in ["tin-geographic", "brep-site"] {
        let (local, national) = (look(form, "local"), look(form, "national"));
        assert_eq!(local.0, [grid::FREE; 3], "{form}");
        assert!(local.1.iter().all(|(_, passage)| passage == "passable"), "{form}: {:?}", local.1);
        assert_eq!(local.2, [true, true].map(Value::Bool), "{form}");
        assert_eq!(national, local, "{form}");
    }
}

#[test]
fn a_pit_is_full_before_it_is_dug_open_with_its_ramp_and_filled_again() {
    let home = tempfile::tempdir().unwrap();
    let (model, facts) = site(home.path(), "tin-stratum", "local");
    let number = |name: &str| facts[name].as_f64().unwrap();
    let (top, bottom) = (number("ground_z_m"), number("pit_floor_z_m"));
    let [before, open, filled] = ["before", "open", "filled"].map(|state| {
        let maps = converted(&model, facts["ground"][state]["date"].as_str());
        maps.json("ground.json")["surfaces"].as_array().unwrap().clone()
    });
    // What lies at the bottom of the pit, or leads down to it.
    let in_pit = |surfaces: &[Value]| -> Vec<(String, f64)> {
        let reaches_down = |s: &&Value| (s["min_m"][2].as_f64().unwrap() - bottom).abs() < 1e-3;
        let of = |s: &Value| (s["class"].as_str().unwrap().to_owned(), s["max_m"][2].as_f64().unwrap());
        surfaces.iter().filter(reaches_down).map(of).collect()
    };
    assert_eq!(in_pit(&before), []);
    assert_eq!(in_pit(&open), [("terrain".to_owned(), bottom), ("road".to_owned(), top)]);
    assert_eq!(in_pit(&filled), []);
}

/// The map storeys of the site at a date, for a robot that climbs so steeply: ground floor, upper floor, outdoors.
fn storeys(model: &Path, date: Option<&str>, max_slope_rad: f64) -> [Storey; 3] {
    let folder = tempfile::tempdir().unwrap();
    let robot = folder.path().join("robot.toml");
    std::fs::write(&robot, format!("name = \"climber\"\nmax_slope_rad = {max_slope_rad}\n")).unwrap();
    let robot = robot.to_str().unwrap();
    let mut arguments = vec!["--robot", robot, "--resolution", "0.1"];
    arguments.extend(date.iter().flat_map(|date| ["--date", date]));
    let maps = convert(model, &arguments);
    let floors: Vec<&str> =
        maps.manifest["storeys"].as_array().unwrap().iter().map(|s| s["floor"].as_str().unwrap()).collect();
    assert_eq!(floors, ["built", "built", "ground"]);
    [0, 1, 2].map(|k| maps.storey(k))
}

#[test]
fn ramps_and_roads_are_free_for_robots_that_climb_them() {
    const RAMP_AT_8: [f64; 2] = [20.0, 32.4];
    const ROAD_AT_8: [f64; 2] = [15.0, 5.0];
    const ROAD_AT_14: [f64; 2] = [44.0, 5.0];
    let home = tempfile::tempdir().unwrap();
    for form in ["tin-geographic", "tin-site"] {
        let (model, facts) = site(home.path(), form, "local");
        let open = facts["ground"]["open"]["date"].as_str();
        for (max_slope_rad, climbs) in [(0.05, [false, false]), (0.1, [true, false]), (0.2, [true, true])] {
            let [ground_floor, upper_floor, outdoors] = storeys(&model, open, max_slope_rad);
            let is_free = |storey: &Storey, at: [f64; 2]| storey.planning(at[0], at[1]) == grid::FREE;
            let found = [is_free(&outdoors, ROAD_AT_8), is_free(&outdoors, ROAD_AT_14)];
            assert_eq!(found, climbs, "{form} {max_slope_rad}");
            let on_ramp = [&ground_floor, &upper_floor].map(|storey| is_free(storey, RAMP_AT_8));
            assert_eq!(
                on_ramp, [climbs[0]; 2],
                "{form} {max_slope_rad}: the ramp is on the maps of both floors or of none"
            );
        }
    }
}

#[test]
fn a_pit_is_ground_before_it_is_dug_and_has_an_edge_while_it_is_open() {
    let home = tempfile::tempdir().unwrap();
    let (model, facts) = site(home.path(), "tin-geographic", "local");
    // In the pit beside its ramp, on the ramp, and at the pit's western edge.
    let places = [[48.5, 30.0], [52.0, 40.0], [46.9, 30.0]];
    let look = |state: &str| {
        let [_, _, outdoors] = storeys(&model, facts["ground"][state]["date"].as_str(), 0.12);
        places.map(|[x, y]| (outdoors.planning(x, y) == grid::FREE, outdoors.keepout(x, y) == grid::OCCUPIED))
    };
    assert_eq!(look("before"), [(true, false); 3]);
    assert_eq!(look("open"), [(true, false), (true, false), (false, true)]);
    assert_eq!(look("filled"), [(true, false); 3]);
}

/// The answer of `groundplan way` for a robot that climbs so steeply; exit code 0 says that there is a way, 1 that there is none.
fn way(model: &Path, from: &str, to: &str, max_slope_rad: f64) -> Value {
    let folder = tempfile::tempdir().unwrap();
    let robot = folder.path().join("robot.toml");
    std::fs::write(&robot, format!("name = \"climber\"\nmax_slope_rad = {max_slope_rad}\n")).unwrap();
    let rest = ["--resolution", "0.1", "--only-now", "--json"];
    let [question, ends, profile] = ["way", "--", "--robot"];
    let mut arguments: Vec<&dyn AsRef<std::ffi::OsStr>> = vec![&question, &profile, &robot];
    arguments.extend(rest.iter().map(|argument| argument as &dyn AsRef<std::ffi::OsStr>));
    arguments.extend([&ends as &dyn AsRef<std::ffi::OsStr>, &from, &to, &model]);
    let output = end_to_end::groundplan(&arguments);
    serde_json::from_slice(&output.stdout).unwrap_or_else(|_| panic!("{}", String::from_utf8_lossy(&output.stderr)))
}

fn kinds(answer: &Value) -> Vec<&str> {
    answer["legs"].as_array().unwrap().iter().map(|leg| leg["kind"].as_str().unwrap()).collect()
}

#[test]
fn a_way_from_the_yard_leads_over_ramps_into_the_storeys_and_tells_how_far_it_climbs() {
    let home = tempfile::tempdir().unwrap();
    let (model, facts) = site(home.path(), "tin-geographic", "local");
    let floors: Vec<f64> = facts["floors_z_m"].as_array().unwrap().iter().map(|z| z.as_f64().unwrap()).collect();
    let number = |value: &Value| value.as_f64().unwrap();
    for (room, n_storeys, floor_z_m) in [("G.1", 1, floors[0]), ("U.1", 2, floors[1])] {
        let answer = way(&model, "5,5,Site", room, 0.1);
        let expected = ["floor", "ground", "floor", "ramp", "floor"];
        assert_eq!(kinds(&answer), expected[..2 * n_storeys + 1], "{answer}");
        let legs = answer["legs"].as_array().unwrap();
        let points = |leg: &Value| -> Vec<f64> {
            leg["points_m"].as_array().unwrap().iter().map(|point| point[2].as_f64().unwrap()).collect()
        };
        let (start_z_m, end_z_m) = (points(&legs[0])[0], *points(&legs[2 * n_storeys]).last().unwrap());
        assert!((end_z_m - floor_z_m).abs() < 1e-3, "{answer}");
        // What it climbs less what it falls is the height between the ends.
        let rise_m = number(&answer["climb_m"]) - number(&answer["descent_m"]);
        assert!((rise_m - (end_z_m - start_z_m)).abs() < 0.03, "{rise_m}: {answer}");
        assert!(legs.iter().all(|leg| number(&leg["slope_rad"]) <= 0.1), "{answer}");
        let doors = legs[2]["doors"].as_array().unwrap();
        assert_eq!(doors[0]["name"], "G wall south door 1", "{answer}");
    }
    let too_steep = way(&model, "5,5,Site", "G.1", 0.05);
    assert_eq!((&too_steep["exists"], kinds(&too_steep).len()), (&Value::Bool(false), 0));
    let missing = too_steep["missing"].as_array().unwrap();
    assert_eq!(missing.len(), 1, "{too_steep}");
    assert_eq!(missing[0]["kind"], "ramp", "{too_steep}");
    let backwards = way(&model, "U.1", "5,5,Site", 0.1);
    assert_eq!(kinds(&backwards), ["floor", "ramp", "floor", "ground", "floor"]);
}
