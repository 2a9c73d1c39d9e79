//! A whole site in one process, from a seed: dates, revisions, progress, robots, full memory, full disks, deaths after every step.
//! After each event what is seen on the bus belongs together, no epoch falls, and answers are true; when all is calm again the site
//! is what its operator asked for.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

#[path = "../../tests/support/house.rs"]
#[expect(dead_code, reason = "other tests use the rest of it")]
mod house;

use bus::{Bus, CheckedSample, Daemon, GridSlot, RawSubscriber, TopicName, topics};
use daemon::{
    ActualsSource, FileText, IngestRequest, Published, RasterizeRequest, RevisionEffect, Robot, ScheduleRequest,
    WaypointRequest,
};
use house::{House, PLAIN};
use messages::{ContentHash, RobotProfile, ScheduleState};
use raster::Rasterizer;
use schedule::{Overrides, Rules, evaluate, parse_actuals};
use site_simulator::{DAEMONS, Daemons, DiskFaults, End, SimulatedClock};
use site_view::SiteSetReader;
use std::collections::{BTreeMap, HashMap};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicI64, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, OnceLock};

/// Histories of the test, and events of each.
const N_HISTORIES: u64 = 10_000;
const N_EVENTS: usize = 24;
/// Histories in which each fault that is put in must be found.
const N_HISTORIES_OF_FAULT: u64 = 2_000;

/// Metres per cell: what is judged is what belongs together, not how it is drawn.
const RESOLUTION_M: f64 = 0.25;
/// The machine's clock at the start, milliseconds since 1970: 1 March 2024.
const START_MS: i64 = 1_709_251_200_000;
const DAY_S: i64 = 86_400;

/// A fault that is put in by hand.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Fault {
    None,
    /// What was saved for a decision that fails is not taken back.
    LostWayBack,
    /// A reader takes the newest sample of each topic as a set, without asking whether they belong together.
    MixedSet,
    /// A daemon that starts again counts its samples from 1.
    FallingEpoch,
}

/// The models of the site, and a state folder in which the first is in force.
struct Models {
    folder: tempfile::TempDir,
    paths: [PathBuf; 3],
    /// Elements whose progress can be reported: both sound models have them.
    walls: Vec<String>,
}

const RULES: &str = "[[property_dates]]\napplies_to = \"IfcBuiltElement\"\nset = \"Plan\"\nproperty = \"Built\"\n";

fn toml(state: &Path, models: &Models) -> String {
    let [first, ..] = &models.paths;
    format!(
        "models = [{:?}]\nstate = {:?}\n[schedule]\nrules = {:?}\nplan_time = \"2024-03-01\"\n[robot]\nresolution_m = {RESOLUTION_M}\n",
        first.display().to_string(),
        state.display().to_string(),
        models.folder.path().join("rules.toml").display().to_string(),
    )
}

/// A room of 4 m by 3 m whose walls are built one after the other; in the second model there is a wall more.
fn house(folder: &Path, name: &str, has_more: bool) -> (PathBuf, Vec<String>) {
    let mut house = House::new("IFC4");
    house.add("IFCSLAB", "Floor", "$,.FLOOR.", [[-0.2, -0.2, -0.2], [4.2, 3.2, 0.0]]);
    let mut walls = Vec::new();
    let corners = [
        [[-0.2, -0.2, 0.0], [4.2, 0.0, 2.5]],
        [[-0.2, 3.0, 0.0], [4.2, 3.2, 2.5]],
        [[-0.2, 0.0, 0.0], [0.0, 3.0, 2.5]],
        [[4.0, 0.0, 0.0], [4.2, 3.0, 2.5]],
    ];
    for (k, corners) in corners.into_iter().enumerate() {
        let wall = house.add("IFCWALL", "Wall", PLAIN, corners);
        house.add_text_property(wall, "Plan", "Built", &format!("2024-03-{:02}", 5 + 4 * k));
        walls.push(format!("{:0>22}", wall - 1));
    }
    house.add_room("Room", [[0.0, 0.0, 0.0], [4.0, 3.0, 2.5]]);
    if has_more {
        house.add("IFCWALL", "Partition", PLAIN, [[1.9, 0.0, 0.0], [2.1, 1.5, 2.5]]);
    }
    let path = folder.join(name);
    std::fs::rename(house.write(folder), &path).unwrap();
    (path, walls)
}

