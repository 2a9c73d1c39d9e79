//! From a date on the bus to the map at a robot in ROS 2: how much later it comes than to a subscriber of the bus.
//!
//! `scripts/bench-ros` builds everything for release and runs this. The robot is a CycloneDDS participant on the same machine. The
//! large map is the ground floor of the demo building twelve times, in cells that make a message of almost 8 MB. Each is measured with
//! a reader as it comes, and with one that reads `config/cyclonedds.xml`.
#![expect(clippy::unwrap_used, reason = "a benchmark stops where it fails")]
#![expect(clippy::print_stdout, reason = "the table")]

use bus::{Bus, Daemon, Domain, Subscriber, Waiter, topics};
use daemon::{Answer, Client, ScheduleRequest};
use serde_json::Value;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

const DEADLINE: Duration = Duration::from_secs(600);
/// Dates between which the ground floor changes, in the schedule of the demo building.
const DATES: [&str; 2] = ["2024-04-06", "2024-06-30"];
const N_DATES: usize = 40;
const ROS_DOMAIN: u16 = 99;

fn main() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    let home = tempfile::tempdir().unwrap();
    let tiled = home.path().join("tiled.ifc");
    let mut tile = Command::new("python3");
    tile.arg(root.join("scripts/tile_model.py")).arg(root.join("config/demo/demo.ifc"));
    assert!(tile.arg(&tiled).args(["--levels", "1", "--days", "0"]).status().unwrap().success());
    println!("| map | bytes | reader | later than on the bus, median | 99th percentile |\n|---|---|---|---|---|");
    for reader in [Reader::AsItComes, Reader::Configured] {
        measure("demo building", &root.join("config/demo/demo.ifc"), 0.05, reader);
        measure("twelve of them", &tiled, 0.028, reader);
    }
}

/// How CycloneDDS is configured at the robot.
#[derive(Clone, Copy)]
enum Reader {
    AsItComes,
    /// By `config/cyclonedds.xml`.
    Configured,
}

/// Daemons with a bridge, on a bus of their own, and a participant that says when maps come.
struct Site {
    up: Child,
    peer: Child,
    maps: Receiver<(f64, u64)>,
    waiter: Waiter,
    dates: Client<ScheduleRequest>,
    indices: Subscriber<topics::Grids>,
}

fn measure(what: &str, model: &Path, resolution_m: f64, reader: Reader) {
    let home = tempfile::tempdir().unwrap();
    let bus_root = tempfile::Builder::new().prefix("gpros").tempdir_in("/dev/shm").unwrap();
    let prefix = format!("gr{:x}_", std::process::id());
    let config = home.path().join("site.toml");
    let text = format!(
        "state = \"state\"\nmodels = [{model:?}]\n[robot]\nresolution_m = {resolution_m}\n\
         [schedule]\nplan_time = {:?}\n[ros]\nenabled = true\ndomain_id = {ROS_DOMAIN}\nstorey = 0\n\
         [bus]\nprefix = {prefix:?}\nroot = {:?}\n",
        DATES[1],
        bus_root.path()
    );
    std::fs::write(&config, text).unwrap();
    let mut site = Site::start(&config, &Domain::shared(&prefix, bus_root.path()).unwrap(), reader);
    let (_, bytes) = site.map();
    let mut later_ms: Vec<f64> = (0..N_DATES).map(|k| site.later_ms(DATES[k % DATES.len()])).collect();
    later_ms.sort_by(f64::total_cmp);
    let at = |share: f64| later_ms[((later_ms.len() - 1) as f64 * share).round() as usize];
    let reader = match reader {
        Reader::AsItComes => "as it comes",
        Reader::Configured => "`config/cyclonedds.xml`",
    };
    println!("| {what} | {bytes} | {reader} | {:.1} ms | {:.1} ms |", at(0.5), at(0.99));
    site.end();
    // What this process was the last to hold, and the folder of the relay.
    for entry in std::fs::read_dir("/dev/shm").unwrap().map(Result::unwrap) {
        if entry.file_name().to_string_lossy().starts_with(&prefix) {
            std::fs::remove_file(entry.path()).unwrap();
        }
    }
    std::fs::remove_dir_all(format!("{}-relay", bus_root.path().display())).unwrap();
}

impl Site {
    fn start(config: &Path, domain: &Domain, reader: Reader) -> Self {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
        let client = std::env::current_exe().unwrap().parent().unwrap().parent().unwrap().join("groundplan");
        let up = Command::new(client).arg("up").arg("--config").arg(config).stderr(Stdio::null()).spawn().unwrap();
        let begun = Instant::now();
        let (bus, waiter) = loop {
            match Bus::join(domain, Daemon::Groundplan) {
                Ok(joined) => break joined,
                Err(_) if begun.elapsed() < DEADLINE => std::thread::sleep(Duration::from_millis(50)),
                Err(why) => panic!("{why}"),
            }
        };
        let mut peer = Command::new(root.join("target/venv/bin/python"));
        peer.arg(root.join("scripts/ros_peer.py")).args(["--raw", "--domain", &ROS_DOMAIN.to_string()]);
        match reader {
            Reader::AsItComes => peer.env_remove("CYCLONEDDS_URI"),
            Reader::Configured => {
                peer.env("CYCLONEDDS_URI", format!("file://{}", root.join("config/cyclonedds.xml").display()))
            }
        };
        let mut peer = peer.stdout(Stdio::piped()).spawn().unwrap();
        let (sender, maps) = channel();
        let lines = BufReader::new(peer.stdout.take().unwrap()).lines();
        std::thread::spawn(move || {
            for line in lines.map_while(Result::ok) {
                let message: Value = serde_json::from_str(&line).unwrap();
                if message["topic"] == "/groundplan/map" {
                    let map = (message["at_s"].as_f64().unwrap(), message["bytes"].as_u64().unwrap());
                    if sender.send(map).is_err() {
                        return;
                    }
                }
            }
        });
        let dates = Client::of(&bus).unwrap();
        Self { up, peer, maps, waiter, dates, indices: bus.subscriber(topics::Grids).unwrap() }
    }

    /// The next map at the robot: seconds since 1970, and bytes.
    fn map(&self) -> (f64, u64) {
        self.maps.recv_timeout(DEADLINE).unwrap()
    }

    /// Sets a date: how much later its map comes to the robot than its index to a subscriber of the bus.
    fn later_ms(&mut self, date: &str) -> f64 {
        // The robot is at rest, and what came of the date before has come.
        std::thread::sleep(Duration::from_millis(500));
        while self.maps.try_recv().is_ok() {}
        while self.indices.take().unwrap().is_some() {}
        let at: frames::PlanTime = date.parse().unwrap();
        let open = self.dates.send(&ScheduleRequest::SetPlanTime { at_s: at.civil_seconds() }).unwrap();
        let (mut state, mut on_bus_s) = (None, None);
        while state.is_none() || on_bus_s.is_none() {
            self.waiter.wait(Duration::from_secs(1)).unwrap();
            if let Ok(Some(Answer::Done(answer))) = open.take() {
                state = Some(answer.state);
            }
            if self.indices.take().unwrap().is_some() {
                on_bus_s = Some(SystemTime::now().duration_since(UNIX_EPOCH).unwrap().as_secs_f64());
            }
        }
        (self.map().0 - on_bus_s.unwrap()) * 1e3
    }

    fn end(mut self) {
        self.peer.kill().unwrap();
        self.peer.wait().unwrap();
        assert!(Command::new("kill").arg(self.up.id().to_string()).status().unwrap().success());
        self.up.wait().unwrap();
    }
}
