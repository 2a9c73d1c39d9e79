//! `groundplan align` on files.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

use end_to_end::{Maps, assert_filter_frees_nothing, convert, demo_model, groundplan, turned_map};
use serde_json::Value;
use std::path::{Path, PathBuf};

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

#[test]
fn a_map_in_another_frame_is_found_on_its_storey_and_on_no_other() {
    let maps = convert(&demo_model(), &[]);
    let home = tempfile::tempdir().unwrap();
    let slam = turned_map(&maps, 0, home.path());
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
    let (code, wrong) = align(&maps.path(), &slam, &["--storey", "1"]);
    assert_eq!((code, wrong["verdict"].as_str()), (Some(1), Some("refused")), "{wrong}");
    assert!(wrong["reason"].as_str().unwrap().contains("where it cannot lie by the hints (storey 1)"), "{wrong}");
    assert_eq!(found["covariance"].as_array().unwrap().len(), 9);
    assert_eq!(found["inputs"]["slam_sha256"].as_str().unwrap().len(), 64);
    let (transform, overlay) = (home.path().join("site_map.yaml"), home.path().join("overlay.png"));
    let files = ["--transform", transform.to_str().unwrap(), "--overlay", overlay.to_str().unwrap()];
    assert_eq!(align(&maps.path(), &slam, &files).0, Some(0));
    let text = std::fs::read_to_string(&transform).unwrap();
    let back = &found["slam_from_map"];
    assert!(text.contains(&format!("translation: {{x: {}, y: {},", back["x_m"], back["y_m"])), "{text} for {back}");
    assert!(std::fs::read(&overlay).unwrap().starts_with(b"\x89PNG"));
    let moved = home.path().join("moved");
    assert_eq!(align(&maps.path(), &slam, &["--resample", moved.to_str().unwrap()]).0, Some(0));
    check_moved(&maps, &moved, &home.path().join("robot.pgm"));
    let (code, other) = align(&localization(&maps, 1), &slam, &[]);
    assert_eq!((code, &other["map_from_slam"]), (Some(1), &Value::Null));
    assert_ne!(other["verdict"], "accepted");
    assert!(!other["reason"].as_str().unwrap().is_empty());
    let (_, hinted) = align(&localization(&maps, 0), &slam, &["--hint", "50", "50", "0"]);
    assert_ne!(hinted["verdict"], "accepted", "not at the hint");
}

/// The maps that were moved into the robot's frame show what the robot's map shows.
fn check_moved(maps: &Maps, moved: &Path, robot: &Path) {
    let read = |path: &Path| grid::decode_pgm(&std::fs::read(path).unwrap()).unwrap();
    let yaml = std::fs::read_to_string(moved.join("planning.yaml")).unwrap();
    let origin: Vec<f64> = yaml.split(['[', ']']).nth(1).unwrap().split(", ").map(|n| n.parse().unwrap()).collect();
    let ((width, _, cells), (robot_width, robot_height, robots)) = (read(&moved.join("planning.pgm")), read(robot));
    let at =
        |x_m: f64, y_m: f64| cells[((y_m - origin[1]) / 0.05) as usize * width + ((x_m - origin[0]) / 0.05) as usize];
    let (mut n_free, mut n_walls, mut n_lost) = (0, 0, 0);
    for row in 3..robot_height - 3 {
        for column in 3..robot_width - 3 {
            let there = at(7.5 + (column as f64 + 0.5) * 0.05, -3.0 + (row as f64 + 0.5) * 0.05);
            let of_robot = robots[row * robot_width + column];
            n_free += u32::from(of_robot == grid::FREE && there == grid::FREE);
            n_walls += u32::from(of_robot == grid::OCCUPIED);
            n_lost += u32::from(of_robot == grid::OCCUPIED && there == grid::FREE);
        }
    }
    assert!(n_free > 10_000 && n_walls > 1_000 && n_lost == 0, "{n_free} free, {n_walls} walls, {n_lost} lost");
    assert_filter_frees_nothing(&cells, &read(&moved.join("keepout.pgm")).2);
    let waypoints: Value = serde_json::from_slice(&std::fs::read(moved.join("waypoints.json")).unwrap()).unwrap();
    let all = maps.json("waypoints.json");
    let of_storey = all["waypoints"].as_array().unwrap().iter().filter(|w| w["storey"] == 0).count();
    let waypoints = waypoints["waypoints"].as_array().unwrap();
    assert_eq!(waypoints.len(), of_storey);
    for w in waypoints {
        assert_eq!(at(w["x_m"].as_f64().unwrap(), w["y_m"].as_f64().unwrap()), grid::FREE, "{w}");
    }
}

