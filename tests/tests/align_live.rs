//! The `slam-map` topic and the running daemons.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

use end_to_end::house::{House, PLAIN};
use end_to_end::live::{DEADLINE, Live};
use end_to_end::mapping_robot::{MappingRobot, planning_at};
use end_to_end::{convert, demo_model, turned_map};
use serde_json::Value;
use std::time::Instant;

fn json(live: &Live, arguments: &[&dyn AsRef<std::ffi::OsStr>]) -> Value {
    serde_json::from_str(&live.text(arguments)).unwrap()
}

/// Of what has a pose, or is one that waits.
fn x_m(alignment: &Value) -> f64 {
    alignment["map_from_slam"]["x_m"].as_f64().unwrap()
}

#[test]
fn a_map_from_a_file_is_aligned_and_its_pose_survives_the_daemon() {
    let maps = convert(&demo_model(), &[]);
    let mut live = Live::of(&demo_model(), "");
    let none = live.run(&[&"align"]);
    assert!(!none.status.success() && String::from_utf8_lossy(&none.stderr).contains("slam-map"));
    assert!(failure(&live, &[&"deviations"]).contains("no SLAM map"));
    let robot = turned_map(&maps, 0, live.home.path());
    let found = json(&live, &[&"slam-map", &robot, &"--json"]);
    assert_eq!((&found["verdict"], &found["storey"]), (&"accepted".into(), &0.into()), "{found}");
    assert_eq!((&found["validity"], &found["of_newest_map"]), (&"effective".into(), &true.into()), "{found}");
    let echo = json(&live, &[&"topic", &"echo", &"alignment", &"--json"]);
    assert_eq!(echo["content"]["map_from_slam"], found["map_from_slam"]);
    assert!(live.text(&[&"status"]).contains("SLAM map on storey 0"));
    // What a hint excludes is a field of the topic, too.
    let hinted = json(&live, &[&"align", &"--elevation", &"0", &"--json"]);
    let echo = json(&live, &[&"topic", &"echo", &"alignment", &"--json"]);
    assert!(hinted["hints"][0]["hint"].as_str().is_some_and(|hint| hint.contains("elevation")), "{hinted}");
    assert_eq!((&echo["content"]["hints"], &echo["content"]["decide"]), (&hinted["hints"], &Value::Null));
    let kept = std::fs::read(live.home.path().join("state/alignment.json")).unwrap();
    let kept: Value = serde_json::from_slice(&kept).unwrap();
    assert_eq!((&kept["pose"]["frame_epoch"], &kept["pose"]["map_storey"]), (&1.into(), &0.into()), "{kept}");
    assert!(live.home.path().join("state/alignment-evidence.gpar").exists());
    // The state has the map itself.
    std::fs::remove_file(&robot).unwrap();
    std::fs::remove_file(robot.with_extension("pgm")).unwrap();
    live.kill("slam-align");
    let transform = live.home.path().join("site_map.yaml");
    let again = json(&live, &[&"align", &"--json", &"--transform", &transform]);
    assert!((x_m(&again) - x_m(&found)).abs() < 0.01, "{again}");
    assert!(std::fs::read_to_string(transform).unwrap().contains("child_frame_id: site_map"));
    let nothing = live.run(&[&"confirm"]);
    assert!(!nothing.status.success() && String::from_utf8_lossy(&nothing.stderr).contains("no pose waits"));
    let missing = live.home.path().join("missing.yaml");
    let state = || -> std::collections::BTreeSet<_> {
        std::fs::read_dir(live.home.path().join("state")).unwrap().map(|entry| entry.unwrap().file_name()).collect()
    };
    let before = state();
    assert!(!live.run(&[&"slam-map", &missing]).status.success());
    assert_eq!(state(), before);
    assert!((x_m(&json(&live, &[&"align", &"--json"])) - x_m(&found)).abs() < 0.01, "the map before it stays");
    live.down();
}

