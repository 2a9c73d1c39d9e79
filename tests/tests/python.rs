//! A Python subscriber reads the running daemons' memory in place.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

mod support;

use serde_json::Value;
use std::path::PathBuf;
use std::process::Command;
use support::live::Live;
use support::{announce, root};

/// Python with what the example needs; `None`, and a loud word, where it cannot be had.
fn python() -> Option<PathBuf> {
    let made = Command::new(root().join("scripts/python-env")).args(["iceoryx2==0.10.0", "numpy"]).output().unwrap();
    if made.status.success() {
        return Some(root().join("target/venv/bin/python"));
    }
    announce(&format!("SKIPPED: iceoryx2 for Python cannot be installed: {}", String::from_utf8_lossy(&made.stderr)));
    None
}

#[test]
fn python_sees_the_grid_that_the_client_sees() {
    let Some(python) = python() else { return };
    let mut live = Live::start();
    live.text(&[&"date", &"2024-04-29T10:00:00"]);
    for storey in [0, 1] {
        let mut command = Command::new(&python);
        command.arg(root().join("scripts/python_subscriber.py")).arg("--root").arg(live.root.path());
        let output = command.args(["--prefix", &live.prefix, "--storey", &storey.to_string()]).output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let seen: Value = serde_json::from_slice(&output.stdout).unwrap();
        let own = live.text(&[&"topic", &"echo", &format!("grid/{storey:02}"), &"--json"]);
        let own: Value = serde_json::from_str(&own).unwrap();
        let content = &own["content"];
        assert_eq!(
            (&seen["epoch"], &seen["content_hash"], &seen["free"], &seen["origin_m"]),
            (&own["epoch"], &own["content_hash"], &content["free_cells"], &content["origin_m"])
        );
        assert_eq!([&seen["shape"][1], &seen["shape"][0]], [&content["size_cells"][0], &content["size_cells"][1]]);
        assert!(seen["keepout"].as_u64().unwrap() > 0);
    }
    live.down();
    assert_eq!(live.segments(), 0, "nothing is left in shared memory");
}
