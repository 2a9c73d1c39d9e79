//! Latency and memory of the running daemons, one table per run.
//!
//! `scripts/bench-live` builds everything for release and runs this. The site is the demo building 60 times, on 10 storeys, each
//! copy a day later than the one before; another model may be given as an argument. Times are of this machine and this
//! moment: what counts are the ratios in a row.
#![expect(clippy::unwrap_used, reason = "a benchmark stops where it fails")]
#![expect(clippy::print_stdout, reason = "the table")]

use bus::{Bus, Daemon, Domain, GridSlot, Keeper, Origin, Sample, Stamp, Subscriber, Topic, TopicName, Waiter, topics};
use daemon::{Answer, Client, ScheduleRequest, SiteConfig, SiteProcess, StatusBoard};
use messages::{ArchiveBuffer, ContentHash, Grids, InputHashes, ScheduleState, Site};
use serde::de::IgnoredAny;
use std::collections::BTreeMap;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

const DEADLINE: Duration = Duration::from_secs(600);
const IDLE: Duration = Duration::from_secs(20);

fn main() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    let home = tempfile::tempdir().unwrap();
    // Arguments of `cargo bench` itself begin with a dash.
    let model = std::env::args().skip(1).find(|a| !a.starts_with('-')).map_or_else(
        || {
            let model = home.path().join("tiled.ifc");
            let tile = Command::new("python3")
                .args([root.join("scripts/tile_model.py"), root.join("config/demo/demo.ifc"), model.clone()])
                .status();
            assert!(tile.unwrap().success());
            model
        },
        PathBuf::from,
    );
    println!("| what | measured |\n|---|---|");
    let mut live = Live::start(home.path(), &model);
    live.describe();
    dates(&mut live);
    live.late_joiners();
    live.commands();
    live.restart();
    live.memory();
    live.idle();
    drop(live);
    payloads();
}

fn row(what: &str, measured: impl std::fmt::Display) {
    println!("| {what} | {measured} |");
}

/// Middle and 99th percentile.
fn percentiles(values: &mut [f64]) -> [f64; 2] {
    values.sort_by(f64::total_cmp);
    [0.5, 0.99].map(|p| values[((values.len() - 1) as f64 * p).round() as usize])
}

fn ms(time: Duration) -> f64 {
    time.as_secs_f64() * 1e3
}

/// Daemons on a bus of their own.
struct Live {
    up: Child,
    prefix: String,
    /// Folder of the bus; goes with this value.
    root: tempfile::TempDir,
    config: PathBuf,
    domain: Domain,
    bus: Bus,
    waiter: Waiter,
}

impl Live {
    fn start(home: &Path, model: &Path) -> Self {
        let root = tempfile::Builder::new().prefix("gpbench").tempdir_in("/dev/shm").unwrap();
        let prefix = format!("gb{:x}_", std::process::id());
        let model = std::path::absolute(model).unwrap();
        let site = format!(
            "state = \"state\"\nmodels = [{model:?}]\n[schedule]\nplan_time = \"2000-01-01\"\n[bus]\nprefix = {prefix:?}\nroot = {:?}\n",
            root.path()
        );
        let config = home.join("site.toml");
        std::fs::write(&config, site).unwrap();
        let up = Command::new(client()).arg("up").arg("--config").arg(&config).stderr(Stdio::null()).spawn().unwrap();
        let domain = Domain::shared(&prefix, root.path()).unwrap();
        let begun = Instant::now();
        let (bus, waiter) = loop {
            match Bus::join(&domain, Daemon::Groundplan) {
                Ok(joined) => break joined,
                Err(_) if begun.elapsed() < DEADLINE => std::thread::sleep(Duration::from_millis(50)),
                Err(why) => panic!("{why}"),
            }
        };
        Self { up, prefix, root, config, domain, bus, waiter }
    }

    fn next<T: Topic>(&mut self, subscriber: &Subscriber<T>) -> Sample<T> {
        let deadline = Instant::now() + DEADLINE;
        loop {
            if let Some(sample) = subscriber.take().unwrap() {
                return sample;
            }
            assert!(Instant::now() < deadline, "nothing comes on {}", subscriber.topic().name());
            self.waiter.wait(Duration::from_secs(1)).unwrap();
        }
    }

