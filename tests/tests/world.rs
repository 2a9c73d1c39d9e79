//! The demo building as a simulation world: read back as any reader of SDF would, in one frame with the maps.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

use end_to_end::house::{House, PLAIN};
use end_to_end::{FREE, Maps, OCCUPIED, UNKNOWN, convert, demo_model, terrain_site};
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// A collision shape of a static model, as corners in `map` and faces.
struct Shape {
    link: String,
    corners: Vec<[f64; 3]>,
    faces: Vec<Vec<usize>>,
}

/// Faces of a box whose corners are counted by bits.
const BOX_FACES: [[usize; 4]; 6] = [[0, 1, 3, 2], [4, 5, 7, 6], [0, 1, 5, 4], [2, 3, 7, 6], [0, 2, 6, 4], [1, 3, 7, 5]];

fn attribute<'a>(line: &'a str, name: &str) -> &'a str {
    line.split_once(&format!("{name}=\"")).unwrap().1.split_once('"').unwrap().0
}

fn numbers(line: &str, tag: &str) -> Option<Vec<f64>> {
    let text = line.split_once(&format!("<{tag}>"))?.1.split_once(&format!("</{tag}>")).unwrap().0;
    Some(text.split_whitespace().map(|n| n.parse().unwrap()).collect())
}

fn corners_of(line: &str, folder: &Path) -> (Vec<[f64; 3]>, Vec<Vec<usize>>) {
    if let Some(size) = numbers(line, "size") {
        let side = |k: usize, bit: usize| if bit >> k & 1 == 1 { size[k] / 2.0 } else { -size[k] / 2.0 };
        return ((0..8).map(|bit| [0, 1, 2].map(|k| side(k, bit))).collect(), BOX_FACES.map(Vec::from).into());
    }
    let uri = line.split_once("<uri>").unwrap().1.split_once("</uri>").unwrap().0;
    let text = std::fs::read_to_string(folder.join(uri)).unwrap();
    let vertices = text.lines().filter_map(|l| l.strip_prefix("v "));
    let corner = |l: &str| {
        let mut c = l.split_whitespace().map(|n| n.parse().unwrap());
        [c.next().unwrap(), c.next().unwrap(), c.next().unwrap()]
    };
    let faces = text.lines().filter_map(|l| l.strip_prefix("f "));
    let face = |l: &str| l.split_whitespace().map(|n| n.parse::<usize>().unwrap() - 1).collect();
    (vertices.map(corner).collect(), faces.map(face).collect())
}

/// Roll, pitch, yaw about fixed axes, then the shift.
fn posed(pose: &[f64], p: [f64; 3]) -> [f64; 3] {
    let turned = |p: [f64; 3], axis: usize, angle: f64| {
        let (sin, cos) = libm::sincos(angle);
        let (i, j) = ((axis + 1) % 3, (axis + 2) % 3);
        let mut q = p;
        q[i] = cos * p[i] - sin * p[j];
        q[j] = sin * p[i] + cos * p[j];
        q
    };
    let q = (0..3).fold(p, |p, axis| turned(p, axis, pose[3 + axis]));
    [0, 1, 2].map(|k| q[k] + pose[k])
}

fn static_shapes(maps: &Maps) -> Vec<Shape> {
    let folder = maps.path().join("world");
    let text = std::fs::read_to_string(folder.join("world.sdf")).unwrap();
    let (mut found, mut model, mut link) = (Vec::new(), String::new(), String::new());
    for line in text.lines().map(str::trim) {
        if line.starts_with("<model ") {
            model = attribute(line, "name").to_owned();
        } else if line.starts_with("<link ") {
            link = attribute(line, "name").to_owned();
        } else if line.starts_with("<collision ") && !model.starts_with("door_") {
            let pose = numbers(line, "pose").unwrap_or(vec![0.0; 6]);
            let (corners, faces) = corners_of(line, &folder);
            let corners = corners.into_iter().map(|c| posed(&pose, c)).collect();
            found.push(Shape { link: link.clone(), corners, faces });
        }
    }
    found
}

