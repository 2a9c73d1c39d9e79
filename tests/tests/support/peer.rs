//! A program outside that looks at a running site, and prints what comes to it: one JSON document a line, with its topic.

use super::live::DEADLINE;
use serde_json::Value;
use std::collections::BTreeMap;
use std::io::{BufRead, BufReader, Lines};
use std::process::{Child, ChildStdout, Command, Stdio};
use std::time::Instant;

/// A process that prints what comes.
pub(crate) struct Peer {
    process: Child,
    lines: Lines<BufReader<ChildStdout>>,
    /// The last message of each topic.
    pub(crate) last: BTreeMap<String, Value>,
    /// Topics in the order in which messages came.
    pub(crate) order: Vec<String>,
}

impl Peer {
    pub(crate) fn start(command: &mut Command) -> Self {
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

    /// Reads until there is nothing more to come.
    pub(crate) fn wait_until_its_end(&mut self) {
        let begun = Instant::now();
        while self.lines.next().is_some() {
            assert!(begun.elapsed() < DEADLINE, "the peer does not end");
        }
    }
}

impl Drop for Peer {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}