    fn describe(&mut self) {
        let sites = self.bus.subscriber(topics::Site).unwrap();
        let indices = self.bus.subscriber(topics::Grids).unwrap();
        let site = self.next(&sites);
        let index = self.next(&indices);
        let view = Site::open(site.bytes()).unwrap();
        let mut cells = 0;
        for k in 0..Grids::open(index.bytes()).unwrap().slots.len() {
            let slot = self.bus.subscriber(topics::Grid(GridSlot::new(k).unwrap())).unwrap();
            cells += self.next(&slot).header().payload_length as usize / 7;
        }
        let (elements, storeys) = (view.elements.len(), view.map_storeys.len());
        row("site", format!("{elements} elements, {storeys} storeys, {cells} cells, {} bytes", site.bytes().len()));
    }

    /// The processes of the daemons, by name.
    fn processes(&self) -> BTreeMap<String, u32> {
        let board = StatusBoard::of(self.root.path());
        let process =
            |process: SiteProcess| Some((process.to_string(), board.report::<IgnoredAny>(process)?.process_id));
        let config = SiteConfig::read(&self.config).unwrap();
        let begun = Instant::now();
        loop {
            let found: BTreeMap<_, _> = SiteProcess::supervised(&config).filter_map(process).collect();
            if found.len() == SiteProcess::supervised(&config).count() {
                return found;
            }
            assert!(begun.elapsed() < DEADLINE, "{found:?}");
        }
    }

    /// Commands of the client as a user waits for them, from the start of the process to its end.
    fn commands(&self) {
        for (what, arguments) in [("status", &["status", "--json"][..]), ("metrics", &["metrics"]), ("date", &["date"])]
        {
            let run = |_| {
                let begun = Instant::now();
                let output = Command::new(client()).args(arguments).arg("--config").arg(&self.config).output().unwrap();
                assert!(!output.stdout.is_empty(), "{what}");
                ms(begun.elapsed())
            };
            let [p50, p99] = percentiles(&mut (0..50).map(run).collect::<Vec<_>>());
            row(&format!("`groundplan {what}`, the whole process"), format!("p50 {p50:.1} ms, p99 {p99:.1} ms"));
        }
    }

    fn late_joiners(&mut self) {
        let join = |_| {
            let begun = Instant::now();
            let (bus, mut waiter) = Bus::join(&self.domain, Daemon::Groundplan).unwrap();
            for topic in [TopicName::Site, TopicName::Grids, TopicName::Grid(GridSlot::new(0).unwrap())] {
                let subscriber = bus.raw_subscriber(topic).unwrap();
                while subscriber.take().unwrap().is_none() {
                    waiter.wait(Duration::from_secs(1)).unwrap();
                }
            }
            ms(begun.elapsed())
        };
        let [p50, p99] = percentiles(&mut (0..50).map(join).collect::<Vec<_>>());
        row("late joiner: from joining to site, index and a grid", format!("p50 {p50:.1} ms, p99 {p99:.1} ms"));
    }

    fn restart(&mut self) {
        let sites = self.bus.subscriber(topics::Site).unwrap();
        let length = self.next(&sites).bytes().len();
        let process = self.processes()["ifc-ingest"];
        let begun = Instant::now();
        assert!(Command::new("kill").args(["-9", &process.to_string()]).status().unwrap().success());
        self.next(&sites);
        let seen = ms(begun.elapsed());
        row(
            "ifc-ingest killed, until its site is there again",
            format!("{seen:.0} ms for {:.0} MB, of which about 250 ms back-off", length as f64 / 1e6),
        );
        // Its first report comes after the site.
        while self.processes()["ifc-ingest"] == process {
            assert!(begun.elapsed() < DEADLINE, "no report of the new process");
            std::thread::sleep(Duration::from_millis(10));
        }
    }

