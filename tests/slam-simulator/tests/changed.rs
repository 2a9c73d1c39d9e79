//! Maps of buildings that are not as planned (`slam-pairs changed`), of a model as `groundplan convert` writes one.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

use occupancy::{Cell, OccupancyMap};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::path::Path;
use std::process::{Command, Output};

/// Walls of a house of two rooms as boxes: x from, y from, x to, y to, in metres; and a column.
const ELEMENTS: [(&str, &str, [f64; 4]); 8] = [
    ("south", "wall", [-0.2, -0.2, 10.2, 0.0]),
    ("north", "wall", [-0.2, 8.0, 10.2, 8.2]),
    ("west", "wall", [-0.2, 0.0, 0.0, 8.0]),
    ("east", "wall", [10.0, 0.0, 10.2, 8.0]),
    ("partition south of the door", "wall", [4.9, 0.0, 5.1, 3.0]),
    ("partition north of the door", "wall", [4.9, 4.2, 5.1, 8.0]),
    ("bay", "wall", [7.0, 5.0, 7.2, 8.0]),
    ("column", "column", [2.0, 5.0, 2.5, 5.5]),
];
const STOREY: &str = "storeys/00-ground";

/// Writes what `groundplan convert --with-geometry` writes of the house, as far as it is read.
fn write_house(folder: &Path, resolution_m: f64) {
    let storey = folder.join(STOREY);
    std::fs::create_dir_all(&storey).unwrap();
    let manifest = json!({
        "robot": {"lidar_height_m": 0.3},
        "storeys": [{"index": 0, "floor_z_m": 0.0, "directory": STOREY}],
    });
    let elements: BTreeMap<&str, Value> =
        ELEMENTS.iter().map(|(name, class, plan)| (*name, element(class, *plan))).collect();
    for (name, document) in [("manifest.json", manifest), ("semantic.json", json!({"elements": elements}))] {
        std::fs::write(folder.join(name), document.to_string()).unwrap();
    }
    let (width, height) = ((12.0 / resolution_m) as usize, (10.0 / resolution_m) as usize);
    let cell = |k: usize| {
        let [x, y] = [k % width, k / width].map(|c| (c as f64 + 0.5) * resolution_m - 1.0);
        let is_in = |b: &[f64; 4]| b[0] < x && x < b[2] && b[1] < y && y < b[3];
        match ELEMENTS.iter().any(|(_, _, plan)| is_in(plan)) {
            true => Cell::Occupied,
            false if is_in(&[0.0, 0.0, 10.0, 8.0]) => Cell::Free,
            false => Cell::Unknown,
        }
    };
    let map =
        OccupancyMap { width, cells: (0..width * height).map(cell).collect(), resolution_m, origin: [-1.0, -1.0, 0.0] };
    slam_simulator::write_map(&storey, "planning", &map).unwrap();
}

/// A box of 2.5 m with its faces outwards.
fn element(class: &str, [x0, y0, x1, y1]: [f64; 4]) -> Value {
    let corner = |k: usize| [[x0, x1][k & 1], [y0, y1][(k >> 1) & 1], [0.0, 2.5][k >> 2]];
    let sides = [[0, 1, 5, 4], [1, 3, 7, 5], [3, 2, 6, 7], [2, 0, 4, 6], [4, 5, 7, 6], [0, 2, 3, 1]];
    let faces: Vec<[usize; 3]> = sides.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect();
    json!({"class": class, "vertices": (0..8).map(corner).collect::<Vec<_>>(), "faces": faces})
}

fn changed(folder: &Path, out: &str, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_slam-pairs"));
    command.args(["changed", out, "house"]).args(arguments).args(["--clutter", "low"]);
    command.current_dir(folder).output().unwrap()
}

fn truths(folder: &Path) -> Vec<Value> {
    let text = std::fs::read_to_string(folder.join("truth.jsonl")).unwrap();
    text.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

#[test]
fn beams_meet_what_stands_and_cross_what_was_removed() {
    let home = tempfile::tempdir().unwrap();
    write_house(&home.path().join("house"), 0.025);
    let done = changed(home.path(), "out", &["--count", "12", "--changed", "0.3", "--seed", "3"]);
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    let truths = truths(&home.path().join("out"));
    assert_eq!(truths.len(), 12);
    let (mut kept_m, mut removed_m, mut kept_crossed, mut removed_crossed) = (0.0, 0.0, 0.0, 0.0);
    for truth in &truths {
        OccupancyMap::read(&home.path().join("out").join(truth["slam"].as_str().unwrap())).unwrap();
        assert_eq!((truth["building"].as_str(), truth["storey"].as_u64()), (Some("house"), Some(0)));
        let elements = truth["elements"].as_object().unwrap();
        assert_eq!(elements.len(), ELEMENTS.len());
        for element in elements.values() {
            let (met_m, crossed) = (element["met_m"].as_f64().unwrap(), element["crossed_share"].as_f64().unwrap());
            assert_eq!(element["group"].is_null(), element["change"].is_null());
            match element["change"].as_str() {
                Some("removed") => (removed_m, removed_crossed) = (removed_m + met_m, removed_crossed + crossed),
                None => (kept_m, kept_crossed) = (kept_m + met_m, kept_crossed + crossed),
                Some(_) => {}
            }
        }
        let n_changed = elements.values().filter(|element| !element["change"].is_null()).count();
        assert!((1..=3).contains(&n_changed), "{n_changed} of 8");
    }
    assert!(kept_m > 100.0 && kept_crossed == 0.0, "{kept_m} m, {kept_crossed}");
    assert!(removed_m == 0.0 && removed_crossed > 0.5, "{removed_m} m, {removed_crossed}");
}

#[test]
fn the_same_seed_changes_the_same() {
    let home = tempfile::tempdir().unwrap();
    write_house(&home.path().join("house"), 0.025);
    for (out, seed) in [("one", "5"), ("two", "5"), ("other", "6")] {
        assert!(changed(home.path(), out, &["--count", "3", "--seed", seed]).status.success());
    }
    let [one, two, other] = ["one", "two", "other"].map(|out| truths(&home.path().join(out)));
    assert_eq!(one, two);
    assert_ne!(one, other);
    for truth in &one {
        let map = |out: &str| OccupancyMap::read(&home.path().join(out).join(truth["slam"].as_str().unwrap())).unwrap();
        assert_eq!(map("one"), map("two"));
    }
}

#[test]
fn a_model_that_cannot_be_driven_in_is_told() {
    let home = tempfile::tempdir().unwrap();
    let folder = home.path().join("house");
    let error = || {
        let done = changed(home.path(), "out", &["--count", "1"]);
        assert!(!done.status.success());
        String::from_utf8_lossy(&done.stderr).into_owned()
    };
    let text = error();
    assert!(text.contains("manifest.json cannot be read"), "{text}");
    write_house(&folder, 0.05);
    let text = error();
    assert!(text.contains("give --resolution 0.025 to groundplan convert"), "{text}");
    std::fs::write(folder.join("semantic.json"), r#"{"elements": 3}"#).unwrap();
    let text = error();
    assert!(text.contains("is not what groundplan convert --with-geometry writes"), "{text}");
}
