//! Logs of drives for programs that do SLAM (`slam-pairs logs`), as files.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

use occupancy::{Cell, OccupancyMap};
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::Path;
use std::process::{Command, Output};

fn slam_pairs(arguments: &[&str], folder: &Path) -> Output {
    Command::new(env!("CARGO_BIN_EXE_slam-pairs")).args(arguments).current_dir(folder).output().unwrap()
}

/// A folder with the logs of four drives in two buildings, in `out`.
fn logs(arguments: &[&str]) -> tempfile::TempDir {
    let home = tempfile::tempdir().unwrap();
    assert!(slam_pairs(&["plans", "plans", "--count", "2", "--seed", "3"], home.path()).status.success());
    let done = slam_pairs(&[&["logs", "out", "plans", "--count", "4"], arguments].concat(), home.path());
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    home
}

fn drives(out: &Path) -> Vec<Value> {
    let text = std::fs::read_to_string(out.join("drives.jsonl")).unwrap();
    text.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

/// Poses of a file: x, y, yaw.
fn true_poses(path: &Path) -> Vec<[f64; 3]> {
    let text = std::fs::read_to_string(path).unwrap();
    let mut lines = text.lines();
    assert_eq!(lines.next(), Some("true_x_m,true_y_m,true_yaw_rad"));
    let pose = |line: &str| -> [f64; 3] {
        line.split(',').map(|word| word.parse().unwrap()).collect::<Vec<f64>>().try_into().unwrap()
    };
    lines.map(pose).collect()
}

/// A message of a log.
struct Message {
    first_rad: f64,
    step_rad: f64,
    max_range_m: f64,
    ranges_m: Vec<f64>,
    odometry: [f64; 3],
}

fn messages(path: &Path) -> Vec<Message> {
    let text = std::fs::read_to_string(path).unwrap();
    let message = |line: &str| {
        let number: Vec<f64> = line.split(' ').skip(1).map_while(|word| word.parse().ok()).collect();
        let n = number[7] as usize;
        let odometry = number[8 + n + 4..][..3].try_into().unwrap();
        let [first_rad, step_rad, max_range_m] = [1, 3, 4].map(|k| number[k]);
        Message { first_rad, step_rad, max_range_m, ranges_m: number[8..8 + n].to_vec(), odometry }
    };
    text.lines().filter(|line| line.starts_with("ROBOTLASER1 ")).map(message).collect()
}

fn is_near_wall(map: &OccupancyMap, [x, y]: [f64; 2]) -> bool {
    let height = map.cells.len() / map.width;
    let cell = [x - map.origin[0], y - map.origin[1]].map(|c| (c / map.resolution_m).floor() as isize);
    let around = (-2..=2).flat_map(|dy| (-2..=2).map(move |dx| [cell[0] + dx, cell[1] + dy]));
    around.into_iter().any(|[column, row]| {
        let is_inside = 0 <= column && column < map.width as isize && 0 <= row && row < height as isize;
        is_inside && map.cells[row as usize * map.width + column as usize] == Cell::Occupied
    })
}

#[test]
fn beams_of_a_log_end_at_walls_of_the_model_where_the_robot_truly_was() {
    let home = logs(&["--clutter", "low", "--max-way", "25"]);
    let out = home.path().join("out");
    let drives = drives(&out);
    assert_eq!(drives.len(), 4);
    for drive in &drives {
        let name = drive["drive"].as_str().unwrap();
        let (messages, poses) =
            (messages(&out.join(format!("{name}.log"))), true_poses(&out.join(format!("{name}-true.csv"))));
        assert_eq!((messages.len(), poses.len()), (poses.len(), drive["scans"].as_u64().unwrap() as usize));
        let map = OccupancyMap::read(&out.join(format!("{name}-reference.yaml"))).unwrap();
        let (mut n, mut n_near) = (0, 0);
        for (message, [x, y, yaw]) in messages.iter().zip(&poses) {
            for (k, range) in
                message.ranges_m.iter().enumerate().filter(|(_, r)| 0.0 < **r && **r < message.max_range_m)
            {
                let (sin, cos) = libm::sincos(yaw + message.first_rad + message.step_rad * k as f64);
                n += 1;
                n_near += usize::from(is_near_wall(&map, [x + range * cos, y + range * sin]));
            }
        }
        assert!(n > 1000 && n_near * 10 > n * 6, "{name}: {n_near} of {n} beams end near a wall of the model");
    }
}

#[test]
fn the_odometry_of_a_log_drifts_and_starts_at_its_origin() {
    let home = logs(&["--max-way", "40"]);
    let out = home.path().join("out");
    for drive in &drives(&out) {
        let name = drive["drive"].as_str().unwrap();
        let drift = drive["odometry_drift"].as_f64().unwrap();
        assert!((0.01..=0.05).contains(&drift) && drive["way_m"].as_f64().unwrap() <= 40.0, "{drive}");
        let messages = messages(&out.join(format!("{name}.log")));
        assert!(messages[0].odometry == [0.0; 3]);
        let poses = true_poses(&out.join(format!("{name}-true.csv")));
        let way = |poses: &[[f64; 3]]| {
            poses.windows(2).map(|p| libm::hypot(p[1][0] - p[0][0], p[1][1] - p[0][1])).sum::<f64>()
        };
        let counted: Vec<[f64; 3]> = messages.iter().map(|m| m.odometry).collect();
        let ratio = way(&counted) / way(&poses);
        assert!((0.9..1.1).contains(&ratio) && (ratio - 1.0).abs() > 1e-9, "{name}: {ratio} of the way");
        let turns = poses.windows(2).map(|p| (p[1][2] - p[0][2] + 9.0 * std::f64::consts::PI) % std::f64::consts::TAU);
        let most = turns.map(|turn| (turn - std::f64::consts::PI).abs()).fold(0.0, f64::max);
        assert!(most <= 0.5 + 1e-6, "{name}: a turn of {most} rad between two scans");
    }
}

#[test]
fn the_same_seed_gives_the_same_logs() {
    let files = |seed: &str| -> BTreeMap<String, Vec<u8>> {
        let home = logs(&["--seed", seed, "--max-way", "10"]);
        let entries = std::fs::read_dir(home.path().join("out")).unwrap().map(|entry| entry.unwrap().path());
        entries.map(|p| (p.file_name().unwrap().to_string_lossy().into_owned(), std::fs::read(&p).unwrap())).collect()
    };
    let (one, two, other) = (files("5"), files("5"), files("6"));
    assert_eq!(one, two);
    assert_eq!(one.len(), 1 + 4 * 4);
    assert_ne!(one["drives.jsonl"], other["drives.jsonl"]);
}