    fn memory(&mut self) {
        let processes = self.processes();
        let anonymous = |process: &u32| -> u64 {
            let status = std::fs::read_to_string(format!("/proc/{process}/status")).unwrap();
            let line = status.lines().find(|l| l.starts_with("RssAnon")).unwrap();
            line.split_whitespace().nth(1).unwrap().parse::<u64>().unwrap() * 1_024
        };
        let own: Vec<String> =
            processes.iter().map(|(name, process)| format!("{name} {:.0}", anonymous(process) as f64 / 1e6)).collect();
        let shared: u64 = std::fs::read_dir("/dev/shm")
            .unwrap()
            .flatten()
            .filter(|e| e.file_name().to_string_lossy().starts_with(&self.prefix))
            .map(|e| e.metadata().unwrap().blocks() * 512)
            .sum();
        row("memory, MB", format!("shared {:.0}, own: {}", shared as f64 / 1e6, own.join(", ")));
    }

    /// Until the waypoints are those of the newest grids.
    fn wait_for_mission_plan(&mut self) {
        let mission_plans = self.bus.subscriber(topics::MissionPlan).unwrap();
        let indices = self.bus.subscriber(topics::Grids).unwrap();
        let index = self.next(&indices).header().content_hash;
        while self.next(&mission_plans).header().inputs.grids != index {}
    }

    fn idle(&mut self) {
        let ticks = |process: u32| -> f64 {
            let stat = std::fs::read_to_string(format!("/proc/{process}/stat")).unwrap();
            let fields: Vec<&str> = stat.rsplit(')').next().unwrap().split_whitespace().collect();
            // Hundredths of a second, user and system.
            (fields[11].parse::<f64>().unwrap() + fields[12].parse::<f64>().unwrap()) / 100.0
        };
        self.wait_for_mission_plan();
        let processes = self.processes();
        let before: Vec<f64> = processes.values().map(|p| ticks(*p)).collect();
        std::thread::sleep(IDLE);
        let used = processes.iter().zip(before).map(|((name, process), before)| {
            format!("{name} {:.2} %", (ticks(*process) - before) / IDLE.as_secs_f64() * 100.0)
        });
        row("idle, of one core", used.collect::<Vec<_>>().join(", "));
    }
}

/// The client of this build.
fn client() -> PathBuf {
    std::env::current_exe().unwrap().parent().unwrap().parent().unwrap().join("groundplan")
}

impl Drop for Live {
    fn drop(&mut self) {
        let _ = Command::new("kill").arg(self.up.id().to_string()).status();
        let _ = self.up.wait();
        remove_segments(&self.prefix);
    }
}

/// This program is on the bus until its end, so the keeper leaves what it uses.
fn remove_segments(prefix: &str) {
    for entry in std::fs::read_dir("/dev/shm").unwrap().flatten() {
        if entry.file_name().to_string_lossy().starts_with(prefix) {
            let _ = std::fs::remove_file(entry.path());
        }
    }
}

/// Dates that are told one by one.
const N_DEAREST: usize = 5;

/// A date that was set, and what came of it.
struct Step {
    total_ms: f64,
    /// Until the schedule state is out, from there until the index is, from there until it is seen.
    parts_ms: [f64; 3],
    memcpy_ms: f64,
    grids: usize,
    toggled: f64,
    plan_time_s: Option<i64>,
}