/// The models, made once; the site that the first one makes is in the state folder `template`.
fn models() -> &'static Models {
    static MODELS: OnceLock<Models> = OnceLock::new();
    MODELS.get_or_init(|| {
        let folder = tempfile::Builder::new().prefix("sim").tempdir_in("/dev/shm").unwrap();
        let (first, walls) = house(folder.path(), "first.ifc", false);
        let (second, _) = house(folder.path(), "second.ifc", true);
        let broken = folder.path().join("broken.ifc");
        std::fs::write(&broken, "ISO-10303-21;\nHEADER;\n").unwrap();
        std::fs::write(folder.path().join("rules.toml"), RULES).unwrap();
        let models = Models { paths: [first, second, broken], walls, folder };
        let state = models.folder.path().join("template");
        let clock = SimulatedClock(Arc::new(AtomicI64::new(START_MS)));
        let mut daemons = Daemons::of(&toml(&state, &models), models.folder.path(), clock);
        for daemon in DAEMONS {
            let started = daemons.start(daemon);
            assert!(matches!(started, End::Done(())), "{daemon}: {started:?}");
        }
        assert!(daemons.ingest.facts().unwrap().site.epoch > 0, "the first model is in force");
        models
    })
}

fn copy_folder(from: &Path, to: &Path) {
    std::fs::create_dir_all(to).unwrap();
    for entry in std::fs::read_dir(from).unwrap() {
        let entry = entry.unwrap();
        let path = to.join(entry.file_name());
        if entry.file_type().unwrap().is_dir() {
            copy_folder(&entry.path(), &path);
        } else {
            std::fs::copy(entry.path(), path).unwrap();
        }
    }
}

/// Numbers from a seed (SplitMix64).
struct Dice(u64);

impl Dice {
    fn roll(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    fn below(&mut self, n: usize) -> usize {
        (self.roll() % n as u64) as usize
    }

    fn one_in(&mut self, n: usize) -> bool {
        self.below(n) == 0
    }
}

/// What the operator has asked for.
#[derive(Debug, Clone, PartialEq)]
struct Wanted {
    plan_time: WantedTime,
    robot: usize,
    /// Tables of reported progress, the last one in force.
    progress: Vec<String>,
    model: usize,
}

/// How the plan time moves.
#[derive(Debug, Clone, Copy, PartialEq)]
enum WantedTime {
    Fixed(i64),
    Running { from_s: i64, rate: f64, since_ms: i64 },
}

impl WantedTime {
    fn at_s(self, now_ms: i64) -> i64 {
        match self {
            Self::Fixed(at_s) => at_s,
            Self::Running { from_s, rate, since_ms } => {
                from_s + ((now_ms - since_ms) as f64 / 1e3 * rate).floor() as i64
            }
        }
    }

