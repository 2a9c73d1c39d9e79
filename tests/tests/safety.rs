//! Distances and limits of speed by what elements are, on the demo building.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

use end_to_end::{FREE, Maps, convert, demo_model, groundplan, terrain_site};
use serde_json::Value;
use std::path::{Path, PathBuf};

/// A profile like the default one with these entries.
fn robot(home: &Path, entries: &str) -> PathBuf {
    let path = home.join("robot.toml");
    std::fs::write(&path, format!("name = \"default\"\n{entries}")).unwrap();
    path
}

fn converted(entries: &str) -> Maps {
    let home = tempfile::tempdir().unwrap();
    let robot = robot(home.path(), entries);
    convert(&demo_model(), &["--robot", robot.to_str().unwrap()])
}

/// A mask of a storey, and which element each of its cells has its value from.
struct Layer {
    folder: PathBuf,
    document: Value,
    width: usize,
}

impl Layer {
    fn of(maps: &Maps, storey: usize) -> Self {
        let record = &maps.manifest["storeys"][storey];
        let folder = maps.path().join(record["directory"].as_str().unwrap());
        let document = serde_json::from_slice(&std::fs::read(folder.join("safety.json")).unwrap()).unwrap();
        Self { folder, document, width: record["size_cells"][0].as_u64().unwrap() as usize }
    }

    fn pixels(&self, name: &str) -> Vec<u8> {
        grid::decode_pgm(&std::fs::read(self.folder.join(name)).unwrap()).unwrap().2
    }

    /// GlobalId of the element of each cell.
    fn elements(&self, key: &str) -> Vec<Option<&str>> {
        let planning = self.pixels("planning.pgm");
        let mut elements = vec![None; planning.len()];
        for stretch in self.document[key].as_array().unwrap() {
            let [row, first, end, source] = [0, 1, 2, 3].map(|k| stretch[k].as_u64().unwrap() as usize);
            let id = self.document["sources"][source]["global_id"].as_str();
            elements[row * self.width + first..row * self.width + end].fill(id);
        }
        elements
    }
}

#[test]
fn a_robot_without_entries_has_the_files_of_the_default_one() {
    let plain = convert(&demo_model(), &[]);
    assert_eq!(plain.contents(), converted("").contents());
    let named: Vec<&String> = plain.manifest["files"].as_object().unwrap().keys().collect();
    assert!(!named.iter().any(|name| name.contains("speed") || name.contains("costs") || name.contains("safety")));
}

#[test]
fn beside_glass_the_speed_is_limited_and_the_element_is_named() {
    let maps = converted("[[safety]]\nnear = \"glass\"\ndistance_m = 0.6\nspeed_m_s = 0.4\n");
    let semantic = maps.json("semantic.json");
    let layer = Layer::of(&maps, 0);
    let (speed, costs, planning) = (layer.pixels("speed.pgm"), layer.pixels("costs.pgm"), layer.pixels("planning.pgm"));
    let elements = layer.elements("speed_cells");
    // 0.4 m/s are 40 steps of 0.01 m/s; the mode `scale` reads 153 as 40.
    assert_eq!(layer.document["speed_step_m_s"], 0.01);
    let mut n_limited = 0;
    for cell in 0..speed.len() {
        let Some(id) = elements[cell] else {
            assert_eq!((speed[cell], costs[cell]), (255, 255), "no limit, no cost");
            continue;
        };
        n_limited += 1;
        assert_eq!(speed[cell], 153);
        assert!((10..=90).contains(&costs[cell]), "{}", costs[cell]);
        assert_eq!(planning[cell], FREE, "all rooms are open: limits are where nothing stands");
        // The element is glass, and no farther from the cell than the rule says.
        let (x, y) = (cell % layer.width, cell / layer.width);
        let origin = &maps.manifest["storeys"][0]["origin_m"];
        let at = [(x, 0), (y, 1)].map(|(n, k)| origin[k].as_f64().unwrap() + (n as f64 + 0.5) * 0.05);
        let aabb = &semantic["elements"][id]["aabb_m"];
        let off = [0, 1].map(|k| {
            let [low, high] = ["min", "max"].map(|end| aabb[end][k].as_f64().unwrap());
            (low - at[k]).max(at[k] - high).max(0.0)
        });
        assert!(length(off) <= 0.75, "{at:?} {id} {aabb}");
    }
    assert!(n_limited > 1_000, "{n_limited}");
    let yaml = std::fs::read_to_string(layer.folder.join("speed.yaml")).unwrap();
    assert!(yaml.contains("mode: scale") && yaml.contains("image: speed.pgm"), "{yaml}");
    let filter = std::fs::read_to_string(layer.folder.join("speed_filter.yaml")).unwrap();
    assert!(filter.contains("type: 2") && filter.contains("multiplier: 0.01"), "{filter}");
}

