//! Python programs read the running daemons' memory in place, with the package in `common/python`.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

use end_to_end::live::Live;
use end_to_end::tower::{FIRST, Tower, published};
use end_to_end::{announce, root};
use serde_json::Value;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

/// Prints the set of a site, and the next one, while it holds on to an array of the first.
const FOLLOWER: &str = r#"
import json, sys, time, groundplan

def describe(site):
    return json.dumps({"plan_time": str(site.plan_time), "valid_until": str(site.valid_until), "robot": site.index.robot_name,
        "radius_m": site.index.robot["radius_m"], "storeys": [grid.storey for grid in site.grids],
        "grids": [f"{grid.content_hash:016x}" for grid in site.grids]})

with groundplan.Bus(sys.argv[1], sys.argv[2]) as bus:
    reader = groundplan.SiteReader(bus)
    first = reader.wait(60)
    held, copied = first.grids[0].planning, first.grids[0].planning.copy()
    print(describe(first), flush=True)
    while reader.current().plan_time == first.plan_time:
        time.sleep(0.01)
    print(describe(reader.current()), flush=True)
    assert (held == copied).all(), "an array that is held does not change"
    assert not held.flags.writeable
"#;

/// Reads all maps of a site until its standard input ends.
const READER: &str = r#"
import sys, threading, groundplan

with groundplan.Bus(sys.argv[1], sys.argv[2]) as bus:
    reader = groundplan.SiteReader(bus)
    print(len(reader.wait(60).grids), flush=True)
    ended = threading.Event()
    threading.Thread(target=lambda: (sys.stdin.read(), ended.set()), daemon=True).start()
    while not ended.is_set():
        reader.current()
        ended.wait(0.2)
"#;

/// Says when the maps may be used, and then when they may not be used any more because of one daemon.
const ROBOT: &str = r#"
import sys, time, groundplan

with groundplan.Bus(sys.argv[1], sys.argv[2]) as bus:
    reader, ends = groundplan.SiteReader(bus), time.monotonic() + 60
    def wait_for(is_it):
        while not is_it(reader.verdict()):
            assert time.monotonic() < ends, reader.verdict()
            time.sleep(0.05)
        print(reader.verdict(), flush=True)
    wait_for(lambda verdict: verdict.word == "current" and verdict.may_drive)
    wait_for(lambda verdict: "rasterize" in (verdict.reason or "") and not verdict.may_drive)
"#;

/// Says when the maps may be used, whether they still may once a daemon that was never heard would be silent, and then that they may
/// not be used any more because of what follows the server.
const FOLLOWING_ROBOT: &str = r#"
import sys, time, groundplan
from groundplan.map_rule import SILENT_AFTER_NS

with groundplan.Bus(sys.argv[1], sys.argv[2]) as bus:
    reader, ends = groundplan.SiteReader(bus), time.monotonic() + 60
    def wait_for(is_it):
        while not is_it(reader.verdict()):
            assert time.monotonic() < ends, reader.verdict()
            time.sleep(0.05)
        return reader.verdict()
    wait_for(lambda verdict: verdict.may_drive)
    joined_ns = time.monotonic_ns()
    while time.monotonic_ns() < joined_ns + SILENT_AFTER_NS + 1_000_000_000:
        verdict = reader.verdict()
        time.sleep(0.05)
    print(verdict, flush=True)
    print(wait_for(lambda verdict: "site-follow" in (verdict.reason or "")), flush=True)
"#;

/// Says of which robot profile the maps of two robots are, that they may be used, and what comes without a name.
const ROBOTS: &str = r#"
import sys, time, groundplan

said = []
for robot in ["lift", "scan"]:
    with groundplan.Bus(sys.argv[1], sys.argv[2], robot=robot) as bus:
        reader, ends = groundplan.SiteReader(bus), time.monotonic() + 60
        said.append(reader.wait(60).index.robot_name)
        while not reader.verdict().may_drive:
            assert time.monotonic() < ends, reader.verdict()
            time.sleep(0.05)
try:
    groundplan.SiteReader(groundplan.Bus(sys.argv[1], sys.argv[2]))
except groundplan.BusGone as gone:
    said.append(str(gone))
try:
    groundplan.Bus(sys.argv[1], sys.argv[2], robot="Lift 1")
except ValueError as error:
    said.append(str(error))
print("; ".join(said), flush=True)
"#;

/// Joins with one reader after the other until there is no place; says how many have one, and why the next has none.
const CROWD: &str = r#"
import sys, groundplan

