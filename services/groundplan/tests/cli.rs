//! The program's output and exit codes. The help of each command is a golden file; UPDATE_GOLDEN=1 rewrites them.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

use clap::CommandFactory;
use groundplan::cli::Cli;
use std::collections::BTreeMap;
use std::path::Path;
use std::process::Command;

fn groundplan(arguments: &[&str]) -> std::process::Output {
    Command::new(env!("CARGO_BIN_EXE_groundplan")).args(arguments).output().unwrap()
}

/// The words that call each command, hidden ones too; none for the program itself.
fn every_command(words: &[String], command: &clap::Command) -> Vec<Vec<String>> {
    let nested = command.get_subcommands().flat_map(|command| {
        let words: Vec<String> = words.iter().cloned().chain([command.get_name().to_owned()]).collect();
        every_command(&words, command)
    });
    std::iter::once(words.to_vec()).chain(nested).collect()
}

#[test]
fn the_help_of_every_command_is_its_golden_file_and_there_is_no_other() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden/help");
    let help = |words: Vec<String>| {
        let name = if words.is_empty() { "groundplan".to_owned() } else { words.join("_") };
        let arguments: Vec<&str> = words.iter().map(String::as_str).chain(["--help"]).collect();
        (format!("{name}.txt"), String::from_utf8(groundplan(&arguments).stdout).unwrap())
    };
    let printed: BTreeMap<String, String> = every_command(&[], &Cli::command()).into_iter().map(help).collect();
    if std::env::var_os("UPDATE_GOLDEN").is_some() {
        std::fs::remove_dir_all(&folder).unwrap();
        std::fs::create_dir(&folder).unwrap();
        printed.iter().for_each(|(name, text)| std::fs::write(folder.join(name), text).unwrap());
    }
    let files = std::fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap());
    let golden: BTreeMap<String, String> =
        files.map(|name| (name.clone(), std::fs::read_to_string(folder.join(name)).unwrap())).collect();
    assert_eq!(golden.keys().collect::<Vec<_>>(), printed.keys().collect::<Vec<_>>(), "UPDATE_GOLDEN=1 rewrites them");
    for (name, text) in &printed {
        assert_eq!(text, &golden[name], "UPDATE_GOLDEN=1 rewrites {name}");
    }
}

#[test]
fn the_version_is_that_of_the_workspace_and_names_the_commit() {
    let said = String::from_utf8(groundplan(&["--version"]).stdout).unwrap();
    let version = concat!("groundplan ", env!("CARGO_PKG_VERSION"), " (commit ");
    assert!(said.starts_with(version) && said.ends_with(")\n"), "{said}");
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
    assert_eq!(summary["storeys"].as_array().unwrap().len(), 4);
    assert_eq!(summary["schedule_ignored"], true);
}

#[test]
fn probabilities_of_the_demo_are_listed_and_drawn() {
    let home = tempfile::tempdir().unwrap();
    let out = home.path().join("out");
    let model = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../config/demo/demo.ifc");
    let (model, folder) = (model.to_str().unwrap(), out.to_str().unwrap());
    let output = groundplan(&["states", model, "--date", "2024-04-27", "--probability", "--json"]);
    let states: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let found = &states["probability"];
    assert_eq!((&found["runs"], &found["seed"]), (&2000.into(), &1.into()));
    let elements = found["elements"].as_object().unwrap();
    assert_eq!(elements.len(), states["elements"].as_object().unwrap().len());
    let stands_and_there: Vec<[f64; 2]> =
        elements.values().map(|e| ["stands", "there"].map(|key| e[key].as_f64().unwrap())).collect();
    assert!(stands_and_there.iter().all(|[stands, there]| 0.0 <= *stands && stands <= there && *there <= 1.0));
    assert!(stands_and_there.iter().any(|[stands, _]| 0.0 < *stands && *stands < 1.0));
    for space in found["spaces"].as_object().unwrap().values() {
        let safest: Vec<f64> =
            space["safest_days"].as_array().unwrap().iter().map(|day| day["open"].as_f64().unwrap()).collect();
        assert!(safest.len() <= 5 && safest.iter().all(|open| *open > 0.0));
        assert!(safest.is_sorted_by(|a, b| a >= b));
    }

    let output = groundplan(&["convert", model, "-o", folder, "--date", "2024-04-27", "--probability", "--json"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let manifest = std::fs::read(out.join("manifest.json")).unwrap();
    let manifest: serde_json::Value = serde_json::from_slice(&manifest).unwrap();
    let expected =
        serde_json::json!({"runs": 2000, "seed": 1, "obstacle_above": 0.05, "floor_above": 0.95, "open_above": 0.95});
    assert_eq!(manifest["probability"], expected);
    for storey in manifest["storeys"].as_array().unwrap() {
        let folder = storey["directory"].as_str().unwrap();
        for file in ["probability.png", "probability.pgm", "probability.yaml"] {
            assert!(manifest["files"].get(format!("{folder}/{file}")).is_some(), "{folder}/{file}");
        }
        let yaml = std::fs::read_to_string(out.join(folder).join("probability.yaml")).unwrap();
        assert!(yaml.contains("mode: scale\n"), "{yaml}");
    }
}

#[test]
fn maps_by_probability_need_one_date() {
    for arguments in [&["--probability"][..], &["--probability", "--date", "all"]] {
        let output = groundplan(&[&["convert", "house.ifc", "-o", "/tmp/never-written"], arguments].concat());
        assert_eq!(output.status.code(), Some(2), "{}", String::from_utf8_lossy(&output.stderr));
        assert!(String::from_utf8_lossy(&output.stderr).contains("--date"), "{arguments:?}");
    }
}
