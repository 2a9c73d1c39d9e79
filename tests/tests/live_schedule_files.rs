//! Schedule files of a running site: in the place of the model's schedule, read again when they change, kept when they are spoilt.

use end_to_end::live::{DEADLINE, Live, POLL_INTERVAL};
use end_to_end::{contents, demo_model, groundplan, root};
use serde_json::Value;
use std::path::Path;
use std::process::Command;
use std::time::Instant;

const DATE: &str = "2024-04-29T10:00:00";

/// The files of the daemons are those of a conversion with this schedule file.
fn check_export_is_convert(live: &Live, plan: &Path) {
    let (exported, converted) = (live.home.path().join("exported"), live.home.path().join("converted"));
    live.text(&[&"export", &exported]);
    let model = live.home.path().join("demo.ifc");
    let output = groundplan(&[&"convert", &model, &"-o", &converted, &"--date", &DATE, &"--schedule-file", &plan]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let (exported, converted) = (contents(&exported), contents(&converted));
    assert!(exported.len() > 20);
    for (one, other) in exported.iter().zip(&converted) {
        assert!(one == other, "{} differs", one.0.display());
    }
    assert_eq!(exported.len(), converted.len());
}

/// The hash of the index of grids, once it is another one.
fn next_index(live: &Live, before: &Value) -> Value {
    let begun = Instant::now();
    loop {
        let index = live.index()["content_hash"].clone();
        if index != *before {
            return index;
        }
        assert!(begun.elapsed() < DEADLINE, "{:?}", live.status());
        std::thread::sleep(POLL_INTERVAL);
    }
}

#[test]
fn a_plan_that_changes_draws_the_maps_anew_and_one_that_is_spoilt_changes_nothing() {
    let plans = tempfile::tempdir().unwrap();
    let plan = plans.path().join("plan.csv");
    let of_2024 = std::fs::read_to_string(root().join("tests/fixtures/demo-schedule.csv")).unwrap();
    std::fs::write(&plan, &of_2024).unwrap();
    let schedule = format!("[schedule]\nplan_time = {DATE:?}\nfiles = [{:?}]\n", plan.display().to_string());
    let mut live = Live::of(&demo_model(), &schedule);
    let tasks: Value = serde_json::from_str(&live.text(&[&"topic", &"echo", &"tasks"])).unwrap();
    assert_eq!(tasks["content"]["files"], serde_json::json!(["plan.csv"]));
    assert!(tasks["content"]["links"].as_u64().unwrap() > 10);
    check_export_is_convert(&live, &plan);

    // A revision of the plan, a year later: nothing stands yet.
    let before = live.index()["content_hash"].clone();
    std::fs::write(&plan, of_2024.replace(".2024", ".2025")).unwrap();
    let revised = next_index(&live, &before);
    live.wait_until_healthy();
    check_export_is_convert(&live, &plan);

    std::fs::write(&plan, b"%PDF-1.7\nno schedule").unwrap();
    let warns = |s: &Value| s["daemons"]["schedule-eval"]["warning"].as_str().is_some_and(|w| w.contains("plan.csv"));
    let before = live.wait_for_status("the spoilt file is told", warns);
    let process = before["daemons"]["schedule-eval"]["process_id"].clone();
    assert!(
        process.as_u64().unwrap() > 1
            && Command::new("kill").args(["-9", &process.to_string()]).status().unwrap().success()
    );
    let is_new = |s: &Value| warns(s) && s["daemons"]["schedule-eval"]["process_id"] != process;
    live.wait_for_status("it is told after a restart too", is_new);
    assert_eq!(live.index()["content_hash"], revised, "the plan of before stays");
    live.down();
}

#[test]
fn a_revision_is_judged_without_the_tasks_of_the_model_that_schedule_files_replace() {
    // Three tasks of the model have the name on which progress is reported; one of the schedule file has it.
    let twins = tempfile::tempdir().unwrap();
    let model = twins.path().join("twins.ifc");
    let demo = std::fs::read_to_string(demo_model()).unwrap();
    let text = demo.replace("$,'Stair',$,$,'1.4'", "$,'Bathroom flooring',$,$,'1.4'");
    let text = text.replace("$,'Upper slab',$,$,'1.3'", "$,'Bathroom flooring',$,$,'1.3'");
    assert_eq!(text.matches("'Bathroom flooring'").count(), 3);
    std::fs::write(&model, &text).unwrap();
    let plan = root().join("config/demo/demo-schedule.xer");
    let schedule = format!("[schedule]\nplan_time = {DATE:?}\nfiles = [{:?}]\n", plan.display().to_string());
    let mut live = Live::of(&model, &schedule);
    let progress = twins.path().join("progress.csv");
    std::fs::write(&progress, "id,start,finish\nBathroom flooring,2024-04-22,2024-04-24\n").unwrap();
    live.text(&[&"actuals", &progress]);
    live.wait_until_healthy();
    let site = |live: &Live| {
        let echo: Value = serde_json::from_str(&live.text(&[&"topic", &"echo", &"site"])).unwrap();
        echo["content_hash"].clone()
    };
    let before = site(&live);
    std::fs::write(live.home.path().join("demo.ifc"), text.replace("'G.dock-south'", "'G.dock-renamed'")).unwrap();
    live.text(&[&"load"]);
    assert_ne!(site(&live), before, "the renamed wall is in force");
    live.wait_until_healthy();
    live.down();
}
