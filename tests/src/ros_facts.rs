//! Facts that hold for every participant of the ROS 2 graph, whatever its DDS.

use super::live::Live;
use super::peer::Peer;
use serde_json::Value;
use std::collections::BTreeMap;

/// Waits until the transform comes, which is that of the alignment.
pub fn wait_for_transform(peer: &mut Peer, live: &Live) {
    peer.wait_until("a transform", |last| last.contains_key("/tf_static"));
    let transform = &peer.last["/tf_static"]["transforms"][0];
    assert_eq!((&transform["parent"], &transform["child"]), (&"map".into(), &"site_map".into()), "{transform}");
    let asked: Value = serde_json::from_str(&live.text(&[&"align", &"--json"])).unwrap();
    let yaw = asked["map_from_slam"]["yaw_rad"].as_f64().unwrap();
    assert!((transform["yaw_rad"].as_f64().unwrap() + yaw).abs() < 1e-3, "{transform} {asked}");
}

/// The route graph that the server has loaded lies in the frame of the maps.
pub fn route_graph_is_in_the_frame_of_the_maps(nav2: &Peer) {
    let file = nav2.last["/route_server/set_route_graph"]["file"].as_str().unwrap();
    let graph: Value = serde_json::from_slice(&std::fs::read(file).unwrap()).unwrap();
    assert_eq!(graph["features"][0]["properties"]["frame"], "site_map", "as the maps");
}

/// The maps are those of a plan time.
pub fn is_at(plan_time: &'static str) -> impl Fn(&BTreeMap<String, Value>) -> bool {
    move |last| last.get("/groundplan/changed").is_some_and(|changed| changed["plan_time"] == plan_time)
}
