//! Every file of the corpus gives what `corpus.toml` says of it, or fails for the reason that stands there.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

use end_to_end::{FREE, announce, convert, corpus, files_in, groundplan};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use toml::{Table, Value};

/// Folders of the corpus with models.
const FOLDERS: [&str; 6] = ["buildings", "malformed", "representations", "schedule", "schedule/generated", "units"];

/// The files of the corpus that are models, named as in `corpus.toml`.
fn models() -> Vec<(String, PathBuf)> {
    let is_model = |path: &PathBuf| path.extension().is_some_and(|e| e == "ifc" || e == "ifczip");
    let named =
        |folder: &str, path: PathBuf| (format!("{folder}/{}", path.file_name().unwrap().to_string_lossy()), path);
    FOLDERS
        .iter()
        .filter_map(|folder| Some((folder, corpus(folder)?)))
        .flat_map(|(folder, path)| files_in(&path).into_iter().filter(is_model).map(move |path| named(folder, path)))
        .collect()
}

/// The facts of a converted model, or the error in words, with the keys of `corpus.toml`.
fn outcome(model: &Path) -> Table {
    let home = tempfile::tempdir().unwrap();
    let out = home.path().join("out");
    let output = groundplan(&[&"convert", &model, &"-o", &out, &"--resolution", &"0.1"]);
    let errors = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(!errors.contains("panicked"), "{}: {errors}", model.display());
    match output.status.code() {
        Some(0) => facts(&out),
        Some(1) => Table::from_iter([("refused".to_owned(), Value::String(errors))]),
        code => panic!("{}: exit code {code:?}: {errors}", model.display()),
    }
}

fn facts(out: &Path) -> Table {
    let json =
        |name: &str| -> serde_json::Value { serde_json::from_slice(&std::fs::read(out.join(name)).unwrap()).unwrap() };
    let (report, manifest) = (json("report.json"), json("manifest.json"));
    let elements: i64 = report["elements"].as_object().unwrap().values().map(|n| n.as_i64().unwrap()).sum();
    let floors = manifest["storeys"].as_array().unwrap().iter().map(|s| s["floor"].as_str().unwrap());
    let without_waypoint = report["spaces_without_waypoint"].as_array().unwrap().len();
    let mut findings: BTreeMap<&str, i64> = BTreeMap::new();
    for diagnostic in report["diagnostics"].as_array().unwrap().iter().filter(|d| d["severity"] != "info") {
        *findings.entry(diagnostic["code"].as_str().unwrap()).or_default() += 1;
    }
    Table::from_iter([
        ("elements".to_owned(), Value::from(elements)),
        ("floors".to_owned(), Value::Array(floors.map(Value::from).collect())),
        ("rooms_without_waypoint".to_owned(), Value::from(i64::try_from(without_waypoint).unwrap())),
        (
            "findings".to_owned(),
            findings.into_iter().map(|(code, n)| (code.to_owned(), Value::from(n))).collect::<Table>().into(),
        ),
    ])
}

/// Whether a model gave what is expected: the same facts, or an error with the expected words.
fn meets(expected: &Table, found: &Table) -> bool {
    if let Some(words) = expected.get("refused") {
        let error = found.get("refused").and_then(Value::as_str);
        return error.is_some_and(|error| error.contains(words.as_str().unwrap()));
    }
    let mut expected = expected.clone();
    expected.remove("known_failure");
    expected.entry("rooms_without_waypoint").or_insert(Value::Integer(0));
    expected.entry("findings").or_insert(Value::Table(Table::new()));
    expected == *found
}

#[test]
fn every_file_gives_what_is_expected_of_it() {
    let expectations: Table = include_str!("corpus.toml").parse().unwrap();
    let mut wrong = Vec::new();
    for (name, model) in models() {
        let found = outcome(&model);
        let Some(expected) = expectations.get(&name).and_then(Value::as_table) else {
            announce(&format!("no expectation: {name} has no entry in corpus.toml, and gives\n{found}"));
            continue;
        };
        match (meets(expected, &found), expected.get("known_failure")) {
            (true, None) => {}
            (true, Some(reason)) => wrong.push(format!("{name} passes, remove its known_failure: {reason}")),
            (false, None) => wrong.push(format!("{name} should give\n{expected}\nand gives\n{found}")),
            (false, Some(reason)) => announce(&format!("known failure: {name}: {reason}")),
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n\n"));
}

#[test]
fn the_gallery_of_the_fzk_house_has_its_void() {
    let Some(folder) = corpus("buildings") else { return };
    let upper = convert(&folder.join("AC20-FZK-Haus.ifc"), &[]).storey(1);
    // Less the railing, the head of the spiral stair, and the roof that comes down into the slab south of y = 1.7.
    upper.assert_drop_off([8.80, 1.75, 11.50, 3.80]);
    upper.assert_forbidden([7.44, 0.30, 11.70, 4.01]);
    for (x, y) in [(6.0, 3.0), (6.0, 6.0), (10.0, 6.0)] {
        assert_eq!(upper.planning(x, y), FREE, "the slab around the void at {x}, {y}");
    }
}

#[test]
fn centres_of_the_fzk_house_are_those_of_its_floors() {
    let Some(folder) = corpus("buildings") else { return };
    let waypoints = convert(&folder.join("AC20-FZK-Haus.ifc"), &[]).json("waypoints.json");
    let centre = |name: &str| {
        let all = waypoints["waypoints"].as_array().unwrap();
        let mut all = all.iter().filter(|w| w["kind"] == "centre");
        let w = all.find(|w| w["name"].as_str().unwrap().ends_with(name)).unwrap_or_else(|| panic!("no {name}"));
        [w["x_m"].as_f64().unwrap(), w["y_m"].as_f64().unwrap()]
    };
    for (name, [x, y]) in [
        ("Schlafzimmer", [9.675, 6.975]),
        ("Bad", [5.725, 7.845]),
        ("Buero", [2.05, 7.845]),
        ("Wohnen", [8.198, 2.155]),
        ("Küche", [2.498, 2.155]),
        ("Flur", [3.986, 4.935]),
    ] {
        let found = centre(name);
        assert!((found[0] - x).abs() < 0.01 && (found[1] - y).abs() < 0.01, "{name}: {found:?}");
    }
}

#[test]
fn the_stair_holes_of_the_duplex_are_drop_offs() {
    let Some(folder) = corpus("buildings") else { return };
    let maps = convert(&folder.join("Ifc2x3_Duplex_Architecture.ifc"), &[]);
    let index = maps.manifest["storeys"].as_array().unwrap().iter().position(|s| s["name"] == "Level 2").unwrap();
    let upper = maps.storey(index);
    for rectangle in DUPLEX_STAIR_HOLES {
        upper.assert_drop_off(rectangle);
    }
}

/// The openings of the two stairs in the upper slab, less their railings.
const DUPLEX_STAIR_HOLES: [[f64; 4]; 2] = [[7.5, -11.2, 8.25, -8.4], [0.55, -9.4, 1.3, -6.6]];
