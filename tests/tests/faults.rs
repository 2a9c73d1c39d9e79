//! Fault injection: killed, hung, full and damaged processes; no partial map is visible, the set recovers, nothing is left
//! behind.
//!
//! One fault of each kind runs with all tests; `scripts/test --long` runs the whole matrix.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

use bus::{Bus, Daemon, Domain, GridSlot, RawSample, RawSubscriber, Stamp, TopicName, Waiter, topics};
use end_to_end::live::{DEADLINE, Live};
use end_to_end::{announce, contents, groundplan};
use messages::{Grid, Grids, ScheduleState};
use site_view::ConsistentSet;
use std::collections::BTreeMap;
use std::path::Path;
use std::process::Command;
use std::time::{Duration, Instant};

/// Dates between which the maps of the demo building differ.
const DATES: [&str; 4] = ["2024-04-06T12:00:00", "2024-04-27T12:00:00", "2024-05-20T12:00:00", "2024-06-03T12:00:00"];

const DAEMONS: [&str; 5] = ["ifc-ingest", "schedule-eval", "rasterize", "waypoint-gen", "slam-align"];

/// A subscriber that believes nothing: it checks every set that comes together.
struct Witness {
    bus: Bus,
    waiter: Waiter,
    subscribers: Vec<RawSubscriber>,
    set: ConsistentSet<RawSample>,
    last_epochs: BTreeMap<TopicName, u64>,
    sets_seen: usize,
    last_index: messages::ContentHash,
}

impl Witness {
    fn join(live: &Live) -> Self {
        let domain = Domain::shared(&live.prefix, live.root.path()).unwrap();
        let begun = Instant::now();
        let (bus, waiter) = loop {
            match Bus::join(&domain, Daemon::Groundplan) {
                Ok(joined) => break joined,
                Err(why) => assert!(begun.elapsed() < DEADLINE, "{why}"),
            }
        };
        let slots = GridSlot::all().map(TopicName::Grid);
        let names = [TopicName::ScheduleState, TopicName::Grids].into_iter().chain(slots);
        let subscribers = names.map(|topic| bus.raw_subscriber(topic).unwrap()).collect();
        let set = ConsistentSet::new(Stamp::now());
        Self {
            bus,
            waiter,
            subscribers,
            set,
            last_epochs: BTreeMap::new(),
            sets_seen: 0,
            last_index: messages::ContentHash::NONE,
        }
    }

    /// Takes what is there, and checks it: whole archives, epochs that do not fall, sets of one schedule state.
    fn look(&mut self) {
        for subscriber in &self.subscribers {
            let Some(sample) = subscriber.take().unwrap() else { continue };
            let topic = sample.topic();
            let epoch = sample.header().epoch;
            let last = self.last_epochs.insert(topic, epoch).unwrap_or(0);
            assert!(last <= epoch, "epochs of {topic} fall from {last} to {epoch}");
            // Opening computes the hash of the content again.
            match topic {
                TopicName::ScheduleState => drop(ScheduleState::open(sample.bytes()).unwrap()),
                TopicName::Grids => drop(Grids::open(sample.bytes()).unwrap()),
                _ => drop(Grid::open(sample.bytes()).unwrap()),
            }
            self.set.insert(Stamp::now(), sample).unwrap();
        }
        let (Some(schedule_state), Some(index)) = (self.set.schedule_state(), self.set.index()) else { return };
        if index.header().content_hash == self.last_index {
            return;
        }
        self.last_index = index.header().content_hash;
        self.sets_seen += 1;
        let named = Grids::open(index.bytes()).unwrap();
        assert_eq!(named.head.schedule_state_hash, schedule_state.header().content_hash);
        for (slot, record) in GridSlot::all().zip(named.slots) {
            let grid = self.set.grid(slot).expect("a set is complete");
            assert_eq!(Grid::open(grid.bytes()).unwrap().content_hash(), record.content_hash, "a half map was seen");
        }
    }

    fn look_for(&mut self, time: Duration) {
        let ends = Instant::now() + time;
        while Instant::now() < ends {
            self.look();
            let wake = self.waiter.wait(Duration::from_millis(20)).unwrap();
            assert!(!wake.superseded, "generation {} is over", self.bus.generation());
        }
        self.look();
    }