    /// As schedule-eval calls it.
    fn words(self) -> String {
        match self {
            Self::Fixed(_) => "fixed".to_owned(),
            Self::Running { rate, .. } => format!("simulated, {rate} times as fast"),
        }
    }
}

/// Profiles of robots; the first is that of the configuration.
const ROBOTS: [&str; 3] = ["default", "narrow", "wide"];

fn profile(robot: usize) -> FileText {
    let text = format!("name = {:?}\nradius_m = {}\n", ROBOTS[robot], [0.3, 0.2, 0.45][robot]);
    FileText { path: format!("/{}.toml", ROBOTS[robot]).into(), text }
}

/// What is newest on the topics, as a reader sees it.
struct Reader {
    topics: Vec<RawSubscriber>,
    sets: SiteSetReader,
    newest: Newest,
}

/// The newest samples of topics that a reader without rules takes for a set.
#[derive(Default)]
struct Newest {
    site: Option<CheckedSample<topics::Site>>,
    state: Option<CheckedSample<topics::ScheduleState>>,
    grids: BTreeMap<usize, ContentHash>,
    robot: Option<RobotProfile>,
}

impl Reader {
    fn of(bus: &bus::InProcessBus) -> Self {
        let bus = Bus::in_process(bus, Daemon::Groundplan);
        let names = [
            TopicName::Site,
            TopicName::ScheduleState,
            TopicName::Grid(GridSlot::new(0).unwrap()),
            TopicName::Grids,
            TopicName::MissionPlan,
        ];
        let topics = names.into_iter().map(|name| bus.raw_subscriber(name).unwrap()).collect();
        Self { topics, sets: SiteSetReader::of(&bus).unwrap(), newest: Newest::default() }
    }
}

/// A history that went wrong, in a sentence.
type Violation = String;

/// A site with its operator.
struct History {
    dice: Dice,
    fault: Fault,
    _home: tempfile::TempDir,
    daemons: Daemons,
    clock: SimulatedClock,
    reader: Reader,
    /// Highest epoch of each topic, and the hash of its content.
    epochs: BTreeMap<TopicName, (u64, ContentHash)>,
    wanted: Wanted,
    /// What a request asked for whose process died before it answered: either may be in force.
    unanswered: Option<Wanted>,
    log: Vec<String>,
}

impl History {
    fn new(seed: u64, fault: Fault) -> Self {
        let models = models();
        let home = tempfile::Builder::new().prefix("sim").tempdir_in("/dev/shm").unwrap();
        let state = home.path().join("state");
        copy_folder(&models.folder.path().join("template"), &state);
        let clock = SimulatedClock(Arc::new(AtomicI64::new(START_MS)));
        let daemons = Daemons::of(&toml(&state, models), home.path(), clock.clone());
        let reader = Reader::of(&daemons.shared.bus);
        let wanted =
            Wanted { plan_time: WantedTime::Fixed(START_MS / 1_000), robot: 0, progress: Vec::new(), model: 0 };
        let (dice, epochs) = (Dice(seed), BTreeMap::new());
        Self { dice, fault, _home: home, daemons, clock, reader, epochs, wanted, unanswered: None, log: Vec::new() }
    }

    fn run(mut self) -> Result<(), Violation> {
        let result = self.events();
        result.map_err(|why| format!("{why}\n{}", self.log.join("\n")))
    }

    fn events(&mut self) -> Result<(), Violation> {
        for daemon in DAEMONS {
            self.daemons.start(daemon);
            (0..2).for_each(|input| drop(self.daemons.deliver(daemon, input)));
        }
        self.look()?;
        for _ in 0..N_EVENTS {
            self.event()?;
            self.look()?;
            self.check_answers()?;
        }
        self.calm()
    }

    fn note(&mut self, what: String) {
        self.log.push(what);
    }

    /// Something happens.
    fn event(&mut self) -> Result<(), Violation> {
        let daemon = DAEMONS[self.dice.below(DAEMONS.len())];
        match self.dice.below(20) {
            0..8 => self.work(daemon),
            8..10 => {
                let ms = self.dice.below(5_000) as i64;
                self.note(format!("{ms} ms pass"));
                self.clock.pass(ms);
            }
            10 => self.kill(daemon),
            11 => {
                let is_full = self.dice.one_in(2);
                self.note(format!("memory is full: {is_full}"));
                self.daemons.shared.bus.set_full(is_full);
            }
            12 => {
                let (n, dies) = (self.dice.below(3), self.dice.one_in(2));
                self.note(format!("publication {n} {}", if dies { "kills" } else { "fails" }));
                if dies {
                    self.daemons.shared.bus.die_at_publish_after(Some(n));
                } else {
                    self.daemons.shared.bus.fail_publish_after(n);
                }
            }
            13 | 14 => {
                let death = self.dice.one_in(2).then(|| (self.dice.below(6) as u32, self.dice.one_in(2)));
                let faults = DiskFaults {
                    is_full: death.is_none() && self.dice.one_in(2),
                    death,
                    loses_way_back: self.fault == Fault::LostWayBack,
                };
                self.note(format!("{daemon}: {faults:?}"));
                self.daemons.set_faults(daemon, faults);
            }
            15 if self.dice.one_in(4) => {
                self.note("the bus is created anew".to_owned());
                self.daemons.renew_bus();
                self.reader = Reader::of(&self.daemons.shared.bus);
            }
            _ => return self.request(),
        }
        Ok(())
    }

