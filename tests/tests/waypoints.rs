//! Waypoints through the client and its daemon.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

use end_to_end::live::Live;
use end_to_end::{contents, convert, demo_model, groundplan};
use serde_json::Value;
use std::collections::BTreeSet;
use std::path::Path;

const DATE: &str = "2024-06-03T12:00:00";

fn exported(live: &Live) -> Value {
    let out = live.home.path().join("exported");
    live.text(&[&"export", &out]);
    read(&out)
}

fn read(out: &Path) -> Value {
    serde_json::from_slice(&std::fs::read(out.join("waypoints.json")).unwrap()).unwrap()
}

/// Spaces that have a waypoint of this kind.
fn names(waypoints: &Value, kind: &str) -> BTreeSet<String> {
    let all = waypoints["waypoints"].as_array().unwrap().iter().filter(|w| w["kind"] == kind);
    all.filter_map(|w| w["name"].as_str().map(str::to_owned)).collect()
}

#[test]
fn what_waypoints_were_asked_for_survives_the_daemon_and_can_be_taken_back() {
    let mut live = Live::of(&demo_model(), &format!("[schedule]\nplan_time = {DATE:?}\n"));
    let usual = exported(&live);
    assert!(names(&usual, "centre").len() > 10 && !names(&usual, "scan").is_empty());
    let only = |found: &Value| {
        let names = names(found, "centre");
        assert!(names.contains("G.02 Plant room") && names.iter().all(|n| n.starts_with("G.0")), "{names:?}");
        assert!(found["spaces"].as_object().unwrap().values().any(|s| s["why"] == "not_asked"));
    };
    live.text(&[&"waypoints", &"--space", &"G.0*"]);
    only(&exported(&live));
    live.kill("waypoint-gen");
    only(&exported(&live));
    live.down();
    live.up();
    only(&exported(&live));
    live.text(&[&"waypoints"]);
    assert_eq!(exported(&live), usual, "without arguments it is what is configured");
    live.down();
    assert_eq!(live.segments(), 0);
}

#[test]
fn the_daemon_plans_what_convert_plans_with_the_same_options() {
    let mut live = Live::of(&demo_model(), &format!("[schedule]\nplan_time = {DATE:?}\n"));
    let options = live.home.path().join("options.toml");
    std::fs::write(&options, "[sensor]\nrange_m = 5.0\nfield_of_view_rad = 2.0\n[tour]\nclosed = true\n").unwrap();
    live.text(&[&"waypoints", &options]);
    let (from_bus, converted) = (live.home.path().join("bus"), live.home.path().join("converted"));
    live.text(&[&"export", &from_bus]);
    let arguments: [&dyn AsRef<std::ffi::OsStr>; 8] =
        [&"convert", &demo_model(), &"-o", &converted, &"--date", &DATE, &"--waypoints", &options];
    assert!(groundplan(&arguments).status.success());
    assert!(contents(&from_bus) == contents(&converted));
    let echo: Value = serde_json::from_str(&live.text(&[&"topic", &"echo", &"mission-plan"])).unwrap();
    let waypoints = read(&converted);
    assert_eq!(echo["content"]["waypoints"], waypoints["waypoints"].as_array().unwrap().len());
    for (published, written) in
        echo["content"]["storeys"].as_array().unwrap().iter().zip(waypoints["storeys"].as_array().unwrap())
    {
        assert_eq!(published["scans"], written["scans"]);
    }
    live.down();
}

#[test]
fn options_that_cannot_be_planned_change_nothing() {
    let mut live = Live::of(&demo_model(), &format!("[schedule]\nplan_time = {DATE:?}\n"));
    let before = live.text(&[&"topic", &"echo", &"mission-plan"]);
    let options = live.home.path().join("options.toml");
    std::fs::write(&options, "[scan]\ncoverage = 2.0\n").unwrap();
    let refused = live.run(&[&"waypoints", &options]);
    assert!(!refused.status.success());
    let why = String::from_utf8_lossy(&refused.stderr).into_owned();
    assert!(why.contains("coverage"), "{why}");
    assert_eq!(live.text(&[&"topic", &"echo", &"mission-plan"]), before);
    live.down();
}

