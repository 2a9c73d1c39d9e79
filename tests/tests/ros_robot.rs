//! A robot with Nav2 and SLAM in the ROS 2 graph, played by a CycloneDDS participant: what it is told, and what it may ask.

use end_to_end::map_server::published_by_map_server;
use end_to_end::ros_facts::{is_at, route_graph_is_in_the_frame_of_the_maps};
use end_to_end::ros_peer::{domain, graph, has_peer, join, site, wait_for_facts, wait_for_graph};
use end_to_end::{convert, demo_model, turned_map};
use serde_json::Value;
use std::collections::BTreeMap;
use std::process::Command;

/// Two places of the ground floor: open before the walls of the rooms stand, closed while they are built, and further apart
/// behind them afterwards.
const ENDS: &str = "23.23,0.72,21.73,10.22";

#[test]
fn nav2_is_stopped_before_its_map_changes_and_plans_around_what_closes() {
    if !has_peer() {
        return;
    }
    let domain = domain();
    let mut live = site(domain, "service_mapping = \"cyclone_dds\"\n[ros.nav2]\n");
    live.text(&[&"date", &"2024-04-06"]);
    let mut nav2 = join(domain, &[&"--nav2", &"--plan", &ENDS]);
    nav2.wait_until("a way", |last| last.get("plan").is_some_and(|plan| plan["length_m"].is_number()));
    let before_m = nav2.last["plan"]["length_m"].as_f64().unwrap();
    nav2.order.clear();
    live.text(&[&"date", &"2024-04-10"]);
    nav2.wait_until("the change", is_at("2024-04-10T00:00:00"));
    let place =
        |topic: &str| nav2.order.iter().rposition(|other| other == topic).unwrap_or_else(|| panic!("no {topic}"));
    assert!(place("/navigate_to_pose/_action/cancel_goal") < place("/groundplan/keepout_mask"), "{:?}", nav2.order);
    for costmap in ["global_costmap", "local_costmap"] {
        let cleared = place(&format!("/{costmap}/clear_entirely_{costmap}"));
        assert!(place("/groundplan/map") < cleared && cleared < place("/groundplan/changed"), "{:?}", nav2.order);
    }
    assert_eq!(nav2.last["plan"]["length_m"], Value::Null, "the rooms are closed while walls are built");
    live.text(&[&"date", &"2024-06-30"]);
    nav2.wait_until("the next change", is_at("2024-06-30T00:00:00"));
    nav2.wait_until("a way around", |last| last["plan"]["length_m"].as_f64().is_some_and(|m| m > before_m));
    nav2.wait_until("the route graph", |last| last.contains_key("/route_server/set_route_graph"));
    route_graph_is_in_the_frame_of_the_maps(&nav2);
    live.wait_until_healthy();
    live.down();
}

#[test]
fn nav2_goes_on_without_a_reader_that_hangs_and_status_says_so() {
    if !has_peer() {
        return;
    }
    let domain = domain();
    let mut live = site(domain, "service_mapping = \"cyclone_dds\"\n[ros.nav2]\n");
    let mut nav2 = join(domain, &[&"--nav2"]);
    // By default its lease, of which a part is over when it stops, may end before the bridge has waited: then no reader hangs.
    let mut hanging = join(domain, &[&"--lease", &"60"]);
    for peer in [&mut nav2, &mut hanging] {
        peer.wait_until("maps", |last| last.contains_key("/groundplan/changed"));
    }
    hanging.signal("-STOP");
    live.text(&[&"date", &"2024-04-20"]);
    nav2.wait_until("the change", is_at("2024-04-20T00:00:00"));
    live.wait_for_status("the reader that hangs", |status| {
        let warning = status["daemons"]["ros-bridge"]["warning"].as_str();
        warning.is_some_and(|warning| warning.contains("a reader has not taken /groundplan/"))
    });
    hanging.signal("-CONT");
    hanging.wait_until("the change", is_at("2024-04-20T00:00:00"));
    live.wait_until_healthy();
    live.down();
}

