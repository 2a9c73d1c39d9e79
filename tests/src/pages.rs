//! Runs the commands of a document for people, as they are printed, in a folder with what a clone has.
//!
//! | fence | what happens |
//! |---|---|
//! | `sh` | its lines run one after the other; `  # exit code 3` after one says how it ends, if not with 0 |
//! | `sh no-test: WHY` | its lines cannot run here; they are counted |
//! | `text` | each line is in what the block before printed, in this order; `..` stands for any text |
//! | `text example: WHY` | shows something that no command before printed |
//! | `LANGUAGE file=NAME` | the text becomes this file |
//! | `rust example=PATH` | the text is this program of the repository, without its header |
//!
//! Programs that run until somebody ends them are ended with the page, or once they have said what they serve. Buses, ports and the
//! domain of ROS in pages are those of the test alone.

use super::live::{DEADLINE, POLL_INTERVAL};
use super::ros_node::has_node;
use super::{announce, client, root, ros_peer};
use std::collections::BTreeMap;
use std::io::{BufRead, BufReader};
use std::net::TcpListener;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::Instant;

/// Ports of pages, for which the test has others.
const PORTS: [&str; 4] = ["8642", "8643", "8765", "7447"];

/// Names of sites in pages: their buses lie in `/dev/shm/NAME`, with the prefix `NAME_`.
const SITES: [&str; 2] = ["tower", "scout"];

/// A fenced block of a document.
pub struct Block {
    /// What stands behind the fence.
    info: String,
    lines: Vec<String>,
    /// Number of its first line.
    line: usize,
}

/// The fenced blocks of a text.
pub fn blocks(text: &str) -> Vec<Block> {
    let mut found: Vec<Block> = Vec::new();
    let mut is_open = false;
    for (number, line) in text.lines().enumerate() {
        match line.strip_prefix("```") {
            Some(_) if is_open => is_open = false,
            Some(info) => {
                is_open = true;
                found.push(Block { info: info.to_owned(), lines: Vec::new(), line: number + 2 });
            }
            None if is_open => found.last_mut().unwrap().lines.push(line.to_owned()),
            None => {}
        }
    }
    assert!(!is_open, "a fence is not closed");
    found
}

/// A command of a page: its line without comment, and its exit code.
fn command_of(line: &str) -> Option<(String, i32)> {
    let (command, comment) = line.split_once("  #").unwrap_or((line, ""));
    let code = comment.trim().strip_prefix("exit code ").map_or(0, |rest| {
        let digits: String = rest.chars().take_while(char::is_ascii_digit).collect();
        digits.parse().unwrap()
    });
    let command = command.trim_end();
    (!command.is_empty() && !command.starts_with('#')).then(|| (command.to_owned(), code))
}

/// How many command lines of a page run, and how many cannot.
#[derive(Debug, Default, Clone, Copy)]
pub struct Counts {
    pub n_run: usize,
    pub n_not_run: usize,
}

/// A folder in which the commands of a page run, with what they left running.
pub struct Page {
    pub home: tempfile::TempDir,
    name: String,
    /// Texts of the page, and what stands for them here.
    private: Vec<(String, String)>,
    /// Folders in which those of buses are made, which go with this value.
    _buses: Vec<tempfile::TempDir>,
    served: Vec<Child>,
    pub counts: Counts,
    /// True if programs of the page find the packages that they import.
    has_python: bool,
    has_curl: bool,
}

impl Page {
    /// A folder with what a clone has, in which commands may write.
    pub fn new(name: &str) -> Self {
        let home = tempfile::tempdir().unwrap();
        for folder in ["config", "scripts", "tests"] {
            std::os::unix::fs::symlink(root().join(folder), home.path().join(folder)).unwrap();
        }
        let buses = SITES.map(|_| tempfile::Builder::new().prefix("gpdoc").tempdir_in("/dev/shm").unwrap());
        let mut private = Vec::new();
        for (site, bus) in SITES.iter().zip(&buses) {
            let prefix = format!("{}_", bus.path().file_name().unwrap().to_string_lossy().replace('.', ""));
            // The relay's folder lies beside it, and goes with it.
            private.push((format!("/dev/shm/{site}"), bus.path().join("bus").display().to_string()));
            private.push((format!("{site}_"), prefix));
        }
        let ros_domain = ros_peer::domain();
        let listeners = PORTS.map(|_| TcpListener::bind("127.0.0.1:0").unwrap());
        for name in ["domain_id = ", "ROS_DOMAIN_ID="] {
            private.push((format!("{name}42"), format!("{name}{ros_domain}")));
        }
        for (port, listener) in PORTS.iter().zip(&listeners) {
            private.push((format!("127.0.0.1:{port}"), listener.local_addr().unwrap().to_string()));
        }
        let is_done = |command: &mut Command| command.output().is_ok_and(|output| output.status.success());
        Self {
            home,
            name: name.to_owned(),
            private,
            _buses: buses.into(),
            served: Vec::new(),
            counts: Counts::default(),
            has_python: is_done(Command::new(root().join("scripts/python-env")).args(["iceoryx2==0.10.0", "numpy"])),
            has_curl: is_done(Command::new("curl").arg("--version")),
        }
    }