/// Plan of a convex shape between two heights: corners of the hull of what is cut out.
fn plan(corners: &[[f64; 3]], low: f64, high: f64) -> Vec<[f64; 2]> {
    let mut points: Vec<[f64; 2]> =
        corners.iter().filter(|c| low <= c[2] && c[2] <= high).map(|c| [c[0], c[1]]).collect();
    // Of a convex body all lines between corners lie inside, so that cutting them all gives its section.
    for (k, a) in corners.iter().enumerate() {
        for b in &corners[..k] {
            for z in [low, high].into_iter().filter(|z| (a[2] < *z) != (b[2] < *z)) {
                let part = (z - a[2]) / (b[2] - a[2]);
                points.push([0, 1].map(|i| a[i] + part * (b[i] - a[i])));
            }
        }
    }
    hull(points)
}

fn hull(mut points: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
    points.sort_by(|a, b| a.partial_cmp(b).unwrap());
    let turn = |o: [f64; 2], a: [f64; 2], b: [f64; 2]| (a[0] - o[0]) * (b[1] - o[1]) - (a[1] - o[1]) * (b[0] - o[0]);
    let chain = |points: &mut dyn Iterator<Item = [f64; 2]>| {
        let mut out: Vec<[f64; 2]> = Vec::new();
        for p in points {
            while out.len() >= 2 && turn(out[out.len() - 2], out[out.len() - 1], p) <= 1e-12 {
                out.pop();
            }
            out.push(p);
        }
        out.pop();
        out
    };
    let mut hull = chain(&mut points.iter().copied());
    hull.extend(chain(&mut points.iter().rev().copied()));
    hull
}

/// Distance of a point from a convex plan; 0 inside.
fn distance(plan: &[[f64; 2]], p: [f64; 2]) -> f64 {
    let edges = || plan.iter().zip(plan.iter().cycle().skip(1));
    if edges().all(|(a, b)| (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]) >= 0.0) {
        return 0.0;
    }
    let off = |(a, b): (&[f64; 2], &[f64; 2])| {
        let (d, v) = ([b[0] - a[0], b[1] - a[1]], [p[0] - a[0], p[1] - a[1]]);
        let s = ((v[0] * d[0] + v[1] * d[1]) / (d[0] * d[0] + d[1] * d[1])).clamp(0.0, 1.0);
        (v[0] - s * d[0]).hypot(v[1] - s * d[1])
    };
    edges().map(off).fold(f64::INFINITY, f64::min)
}

/// Rectangles around the footprints of doors that are closed on the maps: x from, y from, x to, y to.
fn closed_doors(maps: &Maps) -> Vec<[f64; 4]> {
    let semantic = maps.json("semantic.json");
    let report = maps.json("report.json");
    let closed = report["doors"].as_array().unwrap().iter().filter(|d| d["passage"] != "passable");
    closed.map(|door| around(&semantic["elements"][door["global_id"].as_str().unwrap()])).collect()
}

/// The same around ramps.
fn ramps(maps: &Maps) -> Vec<[f64; 4]> {
    let semantic = maps.json("semantic.json");
    let has_body = |e: &&Value| e["class"] == "ramp" && e["aabb_m"].is_object();
    semantic["elements"].as_object().unwrap().values().filter(has_body).map(around).collect()
}

fn around(element: &Value) -> [f64; 4] {
    let aabb = &element["aabb_m"];
    let [low, high] = ["min", "max"].map(|end| [0, 1].map(|k| aabb[end][k].as_f64().unwrap()));
    [low[0], low[1], high[0], high[1]]
}

fn is_within(&[x0, y0, x1, y1]: &[f64; 4], [x, y]: [f64; 2], reach: f64) -> bool {
    x0 - reach <= x && x <= x1 + reach && y0 - reach <= y && y <= y1 + reach
}

