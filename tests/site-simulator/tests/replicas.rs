//! A server, its store and robots that follow it in one process, from a seed: dates, revisions and keys that change; deaths at every
//! write to a disk or the store and at every loan; stores that refuse, lose, cut, garble and go back; forged indices; clocks that jump;
//! full disks.
//!
//! After each event what a robot has on its bus is of one index that the server published, whole, in order, and no older than what
//! the robot has acknowledged; no epoch falls, none is used twice, and no index names what is not in the store. When all is calm every
//! robot shows the set that is due, and goes on with later ones without server and store.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

#[path = "support/drawn.rs"]
mod drawn;
#[path = "support/published.rs"]
mod published;
#[path = "support/seeds.rs"]
mod seeds;
#[path = "support/watched_follower.rs"]
mod watched_follower;

use daemon::Clock;
use drawn::{Drawn, N_STOREYS, ROBOT, START_MS, config, drawn};
use published::{Damage, Record, Wanted};
use replica::{IndexClock, SignedIndex, SiteIndex, signed_index};
use seeds::{Dice, Violation, first_violation};
use site_server::publication::Job;
use site_simulator::replicas::{DrawLater, Server, ServerStart};
use site_simulator::simulated_store::{LinkFaults, SimulatedStore, StoreLink, StoredObjects};
use site_simulator::{DiskFaults, End, SimulatedClock};
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;
use std::sync::atomic::{AtomicBool, AtomicI64, Ordering};
use std::sync::{Arc, Mutex};
use store::{Fetched, Listed, Objects, StoreError};
use watched_follower::{WatchedFollower, forget};

/// Histories of the test, and events of each.
const N_HISTORIES: u64 = 2_000;
const N_EVENTS: usize = 60;
/// Histories in which each fault that is put in must be found.
const N_HISTORIES_OF_FAULT: u64 = 4_000;

const DAY_MS: i64 = 86_400_000;
/// Turns in which all that is damaged of what is shown at once is told and fetched, one archive after the other.
const HEALS: usize = 16;
/// A jump that no robot believes.
const JUMP_MS: i64 = 400 * DAY_MS;

/// A fault that is put in by hand.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Fault {
    None,
    /// A robot that starts again knows nothing of what it acknowledged.
    ForgottenIndex,
    /// A robot follows whoever signs.
    AnySignature,
    /// A robot does not notice that its clock jumps.
    BlindClock,
    /// A server writes blobs after the index that names them.
    IndexFirst,
    /// A server that starts again knows of epochs what the store has.
    ForgottenEpoch,
    /// A server draws later sets for another date than it says.
    WrongLater,
}

/// The end of a server that writes blobs after the newest index.
struct BlobsLast {
    link: StoreLink,
    waiting: Mutex<Vec<(String, Vec<u8>)>>,
}

impl Objects for BlobsLast {
    fn address(&self) -> &str {
        self.link.address()
    }

    fn fetch_unless(&self, path: &str, etag: Option<&str>, max_bytes: u64) -> Result<Fetched, StoreError> {
        self.link.fetch_unless(path, etag, max_bytes)
    }

    fn fetch_whole(&self, path: &str, max_bytes: u64) -> Result<Vec<u8>, StoreError> {
        self.link.fetch_whole(path, max_bytes)
    }

    fn fetch_range(&self, path: &str, range: Range<u64>, object_bytes: u64) -> Result<Vec<u8>, StoreError> {
        self.link.fetch_range(path, range, object_bytes)
    }

    fn create(&self, path: &str, bytes: &[u8]) -> Result<bool, StoreError> {
        self.link.create(path, bytes)
    }

    fn replace(&self, path: &str, bytes: &[u8]) -> Result<(), StoreError> {
        if path.contains("/blobs/") {
            self.waiting.lock().unwrap().push((path.to_owned(), bytes.to_vec()));
            return Ok(());
        }
        self.link.replace(path, bytes)?;
        let waiting = std::mem::take(&mut *self.waiting.lock().unwrap());
        waiting.iter().try_for_each(|(path, bytes)| self.link.replace(path, bytes))
    }

