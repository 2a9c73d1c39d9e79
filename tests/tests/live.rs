//! The daemons of a site as real processes: started, asked, killed, stopped.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

use end_to_end::live::{DEADLINE, Live};
use end_to_end::{contents, groundplan};
use serde_json::Value;
use std::ffi::OsStr;
use std::time::Instant;

#[test]
fn the_next_date_changes_the_maps_and_export_writes_what_convert_writes() {
    let mut live = Live::start();
    assert_eq!(live.index()["content"]["plan_time"], "2024-03-01T00:00:00");
    let before = live.index();
    assert_eq!(live.text(&[&"date", &"--next"]), "2024-03-04T08:00:00");
    assert_ne!(live.index()["content_hash"], before["content_hash"], "it returned when the new index was out");
    for date in ["2024-04-29T10:00:00", "2024-03-20T00:00:00", "2024-06-03T12:00:00"] {
        live.text(&[&"date", &date]);
        check_export_is_convert(&live, &[&"--date", &date]);
    }
    // The configuration may name another robot and resolution than those that are in force.
    let legged = end_to_end::root().join("config/robots/legged.toml");
    live.text(&[&"robot", &legged]);
    let site = std::fs::read_to_string(live.config()).unwrap();
    std::fs::write(live.config(), format!("{site}[robot]\nresolution_m = 0.1\n")).unwrap();
    check_export_is_convert(&live, &[&"--date", &"2024-06-03T12:00:00", &"--robot", &legged]);
    live.down();
    assert_eq!(live.segments(), 0, "nothing is left in shared memory");
}

/// The files of the daemons are those of a conversion with these options.
fn check_export_is_convert(live: &Live, options: &[&dyn AsRef<OsStr>]) {
    let (exported, converted) = (live.home.path().join("exported"), live.home.path().join("converted"));
    let optional: [&dyn AsRef<OsStr>; 5] = [&"--world", &"--usd", &"--cloud", &"--fleet=vda5050,lif", &"--open-rmf"];
    let export: [&dyn AsRef<OsStr>; 2] = [&"export", &exported];
    live.text(&export.iter().chain(&optional).copied().collect::<Vec<_>>());
    let model = live.home.path().join("demo.ifc");
    let convert: [&dyn AsRef<OsStr>; 4] = [&"convert", &model, &"-o", &converted];
    let output = groundplan(&convert.iter().chain(&optional).chain(options).copied().collect::<Vec<_>>());
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let (exported, converted) = (contents(&exported), contents(&converted));
    assert!(exported.len() > 20);
    for (one, other) in exported.iter().zip(&converted) {
        assert!(one == other, "{} differs", one.0.display());
    }
    assert_eq!(exported.len(), converted.len());
}

#[test]
fn what_was_set_survives_the_death_of_every_process() {
    let mut live = Live::start();
    live.text(&[&"date", &"2024-04-29T10:00:00"]);
    live.text(&[&"robot", &end_to_end::root().join("config/robots/legged.toml")]);
    let check = |live: &Live| {
        let content = &live.index()["content"];
        assert_eq!((&content["plan_time"], &content["robot"]), (&"2024-04-29T10:00:00".into(), &"legged".into()));
    };
    let mut epoch = live.index()["epoch"].as_u64().unwrap();
    for daemon in ["ifc-ingest", "schedule-eval", "rasterize", "waypoint-gen", "slam-align"] {
        live.kill(daemon);
        check(&live);
        let now = live.index()["epoch"].as_u64().unwrap();
        assert!(epoch <= now, "epochs never fall");
        epoch = now;
    }
    live.down();
    live.up();
    check(&live);
    assert!(epoch <= live.index()["epoch"].as_u64().unwrap());
    live.down();
}

#[test]
fn a_broken_file_leaves_the_last_good_map_and_says_why() {
    let mut live = Live::start();
    let before = live.index();
    let model = live.home.path().join("demo.ifc");
    let whole = std::fs::read(&model).unwrap();
    std::fs::write(&model, "no IFC file at all").unwrap();
    let output = live.run(&[&"load"]);
    assert!(!output.status.success());
    assert!(String::from_utf8_lossy(&output.stderr).contains("demo.ifc"));
    assert_eq!(live.index()["content_hash"], before["content_hash"]);
    let says_why = |s: &Value| s["daemons"]["ifc-ingest"]["error"].as_str().is_some_and(|e| e.contains("demo.ifc"));
    let begun = Instant::now();
    while !live.status().is_some_and(|status| status["healthy"] == false && says_why(&status)) {
        assert!(begun.elapsed() < DEADLINE, "{:?}", live.status());
    }
    // It is noticed on disk as soon as it is whole again.
    std::fs::write(&model, whole).unwrap();
    live.wait_until_healthy();
    live.down();
}

#[test]
fn a_bus_without_a_keeper_is_an_error_that_says_what_to_do() {
    let mut live = Live::start();
    live.down();
    let output = live.run(&[&"status"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&output.stderr).contains("groundplan up"));
}

/// Plan time and mode, as `date` tells them.
fn plan_time(live: &Live) -> String {
    live.text(&[&"date"]).split_whitespace().next().unwrap().to_owned()
}

