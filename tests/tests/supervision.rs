//! Supervision of a site: what hangs, what is up, what was done.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

use end_to_end::live::{DEADLINE, Live, POLL_INTERVAL};
use serde_json::Value;
use std::collections::BTreeSet;
use std::io::{BufRead, BufReader};
use std::process::{Command, Stdio};
use std::time::Instant;

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
        let has_begun = status["clock"]["valid_until"].is_string();
        status["healthy"] == true && has_begun && daemon["process_id"] != before && daemon["restarts"] == 1
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

/// The history as it is when the file of the month is full, whose end waits for this lock.
fn locked_history(live: &Live) -> std::fs::File {
    let folder = live.home.path().join("state/history");
    let month = std::fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().path());
    let month = month.filter(|path| path.extension().is_some_and(|e| e == "jsonl")).max().unwrap();
    let line = std::fs::read_to_string(&month).unwrap().lines().next().unwrap().to_owned() + "\n";
    std::fs::write(&month, line.repeat((9 << 20) / line.len())).unwrap();
    let lock = std::fs::File::create(folder.join("lock")).unwrap();
    lock.lock().unwrap();
    lock
}

#[test]
fn a_service_whose_thread_waits_for_a_file_is_told_killed_and_started_again() {
    let mut live = Live::start();
    let robot = live.home.path().join("robot.toml");
    std::fs::write(&robot, "name = \"slim\"\nradius_m = 0.2\n").unwrap();
    let before = daemon(&live, "rasterize")["process_id"].as_u64().unwrap();
    let lock = locked_history(&live);
    let mut command = Command::new(end_to_end::client());
    let config = live.config();
    let command = command.arg("robot").arg(&robot).arg("--config").arg(&config).stderr(Stdio::null());
    let mut command = command.stdout(Stdio::null()).spawn().unwrap();
    wait_until(&live, "it is busy", |status| {
        let busy = &status["daemons"]["rasterize"]["busy"];
        busy["job"] == "the request set_robot" && busy["for_s"].as_f64().unwrap() >= 4.0
    });
    let text = String::from_utf8(live.run(&[&"status"]).stdout).unwrap();
    assert!(text.contains(", busy with the request set_robot for "), "{text}");
    wait_until(&live, "it hangs", |status| {
        let daemon = &status["daemons"]["rasterize"];
        status["healthy"] == false && daemon["stage"] == "hangs" && daemon["busy"]["job"] == "the request set_robot"
    });
    // The one that is started in its place must not hang for the lock as well: a request is sent once more, not twice.
    let begun = Instant::now();
    while std::path::Path::new(&format!("/proc/{before}")).exists() {
        assert!(begun.elapsed() < DEADLINE, "it is killed");
        std::thread::sleep(POLL_INTERVAL);
    }
    drop(lock);
    wait_until(&live, "it is started again", |status| status["daemons"]["rasterize"]["process_id"] != before);
    assert!(command.wait().unwrap().success(), "what it asked for is asked for once more");
    live.wait_until_healthy();
    assert_eq!(live.status().unwrap()["grids"]["robot"], "slim");
    live.down();
}

#[test]
fn a_keeper_and_a_relay_that_hang_are_killed_and_started_again() {
    let mut live = Live::start();
    for name in ["keeper", "relay"] {
        let before = daemon(&live, name)["process_id"].as_u64().unwrap();
        assert!(before > 1 && Command::new("kill").args(["-STOP", &before.to_string()]).status().unwrap().success());
        wait_until(&live, "it is started again", |status| {
            let process = &status["daemons"][name];
            status["healthy"] == true && process["process_id"] != before && process["restarts"] == 1
        });
    }
    assert_eq!(live.text(&[&"date", &"2024-04-15T08:00:00"]), "2024-04-15T08:00:00", "there is a bus");
    live.down();
}

#[test]
fn a_daemon_that_dies_while_the_site_is_half_edited_comes_back_when_it_is_whole() {
    let mut live = Live::start();
    // What `up` takes for recovered is what it has seen to run for a while.
    let begun = Instant::now();
    wait_until(&live, "it has run for a while", |_| begun.elapsed().as_secs() >= 11);
    let before = daemon(&live, "rasterize")["process_id"].as_u64().unwrap();
    let up = live.up.as_ref().unwrap().id();
    let site = std::fs::read_to_string(live.config()).unwrap();
    std::fs::write(live.config(), format!("{site}\n[robot\n")).unwrap();
    assert!(before > 1 && Command::new("kill").args(["-9", &before.to_string()]).status().unwrap().success());
    // The client cannot read the file either.
    let begun = Instant::now();
    while begun.elapsed().as_secs() < 3 {
        let line = std::fs::read_to_string(format!("/proc/{up}/status")).unwrap();
        assert!(!line.contains("State:\tZ"), "it has ended");
        std::thread::sleep(POLL_INTERVAL);
    }
    std::fs::write(live.config(), site).unwrap();
    wait_until(&live, "it is started again", |status| {
        status["healthy"] == true && status["daemons"]["rasterize"]["process_id"] != before
    });
    live.down();
}