/// Walks rays in steps of a quarter of a cell: a map's end must be near a piece, and a piece must not be passed by the map.
#[test]
fn rays_in_the_world_end_where_they_end_on_the_planning_map() {
    let maps = convert(&demo_model(), &["--world"]);
    let (shapes, cell) = (static_shapes(&maps), maps.manifest["resolution_m"].as_f64().unwrap());
    let slab: Vec<f64> = maps.manifest["slab_m"].as_array().unwrap().iter().map(|z| z.as_f64().unwrap()).collect();
    let waypoints = maps.json("waypoints.json");
    let (closed, ramps) = (closed_doors(&maps), ramps(&maps));
    let (mut n_rays, mut n_agree) = (0, 0);
    for (index, record) in maps.manifest["storeys"].as_array().unwrap().iter().enumerate() {
        let floor = record["floor_z_m"].as_f64().unwrap();
        let plans: Vec<Vec<[f64; 2]>> =
            shapes.iter().map(|s| plan(&s.corners, floor + slab[0] + 1e-4, floor + slab[1] - 1e-4)).collect();
        let plans: Vec<&Vec<[f64; 2]>> = plans.iter().filter(|p| p.len() >= 3).collect();
        let storey = maps.storey(index);
        let low = [0, 1].map(|k| record["origin_m"][k].as_f64().unwrap());
        let high = [0, 1].map(|k| low[k] + cell * record["size_cells"][k].as_f64().unwrap());
        let stands = |p: [f64; 2], reach: f64| plans.iter().any(|plan| distance(plan, p) <= reach);
        for waypoint in waypoints["waypoints"].as_array().unwrap().iter().filter(|w| w["storey"] == index) {
            let start = ["x_m", "y_m"].map(|k| waypoint[k].as_f64().unwrap());
            for k in 0..24 {
                let angle = std::f64::consts::TAU * (f64::from(k) + 0.5) / 24.0;
                let at = |t: f64| [start[0] + t * libm::cos(angle), start[1] + t * libm::sin(angle)];
                // Where the map ends nothing is compared.
                let is_on_map = |p: [f64; 2]| (0..2).all(|i| low[i] + 2.0 * cell < p[i] && p[i] < high[i] - 2.0 * cell);
                let steps = || (0..320).map(|i| f64::from(i) * cell / 4.0).take_while(|t| is_on_map(at(*t)));
                let ends = |wall: &dyn Fn([f64; 2]) -> bool| steps().find(|t| wall(at(*t)));
                let occupied = |p: [f64; 2]| storey.planning(p[0], p[1]) == OCCUPIED;
                let near = |p: [f64; 2]| {
                    let off = [-1.0, 0.0, 1.0].map(|d| d * cell);
                    off.iter().any(|dx| off.iter().any(|dy| occupied([p[0] + dx, p[1] + dy])))
                };
                let map_end = ends(&occupied);
                // A door that this robot cannot pass stops it on the map; in the world its leaf may be anywhere.
                if map_end.is_some_and(|t| closed.iter().any(|door| is_within(door, at(t), cell))) {
                    continue;
                }
                let world_end = ends(&|p| stands(p, 0.0));
                // On a ramp the map ends at what stands on it, and a ray at the height of the floor in the ramp.
                if world_end.is_some_and(|t| ramps.iter().any(|ramp| is_within(ramp, at(t), cell))) {
                    continue;
                }
                let agrees = match (map_end, world_end) {
                    // Nothing in four metres.
                    (None, None) => true,
                    (m, w) => m.is_none_or(|t| stands(at(t), 1.5 * cell)) && w.is_none_or(|t| near(at(t))),
                };
                n_rays += 1;
                n_agree += i32::from(agrees);
            }
        }
    }
    assert!(n_rays > 1000 && f64::from(n_agree) >= 0.995 * f64::from(n_rays), "{n_agree} of {n_rays}");
}