    /// Looks until a whole set was seen since the witness joined: what is published is latched, so there is one to come.
    fn look_for_a_set(&mut self) {
        let begun = Instant::now();
        while self.sets_seen == 0 {
            assert!(begun.elapsed() < DEADLINE, "no set of grids belongs together");
            self.look_for(Duration::from_millis(20));
        }
    }
}

fn process_of(live: &Live, daemon: &str) -> u64 {
    let begun = Instant::now();
    loop {
        let process = live.status().and_then(|s| s["daemons"][daemon]["process_id"].as_u64()).unwrap_or(0);
        if process > 1 {
            return process;
        }
        assert!(begun.elapsed() < DEADLINE, "{daemon} is silent");
    }
}

fn signal(signal: &str, process: u64) {
    assert!(process > 1);
    // It may be gone at this moment, and that is as good.
    let _ = Command::new("kill").args([signal, &process.to_string()]).status().unwrap();
}

/// The process that keeps the bus: a child of `up` with that word on its command line.
fn keeper_of(live: &Live) -> u64 {
    let up = live.up.as_ref().unwrap().id().to_string();
    let found = Command::new("pgrep").args(["-P", &up, "-f", "groundplan keeper"]).output().unwrap();
    String::from_utf8(found.stdout).unwrap().trim().parse().unwrap()
}

/// The set is well again, and its files are those of a conversion at the date.
fn check_recovered(live: &Live, date: &str) {
    live.wait_until_healthy();
    live.text(&[&"date", &date]);
    let (exported, converted) = (live.home.path().join("exported"), live.home.path().join("converted"));
    live.text(&[&"export", &exported]);
    let model = live.home.path().join("demo.ifc");
    assert!(groundplan(&[&"convert", &model, &"-o", &converted, &"--date", &date]).status.success());
    assert!(contents(&exported) == contents(&converted), "the maps are not those of {date}");
}

fn end(mut live: Live) {
    live.down();
    assert_eq!(live.segments(), 0, "nothing is left in shared memory");
}

/// Kills a process while dates and loads go through the set, `delay` after one of them began.
fn kill_at_work(live: &Live, victim: &str, work: &[&str], delay: Duration) {
    let process = if victim == "keeper" { keeper_of(live) } else { process_of(live, victim) };
    let config = live.config();
    let client = end_to_end::client();
    let mut asked = Command::new(client);
    asked.args(work).arg("--no-wait").arg("--config").arg(config);
    let mut asked = asked.stdout(std::process::Stdio::null()).stderr(std::process::Stdio::null()).spawn().unwrap();
    // Not a wait for something to happen: the moments of death are meant to differ.
    std::thread::sleep(delay);
    signal("-9", process);
    let _ = asked.wait();
}

#[test]
fn a_keeper_and_a_daemon_that_die_at_work_leave_no_half_map_and_no_trace() {
    let live = Live::start();
    live.text(&[&"date", &DATES[0]]);
    let mut witness = Witness::join(&live);
    kill_at_work(&live, "rasterize", &["date", DATES[1]], Duration::from_millis(15));
    witness.look_for(Duration::from_millis(500));
    kill_at_work(&live, "keeper", &["date", DATES[2]], Duration::from_millis(15));
    drop(witness);
    live.wait_until_healthy();
    let mut witness = Witness::join(&live);
    check_recovered(&live, DATES[3]);
    witness.look_for_a_set();
    drop(witness);
    end(live);
}

/// Every daemon and the keeper, at many moments of a load and of a date change.
#[test]
#[ignore = "minutes: scripts/test --long"]
fn every_process_may_die_at_every_moment_of_a_load_and_a_date_change() {
    let live = Live::start();
    live.text(&[&"date", &DATES[0]]);
    for (round, delay_ms) in [0u64, 5, 15, 40, 90, 180, 350].into_iter().enumerate() {
        for victim in DAEMONS.into_iter().chain(["keeper"]) {
            for work in [vec!["load"], vec!["date", DATES[round % 4]]] {
                kill_at_work(&live, victim, &work, Duration::from_millis(delay_ms));
                live.wait_until_healthy();
                eprintln!("{victim} died {delay_ms} ms after {work:?}");
                Witness::join(&live).look_for_a_set();
            }
        }
        check_recovered(&live, DATES[round % 4]);
    }
    end(live);
}

