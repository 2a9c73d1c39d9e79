//! A running bridge as a node of ROS 2 itself sees it, with rclpy.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

use end_to_end::live::{DEADLINE, Live};
use end_to_end::peer::Peer;
use end_to_end::ros_node::{consumer, has_node, join};
use end_to_end::ros_peer::{domain, site};
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// The node of the bridge.
const BRIDGE: &str = "/groundplan/ros_bridge";
/// All that it can publish.
const TOPICS: [&str; 16] = [
    "/diagnostics",
    "/groundplan/changed",
    "/groundplan/grid_map",
    "/groundplan/heartbeat",
    "/groundplan/keepout_info",
    "/groundplan/keepout_mask",
    "/groundplan/localization_map",
    "/groundplan/map",
    "/groundplan/rooms",
    "/groundplan/route",
    "/groundplan/route_graph",
    "/groundplan/speed_info",
    "/groundplan/speed_mask",
    "/groundplan/waypoints",
    "/initialpose",
    "/tf_static",
];
/// All that it can be asked.
const SERVICES: [&str; 9] = [
    "/groundplan/align",
    "/groundplan/confirm",
    "/groundplan/next_change",
    "/groundplan/ros_bridge/describe_parameters",
    "/groundplan/ros_bridge/get_parameter_types",
    "/groundplan/ros_bridge/get_parameters",
    "/groundplan/ros_bridge/list_parameters",
    "/groundplan/ros_bridge/set_parameters",
    "/groundplan/ros_bridge/set_parameters_atomically",
];
/// Every node of rclpy publishes these, the looking ones as well; on a busy machine such a node is lost and found again.
const NODES_OWN: [&str; 2] = ["/parameter_events", "/rosout"];
/// Seconds for which the answer must not change again.
const STEADY_S: u64 = 8;

/// What is wrong with what the node sees; empty if all is the bridge's.
fn wrong(last: &BTreeMap<String, Value>) -> Vec<String> {
    let Some(graph) = last.get("graph") else { return vec!["nothing is seen".to_owned()] };
    let mut wrong = Vec::new();
    let names = |what: &str| -> BTreeSet<&str> {
        graph["of_node"][what].as_object().into_iter().flatten().map(|(name, _)| name.as_str()).collect()
    };
    let [published, subscribed, services] = ["publishers", "subscriptions", "services"].map(names);
    for topic in TOPICS {
        let publishers = graph["endpoints"][topic]["publishers"].as_array();
        if !publishers.is_some_and(|all| all.len() == 1 && all[0][0] == BRIDGE) {
            wrong.push(format!("publishers of {topic}: {publishers:?}"));
        }
    }
    wrong.extend(TOPICS.iter().filter(|topic| !published.contains(**topic)).map(|topic| format!("{topic} is not its")));
    wrong.extend(SERVICES.iter().filter(|name| !services.contains(**name)).map(|name| format!("{name} is not its")));
    if subscribed != BTreeSet::from(["/map", "/tf", "/tf_static"]) {
        wrong.push(format!("it subscribes to {subscribed:?}"));
    }
    let all = graph["endpoints"].as_object().into_iter().flatten();
    for (topic, ends) in all {
        if NODES_OWN.contains(&topic.as_str()) {
            let ends = ends["publishers"].as_array().into_iter().flatten();
            let its = ends.filter(|end| end[0] == BRIDGE).count();
            if its != usize::from(published.contains(topic.as_str())) {
                wrong.push(format!("{its} publishers of {topic} are its"));
            }
            continue;
        }
        let all = ["publishers", "subscriptions"].into_iter().flat_map(|what| ends[what].as_array()).flatten();
        wrong.extend(
            all.filter(|end| end[0].as_str().unwrap().contains("UNKNOWN")).map(|end| format!("{topic}: {end}")),
        );
    }
    wrong
}

/// The node sees all of the bridge, and goes on seeing it.
fn sees_all(node: &mut Peer) {
    let right_at = |last: &BTreeMap<String, Value>| wrong(last).is_empty();
    node.wait_until("all of the bridge", right_at);
    let seen = node.last["graph"]["number"].as_u64().unwrap();
    node.wait_until("the same later", |last| {
        assert_eq!(wrong(last), Vec::<String>::new());
        last["graph"]["number"].as_u64().unwrap() >= seen + STEADY_S
    });
}