#[test]
fn every_standing_element_is_a_link_and_every_hung_door_a_model() {
    let maps = convert(&demo_model(), &["--world"]);
    let lookup = maps.json("world/lookup.json");
    let links: BTreeSet<String> = static_shapes(&maps).into_iter().map(|s| s.link).collect();
    let elements = lookup["elements"].as_object().unwrap();
    for (id, element) in elements {
        match element["link"].as_str() {
            Some(link) => {
                assert!(links.contains(link) && link.ends_with(id.as_str()), "{link}");
                assert_eq!(lookup["models"][element["model"].as_str().unwrap()]["class"], element["class"]);
            }
            None => assert_eq!(lookup["doors"][id]["model"], element["model"]),
        }
    }
    let semantic = maps.json("semantic.json");
    let missing: Vec<&String> = semantic["elements"]
        .as_object()
        .unwrap()
        .iter()
        .filter(|(id, e)| !e["aabb_m"].is_null() && !elements.contains_key(*id))
        .map(|(id, _)| id)
        .collect();
    assert!(missing.is_empty(), "{missing:?}");
    assert_eq!(lookup["counts"]["exact"], lookup["counts"]["collisions"], "the demo is made of exact pieces");
    let spawn = &lookup["spawn"];
    let first =
        maps.json("waypoints.json")["waypoints"].as_array().unwrap().iter().find(|w| w["order"] == 0).unwrap().clone();
    assert_eq!([&spawn["x_m"], &spawn["y_m"], &spawn["z_m"]], [&first["x_m"], &first["y_m"], &first["z_m"]]);
}

#[test]
fn doors_move_as_their_operation_types_say() {
    let lookup = convert(&demo_model(), &["--world"]).json("world/lookup.json");
    let mut seen = BTreeSet::new();
    for (id, door) in lookup["doors"].as_object().unwrap() {
        let operation = door["operation"].as_str().unwrap();
        let leaves = door["leaves"].as_array().unwrap();
        let expected = match operation {
            _ if operation.contains("SWING") || operation.starts_with("FOLDING") => "revolute",
            _ => "prismatic",
        };
        assert!(leaves.iter().all(|l| l["kind"] == expected), "{id} {door}");
        assert!(leaves.iter().all(|l| l["ended_by"] == serde_json::json!([null, null])), "{id} {door}");
        assert_eq!(door["operation_from"], "model", "{id}");
        seen.insert(operation.to_owned());
    }
    assert!(seen.len() >= 7, "{seen:?}");
}

#[test]
fn doors_can_be_fixed_or_left_out() {
    let with = |how: &str| convert(&demo_model(), &["--world", "--doors", how]);
    for how in ["open", "closed"] {
        let maps = with(how);
        let text = std::fs::read_to_string(maps.path().join("world/world.sdf")).unwrap();
        assert!(text.contains("<model name=\"door_") && !text.contains("<joint"), "{how}");
    }
    let maps = with("passable");
    let lookup = maps.json("world/lookup.json");
    assert!(lookup["doors"].as_object().unwrap().is_empty());
    assert!(!lookup["doors_left_out"].as_object().unwrap().is_empty());
}

#[test]
fn the_world_at_a_date_holds_what_stands_and_barriers_close_what_is_blocked() {
    let date = "2024-04-27T12:00:00";
    let maps = convert(&demo_model(), &["--world", "--date", date, "--barriers"]);
    let lookup = maps.json("world/lookup.json");
    let whole = convert(&demo_model(), &["--world"]).json("world/lookup.json");
    let count = |lookup: &Value| lookup["elements"].as_object().unwrap().len();
    assert!(0 < count(&lookup) && count(&lookup) < count(&whole));
    let barriers = lookup["stand_ins"].as_array().unwrap();
    assert!(barriers.iter().any(|b| b["link"].as_str().unwrap().starts_with("barrier_")), "{barriers:?}");
    assert!(whole["stand_ins"].as_array().unwrap().is_empty());
}