#[test]
fn names_that_match_nothing_are_refused_with_the_nearest_and_the_earlier_plan_stays() {
    let mut live = Live::of(&demo_model(), &format!("[schedule]\nplan_time = {DATE:?}\n"));
    let plan = |live: &Live| live.text(&[&"topic", &"echo", &"mission-plan"]);
    let (before, exported_before) = (plan(&live), exported(&live));
    let options = live.home.path().join("options.toml");
    let refused = |arguments: &[&dyn AsRef<std::ffi::OsStr>], words: [&str; 2]| {
        let refused = live.run(arguments);
        let why = String::from_utf8_lossy(&refused.stderr).into_owned();
        assert!(!refused.status.success() && words.iter().all(|word| why.contains(word)), "{words:?}: {why}");
        assert_eq!(plan(&live), before, "{why}");
    };
    let file: [&dyn AsRef<std::ffi::OsStr>; 2] = [&"waypoints", &options];
    for (text, words) in [
        ("spaces = [\"Plnat room\"]\n", ["\"Plnat room\" matches no space", "\"Plant room\""]),
        ("[tour]\nlifts = [\"Lfit\"]\n", ["\"Lfit\" matches no lift", "nearest: \"G.lift car\""]),
        ("[tour]\nstart = { storey = 9, x_m = 1.0, y_m = 1.0 }\n", ["no storey 9", "1 is \"Upper floor\""]),
        (
            "[tour]\nstart = { storey = 0, x_m = -5.0, y_m = 3.0 }\n",
            ["[tour] start", "nearest place where it can is x"],
        ),
    ] {
        std::fs::write(&options, text).unwrap();
        refused(&file, words);
    }
    refused(&[&"waypoints", &"--space", &"Plnat room"], ["\"Plnat room\" matches no space", "\"Plant room\""]);
    live.down();
    live.up();
    assert_eq!(exported(&live), exported_before, "nothing of it is kept for the next start");
    live.down();
}

#[test]
fn a_scan_of_what_changed_looks_at_less_than_a_scan_of_everything() {
    let home = tempfile::tempdir().unwrap();
    let options = home.path().join("options.toml");
    std::fs::write(&options, "[scan]\nchanged_since = \"2024-05-13T00:00:00\"\n").unwrap();
    let all = convert(&demo_model(), &["--date", DATE]).json("waypoints.json");
    let changed = convert(&demo_model(), &["--date", DATE, "--waypoints", options.to_str().unwrap()]);
    let changed = changed.json("waypoints.json");
    let faces = |w: &Value| w["storeys"].as_array().unwrap().iter().map(|s| s["faces"].as_u64().unwrap()).sum::<u64>();
    assert!(0 < faces(&changed) && faces(&changed) < faces(&all) / 2, "{} of {}", faces(&changed), faces(&all));
    assert_eq!(names(&changed, "centre"), names(&all, "centre"));
}

#[test]
fn the_check_on_meshes_says_what_share_of_all_heights_is_seen() {
    let home = tempfile::tempdir().unwrap();
    let options = home.path().join("options.toml");
    std::fs::write(&options, "[scan]\nmesh_check = true\n").unwrap();
    let waypoints = convert(&demo_model(), &["--waypoints", options.to_str().unwrap()]).json("waypoints.json");
    // Nothing is scanned on the ground outdoors.
    let storeys = || waypoints["storeys"].as_array().unwrap().iter().take(3);
    let of_all = |key: &str| storeys().map(|storey| storey[key].as_u64().unwrap()).sum::<u64>();
    let (points, seen) = (of_all("mesh_points"), of_all("mesh_points_seen"));
    assert!(points > 500 && seen > points * 9 / 10 && seen < points, "{seen} of {points}");
    for storey in storeys() {
        let [points, seen] = ["mesh_points", "mesh_points_seen"].map(|key| storey[key].as_u64().unwrap());
        assert!(points > 0 && seen > points * 9 / 10, "{seen} of {points}");
    }
    let without = convert(&demo_model(), &[]).json("waypoints.json");
    assert!(without["storeys"][0]["mesh_points"].is_null());
    assert_eq!(without["waypoints"], waypoints["waypoints"]);
    for notice in waypoints["notices"].as_array().unwrap().iter().filter(|n| n["code"] == "element_unseen") {
        assert_eq!(notice["element"].as_str().unwrap().len(), 22, "{notice}");
    }
}
