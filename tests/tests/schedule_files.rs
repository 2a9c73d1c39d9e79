//! Schedule files of planners' tools from file to maps: the same as the schedule in the model, and bad ones.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

mod support;

use serde_json::Value;
use std::collections::BTreeMap;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use support::{convert, demo_model, groundplan, root};

/// The schedule of the demo building in the forms of planners' tools.
fn demo_schedules() -> [PathBuf; 4] {
    [
        "config/demo/demo-schedule.xer",
        "tests/fixtures/demo-schedule.pmxml",
        "tests/fixtures/demo-schedule.xml",
        "tests/fixtures/demo-schedule.csv",
    ]
    .map(|path| root().join(path))
}

fn json(arguments: &[&dyn AsRef<OsStr>]) -> Value {
    let output = groundplan(arguments);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

/// Files that say nothing of schedules: all but what names tasks, sources and dates.
fn maps(model: &Path, more: &[&str]) -> BTreeMap<PathBuf, Vec<u8>> {
    let names_tasks = |path: &Path| {
        let name = path.file_name().unwrap().to_string_lossy();
        ["manifest.json", "report.json", "semantic.json"].contains(&&*name)
    };
    let mut maps = convert(model, more).contents();
    maps.retain(|path, _| !names_tasks(path));
    maps
}

#[test]
fn every_form_of_the_same_schedule_gives_the_maps_of_the_schedule_in_the_model() {
    let model = demo_model();
    let of_model = maps(&model, &["--date", "all"]);
    assert!(of_model.keys().filter(|path| path.extension().is_some_and(|e| e == "pgm")).count() > 100);
    for schedule in demo_schedules() {
        let of_file = maps(&model, &["--date", "all", "--schedule-file", schedule.to_str().unwrap()]);
        let differing: Vec<&PathBuf> = of_model
            .iter()
            .filter(|(path, content)| of_file.get(*path) != Some(content))
            .map(|(path, _)| path)
            .collect();
        assert_eq!(differing, Vec::<&PathBuf>::new(), "{}", schedule.display());
        assert!(of_model.keys().eq(of_file.keys()), "{}", schedule.display());
    }
}

#[test]
fn states_and_changes_are_those_of_the_schedule_in_the_model() {
    let model = demo_model();
    let changes = json(&[&"changes", &model, &"--json"]);
    for schedule in demo_schedules() {
        let of_file = json(&[&"changes", &model, &"--json", &"--schedule-file", &schedule]);
        for key in ["change_instants", "changes"] {
            assert_eq!(of_file[key], changes[key], "{}: {key}", schedule.display());
        }
    }
}
