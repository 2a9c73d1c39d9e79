//! Heights, slopes and limits of speed in recordings, in the ROS 2 graph, in Foxglove and in Python, against the exported files.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

use end_to_end::foxglove_peer::{connect, served};
use end_to_end::live::Live;
use end_to_end::ros_peer::{domain, join};
use end_to_end::{announce, client, demo_model, files_in, groundplan, root};
use serde_json::Value;
use sha2::{Digest, Sha256};
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// What reads recordings.
const READERS: [&str; 5] = ["rosbags==0.11.9", "mcap==1.6.0", "mcap-ros2-support==0.6.0", "numpy", "pillow==11.3.0"];
/// What looks at a running site.
const PEERS: [&str; 4] =
    ["cyclonedds==11.0.1", "iceoryx2==0.10.0", "websockets==15.0.1", "mcap-protobuf-support==0.5.4"];
/// Damages that the check of a recording does to its messages.
const N_DAMAGES: u64 = 12;

/// Compares heights and slopes of all storeys with the exported files; prints how many storeys are level and how many not.
const PYTHON: &str = r#"
import json, pathlib, sys
import groundplan, numpy as np
from PIL import Image

out = pathlib.Path(sys.argv[3])
directories = [storey["directory"] for storey in json.loads((out / "manifest.json").read_text())["storeys"]]
n_level = n_not_level = 0
with groundplan.Bus(sys.argv[1], sys.argv[2]) as bus:
    for grid in groundplan.SiteReader(bus).wait(60).grids:
        for name, values in [("elevation", grid.elevation), ("slope", grid.slope)]:
            path = out / directories[grid.storey] / f"{name}.png"
            assert path.exists() == (values is not None), path
            if values is None:
                continue
            facts = dict(line.split(": ", 1) for line in path.with_suffix(".yaml").read_text().splitlines())
            pixels = np.asarray(Image.open(path)).astype(int)[::-1]
            scale = float(facts["scale"])
            expected = np.where(pixels == int(facts["none"]), np.nan, float(facts["offset"]) + scale * pixels)
            np.testing.assert_allclose(values, expected, rtol=0, atol=scale / 2 + 1e-9)
        n_level += grid.elevation is None
        n_not_level += grid.elevation is not None
print(n_level, n_not_level)
"#;

/// True, unless Python packages cannot be had: then it says so.
fn has(packages: &[&str]) -> bool {
    let made = Command::new(root().join("scripts/python-env")).args(packages).output().unwrap();
    if !made.status.success() {
        announce(&format!("SKIPPED: {packages:?} cannot be installed: {}", String::from_utf8_lossy(&made.stderr)));
    }
    made.status.success()
}