#[test]
fn a_robot_that_was_silent_for_longer_than_it_may_be_is_heard_and_served_again() {
    if !has_peer() {
        return;
    }
    let domain = domain();
    let mut live = site(domain, "slam_map_topic = \"/map\"\n");
    let map = turned_map(&convert(&demo_model(), &[]), 0, live.home.path());
    let mut robot = join(domain, &[&"--lease", &"2", &"--publish-slam-map", &map]);
    robot.wait_until("maps", |last| last.contains_key("/groundplan/changed"));
    wait_for_graph(&live, &[", 1 other participant;", "/map 1 publisher"]);
    // As where its network is away: it hears nothing of the bridge, and the bridge nothing of it.
    robot.signal("-STOP");
    wait_for_graph(&live, &[", 0 other participants;", "/map 0 publishers"]);
    live.text(&[&"date", &"2024-04-20"]);
    robot.signal("-CONT");
    robot.wait_until("the change", is_at("2024-04-20T00:00:00"));
    wait_for_graph(&live, &[", 1 other participant;", "/map 1 publisher"]);
    assert_eq!(live.status().unwrap()["daemons"]["ros-bridge"]["restarts"], 1);
    live.down();
}

#[test]
fn the_plan_time_moves_from_ros_only_where_the_site_allows_it() {
    if !has_peer() {
        return;
    }
    let domain = domain();
    let mut live = site(domain, "service_mapping = \"cyclone_dds\"\n");
    let mut peer = join(domain, &[&"--set", &"plan_time=2024-05-10", &"--call", &"next_change"]);
    peer.wait_until("a refusal", |last| last.contains_key("/groundplan/ros_bridge/set_parameters"));
    let refused = &peer.last["/groundplan/ros_bridge/set_parameters"];
    assert!(refused["success"] == false && refused["message"].as_str().unwrap().contains("allow_control"), "{refused}");
    assert!(!peer.last.contains_key("/groundplan/next_change"), "the service is not offered");
    drop(peer);
    // The storey is the robot's to tell.
    let mut peer = join(domain, &[&"--set", &"storey=1"]);
    peer.wait_until("the other storey", |last| last.get("/groundplan/changed").is_some_and(|now| now["storey"] == 1));
    drop(peer);
    live.kill("ros-bridge");
    let mut peer = join(domain, &[]);
    peer.wait_until("maps", |last| last.contains_key("/groundplan/changed"));
    assert_eq!(peer.last["/groundplan/changed"]["storey"], 1, "it survives the bridge");
    live.down();

    let allowed = "service_mapping = \"cyclone_dds\"\nallow_control = true\n";
    let mut live = site(domain, allowed);
    let mut peer = join(domain, &[&"--set", &"plan_time=2024-05-10"]);
    peer.wait_until("the date", is_at("2024-05-10T00:00:00"));
    drop(peer);
    let mut peer = join(domain, &[&"--call", &"next_change", &"--call", &"confirm"]);
    peer.wait_until("answers", |last| {
        last.contains_key("/groundplan/next_change") && last.contains_key("/groundplan/confirm")
    });
    let answer = &peer.last["/groundplan/next_change"];
    assert!(answer["success"] == true && answer["message"].as_str().unwrap().contains("2024-05-"), "{answer}");
    assert_eq!(peer.last["/groundplan/confirm"]["success"], false, "nothing waits");
    live.down();
}