    /// A daemon does what is to be done, or starts if it is dead.
    fn work(&mut self, daemon: Daemon) {
        if !self.daemons.is_alive(daemon) {
            let started = self.daemons.start(daemon);
            return self.note(format!("{daemon} starts: {started:?}"));
        }
        let input = self.dice.below(4);
        let end = match input {
            3 => format!("{daemon} ticks: {:?}", self.daemons.tick(daemon)),
            input => format!("{daemon} takes input {input}: {:?}", self.daemons.deliver(daemon, input)),
        };
        self.note(end);
    }

    fn kill(&mut self, daemon: Daemon) {
        self.note(format!("{daemon} dies"));
        self.daemons.kill(daemon);
        if self.fault == Fault::FallingEpoch {
            let state = &self.daemons.shared.config.state;
            let name = format!("{daemon}-epochs.json");
            for path in [name.clone(), format!("{name}.sealed"), format!("kept/{name}")] {
                let _ = std::fs::remove_file(state.join(path));
            }
        }
    }

    /// The operator asks for something.
    fn request(&mut self) -> Result<(), Violation> {
        let now_ms = self.clock.0.load(Ordering::Relaxed);
        let mut wanted = self.wanted.clone();
        if self.unanswered.is_some() {
            // He asks what is in force first, which needs all daemons.
            return Ok(());
        }
        let walls = &models().walls;
        let times = if self.dice.one_in(4) { 2 } else { 1 };
        match self.dice.below(9) {
            0..3 => {
                let at_s = START_MS / 1_000 + self.dice.below(40) as i64 * DAY_S / 2;
                wanted.plan_time = WantedTime::Fixed(at_s);
                let end = self.daemons.schedule.ask_so_often(times, ScheduleRequest::SetPlanTime { at_s });
                self.asked("set the date", end, wanted, |answer| Some(answer.state))
            }
            3 => {
                let (rate, from_s) = ([1.0, 3_600.0, 86_400.0][self.dice.below(3)], self.wanted.plan_time.at_s(now_ms));
                wanted.plan_time = WantedTime::Running { from_s, rate, since_ms: now_ms };
                let end =
                    self.daemons.schedule.ask_so_often(times, ScheduleRequest::Simulate { rate, from_s: Some(from_s) });
                self.asked("let the date run", end, wanted, |answer| Some(answer.state))
            }
            4 | 5 if wanted.progress.len() < walls.len() => {
                // Each table has a row more than the one before: its number of rows tells which one is in force.
                let row = |wall: &String| format!("{wall},2024-03-01,2024-03-{:02}\n", 1 + self.dice.below(20));
                let rows: String = walls[..=wanted.progress.len()].iter().map(row).collect();
                let table = format!("id,start,finish\n{rows}");
                wanted.progress.push(table.clone());
                let file = Some(FileText { path: "/progress.csv".into(), text: table });
                let source = ActualsSource::Reported;
                let end = self.daemons.schedule.ask_so_often(times, ScheduleRequest::SetActuals { file, source });
                self.asked("report progress", end, wanted, |answer| Some(answer.state))
            }
            4..7 => {
                wanted.progress.pop();
                let End::Done(seen) = self.daemons.schedule.ask(ScheduleRequest::GetPlanTime) else { return Ok(()) };
                let request = ScheduleRequest::UndoActuals { table: seen.table.unwrap_or_default() };
                let end = self.daemons.schedule.ask_so_often(times, request);
                self.asked("take progress back", end, wanted, |answer| Some(answer.state))
            }
            7 => {
                wanted.robot = self.dice.below(ROBOTS.len());
                let request = RasterizeRequest::SetRobot { profile: profile(wanted.robot) };
                let end = self.daemons.rasterize.ask_so_often(times, request);
                self.asked("set the robot", end, wanted, |answer| Some(answer.grids))
            }
            _ if self.dice.one_in(3) => {
                let model = self.dice.below(3);
                wanted.model = model;
                let models = vec![models().paths[model].clone()];
                let end = self
                    .daemons
                    .ingest
                    .ask_so_often(times, IngestRequest::Load { models, dry_run: false, force: true });
                let is_in_force = |effect| effect == RevisionEffect::InForce;
                assert!(!matches!(&end, End::Done(answer) if !is_in_force(answer.effect)), "{end:?}");
                self.asked("load a model", end, wanted, |answer| Some(answer.site))
            }
            _ => {
                let none = WaypointRequest::SetWaypoints { options: None, spaces: Vec::new(), changed_since_s: None };
                let end = self.daemons.waypoints.ask_so_often(times, none);
                self.asked("plan waypoints", end, wanted, |_| None)
            }
        }
    }

