//! Running daemons in the ROS 2 graph, with a participant on Fast DDS as peer, which is the usual one of ROS 2.

use end_to_end::fast_dds::{has_peer, join};
use end_to_end::live::Live;
use end_to_end::map_server::published_by_map_server;
use end_to_end::ros_facts::{is_at, route_graph_is_in_the_frame_of_the_maps, wait_for_transform};
use end_to_end::ros_peer::{domain, site};
use end_to_end::{convert, demo_model, turned_map};
use serde_json::Value;
use std::collections::BTreeMap;

/// What a map server publishes of the maps that the site exports, by topic.
fn exported(live: &Live) -> BTreeMap<String, String> {
    let out = live.home.path().join("out");
    live.text(&[&"export", &out]);
    let layers = [("map", "planning.pgm"), ("localization_map", "localization.pgm"), ("keepout_mask", "keepout.pgm")];
    layers.map(|(topic, layer)| (format!("/groundplan/{topic}"), published_by_map_server(&out, 0, layer))).into()
}

/// The newest maps are these. `changed` comes after them only where Nav2 waits for them.
fn has_maps_of(published: BTreeMap<String, String>) -> impl Fn(&BTreeMap<String, Value>) -> bool {
    move |last| {
        let is_there =
            |(topic, sha256): (&String, &String)| last.get(topic).is_some_and(|map| map["sha256"] == **sha256);
        published.iter().all(is_there)
    }
}

#[test]
fn a_node_on_fast_dds_gets_the_maps_of_the_files_and_those_of_the_next_date() {
    if !has_peer() {
        return;
    }
    let domain = domain();
    let mut live = site(domain, "");
    let mut early = join(domain, &[]);
    early.wait_until("all topics", |last| {
        let topics = ["map", "localization_map", "keepout_mask", "keepout_info", "changed", "heartbeat"];
        topics.iter().all(|topic| last.contains_key(&format!("/groundplan/{topic}")))
    });
    early.wait_until("the node", |last| {
        last.get("ros_discovery_info").is_some_and(|graph| graph["nodes"][0] == "/groundplan/ros_bridge")
    });
    let map = early.last["/groundplan/map"].clone();
    assert_eq!((&map["frame"], &map["resolution_m"]), (&"site_map".into(), &0.05.into()), "{map}");
    let info = &early.last["/groundplan/keepout_info"];
    assert_eq!((&info["mask"], &info["type"]), (&"/groundplan/keepout_mask".into(), &0.into()), "{info}");
    early.wait_until("the maps of the files", has_maps_of(exported(&live)));

    live.text(&[&"date", &"2024-06-30"]);
    let next = exported(&live);
    early.wait_until("the next date", is_at("2024-06-30T00:00:00"));
    early.wait_until("its maps", has_maps_of(next.clone()));
    assert_ne!(early.last["/groundplan/map"]["sha256"], map["sha256"]);
    // Who comes later gets the newest set, also from a bridge that was killed.
    join(domain, &[]).wait_until("the newest set", has_maps_of(next.clone()));
    live.kill("ros-bridge");
    let mut late = join(domain, &[]);
    late.wait_until("the newest set again", has_maps_of(next));
    assert!(!late.last.contains_key("/tf_static"), "there is no map of a robot");
    live.down();
}

/// A peer publishes a map as SLAM does, and gets the pose of it.
fn slam_map_is_aligned(more: &[&dyn AsRef<std::ffi::OsStr>]) {
    if !has_peer() {
        return;
    }
    let domain = domain();
    let maps = convert(&demo_model(), &[]);
    let mut live = site(domain, "slam_map_topic = \"/map\"\n");
    live.text(&[&"date", &"2024-12-01"]);
    let robot = turned_map(&maps, 0, live.home.path());
    let arguments: [&dyn AsRef<std::ffi::OsStr>; 2] = [&"--publish-slam-map", &robot];
    let mut peer = join(domain, &[&arguments, more].concat());
    wait_for_transform(&mut peer, &live);
    live.wait_until_healthy();
    live.down();
}

#[test]
fn a_latched_slam_map_is_aligned_and_the_transform_comes_back() {
    slam_map_is_aligned(&[]);
}