    /// Runs a whole document.
    pub fn run(&mut self, blocks: &[Block]) {
        // `None` where something that a command needs is not there.
        let mut printed = Some(String::new());
        for block in blocks {
            let (language, more) = block.info.split_once(' ').unwrap_or((&block.info, ""));
            let place = format!("{}, line {}", self.name, block.line);
            match (language, more) {
                ("sh", "") => printed = block.lines.iter().map(|line| self.run_line(line, &place)).collect(),
                ("text", "") => {
                    let wanted = self.private(&block.lines.join("\n"));
                    printed.iter().for_each(|printed| assert_printed(&wanted, printed, &place));
                }
                ("sh", why) if is_reason(why, "no-test: ") => self.counts.n_not_run += n_commands(block),
                (_, why) if language != "sh" && is_reason(why, "example: ") => {}
                ("rust", more) if more.starts_with("example=") => assert_is_example(block, &more[8..], &place),
                (_, more) if more.starts_with("file=") => {
                    let text = self.private(&block.lines.join("\n"));
                    std::fs::write(self.home.path().join(&more[5..]), text + "\n").unwrap();
                }
                _ => panic!("{place}: what is {:?}?", block.info),
            }
        }
    }

    /// Ends what still runs.
    pub fn end(&mut self) -> Counts {
        for child in self.served.drain(..).rev() {
            end(child);
        }
        self.counts
    }

    /// A text with buses and ports of this test.
    fn private(&self, text: &str) -> String {
        self.private.iter().fold(text.to_owned(), |text, (public, private)| text.replace(public, private))
    }

    /// Runs a line, and gives what it printed; `None` if it cannot run here, which is told.
    fn run_line(&mut self, line: &str, place: &str) -> Option<String> {
        let Some((line, code)) = command_of(line) else { return Some(String::new()) };
        let line = self.private(&line);
        self.counts.n_run += 1;
        if line.starts_with("cargo run ") {
            return self.example(&line, place);
        }
        if line.starts_with("ROS_DOMAIN_ID=") && !has_node() {
            return None;
        }
        let is_own_program = line.starts_with("python3 ") && !line.contains("scripts/");
        if is_own_program && !self.has_python || line.starts_with("curl ") && !self.has_curl {
            announce(&format!("SKIPPED: {place}: {line}: Python's packages or curl cannot be had"));
            return None;
        }
        let mut words = line.split(' ');
        Some(match (words.next(), words.next()) {
            (Some("groundplan"), Some("up" | "serve" | "follow")) => self.up(&line),
            (Some("groundplan"), Some("view")) if !line.contains("--export") && !line.contains("--config") => {
                // Its port may be taken by a page that somebody looks at.
                self.said(&format!("{line} --listen 127.0.0.1:0"), "http://127.0.0.1:")
            }
            (Some("groundplan"), Some("ask")) if line.contains(" --listen ") => self.said(&line, "http://127.0.0.1:"),
            (Some("groundplan"), Some("record")) if !line.contains(" --for ") => self.said(&line, ""),
            (Some("groundplan"), _) if line.contains(" --watch ") => self.said(&line, ""),
            // A screen needs a terminal.
            (Some("groundplan"), Some("monitor")) => self.finished(&format!("{line} --json --for 0.2"), code, place),
            _ => self.finished(&line, code, place),
        })
    }

    /// A line in a shell that finds the programs of this build, and Python with what the package needs.
    fn shell(&self, line: &str) -> Command {
        let programs = client().parent().unwrap().display().to_string();
        let python = root().join("target/venv/bin");
        let mut command = Command::new("sh");
        let path = format!("{programs}:{}:{}", python.display(), std::env::var("PATH").unwrap());
        command.args(["-c", line]).current_dir(self.home.path()).env("PATH", path).env("TMPDIR", self.home.path());
        command.env("PYTHONPATH", root().join("common/python/src")).env("RMW_IMPLEMENTATION", "rmw_fastrtps_cpp");
        command.stdin(Stdio::null());
        command
    }

    fn finished(&self, line: &str, code: i32, place: &str) -> String {
        let output = self.shell(line).output().unwrap();
        let printed =
            [output.stdout, output.stderr].map(|bytes| String::from_utf8_lossy(&bytes).into_owned()).join("\n");
        assert_eq!(output.status.code(), Some(code), "{place}: {line}\n{printed}");
        printed
    }

    /// Starts a site and waits until it is well.
    fn up(&mut self, line: &str) -> String {
        let mut child =
            self.shell(&format!("exec {line}")).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
        let mut options = line.split(' ').skip_while(|word| *word != "--config");
        let site = options.nth(1).map_or("--demo".to_owned(), |file| format!("--config {file}"));
        let begun = Instant::now();
        while !self.shell(&format!("groundplan status {site}")).output().unwrap().status.success() {
            assert!(child.try_wait().unwrap().is_none(), "{line} has ended");
            assert!(begun.elapsed() < DEADLINE, "{line}: the site is not well");
            std::thread::sleep(POLL_INTERVAL);
        }
        self.served.push(child);
        String::new()
    }