    /// What came of a request. Who has an answer finds on the bus what it says.
    fn asked<A: std::fmt::Debug>(
        &mut self,
        what: &str,
        end: End<A>,
        wanted: Wanted,
        published: impl Fn(&A) -> Option<Published>,
    ) -> Result<(), Violation> {
        self.note(format!("{what}: {end:?}"));
        match end {
            End::Done(answer) => {
                self.wanted = wanted;
                let published = published(&answer).filter(|published| published.epoch > 0);
                self.look()?;
                let is_there = |published: &Published| {
                    self.epochs.values().any(|seen| *seen == (published.epoch, published.content_hash))
                };
                match published {
                    // A site that has no room yet is in force and comes later.
                    Some(published) if what != "load a model" && !is_there(&published) => {
                        Err(format!("the answer names {published:?}, which is not on the bus: {:?}", self.epochs))
                    }
                    _ => Ok(()),
                }
            }
            End::Failed(why) if why.contains("cannot be taken back") => {
                self.unanswered = Some(wanted);
                Ok(())
            }
            End::Failed(_) => Ok(()),
            End::Died => {
                self.unanswered = Some(wanted);
                Ok(())
            }
        }
    }

    /// A reader looks at the bus: no epoch falls, and what it takes for a set belongs together.
    fn look(&mut self) -> Result<(), Violation> {
        let Reader { topics: names, sets, newest } = &mut self.reader;
        for subscriber in names {
            let sample = subscriber.take().map_err(|why| daemon::chain(&why))?;
            let Some(sample) = sample else { continue };
            let (topic, header) = (sample.topic(), *sample.header());
            let seen = (header.epoch, header.content_hash);
            let before = self.epochs.insert(topic, seen);
            if before.is_some_and(|before| seen.0 < before.0 || (seen.0 == before.0 && seen.1 != before.1)) {
                return Err(format!("epochs of {topic} fall: {seen:?} after {before:?}"));
            }
            match topic {
                TopicName::Site => newest.site = sample.of(topics::Site).map(|s| s.check().unwrap()),
                TopicName::ScheduleState => {
                    newest.state = sample.of(topics::ScheduleState).map(|s| s.check().unwrap());
                }
                TopicName::Grid(slot) => drop(newest.grids.insert(slot.index(), header.content_hash)),
                TopicName::Grids => {
                    newest.robot = sample.of(topics::Grids).map(|s| s.check().unwrap().view().head.robot);
                }
                _ => {}
            }
        }
        sets.take().map_err(|why| daemon::chain(&why))?;
        if self.fault == Fault::MixedSet {
            let Newest { site: Some(site), state: Some(state), grids, robot: Some(robot) } = newest else {
                return Ok(());
            };
            let grids: Vec<ContentHash> = grids.values().copied().collect();
            return check_set(site, state, robot, &grids);
        }
        let Some(set) = sets.set() else { return Ok(()) };
        set.views().map_err(|why| format!("a set is of two sites: {}", daemon::chain(&why)))?;
        let grids: Vec<ContentHash> = set.grids.iter().map(|grid| grid.content_hash()).collect();
        check_set(set.site, set.state, &set.index.view().head.robot, &grids)
    }

