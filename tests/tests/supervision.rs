//! Supervision of a site: what hangs, what is up, what was done.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

mod support;

use serde_json::Value;
use std::process::Command;
use std::time::Instant;
use support::live::{DEADLINE, Live, POLL_INTERVAL};

/// The report of a daemon in `status`.
fn daemon(live: &Live, name: &str) -> Value {
    live.status().unwrap()["daemons"][name].clone()
}

fn wait_until(live: &Live, what: &str, is_so: impl Fn(&Value) -> bool) {
    let begun = Instant::now();
    while !live.status().is_some_and(|status| is_so(&status)) {
        assert!(begun.elapsed() < DEADLINE, "{what}: {:?}", live.status());
        std::thread::sleep(POLL_INTERVAL);
    }
}

#[test]
fn a_daemon_that_hangs_is_told_killed_and_started_again() {
    let mut live = Live::start();
    let before = daemon(&live, "schedule-eval")["process_id"].as_u64().unwrap();
    assert!(Command::new("kill").args(["-STOP", &before.to_string()]).status().unwrap().success());
    wait_until(&live, "it hangs", |status| {
        let daemon = &status["daemons"]["schedule-eval"];
        status["healthy"] == false && daemon["stage"] == "hangs" && daemon["age_s"].as_f64().unwrap() >= 3.0
    });
    wait_until(&live, "it is started again", |status| {
        let daemon = &status["daemons"]["schedule-eval"];
        status["healthy"] == true && daemon["process_id"] != before && daemon["restarts"] == 1
    });
    let metrics = live.text(&[&"metrics"]);
    for line in [
        "groundplan_up{daemon=\"rasterize\"} 1",
        "groundplan_restarts_total{daemon=\"schedule-eval\"} 1",
        "groundplan_restarts_total{daemon=\"rasterize\"} 0",
        "# TYPE groundplan_valid_until_seconds gauge",
    ] {
        assert!(metrics.lines().any(|l| l == line), "{line}: {metrics}");
    }
    live.down();
}

#[test]
fn a_site_is_up_once_and_commands_after_it_say_how_to_start_it() {
    let mut live = Live::start();
    let second = live.run(&[&"up"]);
    let words = String::from_utf8_lossy(&second.stderr).into_owned();
    assert!(second.status.code() == Some(1) && words.contains("the site is up already: process "), "{words}");
    live.text(&[&"date", &"2024-04-15T08:00:00"]);
    live.down();
    let out = live.home.path().join("out");
    let commands: [&[&str]; 6] = [
        &["status"],
        &["date", "--next"],
        &["load"],
        &["waypoints"],
        &["topic", "list"],
        &["export", out.to_str().unwrap()],
    ];
    for command in commands {
        let arguments: Vec<&dyn AsRef<std::ffi::OsStr>> = command.iter().map(|word| word as _).collect();
        let output = live.run(&arguments);
        let words = String::from_utf8_lossy(&output.stderr).into_owned();
        let wanted = format!("the site is not up; start it with: groundplan up --config {}", live.config().display());
        assert!(output.status.code() == Some(1) && words.contains(&wanted), "{command:?}: {words}");
    }
    // What was done is known although nothing runs.
    let log: Vec<Value> = serde_json::from_str(&live.text(&[&"log", &"--kind", &"date", &"--json"])).unwrap();
    let own = rustix::process::getuid().as_raw();
    let set = log.last().unwrap();
    assert!(set["by"]["uid"] == own && set["summary"].as_str().unwrap().contains("2024-04-15T08:00:00"), "{log:?}");
}