fn length([x, y]: [f64; 2]) -> f64 {
    (x * x + y * y).sqrt()
}

#[test]
fn doors_swing_and_stairs_lead_down_and_each_names_its_element() {
    let maps = converted(
        "[[safety]]\nnear = \"door_swing\"\nspeed_m_s = 0.2\n[[safety]]\nnear = \"stair_edge\"\ndistance_m = 1.0\n",
    );
    let semantic = maps.json("semantic.json");
    let class = |id: &str| semantic["elements"][id]["class"].as_str().unwrap().to_owned();
    let ground = Layer::of(&maps, 0);
    let doors: std::collections::BTreeSet<&str> = ground.elements("speed_cells").into_iter().flatten().collect();
    assert!(doors.len() >= 5 && doors.iter().all(|id| class(id) == "door"), "{doors:?}");
    let upper = Layer::of(&maps, 1);
    let stairs: std::collections::BTreeSet<&str> = upper.elements("cost_cells").into_iter().flatten().collect();
    assert!(!stairs.is_empty() && stairs.iter().all(|id| class(id) == "stair"), "{stairs:?}");
    assert!(ground.elements("cost_cells").iter().all(Option::is_none), "no stair leads down from the ground floor");
}

#[test]
fn treads_are_floor_of_a_robot_that_drives_on_stairs_and_cost_what_its_profile_says() {
    let entries = "climbs_stairs = true\nstair_cost = 60\n[[safety]]\nnear = \"stair\"\nspeed_m_s = 0.3\n";
    let (plain, maps) = (converted("climbs_stairs = true\n"), converted(entries));
    let semantic = maps.json("semantic.json");
    let class = |id: &str| semantic["elements"][id]["class"].as_str().unwrap().to_owned();
    let mut n_treads = 0;
    for storey in 0..2 {
        let layer = Layer::of(&maps, storey);
        let near: Vec<&str> =
            layer.document["rules"].as_array().unwrap().iter().map(|r| r["near"].as_str().unwrap()).collect();
        assert_eq!(near, ["stair", "stair"], "the limit of speed, and the cost of the profile");
        let before = plain.path().join(maps.manifest["storeys"][storey]["directory"].as_str().unwrap());
        let before = grid::decode_pgm(&std::fs::read(before.join("planning.pgm")).unwrap()).unwrap().2;
        let (planning, costs, speed) =
            (layer.pixels("planning.pgm"), layer.pixels("costs.pgm"), layer.pixels("speed.pgm"));
        let elements = layer.elements("cost_cells");
        let is_beside_tread = |cell: usize| {
            let sides = [1, layer.width].into_iter().flat_map(|off| [cell - off, cell + off]);
            sides.into_iter().any(|beside| elements[beside].is_some())
        };
        for (cell, &element) in elements.iter().enumerate() {
            let Some(id) = element else {
                assert_eq!((costs[cell], speed[cell]), (255, 255));
                // The edge of the floor at its end was below a part of the stair.
                let is_new = planning[cell] == FREE && before[cell] != FREE;
                assert!(!is_new || is_beside_tread(cell), "what is free now is a tread, or the floor before one");
                continue;
            };
            n_treads += 1;
            assert_eq!((planning[cell], costs[cell], class(id).as_str()), (FREE, 60, "stair"));
            // 0.3 m/s are 30 steps of 0.01 m/s.
            assert!(speed[cell] != 255 && before[cell] != FREE, "{cell}");
        }
    }
    // Most of a stair of 1.2 m by some metres, on both storeys.
    assert!(n_treads > 1_000, "{n_treads}");
    let is_on_stair = |waypoint: &Value| {
        let storey = waypoint["storey"].as_u64().unwrap() as usize;
        let origin = &maps.manifest["storeys"][storey]["origin_m"];
        let [column, row] = [("x_m", 0), ("y_m", 1)]
            .map(|(key, k)| ((waypoint[key].as_f64().unwrap() - origin[k].as_f64().unwrap()) / 0.05) as usize);
        let layer = Layer::of(&maps, storey);
        layer.pixels("costs.pgm")[row * layer.width + column] == 60
    };
    let waypoints = maps.json("waypoints.json");
    let waypoints = waypoints["waypoints"].as_array().unwrap();
    assert!(!waypoints.is_empty() && !waypoints.iter().any(is_on_stair), "nobody scans from a stair");
}