#[test]
fn a_robot_is_told_when_its_maps_grow_stale_and_kept_out_of_everything() {
    if !has_peer() {
        return;
    }
    let domain = domain();
    let mut live = site(domain, "keepout_when_stale = true\n");
    let mut peer = join(domain, &[]);
    let state = |state: &'static str| {
        move |last: &BTreeMap<String, Value>| {
            last.get("/groundplan/heartbeat").is_some_and(|beat| beat["state"] == state)
        }
    };
    peer.wait_until("fresh maps", state("fresh"));
    peer.wait_until("a mask", |last| last.contains_key("/groundplan/keepout_mask"));
    let mask = peer.last["/groundplan/keepout_mask"].clone();
    let process = live.status().unwrap()["daemons"]["rasterize"]["process_id"].to_string();
    assert!(Command::new("kill").args(["-STOP", &process]).status().unwrap().success());
    peer.wait_until("stale maps", state("stale"));
    let reason = peer.last["/groundplan/heartbeat"]["reason"].as_str().unwrap().to_owned();
    assert!(reason.contains("rasterize"), "{reason}");
    peer.wait_until("a mask of everything", |last| {
        last["/groundplan/keepout_mask"]["occupied"].as_u64() > mask["occupied"].as_u64()
            && last["/groundplan/keepout_mask"]["unknown"] == 0
    });
    // It stays so until the daemon hangs no longer, or is another one.
    let closed = peer.last["/groundplan/keepout_mask"]["sha256"].clone();
    peer.last.remove("/groundplan/heartbeat");
    peer.wait_until("the next heartbeat", |last| last.contains_key("/groundplan/heartbeat"));
    if state("stale")(&peer.last) {
        assert_eq!(peer.last["/groundplan/keepout_mask"]["sha256"], closed);
    }
    // On a slow machine it has been killed for hanging already, and another one is there.
    let _ = Command::new("kill").args(["-CONT", &process]).status().unwrap();
    peer.wait_until("fresh maps again", state("fresh"));
    peer.wait_until("the mask again", |last| last["/groundplan/keepout_mask"]["sha256"] == mask["sha256"]);
    live.wait_until_healthy();
    live.down();
}

#[test]
fn maps_are_moved_into_the_frame_of_slam_and_the_robot_is_placed() {
    if !has_peer() {
        return;
    }
    let domain = domain();
    let maps = convert(&demo_model(), &[]);
    let more = "slam_map_topic = \"/map\"\nin_slam_frame = true\n";
    let mut live = site(domain, more);
    live.text(&[&"date", &"2024-12-01"]);
    let robot = turned_map(&maps, 0, live.home.path());
    let mut early = join(domain, &[]);
    early.wait_until("a heartbeat", |last| last.contains_key("/groundplan/heartbeat"));
    assert!(!early.last.contains_key("/groundplan/map"), "without a pose there is no map in the robot's frame");
    let mut peer = join(domain, &[&"--publish-slam-map", &robot, &"--robot-at", &"17.7,9.0,0.5"]);
    peer.wait_until("a map", |last| last.contains_key("/groundplan/map"));
    let map = peer.last["/groundplan/map"].clone();
    assert_eq!((&map["frame"], &map["resolution_m"]), (&"map".into(), &0.05.into()), "{map}");
    let facts = wait_for_facts(&live, |facts| facts["robot_in_map"].is_object());
    let asked: Value = serde_json::from_str(&live.text(&[&"align", &"--json"])).unwrap();
    let number = |value: &Value, key: &str| value[key].as_f64().unwrap();
    let pose = &asked["map_from_slam"];
    let (sin, cos) = libm::sincos(number(pose, "yaw_rad"));
    let x_m = number(pose, "x_m") + 17.7 * cos - 9.0 * sin;
    let y_m = number(pose, "y_m") + 17.7 * sin + 9.0 * cos;
    let placed = &facts["robot_in_map"];
    assert!(
        (number(placed, "x_m") - x_m).abs() < 0.05 && (number(placed, "y_m") - y_m).abs() < 0.05,
        "{placed} {pose}"
    );
    live.down();
}

