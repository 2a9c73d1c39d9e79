//! The commands of README.md, as they are printed, in a clone of the repository.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

mod support;

use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use support::{announce, client, root};

/// Lines of the blocks of a section that call the client, without their comments.
fn commands(section: &str) -> Vec<String> {
    let readme = std::fs::read_to_string(root().join("README.md")).unwrap();
    let text = readme.split_once(&format!("## {section}\n")).unwrap().1;
    let text = text.split("\n## ").next().unwrap().split("\n### ").next().unwrap();
    let blocks = text.split("```").skip(1).step_by(2);
    let lines = blocks.flat_map(str::lines).filter(|line| line.starts_with("groundplan "));
    lines.map(|line| line.split("  #").next().unwrap().trim_end().to_owned()).collect()
}

/// A folder with what a clone has, in which commands may write.
fn clone_in(folder: &Path) {
    for name in ["config", "scripts", "tests"] {
        std::os::unix::fs::symlink(root().join(name), folder.join(name)).unwrap();
    }
}

/// A line in a shell that finds the programs of this build.
fn shell(line: &str, folder: &Path) -> Command {
    let programs = client().parent().unwrap().display().to_string();
    let mut command = Command::new("sh");
    let path = format!("{programs}:{}", std::env::var("PATH").unwrap());
    command.args(["-c", &format!("exec {line}")]).current_dir(folder).env("PATH", path).env("TMPDIR", folder);
    command.stdin(Stdio::null());
    command
}

fn succeeds(line: &str, folder: &Path) {
    let output = shell(line, folder).output().unwrap();
    assert!(output.status.success(), "{line}\n{}", String::from_utf8_lossy(&output.stderr));
}

/// A program that runs until it is told to end; the line of its output that contains a word has come.
fn serves(line: &str, folder: &Path, word: &str) -> Child {
    let mut child = shell(&format!("{line} 2>&1"), folder).stdout(Stdio::piped()).spawn().unwrap();
    let mut lines = BufReader::new(child.stdout.take().unwrap()).lines();
    assert!(lines.by_ref().any(|said| said.unwrap().contains(word)), "{line}: it does not say {word:?}");
    // What it says later must find somebody who reads.
    std::thread::Builder::new().name("output".to_owned()).spawn(move || lines.for_each(drop)).unwrap();
    child
}

fn end(mut child: Child) {
    rustix::process::kill_process(rustix::process::Pid::from_child(&child), rustix::process::Signal::TERM).unwrap();
    assert!(child.wait().unwrap().success());
}

#[test]
fn first_commands_work_as_they_are_printed() {
    let home = tempfile::tempdir().unwrap();
    clone_in(home.path());
    let lines = commands("First use");
    assert!(lines.len() >= 20, "{lines:#?}");
    for line in lines {
        match line.starts_with("groundplan view") && !line.contains("--export") {
            // Its port may be taken by a page that somebody looks at.
            true => end(serves(&format!("{line} --listen 127.0.0.1:0"), home.path(), "http://127.0.0.1:")),
            false => succeeds(&line, home.path()),
        }
    }
    for made in
        ["maps/manifest.json", "maps-world/world/world.sdf", "demo.mcap", "amcl.yaml", "drive", "page/index.html"]
    {
        assert!(home.path().join(made).exists(), "{made}");
    }
}

#[test]
fn live_commands_work_as_they_are_printed() {
    // There is one demo site for each user.
    if Command::new(client()).args(["status", "--demo"]).output().unwrap().status.success() {
        announce("SKIPPED: live commands of README.md: this user's demo site runs");
        return;
    }
    let home = tempfile::tempdir().unwrap();
    clone_in(home.path());
    let lines = commands("Live use");
    assert!(lines.len() >= 12 && lines[0] == "groundplan up --demo", "{lines:#?}");
    let mut site = shell("groundplan up --demo", home.path()).stderr(Stdio::null()).spawn().unwrap();
    while !shell("groundplan status --demo", home.path()).output().unwrap().status.success() {
        assert!(site.try_wait().unwrap().is_none(), "groundplan up --demo has ended");
        std::thread::yield_now();
    }
    for line in lines.iter().skip(1).filter(|line| *line != "groundplan down --demo") {
        if line.starts_with("groundplan monitor") {
            // A screen needs a terminal.
            succeeds(&format!("{line} --json --for 0.2"), home.path());
        } else if line.contains(" --watch ") || line.starts_with("groundplan record ") {
            end(serves(line, home.path(), ""));
        } else {
            succeeds(line, home.path());
        }
    }
    succeeds("groundplan down --demo", home.path());
    assert!(site.wait().unwrap().success());
    assert!(home.path().join("maps/manifest.json").is_file());
}
