//! A planner's schedule file beside a model: links, their table, a new revision of the plan, provenance.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

use end_to_end::groundplan;
use end_to_end::house::{House, PLAIN};
use serde_json::Value;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};

/// Walls A-1020, A1030, A1040 and =A1050, each with its number as a property; A1040 is removed by D1 while it is built.
struct Project {
    home: tempfile::TempDir,
    model: PathBuf,
    plan: PathBuf,
    rules: PathBuf,
}

impl Project {
    fn new() -> Self {
        let home = tempfile::tempdir().unwrap();
        let mut house = House::new("IFC4");
        for (k, number) in ["A-1020", "A1030", "A1040", "=A1050"].into_iter().enumerate() {
            let x = 3.0 * k as f64;
            let wall = house.add("IFCWALL", &format!("=Wall {k}"), PLAIN, [[x, 0.0, 0.0], [x + 0.2, 4.0, 3.0]]);
            house.add_text_property(wall, "Pset_Plan", "4D_Number", number);
        }
        let model = house.write(home.path());
        let plan = file(home.path(), "plan.csv", PLAN);
        let rules = file(home.path(), "rules.toml", RULES);
        Self { home, model, plan, rules }
    }

    fn run(&self, command: &str, more: &[&dyn AsRef<OsStr>]) -> std::process::Output {
        let arguments: [&dyn AsRef<OsStr>; 6] =
            [&command, &self.model, &"--schedule-file", &self.plan, &"--schedule", &self.rules];
        groundplan(&[&arguments[..], more].concat())
    }

    fn json(&self, command: &str, more: &[&dyn AsRef<OsStr>]) -> Value {
        let output = self.run(command, &[&[&"--json" as &dyn AsRef<OsStr>], more].concat());
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        serde_json::from_slice(&output.stdout).unwrap()
    }
}

const PLAN: &str = "\
id,name,start,finish
A1020,Wall 0,2024-04-01T08:00:00,2024-04-05T17:00:00
A1030,Wall 1,2024-04-08T08:00:00,2024-04-12T17:00:00
A1040,Wall 2,2024-04-15T08:00:00,2024-04-19T17:00:00
D1,Demolition of A1040,2024-04-17T08:00:00,2024-04-18T17:00:00
=A1050,Wall 3,2024-04-22T08:00:00,2024-04-26T17:00:00
";