#[test]
fn the_same_input_gives_the_same_world_on_any_number_of_threads() {
    let world = |threads: &str| -> BTreeMap<_, _> {
        let files = convert(&demo_model(), &["--world", "--usd", "--open-rmf", "--threads", threads]).contents();
        files.into_iter().filter(|(path, _)| path.starts_with("world") || path.starts_with("open-rmf")).collect()
    };
    assert!(world("1") == world("2"));
}

/// What follows this in lines of a text, up to the end of the line.
fn after<'a>(text: &'a str, start: &str) -> Vec<&'a str> {
    text.lines().filter_map(|line| line.trim_start().strip_prefix(start)).collect()
}

#[test]
fn usd_is_written_where_it_is_asked_for_with_every_element_and_joint() {
    let maps = convert(&demo_model(), &["--world", "--usd"]);
    let text = std::fs::read_to_string(maps.path().join("world/site.usda")).unwrap();
    let lookup = maps.json("world/lookup.json");
    let ids: BTreeSet<&str> =
        after(&text, "custom string ifc:globalId = ").iter().map(|id| id.trim_matches('"')).collect();
    let keys = |of: &str| lookup[of].as_object().unwrap().keys().map(String::as_str).collect::<BTreeSet<_>>();
    assert_eq!(ids, &keys("elements") | &keys("doors"));
    let leaves = lookup["doors"].as_object().unwrap().values().flat_map(|door| door["leaves"].as_array().unwrap());
    let mut wanted: BTreeMap<&str, Vec<i64>> = BTreeMap::new();
    for leaf in leaves {
        let (kind, limits, scale) = match leaf["kind"].as_str().unwrap() {
            "revolute" => ("def PhysicsRevoluteJoint", &leaf["limits_rad"][1], 180.0 / std::f64::consts::PI),
            "prismatic" => ("def PhysicsPrismaticJoint", &leaf["limits_m"][1], 1.0),
            kind => panic!("no door of the demo has a leaf that is {kind}"),
        };
        wanted.entry(kind).or_default().push((limits.as_f64().unwrap() * scale * 100.0).round() as i64);
    }
    for (kind, mut wanted) in wanted {
        let joints = text.split(kind).skip(1).map(|joint| after(joint, "float physics:upperLimit = ")[0]);
        let mut found: Vec<i64> = joints.map(|limit| (limit.parse::<f64>().unwrap() * 100.0).round() as i64).collect();
        found.sort_unstable();
        wanted.sort_unstable();
        assert_eq!(found, wanted, "{kind} turns in degrees and slides in metres");
    }
    let fixed = convert(&demo_model(), &["--world", "--usd", "--doors", "open"]);
    let text = std::fs::read_to_string(fixed.path().join("world/site.usda")).unwrap();
    assert!(text.contains("PhysicsCollisionAPI") && !text.contains("Joint") && !text.contains("RigidBody"));
    assert!(!convert(&demo_model(), &["--world"]).path().join("world/site.usda").exists());
}

#[test]
fn the_glb_is_whole() {
    let maps = convert(&demo_model(), &["--world"]);
    let bytes = std::fs::read(maps.path().join("world/site.glb")).unwrap();
    let word = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()) as usize;
    assert_eq!((&bytes[..4], word(4), word(8)), (b"glTF".as_slice(), 2, bytes.len()));
    let document: Value = serde_json::from_slice(&bytes[20..20 + word(12)]).unwrap();
    let names: BTreeSet<&str> =
        document["nodes"].as_array().unwrap().iter().filter_map(|n| n["name"].as_str()).collect();
    let lookup = maps.json("world/lookup.json");
    assert!(lookup["elements"].as_object().unwrap().keys().all(|id| names.contains(id.as_str())));
    assert_eq!(document["buffers"][0]["byteLength"].as_u64().unwrap() as usize, word(20 + word(12)));
}