#[test]
fn a_robot_that_drives_down_the_ramp_gets_the_maps_of_the_level_there() {
    if !has_peer() {
        return;
    }
    let domain = domain();
    let maps = convert(&demo_model(), &[]);
    let mut live = site(domain, "slam_map_topic = \"/map\"\n");
    live.text(&[&"date", &"2024-12-01"]);
    let robot = turned_map(&maps, 0, live.home.path());
    let mut peer = join(domain, &[&"--publish-slam-map", &robot]);
    peer.wait_until("a transform", |last| last.contains_key("/tf_static"));
    assert_eq!(peer.last["/groundplan/changed"]["storey"], 0);
    drop(peer);
    let asked: Value = serde_json::from_str(&live.text(&[&"align", &"--json"])).unwrap();
    let pose = ["x_m", "y_m", "yaw_rad"].map(|key| asked["map_from_slam"][key].as_f64().unwrap());
    let graph = maps.json("site-graph.json");
    let ramp = graph["edges"].as_array().unwrap().iter().find(|edge| edge["class"] == "ramp").unwrap();
    let place = |place: &Value| [0, 1].map(|k| place[k].as_f64().unwrap());
    let line = ramp["line_m"].as_array().unwrap();
    // The line is that from the level below.
    let [to, from] = [place(&line[0]), place(&line[line.len() - 1])];
    let (sin, cos) = libm::sincos(pose[2]);
    const N_STEPS: usize = 10;
    let at = |k: usize| [0, 1].map(|i| from[i] + (to[i] - from[i]) * k as f64 / N_STEPS as f64);
    // The same in the robot's own map.
    let poses = (0..=N_STEPS).map(at).map(|[x, y]| {
        let [x, y] = [x - pose[0], y - pose[1]];
        format!("{},{},0", cos * x + sin * y, cos * y - sin * x)
    });
    let way = poses.collect::<Vec<_>>().join(";");
    let mut peer = join(domain, &[&"--publish-slam-map", &robot, &"--robot-at", &way]);
    // It goes on once it has been seen where it is, or on the level below.
    for place in (0..=N_STEPS).map(at) {
        wait_for_facts(&live, |facts| {
            let is_there = |k: usize| {
                let seen = facts["robot_in_map"][["x_m", "y_m"][k]].as_f64();
                seen.is_some_and(|seen| (seen - place[k]).abs() < 0.05)
            };
            facts["storey"] == 2 || [0, 1].into_iter().all(is_there)
        });
        peer.step(1);
    }
    peer.wait_until("the level below", |last| last.get("/groundplan/changed").is_some_and(|now| now["storey"] == 2));
    // All outputs are those of that storey.
    let out = live.home.path().join("out");
    live.text(&[&"export", &out]);
    peer.wait_until("its heartbeat", |last| last["/groundplan/heartbeat"]["storey"] == 2);
    for (topic, layer) in [("map", "planning.pgm"), ("keepout_mask", "keepout.pgm")] {
        let expected = published_by_map_server(&out, 2, layer);
        peer.wait_until(topic, |last| last[&format!("/groundplan/{topic}")]["sha256"] == expected);
    }
    live.down();
}

#[test]
fn the_plan_time_follows_a_simulator() {
    if !has_peer() {
        return;
    }
    let domain = domain();
    // A week a second.
    let mut live = site(domain, "[ros.sim_time]\nplan_time_at_zero = \"2024-04-06\"\nrate = 604800.0\n");
    let mut peer = join(domain, &[&"--clock", &"0"]);
    let mut at = String::new();
    while at.as_str() < "2024-05-15" {
        let last = at.clone();
        peer.wait_until("a later plan time", |all| {
            all.get("/groundplan/changed").is_some_and(|now| now["plan_time"].as_str().unwrap() != last)
        });
        peer.last["/groundplan/changed"]["plan_time"].as_str().unwrap().clone_into(&mut at);
        assert!(last.is_empty() || last == "2024-04-15T00:00:00" || at > last, "{at} after {last}");
    }
    // The simulation begins anew.
    drop(peer);
    let mut peer = join(domain, &[&"--clock", &"0"]);
    peer.wait_until("an earlier plan time", |last| {
        last.get("/groundplan/changed").is_some_and(|now| now["plan_time"].as_str().unwrap() < "2024-04-30")
    });
    live.down();
}

#[test]
fn another_node_on_the_topic_of_the_map_is_told() {
    if !has_peer() {
        return;
    }
    let domain = domain();
    let maps = convert(&demo_model(), &[]);
    let mut live = site(domain, "");
    assert!(graph(&live).contains("0 other participants"), "{}", graph(&live));
    let robot = turned_map(&maps, 0, live.home.path());
    let mut rival = join(domain, &[&"--publish-slam-map", &robot, &"--topic", &"/groundplan/map"]);
    rival.wait_until("maps", |last| last.contains_key("/groundplan/changed"));
    let warning = |status: &Value| status["daemons"]["ros-bridge"]["warning"].clone();
    let warning = warning(&live.wait_for_status("a warning", |status| warning(status).is_string()));
    assert_eq!(warning, "1 publisher of other nodes on /groundplan/map: readers keep one of them");
    assert!(graph(&live).contains("1 other participant; "), "{}", graph(&live));
    drop(rival);
    live.wait_until_healthy();
    live.down();
}