readers = []
try:
    while len(readers) < 100:
        readers.append(groundplan.SiteReader(groundplan.Bus(sys.argv[1], sys.argv[2])))
        readers[-1].wait(60)
except groundplan.BusFull as error:
    print(len(readers), error, flush=True)
    sys.stdin.read()
"#;

/// Starts a Python program on the bus of a site; the first line that it prints is the second of both.
fn started(live: &Live, program: &str) -> (Child, String) {
    let mut command = python().unwrap();
    command.args(["-c", program]).arg(live.root.path()).arg(&live.prefix);
    let mut child = command.stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap();
    let mut line = String::new();
    BufReader::new(child.stdout.as_mut().unwrap()).read_line(&mut line).unwrap();
    (child, line.trim().to_owned())
}

#[test]
fn readers_do_not_keep_the_operator_out() {
    if python().is_none() {
        return;
    }
    let mut live = Live::start();
    let mut readers = Vec::new();
    for (n, date) in [(7, "2024-04-27T00:00:00"), (20, "2024-04-29T10:00:00")] {
        while readers.len() < n {
            let (reader, n_grids) = started(&live, READER);
            assert!(n_grids.parse::<usize>().unwrap() > 1, "{n_grids} grids");
            readers.push(reader);
        }
        assert_eq!(live.text(&[&"date", &date]), date);
        assert_eq!(live.index()["content"]["plan_time"], date);
    }
    let (crowd, refusal) = started(&live, CROWD);
    assert!(refusal.contains("places are kept for daemons and commands"), "{refusal}");
    assert_eq!(live.text(&[&"date", &"2024-05-13T00:00:00"]), "2024-05-13T00:00:00");
    assert_eq!(live.index()["content"]["plan_time"], "2024-05-13T00:00:00");
    live.wait_until_healthy();
    for mut reader in readers.into_iter().chain([crowd]) {
        drop(reader.stdin.take());
        assert!(reader.wait().unwrap().success());
    }
    live.down();
}

#[test]
fn a_robot_in_python_has_no_map_when_a_daemon_falls_silent() {
    if python().is_none() {
        return;
    }
    let mut live = Live::start();
    let (mut robot, first) = started(&live, ROBOT);
    assert!(first.contains("word='current', reason=None"), "{first}");
    let process = live.status().unwrap()["daemons"]["rasterize"]["process_id"].to_string();
    assert!(Command::new("kill").args(["-STOP", &process]).status().unwrap().success());
    let mut second = String::new();
    BufReader::new(robot.stdout.as_mut().unwrap()).read_line(&mut second).unwrap();
    assert!(second.contains("word='no_map', reason='rasterize has missed 3 heartbeats'"), "{second}");
    assert!(robot.wait().unwrap().success());
    // It may have been killed for its silence, and be another process now.
    let _ = Command::new("kill").args(["-CONT", &process]).status().unwrap();
    live.wait_until_healthy();
    live.down();
}

#[test]
fn a_robot_in_python_uses_the_maps_of_a_server_until_what_follows_it_falls_silent() {
    if python().is_none() {
        return;
    }
    let tower = Tower::with_keys();
    let server = Live::of(&end_to_end::demo_model(), &tower.serve("signing", FIRST));
    let first = published(&server, &tower, 0);
    let mut live = Live::following(&tower.follow(""));
    live.shows(first);
    let (mut robot, verdict) = started(&live, FOLLOWING_ROBOT);
    assert!(verdict.contains("word='current', reason=None"), "{verdict}");
    let process = live.status().unwrap()["daemons"]["site-follow"]["process_id"].to_string();
    assert!(Command::new("kill").args(["-STOP", &process]).status().unwrap().success());
    let mut second = String::new();
    BufReader::new(robot.stdout.as_mut().unwrap()).read_line(&mut second).unwrap();
    // It may have been killed for its silence, and be another process now.
    let _ = Command::new("kill").args(["-CONT", &process]).status().unwrap();
    assert!(second.contains("word='no_map', reason='site-follow has missed 3 heartbeats'"), "{second}");
    assert!(robot.wait().unwrap().success());
    live.wait_until_healthy();
    live.down();
}

#[test]
fn each_robot_in_python_has_maps_of_its_own() {
    if python().is_none() {
        return;
    }
    let profiles = tempfile::tempdir().unwrap();
    let mut tables = String::new();
    for (robot, profile) in [("lift", "tall"), ("scan", "low")] {
        let path = profiles.path().join(format!("{profile}.toml"));
        std::fs::write(&path, format!("name = \"{profile}\"\n")).unwrap();
        tables += &format!("[[robots]]\nname = {robot:?}\nprofile = {path:?}\nresolution_m = 0.1\n");
    }
    let mut live = Live::of(&end_to_end::demo_model(), &tables);
    let (mut program, said) = started(&live, ROBOTS);
    assert!(program.wait().unwrap().success());
    assert!(said.starts_with("tall; low; the bus has no ") && said.contains("robot=\"lift\""), "{said}");
    assert!(said.contains("'Lift 1' is no name of a robot"), "{said}");
    live.down();
}