#[test]
fn a_world_of_chosen_storeys_is_the_whole_building_and_begins_on_one_of_them() {
    let arguments = ["--world", "--markers"];
    let all = convert(&demo_model(), &arguments);
    let upper = convert(&demo_model(), &[&["--storeys", "Upper*"], arguments.as_slice()].concat());
    let listed =
        |maps: &Maps| maps.manifest["files"].as_object().unwrap().keys().cloned().collect::<BTreeSet<String>>();
    let written: BTreeSet<String> =
        upper.contents().into_keys().map(|p| p.to_str().unwrap().to_owned()).filter(|p| p != "manifest.json").collect();
    assert_eq!(listed(&upper), written, "what is listed is what is written");
    let of_world =
        |names: &BTreeSet<String>| names.iter().filter(|n| n.starts_with("world/")).cloned().collect::<Vec<_>>();
    assert_eq!(of_world(&listed(&upper)), of_world(&listed(&all)));
    let sdf = |maps: &Maps| std::fs::read_to_string(maps.path().join("world/world.sdf")).unwrap();
    for uri in sdf(&upper).lines().filter_map(|l| l.split_once("<uri>")?.1.split_once("</uri>")).map(|l| l.0) {
        assert!(written.contains(&format!("world/{uri}")), "{uri}");
    }
    // What a robot sees through the atrium and up the stairs is there: bodies are those of the whole building.
    let bodies = |maps: &Maps| static_shapes(maps).into_iter().map(|s| (s.link, s.corners)).collect::<Vec<_>>();
    assert!(bodies(&upper) == bodies(&all));
    let lookup = [&all, &upper].map(|maps| maps.json("world/lookup.json"));
    assert_eq!(lookup[0]["doors"], lookup[1]["doors"]);
    let waypoints = upper.json("waypoints.json");
    let waypoints = waypoints["waypoints"].as_array().unwrap();
    let spawn = &lookup[1]["spawn"];
    assert_eq!((&spawn["storey"], lookup[0]["spawn"]["storey"].as_u64()), (&1.into(), Some(0)));
    let first = waypoints.iter().min_by_key(|w| w["order"].as_u64().unwrap()).unwrap();
    assert_eq!((&spawn["waypoint"], &spawn["x_m"]), (&first["id"], &first["x_m"]));
    assert_eq!(sdf(&upper).matches("<visual name=\"w").count(), waypoints.len());
}

/// The plans of plates whose top is the floor at 0.
fn plates(maps: &Maps) -> Vec<Vec<[f64; 2]>> {
    let shapes = static_shapes(maps).into_iter().filter(|shape| shape.link.starts_with("assumed_floor_"));
    let plates = shapes.map(|shape| {
        let top = shape.corners.iter().map(|c| c[2]).fold(f64::NEG_INFINITY, f64::max);
        assert!(top.abs() < 1e-6, "{top}");
        hull(shape.corners.iter().map(|c| [c[0], c[1]]).collect())
    });
    plates.collect()
}

#[test]
fn a_plate_lies_where_the_map_assumes_that_walls_enclose_floor_and_nowhere_else() {
    let mut house = House::new("IFC4");
    house.add_walls([0.0, 0.0, 6.0, 4.0], [0.0, 3.0]);
    house.add_walls([10.0, 2.0, 16.0, 8.0], [0.0, 3.0]);
    let home = tempfile::tempdir().unwrap();
    let model = house.write(home.path());
    let maps = convert(&model, &["--world"]);
    let (plates, storey) = (plates(&maps), maps.storey(0));
    let is_there = |p: [f64; 2]| plates.iter().any(|plate| distance(plate, p) == 0.0);
    let cell = maps.manifest["resolution_m"].as_f64().unwrap();
    let record = &maps.manifest["storeys"][0];
    let value = |key: &str, k: usize| record[key][k].as_f64().unwrap();
    let (mut n_free, mut n_unknown) = (0, 0);
    for row in 0..value("size_cells", 1) as usize {
        for column in 0..value("size_cells", 0) as usize {
            let p = [column, row];
            let p = [0, 1].map(|k| value("origin_m", k) + cell * (p[k] as f64 + 0.5));
            match storey.planning(p[0], p[1]) {
                FREE => {
                    assert!(is_there(p), "no plate at {p:?}");
                    n_free += 1;
                }
                UNKNOWN => {
                    assert!(!is_there(p), "a plate at {p:?}");
                    n_unknown += 1;
                }
                _ => {}
            }
        }
    }
    assert!(n_free > 1_000 && n_unknown > 1_000, "{n_free} {n_unknown}");
}