const RULES: &str = "\
[[link]]
name = \"numbers\"
task = { code = \"*A*\" }
elements = { property = \"4D_Number\", value = \"=code\" }
";

fn file(folder: &Path, name: &str, text: &str) -> PathBuf {
    let path = folder.join(name);
    std::fs::write(&path, text).unwrap();
    path
}

#[test]
fn what_fits_nothing_is_named_with_the_nearest_miss() {
    let project = Project::new();
    let report = project.json("link", &[]);
    assert_eq!((&report["tasks"]["linked"], &report["elements"]["linked"]), (&3.into(), &3.into()), "{report}");
    assert_eq!(report["rules"][0]["rule"], "numbers");
    let unlinked = |key: &str, of: &str| -> Vec<Value> {
        report[key].as_array().unwrap().iter().map(|entry| entry[of].clone()).collect()
    };
    assert_eq!(unlinked("unlinked_tasks", "task"), ["A1020", "D1"]);
    assert_eq!(unlinked("unlinked_elements", "name"), ["=Wall 0"]);
    let miss = &report["near_misses"][0];
    assert_eq!((&miss["task"], &miss["element"]), (&"a1020".into(), &"a-1020".into()));
    assert_eq!((&report["shares"][0]["linked"], &report["shares"][0]["all"]), (&3.into(), &4.into()));
    let text = String::from_utf8(project.run("link", &[]).stdout).unwrap();
    assert!(text.contains("a-1020") && text.contains("75 %"), "{text}");
}

#[test]
fn a_table_comes_back_as_it_was_written_and_holds_no_formula() {
    let project = Project::new();
    let table = project.home.path().join("links.csv");
    let first = project.json("link", &[&"--csv", &table]);
    let text = std::fs::read_to_string(&table).unwrap();
    assert!(text.contains(",'=A1050,") && text.contains(",'=Wall 0,") && !text.contains(",="), "{text}");
    let again = project.home.path().join("again.csv");
    let back = project.json("link", &[&"--link", &table, &"--csv", &again]);
    assert_eq!(std::fs::read_to_string(&again).unwrap(), text);
    assert_eq!((&back["elements"], &back["tasks"]), (&first["elements"], &first["tasks"]));
    assert_eq!(back["rules"][0]["links"], 3);
    // Completed: the wall that no rule links.
    let completed = text.replacen(",,,IfcWall,'=Wall 0", ",A1020,builds,IfcWall,'=Wall 0", 1);
    assert_ne!(completed, text);
    let completed = file(project.home.path(), "completed.csv", &completed);
    let whole = project.json("link", &[&"--link", &completed]);
    assert_eq!(whole["elements"]["linked"], 4);
    for input in [&table, &project.plan, &project.model, &project.rules] {
        let before = std::fs::read(input).unwrap();
        let refused = project.run("link", &[&"--link", &table, &"--csv", input]);
        assert_eq!(refused.status.code(), Some(2), "{}", input.display());
        assert_eq!(std::fs::read(input).unwrap(), before);
    }
}

#[test]
fn contradicting_tasks_are_named() {
    let project = Project::new();
    let links = project.home.path().join("links.csv");
    project.json("link", &[&"--csv", &links]);
    let text = std::fs::read_to_string(&links).unwrap();
    let row = text.lines().find(|line| line.contains(",A1040,")).unwrap();
    let removed = row.replace(",A1040,builds,", ",D1,removes,");
    let links = file(project.home.path(), "contradicting.csv", &format!("{text}{removed}\n"));
    let report = project.json("link", &[&"--link", &links]);
    let found = report["contradictions"].as_array().unwrap();
    assert_eq!(found.len(), 1, "{found:?}");
    assert_eq!((&found[0]["kind"], &found[0]["tasks"][1]["task"]), (&"built_while_removed".into(), &"D1".into()));
}

#[test]
fn a_new_revision_tells_which_elements_stand_later_and_when_maps_differ() {
    let project = Project::new();
    let old = file(project.home.path(), "old.csv", &PLAN.replace("2024-04-12T17", "2024-04-10T17"));
    let revision = project.json("changes", &[&"--against", &old]);
    let element = &revision["elements"][0];
    assert_eq!(revision["elements"].as_array().unwrap().len(), 1, "{revision}");
    assert_eq!((&element["name"], &element["stands"]["later_h"]), (&"=Wall 1".into(), &48.0.into()));
    let differs = &revision["storeys"][0]["differs"];
    assert_eq!(differs[0]["from"], "2024-04-10T17:00:00");
    assert_eq!(differs[0]["until"], "2024-04-12T17:00:00");
    let same = project.json("changes", &[&"--against", &project.plan]);
    assert_eq!((&same["elements"], &same["storeys"][0]["differs"]), (&Value::Array(vec![]), &Value::Array(vec![])));
    let text = String::from_utf8(project.run("changes", &[&"--against", &old]).stdout).unwrap();
    assert!(text.contains("48 h later"), "{text}");
}

#[test]
fn tasks_and_maps_name_the_file_and_the_rule_of_a_date() {
    let project = Project::new();
    let tasks = project.json("tasks", &[]);
    let task = tasks["tasks"].as_array().unwrap().iter().find(|task| task["global_id"] == "A1030").unwrap();
    assert_eq!((&task["file"], &task["elements"][0]["rule"]), (&"plan.csv".into(), &"numbers".into()));
    let out = project.home.path().join("maps");
    let done = project.run("convert", &[&"-o", &out, &"--date", &"2024-04-10"]);
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    let read = |name: &str| -> Value { serde_json::from_slice(&std::fs::read(out.join(name)).unwrap()).unwrap() };
    assert_eq!(read("manifest.json")["schedule_sources"][0]["file"], "plan.csv");
    let semantic = read("semantic.json").to_string();
    assert!(semantic.contains("\"file\":\"plan.csv\"") && semantic.contains("\"rule\":\"numbers\""), "{semantic}");
}

#[test]
fn links_and_revisions_without_a_schedule_file_are_bad_usage() {
    let project = Project::new();
    let refused = groundplan(&[&"link", &project.model]);
    assert_eq!(refused.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&refused.stderr).contains("--schedule-file is needed"));
    for alone in ["--against", "--link"] {
        let refused = groundplan(&[&"changes", &project.model, &alone, &project.plan]);
        assert_eq!(refused.status.code(), Some(2), "{alone}");
    }
}
