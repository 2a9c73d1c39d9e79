//! The program as a process.

#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

use std::process::{Command, Output, Stdio};

fn run(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_groundplan-ask")).args(arguments).stdin(Stdio::null()).output().unwrap()
}

#[test]
fn a_configuration_that_cannot_be_used_is_named() {
    for (more, code) in [(&[][..], 2), (&["--stdio"][..], 1)] {
        let output = run(&[&["--config", "/nowhere/site.toml"][..], more].concat());
        assert_eq!(output.status.code(), Some(code));
        assert!(String::from_utf8_lossy(&output.stderr).contains("/nowhere/site.toml"));
        assert!(output.stdout.is_empty(), "standard output is for the client");
    }
}

#[test]
fn the_version_is_that_of_the_workspace_and_names_the_commit() {
    let said = String::from_utf8(run(&["--version"]).stdout).unwrap();
    let version = concat!("groundplan-ask ", env!("CARGO_PKG_VERSION"), " (commit ");
    assert!(said.starts_with(version) && said.ends_with(")\n"), "{said}");
}
