//! `groundplan align` on maps that are bent, mirrored, grey or negated, and what it says about the storey.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

use end_to_end::{Maps, convert, demo_model, groundplan, turned_map};
use occupancy::{Cell, OccupancyMap};
use serde_json::Value;
use std::ffi::OsStr;
use std::path::Path;

fn align(reference: &Path, slam: &Path, more: &[&str]) -> (Option<i32>, Value) {
    let mut arguments: Vec<&dyn AsRef<OsStr>> = vec![&"align", &"--reference", &reference, &"--slam", &slam, &"--json"];
    arguments.extend(more.iter().map(|a| a as &dyn AsRef<OsStr>));
    let output = groundplan(&arguments);
    (output.status.code(), serde_json::from_slice(&output.stdout).unwrap_or_default())
}

fn text(reference: &Path, slam: &Path) -> String {
    let output = groundplan(&[&"align", &"--reference", &reference, &"--slam", &slam]);
    String::from_utf8_lossy(&output.stdout).into_owned()
}

/// Rewrites the image of a map: `moved` says from which column and row a pixel comes.
fn redraw(slam: &Path, moved: impl Fn(usize, usize) -> [i64; 2], changed: impl Fn(u8) -> u8) {
    let pgm = slam.with_extension("pgm");
    let (width, height, pixels) = grid::decode_pgm(&std::fs::read(&pgm).unwrap()).unwrap();
    let pixel = |at: usize| {
        let [column, row] = moved(at % width, at / width);
        let inside = (0..width as i64).contains(&column) && (0..height as i64).contains(&row);
        changed(if inside { pixels[row as usize * width + column as usize] } else { grid::UNKNOWN })
    };
    let redrawn: Vec<u8> = (0..pixels.len()).map(pixel).collect();
    std::fs::write(&pgm, grid::encode_pgm(width, &redrawn)).unwrap();
}

/// Where the planning map of a storey begins, in cells.
fn origin_cells(maps: &Maps, storey: usize) -> [i64; 2] {
    let directory = maps.manifest["storeys"][storey]["directory"].as_str().unwrap();
    let map = OccupancyMap::read(&maps.path().join(directory).join("planning.yaml")).unwrap();
    [map.origin[0], map.origin[1]].map(|metres| (metres / map.resolution_m).round() as i64)
}

fn same(column: usize, row: usize) -> [i64; 2] {
    [column as i64, row as i64]
}

fn replace(slam: &Path, from: &str, to: &str) {
    let text = std::fs::read_to_string(slam).unwrap();
    assert!(text.contains(from), "{text}");
    std::fs::write(slam, text.replace(from, to)).unwrap();
}

fn robots_map(home: &Path) -> (Maps, std::path::PathBuf) {
    let maps = convert(&demo_model(), &[]);
    let slam = turned_map(&maps, 0, home);
    (maps, slam)
}

/// Where a pixel of a map whose lower half bends on a circle of 140 m comes from.
fn unbent([column, row]: [usize; 2], [width, height]: [usize; 2]) -> [i64; 2] {
    let radius_px = 140.0 / 0.05;
    let (x, y) = (column as f64 + 0.5 - width as f64 / 2.0, height as f64 / 2.0 - (row as f64 + 0.5));
    if y <= 0.0 {
        return same(column, row);
    }
    // The length of the arc to the point beside which the pixel lies.
    let aside = |length: f64| (x - length * length / (2.0 * radius_px), y - length);
    let length = (0..20).fold(y, |length, _| {
        let ((sin, cos), (dx, dy)) = (libm::sincos(length / radius_px), aside(length));
        (length + dx * sin + dy * cos).max(0.0)
    });
    let ((sin, cos), (dx, dy)) = (libm::sincos(length / radius_px), aside(length));
    let from = [dx * cos - dy * sin + width as f64 / 2.0, height as f64 / 2.0 - length];
    from.map(|c| c.floor() as i64)
}

/// Turns the lower half of a map to one side on a circle of 140 m: 0.6 m off and five degrees at its end. Its size in pixels.
fn bend(slam: &Path) -> [usize; 2] {
    let (width, height, _) = grid::decode_pgm(&std::fs::read(slam.with_extension("pgm")).unwrap()).unwrap();
    redraw(slam, |column, row| unbent([column, row], [width, height]), |pixel| pixel);
    [width, height]
}

/// Middles of the occupied cells of a map, in metres.
fn occupied_m(map: &OccupancyMap) -> Vec<[f64; 2]> {
    let frame = frames::Rigid2::<frames::Slam, frames::Slam>::of_x_y_yaw(map.origin);
    let cells = map.cells.iter().enumerate().filter(|(_, cell)| **cell == Cell::Occupied);
    let place = |k: usize| [k % map.width, k / map.width].map(|n| (n as f64 + 0.5) * map.resolution_m);
    cells.map(|(k, _)| frame.apply(place(k))).collect()
}