    fn length(&self, path: &str) -> Result<Option<u64>, StoreError> {
        let waiting = self.waiting.lock().unwrap().iter().find(|(of, _)| of == path).map(|(_, bytes)| bytes.len());
        waiting.map_or_else(|| self.link.length(path), |length| Ok(Some(length as u64)))
    }

    fn list(&self, folder: &str) -> Result<Vec<Listed>, StoreError> {
        self.link.list(folder)
    }

    fn remove(&self, path: &str) -> Result<(), StoreError> {
        self.link.remove(path)
    }
}

/// What a store had.
struct Earlier {
    objects: StoredObjects,
    damaged: BTreeMap<String, Damage>,
    current: u64,
}

/// A site on many machines.
struct History {
    dice: Dice,
    fault: Fault,
    _home: tempfile::TempDir,
    clock: SimulatedClock,
    store: SimulatedStore,
    server: Server,
    server_link: Arc<Mutex<LinkFaults>>,
    start: ServerStart,
    wanted: Wanted,
    /// Which of the keys signs.
    key: usize,
    draws_nothing: Arc<AtomicBool>,
    robots: Vec<WatchedFollower>,
    record: Record,
    earlier: Option<Earlier>,
    log: Vec<String>,
}

impl History {
    fn new(seed: u64, fault: Fault) -> Self {
        let drawn = drawn();
        let home = tempfile::Builder::new().prefix("sim").tempdir_in("/dev/shm").unwrap();
        let clock = SimulatedClock(Arc::new(AtomicI64::new(START_MS)));
        let store = SimulatedStore::new(clock.clone());
        let link =
            |meantime| StoreLink { store: store.clone(), faults: Arc::default(), deaths: Arc::default(), meantime };
        let of_server = link(None);
        let (server_link, deaths) = (Arc::clone(&of_server.faults), Arc::clone(&of_server.deaths));
        let open = move || -> Box<dyn Objects> {
            match fault {
                Fault::IndexFirst => Box::new(BlobsLast { link: of_server.clone(), waiting: Mutex::default() }),
                _ => Box::new(of_server.clone()),
            }
        };
        let server = Server::new(clock.clone(), deaths, Arc::new(open));
        let draws_nothing = Arc::new(AtomicBool::new(false));
        let site = config("state = \"server\"\n", home.path());
        let mut dice = Dice(seed);
        let serve = config(
            &format!(
                "state = \"server\"\n[serve]\nstore = \"memory\"\nsite = \"tower\"\nkey = {:?}\nkeys = {:?}\nahead = {}\nkeep_days = {}\n",
                drawn.keys.files[0][0],
                drawn.keys.files[0][1],
                dice.below(4),
                [0, 0, 10][dice.below(3)],
            ),
            home.path(),
        );
        let draw = draw_later(Arc::clone(&draws_nothing), fault);
        let start = ServerStart { config: serve.serve.unwrap(), site, draw };
        let storeys = [(0..N_STOREYS).collect(), vec![1], vec![0]];
        let robots = storeys.into_iter().take(2 + usize::from(dice.one_in(4))).enumerate();
        let trusted = if fault == Fault::AnySignature { 2 } else { 1 };
        let roots = &[drawn.keys.root, drawn.keys.foreign_root][..trusted];
        let robot =
            |(k, storeys)| WatchedFollower::new(home.path(), &format!("robot-{k}"), storeys, roots, link(None), &clock);
        let robots = robots.map(robot).collect();
        let wanted = Wanted { revision: 0, place: 0, clock: IndexClock::ByServer, has_plan: true };
        Self {
            dice,
            fault,
            _home: home,
            clock,
            store,
            server,
            server_link,
            start,
            wanted,
            key: 0,
            draws_nothing,
            robots,
            record: Record::new(),
            earlier: None,
            log: Vec::new(),
        }
    }

    fn run(mut self) -> Result<(), Violation> {
        let result = self.events();
        result.map_err(|why| format!("{why}\n{}", self.log.join("\n")))
    }

    fn events(&mut self) -> Result<(), Violation> {
        for _ in 0..N_EVENTS {
            self.event();
            self.look()?;
        }
        self.calm()?;
        self.alone()
    }

