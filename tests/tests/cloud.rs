//! The demo building as a cloud: what has points at a date, and arguments that no cloud can have.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

use end_to_end::{convert, demo_model, groundplan};
use serde_json::Value;
use std::collections::BTreeMap;
use std::ffi::OsStr;
use std::process::Output;

/// Number of points by class.
fn points_by_class(structure: &Value) -> BTreeMap<&str, u64> {
    let classes = structure["classes"].as_object().unwrap();
    classes.iter().map(|(name, class)| (name.as_str(), class["points"].as_u64().unwrap())).collect()
}

#[test]
fn what_is_not_finished_at_a_date_has_no_points() {
    let whole = convert(&demo_model(), &["--cloud"]).json("cloud/structure.json");
    let early = convert(&demo_model(), &["--cloud", "--date", "2024-04-06"]).json("cloud/structure.json");
    assert!(early["points"].as_u64() < whole["points"].as_u64() && early["plan_time"] == "2024-04-06T00:00:00");
    let (early, whole) = (points_by_class(&early), points_by_class(&whole));
    assert!(early["slab"] > 0 && early["wall"] > 0 && early["wall"] < whole["wall"], "{early:?} {whole:?}");
    assert!(!whole.contains_key("furniture") && !whole.contains_key("door") && !whole.contains_key("window"));
}

#[test]
fn a_larger_spacing_and_fewer_classes_make_fewer_points() {
    let maps = convert(&demo_model(), &["--cloud", "--cloud-spacing", "0.2", "--cloud-classes", "column,furniture"]);
    let structure = maps.json("cloud/structure.json");
    let by_class = points_by_class(&structure);
    assert!(by_class.len() == 2 && by_class.values().all(|n| *n > 0), "{by_class:?}");
    assert_eq!(structure["spacing_m"], 0.2);
    let header = std::fs::read(maps.path().join("cloud/structure.pcd")).unwrap();
    let header = String::from_utf8_lossy(&header[..400]).into_owned();
    assert!(header.contains(&format!("POINTS {}\nDATA binary\n", structure["points"])), "{header}");
    assert!(maps.json("manifest.json")["files"]["cloud/structure.pcd"].is_string());
}

#[test]
fn arguments_that_no_cloud_can_have_are_refused_before_anything_is_read() {
    let refused = |arguments: &[&str]| {
        let home = tempfile::tempdir().unwrap();
        let out = home.path().join("maps");
        let mut words: Vec<&dyn AsRef<OsStr>> = vec![&"convert", &"no-such.ifc", &"-o", &out];
        words.extend(arguments.iter().map(|word| word as &dyn AsRef<OsStr>));
        let Output { status, stderr, .. } = groundplan(&words);
        assert!(status.code() == Some(2) && !out.exists());
        String::from_utf8(stderr).unwrap()
    };
    assert!(refused(&["--cloud", "--cloud-spacing", "0"]).contains("0.005 to 5 m is meant"));
    assert!(refused(&["--cloud", "--cloud-classes", "wall,walls"]).contains("there is no class \"walls\""));
    assert!(refused(&["--cloud-spacing", "0.1"]).contains("--cloud"));
}
