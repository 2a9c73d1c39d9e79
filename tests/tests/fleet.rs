//! The demo building for fleets: ids that stay and change with the date, doors that others open, formats that are asked for.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

use end_to_end::{Maps, convert, demo_model, groundplan};
use serde_json::Value;
use std::collections::BTreeSet;

fn at(date: &str, more: &[&str]) -> Maps {
    convert(&demo_model(), &[&["--date", date, "--resolution", "0.1", "--fleet", "vda5050,lif"], more].concat())
}

fn of_ground_floor(maps: &Maps) -> Value {
    maps.json("fleet/vda5050/maps.json")["maps"][0].clone()
}

fn zones_of_ground_floor(maps: &Maps) -> Vec<Value> {
    maps.json("fleet/vda5050/00-ground-floor.zoneSet.json")["zoneSet"]["zones"].as_array().unwrap().clone()
}

/// Ids of nodes at spaces.
fn rooms(maps: &Maps) -> BTreeSet<String> {
    let layouts = maps.json("fleet/lif/site.lif.json")["layouts"].as_array().unwrap().clone();
    let nodes = layouts.iter().flat_map(|layout| layout["nodes"].as_array().unwrap());
    nodes.map(|node| node["nodeId"].as_str().unwrap().to_owned()).filter(|id| id.starts_with("space:")).collect()
}

#[test]
fn zones_have_another_id_where_the_schedule_changes_them_and_maps_the_same() {
    let (before, same, after) = (at("2024-04-27T12:00:00", &[]), at("2024-04-28T12:00:00", &[]), at("2024-06-03", &[]));
    let [before, same, after] = [before, same, after].map(|maps| (of_ground_floor(&maps), maps));
    assert_eq!(before.0, same.0, "nothing changes between these instants");
    let zone_set = |maps: &Maps| std::fs::read(maps.path().join("fleet/vda5050/00-ground-floor.zoneSet.json")).unwrap();
    assert_eq!(zone_set(&before.1), zone_set(&same.1));
    for key in ["zone_set_id", "map_version"] {
        assert_ne!(before.0[key], after.0[key], "{key}");
    }
    assert_eq!(before.0["map_id"], after.0["map_id"]);
    let manifest = &before.1.manifest;
    assert_eq!(before.1.json("fleet/vda5050/maps.json")["valid_until"], manifest["valid_until"]);
    assert_eq!(before.0["map"]["sha256"], manifest["files"]["fleet/vda5050/00-ground-floor.map.tar"]);
    let (early, late) = (rooms(&before.1), rooms(&after.1));
    assert!(early.len() >= 5 && late.is_superset(&early), "{early:?} {late:?}");
}

#[test]
fn a_door_that_this_robot_cannot_open_is_released_by_others() {
    let home = tempfile::tempdir().unwrap();
    let robot = home.path().join("robot.toml");
    std::fs::write(&robot, "name = \"pallet truck\"\nopens = [\"sliding\"]\n").unwrap();
    let maps = at("2024-06-03", &["--robot", robot.to_str().unwrap()]);
    let zones = zones_of_ground_floor(&maps);
    let released: Vec<&Value> = zones.iter().filter(|zone| zone["zoneType"] == "RELEASE").collect();
    let names: Vec<&str> = released.iter().map(|zone| zone["zoneDescriptor"].as_str().unwrap()).collect();
    assert!(names.iter().any(|name| name.contains("G.D09 meeting room")), "{names:?}");
    assert!(released.iter().all(|zone| zone["releaseLossBehavior"] == "STOP"));
    assert!(!names.iter().any(|name| name.contains("G.D11")), "a door that is too narrow stays closed: {names:?}");
    let vehicle = &maps.json("fleet/lif/site.lif.json")["layouts"][0]["nodes"][0]["vehicleTypeNodeProperties"][0];
    assert_eq!(vehicle["vehicleTypeId"], "pallet.truck");
    let default = zones_of_ground_floor(&at("2024-06-03", &[]));
    assert!(!default.iter().any(|zone| zone["zoneDescriptor"].as_str().unwrap().contains("G.D09")));
}

#[test]
fn only_formats_that_are_asked_for_are_written() {
    let maps = convert(&demo_model(), &["--resolution", "0.2", "--fleet", "lif"]);
    let fleet: Vec<String> =
        maps.manifest["files"].as_object().unwrap().keys().filter(|path| path.starts_with("fleet/")).cloned().collect();
    assert_eq!(fleet, ["fleet/lif/site.lif.json"]);
    let refused = groundplan(&[&"convert", &demo_model(), &"-o", &maps.path().join("x"), &"--fleet", &"openfleet"]);
    assert_eq!(refused.status.code(), Some(2));
    assert!(String::from_utf8(refused.stderr).unwrap().contains("vda5050"));
}
