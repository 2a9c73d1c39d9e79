//! Running daemons and SLAM nodes of all kinds in the ROS 2 graph: maps that grow, that are large, of another building or no
//! maps, many participants, two publishers, another domain.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

use end_to_end::live::{DEADLINE, Live, POLL_INTERVAL};
use end_to_end::peer::Peer;
use end_to_end::ros_peer::{domain, graph, has_peer, join, site, slam, wait_for_graph};
use end_to_end::{Maps, convert, corpus, demo_model, turned_map};
use frames::{Map, Rigid2, Slam, wrapped};
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::time::Instant;

/// The date at which the maps of robots are made and the sites are.
const FINISHED: &str = "2024-12-01";

/// A site that takes SLAM maps, its maps as files, and a map of its ground floor as a robot might have made it.
fn site_with_slam(domain: u16) -> (Live, Maps, PathBuf) {
    let maps = convert(&demo_model(), &["--date", FINISHED]);
    let live = site(domain, "slam_map_topic = \"/map\"\n");
    live.text(&[&"date", &FINISHED]);
    let robot = turned_map(&maps, 0, live.home.path());
    (live, maps, robot)
}

fn warning<'a>(status: &'a Value, daemon: &str) -> &'a str {
    status["daemons"][daemon]["warning"].as_str().unwrap_or_default()
}

/// Waits for the result of a search of the newest map, of another map than that with this hash.
fn wait_for_search(live: &Live, earlier: &Value) -> Value {
    let begun = Instant::now();
    loop {
        let output = live.run(&[&"topic", &"echo", &"alignment", &"--json"]);
        let found = serde_json::from_slice::<Value>(&output.stdout).map(|v| v["content"].clone()).unwrap_or_default();
        if found["of_newest_map"] == true && found["inputs"]["slam_map_hash"] != *earlier {
            return found;
        }
        assert!(begun.elapsed() < DEADLINE, "{found}");
        std::thread::sleep(POLL_INTERVAL);
    }
}

/// Reads until the bridge has sent two heartbeats: the second one has begun after this was called.
fn wait_for_heartbeats(peer: &mut Peer) {
    for _ in 0..2 {
        peer.last.remove("/groundplan/heartbeat");
        peer.wait_until("a heartbeat", |last| last.contains_key("/groundplan/heartbeat"));
    }
}

fn pose<To, From>(value: &Value) -> Rigid2<To, From> {
    let [x, y, yaw] = ["x_m", "y_m", "yaw_rad"].map(|key| value[key].as_f64().unwrap());
    Rigid2::new([x, y], yaw)
}

/// Where the transform puts the robot, and where it is.
fn is_right(transform: &Value, truth: &Value, robot_in_slam: [f64; 2]) -> bool {
    let (slam_from_map, map_from_slam) = (pose::<Slam, Map>(transform), pose::<Map, Slam>(truth));
    let [x, y] = slam_from_map.apply_inverse(robot_in_slam);
    let [true_x, true_y] = map_from_slam.apply(robot_in_slam);
    let turn_rad = wrapped(slam_from_map.yaw_rad() + map_from_slam.yaw_rad());
    (x - true_x).hypot(y - true_y) < 0.05 && turn_rad.abs() < 0.01
}

#[test]
fn a_map_that_grows_is_aligned_as_soon_as_it_suffices_and_stays_so() {
    if !has_peer() {
        return;
    }
    let domain = domain();
    let (mut live, maps, _) = site_with_slam(domain);
    let mut peer = join(domain, &[]);
    let mut robot = slam(domain, "drive", &maps.path(), &[&"--on-line"]);
    let (mut searched, mut published, mut verdicts) = (Value::Null, Vec::new(), Vec::new());
    // Until the robot has been in three rooms, and the map has grown beyond the first.
    for number in 1..=12 {
        robot.step(1);
        robot.wait_until("a map", |last| last.get("/map").is_some_and(|map| map["map"] == number));
        let found = wait_for_search(&live, &searched);
        searched = found["inputs"]["slam_map_hash"].clone();
        verdicts.push(found["verdict"].as_str().unwrap().to_owned());
        published.push(robot.last["/map"].clone());
        wait_for_heartbeats(&mut peer);
        if found["verdict"] == "accepted" {
            peer.wait_until("a transform", |last| last.contains_key("/tf_static"));
            let transform = &peer.last["/tf_static"]["transforms"][0];
            assert_eq!((&transform["parent"], &transform["child"]), (&"map".into(), &"site_map".into()), "{transform}");
            let robot_m = &published[number - 1]["robot_m"];
            let robot_m = [0, 1].map(|k| robot_m[k].as_f64().unwrap());
            let truth = &robot.last["drive"];
            assert!(is_right(transform, truth, robot_m), "map {number}: {transform}, and it is at {truth}");
        } else {
            assert!(!peer.last.contains_key("/tf_static"), "map {number}: {}", peer.last["/tf_static"]);
            assert!(warning(&live.status().unwrap(), "slam-align").contains("pose_refused"));
        }
    }
    let n_before = verdicts.iter().take_while(|verdict| *verdict != "accepted").count();
    assert!(n_before < 9 && verdicts[n_before..].iter().all(|v| v == "accepted"), "{verdicts:?}");
    let (first, last) = (&published[0], &published[11]);
    let size = |map: &Value| [0, 1].map(|k| map["size"][k].as_u64().unwrap());
    assert!((0..2).all(|k| size(last)[k] > size(first)[k]) && last["origin_m"] != first["origin_m"], "{first} {last}");
    live.wait_until_healthy();
    live.down();
}

