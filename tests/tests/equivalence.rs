//! The daemons write what `convert` writes, for every building of the corpus: a line for each.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

use end_to_end::live::Live;
use end_to_end::{contents, corpus, files_in, groundplan};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Dates of a walk over a schedule: many steps, and where it ends.
const STEPS: usize = 10;

/// The first file in which two folders differ.
fn difference(one: &Path, other: &Path) -> Option<PathBuf> {
    let [one, other] = [one, other].map(|folder| contents(folder).into_iter().collect::<BTreeMap<_, _>>());
    one.keys().chain(other.keys()).find(|name| one.get(*name) != other.get(*name)).cloned()
}

/// Some files have dates that fit two orders; both sides read them in the same one.
const RULES: &str = "date_format = \"dmy\"\n";

/// A few instants of a file's schedule, in an order that depends on its length alone.
fn walk_of(model: &Path, rules: &Path) -> Vec<String> {
    let output = groundplan(&[&"changes", &model, &"--json", &"--schedule", &rules]);
    let Ok(changes) = serde_json::from_slice::<serde_json::Value>(&output.stdout) else { return Vec::new() };
    let instants: Vec<String> =
        changes["change_instants"].as_array().unwrap().iter().map(|i| i.as_str().unwrap().to_owned()).collect();
    let n = instants.len();
    (0..STEPS.min(n)).map(|k| instants[(k * 7 + 3) % n].clone()).collect()
}

/// Exports from daemons after a walk over dates, and converts at the last of them.
fn check(model: &Path) -> Result<String, String> {
    let home = tempfile::tempdir().unwrap();
    let rules = home.path().join("rules.toml");
    std::fs::write(&rules, RULES).unwrap();
    let walk = walk_of(model, &rules);
    let mut live = Live::of(model, &format!("[schedule]\nrules = {rules:?}\n"));
    for date in &walk {
        live.text(&[&"date", date]);
    }
    let (exported, converted) = (live.home.path().join("exported"), live.home.path().join("converted"));
    let model = live.home.path().join("demo.ifc");
    let mut convert: Vec<&dyn AsRef<std::ffi::OsStr>> =
        vec![&"convert", &model, &"-o", &converted, &"--schedule", &rules, &"--world", &"--with-ground"];
    if let Some(date) = walk.last() {
        convert.extend([&"--date" as &dyn AsRef<std::ffi::OsStr>, date]);
    }
    let converted_well = groundplan(&convert).status.success();
    let output = live.run(&[&"export", &exported, &"--world", &"--with-ground"]);
    live.down();
    match (converted_well, output.status.success()) {
        (false, _) => return Ok("is no map, for convert either".to_owned()),
        (true, false) => return Err(format!("cannot be exported: {}", String::from_utf8_lossy(&output.stderr))),
        (true, true) => {}
    }
    match difference(&exported, &converted) {
        None => Ok(format!("equal, {} files after {} dates", contents(&exported).len(), walk.len())),
        Some(name) => Err(format!("{} differs after {} dates", name.display(), walk.len())),
    }
}

#[test]
#[ignore = "minutes, needs the corpus: scripts/test --corpus"]
fn export_is_convert_for_every_building_of_the_corpus() {
    let folders = ["buildings", "schedule/generated"].map(corpus);
    let models = folders.iter().flatten().flat_map(|folder| files_in(folder));
    let models = models.filter(|path| path.extension().is_some_and(|e| e == "ifc"));
    let mut wrong = 0;
    for model in models {
        let name = model.file_name().unwrap().to_string_lossy().into_owned();
        match check(&model) {
            Ok(words) => println!("{name}: {words}"),
            Err(words) => {
                wrong += 1;
                println!("{name}: {words}");
            }
        }
    }
    assert_eq!(wrong, 0);
}