/// Python with what the package needs, which it takes from the sources; `None`, and a loud word, where it cannot be had.
fn python() -> Option<Command> {
    let made = Command::new(root().join("scripts/python-env")).args(["iceoryx2==0.10.0", "numpy"]).output().unwrap();
    if made.status.success() {
        let mut command = Command::new(root().join("target/venv/bin/python"));
        command.env("PYTHONPATH", root().join("common/python/src"));
        return Some(command);
    }
    announce(&format!("SKIPPED: iceoryx2 for Python cannot be installed: {}", String::from_utf8_lossy(&made.stderr)));
    None
}

fn toml_of(path: PathBuf) -> toml::Table {
    std::fs::read_to_string(path).unwrap().parse().unwrap()
}

/// The example program sees in a grid what the client sees.
fn example_agrees(live: &Live, storey: usize) {
    let mut command = python().unwrap();
    command.arg(root().join("scripts/python_subscriber.py")).arg("--root").arg(live.root.path());
    let output = command.args(["--prefix", &live.prefix, "--storey", &storey.to_string()]).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let seen: Value = serde_json::from_slice(&output.stdout).unwrap();
    let own = live.text(&[&"topic", &"echo", &format!("grid/{storey:02}"), &"--json"]);
    let own: Value = serde_json::from_str(&own).unwrap();
    let content = &own["content"];
    assert_eq!(
        (&seen["epoch"], &seen["content_hash"], &seen["free"], &seen["origin_m"]),
        (&own["epoch"], &own["content_hash"], &content["free_cells"], &content["origin_m"])
    );
    assert_eq!([&seen["shape"][1], &seen["shape"][0]], [&content["size_cells"][0], &content["size_cells"][1]]);
    assert!(seen["keepout"].as_u64().unwrap() > 0);
}

#[test]
fn python_sees_the_grids_and_sets_that_the_client_sees() {
    let Some(mut follower) = python() else { return };
    let mut live = Live::start();
    let dates = ["2024-04-27T00:00:00", "2024-04-29T10:00:00"];
    live.text(&[&"date", &dates[0]]);
    follower.args(["-c", FOLLOWER]).arg(live.root.path()).arg(&live.prefix);
    let mut child = follower.stdout(Stdio::piped()).spawn().unwrap();
    let mut lines = BufReader::new(child.stdout.take().unwrap()).lines();
    for date in dates {
        live.text(&[&"date", &date]);
        let seen: Value = serde_json::from_str(&lines.next().unwrap().unwrap()).unwrap();
        let own = live.index()["content"].clone();
        assert_eq!(seen["plan_time"].as_str().unwrap(), date.replace('T', " "));
        assert_eq!(seen["grids"], own["grids"]);
        assert_eq!((seen["robot"].as_str(), seen["radius_m"].as_f64()), (Some("default"), Some(0.3)));
        assert!(seen["valid_until"].as_str().unwrap() > seen["plan_time"].as_str().unwrap());
    }
    assert!(child.wait().unwrap().success());
    example_agrees(&live, 0);
    example_agrees(&live, 1);
    live.down();
    assert_eq!(live.segments(), 0, "nothing is left in shared memory");
    let output = python().unwrap().args(["-c", FOLLOWER]).arg(live.root.path()).arg(&live.prefix).output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(said.contains("BusGone") && said.contains("start the site"), "{said}");
}

#[test]
fn the_package_has_the_version_of_the_workspace_and_the_library_of_the_bus() {
    let package = toml_of(root().join("common/python/pyproject.toml"));
    let workspace = toml_of(root().join("Cargo.toml"));
    assert_eq!(package["project"]["version"], workspace["workspace"]["package"]["version"]);
    let locked = toml_of(Path::new(&root()).join("Cargo.lock"));
    let packages = locked["package"].as_array().unwrap();
    let library = packages.iter().find(|p| p["name"].as_str() == Some("iceoryx2")).unwrap();
    let wanted = format!("iceoryx2=={}", library["version"].as_str().unwrap());
    assert_eq!(package["project"]["dependencies"][0].as_str(), Some(wanted.as_str()));
}
