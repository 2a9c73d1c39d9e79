//! A site in use for long: thousands of date changes with subscribers that come, go, hold samples and die, revisions of the
//! model and other robots; what the processes hold at the end is what they held after the first hundred.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

use bus::{Bus, Daemon, Domain, Subscriber, Waiter, topics};
use daemon::{Answer, Client, ScheduleRequest};
use end_to_end::live::{DEADLINE, Live};
use end_to_end::{client, demo_model, root};
use site_view::SiteSetReader;
use std::collections::BTreeMap;
use std::os::unix::fs::MetadataExt;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// Date changes of a round; all that happens on the way begins and ends within it.
const DATES_PER_ROUND: u32 = 100;
/// Rounds of the short test, and of the long one: 20,000 dates.
const SHORT_ROUNDS: u32 = 2;
const LONG_ROUNDS: u32 = 200;
/// The model is revised, and the robot is another one for a while, in every tenth round.
const ROUNDS_PER_REVISION: u32 = 10;

/// What a process may hold more at the end than after the first round: memory that its allocator keeps, and that it does not
/// grow with the number of rounds.
const MORE_MEMORY: f64 = 0.15;
const MORE_MEMORY_BYTES: u64 = 8 << 20;

/// A day in the demo building's schedule, civil seconds since 1970: noon of the first of March 2024, and days after it.
fn noon_s(day: u32) -> i64 {
    1_709_294_400 + i64::from(day) * 86_400
}

/// The site and a client of it.
struct Site {
    live: Live,
    waiter: Waiter,
    dates: Client<ScheduleRequest>,
    indices: Subscriber<topics::Grids>,
    /// Schedule state of the newest index.
    newest: Option<messages::ContentHash>,
}

impl Site {
    fn start() -> Self {
        // Coarse cells: what is counted is what is left behind, not what is drawn.
        let more = "[schedule]\nplan_time = \"2024-03-01\"\n[robot]\nresolution_m = 0.2\n";
        let live = Live::of(&demo_model(), more);
        let (bus, waiter) = join(&live);
        let dates = Client::of(&bus).unwrap();
        let indices = bus.subscriber(topics::Grids).unwrap();
        Self { live, waiter, dates, indices, newest: None }
    }

    /// Sets the plan time, and waits for the index of its grids.
    fn set_date(&mut self, at_s: i64) {
        let open = self.dates.send(&ScheduleRequest::SetPlanTime { at_s }).unwrap();
        let begun = Instant::now();
        let state = loop {
            match open.take().unwrap() {
                Some(Answer::Done(answer)) => break answer.state,
                Some(Answer::Progress(_)) | None => self.wait(begun),
            }
        };
        while self.newest_index() != Some(state.content_hash) {
            self.wait(begun);
        }
    }

    /// The schedule state of the newest index.
    fn newest_index(&mut self) -> Option<messages::ContentHash> {
        let index = self.indices.take().unwrap();
        self.newest = index.map(|index| index.header().inputs.schedule_state).or(self.newest);
        self.newest
    }

    fn wait(&mut self, begun: Instant) {
        assert!(begun.elapsed() < DEADLINE, "{:?}", self.live.status());
        let wake = self.waiter.wait(Duration::from_millis(100)).unwrap();
        assert!(!wake.superseded, "the bus was created anew: a process of it died");
    }

    /// The other revision of the model, then the one of before.
    fn revise(&self) {
        let path = self.live.home.path().join("demo.ifc");
        let before = std::fs::read_to_string(&path).unwrap();
        let revised = before.replacen("Plant room", "Pump room", 1);
        assert_ne!(revised, before, "the demo building has a plant room");
        for text in [&revised, &before] {
            std::fs::write(&path, text).unwrap();
            self.live.text(&[&"load", &path]);
        }
    }

    /// Another robot, then the one of before.
    fn change_robot(&self) {
        for profile in ["legged.toml", "default.toml"] {
            self.live.text(&[&"robot", &root().join("config/robots").join(profile)]);
        }
    }
}

fn join(live: &Live) -> (Bus, Waiter) {
    Bus::join(&Domain::shared(&live.prefix, live.root.path()).unwrap(), Daemon::Groundplan).unwrap()
}

/// A subscriber in a process of its own, which can be killed.
struct Guest(Child);