    /// The daemons have in force what was answered, whoever died since.
    fn check_answers(&mut self) -> Result<(), Violation> {
        let now_ms = self.clock.0.load(Ordering::Relaxed);
        let Some(schedule) = self.daemons.schedule.facts() else { return Ok(()) };
        let (Some(rasterize), Some(ingest)) = (self.daemons.rasterize.facts(), self.daemons.ingest.facts()) else {
            return Ok(());
        };
        let is_so = |wanted: &Wanted| {
            let model = ingest.models.first().map(|model| model.path.as_path());
            schedule.plan_time_s == Some(wanted.plan_time.at_s(now_ms))
                && schedule.clock == wanted.plan_time.words()
                && schedule.progress.reported == wanted.progress.len()
                && rasterize.robot == ROBOTS[wanted.robot]
                && model == Some(&models().paths[wanted.model])
        };
        let is_as_before = is_so(&self.wanted);
        if let Some(unanswered) = self.unanswered.take_if(|unanswered| is_so(unanswered)) {
            // Two dates that run may be told apart later only.
            if is_as_before && unanswered != self.wanted {
                self.unanswered = Some(unanswered);
                return Ok(());
            }
            self.wanted = unanswered;
        } else if !is_as_before {
            return Err(format!(
                "wanted {:?}, in force {:?} {:?} {:?} {:?}",
                self.wanted, schedule.plan_time_s, schedule.progress, rasterize.robot, ingest.models
            ));
        }
        self.unanswered = None;
        Ok(())
    }

    /// No more faults: all daemons run, and do what is to be done until nothing is.
    fn calm(&mut self) -> Result<(), Violation> {
        self.note("calm".to_owned());
        self.daemons.shared.bus.set_full(false);
        self.daemons.shared.bus.die_at_publish_after(None);
        for daemon in DAEMONS {
            self.daemons.set_faults(daemon, DiskFaults::default());
        }
        // Files are read again at two looks, and a publication that was to fail fails for somebody.
        for round in 0..8 {
            self.clock.pass(if round < 4 { 1_500 } else { 0 });
            for daemon in DAEMONS {
                self.daemons.start(daemon);
                let ticked = self.daemons.tick(daemon);
                self.note(format!("{daemon} ticks: {ticked:?}"));
                for input in 0..3 {
                    let taken = self.daemons.deliver(daemon, input);
                    self.note(format!("{daemon} takes input {input}: {taken:?}"));
                }
                self.look()?;
            }
        }
        self.check_answers()?;
        self.check_site()
    }

