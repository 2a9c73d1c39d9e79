//! The walkable surface as files: what is in it at a date, read by a mesh library, and the same from running daemons.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

use end_to_end::live::Live;
use end_to_end::{announce, convert, demo_model, groundplan, root};
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::Path;
use std::process::Command;

const DATE: &str = "2024-04-27T08:00:00";

/// Area in plan by class, from the document alone.
fn areas(document: &Value) -> BTreeMap<String, f64> {
    let mut areas = BTreeMap::new();
    for surface in document["surfaces"].as_array().unwrap() {
        let class = surface["class"].as_str().unwrap().to_owned();
        *areas.entry(class).or_insert(0.0) += surface["area_m2"].as_f64().unwrap();
    }
    areas
}

/// What the script counted; `None`, and a loud word, where it cannot run.
fn checked(out: &Path) -> Option<Value> {
    let packages = ["trimesh==4.9.0", "numpy", "pillow==11.3.0"];
    let made = Command::new(root().join("scripts/python-env")).args(packages).output().unwrap();
    if !made.status.success() {
        announce(&format!("SKIPPED: trimesh or Pillow cannot be installed: {}", String::from_utf8_lossy(&made.stderr)));
        return None;
    }
    let mut check = Command::new(root().join("target/venv/bin/python"));
    let output = check.arg(root().join("scripts/check_ground.py")).arg(out).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    Some(serde_json::from_slice(&output.stdout).unwrap())
}

#[test]
fn the_demo_building_has_terrain_floors_a_ramp_and_a_stair_between_two_floors() {
    let maps = convert(&demo_model(), &["--with-ground", "--resolution", "0.2"]);
    let document = maps.json("ground.json");
    let areas = areas(&document);
    let near = |class: &str, m2: f64| (areas[class] - m2).abs() < 0.01;
    assert!(near("terrain", 880.0) && near("ramp", 3.92) && near("stair_tread", 17.0 * 0.336), "{areas:?}");
    let has = |kind: &str, step_m: f64| {
        let all = document["connections"].as_array().unwrap();
        all.iter().filter(|c| c["kind"] == kind && (c["step_m"].as_f64().unwrap().abs() - step_m).abs() < 1e-3).count()
    };
    assert_eq!(has("stair", 0.1778), 18, "{}", document["connections"]);
    assert!(has("ramp", 0.0) == 2 && has("step", 0.03) == 1, "{}", document["connections"]);
    for name in ["ground.ply", "ground.json"] {
        assert!(maps.manifest["files"][name].is_string(), "the manifest lists {name}");
    }
    let Some(counted) = checked(&maps.path()) else { return };
    assert!((counted["area_m2"].as_f64().unwrap() - areas.values().sum::<f64>()).abs() < 0.01, "{counted}");
    assert!(counted["faces"].as_u64() > Some(50), "{counted}");
    // Of the ground floor and the dock, which a ramp joins, and of the yard; the script has judged the shares.
    assert_eq!(counted["heights_agree"].as_object().map(serde_json::Map::len), Some(3), "{counted}");
}

#[test]
fn what_is_not_built_yet_is_no_ground_and_without_the_option_there_is_no_file() {
    let without = convert(&demo_model(), &["--resolution", "0.2"]);
    assert!(!without.path().join("ground.ply").exists());
    let early = convert(&demo_model(), &["--with-ground", "--resolution", "0.2", "--date", "2024-03-01T00:00:00"]);
    let late = convert(&demo_model(), &["--with-ground", "--resolution", "0.2", "--date", DATE]);
    let floor = |maps: &end_to_end::Maps| areas(&maps.json("ground.json")).get("floor").copied().unwrap_or(0.0);
    assert!(floor(&early) < floor(&late), "{} {}", floor(&early), floor(&late));
    assert_eq!(late.json("ground.json")["plan_time"], DATE);
}

#[test]
fn running_daemons_export_the_same_ground() {
    let mut live = Live::start();
    live.text(&[&"date", &DATE]);
    let (exported, converted) = (live.home.path().join("exported"), live.home.path().join("converted"));
    live.text(&[&"export", &exported, &"--with-ground"]);
    live.down();
    let model = live.home.path().join("demo.ifc");
    let output = groundplan(&[&"convert", &model, &"-o", &converted, &"--date", &DATE, &"--with-ground"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    for name in ["ground.ply", "ground.json", "manifest.json"] {
        let [a, b] = [&exported, &converted].map(|folder| std::fs::read(folder.join(name)).unwrap());
        assert!(a == b && !a.is_empty(), "{name} differs");
    }
}