    /// What a program that runs until it is told to end says up to the line with a word.
    fn said(&self, line: &str, word: &str) -> String {
        let mut child = self.shell(&format!("exec {line} 2>&1")).stdout(Stdio::piped()).spawn().unwrap();
        let mut lines = BufReader::new(child.stdout.take().unwrap()).lines();
        let (mut printed, mut is_said) = (String::new(), false);
        while !is_said && let Some(said) = lines.next() {
            let said = said.unwrap();
            printed += &format!("{said}\n");
            is_said = said.contains(word);
        }
        // What it says later must find somebody who reads.
        std::thread::Builder::new().name("output".to_owned()).spawn(move || lines.for_each(drop)).unwrap();
        end(child);
        assert!(is_said, "{line}: it does not say {word:?}\n{printed}");
        printed
    }

    /// Runs `cargo run --example NAME -- ARGUMENTS`, which is built with the tests, until its first line.
    fn example(&self, line: &str, place: &str) -> Option<String> {
        let (name, arguments) = line.split_once("--example ").unwrap().1.split_once(" -- ").unwrap();
        let program = client().parent().unwrap().join("examples").join(name);
        if !program.exists() {
            announce(&format!("SKIPPED: {place}: the example {name} is not built: cargo build --workspace --examples"));
            return None;
        }
        Some(self.said(&format!("{} {arguments}", program.display()), ""))
    }
}

impl Drop for Page {
    /// After a failure nothing stays.
    fn drop(&mut self) {
        for child in self.served.iter_mut().rev() {
            let _ =
                rustix::process::kill_process(rustix::process::Pid::from_child(child), rustix::process::Signal::TERM);
            let _ = child.wait();
        }
    }
}

fn end(mut child: Child) {
    rustix::process::kill_process(rustix::process::Pid::from_child(&child), rustix::process::Signal::TERM).unwrap();
    let status = child.wait().unwrap();
    // A program without a handler is ended by the signal.
    let by_signal = std::os::unix::process::ExitStatusExt::signal(&status) == Some(15);
    assert!(status.success() || by_signal, "{status}");
}

fn is_reason(more: &str, word: &str) -> bool {
    more.strip_prefix(word).is_some_and(|why| why.trim().len() > 3)
}

fn n_commands(block: &Block) -> usize {
    block.lines.iter().filter(|line| command_of(line).is_some()).count()
}

/// The texts between `..` of a line.
pub fn pieces(line: &str) -> impl Iterator<Item = &str> {
    line.split("..").map(str::trim).filter(|piece| !piece.is_empty())
}

/// A text with one blank for any number of them.
fn single_spaced(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// True if a text has the pieces in their order.
pub fn has_pieces<'a>(text: &str, mut pieces: impl Iterator<Item = &'a str>) -> bool {
    let mut rest = text;
    pieces.all(|piece| match rest.split_once(piece) {
        Some((_, after)) => {
            rest = after;
            true
        }
        None => false,
    })
}

fn assert_printed(wanted: &str, printed: &str, place: &str) {
    let mut lines = printed.lines();
    for line in wanted.lines().filter(|line| pieces(line).next().is_some()) {
        let line = single_spaced(line);
        let is_there = lines.any(|printed| has_pieces(&single_spaced(printed), pieces(&line)));
        assert!(is_there, "{place}: {line:?} is not in, or not behind the lines before it in\n{printed}");
    }
}

fn assert_is_example(block: &Block, path: &str, place: &str) {
    let text = std::fs::read_to_string(root().join(path)).unwrap();
    let program: Vec<&str> = text.lines().skip_while(|line| line.starts_with("//!") || line.is_empty()).collect();
    assert_eq!(block.lines, program, "{place}: {path} differs");
}

/// Source text of all programs without tests, by file: texts that go over several lines are on one, quotes are not escaped.
pub fn sources() -> BTreeMap<String, String> {
    let (mut todo, mut found) = (vec![root().join("common"), root().join("services")], BTreeMap::new());
    while let Some(folder) = todo.pop() {
        for path in super::files_in(&folder) {
            let is_rust = path.extension().is_some_and(|end| end == "rs");
            match path.is_dir() {
                true if !["tests", "bundle", "node_modules", "target"].iter().any(|name| path.ends_with(name)) => {
                    todo.push(path)
                }
                false if is_rust => {
                    found.insert(path.display().to_string(), source(&path));
                }
                _ => {}
            }
        }
    }
    found
}

fn source(path: &Path) -> String {
    let text = std::fs::read_to_string(path).unwrap();
    let text = text.split("#[cfg(test)]\nmod ").next().unwrap();
    let mut parts = text.split("\\\n");
    let first = parts.next().unwrap_or_default().to_owned();
    parts.fold(first, |joined, part| joined + part.trim_start()).replace("\\\"", "\"")
}