#[test]
fn a_plate_goes_on_through_the_opening_between_two_rooms_without_a_slab() {
    let mut house = House::new("IFC4");
    house.add_walls([0.0, 0.0, 12.2, 4.0], [0.0, 3.0]);
    let wall = house.add("IFCWALL", "Between", PLAIN, [[6.0, 0.0, 0.0], [6.2, 4.0, 3.0]]);
    house.add_opening(wall, [[5.9, 1.5, 0.0], [6.3, 2.5, 2.1]]);
    house.add_room("A", [[0.0, 0.0, 0.0], [6.0, 4.0, 3.0]]);
    house.add_room("B", [[6.2, 0.0, 0.0], [12.2, 4.0, 3.0]]);
    let home = tempfile::tempdir().unwrap();
    let maps = convert(&house.write(home.path()), &["--world"]);
    let plates = plates(&maps);
    for k in 0..100 {
        let p = [5.5 + 0.01 * f64::from(k), 2.0];
        assert_eq!(maps.storey(0).planning(p[0], p[1]), FREE, "{p:?}");
        assert!(plates.iter().any(|plate| distance(plate, p) == 0.0), "{p:?}");
    }
}

/// Height at which a ray ends that falls from a height on a place.
fn fallen(shapes: &[Shape], [x, y, from_z]: [f64; 3]) -> f64 {
    let fans = shapes.iter().flat_map(|s| {
        let fan =
            |f: &Vec<usize>| (1..f.len() - 1).map(|k| [f[0], f[k], f[k + 1]].map(|c| s.corners[c])).collect::<Vec<_>>();
        s.faces.iter().flat_map(fan)
    });
    let area = |p: [f64; 3], q: [f64; 3], r: [f64; 3]| (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]);
    let met = |[a, b, c]: [[f64; 3]; 3]| {
        let (whole, p) = (area(a, b, c), [x, y, 0.0]);
        let shares = [area(p, b, c), area(a, p, c), area(a, b, p)].map(|part| part / whole);
        let z = shares[0] * a[2] + shares[1] * b[2] + shares[2] * c[2];
        (whole.abs() > 1e-9 && shares.iter().all(|s| *s >= -1e-9) && z <= from_z).then_some(z)
    };
    fans.filter_map(met).fold(f64::NEG_INFINITY, f64::max)
}

/// Links of ground outdoors, by the entities of what they are.
fn ground_links(lookup: &Value) -> BTreeMap<String, String> {
    let elements = lookup["elements"].as_object().unwrap().values();
    let ground = elements.filter(|e| e["pieces"]["mesh"] == 1);
    ground.map(|e| (e["link"].as_str().unwrap().to_owned(), e["type"].as_str().unwrap().to_owned())).collect()
}

/// Bodies of the file for MuJoCo.
fn bodies_for_mujoco(maps: &Maps) -> BTreeSet<String> {
    let text = std::fs::read_to_string(maps.path().join("world/ground.xml")).unwrap();
    text.lines().filter(|l| l.trim().starts_with("<body ")).map(|l| attribute(l, "name").to_owned()).collect()
}