impl Guest {
    fn start(live: &Live, arguments: &[&str]) -> Self {
        let mut command = Command::new(client());
        command.args(arguments).arg("--config").arg(live.config());
        Self(command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap())
    }

    fn signal(&self, signal: &str) {
        assert!(Command::new("kill").args([signal, &self.0.id().to_string()]).status().unwrap().success());
    }

    fn end(mut self, signal: &str) {
        self.signal(signal);
        self.0.wait().unwrap();
    }
}

/// A subscriber that holds samples of every topic while others come.
struct Holder {
    // Before the bus that it reads from.
    reader: SiteSetReader,
    _bus: (Bus, Waiter),
}

impl Holder {
    fn join(live: &Live) -> Self {
        let (bus, mut waiter) = join(live);
        let mut reader = SiteSetReader::of(&bus).unwrap();
        let begun = Instant::now();
        while reader.samples().index().is_none() {
            assert!(begun.elapsed() < DEADLINE, "no sample comes");
            waiter.wait(Duration::from_millis(20)).unwrap();
            reader.take().unwrap();
        }
        Self { reader, _bus: (bus, waiter) }
    }
}

/// A hundred dates, and what happens on the way.
fn round(site: &mut Site, number: u32, is_last: bool) {
    let (mut killed, mut follower, mut holder) = (None, None, None);
    for step in 0..DATES_PER_ROUND {
        match step {
            10 => killed = Some(Guest::start(&site.live, &["monitor", "--json"])),
            20 => follower = Some(Guest::start(&site.live, &["topic", "echo", "grids", "--follow"])),
            30 => holder = Some(Holder::join(&site.live)),
            // It hangs with samples in hand, and dies like that.
            50 => killed.iter().for_each(|guest| guest.signal("-STOP")),
            60 => killed.take().into_iter().for_each(|guest| guest.end("-KILL")),
            70 => follower.take().into_iter().for_each(|guest| guest.end("-TERM")),
            80 => {
                let held: Option<Holder> = holder.take();
                assert!(held.is_some_and(|held| held.reader.samples().index().is_some()));
            }
            _ => {}
        }
        site.set_date(noon_s((number * DATES_PER_ROUND + step) * 37 % 95));
    }
    // Also in the last one: a publisher lets go of what its last subscribers left when it publishes again.
    if number.is_multiple_of(ROUNDS_PER_REVISION) || is_last {
        site.revise();
        site.change_robot();
    }
    site.set_date(noon_s(60));
}

/// What a process holds.
#[derive(Debug, Clone, PartialEq)]
struct Usage {
    process_id: u32,
    resident_bytes: u64,
    descriptors: usize,
}

/// What a site holds.
#[derive(Debug, Clone)]
struct Holdings {
    /// `up` and its children, by name.
    processes: BTreeMap<String, Usage>,
    /// Shared memory of the bus: files, and bytes of them in memory.
    segments: usize,
    segment_bytes: u64,
    /// Files in the folder of the bus.
    root_files: usize,
}

impl Holdings {
    fn of(live: &Live) -> Self {
        let up = live.up.as_ref().unwrap().id();
        let mut processes = BTreeMap::from([("up".to_owned(), Usage::of(up))]);
        for entry in std::fs::read_dir("/proc").unwrap() {
            let Some(id) = entry.unwrap().file_name().to_str().and_then(|name| name.parse().ok()) else { continue };
            // A process may have ended meanwhile.
            let Ok(stat) = std::fs::read_to_string(format!("/proc/{id}/stat")) else { continue };
            let (name, rest) = stat.split_once('(').unwrap().1.rsplit_once(')').unwrap();
            if rest.split_whitespace().nth(1) == Some(&up.to_string()) {
                // Keeper and relay are the same program: the command tells them apart.
                let line = std::fs::read_to_string(format!("/proc/{id}/cmdline")).unwrap();
                let command = line.split('\0').nth(1).filter(|_| name == "groundplan").unwrap_or_default();
                processes.insert(format!("{name} {command}").trim_end().to_owned(), Usage::of(id));
            }
        }
        let segments: Vec<u64> = std::fs::read_dir("/dev/shm")
            .unwrap()
            .map(|entry| entry.unwrap())
            .filter(|entry| entry.file_name().to_string_lossy().starts_with(&live.prefix))
            .filter_map(|entry| Some(entry.metadata().ok()?.blocks() * 512))
            .collect();
        Self {
            processes,
            segments: segments.len(),
            segment_bytes: segments.iter().sum(),
            root_files: n_files(live.root.path()),
        }
    }