/// What a command that fails prints on standard error.
fn failure(live: &Live, arguments: &[&dyn AsRef<std::ffi::OsStr>]) -> String {
    let output = live.run(arguments);
    assert!(!output.status.success());
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// Waits for an alignment that is as it should be.
fn wait_for(live: &Live, is_it: impl Fn(&Value) -> bool) -> Value {
    let begun = Instant::now();
    loop {
        let output = live.run(&[&"topic", &"echo", &"alignment", &"--json"]);
        let found = serde_json::from_slice::<Value>(&output.stdout).map(|v| v["content"].clone()).unwrap_or_default();
        if is_it(&found) {
            return found;
        }
        assert!(begun.elapsed() < DEADLINE, "{found}");
    }
}

#[test]
fn maps_of_a_robot_are_followed_and_a_jump_waits_until_somebody_confirms_it() {
    let maps = convert(&demo_model(), &[]);
    let mut live = Live::of(&demo_model(), "");
    let mut robot = MappingRobot::of(&live, &maps, "planning.pgm");
    robot.publish(2.0);
    let first = wait_for(&live, |a| a["state"] == "found" || a["state"] == "tracked");
    assert_eq!(first["verdict"], "accepted");
    robot.publish(2.06);
    let followed = wait_for(&live, |a| !a["map_from_slam"].is_null() && (x_m(a) - x_m(&first) + 0.06).abs() < 0.01);
    assert!(followed["waiting"].is_null());
    robot.publish(2.30);
    let held = wait_for(&live, |a| !a["waiting"].is_null());
    assert!(held["state"] == "held" && (x_m(&held) - x_m(&followed)).abs() < 0.01, "the pose stays: {held}");
    assert!((x_m(&held["waiting"]) - x_m(&followed) + 0.24).abs() < 0.01, "{held}");
    // A daemon reports what it has published: the report is the later of the two.
    let begun = Instant::now();
    loop {
        let status = live.run(&[&"status"]);
        let text = String::from_utf8_lossy(&status.stdout);
        if text.contains("another pose waits") {
            assert!(!status.status.success(), "{text}");
            break;
        }
        assert!(begun.elapsed() < DEADLINE, "{text}");
    }
    let transform = live.home.path().join("site_map.yaml");
    let asked = live.run(&[&"align", &"--json", &"--transform", &transform]);
    let found: Value = serde_json::from_slice(&asked.stdout).unwrap();
    assert_eq!((asked.status.code(), &found["validity"]), (Some(3), &"waits_for_confirm".into()), "{found}");
    assert!(!transform.exists() && String::from_utf8_lossy(&asked.stderr).contains("is not written"));
    assert!(failure(&live, &[&"deviations"]).contains("groundplan confirm"));
    let listed = json(&live, &[&"confirm", &"--list", &"--json"]);
    assert!((x_m(&listed["waiting"]) - x_m(&held["waiting"])).abs() < 0.01, "{listed}");
    // Where a revision waits as well, one of the two has to be named.
    let mut house = House::new("IFC4");
    house.add("IFCSLAB", "Slab", PLAIN, [[0.0, 0.0, -0.2], [8.0, 4.0, 0.0]]);
    assert_eq!(live.run(&[&"load", &house.write(live.home.path())]).status.code(), Some(1));
    let both = failure(&live, &[&"confirm"]);
    assert!(both.contains("house.ifc waits") && both.contains("say which"), "{both}");
    live.text(&[&"load", &"--discard"]);
    let confirmed = json(&live, &[&"confirm", &"--json"]);
    assert!((x_m(&confirmed) - x_m(&held["waiting"])).abs() < 0.01 && confirmed["waiting"].is_null(), "{confirmed}");
    let listed = json(&live, &[&"confirm", &"--list", &"--json"]);
    assert!((x_m(&listed["before_confirmed"][0]) - x_m(&followed)).abs() < 0.01, "{listed}");
    let undone = json(&live, &[&"undo", &"pose", &"--json"]);
    assert!((x_m(&undone) - x_m(&followed)).abs() < 0.01, "the pose before comes back: {undone}");
    assert!((x_m(&undone["waiting"]) - x_m(&confirmed)).abs() < 0.01, "the confirmed one waits again: {undone}");
    assert!(failure(&live, &[&"undo", &"pose"]).contains("no confirmed pose"));
    live.text(&[&"confirm", &"pose"]);
    live.text(&[&"align", &"--transform", &transform]);
    assert!(transform.exists());
    // A search where the map does not lie finds nothing, and says nothing about the pose.
    let elsewhere = live.run(&[&"align", &"--storey", &"1", &"--json"]);
    assert_eq!(elsewhere.status.code(), Some(5), "{}", String::from_utf8_lossy(&elsewhere.stdout));
    let alignment = wait_for(&live, |a| a["verdict"] == "refused");
    assert_eq!(alignment["validity"], "effective", "{alignment}");
    live.text(&[&"deviations"]);
    // A map without walls: nothing bears the pose out.
    robot.cells.fill(0);
    robot.publish(2.30);
    wait_for(&live, |a| a["validity"] == "refused" && a["of_newest_map"] == true);
    let refused = live.run(&[&"align", &"--transform", &transform]);
    assert_eq!(refused.status.code(), Some(5));
    assert!(!transform.exists() && transform.with_extension("yaml.stale").exists());
    assert!(failure(&live, &[&"deviations"]).contains("pose_refused"));
    // What ends or changes is told.
    let history = json(&live, &[&"log", &"--kind", &"pose", &"--json"]);
    let summaries: Vec<&str> = history.as_array().unwrap().iter().filter_map(|e| e["summary"].as_str()).collect();
    let n_of = |what: &str| summaries.iter().filter(|summary| summary.contains(what)).count();
    assert!(n_of("withdrawn (pose_waits") >= 1 && n_of("withdrawn (pose_refused") == 1, "{summaries:#?}");
    assert!((1..=n_of("withdrawn")).contains(&n_of("in effect again")), "{summaries:#?}");
    live.down();
}

#[test]
fn what_is_early_counts_by_itself_and_what_is_absent_when_somebody_confirms_it() {
    let maps = convert(&demo_model(), &[]);
    // The partitions stand, the walls of the lift do not.
    let mut live = Live::of(&demo_model(), "[schedule]\nplan_time = \"2024-04-18T00:00:00\"\n[align]\napply = true\n");
    // The partition between meeting room and store was never built.
    let (wall, in_wall) = ("0T8xbPmeHQFhEy1wPGGLbq", [6.25, 12.0]);
    assert_eq!(planning_at(&live, in_wall), grid::OCCUPIED);
    let (lift, in_lift) = ("1ghCNJDIzNKO1u55gceO4K", [14.85, 13.7]);
    assert_ne!(planning_at(&live, in_lift), grid::OCCUPIED);
    let mut robot = MappingRobot::of(&live, &maps, "localization.pgm");
    robot.sees_through(&maps, [5.7, 10.2, 6.8, 14.6]);
    robot.publish(2.0);
    wait_for(&live, |a| a["state"] == "found" || a["state"] == "tracked");
    let out = live.home.path().join("deviations");
    let found = json(&live, &[&"deviations", &"--json", &"-o", &out]);
    let of_wall = &found["elements"][wall];
    assert_eq!((&of_wall["observation"], &of_wall["judgement"]), (&"absent".into(), &"late".into()), "{of_wall}");
    let of_lift = &found["elements"][lift];
    assert_eq!((&of_lift["observation"], &of_lift["judgement"]), (&"observed".into(), &"early".into()), "{of_lift}");
    for name in ["deviations.json", "actuals.csv", "deviations.bcfzip", "deviations.png"] {
        assert!(out.join(name).is_file(), "{name}");
    }
    let begun = Instant::now();
    while planning_at(&live, in_lift) != grid::OCCUPIED {
        assert!(begun.elapsed() < DEADLINE, "what was seen is not on the map");
    }
    assert_eq!(planning_at(&live, in_wall), grid::OCCUPIED, "what seems absent stays on the map");
    let refused = live.run(&[&"confirm", &lift]);
    assert!(!refused.status.success() && String::from_utf8_lossy(&refused.stderr).contains("only what is absent"));
    let confirmed = json(&live, &[&"confirm", &wall, &"--json"]);
    let of_wall = &confirmed["absent"][0];
    assert_eq!((&of_wall["global_id"], of_wall["ifc_type"].as_str()), (&wall.into(), Some("IfcWall")), "{confirmed}");
    live.kill("slam-align");
    live.kill("schedule-eval");
    let begun = Instant::now();
    while planning_at(&live, in_wall) != grid::FREE {
        assert!(begun.elapsed() < DEADLINE, "what was confirmed to be absent is still on the map");
    }
    let listed = live.text(&[&"confirm", &"--list"]);
    assert!(listed.contains(wall) && listed.contains("by user"), "{listed}");
    assert!(failure(&live, &[&"undo", &lift]).contains("is not confirmed"));
    assert!(live.text(&[&"undo", &wall]).contains("no longer confirmed"));
    let begun = Instant::now();
    while planning_at(&live, in_wall) != grid::OCCUPIED {
        assert!(begun.elapsed() < DEADLINE, "what is no longer confirmed to be absent is not on the map");
    }
    assert!(!live.text(&[&"confirm", &"--list"]).contains(wall));
    live.down();
}

#[test]
fn a_robot_is_compared_with_what_is_planned_at_the_date() {
    let maps = convert(&demo_model(), &[]);
    // Before the first wall nothing of the finished building's map can be found.
    let mut live = Live::of(&demo_model(), "[schedule]\nplan_time = \"2024-03-01T00:00:00\"\n");
    let robot = turned_map(&maps, 0, live.home.path());
    let early = live.run(&[&"slam-map", &robot, &"--json"]);
    let early: Value = serde_json::from_slice(&early.stdout).unwrap();
    assert_eq!((&early["verdict"], &early["map_from_slam"]), (&"refused".into(), &Value::Null), "{early}");
    live.text(&[&"date", &"2024-12-01T00:00:00"]);
    let found = json(&live, &[&"align", &"--json"]);
    assert_eq!((&found["verdict"], &found["inputs"]["plan_time"]), (&"accepted".into(), &"2024-12-01T00:00:00".into()));
    live.down();
}
