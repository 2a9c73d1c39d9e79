//! Open-RMF's own reader loads what is written for it, and finds in both formats what the route graph has at the date.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

use end_to_end::house::{House, PLAIN};
use end_to_end::{Maps, convert, corpus, demo_model, files_in};
use rmf_site_format::legacy::building_map::BuildingMap;
use rmf_site_format::legacy::nav_graph::NavGraph;
use rmf_site_format::{Category, DoorType, LiftCabin, Site};
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// Two points of a line, or one twice, in tenths of a millimetre, the smaller first.
type Line = [[i64; 2]; 2];

fn line(mut ends: [[f64; 2]; 2]) -> Line {
    ends.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    ends.map(|end| end.map(|c| (c * 1e4).round() as i64))
}

/// How often each lane is there.
type Lanes = BTreeMap<Line, usize>;

/// What a level has.
#[derive(Debug, Default, PartialEq)]
struct LevelFacts {
    /// Its elevation.
    tenths: i64,
    lanes: Lanes,
    walls: Vec<Line>,
    /// Type and ends by name.
    doors: BTreeMap<String, (&'static str, Line)>,
}

/// What a lift has.
#[derive(Debug, Clone, PartialEq)]
struct LiftFacts {
    /// Ends of the inner front of its cabin.
    front: Line,
    /// Width and depth.
    sides: [i64; 2],
    /// Levels of each door.
    visits: Vec<BTreeSet<String>>,
}

/// What a site says, however it was loaded.
#[derive(Debug, Default, PartialEq)]
struct Facts {
    levels: BTreeMap<String, LevelFacts>,
    /// Named places, but for those in cabins.
    places: BTreeMap<String, [i64; 2]>,
    lifts: BTreeMap<String, LiftFacts>,
    /// Names of places in cabins, and lanes that lead there.
    cabins: (BTreeSet<String>, usize),
}

impl Facts {
    fn of(site: &Site) -> Self {
        let at = |anchor: u32| {
            let (anchor, level) = site.get_anchor_and_level(anchor)?;
            Some((anchor.translation_for_category(Category::General).map(f64::from), level))
        };
        let is_cabin = |anchor: &u32| site.lifts.values().any(|lift| lift.cabin_anchors.contains_key(anchor));
        let mut facts = Self::default();
        let tenths = |metres: f32| (f64::from(metres) * 1e4).round() as i64;
        for level in site.levels.values() {
            let door = |door: &rmf_site_format::Door<u32>| {
                let ends = door.anchors.array().map(|end| at(end).unwrap().0);
                let kind = match door.kind {
                    DoorType::SingleSwing(_) => "hinged",
                    DoorType::DoubleSwing(_) => "double_hinged",
                    DoorType::SingleSliding(_) => "sliding",
                    DoorType::DoubleSliding(_) => "double_sliding",
                    DoorType::Model(_) => "model",
                };
                (door.name.0.clone(), (kind, line(ends)))
            };
            let doors: BTreeMap<_, _> = level.doors.values().map(door).collect();
            assert_eq!(doors.len(), level.doors.len(), "names of doors are unique");
            let walls = level.walls.values().map(|wall| line(wall.anchors.array().map(|end| at(end).unwrap().0)));
            let walls = walls.collect();
            let properties = &level.properties;
            let of = LevelFacts { tenths: tenths(properties.elevation.0), lanes: BTreeMap::new(), walls, doors };
            assert!(facts.levels.insert(properties.name.0.clone(), of).is_none(), "names of levels are unique");
        }
        for lane in site.navigation.guided.lanes.values() {
            let ends = lane.anchors.array();
            if ends.iter().any(is_cabin) {
                facts.cabins.1 += 1;
                continue;
            }
            let [(a, level), (b, other)] = ends.map(|end| at(end).expect("both ends of a lane exist"));
            let name = |level: Option<&rmf_site_format::Level>| level.unwrap().properties.name.0.clone();
            assert_eq!(name(level), name(other), "a lane is on one level");
            *facts.levels.get_mut(&name(level)).unwrap().lanes.entry(line([a, b])).or_default() += 1;
        }
        for location in site.navigation.guided.locations.values() {
            let name = location.name.0.clone();
            let is_new = if is_cabin(&location.anchor.0) {
                facts.cabins.0.insert(name)
            } else {
                let place = line([at(location.anchor.0).unwrap().0; 2])[0];
                facts.places.insert(name, place).is_none()
            };
            assert!(is_new, "names of places are unique");
        }
        for lift in site.lifts.values() {
            let LiftCabin::Rect(cabin) = &lift.properties.cabin;
            let visits = lift
                .cabin_doors
                .values()
                .map(|door| door.visits.0.iter().map(|level| site.levels[level].properties.name.0.clone()).collect());
            let front = line(lift.properties.reference_anchors.array().map(|end| at(end).unwrap().0));
            let sides = [cabin.width, cabin.depth].map(tenths);
            facts.lifts.insert(lift.properties.name.0.clone(), LiftFacts { front, sides, visits: visits.collect() });
        }
        facts
    }