    /// What is more than before, in words; empty if nothing is.
    fn more_than(&self, before: &Self) -> Vec<String> {
        let mut more = Vec::new();
        let mut check = |what: String, before: u64, now: u64, allowed: u64| {
            if now > before + allowed {
                more.push(format!("{what}: {before} before, {now} now"));
            }
        };
        let memory = |bytes: u64| (bytes as f64 * MORE_MEMORY) as u64 + MORE_MEMORY_BYTES;
        for (name, now) in &self.processes {
            let Some(before) = before.processes.get(name) else { panic!("{name} was not there before") };
            assert_eq!(now.process_id, before.process_id, "{name} died");
            check(format!("descriptors of {name}"), before.descriptors as u64, now.descriptors as u64, 0);
            let allowed = memory(before.resident_bytes);
            check(format!("memory of {name} in bytes"), before.resident_bytes, now.resident_bytes, allowed);
        }
        check("segments".to_owned(), before.segments as u64, self.segments as u64, 0);
        check("files of the bus".to_owned(), before.root_files as u64, self.root_files as u64, 0);
        let allowed = memory(before.segment_bytes);
        check("shared memory in bytes".to_owned(), before.segment_bytes, self.segment_bytes, allowed);
        more
    }
}

impl Usage {
    fn of(process_id: u32) -> Self {
        let status = std::fs::read_to_string(format!("/proc/{process_id}/status")).unwrap();
        let resident = status.lines().find_map(|line| line.strip_prefix("VmRSS:")).unwrap();
        let kilobytes: u64 = resident.trim().trim_end_matches(" kB").parse().unwrap();
        let descriptors = std::fs::read_dir(format!("/proc/{process_id}/fd")).unwrap().count();
        Self { process_id, resident_bytes: kilobytes << 10, descriptors }
    }
}

/// Files below a folder; those that come and go are counted when they are seen.
fn n_files(folder: &Path) -> usize {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    entries.map(|entry| if entry.path().is_dir() { n_files(&entry.path()) } else { 1 }).sum()
}

/// Holdings when the site is at rest: what the dead left is cleared up within seconds, reports are replaced each second.
fn holdings_at_rest(site: &Site, before: Option<&Holdings>) -> Holdings {
    let begun = Instant::now();
    let mut last = Holdings::of(&site.live);
    loop {
        std::thread::sleep(Duration::from_secs(1));
        let now = Holdings::of(&site.live);
        let is_at_rest = (now.segments, now.root_files) == (last.segments, last.root_files);
        if is_at_rest && before.is_none_or(|before| now.more_than(before).is_empty()) {
            return now;
        }
        if begun.elapsed() > DEADLINE {
            return now;
        }
        last = now;
    }
}

fn soak(rounds: u32) {
    let mut site = Site::start();
    round(&mut site, 0, false);
    let before = holdings_at_rest(&site, None);
    let begun = Instant::now();
    for number in 1..rounds {
        round(&mut site, number, number + 1 == rounds);
        if number.is_multiple_of(ROUNDS_PER_REVISION) {
            let now = Holdings::of(&site.live);
            eprintln!("{} dates, {} s: {now:?}", (number + 1) * DATES_PER_ROUND, begun.elapsed().as_secs());
        }
    }
    let now = holdings_at_rest(&site, Some(&before));
    let more = now.more_than(&before);
    assert!(more.is_empty(), "after {} dates: {more:#?}\nbefore {before:#?}\nnow {now:#?}", rounds * DATES_PER_ROUND);
    let Site { mut live, waiter, dates, indices, .. } = site;
    drop((dates, indices, waiter));
    live.wait_until_healthy();
    live.down();
    assert_eq!(live.segments(), 0, "nothing is left in shared memory");
}

#[test]
fn two_hundred_dates_with_subscribers_that_die_leave_nothing_behind() {
    soak(SHORT_ROUNDS);
}

#[test]
#[ignore = "minutes: scripts/test --long"]
fn twenty_thousand_dates_leave_no_more_behind_than_a_hundred() {
    let rounds = std::env::var("GROUNDPLAN_SOAK_ROUNDS").map_or(LONG_ROUNDS, |rounds| rounds.parse().unwrap());
    soak(rounds);
}