#[test]
fn when_all_die_at_once_the_next_start_finds_date_and_maps() {
    let mut live = Live::start();
    live.text(&[&"date", &DATES[1]]);
    let epoch = live.index()["epoch"].as_u64().unwrap();
    let processes: Vec<u64> = DAEMONS.iter().map(|d| process_of(&live, d)).chain([keeper_of(&live)]).collect();
    let mut up = live.up.take().unwrap();
    signal("-9", u64::from(up.id()));
    processes.into_iter().for_each(|p| signal("-9", p));
    up.wait().unwrap();
    assert!(live.segments() > 0, "a crash leaves something behind");
    live.up();
    assert_eq!(live.index()["content"]["plan_time"], DATES[1]);
    assert!(epoch <= live.index()["epoch"].as_u64().unwrap(), "epochs never fall");
    check_recovered(&live, DATES[2]);
    end(live);
}

#[test]
fn two_clients_at_once_are_both_answered_and_one_wins() {
    let live = Live::start();
    let config = live.config();
    for _ in 0..5 {
        let ask = |date: &str| {
            let mut command = Command::new(end_to_end::client());
            command.args(["date", date, "--no-wait", "--config"]).arg(&config).spawn().unwrap()
        };
        let mut asked = [ask(DATES[0]), ask(DATES[1]), ask(DATES[2])];
        assert!(asked.iter_mut().all(|a| a.wait().unwrap().success()));
        let now = live.text(&[&"date"]);
        let now = now.split_whitespace().next().unwrap();
        assert!(DATES[..3].contains(&now), "{now}");
        let begun = Instant::now();
        while live.index()["content"]["plan_time"] != now {
            assert!(begun.elapsed() < DEADLINE, "{}", live.index());
        }
    }
    end(live);
}

#[test]
fn a_subscriber_that_hangs_with_a_sample_in_hand_holds_nobody_up() {
    let live = Live::start();
    let client = end_to_end::client();
    let mut follower = Command::new(client);
    follower.args(["monitor", "--json", "--config"]).arg(live.config());
    let mut follower = follower.stdout(std::process::Stdio::null()).spawn().unwrap();
    // It has joined when it has printed a line; here the time of a few dates is enough.
    live.text(&[&"date", &DATES[0]]);
    live.text(&[&"date", &DATES[1]]);
    signal("-STOP", u64::from(follower.id()));
    for round in 0..6 {
        live.text(&[&"date", &DATES[round % 4]]);
    }
    assert_eq!(live.status().unwrap()["healthy"], true);
    signal("-CONT", u64::from(follower.id()));
    follower.kill().unwrap();
    follower.wait().unwrap();
    check_recovered(&live, DATES[3]);
    end(live);
}

#[test]
fn a_damaged_cache_is_reported_and_everything_is_read_anew() {
    let mut live = Live::start();
    live.down();
    let cache = live.home.path().join("state/site.gpar");
    let whole = std::fs::read(&cache).unwrap();
    let middle = whole.len() / 2;
    let flipped: Vec<u8> = whole.iter().enumerate().map(|(k, b)| if k == middle { b ^ 1 } else { *b }).collect();
    let mut other_version = whole.clone();
    other_version[4] ^= 0x55;
    for damaged in [flipped, whole[..middle].to_vec(), other_version, Vec::new()] {
        std::fs::write(&cache, damaged).unwrap();
        live.up();
        live.down();
        assert!(std::fs::read(&cache).unwrap() == whole, "the cache is whole again");
    }
}