#[test]
fn a_simulated_plan_time_runs_on_and_never_goes_back_when_its_daemon_dies() {
    let mut live = Live::start();
    live.text(&[&"date", &"2024-03-04", &"--simulate", &"200000"]);
    let begun = Instant::now();
    let mut seen = vec![plan_time(&live)];
    let mut kills = 0;
    // The last change of the building is in June.
    while seen.last().unwrap().as_str() < "2024-07-01" {
        assert!(begun.elapsed() < DEADLINE, "{seen:?}");
        if kills < 2 && seen.len() % 5 == 0 {
            live.kill("schedule-eval");
            kills += 1;
        }
        seen.push(plan_time(&live));
    }
    assert!(seen.is_sorted(), "{seen:?}");
    assert_eq!(kills, 2);
    while live.index()["content"]["plan_time"].as_str().unwrap() < "2024-06-01" {
        assert!(begun.elapsed() < DEADLINE, "{}", live.index());
    }
    // The wall clock needs to know where the site is.
    let output = live.run(&[&"date", &"--wall"]);
    assert!(String::from_utf8_lossy(&output.stderr).contains("site_zone"));
    assert_eq!(live.text(&[&"date", &"2024-04-29T10:00:00"]), "2024-04-29T10:00:00");
    assert!(live.text(&[&"date"]).ends_with("fixed"));
    live.down();
}

#[test]
fn reported_progress_is_on_the_maps_and_survives_its_daemon() {
    let mut live = Live::start();
    live.text(&[&"date", &"2024-04-29T10:00:00"]);
    let planned = live.index();
    let csv = live.home.path().join("progress.csv");
    std::fs::write(&csv, "id,start,finish\n36bpPbojzVJhkO4eHcxkTd,2024-05-20,\n").unwrap();
    live.text(&[&"actuals", &csv]);
    assert_ne!(live.index()["content"]["grids"], planned["content"]["grids"], "the partition walls are late");
    live.kill("schedule-eval");
    let (exported, converted) = (live.home.path().join("exported"), live.home.path().join("converted"));
    live.text(&[&"export", &exported]);
    let model = live.home.path().join("demo.ifc");
    let date = "2024-04-29T10:00:00";
    let convert: [&dyn AsRef<OsStr>; 8] = [&"convert", &model, &"-o", &converted, &"--date", &date, &"--actuals", &csv];
    assert!(groundplan(&convert).status.success());
    for (one, other) in contents(&exported).iter().zip(&contents(&converted)) {
        assert!(one == other, "{} differs", one.0.display());
    }

    let reported = live.index();
    std::fs::write(&csv, "id,start,finish\nnobody,2024-05-20,\n").unwrap();
    let output = live.run(&[&"actuals", &csv]);
    assert!(!output.status.success() && String::from_utf8_lossy(&output.stderr).contains("nobody"));
    assert_eq!(live.index()["content_hash"], reported["content_hash"], "what was reported before stays");
    live.text(&[&"actuals", &"--clear"]);
    assert_eq!(live.index()["content"]["grids"], planned["content"]["grids"]);
    live.down();
}

#[test]
fn a_date_with_an_offset_needs_the_zone_of_the_site() {
    let home = tempfile::tempdir().unwrap();
    let rules = home.path().join("schedule.toml");
    std::fs::write(&rules, "site_zone = \"Europe/Amsterdam\"\n").unwrap();
    let schedule = format!("[schedule]\nplan_time = \"2024-02-29T23:00:00Z\"\nrules = {:?}\n", rules);
    let mut live = Live::of(&end_to_end::demo_model(), &schedule);
    assert!(live.text(&[&"date"]).starts_with("2024-03-01T00:00:00"));
    assert_eq!(live.text(&[&"date", &"2024-04-29T08:00:00Z"]), "2024-04-29T10:00:00");
    // The zone is that of the rules in force, whatever became of their file.
    std::fs::write(&rules, "").unwrap();
    assert_eq!(live.text(&[&"date", &"2024-04-30T08:00:00+02:00"]), "2024-04-30T08:00:00");
    live.down();

    let mut live = Live::start();
    let refused = live.run(&[&"date", &"2024-04-29T08:00:00+02:00"]);
    assert_eq!(refused.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&refused.stderr).contains("site_zone"));
    assert!(live.text(&[&"date"]).starts_with("2024-03-01T00:00:00"));
    live.down();
}

/// A site whose daemons have nothing to show: started anew with other models, and waited for until a daemon says something.
fn without_maps(models: &str) -> Live {
    let mut live = Live::start();
    live.down();
    std::fs::remove_dir_all(live.home.path().join("state")).unwrap();
    let site = std::fs::read_to_string(live.config()).unwrap();
    std::fs::write(live.home.path().join("broken.ifc"), "this is no model").unwrap();
    std::fs::write(live.config(), site.replace("models = [\"demo.ifc\"]", &format!("models = [{models}]"))).unwrap();
    let mut up = std::process::Command::new(end_to_end::client());
    up.arg("up").arg("--config").arg(live.config()).stderr(std::process::Stdio::null());
    live.up = Some(up.spawn().unwrap());
    let begun = Instant::now();
    // The daemons run before there is a bus.
    while !live.run(&[&"topic", &"list"]).status.success() {
        assert!(begun.elapsed() < DEADLINE, "{:?}", live.status());
    }
    live
}

#[test]
fn an_export_of_maps_that_cannot_come_says_why_instead_of_waiting() {
    let refused = |live: &Live| {
        let out = live.home.path().join("exported");
        let output = live.run(&[&"export", &out]);
        assert_eq!(output.status.code(), Some(1));
        assert!(!out.exists());
        String::from_utf8(output.stderr).unwrap()
    };
    let mut live = without_maps("");
    let why = refused(&live);
    assert!(why.contains("no model is loaded: groundplan load MODEL.ifc"), "{why}");
    live.down();

    let mut live = without_maps("\"broken.ifc\"");
    let why = refused(&live);
    assert!(why.contains("ifc-ingest: ") && why.contains("broken.ifc"), "{why}");
    live.down();
}
