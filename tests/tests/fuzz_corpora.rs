//! The committed inputs of the fuzz targets: each target reads its own again, as the fuzzer does, without a panic.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

#[allow(unreachable_pub, reason = "the fuzzer has these files as a library")]
#[path = "../fuzz/src/targets/mod.rs"]
mod targets;

use std::path::Path;

/// Runs a target on its corpus.
fn replay(target: &str, run: fn(&[u8])) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz/corpus").join(target);
    let mut paths: Vec<_> = std::fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    paths.sort();
    assert!(!paths.is_empty(), "{} is empty", folder.display());
    for path in paths {
        let bytes = std::fs::read(&path).unwrap();
        // A test prints this where it fails.
        eprintln!("{}", path.display());
        run(&bytes);
    }
}

#[test]
fn ifc_files_of_the_fuzzer_are_read_or_refused() {
    replay("ifc", targets::ifc::run);
}

#[test]
fn ids_files_of_the_fuzzer_are_checked_or_refused() {
    replay("ids", targets::ids::run);
}

#[test]
fn schedules_of_the_fuzzer_are_evaluated_or_refused() {
    replay("schedule", targets::schedule::run);
}

#[test]
fn schedule_files_of_the_fuzzer_are_read_or_refused() {
    replay("schedule_files", targets::schedule_files::run);
}

#[test]
fn map_files_of_the_fuzzer_are_read_or_refused() {
    replay("map_file", targets::map_file::run);
}

#[test]
fn configurations_of_the_fuzzer_are_used_or_refused() {
    replay("configuration", targets::configuration::run);
}

#[test]
fn archives_of_the_fuzzer_are_read_or_refused() {
    replay("archives", targets::archives::run);
}

#[test]
fn changed_archives_of_the_fuzzer_stop_no_stage() {
    replay("stages", targets::stages::run);
}

#[test]
fn every_fuzz_target_has_a_program_a_corpus_and_a_replay() {
    let fuzz = Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz");
    let manifest: toml::Table = std::fs::read_to_string(fuzz.join("Cargo.toml")).unwrap().parse().unwrap();
    let mut programs: Vec<_> =
        manifest["bin"].as_array().unwrap().iter().map(|bin| bin["name"].as_str().unwrap()).collect();
    programs.sort_unstable();
    assert_eq!(
        programs,
        ["archives", "configuration", "ids", "ifc", "map_file", "schedule", "schedule_files", "stages"]
    );
    for program in programs {
        assert!(
            fuzz.join("corpus").join(program).is_dir() && fuzz.join(format!("fuzz_targets/{program}.rs")).is_file()
        );
    }
}