#[test]
fn a_map_of_25_megabytes_every_second_disturbs_no_daemon() {
    if !has_peer() {
        return;
    }
    let domain = domain();
    let (mut live, _, map) = site_with_slam(domain);
    let of_all = |status: &Value, key: &str| -> Vec<Value> {
        status["daemons"].as_object().unwrap().values().map(|daemon| daemon[key].clone()).collect()
    };
    live.wait_until_healthy();
    let before = live.status().unwrap();
    let mut peer = join(domain, &[]);
    let mut large = slam(domain, "large", &map, &[]);
    peer.wait_until("a transform", |last| last.contains_key("/tf_static"));
    for _ in 0..5 {
        wait_for_heartbeats(&mut peer);
        assert_eq!(warning(&live.status().unwrap(), "ros-bridge"), "");
    }
    let is_late = |map: &Value| map["map"].as_u64() > Some(8) && map["size"] == serde_json::json!([5000, 5000]);
    large.wait_until("many maps", |last| last.get("/map").is_some_and(is_late));
    peer.wait_until("fresh maps", |last| last["/groundplan/heartbeat"]["state"] == "fresh");
    drop(large);
    // A node that publishes the same map as it is, which is another one than all before.
    let earlier = wait_for_search(&live, &Value::Null)["inputs"]["slam_map_hash"].clone();
    let _robot = join(domain, &[&"--publish-slam-map", &map]);
    let found = wait_for_search(&live, &earlier);
    assert_eq!(found["verdict"], "accepted", "{found}");
    live.wait_until_healthy();
    let after = live.status().unwrap();
    for key in ["process_id", "restarts"] {
        assert_eq!(of_all(&after, key), of_all(&before, key), "{key}");
    }
    live.down();
}

#[test]
fn a_real_map_of_another_building_is_refused_with_why_and_brings_no_transform() {
    let Some(folder) = corpus("real-maps") else { return };
    if !has_peer() {
        return;
    }
    let domain = domain();
    let (mut live, _, _) = site_with_slam(domain);
    let mut peer = join(domain, &[&"--publish-slam-map", &folder.join("bonn/youbot-2021-10.yaml")]);
    let found = wait_for_search(&live, &Value::Null);
    assert_eq!((&found["verdict"], &found["map_from_slam"]), (&"refused".into(), &Value::Null), "{found}");
    let reason = found["reason"].as_str().unwrap();
    assert!(reason.contains("the best pose"), "{reason}");
    let status = live.wait_for_status("the reason", |status| warning(status, "slam-align").contains(reason));
    assert_eq!((warning(&status, "ros-bridge"), &status["alignment"]["verdict"]), ("", &"refused".into()), "{status}");
    let asked = live.run(&[&"align"]);
    assert_eq!(asked.status.code(), Some(5));
    let words = String::from_utf8_lossy(&asked.stdout).into_owned() + &String::from_utf8_lossy(&asked.stderr);
    assert!(words.contains("refused") && words.contains("the best pose"), "{words}");
    wait_for_heartbeats(&mut peer);
    assert!(!peer.last.contains_key("/tf_static"), "{}", peer.last["/tf_static"]);
    live.down();
}