    fn look(&mut self) -> Result<(), Violation> {
        self.record.take(&self.store, &self.wanted)?;
        let now_s = self.now_s();
        for (k, robot) in self.robots.iter_mut().enumerate() {
            robot.look(&self.record, now_s).map_err(|why| format!("robot {k}: {why}"))?;
        }
        Ok(())
    }

    fn note(&mut self, what: impl Into<String>) {
        self.log.push(what.into());
    }

    fn now_s(&self) -> i64 {
        self.clock.now().wall_ms.div_euclid(1_000)
    }

    /// Something happens.
    fn event(&mut self) {
        let k = self.dice.below(self.robots.len());
        match self.dice.below(36) {
            0..10 => self.robot_works(k),
            10..15 => self.server_works(),
            15..19 => self.operator(),
            19 | 20 => {
                let ms = [60_000, 3_600_000, DAY_MS, 3 * DAY_MS][self.dice.below(4)];
                let ms = self.dice.below(ms as usize) as i64;
                self.note(format!("{ms} ms pass"));
                self.clock.pass(ms);
            }
            21 => self.robot_stops(k),
            22 => {
                self.note("the server dies");
                self.server.kill();
            }
            23 | 24 => self.link_fails(k),
            25 | 26 => self.disk_fails(k),
            27 => self.bus_fails(k),
            28 | 29 => self.store_fails(),
            30..33 => self.forge(k),
            33 | 34 => self.clock_fails(k),
            _ => self.archive_is_damaged(k),
        }
    }

    fn robot_works(&mut self, k: usize) {
        let forgets = self.fault == Fault::ForgottenIndex;
        if !self.robots[k].follower.is_alive() {
            let started = self.robots[k].start(forgets);
            return self.note(format!("robot {k} starts: {started:?}"));
        }
        if self.dice.one_in(3) {
            let end = self.robots[k].follower.tick();
            return self.note(format!("robot {k} ticks: {end:?}"));
        }
        let meantime = if self.dice.one_in(2) { self.dice.roll() & self.dice.roll() } else { 0 };
        self.robots[k].follower.link.lock().unwrap().meantime = meantime;
        let end = self.robots[k].follower.ask();
        self.robots[k].follower.link.lock().unwrap().meantime = 0;
        let trouble = self.robots[k].follower.process.lock().unwrap().standing();
        self.note(format!("robot {k} asks: {end:?} {trouble:?}"));
        let end = self.robots[k].follower.tick();
        self.note(format!("robot {k} ticks: {end:?}"));
    }

    fn job(&self) -> Job {
        let site = drawn().revisions[self.wanted.revision].site.clone();
        let site = site_server::pieces::SitePieces { clock: self.wanted.clock.clone(), ..site };
        Job { site, set: self.wanted.set(), config: self.start.site.clone() }
    }

    fn server_works(&mut self) {
        if !self.server.is_alive() {
            return self.server_starts();
        }
        if self.dice.one_in(4) {
            self.date_goes_on();
        }
        let end = self.server.step();
        self.note(format!("the server works: {end:?}"));
    }

    fn server_starts(&mut self) {
        if self.fault == Fault::ForgottenEpoch {
            forget(&self.start.site.state, "site-server-tower.json");
        }
        let started = self.server.start(&self.start);
        self.note(format!("the server starts: {started:?}"));
        self.record.server_starts();
        self.server.give(self.job());
    }

    /// A plan time that follows the clock is that of the clock.
    fn date_goes_on(&mut self) {
        if self.wanted.clock == IndexClock::ByServer {
            return;
        }
        let (sets, now_s) = (&drawn().revisions[self.wanted.revision].sets, self.now_s());
        let place = sets.iter().rposition(|set| set.plan_time_s <= Some(now_s)).unwrap_or(0);
        self.want(Wanted { place, ..self.wanted.clone() });
    }

    fn want(&mut self, wanted: Wanted) {
        if wanted == self.wanted {
            return;
        }
        self.note(format!("{wanted:?}"));
        self.wanted = wanted;
        self.server.give(self.job());
    }

