//! The program as a process.

#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

use std::process::{Command, Output};

fn run(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_groundplan-web")).args(arguments).output().unwrap()
}

#[test]
fn a_configuration_that_cannot_be_used_exits_with_2_and_is_named() {
    let output = run(&["--config", "/nowhere/site.toml"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stderr).contains("/nowhere/site.toml"));
}

#[test]
fn a_folder_without_maps_is_a_failure_that_says_what_makes_them() {
    let folder = tempfile::tempdir().unwrap();
    let output = run(&["--out", folder.path().to_str().unwrap(), "--listen", "127.0.0.1:0"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&output.stderr).contains("groundplan convert"));
}

#[test]
fn the_version_is_that_of_the_workspace_and_names_the_commit() {
    let said = String::from_utf8(run(&["--version"]).stdout).unwrap();
    let version = concat!("groundplan-web ", env!("CARGO_PKG_VERSION"), " (commit ");
    assert!(said.starts_with(version) && said.ends_with(")\n"), "{said}");
}
