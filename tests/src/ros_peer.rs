//! A participant of the ROS 2 graph, and sites with a bridge.

use super::live::{DEADLINE, Live, POLL_INTERVAL};
use super::peer::Peer;
use super::{announce, demo_model, root};
use rustix::io::FdFlags;
use serde_json::Value;
use std::ffi::OsStr;
use std::fs::File;
use std::path::Path;
use std::process::Command;
use std::time::Instant;

/// True, unless CycloneDDS cannot be had: then it says so.
pub fn has_peer() -> bool {
    let made = Command::new(root().join("scripts/python-env")).arg("cyclonedds==11.0.1").output().unwrap();
    if !made.status.success() {
        announce(&format!("SKIPPED: CycloneDDS cannot be installed: {}", String::from_utf8_lossy(&made.stderr)));
    }
    made.status.success()
}

/// A domain that no other test has as long as this process runs, or a daemon that it left behind: one that was killed leaves some.
pub fn domain() -> u16 {
    let mut domains = 100..228;
    let free = domains.find(|domain| {
        let path = std::env::temp_dir().join(format!("groundplan-test-domain-{domain}"));
        let lock = File::create(path).unwrap();
        let is_free = lock.try_lock().is_ok();
        if is_free {
            // The system gives it back when this process and all that it started have ended.
            rustix::io::fcntl_setfd(&lock, FdFlags::empty()).unwrap();
            std::mem::forget(lock);
        }
        is_free
    });
    free.expect("as many domains as tests")
}

fn start(script: &str, domain: u16, more: &[&dyn AsRef<OsStr>]) -> Peer {
    let mut command = Command::new(root().join("target/venv/bin/python"));
    Peer::start(command.arg(root().join(script)).args(["--domain", &domain.to_string()]).args(more))
}

/// A participant that prints what comes.
pub fn join(domain: u16, more: &[&dyn AsRef<OsStr>]) -> Peer {
    start("scripts/ros_peer.py", domain, more)
}

/// A SLAM node that publishes maps of a kind on `/map`.
pub fn slam(domain: u16, kind: &str, path: &Path, more: &[&dyn AsRef<OsStr>]) -> Peer {
    let own: [&dyn AsRef<OsStr>; 2] = [&kind, &path];
    start("scripts/ros_slam.py", domain, &own.iter().chain(more).copied().collect::<Vec<_>>())
}

/// The demo building in April 2024, with a bridge in a domain; `more` keys of `[ros]`.
pub fn site(domain: u16, more: &str) -> Live {
    let ros = format!("[schedule]\nplan_time = \"2024-04-15\"\n[ros]\nenabled = true\ndomain_id = {domain}\n{more}");
    Live::of(&demo_model(), &ros)
}

/// What `doctor` says about the graph.
pub fn graph(live: &Live) -> String {
    let checks: Value = serde_json::from_slice(&live.run(&[&"doctor", &"--json"]).stdout).unwrap();
    let check = checks.as_array().unwrap().iter().find(|check| check["what"] == "ROS 2").cloned();
    check.unwrap()["found"].as_str().unwrap().to_owned()
}

/// Waits until `doctor` says all these words about the graph.
pub fn wait_for_graph(live: &Live, words: &[&str]) {
    let begun = Instant::now();
    loop {
        let found = graph(live);
        if words.iter().all(|words| found.contains(words)) {
            return;
        }
        assert!(begun.elapsed() < DEADLINE, "{found}");
        std::thread::sleep(POLL_INTERVAL);
    }
}

/// Waits until what the bridge says of itself is as it should be.
pub fn wait_for_facts(live: &Live, is_so: impl Fn(&Value) -> bool) -> Value {
    let begun = Instant::now();
    loop {
        let report = std::fs::read(live.root.path().join("board/ros-bridge.json")).unwrap();
        let facts = serde_json::from_slice::<Value>(&report).unwrap()["facts"].take();
        if is_so(&facts) {
            return facts;
        }
        assert!(begun.elapsed() < DEADLINE, "{facts}");
        std::thread::sleep(POLL_INTERVAL);
    }
}
