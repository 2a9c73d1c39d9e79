//! `groundplan check`: models with one fault each, in schemas, units and places that vary, and models without any.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

use end_to_end::{demo_model, groundplan, root};
use serde_json::Value;
use std::collections::BTreeSet;
use std::path::Path;
use std::process::Command;

/// Writes a model with a fault, or none, and gives what is wrong with it.
fn model(path: &Path, fault: &str, options: &[&str]) -> Value {
    let mut script = Command::new("python3");
    script.arg(root().join("scripts/faulty_model.py")).arg(path).args(Some(fault).filter(|fault| !fault.is_empty()));
    let output = script.args(options).output().unwrap();
    assert!(output.status.success(), "{fault}: {}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

fn faults() -> Vec<String> {
    let output = Command::new("python3").arg(root().join("scripts/faulty_model.py")).arg("--list").output().unwrap();
    String::from_utf8(output.stdout).unwrap().lines().map(str::to_owned).collect()
}

/// The exit code and the document of a check.
fn checked(path: &Path) -> (i32, Value) {
    let output = groundplan(&[&"check", &path, &"--json"]);
    let code = output.status.code().unwrap();
    assert!([0, 3].contains(&code), "{}: {}", path.display(), String::from_utf8_lossy(&output.stderr));
    (code, serde_json::from_slice(&output.stdout).unwrap())
}

fn texts(list: &Value) -> BTreeSet<String> {
    list.as_array().unwrap().iter().map(|text| text.as_str().unwrap().to_owned()).collect()
}

fn ids(list: &Value) -> BTreeSet<String> {
    list.as_array().unwrap().iter().map(|of| of["global_id"].as_str().unwrap().to_owned()).collect()
}

/// Schema, unit, turn and place of the models of a test.
const VARIANTS: [&[&str]; 5] = [
    &["--schema", "IFC4", "--unit", "METRE"],
    &["--schema", "IFC2X3", "--unit", "MILLI", "--turn", "27.5", "--shift", "120", "-35"],
    &["--schema", "IFC4", "--unit", "FOOT", "--turn", "-63"],
    &["--schema", "IFC4X3_ADD2", "--unit", "CENTI", "--shift", "-800", "2400"],
    &["--schema", "IFC2X3", "--unit", "METRE", "--turn", "90"],
];

/// Faults whose issues change no map, so that the model is fit.
const OF_DATA: [&str; 12] = [
    "door_without_width",
    "door_without_operation",
    "door_width_wrong",
    "duplicate_element",
    "element_on_other_storey",
    "floor_without_room",
    "no_dates",
    "no_georeference",
    "opening_misses_wall",
    "storey_elevation",
    "door_beside_opening",
    "wall_gap",
];

#[test]
fn every_fault_is_found_with_its_elements_and_effect_and_no_other() {
    let folder = tempfile::tempdir().unwrap();
    for (k, fault) in faults().iter().enumerate() {
        for n in 0..2 {
            let variant = VARIANTS[(2 * k + n) % VARIANTS.len()];
            let seed = (3 * k + n + 1).to_string();
            let path = folder.path().join(format!("{fault}-{n}.ifc"));
            let truth = model(&path, fault, &[variant, &["--seed", &seed]].concat());
            let context = format!("{fault}, seed {seed}, {variant:?}");
            let (code, document) = checked(&path);
            let issues = document["issues"].as_array().unwrap();
            let codes: Vec<&str> = issues.iter().map(|issue| issue["code"].as_str().unwrap()).collect();
            assert_eq!(codes, [truth["code"].as_str().unwrap()], "{context}");
            let (issue, effect) = (&issues[0], &issues[0]["effect"]);
            // Of two copies either is at fault: the other one is named beside it.
            let named = issue["elements"].to_string();
            assert!(texts(&truth["elements"]).iter().all(|id| named.contains(id)), "{context}: {issue}");
            assert!(texts(&truth["doors"]).is_subset(&ids(&effect["doors"])), "{context}: {issue}");
            let out_of_reach = texts(&truth["unreachable"]);
            assert!(out_of_reach.is_subset(&ids(&effect["rooms"])), "{context}: {issue}");
            assert!(texts(&truth["rooms"]).is_subset(&ids(&effect["rooms"])), "{context}: {issue}");
            if let Some(area_m2) = truth["area_m2"].as_f64() {
                let found_m2 = effect["area_m2"].as_f64().unwrap();
                assert!((found_m2 - area_m2).abs() < 0.15 * area_m2 + 0.1, "{context}: {found_m2} of {area_m2} m2");
            }
            let is_of_data = OF_DATA.contains(&truth["code"].as_str().unwrap());
            assert_eq!(document["fit"] == true, code == 0, "{context}");
            assert_eq!(issue["kind"] == "maps", code == 3, "{context}");
            assert!(is_of_data || code == 3, "{context}: {issue}");
        }
    }
}

#[test]
fn sound_models_and_the_demo_have_no_issue() {
    let folder = tempfile::tempdir().unwrap();
    for (k, variant) in VARIANTS.iter().enumerate() {
        for seed in [k + 1, k + 11] {
            let path = folder.path().join(format!("sound-{seed}.ifc"));
            model(&path, "", &[*variant, &["--seed", &seed.to_string()]].concat());
            let (code, document) = checked(&path);
            assert_eq!((code, &document["issues"]), (0, &Value::Array(vec![])), "{variant:?}, seed {seed}");
            assert_eq!(document["building"], Value::Array(vec![]), "{variant:?}, seed {seed}");
        }
    }
    let (code, document) = checked(&demo_model());
    assert_eq!((code, &document["issues"]), (0, &Value::Array(vec![])));
    let building: Vec<&str> =
        document["building"].as_array().unwrap().iter().map(|i| i["code"].as_str().unwrap()).collect();
    assert!(building.contains(&"door_too_narrow") && building.contains(&"door_of_lift"), "{building:?}");
}

#[test]
fn a_model_without_a_unit_is_no_verdict_but_a_failure() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("unit.ifc");
    model(&path, "", &[]);
    let text = std::fs::read_to_string(&path).unwrap();
    std::fs::write(&path, text.replace(".LENGTHUNIT.", ".MASSUNIT.")).unwrap();
    let output = groundplan(&[&"check", &path]);
    assert_eq!(output.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&output.stderr).contains("unit"), "{}", String::from_utf8_lossy(&output.stderr));
}

