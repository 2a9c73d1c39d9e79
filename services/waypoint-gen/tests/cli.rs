//! The daemon as a process.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

use std::process::{Command, Output};

fn run(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_waypoint-gen")).args(arguments).output().unwrap()
}

#[test]
fn a_configuration_that_cannot_be_used_exits_with_2_and_is_named() {
    let output = run(&["--config", "/nowhere/site.toml"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stderr).contains("/nowhere/site.toml"));
}

#[test]
fn the_version_is_that_of_the_workspace() {
    assert_eq!(
        String::from_utf8_lossy(&run(&["--version"]).stdout).trim(),
        concat!("waypoint-gen ", env!("CARGO_PKG_VERSION"))
    );
}
