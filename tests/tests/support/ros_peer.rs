//! A participant of the ROS 2 graph, and sites with a bridge.

use super::live::{DEADLINE, Live};
use super::{announce, demo_model, root};
use serde_json::Value;
use std::collections::BTreeMap;
use std::io::{BufRead, BufReader, Lines};
use std::process::{Child, ChildStdout, Command, Stdio};
use std::sync::atomic::{AtomicU16, Ordering};
use std::time::Instant;

/// True, unless CycloneDDS cannot be had: then it says so.
pub(crate) fn has_peer() -> bool {
    let made = Command::new(root().join("scripts/python-env")).arg("cyclonedds==11.0.1").output().unwrap();
    if !made.status.success() {
        announce(&format!("SKIPPED: CycloneDDS cannot be installed: {}", String::from_utf8_lossy(&made.stderr)));
    }
    made.status.success()
}

/// A domain that no other test of this process and hardly one of another has.
pub(crate) fn domain() -> u16 {
    static NUMBER: AtomicU16 = AtomicU16::new(0);
    100 + (std::process::id() % 60) as u16 * 2 + NUMBER.fetch_add(1, Ordering::Relaxed) % 2
}

/// A participant that prints what comes.
pub(crate) struct Peer {
    process: Child,
    lines: Lines<BufReader<ChildStdout>>,
    /// The last message of each topic.
    pub(crate) last: BTreeMap<String, Value>,
    /// Topics in the order in which messages came.
    pub(crate) order: Vec<String>,
}

impl Peer {
    pub(crate) fn join(domain: u16, more: &[&dyn AsRef<std::ffi::OsStr>]) -> Self {
        let mut command = Command::new(root().join("target/venv/bin/python"));
        command.arg(root().join("scripts/ros_peer.py")).args(["--domain", &domain.to_string()]).args(more);
        let mut process = command.stdout(Stdio::piped()).spawn().unwrap();
        let lines = BufReader::new(process.stdout.take().unwrap()).lines();
        Self { process, lines, last: BTreeMap::new(), order: Vec::new() }
    }

    /// Reads messages until they are as they should be.
    pub(crate) fn wait_until(&mut self, what: &str, is_so: impl Fn(&BTreeMap<String, Value>) -> bool) {
        let begun = Instant::now();
        while !is_so(&self.last) {
            let line = self.lines.next().unwrap_or_else(|| panic!("{what}: the peer has ended")).unwrap();
            let message: Value = serde_json::from_str(&line).unwrap();
            let topic = message["topic"].as_str().unwrap().to_owned();
            self.order.push(topic.clone());
            self.last.insert(topic, message);
            assert!(begun.elapsed() < DEADLINE, "{what}: {:?}", self.last);
        }
    }
}

impl Drop for Peer {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

/// The demo building in April 2024, with a bridge in a domain; `more` keys of `[ros]`.
pub(crate) fn site(domain: u16, more: &str) -> Live {
    let ros = format!("[schedule]\nplan_time = \"2024-04-15\"\n[ros]\nenabled = true\ndomain_id = {domain}\n{more}");
    Live::of(&demo_model(), &ros)
}