/// A private /dev/shm of 48 MB that is filled up.
#[test]
fn full_shared_memory_is_reported_and_the_last_map_stays() {
    let inside = std::env::var_os("GROUNDPLAN_TEST_INSIDE").is_some();
    if !inside {
        // The same test again, where /dev/shm is another.
        let own = std::env::current_exe().unwrap();
        let script = "mount -t tmpfs -o size=128m tmpfs /dev/shm && exec \"$0\" --exact --nocapture \
                      full_shared_memory_is_reported_and_the_last_map_stays";
        let mut command = Command::new("unshare");
        command.args(["-m", "sh", "-c", script]).arg(own).env("GROUNDPLAN_TEST_INSIDE", "1");
        let Ok(output) = command.output() else {
            announce("SKIPPED: there is no unshare");
            return;
        };
        let output_text = String::from_utf8_lossy(&output.stderr);
        if output_text.contains("Operation not permitted") || output_text.contains("permission denied") {
            announce(&format!("SKIPPED: a private /dev/shm cannot be mounted: {output_text}"));
            return;
        }
        assert!(output.status.success(), "{output_text}{}", String::from_utf8_lossy(&output.stdout));
        return;
    }
    let live = Live::start();
    live.text(&[&"date", &DATES[0]]);
    let before = live.index();
    let processes = DAEMONS.map(|d| process_of(&live, d));
    let domain = Domain::shared(&live.prefix, live.root.path()).unwrap();
    let (bus, mut waiter) = Bus::join(&domain, Daemon::Groundplan).unwrap();
    let heartbeats = bus.status_reader().unwrap();
    let indices = bus.subscriber(topics::Grids).unwrap();
    let begun = Instant::now();
    while indices.take().unwrap().is_none() {
        assert!(begun.elapsed() < DEADLINE);
        waiter.wait(Duration::from_millis(100)).unwrap();
    }
    // What is left is enough for heartbeats and commands, and not for grids of four times as many cells: 12 MB are not, 14 are. What
    // the maps before these held is given back first.
    let filler = Path::new("/dev/shm/filler");
    let free_bytes = shared_memory_at_rest();
    std::fs::write(filler, vec![1u8; free_bytes - (9 << 20)]).unwrap();
    let config = std::fs::read_to_string(live.config()).unwrap();
    let configure = |text: &str| {
        std::fs::write(live.config(), text).unwrap();
        signal("-HUP", processes[2]);
    };
    let mut wait_for_error = |wanted: &dyn Fn(&str) -> bool| {
        let begun = Instant::now();
        loop {
            while let Some(record) = heartbeats.take().unwrap() {
                if Daemon::from_id(record.daemon) == Some(Daemon::Rasterize) && wanted(record.error()) {
                    return record.error().to_owned();
                }
            }
            assert!(begun.elapsed() < DEADLINE);
            waiter.wait(Duration::from_millis(100)).unwrap();
        }
    };
    configure(&format!("{config}[robot]\nresolution_m = 0.025\n"));
    let message = wait_for_error(&|error| !error.is_empty());
    assert!(message.contains("shared memory") || message.contains("no room"), "{message}");
    assert!(indices.take().unwrap().is_none(), "the last maps stay: {}", live.index());
    std::fs::remove_file(filler).unwrap();
    // Without a request it goes on by itself.
    wait_for_error(&str::is_empty);
    live.wait_until_healthy();
    assert_ne!(live.index()["content"]["grids"], before["content"]["grids"]);
    configure(&config);
    let begun = Instant::now();
    while live.index()["content"]["grids"] != before["content"]["grids"] {
        assert!(begun.elapsed() < DEADLINE, "{}", live.index());
    }
    assert_eq!(processes, DAEMONS.map(|d| process_of(&live, d)), "no daemon died of it");
    drop((heartbeats, indices, bus, waiter));
    check_recovered(&live, DATES[3]);
    end(live);
}

/// How many bytes of shared memory are free, once that has been the same for a second.
fn shared_memory_at_rest() -> usize {
    let free_bytes = || {
        let memory = rustix::fs::statvfs("/dev/shm").unwrap();
        usize::try_from(memory.f_bavail * memory.f_frsize).unwrap()
    };
    let begun = Instant::now();
    let (mut last, mut since) = (free_bytes(), Instant::now());
    while since.elapsed() < Duration::from_secs(1) {
        assert!(begun.elapsed() < DEADLINE, "shared memory does not come to rest");
        std::thread::sleep(Duration::from_millis(50));
        let now = free_bytes();
        if now != last {
            (last, since) = (now, Instant::now());
        }
    }
    last
}

/// Two hundred dates, and a witness that checks every set.
#[test]
#[ignore = "minutes: scripts/test --long"]
fn two_hundred_dates_show_no_half_map_and_end_where_a_fresh_start_begins() {
    let live = Live::start();
    let mut witness = Witness::join(&live);
    for round in 0..200 {
        let day = (round * 37) % 95;
        let date = noon_of(day);
        live.text(&[&"date", &date]);
        witness.look_for(Duration::from_millis(1));
    }
    assert!(witness.sets_seen > 50, "{}", witness.sets_seen);
    drop(witness);
    check_recovered(&live, DATES[1]);
    end(live);
}

/// Noon of a day in the spring of the demo's schedule.
fn noon_of(day: u32) -> String {
    let (month, day) = match day {
        0..31 => (3, day + 1),
        31..61 => (4, day - 30),
        61..92 => (5, day - 60),
        _ => (6, day - 91),
    };
    format!("2024-{month:02}-{day:02}T12:00:00")
}