    fn lanes(&self) -> usize {
        self.levels.values().flat_map(|level| level.lanes.values()).sum()
    }

    fn doors(&self) -> usize {
        self.levels.values().map(|level| level.doors.len()).sum()
    }
}

/// Lanes by level and centres of rooms as the route graph has them.
fn expected(maps: &Maps) -> (BTreeMap<i64, Lanes>, BTreeSet<[i64; 2]>) {
    let graph = maps.json("site-graph.json");
    let nodes = graph["nodes"].as_array().unwrap();
    let point = |node: &Value| [&node["x_m"], &node["y_m"]].map(|c| c.as_f64().unwrap());
    let mut lanes: BTreeMap<i64, Lanes> = BTreeMap::new();
    for edge in graph["edges"].as_array().unwrap().iter().filter(|edge| edge["usable"] == true) {
        let [from, to] = ["from", "to"].map(|end| &nodes[edge[end].as_u64().unwrap() as usize]);
        if from["storey"] != to["storey"] {
            continue;
        }
        let inner = edge["line_m"].as_array().unwrap().iter().map(|p| [0, 1].map(|k| p[k].as_f64().unwrap()));
        let mut points: Vec<[f64; 2]> = inner.collect();
        let last = points.len() - 1;
        (points[0], points[last]) = (point(from), point(to));
        points.dedup();
        let of = lanes.entry(from["storey"].as_i64().unwrap()).or_default();
        points.windows(2).for_each(|pair| *of.entry(line([pair[0], pair[1]])).or_default() += 1);
    }
    let rooms = nodes.iter().filter(|node| node["kind"] == "space").map(|node| line([point(node); 2])[0]);
    (lanes, rooms.collect())
}

/// The one file of the folder for Open-RMF that ends so.
fn file(maps: &Maps, end: &str) -> Vec<u8> {
    let all = files_in(&maps.path().join("open-rmf"));
    let path = all.iter().find(|path| path.to_string_lossy().ends_with(end)).unwrap();
    std::fs::read(path).unwrap()
}

/// Loads both formats, and compares them with each other and with the route graph.
fn checked(maps: &Maps) -> (Facts, Site) {
    let building = BuildingMap::from_bytes(&file(maps, ".building.yaml")).unwrap();
    let site = Site::from_bytes_json(&file(maps, ".site.json")).unwrap();
    let facts = Facts::of(&site);
    assert_eq!(Facts::of(&building.to_site().unwrap()), facts, "the building map and the site are one building");
    let (lanes, rooms) = expected(maps);
    let storeys = maps.manifest["storeys"].as_array().unwrap();
    assert_eq!(facts.levels.len(), storeys.len());
    for storey in storeys {
        let (index, floor_m) = (storey["index"].as_i64().unwrap(), storey["floor_z_m"].as_f64().unwrap());
        let name = storey["name"].as_str().unwrap_or_default();
        let numbered = format!("{name} ({index})");
        let level = facts.levels.get(name).unwrap_or_else(|| &facts.levels[numbered.trim()]);
        assert_eq!(
            (level.tenths, &level.lanes),
            ((floor_m * 1e4).round() as i64, lanes.get(&index).unwrap_or(&Lanes::new()))
        );
    }
    assert_eq!(facts.places.values().copied().collect::<BTreeSet<_>>(), rooms);
    (facts, site)
}

fn on(date: &str) -> Maps {
    convert(&demo_model(), &["--open-rmf", "--date", date])
}

#[test]
fn doors_and_lanes_of_the_demo_come_with_the_dates() {
    let found: Vec<Facts> =
        ["2024-04-06", "2024-04-27", "2024-06-03"].map(|date| checked(&on(&format!("{date}T00:00:00"))).0).into();
    let counts: Vec<[usize; 3]> =
        found.iter().map(|facts| [facts.doors(), facts.lanes(), facts.places.len()]).collect();
    let (doors, lanes, rooms) =
        ([0, 1, 2].map(|k| counts[k][0]), [0, 1, 2].map(|k| counts[k][1]), counts[2][2] - counts[0][2]);
    assert_eq!(doors, [0, 0, 25], "no door hangs in April");
    assert!(lanes[0] < lanes[1] && lanes[1] < lanes[2], "{lanes:?}");
    assert_eq!(rooms, 8, "that are closed until they are finished");
    // From the south-east corner to the main entrance, in the middle of a wall of 0.3 m.
    let south = line([[18.55, 0.15], [24.0, 0.15]]);
    assert!(
        found.iter().all(|facts| facts.levels["Ground floor"].walls.contains(&south)),
        "{:?}",
        found[2].levels["Ground floor"].walls
    );
    let ground = &found[2].levels["Ground floor"].doors;
    assert_eq!(ground["G.D06 kitchen"].0, "sliding");
    assert_eq!(ground["G.D12 foyer"].0, "double_hinged");
    assert_eq!(ground["G.D01 main entrance"], ("double_hinged", line([[16.95, 0.15], [18.55, 0.15]])));
}

#[test]
fn lanes_ask_for_the_door_that_they_pass() {
    let maps = convert(&demo_model(), &["--open-rmf"]);
    let (facts, site) = checked(&maps);
    let passed: BTreeSet<String> = NavGraph::from_site(&site)[0]
        .1
        .levels
        .values()
        .flat_map(|level| &level.lanes)
        .filter_map(|lane| lane.2.door_name.clone())
        .collect();
    let graph = maps.json("site-graph.json");
    let node = |edge: &Value, end: &str| &graph["nodes"][edge[end].as_u64().unwrap() as usize];
    let name = |of: &Value| {
        graph["nodes"].as_array().unwrap().iter().find(|n| n["of"] == *of).unwrap()["name"].as_str().unwrap().to_owned()
    };
    let ways = graph["edges"].as_array().unwrap().iter().filter(|e| e["class"] == "door" && e["usable"] == true);
    let mut doors: BTreeMap<(String, &str), usize> = BTreeMap::new();
    for edge in ways {
        let storey = node(edge, "from")["storey"].as_u64().unwrap() as usize;
        let level = maps.manifest["storeys"][storey]["name"].as_str().unwrap();
        *doors.entry((name(&edge["of"]), level)).or_default() += 1;
    }
    // Open-RMF looks for doors on their own level, and a way that ends in one need not cross it.
    let crossed = doors.iter().filter(|((door, level), n)| facts.levels[*level].doors.contains_key(door) && **n > 1);
    let crossed: BTreeSet<String> = crossed.map(|((door, _), _)| door.clone()).collect();
    assert!(
        crossed.len() > 15 && crossed.is_subset(&passed),
        "Open-RMF finds by itself which doors lanes pass: {passed:?}"
    );
    let own = std::fs::read_to_string(maps.path().join("open-rmf/nav_graphs/0.yaml")).unwrap();
    for ((door, _), _) in doors {
        assert!(own.contains(&format!("{{\"door_name\": {}}}", Value::from(door.as_str()))), "{door}");
    }
}

#[test]
fn levels_are_the_storeys_that_are_written() {
    let (facts, _) = checked(&convert(&demo_model(), &["--open-rmf", "--storeys", "1"]));
    assert_eq!(facts.levels.keys().collect::<Vec<_>>(), ["Upper floor"]);
    assert!(facts.lanes() > 0 && facts.doors() > 0);
}

/// A lift between two storeys, with a landing door before its front on both.
fn house_with_a_lift() -> House {
    let mut house = House::new("IFC4");
    for (storey, z) in [("A", 0.0), ("B", 3.0)] {
        if z > 0.0 {
            house.add_storey("First", z);
        }
        house.add_walls([0.0, 0.0, 9.0, 6.0], [z, z + 2.8]);
        // Around the shaft, which is in the corner.
        for [x0, y0, x1, y1] in [[0.0, 0.0, 6.8, 6.0], [6.8, 0.0, 9.0, 1.9], [6.8, 4.1, 9.0, 6.0]] {
            house.add("IFCSLAB", "Slab", PLAIN, [[x0, y0, z - 0.2], [x1, y1, z]]);
        }
        house.add("IFCWALL", "Shaft", PLAIN, [[6.8, 1.9, z], [9.0, 2.0, z + 2.8]]);
        house.add("IFCWALL", "Shaft", PLAIN, [[6.8, 4.0, z], [9.0, 4.1, z + 2.8]]);
        let wall = house.add("IFCWALL", "Shaft", PLAIN, [[6.6, 1.9, z], [6.8, 4.1, z + 2.8]]);
        let opening = house.add_opening(wall, [[6.6, 2.5, z], [6.8, 3.5, z + 2.1]]);
        let door = "$,2.1,1.0,.DOOR.,.DOUBLE_DOOR_SLIDING.,$";
        let door = house.add("IFCDOOR", &format!("Landing {storey}"), door, [[6.68, 2.5, z], [6.72, 3.5, z + 2.1]]);
        house.fill(opening, door);
        // What YAML would read as a comment, a map or the end of a text.
        house.add_room(&format!("Hall: \"{storey}\" # {{1}}, -"), [[0.0, 0.0, z], [6.6, 6.0, z + 2.8]]);
    }
    house.add("IFCTRANSPORTELEMENT", "Lift", "$,.ELEVATOR.", [[7.0, 2.2, 0.0], [8.6, 3.8, 5.5]]);
    house
}

#[test]
fn a_lift_joins_its_levels_where_the_robot_takes_it() {
    let home = tempfile::tempdir().unwrap();
    let model = house_with_a_lift().write(home.path());
    let options = home.path().join("lifts.toml");
    std::fs::write(&options, "[tour]\nlifts = [\"Lift\"]\n").unwrap();
    let taken = ["--open-rmf", "--waypoints", options.to_str().unwrap()];
    let both: BTreeSet<String> = ["Ground", "First"].map(str::to_owned).into();
    // Its first door is to the west: the inner front of the cabin runs along x = 7.
    let lift = LiftFacts { front: line([[7.0, 2.2], [7.0, 3.8]]), sides: [16_000, 16_000], visits: vec![both] };
    for (more, cabins, lanes) in [(&taken[..], 2, 2), (&taken[..1], 0, 0)] {
        let (facts, site) = checked(&convert(&model, more));
        assert_eq!(facts.lifts, BTreeMap::from([("Lift".to_owned(), lift.clone())]));
        assert_eq!((facts.cabins.0.len(), facts.cabins.1), (cabins, lanes), "{more:?}");
        assert_eq!(facts.doors(), 0, "landing doors are the lift's");
        let lift = site.lifts.values().next().unwrap();
        let LiftCabin::Rect(cabin) = &lift.properties.cabin;
        assert_eq!(cabin.front_door.map(|door| (door.width, door.shifted)), Some((1.0, Some(0.0))));
    }
}

#[test]
fn buildings_of_the_corpus_are_loaded() {
    let Some(folder) = corpus("buildings") else { return };
    let load = |path: &Path| checked(&convert(path, &["--open-rmf", "--resolution", "0.1", "--allow-empty"])).0;
    let small = [
        "building-architecture.ifc",
        "SWW-5_SB.ifc",
        "demo2.ifc",
        "XELLA-Begane_grond.ifc",
        "TallBuilding.ifc",
        "IfcOpenHouse.ifc",
        "creative-freedom.ifc",
        "crane_hall_v10.ifc",
        "Ifc2x3_Duplex_Architecture.ifc",
        "AC20-FZK-Haus.ifc",
    ];
    let lanes: Vec<usize> = small.iter().map(|name| load(&folder.join(name)).lanes()).collect();
    assert!(lanes.iter().filter(|n| **n > 0).count() >= 5, "{lanes:?}");
}
