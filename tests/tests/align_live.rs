//! The robot's map and the running daemons.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

mod support;

use bus::{Bus, Daemon, Origin, Publisher, Topic, Waiter};
use daemon::SiteConfig;
use messages::{InputHashes, SlamMap, SlamMapHead};
use serde_json::Value;
use std::time::Instant;
use support::live::{DEADLINE, Live};
use support::{Maps, convert, demo_model, turned_map};

fn json(live: &Live, arguments: &[&dyn AsRef<std::ffi::OsStr>]) -> Value {
    serde_json::from_str(&live.text(arguments)).unwrap()
}

fn x_m(alignment: &Value) -> f64 {
    alignment["map_from_slam"]["x_m"].as_f64().unwrap()
}

#[test]
fn a_map_from_a_file_is_aligned_and_its_pose_survives_the_daemon() {
    let maps = convert(&demo_model(), &[]);
    let mut live = Live::of(&demo_model(), "");
    let none = live.run(&[&"align"]);
    assert!(!none.status.success() && String::from_utf8_lossy(&none.stderr).contains("slam-map"));
    let robot = turned_map(&maps, 0, live.home.path());
    let found = json(&live, &[&"slam-map", &robot, &"--json"]);
    assert_eq!((&found["verdict"], &found["storey"]), (&"accepted".into(), &0.into()), "{found}");
    let echo = json(&live, &[&"topic", &"echo", &"alignment", &"--json"]);
    assert_eq!(echo["content"]["map_from_slam"], found["map_from_slam"]);
    assert!(live.text(&[&"status"]).contains("SLAM map on storey 0"));
    live.kill("slam-align");
    let transform = live.home.path().join("site_map.yaml");
    let again = json(&live, &[&"align", &"--json", &"--transform", &transform]);
    assert!((x_m(&again) - x_m(&found)).abs() < 0.01, "{again}");
    assert!(std::fs::read_to_string(transform).unwrap().contains("child_frame_id: site_map"));
    let nothing = live.run(&[&"confirm"]);
    assert!(!nothing.status.success() && String::from_utf8_lossy(&nothing.stderr).contains("no pose waits"));
    let missing = live.home.path().join("missing.yaml");
    assert!(!live.run(&[&"slam-map", &missing]).status.success());
    assert!((x_m(&json(&live, &[&"align", &"--json"])) - x_m(&found)).abs() < 0.01, "the map before it stays");
    live.down();
}

/// A robot that publishes the planning map of a storey as its own.
struct Robot {
    publisher: Publisher,
    _bus: (Bus, Waiter),
    cells: Vec<i8>,
    size: [u32; 2],
    epoch: u64,
}

impl Robot {
    fn of(live: &Live, maps: &Maps) -> Self {
        let config = SiteConfig::read(&live.config()).unwrap();
        let (bus, waiter) = Bus::join(&config.bus.domain().unwrap(), Daemon::Robot).unwrap();
        let directory = maps.manifest["storeys"][0]["directory"].as_str().unwrap();
        let bytes = std::fs::read(maps.path().join(directory).join("planning.pgm")).unwrap();
        let (width, height, pixels) = grid::decode_pgm(&bytes).unwrap();
        let cells = pixels.into_iter().map(|p| match p {
            grid::FREE => 0,
            grid::OCCUPIED => 100,
            _ => -1,
        });
        let publisher = bus.publisher(Topic::SlamMap, 1 << 20).unwrap();
        let size = [width as u32, height as u32];
        Self { publisher, _bus: (bus, waiter), cells: cells.collect(), size, epoch: 0 }
    }

    fn publish(&mut self, x_m: f64) {
        let [width, height] = self.size;
        let head = SlamMapHead { resolution_m: 0.05, origin: [x_m, 1.0, 0.0], width, height };
        self.epoch += 1;
        let origin = Origin { epoch: self.epoch, frame_epoch: 0, inputs: InputHashes::default() };
        self.publisher.publish_copy(SlamMap::write(&head, &self.cells).bytes(), origin).unwrap();
    }
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
    let mut robot = Robot::of(&live, &maps);
    robot.publish(2.0);
    let first = wait_for(&live, |a| a["state"] == "found" || a["state"] == "tracked");
    assert_eq!(first["verdict"], "accepted");
    robot.publish(2.06);
    let followed = wait_for(&live, |a| !a["map_from_slam"].is_null() && (x_m(a) - x_m(&first) + 0.06).abs() < 0.01);
    assert!(followed["waiting"].is_null());
    robot.publish(2.30);
    let held = wait_for(&live, |a| !a["waiting"].is_null());
    assert_eq!((&held["state"], x_m(&held)), (&"held".into(), x_m(&followed)), "the pose stays");
    assert!((x_m(&held["waiting"]) - x_m(&followed) + 0.24).abs() < 0.01, "{held}");
    assert!(live.text(&[&"status"]).contains("another pose waits"));
    let confirmed = json(&live, &[&"confirm", &"--json"]);
    assert!((x_m(&confirmed) - x_m(&held["waiting"])).abs() < 0.001 && confirmed["waiting"].is_null(), "{confirmed}");
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
