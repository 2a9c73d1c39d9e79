//! A program outside that looks at a running site, and prints what comes to it: one JSON document a line, with its topic.

use super::live::DEADLINE;
use serde_json::Value;
use std::collections::BTreeMap;
use std::io::{BufRead, BufReader, Write};
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::Instant;

/// A process that prints what comes.
pub struct Peer {
    process: Child,
    input: ChildStdin,
    /// What it has printed and is not read yet.
    lines: Receiver<String>,
    /// The last message of each topic.
    pub last: BTreeMap<String, Value>,
    /// Topics in the order in which messages came.
    pub order: Vec<String>,
}

impl Peer {
    pub fn start(command: &mut Command) -> Self {
        let mut process = command.stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap();
        let input = process.stdin.take().unwrap();
        let printed = BufReader::new(process.stdout.take().unwrap()).lines();
        let (sender, lines) = channel();
        // One that is silent is no reason to wait longer than the deadline.
        std::thread::spawn(move || printed.map_while(Result::ok).try_for_each(|line| sender.send(line)));
        Self { process, input, lines, last: BTreeMap::new(), order: Vec::new() }
    }

    /// Sends so many lines, for each of which it does its next step.
    pub fn step(&mut self, n_steps: usize) {
        self.input.write_all("\n".repeat(n_steps).as_bytes()).unwrap();
    }

    /// Sends it a signal, as `kill` names it.
    pub fn signal(&self, signal: &str) {
        assert!(Command::new("kill").args([signal, &self.process.id().to_string()]).status().unwrap().success());
    }

    /// Reads messages until they are as they should be.
    pub fn wait_until(&mut self, what: &str, is_so: impl Fn(&BTreeMap<String, Value>) -> bool) {
        let begun = Instant::now();
        while !is_so(&self.last) {
            assert!(self.read(), "{what}: the peer has ended");
            assert!(begun.elapsed() < DEADLINE, "{what}: {:?}", self.last);
        }
    }

    /// Reads until there is nothing more to come.
    pub fn wait_until_its_end(&mut self) {
        let begun = Instant::now();
        while self.read() {
            assert!(begun.elapsed() < DEADLINE, "the peer does not end");
        }
    }

    /// Reads the next message; false at the end.
    fn read(&mut self) -> bool {
        let line = match self.lines.recv_timeout(DEADLINE) {
            Ok(line) => line,
            Err(RecvTimeoutError::Disconnected) => return false,
            Err(RecvTimeoutError::Timeout) => panic!("the peer is silent: {:?}", self.last),
        };
        let message: Value = serde_json::from_str(&line).unwrap();
        let topic = message["topic"].as_str().unwrap().to_owned();
        self.order.push(topic.clone());
        self.last.insert(topic, message);
        true
    }
}

impl Drop for Peer {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}
