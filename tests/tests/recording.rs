//! The construction as a recording, read with MCAP's own reader for ROS 2.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

use end_to_end::live::Live;
use end_to_end::{announce, client, demo_model, files_in, groundplan, root};
use serde_json::Value;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Command, Stdio};

/// Topics of a storey.
const N_TOPICS: usize = 7;

fn run(arguments: &[&str], recording: &Path) -> (Option<i32>, String) {
    let model = demo_model();
    let mut all: Vec<&dyn AsRef<std::ffi::OsStr>> = vec![&"convert", &model, &"--mcap", &recording];
    all.extend(arguments.iter().map(|a| a as &dyn AsRef<std::ffi::OsStr>));
    let output = groundplan(&all);
    (output.status.code(), String::from_utf8_lossy(&[output.stderr, output.stdout].concat()).into_owned())
}

/// What the script counted in a recording; `None`, and a loud word, where it cannot run.
fn checked(recording: &Path, out: &Path) -> Option<Value> {
    let packages = ["mcap==1.6.0", "mcap-ros2-support==0.6.0", "numpy"];
    let made = Command::new(root().join("scripts/python-env")).args(packages).output().unwrap();
    if !made.status.success() {
        announce(&format!("SKIPPED: mcap cannot be installed: {}", String::from_utf8_lossy(&made.stderr)));
        return None;
    }
    let mut check = Command::new(root().join("target/venv/bin/python"));
    let output = check.arg(root().join("scripts/check_recording.py")).arg(recording).arg(out).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    Some(serde_json::from_slice(&output.stdout).unwrap())
}

#[test]
fn a_recording_has_the_maps_of_every_change() {
    let home = tempfile::tempdir().unwrap();
    let (recording, out) = (home.path().join("demo.mcap"), home.path().join("out"));
    let arguments = ["--resolution", "0.1", "--date", "all", "-o", out.to_str().unwrap()];
    let (code, text) = run(&arguments, &recording);
    assert_eq!(code, Some(0), "{text}");
    assert!(text.contains(&format!("{} and {} written", out.display(), recording.display())), "{text}");
    let Some(counted) = checked(&recording, &out) else { return };
    let dates = &serde_json::from_slice::<Value>(&std::fs::read(out.join("manifest.json")).unwrap()).unwrap()["dates"];
    let n_dates = dates.as_array().unwrap().len();
    assert!(n_dates > 20, "{n_dates}");
    assert_eq!(counted["change_instants"], n_dates);
    let topics = counted["topics"].as_object().unwrap();
    // Two floors, the loading dock and the yard.
    assert_eq!(topics.len(), 4 * N_TOPICS + 1, "{topics:?}");
    assert_eq!(topics["/tf_static"], 1);
    assert!(topics.iter().all(|(topic, n)| topic == "/tf_static" || *n == n_dates), "{topics:?}");
    assert!(counted["cells"].as_u64() > Some(1_000_000) && counted["markers"].as_u64() > Some(1_000), "{counted}");
}

#[test]
fn one_storey_has_the_topics_that_nav2_asks_for_and_no_folder_is_needed() {
    let home = tempfile::tempdir().unwrap();
    let (recording, out) = (home.path().join("demo.mcap"), home.path().join("out"));
    let arguments = ["--resolution", "0.2", "--date", "all", "--storeys", "0"];
    let (code, text) = run(&arguments, &recording);
    assert_eq!(code, Some(0), "{text}");
    assert_eq!(files_in(home.path()), std::slice::from_ref(&recording));
    let first = std::fs::read(&recording).unwrap();
    let (code, text) = run(&[&arguments[..], &["-o", out.to_str().unwrap(), "--threads", "1"]].concat(), &recording);
    assert_eq!(code, Some(0), "{text}");
    assert!(std::fs::read(&recording).unwrap() == first, "the same input gives the same bytes");
    let Some(counted) = checked(&recording, &out) else { return };
    let topics: Vec<&String> = counted["topics"].as_object().unwrap().keys().collect();
    assert_eq!(topics.len(), N_TOPICS);
    assert!(topics.iter().all(|topic| topic.matches('/').count() == 2), "{topics:?}");
}

#[test]
fn a_running_site_is_recorded_as_its_maps_change() {
    let mut live = Live::start();
    let (recording, out) = (live.home.path().join("day.mcap"), live.home.path().join("out"));
    let mut record = Command::new(client());
    record.arg("record").arg(&recording).arg("--config").arg(live.config());
    let mut record = record.stderr(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap();
    let mut lines = BufReader::new(record.stderr.take().unwrap()).lines();
    let first = lines.next().unwrap().unwrap();
    assert!(first.contains("2024-03-01T00:00:00"), "{first}");
    assert!(!recording.exists(), "it appears whole");
    live.text(&[&"date", &"2024-04-15"]);
    let second = lines.next().unwrap().unwrap();
    assert!(second.contains("2024-04-15T00:00:00"), "{second}");
    // The bus is another one after that, and the recording goes on.
    live.kill("rasterize");
    live.text(&[&"date", &"2024-06-30"]);
    assert!(lines.any(|line| line.unwrap().contains("2024-06-30T00:00:00")));
    assert!(Command::new("kill").args(["-INT", &record.id().to_string()]).status().unwrap().success());
    let output = record.wait_with_output().unwrap();
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(output.status.success() && text.ends_with(&format!("sets of maps in {}\n", recording.display())), "{text}");
    live.text(&[&"export", &out]);
    live.down();
    if let Some(counted) = checked(&recording, &out) {
        assert!(counted["cells"].as_u64() > Some(100_000), "{counted}");
    }
}

#[test]
fn a_recording_that_cannot_be_made_leaves_what_stands_there() {
    let home = tempfile::tempdir().unwrap();
    let recording = home.path().join("demo.mcap");
    std::fs::write(&recording, "precious").unwrap();
    let check = |arguments: &[&str], code: i32, words: &str| {
        let (found, text) = run(arguments, &recording);
        assert!(found == Some(code) && text.contains(words), "{arguments:?}: {found:?} {text}");
        assert_eq!(std::fs::read_to_string(&recording).unwrap(), "precious");
        assert_eq!(files_in(home.path()), std::slice::from_ref(&recording));
    };
    let out = home.path().join("out");
    check(&["--date", "2024-04-15"], 2, "give --date all");
    check(&["--date", "all", "--world"], 2, "give -o");
    check(&["--date", "all", "--resolution", "0.2", "-o", out.to_str().unwrap()], 2, "is no MCAP file");
}