#[test]
fn a_volatile_slam_map_is_aligned_and_the_transform_comes_back() {
    slam_map_is_aligned(&[&"--volatile"]);
}

#[test]
fn nav2_on_fast_dds_answers_before_and_after_its_maps_change() {
    if !has_peer() {
        return;
    }
    let domain = domain();
    let mut live = site(domain, "service_mapping = \"fast_dds\"\n[ros.nav2]\n");
    let mut nav2 = join(domain, &[&"--nav2"]);
    nav2.wait_until("maps", is_at("2024-04-15T00:00:00"));
    nav2.order.clear();
    live.text(&[&"date", &"2024-06-30"]);
    nav2.wait_until("the change", is_at("2024-06-30T00:00:00"));
    nav2.wait_until("its maps", has_maps_of(exported(&live)));
    let place =
        |topic: &str| nav2.order.iter().rposition(|other| other == topic).unwrap_or_else(|| panic!("no {topic}"));
    for action in ["navigate_to_pose", "navigate_through_poses", "follow_waypoints"] {
        assert!(
            place(&format!("/{action}/_action/cancel_goal")) < place("/groundplan/keepout_mask"),
            "{:?}",
            nav2.order
        );
    }
    for costmap in ["global_costmap", "local_costmap"] {
        let cleared = place(&format!("/{costmap}/clear_entirely_{costmap}"));
        assert!(place("/groundplan/map") < cleared && cleared < place("/groundplan/changed"), "{:?}", nav2.order);
    }
    route_graph_is_in_the_frame_of_the_maps(&nav2);
    // An answer that is lost shows as a warning of the bridge.
    live.wait_until_healthy();
    live.down();
}

#[test]
fn a_lifecycle_manager_on_fast_dds_pauses_nav2_and_resumes_it_with_the_next_maps() {
    if !has_peer() {
        return;
    }
    let domain = domain();
    let mut live = site(domain, "[ros.nav2]\npause = \"lifecycle\"\n");
    let mut nav2 = join(domain, &[&"--nav2"]);
    nav2.wait_until("maps", is_at("2024-04-15T00:00:00"));
    let manager = "/lifecycle_manager_navigation/manage_nodes";
    live.text(&[&"date", &"2024-06-30"]);
    nav2.wait_until("a pause", |last| last.get(manager).is_some_and(|call| call["command"] == 1));
    assert_eq!(nav2.last["/groundplan/changed"]["plan_time"], "2024-04-15T00:00:00", "it stops before");
    nav2.wait_until("its end", |last| last[manager]["command"] == 2);
    nav2.wait_until("the change", is_at("2024-06-30T00:00:00"));
    live.wait_until_healthy();
    live.down();
}

#[test]
fn nodes_on_fast_dds_get_answers_to_their_calls() {
    if !has_peer() {
        return;
    }
    let domain = domain();
    let mut live = site(domain, "service_mapping = \"fast_dds\"\nallow_control = true\n");
    let mut peer = join(domain, &[&"--set", &"plan_time=2024-05-10"]);
    peer.wait_until("the date", is_at("2024-05-10T00:00:00"));
    peer.wait_until("an answer", |last| last.contains_key("/groundplan/ros_bridge/set_parameters"));
    assert_eq!(peer.last["/groundplan/ros_bridge/set_parameters"]["success"], true);
    drop(peer);
    let mut peer = join(domain, &[&"--call", &"next_change", &"--call", &"confirm", &"--set", &"storey=-2"]);
    peer.wait_until("answers", |last| {
        let names = ["next_change", "confirm", "ros_bridge/set_parameters"];
        names.iter().all(|name| last.contains_key(&format!("/groundplan/{name}")))
    });
    let answer = &peer.last["/groundplan/next_change"];
    assert!(answer["success"] == true && answer["message"].as_str().unwrap().contains("2024-05-"), "{answer}");
    assert_eq!(peer.last["/groundplan/confirm"]["success"], false, "nothing waits");
    let refused = &peer.last["/groundplan/ros_bridge/set_parameters"];
    assert!(refused["success"] == false && refused["message"].as_str().unwrap().contains("storey"), "{refused}");
    live.down();
}