    /// An operator changes something at the server.
    fn operator(&mut self) {
        let mut wanted = self.wanted.clone();
        let n_sets = |revision: usize| drawn().revisions[revision].sets.len();
        match self.dice.below(8) {
            0..3 => {
                wanted.clock = IndexClock::ByServer;
                wanted.place = self.dice.below(n_sets(wanted.revision));
            }
            3 => {
                wanted.revision = self.dice.below(2);
                wanted.place = wanted.place.min(n_sets(wanted.revision) - 1);
            }
            4 | 5 => wanted.clock = IndexClock::Wall { zone: "UTC".to_owned() },
            6 => wanted.has_plan = !wanted.has_plan,
            _ if self.dice.one_in(2) => {
                let nothing = self.dice.one_in(2);
                self.note(format!("nothing is drawn ahead: {nothing}"));
                return self.draws_nothing.store(nothing, Ordering::Relaxed);
            }
            _ => return self.change_keys(),
        }
        self.want(wanted);
        self.date_goes_on();
    }

    /// The second key signs from here on, and the first one is revoked.
    fn change_keys(&mut self) {
        self.note("the first key is revoked");
        self.key = 1;
        let [key, keys] = drawn().keys.files[1].clone();
        (self.start.config.key, self.start.config.keys) = (key, keys);
        self.server.kill();
    }

    fn robot_stops(&mut self, k: usize) {
        self.note(format!("robot {k} stops"));
        let is_off = self.dice.one_in(2);
        let robot = &mut self.robots[k].follower;
        robot.kill();
        if is_off {
            self.tear(k);
            if self.fault != Fault::BlindClock {
                self.robots[k].follower.clock.change(|clock| clock.boot += 1);
            }
        }
    }

    /// A robot without power loses what was not flushed: of archives that are not whole.
    fn tear(&mut self, k: usize) {
        let folder = self.robots[k].follower.state().join("followed-archives");
        for path in std::fs::read_dir(folder).into_iter().flatten().map(|entry| entry.unwrap().path()) {
            let is_part = path.extension().is_some_and(|end| end == "part");
            let is_recipe = path.extension().is_some_and(|end| end == "recipe") && !path.with_extension("").exists();
            if (is_part || is_recipe) && self.dice.one_in(2) {
                let mut bytes = std::fs::read(&path).unwrap();
                let from = self.dice.below(bytes.len() + 1);
                if is_part {
                    bytes[from..].fill(0);
                } else {
                    bytes.truncate(from);
                }
                std::fs::write(&path, bytes).unwrap();
                self.note(format!("robot {k} loses what it had not flushed"));
            }
        }
    }

    fn link_fails(&mut self, k: usize) {
        let is_server = self.dice.one_in(2);
        let mut faults = LinkFaults::default();
        match self.dice.below(7) {
            0 => faults.is_away = true,
            6 => faults.slow_ms = 4_000,
            1 | 2 => faults.breaks_off = Some((self.dice.below(12) as u32, 1 + self.dice.below(6) as u32)),
            3 => faults.loses_answer = Some(self.dice.below(8) as u32),
            4 => faults.garbles = Some(self.dice.below(10) as u32),
            _ => {}
        }
        let (name, link) = match is_server {
            true => ("the server".to_owned(), Arc::clone(&self.server_link)),
            false => (format!("robot {k}"), Arc::clone(&self.robots[k].follower.link)),
        };
        self.note(format!("the link of {name}: {faults:?}"));
        let forged = link.lock().unwrap().forged.clone();
        *link.lock().unwrap() = LinkFaults { forged, ..faults };
    }

    fn disk_fails(&mut self, k: usize) {
        let death = self.dice.one_in(2).then(|| (self.dice.below(16) as u32, self.dice.one_in(2)));
        let is_full = death.is_none() && self.dice.one_in(2);
        let (name, disk) = match self.dice.one_in(3) {
            true => ("the server".to_owned(), &self.server.faults),
            false => (format!("robot {k}"), &self.robots[k].follower.faults),
        };
        let faults = DiskFaults { is_full, death, loses_way_back: false };
        *disk.lock().unwrap() = faults;
        self.note(format!("the disk of {name}: {faults:?}"));
    }