#[test]
fn the_page_and_the_topics_hold_every_element_of_every_issue() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("house.ifc");
    let truth = model(&path, "door_without_opening", &["--turn", "20", "--seed", "4"]);
    let door = truth["elements"][0].as_str().unwrap();
    for version in ["2.1", "3.0"] {
        let (html, bcf) = (folder.path().join("check.html"), folder.path().join("check.bcfzip"));
        let output = groundplan(&[&"check", &path, &"--html", &html, &"--bcf", &bcf, &"--bcf-version", &version]);
        assert_eq!(output.status.code(), Some(3), "{}", String::from_utf8_lossy(&output.stderr));
        let page = std::fs::read_to_string(&html).unwrap();
        assert!(page.contains(door) && page.contains("data:image/png;base64,") && !page.contains("<script"));
        let container = bcf::Container::read(&std::fs::read(&bcf).unwrap()).unwrap();
        assert_eq!(container.version().text(), version);
        let [topic] = container.topics() else { panic!("{:?}", container.topics()) };
        assert_eq!((topic.status.as_str(), &topic.labels[0]), ("Open", &"door_without_opening".to_owned()));
        let viewpoint = &topic.viewpoints[0];
        assert_eq!(viewpoint.components[0].global_id, door);
        assert!(matches!(&viewpoint.snapshot, Some(bcf::Snapshot::Png(bytes)) if bytes.starts_with(b"\x89PNG")));
        // The camera stands over the door in the coordinates of the file, which are turned.
        let [_, _, z] = viewpoint.camera.unwrap().position;
        assert!((20.0..25.0).contains(&z), "{z}");
    }
}