#[test]
fn maps_in_the_robots_frame_bend_as_its_map_does() {
    let home = tempfile::tempdir().unwrap();
    let (maps, slam) = robots_map(home.path());
    bend(&slam);
    let folder = home.path().join("in_slam");
    align(&maps.path(), &slam, &["--resample", folder.to_str().unwrap()]);
    let [robots, moved] =
        [&slam, &folder.join("planning.yaml")].map(|path| occupied_m(&OccupancyMap::read(path).unwrap()));
    let near = |place: &[f64; 2]| moved.iter().any(|wall| (wall[0] - place[0]).hypot(wall[1] - place[1]) < 0.11);
    // Every fifth is enough, and one pose for all of them met two thirds.
    let walls: Vec<&[f64; 2]> = robots.iter().step_by(5).collect();
    let n_met = walls.iter().filter(|place| near(place)).count();
    assert!(n_met as f64 > 0.95 * walls.len() as f64, "{n_met} of {} walls are where the robot has them", walls.len());
    let manifest: Value = serde_json::from_slice(&std::fs::read(folder.join("manifest.json")).unwrap()).unwrap();
    assert!(manifest["bends_m"].as_f64().unwrap() > 0.2, "{manifest}");
}

#[test]
fn a_bend_of_the_map_displaces_no_elements() {
    let home = tempfile::tempdir().unwrap();
    let (_, slam) = robots_map(home.path());
    bend(&slam);
    let output = groundplan(&[&"deviations", &demo_model(), &"--slam", &slam, &"--json"]);
    let found: Value = serde_json::from_slice(&output.stdout).unwrap();
    let n = |observation: &str| found["observations"][observation].as_u64().unwrap();
    let residual_m = found["residual_rms_m"].as_f64().unwrap();
    assert!(residual_m > 0.1, "the bend is told: {residual_m}");
    assert!(n("observed") > 30 && n("displaced") + n("absent") == 0, "{}", found["observations"]);
}

#[test]
fn a_bent_map_may_be_used_where_the_robot_is_known_to_be_and_nowhere_else() {
    let home = tempfile::tempdir().unwrap();
    let (maps, slam) = robots_map(home.path());
    let (_, straight) = align(&maps.path(), &slam, &[]);
    assert!(straight["holds"]["share_of_walls"].as_f64().unwrap() > 0.9, "{}", straight["holds"]);
    let [width, height] = bend(&slam);
    let transform = home.path().join("site_map.yaml");
    let (code, found) = align(&maps.path(), &slam, &["--transform", transform.to_str().unwrap()]);
    assert_eq!(
        (found["verdict"].as_str(), found["validity"].as_str()),
        (Some("accepted"), Some("uncertain")),
        "{found}"
    );
    assert!(code == Some(1) && !transform.exists());
    let holds = &found["holds"];
    assert!(holds["share_of_walls"].as_f64().unwrap() < 0.9 && holds["anywhere_m"].as_f64().unwrap() > 0.1, "{holds}");
    assert!(!holds["outline_in_slam_m"].as_array().unwrap().is_empty());
    assert!(text(&maps.path(), &slam).contains("may be used only where the robot is"));
    // Free cells of the map at its straight end and in the bend: where they lie by the straight map is the truth.
    let pose = |of: &Value| ["x_m", "y_m", "yaw_rad"].map(|key| of[key].as_f64().unwrap());
    let truth: frames::Rigid2<frames::Map, frames::Slam> = frames::Rigid2::of_x_y_yaw(pose(&straight["map_from_slam"]));
    let (_, _, pixels) = grid::decode_pgm(&std::fs::read(slam.with_extension("pgm")).unwrap()).unwrap();
    let metres = |column: i64, row: i64| [7.5 + (column as f64 + 0.5) * 0.05, -3.0 + (row as f64 + 0.5) * 0.05];
    let (mut n_used, mut wrong) = (0, Vec::new());
    for row in (height / 8..height).step_by(height / 12) {
        let free: Vec<usize> = (0..width).filter(|column| pixels[row * width + column] == grid::FREE).collect();
        let Some(&column) = free.get(free.len() / 2) else { continue };
        let (robot, [from_column, from_row]) =
            (metres(column as i64, row as i64), unbent([column, row], [width, height]));
        let [x, y] = robot.map(|c| c.to_string());
        let (code, there) = align(&maps.path(), &slam, &["--robot", &x, &y]);
        let Some(map_from_slam) = there.get("map_from_slam").filter(|_| code == Some(0)) else { continue };
        let local: frames::Rigid2<frames::Map, frames::Slam> = frames::Rigid2::of_x_y_yaw(pose(map_from_slam));
        let ([x_m, y_m], expected) = (local.apply(robot), truth.apply(metres(from_column, from_row)));
        let off_m = (x_m - expected[0]).hypot(y_m - expected[1]);
        let deviation_m = |k: usize| there["covariance"][k].as_f64().unwrap().sqrt();
        if off_m >= (3.0 * deviation_m(0).max(deviation_m(4))).max(0.15) {
            wrong.push((robot, off_m));
        }
        n_used += 1;
    }
    assert!(n_used >= 5 && wrong.is_empty(), "of {n_used} places that may be used: {wrong:?}");
}

