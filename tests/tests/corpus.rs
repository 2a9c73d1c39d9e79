//! Corpus files: each converts or fails with a clear reason.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

mod support;

use std::path::Path;
use support::{FREE, convert, corpus, files_in, groundplan};

/// Exit code and words of a conversion.
fn outcome(model: &Path, more: &[&str]) -> (i32, String) {
    let home = tempfile::tempdir().unwrap();
    let out = home.path().join("out");
    let mut arguments: Vec<&dyn AsRef<std::ffi::OsStr>> = vec![&"convert", &model, &"-o", &out];
    arguments.extend(more.iter().map(|a| a as &dyn AsRef<std::ffi::OsStr>));
    let output = groundplan(&arguments);
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    let code = output.status.code().unwrap_or_else(|| panic!("{}: killed by a signal: {said}", model.display()));
    assert!(!said.contains("panicked"), "{}: {said}", model.display());
    (code, said)
}

#[test]
fn every_building_is_converted() {
    let Some(folder) = corpus("buildings") else { return };
    for model in files_in(&folder) {
        let (code, said) = outcome(&model, &["--resolution", "0.1"]);
        assert_eq!(code, 0, "{}: {said}", model.display());
    }
}

#[test]
fn malformed_files_are_refused_in_words() {
    let Some(folder) = corpus("malformed") else { return };
    for model in files_in(&folder) {
        let (code, said) = outcome(&model, &[]);
        assert_eq!(code, 1, "{}: {said}", model.display());
        assert!(said.len() > 40, "{}: {said}", model.display());
    }
}

#[test]
fn units_and_representations_are_drawn_or_refused_in_words() {
    for folder in ["units", "representations"] {
        let Some(folder) = corpus(folder) else { return };
        for model in files_in(&folder) {
            let (code, said) = outcome(&model, &[]);
            assert!(code == 0 || said.len() > 40, "{}: {said}", model.display());
        }
    }
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