#[test]
fn the_ground_outdoors_is_in_the_world_as_it_is_at_the_date_and_no_part_of_it_twice() {
    let home = tempfile::tempdir().unwrap();
    for (form, entity) in [("tin-site", "IfcSite"), ("tin-geographic", "IfcGeographicElement")] {
        let (model, _) = terrain_site(home.path(), &["--form", form]);
        // In the pit, where its earth is taken away first, and where later; on its ramp; on the road of 8 %; beside the house.
        let places = [[48.5, 38.0], [48.5, 25.0], [52.0, 34.0], [16.0, 5.0], [44.0, 40.0]];
        let road = 100.0 + 0.08 * 10.0 + 0.04;
        for (date, expected) in [
            ("2024-03-01", [100.0, 100.0, 100.0, road, 100.0]),
            ("2024-03-06", [98.0, 100.0, 98.0, road, 100.0]),
            ("2024-04-10", [98.0, 98.0, 99.0, road, 100.0]),
            ("2024-05-15", [100.0, 100.0, 100.0, road, 100.0]),
        ] {
            let date = format!("{date}T12:00:00");
            let maps = convert(&model, &["--world", "--resolution", "0.25", "--date", &date]);
            let shapes = static_shapes(&maps);
            let found = places.map(|[x, y]| fallen(&shapes, [x, y, 103.0]));
            let is_near = found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-3);
            assert!(is_near, "{form} {date}: {found:?}, {expected:?}");
            let lookup = maps.json("world/lookup.json");
            let ground = ground_links(&lookup);
            assert!(ground.values().eq([entity]), "{form} {date}: {ground:?}");
            assert!(bodies_for_mujoco(&maps).iter().eq(ground.keys()), "{form} {date}");
            let links: Vec<&String> = shapes.iter().map(|s| &s.link).filter(|l| ground.contains_key(*l)).collect();
            assert_eq!(links.len(), 1, "{form} {date}: one mesh that collides");
        }
    }
}

#[test]
fn of_large_terrain_the_world_has_what_the_map_of_the_ground_outdoors_has() {
    let home = tempfile::tempdir().unwrap();
    let (model, _) = terrain_site(home.path(), &["--size", "400", "300", "--cell", "5"]);
    let maps = convert(&model, &["--world", "--resolution", "0.25"]);
    let ground = ground_links(&maps.json("world/lookup.json"));
    let shapes: Vec<Shape> = static_shapes(&maps).into_iter().filter(|s| ground.contains_key(&s.link)).collect();
    let end =
        |k: usize, pick: fn(f64, f64) -> f64, start: f64| shapes[0].corners.iter().map(|c| c[k]).fold(start, pick);
    let storeys = maps.manifest["storeys"].as_array().unwrap();
    let map = storeys.iter().find(|s| s["floor"] == "ground").unwrap();
    for k in 0..2 {
        // The map has a margin of 1 m, and a triangle at its end is whole.
        let low = map["origin_m"][k].as_f64().unwrap() + 1.0;
        let high = low - 2.0 + 0.25 * map["size_cells"][k].as_f64().unwrap();
        let (least, most) = (end(k, f64::min, f64::INFINITY), end(k, f64::max, f64::NEG_INFINITY));
        assert!((low - 5.0..=low + 0.25).contains(&least), "{k}: {least} {low}");
        assert!((high - 0.25..=high + 5.25).contains(&most), "{k}: {most} {high}");
    }
}

#[test]
fn without_ground_outdoors_there_is_no_file_of_it_and_no_mesh_that_is_not_convex() {
    let mut house = House::new("IFC4");
    house.add_walls([0.0, 0.0, 6.0, 4.0], [0.0, 3.0]);
    house.add("IFCSLAB", "Floor", PLAIN, [[0.0, 0.0, -0.2], [6.0, 4.0, 0.0]]);
    let home = tempfile::tempdir().unwrap();
    let maps = convert(&house.write(home.path()), &["--world"]);
    assert!(!maps.path().join("world/ground.xml").exists());
    assert!(ground_links(&maps.json("world/lookup.json")).is_empty());
}