#[test]
fn a_mirrored_map_is_told() {
    let home = tempfile::tempdir().unwrap();
    let (maps, slam) = robots_map(home.path());
    let (width, _, _) = grid::decode_pgm(&std::fs::read(slam.with_extension("pgm")).unwrap()).unwrap();
    redraw(&slam, |column, row| [(width - 1 - column) as i64, row as i64], |pixel| pixel);
    let (code, found) = align(&maps.path(), &slam, &[]);
    assert_eq!((code, found["verdict"].as_str()), (Some(1), Some("refused")), "{found}");
    assert!(found["reason"].as_str().unwrap().contains("left and right exchanged"), "{found}");
}

#[test]
fn a_map_of_two_storeys_is_told() {
    let home = tempfile::tempdir().unwrap();
    let (maps, slam) = robots_map(home.path());
    // The robot took the lift: a part of the upper floor lies over the ground floor.
    let home_above = tempfile::tempdir().unwrap();
    let above = turned_map(&maps, 1, home_above.path());
    let read = |slam: &Path| grid::decode_pgm(&std::fs::read(slam.with_extension("pgm")).unwrap()).unwrap();
    let ((width, height, mut pixels), (width_above, _, above)) = (read(&slam), read(&above));
    // Columns of a turned map go along y, rows along x.
    let [[x, y], [x_above, y_above]] = [0, 1].map(|storey| origin_cells(&maps, storey));
    for (at, pixel) in above.into_iter().enumerate().filter(|(_, pixel)| *pixel != grid::UNKNOWN) {
        let column = at as i64 % width_above as i64 + y_above - y;
        let row = at as i64 / width_above as i64 + x_above - x;
        if (0..width as i64).contains(&column) && (height as i64 / 2..height as i64).contains(&row) {
            pixels[row as usize * width + column as usize] = pixel;
        }
    }
    std::fs::write(slam.with_extension("pgm"), grid::encode_pgm(width, &pixels)).unwrap();
    let (_, found) = align(&maps.path(), &slam, &[]);
    let reason = found["reason"].as_str().unwrap();
    assert!(reason.contains("storey 1") && reason.contains("storey 0") && reason.contains("a map for each"), "{found}");
    assert!(text(&maps.path(), &slam).contains(reason));
}

#[test]
fn a_grey_map_is_told_what_thresholds_it_needs_and_has_its_pose_with_them() {
    let home = tempfile::tempdir().unwrap();
    let (maps, slam) = robots_map(home.path());
    let (_, sharp) = align(&maps.path(), &slam, &[]);
    let grey = |pixel: u8| match pixel {
        grid::OCCUPIED => 100,
        grid::FREE => 190,
        other => other,
    };
    redraw(&slam, same, grey);
    replace(&slam, "negate: 0", "negate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196");
    let (code, found) = align(&maps.path(), &slam, &[]);
    assert_eq!(code, Some(1));
    assert!(found["reason"].as_str().unwrap().contains("set occupied_thresh: 0.5 and free_thresh: 0.49"), "{found}");
    replace(&slam, "occupied_thresh: 0.65\nfree_thresh: 0.196", "occupied_thresh: 0.5\nfree_thresh: 0.49");
    assert_eq!(align(&maps.path(), &slam, &[]).1["map_from_slam"], sharp["map_from_slam"]);
}

#[test]
fn a_negated_map_is_the_same_map() {
    let home = tempfile::tempdir().unwrap();
    let (maps, slam) = robots_map(home.path());
    let (code, found) = align(&maps.path(), &slam, &[]);
    redraw(&slam, same, |pixel| 255 - pixel);
    replace(&slam, "negate: 0", "negate: 1");
    let (negated_code, negated) = align(&maps.path(), &slam, &[]);
    assert_eq!((negated_code, &negated["map_from_slam"]), (code, &found["map_from_slam"]));
    assert_eq!(negated["holds"], found["holds"]);
}

#[test]
fn the_storey_is_tested_given_or_not_tested_and_the_answer_says_which() {
    let home = tempfile::tempdir().unwrap();
    let (maps, slam) = robots_map(home.path());
    let folder = maps.path().join(maps.manifest["storeys"][0]["directory"].as_str().unwrap());
    let claim = |reference: &Path, more: &[&str]| {
        let (code, found) = align(reference, &slam, more);
        (code, found["storey"].clone(), found["storey_claim"].as_str().unwrap().to_owned())
    };
    assert_eq!(claim(&maps.path(), &[]), (Some(0), 0.into(), "tested".to_owned()));
    assert_eq!(claim(&maps.path(), &["--storey", "0"]), (Some(0), 0.into(), "given".to_owned()));
    assert_eq!(claim(&folder.join("localization.yaml"), &[]), (Some(0), 0.into(), "given".to_owned()));
    for name in ["localization.yaml", "localization.pgm"] {
        std::fs::copy(folder.join(name), home.path().join(name)).unwrap();
    }
    let alone = home.path().join("localization.yaml");
    assert_eq!(claim(&alone, &[]), (Some(0), Value::Null, "not_tested".to_owned()));
    assert!(text(&alone, &slam).contains("storey not tested"));
}