#[test]
fn beside_a_ramp_what_stands_at_its_height_is_near_on_the_maps_of_both_storeys_and_outdoors() {
    let home = tempfile::tempdir().unwrap();
    let (model, _) = terrain_site(home.path(), &[]);
    let robot = robot(home.path(), "[[safety]]\nnear = \"class\"\nclass = \"wall\"\ndistance_m = 0.5\n");
    let arguments = ["--robot", robot.to_str().unwrap(), "--resolution", "0.1", "--date", "2024-04-10T00:00:00"];
    let maps = convert(&model, &arguments);
    let semantic = maps.json("semantic.json");
    let name = |id: &str| semantic["elements"][id]["name"].as_str().unwrap().to_owned();
    let is_outdoors = |storey: usize| maps.manifest["storeys"][storey]["floor"] == "ground";
    assert_eq!([0, 1, 2].map(is_outdoors), [false, false, true]);
    // The ramp climbs along its wall from 100.3 m to 103.1 m; above the wall of the ground floor is the parapet of the upper one, whose
    // other walls the ground floor has nothing to do with.
    for (storey, near, far) in [
        (0, ["G wall beside the ramp", "U wall beside the ramp"], Some("U wall south")),
        (1, ["G wall beside the ramp", "U wall beside the ramp"], Some("Hoarding")),
        (2, ["U wall beside the ramp", "Hoarding"], None),
    ] {
        let layer = Layer::of(&maps, storey);
        let sources = layer.document["sources"].as_array().unwrap().iter();
        let named: Vec<String> = sources.map(|source| name(source["global_id"].as_str().unwrap())).collect();
        let is_named = |wanted: &str| named.iter().any(|name| name == wanted);
        assert!(near.into_iter().all(is_named) && !far.is_some_and(is_named), "storey {storey}: {named:?}");
        // On the ramp at both ends, a quarter of a metre from the wall beside it.
        let origin = &maps.manifest["storeys"][storey]["origin_m"];
        for x in [8.05, 36.05] {
            let [column, row] = [(x, 0), (31.45, 1)]
                .map(|(at, k): (f64, usize)| ((at - origin[k].as_f64().unwrap()) / 0.1).floor() as usize);
            let id = layer.elements("cost_cells")[row * layer.width + column];
            assert!(
                id.is_some_and(|id| name(id).ends_with("wall beside the ramp")),
                "storey {storey} at {x} m: {id:?}"
            );
        }
    }
}

#[test]
fn centres_of_rooms_keep_the_distance_and_the_same_rooms_are_reached() {
    let plain = convert(&demo_model(), &[]).json("waypoints.json");
    let maps = converted("[[safety]]\nnear = \"class\"\nclass = \"wall\"\ndistance_m = 1.2\n");
    let kept = maps.json("waypoints.json");
    let reached = |waypoints: &Value| {
        let centres = waypoints["waypoints"].as_array().unwrap().iter().filter(|w| w["kind"] == "centre");
        centres.map(|w| w["space"].as_str().unwrap().to_owned()).collect::<std::collections::BTreeSet<_>>()
    };
    assert_eq!(reached(&plain), reached(&kept));
    let layers: Vec<Layer> = (0..2).map(|storey| Layer::of(&maps, storey)).collect();
    let costs: Vec<Vec<u8>> = layers.iter().map(|layer| layer.pixels("costs.pgm")).collect();
    let within = |w: &Value| {
        let storey = w["storey"].as_u64().unwrap() as usize;
        let origin = &maps.manifest["storeys"][storey]["origin_m"];
        let at = [("x_m", 0), ("y_m", 1)]
            .map(|(key, k)| ((w[key].as_f64().unwrap() - origin[k].as_f64().unwrap()) / 0.05).floor() as usize);
        costs[storey][at[1] * layers[storey].width + at[0]] != 255
    };
    let all = kept["waypoints"].as_array().unwrap().iter().filter(|w| w["storey"].as_u64().unwrap() < 2);
    let n_within = all.filter(|w| within(w)).count();
    let notices = kept.to_string();
    let n_said = notices.matches("lies within a distance that the robot is to keep").count();
    assert!(
        n_within > 0 && n_said >= n_within,
        "small rooms have no other place, and that is said: {n_within} {n_said}"
    );
    let before = plain["waypoints"].as_array().unwrap().iter().filter(|w| w["storey"].as_u64().unwrap() < 2);
    let n_before = before.filter(|w| within(w)).count();
    assert!(n_within < n_before, "{n_within} of {n_before}");
}

#[test]
fn an_entry_that_cannot_be_is_refused_with_its_name_and_nothing_is_written() {
    let home = tempfile::tempdir().unwrap();
    let robot = robot(home.path(), "[[safety]]\nnear = \"glass\"\ndistance_m = -1.0\n");
    let out = home.path().join("out");
    let output = groundplan(&[&"convert", &demo_model(), &"-o", &out, &"--robot", &robot]);
    let error = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{error}");
    assert!(error.contains("safety entry 1 (near \"glass\"): distance_m is -1, it must be from 0 to 20"), "{error}");
    assert!(!out.exists());
}
