//! The manual is a golden text; UPDATE_GOLDEN=1 rewrites it.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

use std::path::Path;
use std::process::Command;

fn groundplan(arguments: &[&str]) -> std::process::Output {
    Command::new(env!("CARGO_BIN_EXE_groundplan")).args(arguments).output().unwrap()
}

#[test]
fn the_manuals_are_what_they_were() {
    for command in ["convert", "states", "changes", "tasks"] {
        let text = String::from_utf8(groundplan(&[command, "--help"]).stdout).unwrap();
        let golden = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("tests/{command}-help.txt"));
        if std::env::var_os("UPDATE_GOLDEN").is_some() {
            std::fs::write(&golden, &text).unwrap();
        }
        assert_eq!(text, std::fs::read_to_string(&golden).unwrap(), "UPDATE_GOLDEN=1 rewrites {}", golden.display());
    }
}

/// Commands for running daemons, one after the other in one text.
#[test]
fn the_manuals_of_the_daemons_are_what_they_were() {
    let commands = [
        "up",
        "down",
        "status",
        "load",
        "date",
        "actuals",
        "robot",
        "monitor",
        "topic",
        "topic list",
        "topic echo",
        "topic hz",
        "export",
        "doctor",
        "completions",
        "man",
    ];
    let help = |command: &str| {
        let words: Vec<&str> = command.split(' ').chain(["--help"]).collect();
        format!("== {command}\n{}\n", String::from_utf8(groundplan(&words).stdout).unwrap())
    };
    let text: String = std::iter::once(String::from_utf8(groundplan(&["--help"]).stdout).unwrap() + "\n")
        .chain(commands.map(help))
        .collect();
    let golden = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden/daemons-help.txt");
    if std::env::var_os("UPDATE_GOLDEN").is_some() {
        std::fs::write(&golden, &text).unwrap();
    }
    assert_eq!(text, std::fs::read_to_string(&golden).unwrap_or_default(), "UPDATE_GOLDEN=1 rewrites it");
}

#[test]
fn completions_and_manual_pages_know_every_command() {
    let completions = String::from_utf8(groundplan(&["completions", "bash"]).stdout).unwrap();
    assert!(completions.contains("monitor") && completions.contains("--on-change"));
    let home = tempfile::tempdir().unwrap();
    assert!(groundplan(&["man", home.path().to_str().unwrap()]).status.success());
    let page = std::fs::read_to_string(home.path().join("groundplan-export.1")).unwrap();
    assert!(page.contains("watch"), "{page}");
}

#[test]
fn a_doctor_without_a_site_says_so_and_fails() {
    let output = groundplan(&["doctor", "--json", "--config", "/nowhere/site.toml"]);
    assert_eq!(output.status.code(), Some(1));
    let checks: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let checks = checks.as_array().unwrap();
    let verdict = |what: &str| checks.iter().find(|c| c["what"] == what).unwrap()["verdict"].clone();
    assert_eq!((verdict("configuration"), verdict("kernel").is_string()), ("failure".into(), true));
}

#[test]
fn usage_errors_exit_with_2_and_say_what_is_missing() {
    let output = groundplan(&["convert", "house.ifc"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stderr).contains("--out"));
}

#[test]
fn a_missing_model_exits_with_1_and_is_named() {
    let output = groundplan(&["convert", "/nowhere/house.ifc", "-o", "/tmp/never-written"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&output.stderr).contains("/nowhere/house.ifc"));
}

#[test]
fn json_is_one_document_and_nothing_else() {
    let home = tempfile::tempdir().unwrap();
    let out = home.path().join("out");
    let model = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../config/demo/demo.ifc");
    let output = groundplan(&["convert", model.to_str().unwrap(), "-o", out.to_str().unwrap(), "--json"]);
    let summary: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(summary["storeys"].as_array().unwrap().len(), 3);
    assert_eq!(summary["schedule_ignored"], true);
}
