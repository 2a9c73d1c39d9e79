//! Questions about a site: ways, rooms and doors of model files and of running daemons.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

use end_to_end::live::Live;
use end_to_end::{convert, demo_model, groundplan, root};
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::Path;

/// A robot that climbs stairs and is as wide as the default one.
fn climbing_robot(home: &Path) -> std::path::PathBuf {
    let path = home.join("climber.toml");
    std::fs::write(&path, "name = \"climber\"\nclimbs_stairs = true\n").unwrap();
    path
}

/// Exit code and document of a question of the demo building.
fn ask(words: &[&str]) -> (i32, Value) {
    let model = demo_model();
    let question: Vec<&dyn AsRef<std::ffi::OsStr>> = words
        [..words.iter().position(|w| w.starts_with("--")).unwrap_or(words.len())]
        .iter()
        .map(|w| w as &dyn AsRef<std::ffi::OsStr>)
        .collect();
    let more: Vec<&dyn AsRef<std::ffi::OsStr>> =
        words[question.len()..].iter().map(|w| w as &dyn AsRef<std::ffi::OsStr>).collect();
    let middle: [&dyn AsRef<std::ffi::OsStr>; 2] = [&model, &"--json"];
    let output = groundplan(&[&question[..], &middle, &more].concat());
    let error = String::from_utf8_lossy(&output.stderr).into_owned();
    let answer = serde_json::from_slice(&output.stdout).unwrap_or_else(|_| panic!("{error}"));
    (output.status.code().unwrap(), answer)
}

#[test]
fn a_way_between_storeys_exists_once_the_stair_and_the_floors_are_built() {
    let home = tempfile::tempdir().unwrap();
    let robot = climbing_robot(home.path());
    let robot = robot.to_str().unwrap();
    let (code, early) = ask(&["way", "G.11", "U.09", "--date", "2024-03-20", "--robot", robot]);
    assert_eq!((code, &early["exists"], &early["length_m"]), (3, &false.into(), &Value::Null));
    let missing = early["missing"].as_array().unwrap();
    let of_kind = |kind: &str| missing.iter().find(|m| m["kind"] == kind).unwrap();
    let floor = of_kind("floor");
    assert_eq!((&floor["name"], &floor["code"]), (&"U.slab".into(), &"not_built".into()));
    assert_eq!(floor["changes_at"], "2024-03-22T17:00:00");
    assert_eq!(floor["global_id"].as_str().unwrap().len(), 22);
    let opens = early["changes"]["at"].as_str().unwrap().to_owned();
    assert_eq!(opens, "2024-03-29T17:00:00", "{early}");

    // The stair is begun, and the room above is not closed yet.
    let (code, stair) = ask(&["way", "G.11", "U.01", "--date", "2024-03-23", "--only-now", "--robot", robot]);
    assert_eq!((code, stair["changes"]["why_not_searched"].is_string()), (3, true));

    let (code, later) = ask(&["way", "G.11", "U.09", "--date", &opens, "--robot", robot]);
    assert_eq!((code, &later["exists"], &later["changes"]), (0, &true.into(), &Value::Null));
    let legs = later["legs"].as_array().unwrap();
    assert_eq!(legs.iter().map(|l| l["kind"].as_str().unwrap()).collect::<Vec<_>>(), ["floor", "stair", "floor"]);
    assert_eq!((&legs[1]["element"]["name"], &legs[1]["to_storey"]), (&"G.stair".into(), &1.into()));
    let all_m: f64 = legs.iter().map(|l| l["length_m"].as_f64().unwrap()).sum();
    assert!((all_m - later["length_m"].as_f64().unwrap()).abs() < 1e-3);
    assert_eq!(later["circumstances"]["of"], "models");
}

#[test]
fn the_lines_of_a_way_are_free_on_the_planning_maps() {
    let maps = convert(&demo_model(), &["--date", "2024-06-20"]);
    let (code, way) = ask(&["way", "G.02", "G.10", "--date", "2024-06-20"]);
    assert_eq!(code, 0, "{way}");
    let legs = way["legs"].as_array().unwrap();
    let doors: Vec<&str> =
        legs.iter().flat_map(|l| l["doors"].as_array().unwrap()).map(|d| d["name"].as_str().unwrap()).collect();
    assert_eq!(doors.first(), Some(&"G.D04 plant room"), "{doors:?}");
    let storey = maps.storey(0);
    for leg in legs {
        let points: Vec<[f64; 3]> = serde_json::from_value(leg["points_m"].clone()).unwrap();
        for pair in points.windows(2) {
            for k in 0..=100 {
                let at = [0, 1].map(|c| pair[0][c] + (pair[1][c] - pair[0][c]) * f64::from(k) / 100.0);
                assert_eq!(storey.planning(at[0], at[1]), 254, "{at:?}");
                assert_ne!(storey.keepout(at[0], at[1]), 0, "{at:?}");
            }
        }
    }
}

