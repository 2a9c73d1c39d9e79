//! Tests of a daemon as a process, for packages that are named as their program.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

use std::process::{Command, Output};

fn run(arguments: &[&str]) -> Output {
    Command::new(env!(concat!("CARGO_BIN_EXE_", env!("CARGO_PKG_NAME")))).args(arguments).output().unwrap()
}

#[test]
fn a_configuration_that_cannot_be_used_exits_with_2_and_is_named() {
    let output = run(&["--config", "/nowhere/site.toml"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stderr).contains("/nowhere/site.toml"));
}

#[test]
fn the_version_is_that_of_the_workspace_and_names_the_commit() {
    let said = String::from_utf8(run(&["--version"]).stdout).unwrap();
    let version = concat!(env!("CARGO_PKG_NAME"), " ", env!("CARGO_PKG_VERSION"), " (commit ");
    assert!(said.starts_with(version) && said.ends_with(")\n"), "{said}");
}