#[test]
fn every_topic_and_service_of_the_bridge_is_its_nodes_for_early_and_late_nodes() {
    if !has_node() {
        return;
    }
    let domain = domain();
    let more = "slam_map_topic = \"/map\"\nrobot_frame = \"base_link\"\ninitial_pose = true\n\
                allow_control = true\nservice_mapping = \"fast_dds\"\nspeed_mask = true\ngrid_map = true\n";
    let mut early = join(domain);
    let mut live = site(domain, more);
    sees_all(&mut early);
    sees_all(&mut join(domain));
    // Its successor is another participant with the same name.
    live.kill("ros-bridge");
    sees_all(&mut join(domain));
    live.down();
}

/// The latched grids.
const GRIDS: [&str; 3] = ["/groundplan/keepout_mask", "/groundplan/localization_map", "/groundplan/map"];

/// Exports the maps of a plan time once the daemons hold them; with when the next change comes.
fn exported(live: &Live, plan_time: &str) -> (PathBuf, String) {
    let out = live.home.path().join(plan_time.replace(':', ""));
    let begun = Instant::now();
    loop {
        live.text(&[&"export", &out]);
        let manifest: Value = serde_json::from_slice(&std::fs::read(out.join("manifest.json")).unwrap()).unwrap();
        if manifest["plan_time"] == plan_time {
            return (out, manifest["valid_until"].as_str().unwrap_or_default().to_owned());
        }
        assert!(begun.elapsed() < DEADLINE, "the maps are those of {}", manifest["plan_time"]);
    }
}

/// A node that comes now gets the grids of a storey as the exported files have them, cell by cell.
fn gets_the_files(domain: u16, out: &Path, storey: &str) {
    let mut node = consumer(domain, &[&"--export", &out, &"--storey", &storey]);
    let is_file =
        |grid: &Value| grid["differing"] == 0 && grid["cells"].as_u64() > Some(0) && grid["frame"] == "site_map";
    node.wait_until("the grids of the files", |last| GRIDS.iter().all(|grid| last.get(*grid).is_some_and(is_file)));
}

/// What a node is answered that does these actions one after the other.
fn answers<const N: usize>(domain: u16, actions: [&str; N]) -> [Value; N] {
    let mut node = consumer(domain, &actions.each_ref().map(|action| action as &dyn AsRef<OsStr>));
    node.wait_until("answers", |last| actions.iter().all(|action| last.contains_key(*action)));
    actions.map(|action| node.last[action].clone())
}

#[test]
fn a_node_gets_the_exported_grids_and_answers_also_of_a_bridge_that_was_killed() {
    if !has_node() {
        return;
    }
    let domain = domain();
    let mut live = site(domain, "allow_control = true\nservice_mapping = \"fast_dds\"\n");
    let (out, next_time) = exported(&live, "2024-04-15T00:00:00");
    gets_the_files(domain, &out, "0");
    let [names, time, storey] = answers(domain, ["list", "get plan_time", "get storey"]);
    assert_eq!(names["answer"], serde_json::json!(["plan_time", "storey"]), "{names}");
    assert_eq!((&time["answer"], &storey["answer"]), (&"2024-04-15T00:00:00".into(), &(-1).into()), "{time} {storey}");

    let [set, refused] = answers(domain, ["set storey=1", "set-atomically storey=-2"]);
    assert_eq!(set["answer"], true, "{set}");
    assert!(refused["answer"] == false && refused["reason"].as_str().unwrap().contains("no storey"), "{refused}");
    gets_the_files(domain, &out, "1");

    let [called] = answers(domain, ["call next_change"]);
    assert_eq!(called["answer"], true, "{called}");
    let (out, _) = exported(&live, &next_time);
    gets_the_files(domain, &out, "1");

    live.kill("ros-bridge");
    gets_the_files(domain, &out, "1");
    let [time, storey] = answers(domain, ["get plan_time", "get storey"]);
    assert_eq!((&time["answer"], &storey["answer"]), (&next_time.into(), &1.into()), "{time} {storey}");
    let actions = ["set-atomically storey=0", "set plan_time=2024-06-30", "call confirm"];
    let [set, moved, confirmed] = answers(domain, actions);
    assert_eq!((&set["answer"], &moved["answer"]), (&true.into(), &true.into()), "{set} {moved}");
    assert_eq!(confirmed["answer"], false, "nothing waits: {confirmed}");
    let (out, _) = exported(&live, "2024-06-30T00:00:00");
    gets_the_files(domain, &out, "0");
    live.down();
}
