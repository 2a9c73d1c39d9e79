//! Flight waypoints of the demo building and of a site on terrain, from the command line and from running daemons.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

use end_to_end::live::Live;
use end_to_end::{Maps, contents, convert, demo_model, groundplan, terrain_site};
use serde_json::Value;
use std::collections::BTreeSet;
use std::ffi::OsStr;
use std::path::Path;

const OPTIONS: &str = "waypoints = []\n[flight]\nheights_m = [1.2, 3.0]\nclearance_m = 0.4\nspacing_m = 3.0\n";

/// Partition walls stand, their doors are open holes.
const DATE: &str = "2024-05-02T00:00:00";

fn flown(model: &Path, more: &[&str]) -> (Maps, Value) {
    let home = tempfile::tempdir().unwrap();
    let options = home.path().join("drone.toml");
    std::fs::write(&options, OPTIONS).unwrap();
    let maps = convert(model, &[&["--waypoints", options.to_str().unwrap()], more].concat());
    let flight = maps.json("flight.json");
    (maps, flight)
}

fn list<'a>(document: &'a Value, key: &str) -> &'a [Value] {
    document[key].as_array().unwrap()
}

fn number(value: &Value, key: &str) -> f64 {
    value[key].as_f64().unwrap()
}

/// Parts in which the waypoints lie that a choice takes.
fn parts(flight: &Value, is_chosen: impl Fn(&Value) -> bool) -> BTreeSet<u64> {
    list(flight, "waypoints").iter().filter(|w| is_chosen(w)).map(|w| w["part"].as_u64().unwrap()).collect()
}

#[test]
fn every_waypoint_keeps_the_clearance_and_every_room_has_some_or_a_reason() {
    let (maps, flight) = flown(&demo_model(), &[]);
    assert!(maps.manifest["files"]["flight.json"].is_string());
    assert_eq!(
        (&flight["plan_time"], &flight["frame"], number(&flight, "clearance_m")),
        (&Value::Null, &"map".into(), 0.4)
    );
    assert!(list(&flight, "waypoints").len() > 50);
    for waypoint in list(&flight, "waypoints") {
        assert!(number(waypoint, "clearance_m") >= 0.4, "{waypoint}");
        let height_m = number(waypoint, "height_above_ground_m");
        assert!(height_m == 1.2 || height_m == 3.0, "{waypoint}");
    }
    let mut n_reasons = 0;
    for (global_id, space) in flight["spaces"].as_object().unwrap() {
        for height in list(space, "heights") {
            assert_eq!(height["waypoints"] == 0, height["reason"].is_string(), "{global_id}: {height}");
            n_reasons += usize::from(height["why"] == "too_narrow");
        }
    }
    // Storeys are 3.5 m apart with slabs and ceilings: at 3 m rooms are too low for 0.4 m of air.
    assert!(n_reasons > 5, "{n_reasons}");
}

#[test]
fn doors_that_hang_part_rooms_and_open_holes_do_not() {
    let whole = flown(&demo_model(), &[]).1;
    let early = flown(&demo_model(), &["--date", DATE]).1;
    let in_rooms = |w: &Value| w["space"].is_string() && w["storey"] == 0;
    let [whole, early] = [&whole, &early].map(|flight| parts(flight, in_rooms).len());
    assert!(early < whole, "{early} {whole}");
}

#[test]
fn the_heights_over_terrain_follow_it() {
    let home = tempfile::tempdir().unwrap();
    let (model, _) = terrain_site(home.path(), &[]);
    let (maps, flight) = flown(&model, &["--resolution", "0.25"]);
    let outdoors = list(&maps.manifest, "storeys").iter().find(|storey| storey["floor"] == "ground").unwrap();
    let over: Vec<&Value> = list(&flight, "waypoints").iter().filter(|w| w["storey"] == outdoors["index"]).collect();
    let heights: BTreeSet<i64> = over.iter().map(|w| (number(w, "z_m") * 10.0).round() as i64).collect();
    assert!(over.len() > 200 && heights.len() > 10, "{} {heights:?}", over.len());
    // The highest ground within 0.4 m is as near as that.
    let farthest_m = over.iter().map(|w| number(w, "clearance_m")).fold(0.0, f64::max);
    assert!((2.0..3.1).contains(&farthest_m), "{farthest_m}");
}

#[test]
fn running_daemons_export_the_same_flight_waypoints_and_none_without_the_section() {
    let mut live = Live::of(&demo_model(), &format!("[schedule]\nplan_time = {DATE:?}\n"));
    let home = live.home.path().to_owned();
    let without = home.join("without");
    live.text(&[&"export", &without]);
    assert!(without.join("waypoints.json").is_file() && !without.join("flight.json").exists());
    let options = home.join("drone.toml");
    std::fs::write(&options, OPTIONS).unwrap();
    live.text(&[&"waypoints", &options]);
    let (exported, converted) = (home.join("exported"), home.join("converted"));
    live.text(&[&"export", &exported]);
    let arguments: [&dyn AsRef<OsStr>; 8] =
        [&"convert", &demo_model(), &"-o", &converted, &"--date", &DATE, &"--waypoints", &options];
    assert!(groundplan(&arguments).status.success());
    assert!(exported.join("flight.json").is_file());
    for ((path, from_bus), (_, from_files)) in contents(&exported).into_iter().zip(contents(&converted)) {
        assert!(from_bus == from_files, "{} differs", path.display());
    }
    assert_eq!(contents(&exported).len(), contents(&converted).len());
    live.down();
}

#[test]
fn options_that_no_drone_can_keep_are_refused_before_anything_is_read() {
    let home = tempfile::tempdir().unwrap();
    let (options, out) = (home.path().join("drone.toml"), home.path().join("maps"));
    std::fs::write(&options, "[flight]\nheights_m = [0.5]\nclearance_m = 0.8\n").unwrap();
    let refused = groundplan(&[&"convert", &"no-such.ifc", &"-o", &out, &"--waypoints", &options]);
    let stderr = String::from_utf8(refused.stderr).unwrap();
    assert!(refused.status.code() == Some(2) && !out.exists());
    assert!(stderr.contains("drone.toml") && stderr.contains("the ground is nearer than clearance_m 0.8"), "{stderr}");
}
