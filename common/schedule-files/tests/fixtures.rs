//! Files that MPXJ wrote are read as MPXJ reads them: `scripts/check_schedule_files.py --write-fixtures` makes files and expectations.

mod plan_json;

use schedule_files::ReadOptions;
use serde_json::Value;
use std::path::PathBuf;

fn folder() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures")
}

/// Paths and values that differ, to be read when the test fails.
fn differences(path: &str, expected: &Value, read: &Value, out: &mut Vec<String>) {
    match (expected, read) {
        // What is not expected of a task is a known difference; days of calendars are all there.
        (Value::Object(a), Value::Object(b)) if a.len() == b.len() || !path.ends_with("/days") => {
            a.iter().for_each(|(key, value)| differences(&format!("{path}/{key}"), value, &b[key], out));
        }
        (Value::Array(a), Value::Array(b)) if a.len() == b.len() => {
            a.iter().zip(b).enumerate().for_each(|(k, (a, b))| differences(&format!("{path}/{k}"), a, b, out));
        }
        _ if expected == read => {}
        _ => out.push(format!("{path}: MPXJ reads {expected}, here it is {read}")),
    }
}

#[test]
fn files_are_read_as_mpxj_reads_them() {
    // MPXJ writes XER in the code page of the computer, which the file does not name.
    let options = ReadOptions { encoding: Some("windows-1252".to_owned()), ..ReadOptions::default() };
    let mut n_files = 0;
    let mut out = Vec::new();
    for entry in std::fs::read_dir(folder()).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_str().unwrap();
        let Some(plan) = name.strip_suffix(".expected.json") else { continue };
        let expected: Value = serde_json::from_slice(&std::fs::read(&path).unwrap()).unwrap();
        let bytes = std::fs::read(folder().join(plan)).unwrap();
        let file = schedule_files::read(plan, &bytes, &options).unwrap();
        assert!(file.findings.is_empty(), "{plan}: {:?}", file.findings);
        // As the other side does, through text.
        let read = serde_json::from_str(&plan_json::plan_json(&file).to_string()).unwrap();
        differences(plan, &expected, &read, &mut out);
        n_files += 1;
    }
    assert!(out.is_empty(), "{}", out.join("\n"));
    assert_eq!(n_files, 9);
}