    fn bus_fails(&mut self, k: usize) {
        let (what, n) = (self.dice.below(5), self.dice.below(6));
        let robot = &mut self.robots[k];
        let told = match what {
            0 => {
                robot.follower.bus.set_full(n < 3);
                format!("is full: {}", n < 3)
            }
            1 => {
                robot.follower.bus.fail_publish_after(n);
                format!("fails after {n}")
            }
            2 | 3 => {
                robot.follower.bus.die_at_publish_after(Some(n));
                format!("kills after {n}")
            }
            _ => format!("is created anew: {:?}", robot.renew_bus()),
        };
        self.note(format!("the bus of robot {k} {told}"));
    }

    fn store_fails(&mut self) {
        // What the server did before counts as such.
        let blobs = self.record.blobs();
        let current = self.record.current_path();
        match self.dice.below(10) {
            0..4 if !blobs.is_empty() => {
                let path = blobs[self.dice.below(blobs.len())].clone();
                let Some(bytes) = self.store.object(&path) else { return };
                let (bytes, damage) = match self.dice.below(3) {
                    0 => (None, Damage::Lost),
                    1 => (Some(bytes[..bytes.len() / 2].to_vec()), Damage::Lost),
                    _ => (Some(vec![7; bytes.len()]), Damage::Wrong),
                };
                self.note(format!("{path} in the store: {damage:?}, {:?} bytes", bytes.as_ref().map(Vec::len)));
                self.store.tamper(&path, bytes);
                self.record.is_damaged(&path, damage);
            }
            4 | 5 => {
                self.note("what the store has is kept");
                let (damaged, current) = (self.record.damaged.clone(), self.record.current);
                self.earlier = Some(Earlier { objects: self.store.objects(), damaged, current });
            }
            6 => {
                let Some(Earlier { objects, damaged, current }) = self.earlier.take() else { return };
                self.note(format!("the store is set back to epoch {current}"));
                let present: BTreeSet<String> = objects.keys().cloned().collect();
                self.record.is_set_back(present, damaged, current);
                self.store.set_back(objects);
            }
            7 => {
                self.note("the store loses its newest index");
                self.store.tamper(&current, None);
                self.record.current = 0;
            }
            8 => {
                let Some(forged) = self.forged_index(usize::MAX) else { return };
                self.note(format!("the store has another newest index: {}", forged.0));
                self.record.current = self.record.epoch_of(&forged.1).unwrap_or(0);
                self.store.tamper(&current, Some(forged.1));
            }
            _ => {
                let epoch = self.record.taken + 1 + self.dice.below(3) as u64;
                self.note(format!("somebody else writes an index of epoch {epoch}"));
                let path = replica::index_path(&"tower".parse().unwrap(), epoch);
                self.store.tamper(&path, Some(b"mine".to_vec()));
            }
        }
    }

    /// An index that no robot may show, for one robot or all, and what it is.
    fn forged_index(&mut self, robot: usize) -> Option<(String, Vec<u8>)> {
        let keys = &drawn().keys;
        let known: Vec<u64> = self.record.indices.keys().copied().collect();
        let newest = &self.record.indices[known.last()?];
        let mut index = SiteIndex { epoch: newest.index.epoch + 50, ..newest.index.clone() };
        // Somebody else has other maps: those of the first storey on all of them.
        for set in &mut index.sets {
            let storeys = &mut set.robots.get_mut(ROBOT).unwrap().storeys;
            let first = storeys[0].grid;
            storeys.iter_mut().for_each(|storey| storey.grid = first);
        }
        let may_be_stolen = match self.robots.get(robot) {
            Some(robot) => robot.list == 2,
            None => self.robots.iter().all(|robot| robot.list == 2),
        };
        Some(match self.dice.below(4) {
            0 => {
                let epoch = known[self.dice.below(known.len())];
                (format!("the old one of epoch {epoch}"), self.record.indices[&epoch].file.clone())
            }
            1 => {
                let text = String::from_utf8(newest.file.clone()).unwrap();
                let epoch = newest.index.epoch;
                let (from, to) = (format!("\"epoch\":{epoch}"), format!("\"epoch\":{}", epoch + 50));
                ("one that was changed".to_owned(), text.replacen(&from, &to, 1).into_bytes())
            }
            2 => ("a foreign one".to_owned(), signed_index(&keys.foreign_list, &index, &keys.foreign).unwrap()),
            _ if may_be_stolen => {
                // With the content of the newest one it is the harder to tell.
                let index = SiteIndex { epoch: index.epoch, ..newest.index.clone() };
                ("one of a revoked key".to_owned(), signed_index(&keys.lists[0], &index, &keys.signing[0]).unwrap())
            }
            _ => ("no index".to_owned(), b"{}\n{}\n{}\n{}\n".to_vec()),
        })
    }

