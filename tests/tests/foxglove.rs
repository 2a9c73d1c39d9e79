//! Foxglove beside running daemons, with a WebSocket client that decodes what comes by the schemas that were advertised.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

use end_to_end::foxglove_peer::{PACKAGES, connect, served};
use end_to_end::live::{DEADLINE, Live, POLL_INTERVAL};
use end_to_end::map_server::published_by_map_server;
use end_to_end::peer::Peer;
use end_to_end::ros_peer::domain;
use end_to_end::{announce, convert, demo_model, root, turned_map};
use serde_json::Value;
use sha2::{Digest, Sha256};
use std::io::Write;
use std::net::{Ipv4Addr, SocketAddr, TcpListener, TcpStream};
use std::process::Command;
use std::time::Instant;

/// True, unless what the client needs cannot be had: then it says so.
fn has_client() -> bool {
    let made = Command::new(root().join("scripts/python-env")).args(PACKAGES).output().unwrap();
    if !made.status.success() {
        announce(&format!("SKIPPED: websockets cannot be installed: {}", String::from_utf8_lossy(&made.stderr)));
    }
    made.status.success()
}

/// A site that serves Foxglove; nothing in the graph of ROS looks at it.
fn site(address: SocketAddr, plan_time: &str) -> Live {
    let domain = domain();
    let ros = format!("[ros]\nenabled = true\ndomain_id = {domain}\n[ros.foxglove]\naddress = \"{address}\"\n");
    Live::of(&demo_model(), &format!("[schedule]\nplan_time = \"{plan_time}\"\n{ros}"))
}

/// Any port that is free.
fn free() -> SocketAddr {
    SocketAddr::from((Ipv4Addr::LOCALHOST, 0))
}

/// Waits for the maps of a plan time.
fn wait_for(peer: &mut Peer, plan_time: &str) {
    peer.wait_until(plan_time, |last| {
        last.get("/groundplan/changed").is_some_and(|changed| changed["plan_time"] == plan_time)
    });
}

#[test]
fn a_late_client_gets_the_maps_of_the_files_and_those_of_the_next_date() {
    if !has_client() {
        return;
    }
    let mut live = site(free(), "2024-04-15");
    let address = served(&live);
    let mut peer = connect(address, &[]);
    peer.wait_until("all channels but those of an alignment", |last| {
        let is_advertised = |topic: &&String| topic.starts_with("advertised ");
        last.keys().filter(is_advertised).count() == 13 && last.len() == 1 + 13 + 11
    });
    let server = &peer.last["serverInfo"];
    assert_eq!((&server["name"], &server["subprotocol"]), (&"groundplan".into(), &"foxglove.sdk.v1".into()));
    let channel = &peer.last["advertised /groundplan/map"];
    let encodings = (&channel["schema"], &channel["schema_encoding"], &channel["encoding"]);
    assert_eq!(encodings, (&"nav_msgs/msg/OccupancyGrid".into(), &"ros2msg".into(), &"cdr".into()));
    let out = live.home.path().join("out");
    live.text(&[&"export", &out]);
    for (topic, layer) in
        [("map", "planning.pgm"), ("localization_map", "localization.pgm"), ("keepout_mask", "keepout.pgm")]
    {
        let message = &peer.last[&format!("/groundplan/{topic}")];
        assert_eq!(message["sha256"], published_by_map_server(&out, 0, layer), "{topic}: {message}");
    }
    let rooms = peer.last["/groundplan/room_entities"]["rooms"].as_array().unwrap();
    let semantic: Value = serde_json::from_slice(&std::fs::read(out.join("semantic.json")).unwrap()).unwrap();
    let names = semantic.to_string();
    assert!(!rooms.is_empty() && rooms.iter().all(|room| names.contains(&room["GlobalId"].to_string())), "{rooms:?}");
    assert!(rooms.iter().any(|room| room["state"] == "blocked"), "{rooms:?}");
    assert_eq!(peer.last["/diagnostics"]["n_status"], 8);
    let map = peer.last["/groundplan/map"].clone();
    live.text(&[&"date", &"2024-06-30"]);
    wait_for(&mut peer, "2024-06-30T00:00:00");
    let newest = peer.last["/groundplan/map"]["sha256"].clone();
    assert_ne!(newest, map["sha256"]);
    live.kill("ros-bridge");
    let mut late = connect(served(&live), &["--topic", "/groundplan/map"]);
    late.wait_until("the newest map", |last| last.contains_key("/groundplan/map"));
    assert_eq!(late.last["/groundplan/map"]["sha256"], newest);
    live.down();
}

