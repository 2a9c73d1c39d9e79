//! buildingSMART's test cases of IDS 1.0. They are not part of the repository: `GROUNDPLAN_CORPUS` or `../shared/corpus` names the
//! folder, and without it these tests are skipped, loudly.

#![expect(clippy::unwrap_used, reason = "helpers of tests may")]

use std::io::Write as _;
use std::path::{Path, PathBuf};

use ids::{CheckError, Ids, IdsError, Scope};

/// Test cases that there are at least: fewer are a corpus that is not complete.
const CASES_MIN: usize = 300;

fn cases() -> Option<Vec<PathBuf>> {
    let beside = || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/corpus");
    let folder = std::env::var_os("GROUNDPLAN_CORPUS").map_or_else(beside, PathBuf::from).join("ids/testcases");
    if !folder.is_dir() {
        let line = format!("\n** SKIPPED: no test cases of IDS at {} (set GROUNDPLAN_CORPUS)\n", folder.display());
        // Not caught by the test harness.
        std::io::stderr().write_all(line.as_bytes()).unwrap();
        return None;
    }
    let folders = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).filter(|path| path.is_dir());
    let files = folders.flat_map(|folder| std::fs::read_dir(folder).unwrap()).map(|entry| entry.unwrap().path());
    let mut cases: Vec<PathBuf> = files.filter(|path| path.extension().is_some_and(|e| e == "ids")).collect();
    cases.sort();
    assert!(cases.len() >= CASES_MIN, "{} test cases", cases.len());
    Some(cases)
}

/// The answer in the words of the test cases.
fn answer(case: &Path) -> &'static str {
    let ids = match Ids::read(&std::fs::read(case).unwrap()) {
        Ok(ids) => ids,
        Err(IdsError::Unsatisfiable { .. }) => return "invalid",
        Err(error) => panic!("{}: {error}", case.display()),
    };
    let ifc = std::fs::read(case.with_extension("ifc")).unwrap();
    match ids::check(&ids, &ifc, Scope::All) {
        Ok(report) if report.passed => "pass",
        Ok(_) => "fail",
        Err(CheckError::Ifc(error)) => panic!("{}: {error}", case.display()),
    }
}

#[test]
fn every_test_case_has_the_answer_that_its_name_says() {
    let Some(cases) = cases() else { return };
    let wrong = cases.iter().filter_map(|case| {
        let name = case.file_name().unwrap().to_str().unwrap();
        let (expected, answer) = (name.split_once('-').unwrap().0, answer(case));
        (expected != answer).then(|| format!("{name}: {answer}"))
    });
    let wrong: Vec<String> = wrong.collect();
    assert!(wrong.is_empty(), "{} of {} wrong:\n{}", wrong.len(), cases.len(), wrong.join("\n"));
}