#[test]
fn a_program_of_another_build_is_not_started() {
    let home = tempfile::tempdir().unwrap();
    let own = end_to_end::client();
    // A link would be followed to the programs beside the file.
    std::fs::copy(&own, home.path().join("groundplan")).unwrap();
    for name in ["ifc-ingest", "schedule-eval", "waypoint-gen", "slam-align"] {
        std::os::unix::fs::symlink(own.with_file_name(name), home.path().join(name)).unwrap();
    }
    let other = home.path().join("rasterize");
    end_to_end::write_program(&other, "#!/bin/sh\necho 'rasterize 0.9.0 (commit 0123456789ab)'\n");
    let live = Live::without_models("models = []\n");
    let run = |command: &str| {
        let mut client = Command::new(home.path().join("groundplan"));
        client.args([command, "--config"]).arg(live.config()).output().unwrap()
    };
    let refused = run("up");
    let told = String::from_utf8(refused.stderr).unwrap();
    let version = String::from_utf8(Command::new(&own).arg("--version").output().unwrap().stdout).unwrap();
    let own_build = version.trim().strip_prefix("groundplan ").unwrap();
    assert_eq!(refused.status.code(), Some(1), "{told}");
    for part in [&other.display().to_string(), "0.9.0 (commit 0123456789ab)", own_build] {
        assert!(told.contains(part), "{part}: {told}");
    }
    assert!(!live.home.path().join("state").exists(), "nothing was started");
    let doctor = String::from_utf8(run("doctor").stdout).unwrap();
    assert!(doctor.contains("FAILS    executables") && doctor.contains("0.9.0 (commit 0123456789ab)"), "{doctor}");
}

#[test]
fn a_client_and_a_daemon_refuse_the_bus_of_another_build() {
    let mut live = Live::start();
    let before = daemon(&live, "rasterize")["process_id"].as_u64().unwrap();
    // As a keeper of another build writes it.
    let file = live.root.path().join("generation");
    let own = std::fs::read_to_string(&file).unwrap();
    let line = own.lines().find(|line| line.starts_with("build=")).unwrap();
    std::fs::write(&file, own.replace(line, "build=0.9.0 (commit 0123456789ab)")).unwrap();
    let refused = live.run(&[&"date", &"2024-04-15"]);
    let told = String::from_utf8(refused.stderr).unwrap();
    assert_eq!(refused.status.code(), Some(1), "{told}");
    let own_build = line.strip_prefix("build=").unwrap();
    assert!(told.contains("of groundplan 0.9.0 (commit 0123456789ab)") && told.contains(own_build), "{told}");

    assert!(before > 1 && Command::new("kill").args(["-9", &before.to_string()]).status().unwrap().success());
    wait_until(&live, "the one in its place refuses it", |status| {
        let daemon = &status["daemons"]["rasterize"];
        let told = daemon["error"].as_str().is_some_and(|error| error.contains("0.9.0 (commit 0123456789ab)"));
        told && status["healthy"] == false && daemon["process_id"] != before
    });
    std::fs::write(&file, own).unwrap();
    live.wait_until_healthy();
    live.down();
}

#[test]
fn every_process_logs_as_the_site_wants_it() {
    let home = tempfile::tempdir().unwrap();
    let config = home.path().join("site.toml");
    let root = tempfile::Builder::new().prefix("gplog").tempdir_in("/dev/shm").unwrap();
    let prefix = root.path().file_name().unwrap().to_string_lossy().replace('.', "");
    let text = format!(
        "state = \"state\"\nthreads = 1\n[log]\nformat = \"json\"\n[bus]\nprefix = \"{prefix}_\"\nroot = {:?}\n",
        root.path().join("bus")
    );
    std::fs::write(&config, text).unwrap();
    let mut up = Command::new(end_to_end::client());
    let mut up = up.arg("up").arg("--config").arg(&config).stderr(Stdio::piped()).spawn().unwrap();
    let lines = BufReader::new(up.stderr.take().unwrap()).lines().map(Result::unwrap);
    let mut missing: BTreeSet<&str> =
        ["up", "keeper", "relay", "ifc-ingest", "schedule-eval", "rasterize", "waypoint-gen", "slam-align"].into();
    for line in lines {
        let document: Value = serde_json::from_str(&line).unwrap_or_else(|_| panic!("{line}"));
        let service = document["service"].as_str().unwrap_or_default().to_owned();
        missing.remove(service.as_str());
        // The supervisor itself tells what it starts.
        if document["message"] == "started" {
            missing.remove("up");
        }
        if missing.is_empty() {
            break;
        }
    }
    assert!(end_to_end::groundplan(&[&"down", &"--config", &config]).status.success());
    assert!(up.wait().unwrap().success());
    assert_eq!(missing, BTreeSet::new());
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