    /// Somebody on the way gives a robot another index, or lets it be.
    fn forge(&mut self, k: usize) {
        let path = self.record.current_path();
        let forged = if self.dice.one_in(4) { None } else { self.forged_index(k) };
        self.note(format!("on the way to robot {k}: {:?}", forged.as_ref().map(|forged| &forged.0)));
        let mut link = self.robots[k].follower.link.lock().unwrap();
        link.forged.clear();
        link.forged.extend(forged.map(|(_, bytes)| (path, bytes)));
    }

    fn clock_fails(&mut self, k: usize) {
        let robot = &mut self.robots[k];
        // Who has shown nothing yet believes any clock.
        let has_reached = robot.kept()["reached"][1]["plan_s"].is_i64();
        match self.dice.below(5) {
            0 | 1 if has_reached && !robot.is_clock_wrong => {
                let is_blind = self.fault == Fault::BlindClock;
                let by_ms = [JUMP_MS, -10 * DAY_MS][self.dice.below(2)];
                robot.is_clock_wrong = true;
                robot.follower.clock.change(|clock| {
                    clock.ahead_ms = by_ms;
                    clock.counts_more_ms = if is_blind { by_ms } else { 0 };
                });
                self.note(format!("the clock of robot {k} jumps by {by_ms} ms"));
            }
            2 => {
                let path = robot.synchronised();
                let told = if path.exists() { std::fs::remove_file(path) } else { std::fs::write(path, "") };
                told.unwrap();
                self.note(format!("the clock of robot {k} is synchronised, or not any more"));
            }
            _ => self.put_clock_right(k),
        }
    }

    fn put_clock_right(&mut self, k: usize) {
        let robot = &mut self.robots[k];
        robot.is_clock_wrong = false;
        robot.follower.clock.change(|clock| (clock.ahead_ms, clock.counts_more_ms) = (0, 0));
        self.note(format!("the clock of robot {k} is right"));
    }

    /// What the disk of a robot has of an archive is another one, or has another bit.
    fn archive_is_damaged(&mut self, k: usize) {
        let folder = self.robots[k].follower.state().join("followed-archives");
        let files = std::fs::read_dir(folder).into_iter().flatten().map(|entry| entry.unwrap().path());
        let mut files: Vec<_> = files.filter(|path| path.extension().is_none()).collect();
        files.sort();
        if files.is_empty() {
            return;
        }
        let (file, other) = (&files[self.dice.below(files.len())], &files[self.dice.below(files.len())]);
        let mut bytes = std::fs::read(file).unwrap();
        let others = std::fs::read(other).unwrap();
        if others != bytes && others.len() == bytes.len() {
            self.note(format!("robot {k} has another archive for {}", file.display()));
            bytes = others;
        } else {
            let place = self.dice.below(bytes.len());
            bytes[place] ^= 1;
            self.note(format!("a bit of robot {k} is another in {}", file.display()));
        }
        std::fs::write(file, bytes).unwrap();
        self.robots[k].lose_something();
    }

