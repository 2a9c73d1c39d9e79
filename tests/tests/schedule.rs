//! Schedules from file to states, changes and maps, on the demo building and against ground truth.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

use end_to_end::{FREE, Maps, OCCUPIED, UNKNOWN, convert, corpus, demo_model, files_in, groundplan};
use serde_json::Value;
use std::collections::BTreeSet;
use std::ffi::OsStr;
use std::fmt::Write;
use std::path::Path;

/// Runs a command and parses what it prints.
fn json(arguments: &[&dyn AsRef<OsStr>]) -> Value {
    let output = groundplan(arguments);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

fn failure(arguments: &[&dyn AsRef<OsStr>]) -> (Option<i32>, String) {
    let output = groundplan(arguments);
    assert!(!output.status.success());
    (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
}

/// The rules whose violation must be reported, by the expected result.
fn rules_of(config: &Value, paper: bool) -> String {
    let mut rules = String::new();
    if paper {
        rules.push_str("mode = \"paper\"\n");
    }
    if let Some(format) = config["date_format"].as_str() {
        let _ = writeln!(rules, "date_format = {:?}", if format == "ifcdatetime" { "iso" } else { format });
    }
    if let Some(day) = config["duration_day"].as_str() {
        let _ = writeln!(rules, "duration_day = {day:?}");
    }
    for (entity, place) in config["psets"].as_object().into_iter().flatten() {
        let _ =
            writeln!(rules, "[[property_dates]]\napplies_to = {entity:?}\nset = {}\nproperty = {}", place[0], place[1]);
    }
    for phase in config["phases"].as_array().into_iter().flatten() {
        let _ = writeln!(rules, "[[phases]]\nname = {}", phase["name"]);
        if let (Some(start), Some(finish)) = (phase["start"].as_str(), phase["finish"].as_str()) {
            let _ = writeln!(rules, "start = {start}\nfinish = {finish}");
        }
    }
    rules
}

/// States and changes of a generated file against its truth, and the prototype's rule where the truth has it.
fn check_truth(truth_path: &Path) {
    let name = truth_path.file_name().unwrap().to_string_lossy().replace(".expected.json", "");
    let truth: Value = serde_json::from_slice(&std::fs::read(truth_path).unwrap()).unwrap();
    let model = truth_path.with_file_name(format!("{name}.ifc"));
    let home = tempfile::tempdir().unwrap();
    let rules = home.path().join("schedule.toml");
    std::fs::write(&rules, rules_of(&truth["config"], false)).unwrap();
    let mut arguments: Vec<&dyn AsRef<OsStr>> = vec![&"states", &model, &"--schedule", &rules, &"--json"];
    let probes: Vec<&str> = truth["probes"].as_array().unwrap().iter().map(|p| p["at"].as_str().unwrap()).collect();
    for probe in &probes {
        arguments.extend([&"--date" as &dyn AsRef<OsStr>, probe]);
    }
    let states = json(&arguments);
    for (found, expected) in states.as_array().unwrap().iter().zip(truth["probes"].as_array().unwrap()) {
        for key in ["at", "elements", "spaces"] {
            assert_eq!(found[key], expected[key], "{name}: {key} at {}", expected["at"]);
        }
    }
    let changes = json(&[&"changes", &model, &"--schedule", &rules, &"--json"]);
    assert_eq!(changes["change_instants"], truth["change_instants"], "{name}");
    assert_eq!(changes["changes"], truth["changes"], "{name}");
    std::fs::write(&rules, rules_of(&truth["config"], true)).unwrap();
    for cursor in truth["paper"].as_array().into_iter().flatten() {
        let at = cursor["cursor"].as_str().unwrap();
        let found = json(&[&"states", &model, &"--schedule", &rules, &"--json", &"--date", &at]);
        let ids = |list: &Value| -> BTreeSet<String> {
            list.as_array().unwrap().iter().map(|id| id.as_str().unwrap().to_owned()).collect()
        };
        let drawn = ids(&cursor["walls"]).union(&ids(&cursor["doors"])).cloned().collect();
        let having = |map: &Value, wanted: fn(&Value) -> bool| -> BTreeSet<String> {
            map.as_object().unwrap().iter().filter(|(_, v)| wanted(v)).map(|(id, _)| id.clone()).collect()
        };
        assert_eq!(having(&found["elements"], |state| state == "built"), drawn, "{name} at {at}");
        assert_eq!(having(&found["spaces"], |s| s["state"] == "open"), ids(&cursor["rooms_open"]), "{name} at {at}");
    }
}

#[test]
fn generated_schedules_have_their_true_states_and_changes() {
    let Some(folder) = corpus("schedule/generated") else { return };
    let truths: Vec<_> =
        files_in(&folder).into_iter().filter(|f| f.to_string_lossy().ends_with(".expected.json")).collect();
    assert!(truths.len() >= 13);
    truths.iter().for_each(|truth| check_truth(truth));
}

#[test]
fn real_schedules_evaluate_and_say_what_they_lack() {
    let Some(folder) = corpus("schedule") else { return };
    let states = |file: &str, date: &str| json(&[&"states", &folder.join(file), &"--json", &"--date", &date]);
    let bridge = states("pass-sps005-valid_structural_relationship.ifc", "2025-03-01");
    assert_eq!(bridge["report"]["undated_tasks"].as_array().unwrap().len(), 14, "tasks without any time");
    assert!(bridge["elements"].as_object().unwrap().values().all(|state| state == "built"));
    // Start plus duration, dates on nested tasks alone, a storey as a product.
    let walls = states("construction_scheduling_task.ifc", "2010-09-22T10:00:00");
    let of_state = |wanted: &str| walls["elements"].as_object().unwrap().values().filter(|s| *s == wanted).count();
    assert_eq!([of_state("built"), of_state("in_progress"), of_state("not_started")], [2, 1, 2]);
    assert_eq!(walls["report"]["sources"]["task_early"], 5);
}

#[test]
fn dates_that_fit_two_orders_are_refused_with_both_readings() {
    let Some(folder) = corpus("schedule/generated") else { return };
    let model = folder.join("fzk-pset-revit.ifc");
    let rules = corpus("schedule/generated").map(|_| tempfile::tempdir().unwrap()).unwrap();
    let path = rules.path().join("schedule.toml");
    std::fs::write(
        &path,
        "[[property_dates]]\napplies_to = \"IfcWall\"\nset = \"Wall Schedule\"\nproperty = \"ConstructionDate\"\n",
    )
    .unwrap();
    let (code, error) = failure(&[&"states", &model, &"--schedule", &path, &"--date", &"2024-04-09"]);
    assert_eq!(code, Some(2));
    assert!(
        error.contains("day/month/year") && error.contains("month/day/year") && error.contains("date_format"),
        "{error}"
    );
    let home = tempfile::tempdir().unwrap();
    let out = home.path().join("out");
    let output = groundplan(&[&"convert", &model, &"-o", &out]);
    assert!(output.status.success(), "without a date they do not matter");
    assert!(String::from_utf8_lossy(&output.stdout).contains("both"), "but it is a warning");
}

fn at(date: &str) -> Maps {
    convert(&demo_model(), &["--date", date])
}

#[test]
fn before_the_first_slab_all_is_unknown_and_forbidden_and_after_it_there_is_floor() {
    let before = at("2024-03-01");
    for index in [0, 1] {
        assert_eq!(before.manifest["storeys"][index]["status"], "no_floor_yet");
        let storey = before.storey(index);
        assert!(storey.all_planning(UNKNOWN) && storey.all_keepout(OCCUPIED));
    }
    let ground = at("2024-03-09");
    assert_eq!(
        (&ground.manifest["storeys"][0]["status"], &ground.manifest["storeys"][1]["status"]),
        (&"ok".into(), &"no_floor_yet".into())
    );
    for index in [0, 1] {
        ground.storey(index).assert_filter_frees_nothing();
    }
    assert_eq!((ground.storey(0).planning(6.0, 5.8), ground.storey(0).keepout(6.0, 5.8)), (FREE, UNKNOWN));
    assert_eq!(at("2024-03-23").manifest["storeys"][1]["status"], "ok");
}

#[test]
fn three_dates_are_three_maps() {
    // Where a partition wall, a door in it, and a desk will be; in a room that opens last, and in the corridor.
    let (wall, door, room, corridor) = ([7.0, 6.78], [9.0, 6.78], [11.0, 12.0], [6.0, 5.8]);
    let structure = at("2024-04-06").storey(0);
    assert_eq!((structure.planning(wall[0], wall[1]), structure.planning(door[0], door[1])), (FREE, FREE));
    let partitions = at("2024-04-27").storey(0);
    assert_eq!((partitions.planning(wall[0], wall[1]), partitions.planning(door[0], door[1])), (OCCUPIED, FREE));
    let finished = at("2024-06-01").storey(0);
    assert_eq!((finished.planning(wall[0], wall[1]), finished.planning(door[0], door[1])), (OCCUPIED, FREE));
    for storey in [&structure, &partitions] {
        assert_eq!((storey.planning(room[0], room[1]), storey.keepout(room[0], room[1])), (OCCUPIED, OCCUPIED));
        assert_eq!(
            (storey.planning(corridor[0], corridor[1]), storey.keepout(corridor[0], corridor[1])),
            (FREE, UNKNOWN)
        );
    }
    assert_eq!((finished.planning(room[0], room[1]), finished.keepout(room[0], room[1])), (FREE, UNKNOWN));
}

#[test]
fn work_above_forbids_the_floor_below() {
    // The upper slab is poured over the ground floor, whose rooms are not bounded by it.
    let pouring = at("2024-03-20").storey(0);
    assert_eq!((pouring.planning(6.0, 5.8), pouring.keepout(6.0, 5.8)), (FREE, OCCUPIED));
}

#[test]
fn blocking_a_room_changes_nothing_that_a_lidar_sees() {
    let home = tempfile::tempdir().unwrap();
    let rules = home.path().join("schedule.toml");
    std::fs::write(&rules, "[[closed_spaces]]\nmatch = \"*Open-plan office\"\nreason = \"private\"\n").unwrap();
    let open = at("2024-06-03");
    let closed = convert(&demo_model(), &["--date", "2024-06-03", "--schedule", rules.to_str().unwrap()]);
    let layer = |maps: &Maps, name: &str| {
        maps.contents()
            .into_iter()
            .find(|(p, _)| p.starts_with("storeys/00-ground-floor") && p.ends_with(name))
            .unwrap()
            .1
    };
    assert_eq!(layer(&open, "localization.pgm"), layer(&closed, "localization.pgm"));
    assert_ne!(layer(&open, "planning.pgm"), layer(&closed, "planning.pgm"));
    let waypoints = closed.json("waypoints.json");
    let spaces = waypoints["spaces"].as_object().unwrap().values();
    assert!(spaces.into_iter().any(|s| s["reason"].as_str().is_some_and(|r| r.contains("private"))));
}

#[test]
fn files_say_when_things_are_built_and_until_when_a_map_holds() {
    let maps = at("2024-04-29T10:00:00");
    let times = ["plan_time", "plan_until", "valid_from", "valid_until"].map(|key| maps.manifest[key].clone());
    assert_eq!(
        times,
        ["2024-04-29T10:00:00".into(), Value::Null, "2024-04-29T08:00:00".into(), "2024-05-03T08:00:00".into()]
    );
    let semantic = maps.json("semantic.json");
    let window = semantic["elements"].as_object().unwrap().values().find(|e| e["class"] == "window").unwrap();
    let schedule = &window["schedule"];
    assert_eq!(
        (&schedule["start"], &schedule["finish"]),
        (&"2024-04-29T08:00:00".into(), &"2024-05-08T17:00:00".into())
    );
    assert_eq!((&schedule["source"], &schedule["state"]), (&"task_schedule".into(), &"in_progress".into()));
    assert!(schedule["total_float_h"].as_f64().is_some_and(|h| h > 0.0));
    let report = &maps.json("report.json")["schedule"];
    assert_eq!(report["undated"].as_array().unwrap().len(), 1, "the WC: {report}");
    assert_eq!(maps.manifest["schedule_ignored"], false);
}

#[test]
fn every_change_has_a_folder_of_its_own() {
    let home = tempfile::tempdir().unwrap();
    let out = home.path().join("out");
    let model = demo_model();
    let command: [&dyn AsRef<OsStr>; 6] = [&"convert", &model, &"-o", &out, &"--date", &"all"];
    for _ in 0..2 {
        // The second run replaces what the first wrote.
        assert!(groundplan(&command).status.success());
    }
    let manifest: Value = serde_json::from_slice(&std::fs::read(out.join("manifest.json")).unwrap()).unwrap();
    let changes = json(&[&"changes", &model, &"--json"]);
    let dates: Vec<&Value> = manifest["dates"].as_array().unwrap().iter().map(|d| &d["plan_time"]).collect();
    assert_eq!(dates, changes["change_instants"].as_array().unwrap().iter().collect::<Vec<_>>());
    for date in manifest["dates"].as_array().unwrap() {
        let folder = out.join(date["directory"].as_str().unwrap());
        let own: Value = serde_json::from_slice(&std::fs::read(folder.join("manifest.json")).unwrap()).unwrap();
        assert_eq!((&own["plan_time"], &own["valid_until"]), (&date["plan_time"], &date["valid_until"]));
    }
    assert_eq!(std::fs::read_dir(home.path()).unwrap().count(), 1, "nothing is left beside it");
}

#[test]
fn differences_name_elements_doors_and_spaces() {
    let model = demo_model();
    let diff = json(&[&"changes", &model, &"--json", &"--diff", &"2024-04-27", &"2024-06-03"]);
    let names = |key: &str| -> Vec<&str> {
        diff[key].as_array().unwrap().iter().map(|n| n["name"].as_str().unwrap()).collect()
    };
    // All were openings before: nothing opens where a door is hung, and what this robot cannot open or pass closes.
    assert_eq!(names("doors_opened"), Vec::<&str>::new());
    let mut closed = names("doors_closed");
    closed.sort_unstable();
    assert_eq!(closed, ["G.D02 dock gate", "G.D11 store", "G.D15 lift", "U.D09 board room, folding"]);
    assert!(diff["doors_closed"].as_array().unwrap().iter().all(|door| door["before"] == "absent"), "{diff:#}");
    assert!(names("spaces_reachable").contains(&"G.07") && names("spaces_unblocked").contains(&"G.07"));
    assert!(names("elements_added").contains(&"Sofa") && names("elements_removed").is_empty());
    let back = json(&[&"changes", &model, &"--json", &"--diff", &"2024-06-03", &"2024-04-27"]);
    assert_eq!(
        (&back["elements_removed"], &back["spaces_blocked"]),
        (&diff["elements_added"], &diff["spaces_unblocked"])
    );
}

#[test]
fn delays_and_reported_progress_show_in_states_and_changes() {
    let model = demo_model();
    let open = |more: &[&str]| -> Vec<String> {
        let mut arguments: Vec<&dyn AsRef<OsStr>> = vec![&"changes", &model, &"--json"];
        arguments.extend(more.iter().map(|a| a as &dyn AsRef<OsStr>));
        json(&arguments)["change_instants"].as_array().unwrap().iter().map(|i| i.as_str().unwrap().to_owned()).collect()
    };
    let plan = open(&[]);
    let delayed = open(&["--delay", "2.1=5d"]);
    assert!(plan.contains(&"2024-04-08T08:00:00".to_owned()) && !delayed.contains(&"2024-04-08T08:00:00".to_owned()));
    assert!(delayed.contains(&"2024-04-15T08:00:00".to_owned()), "{delayed:?}");
    let home = tempfile::tempdir().unwrap();
    let actual = home.path().join("progress.csv");
    std::fs::write(&actual, "id,start,finish\n1.1,2024-03-06T08:00:00,2024-03-12T12:00:00\n").unwrap();
    assert!(open(&["--actual", actual.to_str().unwrap()]).contains(&"2024-03-12T12:00:00".to_owned()));
    let states = json(&[&"states", &model, &"--json", &"--date", &"2024-03-05", &"--actuals", &actual]);
    assert!(states["elements"].as_object().unwrap().values().all(|s| s == "not_started" || s == "built"));
}

#[test]
fn dates_and_rules_that_mean_nothing_are_bad_usage() {
    let model = demo_model();
    let home = tempfile::tempdir().unwrap();
    let rules = home.path().join("schedule.toml");
    std::fs::write(&rules, "undated = \"maybe\"\n").unwrap();
    let out = home.path().join("out");
    let cases: [(Vec<&dyn AsRef<OsStr>>, &str); 10] = [
        (vec![&"states", &model, &"--date", &"15/04/2024"], "15/04/2024"),
        (vec![&"states", &model, &"--date", &"2024-04-15", &"--schedule", &rules], "maybe"),
        (vec![&"states", &model, &"--date", &"2024-04-15", &"--delay", &"nobody=5d"], "nobody"),
        (vec![&"states", &model, &"--date", &"2024-04-15T08:00:00+02:00"], "site_zone"),
        (vec![&"convert", &model, &"-o", &out, &"--date", &"2024-04-15T08:00:00Z"], "site_zone"),
        (vec![&"changes", &model, &"--diff", &"2024-04-15", &"2024-04-15T08:00:00Z"], "site_zone"),
        (vec![&"states", &model, &"--date", &"2024-04-15", &"--threads", &"9999"], "256"),
        (vec![&"convert", &model, &"-o", &out, &"--date", &"2024-04-15", &"--until", &"2024-04-01"], "not after"),
        (vec![&"convert", &model, &"-o", &out, &"--delay", &"2.1=5d"], "--date"),
        (vec![&"changes", &model, &"--actual", &"/nowhere.csv"], "/nowhere.csv"),
    ];
    for (arguments, word) in cases {
        let (code, error) = failure(&arguments);
        assert_eq!(code, Some(2), "{error}");
        assert!(error.contains(word), "{error}");
    }
}

#[test]
fn a_date_with_an_offset_is_converted_to_the_zone_of_the_site() {
    let model = demo_model();
    let home = tempfile::tempdir().unwrap();
    let rules = home.path().join("schedule.toml");
    std::fs::write(&rules, "site_zone = \"Europe/Amsterdam\"\n").unwrap();
    for date in
        ["2024-04-29T08:00:00+00:00", "2024-04-29T08:00:00Z", "2024-04-29T10:00:00+02:00", "2024-04-29T10:00:00"]
    {
        let states = json(&[&"states", &model, &"--json", &"--schedule", &rules, &"--date", &date]);
        assert_eq!(states["at"], "2024-04-29T10:00:00", "{date}");
        let maps = convert(&model, &["--resolution", "0.2", "--schedule", rules.to_str().unwrap(), "--date", date]);
        assert_eq!(
            (&maps.manifest["plan_time"], &maps.manifest["plan_until"]),
            (&states["at"], &Value::Null),
            "{date}"
        );
    }
}

#[test]
fn states_of_a_date_tell_midnight_and_what_the_maps_of_its_day_show() {
    let model = demo_model();
    // Work begins at 8: at midnight nothing is in progress, and the maps of the day show the work.
    let date = "2024-04-29";
    let states = json(&[&"states", &model, &"--json", &"--date", &date]);
    let midnight = json(&[&"states", &model, &"--json", &"--date", &"2024-04-29T00:00:00"]);
    for key in ["at", "until", "elements", "spaces"] {
        assert_eq!(states[key], midnight[key], "{key}");
    }
    assert_eq!((&states["until"], &midnight["whole_day"]), (&Value::Null, &Value::Null));
    let day = json(&[&"states", &model, &"--json", &"--date", &date, &"--until", &date]);
    assert_eq!((&day["at"], &day["until"]), (&"2024-04-29T00:00:00".into(), &"2024-04-30T00:00:00".into()));
    let mut merged = states.clone();
    for key in ["elements", "spaces"] {
        let different = states["whole_day"][key].as_object().unwrap();
        assert!(key == "spaces" || !different.is_empty());
        different.iter().for_each(|(id, state)| merged[key][id] = state.clone());
        assert_eq!(merged[key], day[key]);
    }
    let maps = convert(&model, &["--resolution", "0.2", "--date", date]);
    assert_eq!((&maps.manifest["plan_time"], &maps.manifest["plan_until"]), (&day["at"], &day["until"]));
    let drawn = maps.json("semantic.json");
    for (id, element) in drawn["elements"].as_object().unwrap() {
        assert_eq!(element["schedule"]["state"], day["elements"][id], "{id}");
    }
    let text = String::from_utf8(groundplan(&[&"states", &model, &"--date", &date]).stdout).unwrap();
    assert!(text.contains("this is midnight"), "{text}");
    let (code, error) = failure(&[&"states", &model, &"--date", &date, &"--date", &date, &"--until", &date]);
    assert_eq!((code, error.contains("one --date")), (Some(2), true));
}

#[test]
fn tasks_are_listed_with_dates_and_what_they_act_on() {
    let model = demo_model();
    let all = json(&[&"tasks", &model, &"--json", &"--date", &"2024-04-15T10:00:00"]);
    let tasks = all["tasks"].as_array().unwrap();
    let task = |identification: &str| tasks.iter().find(|t| t["identification"] == identification).unwrap();
    let partitions = task("2.1");
    assert_eq!(partitions["start"], "2024-04-08T08:00:00");
    assert_eq!(partitions["dates_from"], "task_computed");
    let states = json(&[&"states", &model, &"--json", &"--date", &partitions["start"].as_str().unwrap()]);
    let built: Vec<&Value> = partitions["elements"].as_array().unwrap().iter().collect();
    assert!(!built.is_empty());
    for element in built {
        assert_eq!(element["operation"], "constructs");
        assert_eq!(states["elements"][element["global_id"].as_str().unwrap()], "in_progress", "{element}");
    }
    for space in partitions["spaces"].as_array().unwrap() {
        let state = &states["spaces"][space["global_id"].as_str().unwrap()];
        let why = format!("task:{}", partitions["global_id"].as_str().unwrap());
        assert!(state["why"].as_array().unwrap().contains(&why.into()), "{state}");
    }
    let parent = tasks.iter().find(|t| t["global_id"] == partitions["parent"]).unwrap();
    assert_eq!((parent["depth"].as_u64(), partitions["depth"].as_u64()), (Some(0), Some(1)));
    assert!(tasks.iter().any(|t| t["status"] == "finished") && tasks.iter().any(|t| t["status"] == "not_started"));
    let text = String::from_utf8(groundplan(&[&"tasks", &model, &"--task", &"2.1"]).stdout).unwrap();
    assert!(text.contains("2024-04-08T08:00:00") && text.contains("builds"), "{text}");
    assert_eq!(text.lines().count(), 2, "{text}");
}

#[test]
fn mistyped_names_of_tasks_get_the_nearest_names() {
    let model = demo_model();
    let all = json(&[&"tasks", &model, &"--json"]);
    let name =
        all["tasks"].as_array().unwrap().iter().find_map(|t| t["name"].as_str().filter(|n| n.len() > 8)).unwrap();
    let mistyped = name.replacen(&name[1..2], "", 1);
    let delay = format!("{mistyped}=5d");
    let home = tempfile::tempdir().unwrap();
    let actual = home.path().join("progress.csv");
    std::fs::write(&actual, format!("id,start,finish\n{mistyped},2024-03-06,\n")).unwrap();
    let cases: [Vec<&dyn AsRef<OsStr>>; 3] = [
        vec![&"tasks", &model, &"--task", &mistyped],
        vec![&"changes", &model, &"--delay", &delay],
        vec![&"changes", &model, &"--actual", &actual],
    ];
    for arguments in cases {
        let (code, error) = failure(&arguments);
        assert_eq!(code, Some(2), "{error}");
        assert!(error.contains("nearest") && error.contains(name), "{error}");
    }
}

#[test]
fn changes_name_the_tasks_that_make_them() {
    let model = demo_model();
    let changes = json(&[&"changes", &model, &"--json"]);
    let causes = changes["causes"].as_array().unwrap();
    assert_eq!(causes.len(), changes["changes"].as_array().unwrap().len());
    let at = |time: &str| causes.iter().find(|c| c["at"] == time).unwrap()["tasks"].as_array().unwrap();
    let start = at("2024-04-08T08:00:00").iter().find(|t| t["identification"] == "2.1").unwrap();
    assert_eq!(start["event"], "starts");
    assert!(!start["elements"].as_array().unwrap().is_empty());
    for (change, cause) in changes["changes"].as_array().unwrap().iter().zip(causes) {
        assert_eq!(change["at"], cause["at"]);
        for task in cause["tasks"].as_array().unwrap() {
            for id in task["elements"].as_array().unwrap() {
                assert!(change["elements"].get(id.as_str().unwrap()).is_some(), "{task}");
            }
        }
    }
    let text = String::from_utf8(groundplan(&[&"changes", &model]).stdout).unwrap();
    assert!(text.contains("start of 2.1 "), "{text}");
    let diff = json(&[&"changes", &model, &"--json", &"--diff", &"2024-04-08", &"2024-04-09"]);
    assert!(diff["causes"][0]["tasks"].as_array().unwrap().iter().any(|t| t["identification"] == "2.1"), "{diff}");
}