/// Walks through all changes twice: a robot's dates are new ones, and what was drawn once is drawn again from what is kept.
fn dates(live: &mut Live) {
    let indices = live.bus.subscriber(topics::Grids).unwrap();
    let schedule_states = live.bus.subscriber(topics::ScheduleState).unwrap();
    let n_storeys = Grids::open(live.next(&indices).bytes()).unwrap().slots.len();
    let slots: Vec<Subscriber<topics::Grid>> =
        GridSlot::all().take(n_storeys).map(|slot| live.bus.subscriber(topics::Grid(slot)).unwrap()).collect();
    let client = Client::<ScheduleRequest>::of(&live.bus).unwrap();
    let mut copies: Vec<Vec<u8>> = vec![Vec::new(); slots.len()];
    let mut states: Vec<u8> = Vec::new();
    let mut step = |live: &mut Live, request: &ScheduleRequest| -> Option<Step> {
        let begun = Stamp::now();
        let open = client.send(request).unwrap();
        let answer = loop {
            match open.take() {
                Ok(Some(Answer::Done(answer))) => break answer,
                Err(_) => return None,
                Ok(_) => drop(live.waiter.wait(Duration::from_secs(1)).unwrap()),
            }
        };
        let index = loop {
            let index = live.next(&indices);
            if index.header().inputs.schedule_state == answer.state.content_hash {
                break index;
            }
        };
        let seen = Stamp::now();
        let schedule_state = loop {
            let schedule_state = live.next(&schedule_states);
            if schedule_state.header().content_hash == answer.state.content_hash {
                break schedule_state;
            }
        };
        let [schedule_state_at, index_at] =
            [schedule_state.header(), index.header()].map(|header| Stamp(header.stamp_ns));
        let now = ScheduleState::open(schedule_state.bytes()).unwrap();
        let new: Vec<u8> = (0..now.n_elements()).map(|k| now.effective(k) as u8).collect();
        let toggled = new.iter().zip(&states).filter(|(a, b)| a != b).count() as f64 / new.len() as f64;
        states = new;
        let changed: Vec<(usize, Sample<topics::Grid>)> =
            slots.iter().enumerate().filter_map(|(k, slot)| Some((k, slot.take().unwrap()?))).collect();
        // Into memory that was written before: what a copy costs when nothing else does.
        let is_cold = changed.iter().any(|(k, grid)| copies[*k].len() != grid.bytes().len());
        if is_cold {
            changed.iter().for_each(|(k, grid)| copies[*k] = grid.bytes().to_vec());
            return None;
        }
        let copied = Instant::now();
        changed.iter().for_each(|(k, grid)| copies[*k].copy_from_slice(grid.bytes()));
        let memcpy_ms = ms(copied.elapsed());
        let parts_ms =
            [schedule_state_at.since(begun), index_at.since(schedule_state_at), seen.since(index_at)].map(ms);
        let (total_ms, grids) = (ms(seen.since(begun)), changed.len());
        Some(Step { total_ms, parts_ms, memcpy_ms, grids, toggled, plan_time_s: answer.plan_time_s })
    };
    let mut walk = |live: &mut Live| -> Vec<Step> {
        step(live, &ScheduleRequest::SetPlanTime { at_s: 0 });
        let mut after_s = Some(0);
        let mut steps = Vec::new();
        for _ in 0..400 {
            let Some(next) = step(live, &ScheduleRequest::NextChange { after_s }) else { continue };
            after_s = next.plan_time_s;
            steps.push(next);
        }
        steps
    };
    for when in ["for the first time", "again"] {
        let steps = walk(live);
        report(&steps, &format!("{when}, at most 1 % toggled"), |step| step.toggled <= 0.01 && step.grids > 0);
        report(&steps, &format!("{when}, more toggled"), |step| step.toggled > 0.01 && step.grids > 0);
        report(&steps, &format!("{when}, no grid changes"), |step| step.grids == 0);
    }
}

fn report(steps: &[Step], which: &str, wanted: impl Fn(&Step) -> bool) {
    let steps: Vec<&Step> = steps.iter().filter(|step| wanted(step)).collect();
    if steps.is_empty() {
        return;
    }
    let of = |value: &dyn Fn(&Step) -> f64| percentiles(&mut steps.iter().map(|s| value(s)).collect::<Vec<_>>());
    let [total, total99] = of(&|s| s.total_ms);
    let [schedule_state, index, seen] = [0, 1, 2].map(|k| of(&|s| s.parts_ms[k])[0]);
    let [memcpy, memcpy99] = of(&|s| s.memcpy_ms);
    let grids = steps.iter().map(|s| s.grids).sum::<usize>() as f64 / steps.len() as f64;
    row(
        &format!("date -> index at a subscriber, seen {which} ({} dates, {grids:.1} grids each)", steps.len()),
        format!(
            "p50 {total:.2} ms, p99 {total99:.2} ms; until the schedule state {schedule_state:.2}, until the index {index:.2}, until it is seen {seen:.2}"
        ),
    );
    // Without a grid there is nothing to copy.
    if grids > 0.0 {
        let ratio_of = |s: &Step| (s.total_ms - 1.0).max(0.0) / s.memcpy_ms;
        let [ratio, ratio99] = of(&ratio_of);
        let [rasterize, _] = of(&|s| s.parts_ms[1] / s.memcpy_ms);
        row(
            &format!("the same against a memcpy of those grids, {which}"),
            format!(
                "memcpy p50 {memcpy:.2} ms, p99 {memcpy99:.2} ms; (date - 1 ms) / memcpy p50 {ratio:.1}, p99 {ratio99:.1}; schedule state to index / memcpy {rasterize:.1}"
            ),
        );
        let mut dearest = steps.clone();
        dearest.sort_by(|a, b| ratio_of(b).total_cmp(&ratio_of(a)));
        let one = |s: &&Step| {
            let [state, index, _] = s.parts_ms;
            let at_s = s.plan_time_s.unwrap_or_default();
            format!(
                "{at_s}: {:.1} ({} grids, {state:.1} + {index:.1} ms, memcpy {:.1})",
                ratio_of(s),
                s.grids,
                s.memcpy_ms
            )
        };
        let dearest: Vec<String> = dearest.iter().take(N_DEAREST).map(one).collect();
        row(&format!("the dearest of these dates, {which}"), dearest.join("; "));
    }
}