#[test]
fn evidence_of_looks_goes_on_from_file_to_file_and_tells_what_was_withdrawn() {
    let maps = convert(&demo_model(), &[]);
    let home = tempfile::tempdir().unwrap();
    let slam = turned_map(&maps, 0, home.path());
    let evidence = home.path().join("drive");
    let more = ["--evidence", evidence.to_str().unwrap()];
    let (code, first) = align(&maps.path(), &slam, &more);
    assert_eq!((code, &first["change"]), (Some(0), &Value::Null), "{first}");
    let before = std::fs::read(&evidence).unwrap();
    let (code, again) = align(&maps.path(), &slam, &more);
    assert_eq!((code, &again["map_from_slam"]), (Some(0), &first["map_from_slam"]));
    assert_eq!(std::fs::read(&evidence).unwrap(), before, "nothing is new");
    // The walls of the map are gone.
    let pgm = slam.with_extension("pgm");
    let (width, _, mut pixels) = grid::decode_pgm(&std::fs::read(&pgm).unwrap()).unwrap();
    pixels.iter_mut().filter(|pixel| **pixel == grid::OCCUPIED).for_each(|pixel| *pixel = grid::FREE);
    std::fs::write(&pgm, grid::encode_pgm(width, &pixels)).unwrap();
    let (code, gone) = align(&maps.path(), &slam, &more);
    assert_eq!((code, gone["verdict"].as_str()), (Some(1), Some("refused")), "{gone}");
    assert!(gone["change"].as_str().is_some_and(|change| change.contains("withdrawn: storey 0")), "{gone}");
    std::fs::write(&evidence, "of a person").unwrap();
    assert_eq!(align(&maps.path(), &slam, &more).0, Some(2));
    assert_eq!(std::fs::read(&evidence).unwrap(), b"of a person");
}

#[test]
fn waypoints_are_carried_to_where_they_lie_in_the_robots_map() {
    let model = demo_model();
    let maps = convert(&model, &[]);
    let home = tempfile::tempdir().unwrap();
    let slam = turned_map(&maps, 0, home.path());
    let (_, found) = align(&localization(&maps, 0), &slam, &[]);
    let (waypoints, out) = (maps.path().join("waypoints.json"), home.path().join("deviations"));
    let done = groundplan(&[&"deviations", &model, &"--slam", &slam, &"-o", &out, &"--goals", &waypoints]);
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    let read = |path: &Path| serde_json::from_slice::<Value>(&std::fs::read(path).unwrap()).unwrap();
    let pose = |of: &Value| ["x_m", "y_m", "yaw_rad"].map(|key| of[key].as_f64().unwrap());
    let slam_from_map: frames::Rigid2<frames::Slam, frames::Map> =
        frames::Rigid2::of_x_y_yaw(pose(&found["slam_from_map"]));
    let goals = read(&out.join("goals.json"));
    let planned = read(&waypoints);
    let n_planned = planned["waypoints"].as_array().unwrap().iter().filter(|w| w["storey"] == 0).count();
    assert_eq!((goals["storey"].as_u64(), goals["goals"].as_array().map(Vec::len)), (Some(0), Some(n_planned)));
    for goal in goals["goals"].as_array().unwrap() {
        let ([x, y, yaw], [x_slam, y_slam, yaw_slam]) = (pose(&goal["map"]), pose(&goal["slam"]));
        let [x_expected, y_expected] = slam_from_map.apply([x, y]);
        // The robot's map is that of the model, turned: nothing in it is bent.
        assert!((x_slam - x_expected).hypot(y_slam - y_expected) < 0.05, "{goal}");
        assert!(frames::wrapped(yaw_slam - yaw - slam_from_map.yaw_rad()).abs() < 0.02, "{goal}");
        assert!(pose(&goal["deviation"]).iter().all(|deviation| (0.0..0.2).contains(deviation)), "{goal}");
    }
    let missing = groundplan(&[&"deviations", &model, &"--slam", &slam, &"-o", &out, &"--goals", &"no.json"]);
    assert_eq!(missing.status.code(), Some(2), "{}", String::from_utf8_lossy(&missing.stderr));
    assert_eq!(read(&out.join("goals.json")), goals, "what was there stays");
}