#[test]
fn the_building_comes_under_its_url_as_an_export_writes_it() {
    if !has_client() {
        return;
    }
    let mut live = site(free(), "2024-04-15");
    let mut peer = connect(served(&live), &["--topic", "/groundplan/world", "--world"]);
    peer.wait_until("the model", |last| last.contains_key("asset 1"));
    let out = live.home.path().join("out");
    live.text(&[&"export", &out, &"--world"]);
    let exported = Sha256::digest(std::fs::read(out.join("world/site.glb")).unwrap());
    let exported: String = exported.iter().map(|byte| format!("{byte:02x}")).collect();
    assert_eq!(peer.last["asset 1"]["sha256"], exported, "{}", peer.last["asset 1"]);
    live.text(&[&"date", &"2024-06-30"]);
    peer.wait_until("the next model", |last| last.contains_key("asset 2"));
    assert_ne!(peer.last["asset 2"]["sha256"], exported);
    live.down();
}

#[test]
fn clients_that_do_not_read_talk_nonsense_or_are_too_many_stop_nothing() {
    if !has_client() {
        return;
    }
    let mut live = site(free(), "2024-03-01");
    let address = served(&live);
    let mut deaf = connect(address, &["--deaf"]);
    deaf.wait_until("it is deaf", |last| last.contains_key("deaf"));
    // One that never finishes its handshake, and one that never begins it.
    let _silent = TcpStream::connect(address).unwrap();
    TcpStream::connect(address).unwrap().write_all(&[0xff; 4096]).unwrap();
    let mut peer = connect(address, &["--topic", "/groundplan/changed", "--topic", "/groundplan/map"]);
    for month in 4..13 {
        let date = format!("2024-{month:02}-01");
        live.text(&[&"date", &date]);
        wait_for(&mut peer, &format!("{date}T00:00:00"));
    }
    // Too many at once are all disconnected; who comes after that gets the newest map.
    let flood: Vec<TcpStream> = (0..200).map_while(|_| TcpStream::connect(address).ok()).collect();
    peer.wait_until_its_end();
    drop(flood);
    let begun = Instant::now();
    // Another free port says that it was begun again.
    while served(&live) == address {
        assert!(begun.elapsed() < DEADLINE, "{:?}", live.status());
        std::thread::sleep(POLL_INTERVAL);
    }
    let mut late = connect(served(&live), &["--topic", "/groundplan/changed"]);
    wait_for(&mut late, "2024-12-01T00:00:00");
    live.down();
}

#[test]
fn the_pose_of_a_slam_map_comes_with_its_covariance() {
    if !has_client() {
        return;
    }
    let maps = convert(&demo_model(), &[]);
    let mut live = site(free(), "2024-12-01");
    let robot = turned_map(&maps, 0, live.home.path());
    let mut peer = connect(served(&live), &["--topic", "/groundplan/alignment", "--topic", "/tf_static"]);
    live.text(&[&"slam-map", &robot]);
    peer.wait_until("a pose", |last| ["/groundplan/alignment", "/tf_static"].iter().all(|t| last.contains_key(*t)));
    let pose = &peer.last["/groundplan/alignment"];
    let asked: Value = serde_json::from_str(&live.text(&[&"align", &"--json"])).unwrap();
    let [found, expected] = [&pose["position_m"][0], &asked["map_from_slam"]["x_m"]].map(|x| x.as_f64().unwrap());
    assert!((found - expected).abs() < 1e-3 && pose["frame"] == "site_map", "{pose} {asked}");
    let covariance = pose["covariance"].as_array().unwrap();
    assert!(covariance.len() == 36 && covariance[0].as_f64().unwrap() > 0.0, "{pose}");
    assert_eq!(peer.last["/tf_static"]["frames"][0], serde_json::json!(["map", "site_map"]));
    live.down();
}

#[test]
fn a_port_that_is_taken_is_an_error_until_it_is_free() {
    let address = TcpListener::bind(free()).map(|listener| listener.local_addr().unwrap()).unwrap();
    let mut live = site(address, "2024-03-01");
    assert_eq!(served(&live), address);
    live.down();
    let taken = TcpListener::bind(address).unwrap();
    live.start_up();
    let begun = Instant::now();
    let error = |status: Value| status["daemons"]["ros-bridge"]["error"].as_str().map(str::to_owned);
    let told = format!("Foxglove cannot be served at {address}");
    while !live.status().and_then(error).is_some_and(|error| error.contains(&told) && error.contains("in use")) {
        assert!(begun.elapsed() < DEADLINE, "{:?}", live.status());
        std::thread::sleep(POLL_INTERVAL);
    }
    drop(taken);
    live.wait_until_healthy();
    assert_eq!(served(&live), address);
    live.down();
}