    /// The site is what its operator asked for: what a conversion of the model would be.
    fn check_site(&mut self) -> Result<(), Violation> {
        let set = self.reader.sets.set().ok_or("what is on the bus does not belong together")?;
        let Wanted { plan_time, robot, progress, .. } = &self.wanted;
        let site = set.site.view();
        let rules = Rules::parse(RULES).unwrap();
        let actuals = progress.last().map_or_else(Vec::new, |table| parse_actuals(table.as_bytes()).unwrap());
        let overrides = Overrides { actuals, is_of_earlier_revision: true, ..Overrides::default() };
        let timeline = evaluate(&site, &rules, &overrides).unwrap();
        let now_s = plan_time.at_s(self.clock.0.load(Ordering::Relaxed));
        let shown_s = match plan_time {
            WantedTime::Fixed(at_s) => *at_s,
            WantedTime::Running { .. } => {
                let updates = timeline.update_instants_s();
                let past = updates.iter().rev().find(|update| **update <= now_s);
                past.copied().or(updates.first().map(|first| first - 1)).unwrap_or(now_s)
            }
        };
        let expected = timeline.schedule_state_at(Some(shown_s)).finish();
        if ScheduleState::open(expected.bytes()).unwrap().content_hash() != set.state.content_hash() {
            let shown = set.state.view().head.plan_time_s;
            return Err(format!("the schedule state is not that of {shown_s}, its plan time is {shown}"));
        }
        if set.index.view().head.robot != Robot::of((*robot > 0).then(|| profile(*robot)).as_ref()).unwrap().profile {
            return Err(format!("the maps are not for the robot {}", ROBOTS[*robot]));
        }
        set.mission_plan.map(drop).ok_or_else(|| "no mission plan is of these maps".to_owned())
    }
}

/// The grids of a set are those that a conversion of its site draws at its schedule state for its robot.
fn check_set(
    site: &CheckedSample<topics::Site>,
    state: &CheckedSample<topics::ScheduleState>,
    robot: &RobotProfile,
    grids: &[ContentHash],
) -> Result<(), Violation> {
    type Drawn = Mutex<HashMap<(ContentHash, ContentHash, u32), Vec<ContentHash>>>;
    static DRAWN: OnceLock<Drawn> = OnceLock::new();
    let key = (
        site.content_hash(),
        state.content_hash(),
        robot.radius_m.to_bits() as u32 ^ (robot.radius_m.to_bits() >> 32) as u32,
    );
    let drawn = DRAWN.get_or_init(Drawn::default);
    let known = drawn.lock().unwrap().get(&key).cloned();
    let expected = known.unwrap_or_else(|| {
        let mut rasterizer = Rasterizer::new(&site.view(), robot, RESOLUTION_M).unwrap();
        if state.view().check_site(&site.view()).is_ok() {
            rasterizer.draw(&site.view(), &state.view());
        }
        let hashes: Vec<ContentHash> = rasterizer.drawn().map(|grid| grid.content_hash).collect();
        drawn.lock().unwrap().insert(key, hashes.clone());
        hashes
    });
    if grids == expected {
        Ok(())
    } else {
        Err("grids that are not of their site and schedule state are taken for a set".to_owned())
    }
}

/// The first seed whose history goes wrong, and how.
fn first_violation(fault: Fault, n_histories: u64) -> Option<(u64, Violation)> {
    // A process that dies is no failure of the test.
    static QUIET: OnceLock<()> = OnceLock::new();
    QUIET.get_or_init(|| {
        let told = std::panic::take_hook();
        std::panic::set_hook(Box::new(move |panic| {
            if panic.payload().downcast_ref::<&str>().is_some() || panic.payload().downcast_ref::<String>().is_some() {
                told(panic);
            }
        }));
    });
    let (next, found) = (AtomicU64::new(0), Mutex::new(None));
    std::thread::scope(|scope| {
        for _ in 0..std::thread::available_parallelism().map_or(1, usize::from) {
            scope.spawn(|| {
                while found.lock().unwrap().is_none() {
                    let seed = next.fetch_add(1, Ordering::Relaxed);
                    if seed >= n_histories {
                        return;
                    }
                    if let Err(why) = History::new(seed, fault).run() {
                        found.lock().unwrap().get_or_insert((seed, why));
                    }
                }
            });
        }
    });
    found.into_inner().unwrap()
}

#[test]
fn no_history_mixes_what_does_not_belong_together_or_makes_an_answer_false() {
    if let Some((seed, why)) = first_violation(Fault::None, N_HISTORIES) {
        panic!("seed {seed}: {why}");
    }
}

#[test]
fn faults_that_are_put_in_are_found() {
    let expected =
        [(Fault::LostWayBack, "wanted"), (Fault::MixedSet, "taken for a set"), (Fault::FallingEpoch, "epoch")];
    for (fault, told) in expected {
        let (seed, why) =
            first_violation(fault, N_HISTORIES_OF_FAULT).unwrap_or_else(|| panic!("{fault:?} is not found"));
        assert!(why.contains(told), "{fault:?}, seed {seed}: {why}");
    }
}