    /// No more faults: all run, and do what is to be done until nothing is.
    fn calm(&mut self) -> Result<(), Violation> {
        self.note("calm");
        *self.server_link.lock().unwrap() = LinkFaults::default();
        *self.server.faults.lock().unwrap() = DiskFaults::default();
        self.draws_nothing.store(false, Ordering::Relaxed);
        // Blobs whose bytes are others are told, and taken away by an operator.
        let wrong = self.record.damaged.iter().filter(|(_, damage)| **damage == Damage::Wrong);
        for path in wrong.map(|(path, _)| path.clone()).collect::<Vec<_>>() {
            self.store.tamper(&path, None);
            self.record.is_damaged(&path, Damage::Lost);
        }
        self.wanted.has_plan = true;
        self.date_goes_on();
        self.server.kill();
        self.server_starts();
        let end = self.server.step();
        self.note(format!("the server works: {end:?}"));
        self.look()?;
        match end {
            End::Done(outcome) if outcome.error.is_none() && outcome.warning.is_none() => {}
            end => return Err(format!("the server has nothing to complain of: {end:?}")),
        }
        for k in 0..self.robots.len() {
            self.put_clock_right(k);
            let robot = &mut self.robots[k];
            *robot.follower.link.lock().unwrap() = LinkFaults::default();
            *robot.follower.faults.lock().unwrap() = DiskFaults::default();
            robot.follower.bus.set_full(false);
            robot.follower.bus.die_at_publish_after(None);
            robot.follower.bus.fail_publish_after(usize::MAX);
            std::fs::write(robot.synchronised(), "").unwrap();
        }
        for _ in 0..HEALS {
            self.clock.pass(5_000);
            for k in 0..self.robots.len() {
                let started = self.robots[k].start(self.fault == Fault::ForgottenIndex);
                let asked = self.robots[k].follower.ask();
                let ticked = self.robots[k].follower.tick();
                self.note(format!("robot {k} starts: {started:?}, asks: {asked:?}, ticks: {ticked:?}"));
            }
            self.look()?;
        }
        self.check_calm()
    }

    /// The newest index is what is wanted, its blobs are in the store, and all robots show it.
    fn check_calm(&self) -> Result<(), Violation> {
        let newest = self.store.object(&self.record.current_path()).ok_or("the store has no newest index")?;
        let signed = SignedIndex::parse(&newest, &[drawn().keys.root]).map_err(|why| daemon::chain(&why))?;
        let index = &signed.index;
        if signed.keys.number != self.key as u64 + 1 {
            return Err(format!("the newest index has list {} of the keys", signed.keys.number));
        }
        let wanted = self.wanted.set();
        if index.sets[0].plan_time_s != wanted.plan_time_s
            || index.sets[0].schedule_state.content_hash != wanted.state.hash
            || index.clock != self.wanted.clock
        {
            return Err(format!("the newest index is not what is wanted: {:?}", index.sets[0]));
        }
        for path in self.record.needed(&self.store, index) {
            let object = self.store.object(&path);
            let is_whole = object.is_some_and(|bytes| path.ends_with(&messages::ContentId::of(&bytes).to_string()));
            if !is_whole {
                return Err(format!("{path} is not in the store, and the newest index needs it"));
            }
        }
        for (k, robot) in self.robots.iter().enumerate() {
            let process = robot.follower.process.lock().unwrap();
            let (facts, standing) = (process.facts(), process.standing());
            let epoch = facts.as_ref().map(|facts| facts.epoch);
            let error = standing.as_ref().and_then(|standing| standing.error.clone());
            if epoch != Some(index.epoch) || error.is_some() {
                return Err(format!("robot {k} shows {epoch:?} and not {}: {error:?}", index.epoch));
            }
            let now_s = Some(self.now_s()).filter(|_| index.clock != IndexClock::ByServer);
            let due = index.sets.iter().rposition(|set| set.plan_time_s <= now_s).unwrap_or(0);
            robot.shows(&self.record, index.epoch, due).map_err(|why| format!("robot {k}: {why}"))?;
        }
        Ok(())
    }

