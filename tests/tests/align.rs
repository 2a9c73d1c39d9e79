//! `groundplan align` on files.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

mod support;

use serde_json::Value;
use std::path::{Path, PathBuf};
use support::{Maps, convert, demo_model, groundplan};

fn localization(maps: &Maps, storey: usize) -> PathBuf {
    maps.path().join(maps.manifest["storeys"][storey]["directory"].as_str().unwrap()).join("localization.yaml")
}

fn align(reference: &Path, slam: &Path, more: &[&str]) -> (Option<i32>, Value) {
    let mut arguments: Vec<&dyn AsRef<std::ffi::OsStr>> =
        vec![&"align", &"--reference", &reference, &"--slam", &slam, &"--json"];
    arguments.extend(more.iter().map(|a| a as &dyn AsRef<std::ffi::OsStr>));
    let output = groundplan(&arguments);
    (output.status.code(), serde_json::from_slice(&output.stdout).unwrap_or_default())
}

/// The planning map of a storey as a robot might have mapped it: in a frame of its own, a quarter turn around.
fn turned(maps: &Maps, storey: usize, folder: &Path) -> PathBuf {
    let source = localization(maps, storey).with_file_name("planning.pgm");
    let (width, height, pixels) = grid::decode_pgm(&std::fs::read(source).unwrap()).unwrap();
    // What was at (column, row) comes to (height - 1 - row, column).
    let turned = grid::encode_pgm(height, |at| pixels[(height - 1 - at % height) * width + at / height], width);
    std::fs::write(folder.join("robot.pgm"), turned).unwrap();
    let yaml = folder.join("robot.yaml");
    std::fs::write(&yaml, "image: robot.pgm\nresolution: 0.05\norigin: [7.5, -3.0, 0.0]\nnegate: 0\n").unwrap();
    yaml
}

#[test]
fn a_map_in_another_frame_is_found_on_its_storey_and_on_no_other() {
    let maps = convert(&demo_model(), &[]);
    let home = tempfile::tempdir().unwrap();
    let slam = turned(&maps, 0, home.path());
    let (code, found) = align(&localization(&maps, 0), &slam, &[]);
    assert_eq!((code, found["verdict"].as_str()), (Some(0), Some("accepted")), "{found}");
    let yaw_rad = found["map_from_slam"]["yaw_rad"].as_f64().unwrap();
    assert!((yaw_rad + std::f64::consts::FRAC_PI_2).abs() < 0.002, "{yaw_rad}");
    // The corner of the robot's map is the upper left corner of the model's.
    let origin = [0, 1].map(|k| maps.manifest["storeys"][0]["origin_m"][k].as_f64().unwrap());
    let high_m = maps.manifest["storeys"][0]["size_cells"][1].as_f64().unwrap() * 0.05;
    let at = [&found["map_from_slam"]["x_m"], &found["map_from_slam"]["y_m"]].map(|v| v.as_f64().unwrap());
    // R(-90 degrees) takes (7.5, -3.0) to (-3.0, -7.5).
    let corner = [at[0] - 3.0, at[1] - 7.5];
    assert!((corner[0] - origin[0]).abs() < 0.06 && (corner[1] - origin[1] - high_m).abs() < 0.06, "{corner:?}");
    let (code, anywhere) = align(&maps.path(), &slam, &[]);
    assert_eq!((code, &anywhere["storey"], &anywhere["map_from_slam"]), (Some(0), &0.into(), &found["map_from_slam"]));
    assert_eq!(align(&maps.path(), &slam, &["--storey", "7"]).0, Some(2));
    assert_eq!(found["covariance"].as_array().unwrap().len(), 9);
    assert_eq!(found["inputs"]["slam_sha256"].as_str().unwrap().len(), 64);
    let (transform, overlay) = (home.path().join("site_map.yaml"), home.path().join("overlay.png"));
    let files = ["--transform", transform.to_str().unwrap(), "--overlay", overlay.to_str().unwrap()];
    assert_eq!(align(&maps.path(), &slam, &files).0, Some(0));
    let text = std::fs::read_to_string(&transform).unwrap();
    let back = &found["slam_from_map"];
    assert!(text.contains(&format!("translation: {{x: {}, y: {},", back["x_m"], back["y_m"])), "{text} for {back}");
    assert!(std::fs::read(&overlay).unwrap().starts_with(b"\x89PNG"));
    let (code, other) = align(&localization(&maps, 1), &slam, &[]);
    assert_eq!((code, &other["map_from_slam"]), (Some(1), &Value::Null));
    assert_ne!(other["verdict"], "accepted");
    assert!(!other["reason"].as_str().unwrap().is_empty());
    let (_, hinted) = align(&localization(&maps, 0), &slam, &["--hint", "50", "50", "0"]);
    assert_ne!(hinted["verdict"], "accepted", "not where somebody says it is");
}

#[test]
fn a_map_that_cannot_be_read_is_bad_usage_and_says_which() {
    let home = tempfile::tempdir().unwrap();
    let missing = home.path().join("missing.yaml");
    let output = groundplan(&[&"align", &"--reference", &missing, &"--slam", &missing]);
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stderr).contains("missing.yaml"));
}