/// What a script counted in a recording.
fn checked(script: &str, options: &[&str], recording: &Path, out: &Path) -> Value {
    let mut check = Command::new(root().join("target/venv/bin/python"));
    check.arg(root().join("scripts").join(script)).args(options);
    let output = check.arg(recording).arg(out).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

/// A profile of a robot that is slow where doors swing, and takes slopes up to this one.
fn slow_robot(home: &Path, max_slope_rad: f64) -> PathBuf {
    let path = home.join(format!("robot-{max_slope_rad}.toml"));
    let rule = "[[safety]]\nnear = \"door_swing\"\nspeed_m_s = 0.2\n";
    std::fs::write(&path, format!("name = \"slow\"\nmax_slope_rad = {max_slope_rad}\n{rule}")).unwrap();
    path
}

fn recorded(model: &Path, robot: &Path, recording: &Path, more: &[&str]) {
    let mut arguments: Vec<&dyn AsRef<std::ffi::OsStr>> = vec![&"convert", &model, &"--robot", &robot, &"--mcap"];
    arguments.extend([&recording as &dyn AsRef<std::ffi::OsStr>, &"--date", &"all", &"--resolution", &"0.2"]);
    arguments.extend(more.iter().map(|a| a as &dyn AsRef<std::ffi::OsStr>));
    let output = groundplan(&arguments);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

#[test]
fn a_recording_of_a_site_on_terrain_has_the_heights_of_the_files_if_they_are_asked_for() {
    if !has(&READERS) {
        return;
    }
    let home = tempfile::tempdir().unwrap();
    let model = home.path().join("site.ifc");
    let made =
        Command::new(root().join("scripts/build_terrain_site")).arg(&model).args(["--size", "60", "60"]).status();
    assert!(made.unwrap().success());
    let (recording, out) = (home.path().join("site.mcap"), home.path().join("out"));
    let robot = slow_robot(home.path(), 0.1);
    recorded(&model, &robot, &recording, &["--grid-map", "--speed-mask", "-o", out.to_str().unwrap()]);
    let counted = checked("check_grid_map.py", &["--self-test"], &recording, &out);
    assert!(counted["change_instants"].as_u64() > Some(2) && counted["storeys"] == 3, "{counted}");
    assert!(counted["sloped_cells"].as_u64() > Some(100_000), "{counted}");
    assert_eq!(counted["damages_noticed"], N_DAMAGES, "{counted}");
    let topics = checked("check_recording.py", &[], &recording, &out);
    assert!(topics["limited_cells"].as_u64() > Some(100), "{topics}");
    assert_eq!(topics["topics"].as_object().unwrap().len(), 3 * 11 + 1, "{topics}");

    // Without the options nothing of them is there.
    recorded(&model, &robot, &recording, &[]);
    let topics = checked("check_recording.py", &[], &recording, &out);
    assert_eq!(topics["topics"].as_object().unwrap().len(), 3 * 7 + 1, "{topics}");
}

#[test]
fn what_is_recorded_needs_a_recording() {
    let home = tempfile::tempdir().unwrap();
    let out = home.path().join("out");
    for option in ["--grid-map", "--speed-mask"] {
        let output = groundplan(&[&"convert", &demo_model(), &"-o", &out, &option]);
        let text = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.code() == Some(2) && text.contains("give --mcap"), "{text}");
    }
    assert!(files_in(home.path()).is_empty());
}

/// The recording of a running site up to the maps of a plan time, which is set meanwhile.
fn recorded_live(live: &Live, recording: &Path, plan_time: &str) {
    let mut record = Command::new(client());
    record.arg("record").arg(recording).args(["--grid-map", "--speed-mask", "--config"]).arg(live.config());
    let mut record = record.stderr(Stdio::piped()).stdout(Stdio::null()).spawn().unwrap();
    let mut lines = BufReader::new(record.stderr.take().unwrap()).lines();
    assert!(lines.next().unwrap().unwrap().contains("recorded the maps"));
    live.text(&[&"date", &plan_time]);
    assert!(lines.any(|line| line.unwrap().contains(plan_time)));
    assert!(Command::new("kill").args(["-INT", &record.id().to_string()]).status().unwrap().success());
    assert!(record.wait().unwrap().success());
}

/// sha256 of the limits of speed of a storey as Nav2's map server publishes the exported file, and how many cells have one.
fn speed_limits(folder: &Path) -> (String, usize) {
    let (width, _, pixels) = grid::decode_pgm(&std::fs::read(folder.join("speed.pgm")).unwrap()).unwrap();
    let steps = |pixel: &u8| (f64::from(255 - pixel) / 2.55).round() as u8;
    let cells: Vec<u8> = pixels.chunks(width).flatten().map(steps).collect();
    let n_limited = cells.iter().filter(|steps| **steps > 0).count();
    (Sha256::digest(cells).iter().map(|byte| format!("{byte:02x}")).collect(), n_limited)
}

#[test]
fn nodes_viewers_recordings_and_python_have_the_heights_of_the_files_also_after_the_date_has_changed() {
    if !(has(&READERS) && has(&PEERS)) {
        return;
    }
    let profiles = tempfile::tempdir().unwrap();
    let domain = domain();
    let mut live = Live::of(
        &demo_model(),
        &format!(
            "[schedule]\nplan_time = \"2024-03-01\"\n[robot]\nprofile = {:?}\n[ros]\nenabled = true\n\
             domain_id = {domain}\ngrid_map = true\nspeed_mask = true\n[ros.foxglove]\naddress = \"127.0.0.1:0\"\n",
            slow_robot(profiles.path(), 0.1)
        ),
    );
    let mut node = join(domain, &[]);
    let mut viewer = connect(served(&live), &[]);
    node.wait_until("heights", |last| last.contains_key("/groundplan/grid_map"));
    viewer.wait_until("heights", |last| last.contains_key("/groundplan/elevation"));
    let before = node.last["/groundplan/grid_map"]["sha256"].clone();
    assert_eq!(viewer.last["/groundplan/elevation"]["sha256"], before);

    let (recording, out) = (live.home.path().join("day.mcap"), live.home.path().join("out"));
    recorded_live(&live, &recording, "2024-06-30T00:00:00");
    live.text(&[&"export", &out]);
    let counted = checked("check_grid_map.py", &[], &recording, &out);
    let manifest: Value = serde_json::from_slice(&std::fs::read(out.join("manifest.json")).unwrap()).unwrap();
    let directory = manifest["storeys"][0]["directory"].as_str().unwrap();
    let storey = directory.strip_prefix("storeys/").unwrap().replace('-', "_");
    let expected = counted["sha256"][format!("/groundplan/storey_{storey}/grid_map")].clone();
    assert!(expected.is_string() && expected != before, "{counted}");
    assert!(checked("check_recording.py", &[], &recording, &out)["limited_cells"].as_u64() > Some(100));

    let (limits, n_limited) = speed_limits(&out.join(directory));
    assert!(n_limited > 100, "{n_limited}");
    let has_both = |last: &std::collections::BTreeMap<String, Value>, heights: &str| {
        let sum = |topic: &str| last.get(topic).map(|message| &message["sha256"]);
        sum(heights) == Some(&expected) && sum("/groundplan/speed_mask") == Some(&limits.as_str().into())
    };
    node.wait_until("the next heights", |last| has_both(last, "/groundplan/grid_map"));
    viewer.wait_until("the next heights", |last| has_both(last, "/groundplan/elevation"));
    let message = &node.last["/groundplan/grid_map"];
    assert_eq!((&message["frame"], &message["resolution_m"]), (&"site_map".into(), &0.05.into()), "{message}");
    for info in [&node.last["/groundplan/speed_info"], &viewer.last["/groundplan/speed_info"]] {
        assert_eq!((&info["mask"], &info["type"]), (&"/groundplan/speed_mask".into(), &2.into()), "{info}");
    }
    // Who comes later gets the newest, also from a bridge that was killed.
    live.kill("ros-bridge");
    join(domain, &[]).wait_until("the same heights", |last| has_both(last, "/groundplan/grid_map"));
    // A viewer ends with its server.
    let mut viewer = connect(served(&live), &[]);
    viewer.wait_until("the same heights", |last| has_both(last, "/groundplan/elevation"));

    let mut python = Command::new(root().join("target/venv/bin/python"));
    python.env("PYTHONPATH", root().join("common/python/src")).args(["-c", PYTHON]);
    let output = python.arg(live.root.path()).arg(&live.prefix).arg(&out).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert_eq!(String::from_utf8(output.stdout).unwrap().trim(), "1 3", "storeys that are level, and that are not");

    // The map of a robot that takes somewhat steeper ground is the same, and it drives better on it.
    let map = node.last["/groundplan/map"]["sha256"].clone();
    live.text(&[&"robot", &slow_robot(profiles.path(), 0.11)]);
    node.wait_until("heights for another robot", |last| last["/groundplan/grid_map"]["sha256"] != expected);
    assert_eq!(node.last["/groundplan/map"]["sha256"], map);
    let expected = node.last["/groundplan/grid_map"]["sha256"].clone();
    viewer.wait_until("heights for another robot", |last| last["/groundplan/elevation"]["sha256"] == expected);
    live.down();
}