    /// Without server and store robots go on by their own clocks.
    fn alone(&mut self) -> Result<(), Violation> {
        let newest = &self.record.indices[&self.record.current].index;
        let (epoch, clock) = (newest.epoch, newest.clock.clone());
        let times: Vec<Option<i64>> = newest.sets.iter().map(|set| set.plan_time_s).collect();
        self.server.kill();
        for robot in &self.robots {
            // What is damaged on a disk is noticed when it is due, and fetched again.
            robot.follower.link.lock().unwrap().is_away = !robot.is_damaged;
        }
        for (place, at_s) in times.iter().enumerate().skip(1) {
            if clock == IndexClock::ByServer {
                break;
            }
            let until_ms = at_s.unwrap() * 1_000 - self.clock.now().wall_ms;
            self.note(format!("{until_ms} ms pass, and set {place} is due"));
            self.clock.pass(until_ms.max(0));
            for k in 0..self.robots.len() {
                let robot = &mut self.robots[k];
                let ticked = robot.follower.tick();
                let n_heals = if robot.is_damaged { HEALS } else { 0 };
                let healed: Vec<_> = (0..n_heals).map(|_| (robot.follower.ask(), robot.follower.tick())).collect();
                let standing = robot.follower.process.lock().unwrap().standing();
                self.note(format!("robot {k} ticks: {ticked:?} {healed:?} {standing:?}"));
            }
            self.look()?;
            for (k, robot) in self.robots.iter().enumerate() {
                robot.shows(&self.record, epoch, place).map_err(|why| format!("robot {k} alone: {why}"))?;
            }
        }
        Ok(())
    }
}

/// Later sets as they were drawn.
fn draw_later(nothing: Arc<AtomicBool>, fault: Fault) -> DrawLater {
    Arc::new(move |job: &Job, ahead: usize| {
        if nothing.load(Ordering::Relaxed) {
            return Err("nothing is drawn".into());
        }
        let Drawn { revisions, .. } = drawn();
        let revision = revisions.iter().find(|revision| revision.site.site.hash == job.site.site.hash).unwrap();
        let later = revision.sets.iter().filter(|set| set.plan_time_s > job.set.plan_time_s);
        let mut later: Vec<_> = later.take(ahead).cloned().collect();
        if let (Fault::WrongLater, [.., before, last]) = (fault, &mut later[..]) {
            last.robots.clone_from(&before.robots);
        }
        Ok(later)
    })
}

#[test]
fn no_history_shows_what_the_server_did_not_publish_and_calm_brings_all_up_to_date() {
    if let Some((seed, why)) = first_violation(N_HISTORIES, |seed| History::new(seed, Fault::None).run()) {
        panic!("seed {seed}: {why}");
    }
}

#[test]
fn what_was_cleaned_is_written_again_before_an_index_names_it() {
    let mut site = History::new(0, Fault::None);
    (site.start.config.keep_days, site.start.config.ahead) = (0, 3);
    let by_server = |place| Wanted { place, clock: IndexClock::ByServer, revision: 0, has_plan: true };
    // The map of the second date is known from the first index, in which it is a later one.
    let dates =
        [Wanted { clock: IndexClock::Wall { zone: "UTC".to_owned() }, ..by_server(0) }, by_server(1), by_server(0)];
    for (k, wanted) in dates.into_iter().enumerate() {
        if k == 1 {
            // What is older than a day goes.
            site.clock.pass(DAY_MS + 3_600_000);
            site.server.kill();
        }
        site.want(wanted);
        if !site.server.is_alive() {
            site.server_starts();
        }
        let end = site.server.step();
        assert!(matches!(&end, End::Done(outcome) if outcome.error.is_none()), "{end:?}");
        site.look().unwrap();
    }
}

#[test]
fn faults_that_are_put_in_are_found() {
    let expected: [(Fault, &[&str]); 6] = [
        // Who has forgotten how far his clock got believes one that is wrong, too.
        (Fault::ForgottenIndex, &["was acknowledged", "is not set"]),
        // What somebody else signs has grids that its index does not name.
        (Fault::AnySignature, &["has not published", "did not publish", "comes before the grid"]),
        (Fault::BlindClock, &["is shown, and it is"]),
        (Fault::IndexFirst, &["which is not there"]),
        (Fault::ForgottenEpoch, &["is used twice", "epochs fall"]),
        (Fault::WrongLater, &["is not what was drawn"]),
    ];
    for (fault, told) in expected {
        let found = first_violation(N_HISTORIES_OF_FAULT, |seed| History::new(seed, fault).run());
        let (seed, why) = found.unwrap_or_else(|| panic!("{fault:?} is not found"));
        assert!(told.iter().any(|told| why.contains(told)), "{fault:?}, seed {seed}: {why}");
    }
}