#[test]
fn lengths_that_are_wrong_are_found_when_nobody_vouches_for_them() {
    let maps = convert(&demo_model(), &[]);
    let home = tempfile::tempdir().unwrap();
    let slam = turned_map(&maps, 0, home.path());
    let text = std::fs::read_to_string(&slam).unwrap();
    std::fs::write(&slam, text.replace("resolution: 0.05", "resolution: 0.055")).unwrap();
    assert_ne!(align(&maps.path(), &slam, &[]).1["verdict"], "accepted", "10 % are not absorbed");
    let (code, found) = align(&maps.path(), &slam, &["--free-scale"]);
    let scale = found["scale"].as_f64().unwrap();
    assert!(code == Some(0) && (scale - 1.1).abs() < 0.003, "{found}");
    std::fs::write(&slam, text.replace("resolution: 0.05", "resolution: 0.0502")).unwrap();
    let (_, found) = align(&maps.path(), &slam, &[]);
    let scale = found["scale"].as_f64().unwrap();
    // The walls of the lift shaft have one side on the localization map, and two on the robot's.
    assert!((scale - 1.004).abs() < 0.003, "{found}");
    std::fs::write(&slam, text.replace("resolution: 0.05", "resolution: 0.051")).unwrap();
    let (_, found) = align(&maps.path(), &slam, &[]);
    assert_eq!(found["verdict"], "accepted", "{found}");
    // The building is 24 m long: 2 % of half of it.
    let off_m = found["off_by_scale_m"].as_f64().unwrap();
    assert!((0.15..0.35).contains(&off_m), "{found}");
    let told = groundplan(&[&"align", &"--reference", &maps.path(), &"--slam", &slam]);
    let told = String::from_utf8_lossy(&told.stdout);
    assert!(
        told.contains(&format!("{off_m:.2} m off at the ends of the map")) && told.contains("--free-scale"),
        "{told}"
    );
}

#[test]
fn a_map_that_cannot_be_read_is_bad_usage_and_says_which() {
    let home = tempfile::tempdir().unwrap();
    let missing = home.path().join("missing.yaml");
    let output = groundplan(&[&"align", &"--reference", &missing, &"--slam", &missing]);
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stderr).contains("missing.yaml"));
}

#[test]
fn a_model_or_a_picture_in_place_of_a_map_is_refused_with_what_to_give_instead() {
    let home = tempfile::tempdir().unwrap();
    let [picture, map] = ["robot.pgm", "robot.yaml"].map(|name| home.path().join(name));
    std::fs::write(&picture, b"P5 2 2 255\n\xfe\xfe\x00\x00").unwrap();
    std::fs::write(&map, "image: robot.pgm\nresolution: 0.05\norigin: [0, 0, 0]\n").unwrap();
    let why = |reference: &Path, slam: &Path| {
        let output = groundplan(&[&"align", &"--reference", &reference, &"--slam", &slam]);
        assert_eq!(output.status.code(), Some(2));
        String::from_utf8_lossy(&output.stderr).into_owned()
    };
    let model = why(&demo_model(), &map);
    assert!(model.contains("a building model (IFC), not a map") && model.contains("groundplan convert"), "{model}");
    let of_picture = why(&map, &picture);
    assert!(of_picture.contains("a picture, not the description of a map: give the .yaml file"), "{of_picture}");
}

/// The output of `convert` with the ground floor's map also on the upper floor, and a robot's map of its western half. The maps
/// differ by a wall in the Director's office, if there is to be one.
fn twin_storeys(maps: &Maps, home: &Path, has_wall: bool) -> [PathBuf; 2] {
    let twins = home.join("twins");
    let folder = |storey: usize| twins.join(maps.manifest["storeys"][storey]["directory"].as_str().unwrap());
    for storey in [0, 1] {
        std::fs::create_dir_all(folder(storey)).unwrap();
        for file in ["localization.yaml", "localization.pgm"] {
            std::fs::copy(localization(maps, 0).with_file_name(file), folder(storey).join(file)).unwrap();
        }
    }
    std::fs::copy(maps.path().join("semantic.json"), twins.join("semantic.json")).unwrap();
    let mut manifest = maps.manifest.clone();
    manifest["storeys"].as_array_mut().unwrap().truncate(2);
    std::fs::write(twins.join("manifest.json"), manifest.to_string()).unwrap();
    let path = folder(1).join("localization.pgm");
    let (width, _, pixels) = grid::decode_pgm(&std::fs::read(&path).unwrap()).unwrap();
    let origin = [0, 1].map(|k| maps.manifest["storeys"][0]["origin_m"][k].as_f64().unwrap());
    let at = |k: usize| [0, 1].map(|axis| origin[axis] + ([k % width, k / width][axis] as f64 + 0.5) * 0.05);
    let wall = |k: usize| {
        let [x, y] = at(k);
        if has_wall && (19.5..21.0).contains(&x) && (12.0..12.2).contains(&y) { grid::OCCUPIED } else { pixels[k] }
    };
    let write = |path: &Path, pixel: &dyn Fn(usize) -> u8| {
        let pixels: Vec<u8> = (0..pixels.len()).map(pixel).collect();
        std::fs::write(path, grid::encode_pgm(width, &pixels)).unwrap();
    };
    write(&path, &wall);
    let seen = |k: usize| if at(k)[0] < 14.0 { pixels[k] } else { grid::UNKNOWN };
    write(&home.join("robot.pgm"), &seen);
    let slam = home.join("robot.yaml");
    std::fs::write(&slam, "image: robot.pgm\nresolution: 0.05\norigin: [0.0, 0.0, 0.0]\nnegate: 0\n").unwrap();
    [twins, slam]
}

