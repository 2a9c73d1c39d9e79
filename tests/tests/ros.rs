//! Running daemons in the ROS 2 graph, with a CycloneDDS participant as peer and without ROS.

use end_to_end::map_server::published_by_map_server;
use end_to_end::ros_facts::wait_for_transform;
use end_to_end::ros_peer::{domain, has_peer, join, site};
use end_to_end::{convert, demo_model, turned_map};
use std::process::Command;
use std::time::Duration;

#[test]
fn a_peer_gets_the_maps_of_the_files_and_those_of_the_next_date() {
    if !has_peer() {
        return;
    }
    let domain = domain();
    let mut live = site(domain, "");
    let mut early = join(domain, &[]);
    early.wait_until("all topics", |last| last.len() >= 8 && last.contains_key("/diagnostics"));
    let map = early.last["/groundplan/map"].clone();
    assert_eq!((&map["frame"], &map["resolution_m"]), (&"site_map".into(), &0.05.into()), "{map}");
    let out = live.home.path().join("out");
    live.text(&[&"export", &out]);
    for (topic, layer) in
        [("map", "planning.pgm"), ("localization_map", "localization.pgm"), ("keepout_mask", "keepout.pgm")]
    {
        let message = &early.last[&format!("/groundplan/{topic}")];
        assert_eq!(message["sha256"], published_by_map_server(&out, 0, layer), "{topic}: {message}");
    }
    let info = &early.last["/groundplan/keepout_info"];
    assert_eq!((&info["mask"], &info["type"]), (&"/groundplan/keepout_mask".into(), &0.into()), "{info}");
    assert_eq!(early.last["/groundplan/keepout_mask"]["free"], 0, "no cell of a mask says free");
    let levels = early.last["/diagnostics"]["levels"].as_object().unwrap();
    assert!(levels.len() == 8 && levels.values().all(|level| *level == 0), "{levels:?}");
    assert_eq!(early.last["/groundplan/changed"]["plan_time"], "2024-04-15T00:00:00");

    live.text(&[&"date", &"2024-06-30"]);
    early.wait_until("the next date", |last| {
        last["/groundplan/changed"]["plan_time"] == "2024-06-30T00:00:00"
            && last["/groundplan/map"]["sha256"] != map["sha256"]
    });
    // Who comes later gets the newest set, also from a bridge that was killed.
    live.kill("ros-bridge");
    let mut late = join(domain, &[]);
    late.wait_until("the newest set", |last| {
        last.get("/groundplan/map").is_some_and(|map| map["sha256"] == early.last["/groundplan/map"]["sha256"])
    });
    assert!(!late.last.contains_key("/tf_static"), "there is no map of a robot");
    live.down();
}

#[test]
fn a_bridge_that_was_stopped_and_goes_on_is_heard_again() {
    if !has_peer() {
        return;
    }
    let domain = domain();
    let mut live = site(domain, "");
    let mut peer = join(domain, &[]);
    peer.wait_until("maps", |last| last.contains_key("/groundplan/changed"));
    let process = live.status().unwrap()["daemons"]["ros-bridge"]["process_id"].to_string();
    for signal in ["-STOP", "-CONT"] {
        assert!(Command::new("kill").args([signal, &process]).status().unwrap().success());
        std::thread::sleep(Duration::from_secs(1));
    }
    live.text(&[&"date", &"2024-06-30"]);
    peer.wait_until("the next date", |last| last["/groundplan/changed"]["plan_time"] == "2024-06-30T00:00:00");
    live.wait_until_healthy();
    live.down();
}

#[test]
fn a_slam_map_from_the_graph_is_aligned_and_the_transform_comes_back() {
    if !has_peer() {
        return;
    }
    let domain = domain();
    let maps = convert(&demo_model(), &[]);
    let mut live = site(domain, "slam_map_topic = \"/map\"\n");
    live.text(&[&"date", &"2024-12-01"]);
    let robot = turned_map(&maps, 0, live.home.path());
    let mut peer = join(domain, &[&"--publish-slam-map", &robot]);
    wait_for_transform(&mut peer, &live);
    live.wait_until_healthy();
    live.down();
}