/// From publishing to having it, by size; nothing is copied.
fn payloads() {
    let root = tempfile::Builder::new().prefix("gpbench").tempdir_in("/dev/shm").unwrap();
    let prefix = format!("gp{:x}_", std::process::id());
    let domain = Domain::shared(&prefix, root.path()).unwrap();
    let _keeper = Keeper::start(&domain).unwrap();
    let mut epoch = 0;
    for length in [1 << 10, 1 << 20, 16 << 20, 128 << 20, 512 << 20] {
        let (bus, mut own_waiter) = Bus::join(&domain, Daemon::ScheduleEval).unwrap();
        let publisher = bus.publisher(topics::ScheduleState, length).unwrap();
        let (other, mut waiter) = Bus::join(&domain, Daemon::Groundplan).unwrap();
        let (latency_sender, latency_receiver) = std::sync::mpsc::channel();
        let receiver = std::thread::spawn(move || {
            let subscriber = other.subscriber(topics::ScheduleState).unwrap();
            latency_sender.send(0.0).unwrap();
            loop {
                waiter.wait(Duration::from_secs(10)).unwrap();
                while let Some(sample) = subscriber.take().unwrap() {
                    let latency = Stamp::now().since(Stamp(sample.header().stamp_ns));
                    if latency_sender.send(latency.as_secs_f64() * 1e6).is_err() {
                        return;
                    }
                }
            }
        });
        latency_receiver.recv().unwrap();
        let archive = messages::ScheduleStateBuilder::everything_built(ContentHash::from_bits(1), 0, 0).finish();
        let (mut latencies, mut loans) = (Vec::new(), Vec::new());
        for k in 0..300 {
            own_waiter.wait(Duration::ZERO).unwrap();
            let begun = Instant::now();
            let mut loan = publisher.loan(length).unwrap();
            loans.push(begun.elapsed().as_secs_f64() * 1e6);
            write_head(loan.bytes_mut(), &archive);
            epoch += 1;
            loan.publish(Origin { epoch, frame_epoch: 0, inputs: InputHashes::default() }).unwrap();
            let latency = latency_receiver.recv_timeout(Duration::from_secs(10)).unwrap();
            // The first ones touch their pages for the first time.
            if k >= 50 {
                latencies.push(latency);
            }
        }
        let [loan, _] = percentiles(&mut loans[50..]);
        let [p50, p99] = percentiles(&mut latencies);
        row(
            &format!("publish -> had by a waiting subscriber, {} KiB", length >> 10),
            format!("p50 {p50:.0} us, p99 {p99:.0} us; a loan takes {loan:.0} us"),
        );
        drop(latency_receiver);
        epoch += 1;
        publisher
            .publish_copy(archive.bytes(), Origin { epoch, frame_epoch: 0, inputs: InputHashes::default() })
            .unwrap();
        receiver.join().unwrap();
    }
    remove_segments(&prefix);
}

/// An archive as large as the loan says it is: its preamble with the loan's length.
fn write_head(out: &mut [u8], archive: &ArchiveBuffer) {
    let n = archive.bytes().len().min(out.len());
    let length = out.len() as u64;
    out[..n].copy_from_slice(&archive.bytes()[..n]);
    out[16..24].copy_from_slice(&length.to_le_bytes());
}