#[test]
fn twin_storeys_are_told_apart_by_a_drive_or_by_a_hint_and_a_wrong_hint_accepts_nothing() {
    let maps = convert(&demo_model(), &[]);
    let home = tempfile::tempdir().unwrap();
    let [twins, slam] = twin_storeys(&maps, home.path(), true);
    let (code, found) = align(&twins, &slam, &[]);
    assert_eq!((code, found["verdict"].as_str()), (Some(1), Some("ambiguous")), "{found}");
    let reason = found["reason"].as_str().unwrap();
    // Which of the twins comes first nothing tells.
    let ways = ["G.15 of storey 0 or U.10 of storey 1", "U.10 of storey 1 or G.15 of storey 0"];
    assert!(ways.iter().any(|way| reason.contains(&format!("drive through {way} (x "))), "{reason}");
    let place = &found["decide"]["places"][0];
    let mut rooms = [0, 1].map(|k| place["candidates"][k]["room"]["long_name"].as_str().unwrap());
    rooms.sort_unstable();
    assert_eq!(rooms, ["Board room", "Director's office"]);
    assert!(place["in_slam"]["x_m"].as_f64().unwrap() > 15.0, "the robot saw what lies west of it: {place}");
    // The robot's map has its corner where that of the model has it, outside; at x 7 m and y 5 m it shows room G.02.
    let pose = home.path().join("amcl.yaml");
    let hint = ["--at", "7", "5", "G.02", "--initial-pose", pose.to_str().unwrap(), "--robot", "7", "5", "90"];
    let (code, found) = align(&twins, &slam, &hint);
    assert_eq!((code, &found["storey"], &found["hints"][0]["excluded"]), (Some(0), &0.into(), &1.into()), "{found}");
    let text = std::fs::read_to_string(&pose).unwrap();
    assert!(text.contains("set_initial_pose: true") && text.contains("yaw: 1.57"), "{text}");
    let (code, found) = align(&twins, &slam, &["--storey", "0"]);
    let claim = [&found["storey_claim"], &found["storeys_alike"]];
    assert_eq!((code, claim), (Some(0), [&"given".into(), &serde_json::json!([1])]), "{found}");
    let (code, found) = align(&twins, &slam, &["--elevation", "3"]);
    assert_eq!((code, &found["storey"], &found["decide"]), (Some(0), &1.into(), &Value::Null), "{found}");
    assert_eq!(
        (&found["storey_claim"], &found["storeys_alike"]),
        (&"given".into(), &serde_json::json!([0])),
        "{found}"
    );
    let (code, found) = align(&twins, &slam, &["--start-room", "G.02", "--initial-pose", pose.to_str().unwrap()]);
    assert_eq!((code, found["verdict"].as_str()), (Some(1), Some("refused")), "{found}");
    assert!(!pose.exists() && home.path().join("amcl.yaml.stale").exists());
    for (arguments, words) in [
        (["--start-room", "G.99"], "there is no room \"G.99\"; nearest: \"G.09\""),
        (["--elevation", "9"], "no storey has its floor within"),
        (["--portal", "G.stairs"], "nearest: \"G.stair\""),
    ] {
        let output = groundplan(&[&"align", &"--reference", &twins, &"--slam", &slam, &arguments[0], &arguments[1]]);
        let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.code() == Some(2) && stderr.contains(words), "{stderr}");
    }
    let [twins, slam] = twin_storeys(&maps, home.path(), false);
    let (_, found) = align(&twins, &slam, &[]);
    assert!(found["reason"].as_str().unwrap().contains("nothing in the model that the robot can reach"), "{found}");
    assert_eq!(found["decide"]["undecided"], serde_json::json!([[0, 1]]));
}
