//! The files of the shared corpus. They are not part of the repository: `GROUNDPLAN_CORPUS` or `../shared/corpus`
//! beside the workspace; without them these tests say so and pass.

#![expect(clippy::unwrap_used, reason = "helpers of tests may")]

use std::io::Write;
use std::path::{Path, PathBuf};

use ifc::{Diagnostic, GeometryStatus, MeshPool, Model, ReadError, ReadOptions, Severity};

fn corpus() -> Option<PathBuf> {
    let beside = || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/corpus");
    let folder = std::env::var_os("GROUNDPLAN_CORPUS").map_or_else(beside, PathBuf::from);
    if !folder.is_dir() {
        // Not by `eprintln`, which the test harness captures.
        let line = format!("\n** SKIPPED: no corpus at {} (set GROUNDPLAN_CORPUS)\n", folder.display());
        std::io::stderr().write_all(line.as_bytes()).unwrap();
        return None;
    }
    Some(folder)
}

fn read(path: &Path, threads: usize) -> Result<(Model, Vec<Diagnostic>), ReadError> {
    let bytes = std::fs::read(path).unwrap();
    let pool = MeshPool::new(threads)?;
    ifc::read(&bytes, &ReadOptions { pool: Some(&pool), ..ReadOptions::default() })
}

fn files(folder: &Path) -> Vec<PathBuf> {
    let mut files: Vec<PathBuf> = std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect();
    files.retain(|f| f.is_file());
    files.sort();
    files
}

/// Elements, of them with a mesh and with a box; spaces, openings, storeys.
type Counts = [usize; 6];

fn counts(model: &Model) -> Counts {
    let status =
        |wanted: fn(&GeometryStatus) -> bool| model.elements.iter().filter(|e| wanted(&e.geometry.status)).count();
    let meshed = status(|s| *s == GeometryStatus::Meshed);
    let boxed = status(|s| matches!(s, GeometryStatus::BoundingBox { .. }));
    assert_eq!(status(|s| matches!(s, GeometryStatus::Failed { .. })), 0);
    [model.elements.len(), meshed, boxed, model.spaces.len(), model.openings.len(), model.storeys.len()]
}

/// What files are known for: part of the error, or the counts.
const EXPECTED: &[(&str, Result<Counts, &str>)] = &[
    ("malformed/dot_after_specifier.ifc", Ok([0; 6])),
    ("malformed/empty_file.ifc", Err("empty")),
    ("malformed/invalid_file.ifc", Err("no IFC file")),
    ("malformed/invalid_utf8_with_bom.ifc", Ok([0; 6])),
    ("malformed/invalid_xss_file_missing_apostrophe.ifc", Err("FILE_SCHEMA")),
    ("units/pass-brp003-large_coords.ifc", Err("length unit")),
    ("units/column-straight-rectangle-tessellation.ifc", Ok([1, 1, 0, 0, 0, 0])),
    ("representations/beam-revolved-solid-tapered.ifc", Ok([1, 0, 1, 0, 0, 0])),
    ("representations/FixedReferenceSweptAreaSolid-1.ifc", Ok([1, 0, 1, 0, 0, 0])),
    ("representations/grid-placement.ifc", Ok([35, 35, 0, 0, 0, 1])),
    ("representations/Ifc4_WallElementedCase.ifc", Ok([13, 4, 0, 0, 2, 0])),
    ("buildings/AC20-FZK-Haus.ifc", Ok([82, 82, 0, 7, 17, 2])),
    ("buildings/Duplex_A_20110907_georeferenced.ifc", Ok([218, 215, 0, 21, 50, 4])),
    ("buildings/IFC-houten_kozijnen.ifc", Ok([164, 100, 0, 0, 69, 4])),
    ("buildings/ROOT-houten_kozijnen.ifczip", Ok([164, 100, 0, 0, 69, 4])),
    ("buildings/creative-freedom.ifc", Ok([329, 299, 0, 4, 26, 8])),
    ("buildings/fhnw-three-storeys.ifc", Ok([492, 464, 0, 48, 58, 3])),
];

#[test]
fn every_file_ends_as_expected() {
    let Some(corpus) = corpus() else { return };
    for folder in ["malformed", "units", "representations", "buildings"] {
        for path in files(&corpus.join(folder)) {
            let name = format!("{folder}/{}", path.file_name().unwrap().to_string_lossy());
            let outcome = read(&path, 0);
            match (EXPECTED.iter().find(|(file, _)| *file == name).map(|(_, e)| e), outcome) {
                (Some(Ok(expected)), Ok((model, _))) => assert_eq!(counts(&model), *expected, "{name}"),
                (Some(Err(words)), Err(error)) => assert!(error.to_string().contains(words), "{name}: {error}"),
                (None, Ok((model, _))) => drop(counts(&model)),
                (_, Ok(_)) => panic!("{name} was read"),
                (_, Err(error)) => panic!("{name}: {error}"),
            }
        }
    }
}

#[test]
fn results_do_not_depend_on_threads() {
    let Some(corpus) = corpus() else { return };
    // The last has shapes that several products share and that lack a face.
    for name in ["Duplex_A_20110907_georeferenced.ifc", "creative-freedom.ifc", "MULTICOM-balkons.ifc"] {
        let read = |threads| format!("{:?}", read(&corpus.join("buildings").join(name), threads).unwrap());
        let one = read(1);
        assert!((0..3).all(|_| read(2) == one), "{name}");
    }
}

#[test]
fn units_are_those_of_the_file() {
    let Some(corpus) = corpus() else { return };
    for (name, metres) in [
        ("column-straight-rectangle-tessellation.ifc", 0.0254),
        ("fail-pjs001-scenario01-furlong_ifc4x3.ifc", 201.168),
        ("pass-pjs001-ft_ifc2x3.ifc", 0.3048),
        ("pass-pjs001-us_survey_foot_ifc4x3.ifc", 0.304_800_609_601_22),
    ] {
        let (model, _) = read(&corpus.join("units").join(name), 1).unwrap();
        assert!((model.source.length_unit_m - metres).abs() < 1e-12, "{name}");
    }
}

#[test]
fn schedules_of_the_corpus_are_read_whole() {
    let Some(folder) = corpus() else { return };
    // Tasks, of them with a time; sequences; links, those of whole bridges to each of their parts; calendars.
    for (file, expected) in [
        ("construction_scheduling_task.ifc", [8, 8, 7, 6, 1]),
        ("pass-sps005-valid_structural_relationship.ifc", [14, 0, 9, 16, 0]),
        ("generated/duplex-timecontrol.ifc", [55, 41, 75, 167, 0]),
        ("generated/fzk-ifctask-computed.ifc", [38, 28, 47, 178, 1]),
    ] {
        let (model, diagnostics) = read(&folder.join("schedule").join(file), 1).unwrap();
        let schedule = &model.schedule;
        let n_times = schedule.tasks.iter().filter(|t| t.time.is_some()).count();
        let (n_sequences, n_links) = (schedule.sequences.len(), schedule.links.len());
        let found = [schedule.tasks.len(), n_times, n_sequences, n_links, schedule.calendars.len()];
        assert_eq!(found, expected, "{file}");
        let is_lost = |d: &&Diagnostic| d.severity == Severity::Error;
        let problems: Vec<&str> = diagnostics.iter().filter(is_lost).map(|d| d.message.as_str()).collect();
        assert!(problems.is_empty(), "{file}: {problems:?}");
    }
}