/// Messages that are no map, and what the bridge says of each.
const FAULTS: [(&str, &str); 18] = [
    ("a column more than cells", "cells, and its width and height make"),
    ("the largest width and height", "its width and height make 18446744065119617025"),
    ("no cells", "the grid has no cells"),
    ("only unknown cells", "no cell of the grid is known"),
    ("no resolution", "the resolution of the grid is 0 m"),
    ("a negative resolution", "the resolution of the grid is -0.05 m"),
    ("a resolution that is no number", "the resolution of the grid is NaN m"),
    ("an origin that is no number", "the origin of the grid is at NaN"),
    ("a tilted origin", "turned out of the plane"),
    ("a turn that is no number", "is no rotation"),
    ("a cell of 101", "a cell of 101"),
    ("a cell of -2", "a cell of -2"),
    ("a frame that is no text", "its message cannot be read"),
    ("an unknown encoding", "its message cannot be read"),
    ("more cells than bytes", "its message cannot be read"),
    ("cut off", "its message cannot be read"),
    ("cut off in its head", "its message cannot be read"),
    ("random bytes", "its message cannot be read"),
];

#[test]
fn what_is_no_map_is_refused_with_why_and_the_next_map_is_taken() {
    if !has_peer() {
        return;
    }
    let domain = domain();
    let (mut live, _, map) = site_with_slam(domain);
    live.wait_until_healthy();
    let process = live.status().unwrap()["daemons"]["ros-bridge"]["process_id"].clone();
    let mut robot = slam(domain, "faulty", &map, &[&"--on-line"]);
    let mut publish = |name: &str| {
        robot.step(1);
        robot.wait_until(name, |last| last.get("/map").is_some_and(|map| map["map"] == name));
    };
    for (name, words) in FAULTS {
        publish(name);
        live.wait_for_status(name, |status| {
            let warning = warning(status, "ros-bridge");
            warning.contains("a SLAM map is not taken: ") && warning.contains(words)
        });
        publish("good");
        live.wait_for_status("the good map", |status| {
            warning(status, "ros-bridge").is_empty() && status["alignment"]["verdict"] == "accepted"
        });
    }
    live.wait_until_healthy();
    assert_eq!(live.status().unwrap()["daemons"]["ros-bridge"]["process_id"], process, "it has not been started again");
    live.down();
}

#[test]
fn among_thirty_participants_maps_go_both_ways() {
    if !has_peer() {
        return;
    }
    let domain = domain();
    let (mut live, _, map) = site_with_slam(domain);
    let mut robot = join(domain, &[&"--participants", &"30", &"--publish-slam-map", &map]);
    robot.wait_until("all to hear the bridge", |last| last.get("participants").is_some_and(|all| all["hear"] == 30));
    let is_whole =
        |last: &BTreeMap<String, Value>| last.contains_key("/groundplan/map") && last.contains_key("/tf_static");
    robot.wait_until("a map and a transform", is_whole);
    wait_for_graph(&live, &["30 other participants"]);
    live.wait_until_healthy();
    live.down();
}

#[test]
fn two_publishers_of_slam_maps_are_told_until_one_is_left() {
    if !has_peer() {
        return;
    }
    let domain = domain();
    let (mut live, maps, map) = site_with_slam(domain);
    let mut peer = join(domain, &[&"--publish-slam-map", &map]);
    peer.wait_until("a transform", |last| last.contains_key("/tf_static"));
    let mut other = slam(domain, "drive", &maps.path(), &[&"--on-line"]);
    other.step(1);
    let status = live.wait_for_status("two publishers", |status| !warning(status, "ros-bridge").is_empty());
    assert_eq!(
        warning(&status, "ros-bridge"),
        "2 publishers on /map: the newest SLAM map is now that of one, now that of another"
    );
    drop(other);
    // The map of the one that is left is the robot's again.
    live.wait_until_healthy();
    assert_eq!(live.status().unwrap()["alignment"]["verdict"], "accepted");
    live.down();
}

#[test]
fn a_participant_of_another_domain_sees_nothing_of_the_site() {
    if !has_peer() {
        return;
    }
    let (own, other) = (domain(), domain());
    let (mut live, _, map) = site_with_slam(own);
    let mut peer = join(own, &[]);
    let mut stranger = join(other, &[&"--for", &"5", &"--publish-slam-map", &map]);
    stranger.wait_until_its_end();
    wait_for_heartbeats(&mut peer);
    assert!(stranger.order.is_empty(), "{:?}", stranger.last);
    assert!(graph(&live).contains("1 other participant; "), "{}", graph(&live));
    assert!(live.status().unwrap()["alignment"].is_null(), "its map is none of this site");
    live.down();
}