#[test]
fn who_may_enter_a_room_agrees_with_the_waypoints_of_the_same_date() {
    let maps = convert(&demo_model(), &["--date", "2024-04-27"]);
    let (waypoints, semantic) = (maps.json("waypoints.json"), maps.json("semantic.json"));
    let rooms = semantic["spaces"].as_object().unwrap();
    for (global_id, space) in rooms.iter().take(8) {
        let (code, room) = ask(&["room", global_id, "--date", "2024-04-27", "--only-now"]);
        let planned = &waypoints["spaces"][global_id];
        assert_eq!(room["access"], planned["access"], "{global_id}");
        assert_eq!(code == 0, planned["access"] == "reached");
        assert_eq!(room["state"], space["state"]);
    }
    let (code, room) = ask(&["room", "G.13", "--date", "2024-05-01"]);
    assert_eq!((code, &room["closed_by"][0]["code"]), (3, &"task".into()));
    assert_eq!(room["closed_by"][0]["task"]["identification"], "3.1");
    assert_eq!(room["changes"]["at"], "2024-05-08T17:00:00");
    let periods = room["periods"].as_array().unwrap();
    let states: Vec<&str> = periods.iter().map(|p| p["state"].as_str().unwrap()).collect();
    assert!(states.windows(2).all(|pair| pair[0] != pair[1]), "{states:?}");
    assert!(room["tasks"].as_array().unwrap().iter().any(|task| task["name"] == "Windows"));
}

#[test]
fn a_door_says_whether_it_can_be_passed_and_when_that_changes() {
    let (code, door) = ask(&["door", "G.D04 plant room", "--date", "2024-04-27"]);
    assert_eq!(
        (code, &door["can_pass"], &door["passage"]),
        (0, &true.into(), &"absent".into()),
        "its opening is a way"
    );
    assert_eq!((&door["state"], &door["built_at"]), (&"not_started".into(), &"2024-05-17T17:00:00".into()));
    assert_eq!(door["changes"]["at"], "2024-05-13T08:00:00", "while it is hung it cannot be passed: {door}");
    assert_eq!(door["rooms"].as_array().unwrap().len(), 2);
    let legged = root().join("config/robots/legged.toml");
    let (code, door) = ask(&["door", "G.D04 plant room", "--robot", legged.to_str().unwrap()]);
    assert_eq!((code, &door["can_pass"], &door["reasons"][0]["code"]), (3, &false.into(), &"too_narrow".into()));
    assert!(door["clear_width_m"].as_f64() < door["needed_width_m"].as_f64());
    assert_eq!(ask(&["door", "G.D04 plant room"]).0, 0);
}

#[test]
fn what_cannot_be_found_or_does_not_fit_is_bad_usage() {
    let model = demo_model();
    let check = |arguments: &[&str], expected: &str| {
        let all: Vec<&dyn AsRef<std::ffi::OsStr>> = arguments
            .iter()
            .map(|word| if *word == "MODEL" { &model as &dyn AsRef<std::ffi::OsStr> } else { word })
            .collect();
        let output = groundplan(&all);
        let error = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{error}");
        assert!(error.contains(expected), "{error}");
    };
    check(&["room", "G.1O", "MODEL"], "nearest");
    check(&["door", "G.D4 plant", "MODEL"], "G.D04 plant room");
    check(&["way", "1,2", "G.02", "MODEL"], "X,Y,STOREY");
    check(&["way", "1,2,cellar", "G.02", "MODEL"], "Upper floor");
    check(&["room", "G.02", "--robot", "legged.toml"], "MODEL.ifc");
    check(&["room", "G.02", "--delay", "1.1=5d"], "MODEL.ifc");
    check(&["room", "G.02", "MODEL", "--demo"], "cannot be used with");
    check(&["room", "G.02", "MODEL", "--delay", "1.1=5d"], "--date");
}

#[test]
fn running_daemons_answer_as_files_at_their_plan_time_and_at_other_dates() {
    const DATE: &str = "2024-06-03T12:00:00";
    let mut live = Live::of(&demo_model(), &format!("[schedule]\nplan_time = {DATE:?}\n"));
    let asked = |words: &[&str]| -> (i32, Value) {
        let words: Vec<&dyn AsRef<std::ffi::OsStr>> = words.iter().map(|w| w as &dyn AsRef<std::ffi::OsStr>).collect();
        let output = live.run(&[&words[..], &[&"--json"]].concat());
        let error = String::from_utf8_lossy(&output.stderr).into_owned();
        (output.status.code().unwrap(), serde_json::from_slice(&output.stdout).unwrap_or_else(|_| panic!("{error}")))
    };
    let without_circumstances = |(code, mut answer): (i32, Value)| {
        answer.as_object_mut().unwrap().remove("circumstances");
        (code, answer)
    };
    let (code, answer) = asked(&["way", "G.02", "G.10"]);
    let circumstances = &answer["circumstances"];
    assert_eq!((&circumstances["of"], &circumstances["plan_time"]), (&"running_site".into(), &DATE.into()));
    assert_eq!((code, &circumstances["maps"]["may_be_used"]), (0, &true.into()), "{answer}");
    assert!(circumstances["epochs"].as_object().unwrap().values().all(|epoch| epoch.as_u64() > Some(0)));
    for question in [&["way", "G.02", "G.10"][..], &["way", "G.02", "U.07"], &["door", "G.D04 plant room"]] {
        let of_files = ask(&[question, &["--date", DATE]].concat());
        assert_eq!(without_circumstances(asked(question)), without_circumstances(of_files), "{question:?}");
        let other = [question, &["--date", "2024-04-27"]].concat();
        let (code, there) = asked(&other);
        assert_eq!(there["circumstances"]["of"], "running_site_at_date");
        assert_eq!(without_circumstances((code, there)), without_circumstances(ask(&other)), "{question:?}");
    }
    // Scans are those of the whole plan there.
    let keys = |(code, room): (i32, Value)| -> (i32, BTreeMap<String, Value>) {
        let kept = room.as_object().unwrap().clone().into_iter();
        (code, kept.filter(|(key, _)| !["circumstances", "scans"].contains(&key.as_str())).collect())
    };
    assert_eq!(keys(asked(&["room", "G.02"])), keys(ask(&["room", "G.02", "--date", DATE])));
    live.down();
}
