//! A whole site in one process, from a seed: dates, revisions, progress, robots, full memory, full disks, deaths after every step.
//! A robot publishes maps, their searches end, the operator confirms poses and absences, and takes that back.
//! After each event what is seen on the bus belongs together, no epoch falls, and answers are true; when all is calm again the site
//! is what its operator asked for.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

#[path = "support/models.rs"]
mod models;
#[path = "support/robot.rs"]
#[expect(dead_code, reason = "other tests use the rest of it")]
mod robot;
#[path = "support/seeds.rs"]
mod seeds;

use bus::{Bus, CheckedSample, Daemon, GridSlot, RawSubscriber, TopicName, topics};
use daemon::facts::Pose;
use daemon::{
    ActualsSource, AlignAnswer, AlignRequest, Confirmations, FileText, IngestRequest, KnownPlaces, ListedPose,
    Published, RasterizeRequest, RevisionEffect, Robot, ScheduleRequest, WaypointRequest,
};
use messages::{ContentHash, RobotProfile, ScheduleState};
use models::{RESOLUTION_M, RULES, START_MS, copy_folder, models, toml};
use raster::Rasterizer;
use robot::{N_MAPS, TRUE_POSE, accepted, east_wall, result_of};
use schedule::{Overrides, Rules, evaluate, parse_actuals};
use seeds::{Dice, Violation, first_violation};
use serde_json::Value;
use site_simulator::{DAEMONS, Daemons, DiskFaults, End, SimulatedClock};
use site_view::SiteSetReader;
use std::collections::{BTreeMap, HashMap};
use std::sync::atomic::{AtomicI64, Ordering};
use std::sync::{Arc, Mutex, OnceLock};

/// Histories of the test, and events of each.
const N_HISTORIES: u64 = 10_000;
const N_EVENTS: usize = 20;
/// Histories in which each fault that is put in must be found.
const N_HISTORIES_OF_FAULT: u64 = 2_000;

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

/// What the operator has asked for.
#[derive(Debug, Clone, PartialEq)]
struct Wanted {
    plan_time: WantedTime,
    robot: usize,
    /// Tables of reported progress, the last one in force.
    progress: Vec<String>,
    model: usize,
    /// A pose of the SLAM map is confirmed, and can be taken back.
    has_confirmed_pose: bool,
    /// An absence is confirmed. A robot that sees the element again takes that back.
    has_confirmed_absence: bool,
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
    alignment: Option<CheckedSample<topics::Alignment>>,
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
            TopicName::Alignment,
            TopicName::Deviations,
        ];
        let topics = names.into_iter().map(|name| bus.raw_subscriber(name).unwrap()).collect();
        Self { topics, sets: SiteSetReader::of(&bus).unwrap(), newest: Newest::default() }
    }
}

/// A site with its operator.
struct History {
    dice: Dice,
    fault: Fault,
    _home: tempfile::TempDir,
    daemons: Daemons,
    clock: SimulatedClock,
    reader: Reader,
    robot: robot::Robot,
    /// A robot takes part in every eighth history.
    has_robot: bool,
    /// True if slam-align has done something since it was asked what is in force.
    is_align_touched: bool,
    /// Highest epoch of each topic, and the hash of its content.
    epochs: BTreeMap<TopicName, (u64, ContentHash)>,
    wanted: Wanted,
    /// What a request asked for whose process died before it answered: either may be in force.
    unanswered: Option<Wanted>,
    /// What a request asked for whose client waits.
    waits: Option<Wanted>,
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
        let wanted = Wanted {
            plan_time: WantedTime::Fixed(START_MS / 1_000),
            robot: 0,
            progress: Vec::new(),
            model: 0,
            has_confirmed_pose: false,
            has_confirmed_absence: false,
        };
        let robot = robot::Robot::of(&daemons.shared.bus, 0);
        let (dice, epochs) = (Dice(seed), BTreeMap::new());
        Self {
            dice,
            fault,
            _home: home,
            daemons,
            clock,
            reader,
            robot,
            has_robot: seed.is_multiple_of(8),
            is_align_touched: true,
            epochs,
            wanted,
            unanswered: None,
            waits: None,
            log: Vec::new(),
        }
    }

    fn run(mut self) -> Result<(), Violation> {
        let result = self.events();
        result.map_err(|why| format!("{why}\n{}", self.log.join("\n")))
    }

    fn events(&mut self) -> Result<(), Violation> {
        for daemon in DAEMONS {
            self.daemons.start(daemon);
            (0..3).for_each(|input| drop(self.daemons.deliver(daemon, input)));
        }
        if self.has_robot {
            self.align();
        }
        self.look()?;
        for _ in 0..N_EVENTS {
            self.event()?;
            self.look()?;
            self.check_answers()?;
        }
        self.calm()
    }

    /// All walls stand, and the map of the robot is aligned with them.
    fn align(&mut self) {
        let at_s = START_MS / 1_000 + 60 * DAY_S;
        assert!(matches!(self.daemons.schedule.ask(ScheduleRequest::SetPlanTime { at_s }), End::Done(_)));
        self.wanted.plan_time = WantedTime::Fixed(at_s);
        self.robot.publish(if self.dice.one_in(2) { N_MAPS - 1 } else { 0 });
        for daemon in DAEMONS {
            (0..4).for_each(|input| drop(self.daemons.deliver(daemon, input)));
        }
        while self.daemons.aligner.finish(|job| result_of(job, &accepted(TRUE_POSE))) {
            assert!(matches!(self.daemons.align.tick(), End::Done(())));
        }
    }

    fn note(&mut self, what: String) {
        self.log.push(what);
    }

    /// Something happens.
    fn event(&mut self) -> Result<(), Violation> {
        let daemon = DAEMONS[self.dice.below(DAEMONS.len())];
        match self.dice.below(27) {
            20.. if !self.has_robot => return self.request(),
            20 => {
                let map = self.dice.below(N_MAPS);
                self.note(format!("the robot publishes map {map}"));
                self.robot.publish(map);
                let taken = self.daemons.align.deliver(3);
                self.note(format!("slam-align takes it: {taken:?}"));
            }
            21 | 22 => self.finish_job(),
            23 if self.dice.one_in(4) => {
                let takes = self.dice.one_in(2);
                self.note(format!("schedule-eval takes tables of slam-align: {takes}"));
                self.daemons.aligner.take_tables(takes);
            }
            23.. => return self.confirm(),
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
                self.robot = robot::Robot::of(&self.daemons.shared.bus, self.robot.epoch);
            }
            _ => return self.request(),
        }
        Ok(())
    }

    /// A daemon does what is to be done, or starts if it is dead.
    fn work(&mut self, daemon: Daemon) {
        self.is_align_touched |= daemon == Daemon::SlamAlign;
        if !self.daemons.is_alive(daemon) {
            let started = self.daemons.start(daemon);
            return self.note(format!("{daemon} starts: {started:?}"));
        }
        let input = self.dice.below(5);
        let end = match input {
            4 => format!("{daemon} ticks: {:?}", self.daemons.tick(daemon)),
            _ if daemon == Daemon::IfcIngest => format!("{daemon} ticks: {:?}", self.daemons.tick(daemon)),
            input => format!("{daemon} takes input {input}: {:?}", self.daemons.deliver(daemon, input)),
        };
        self.note(end);
    }

    /// The worker of slam-align ends its job: a search finds the true pose, one 2 m beside it, or none.
    fn finish_job(&mut self) {
        let beside_m = [0.0, 0.0, 2.0][self.dice.below(3)];
        let mut found = accepted([TRUE_POSE[0] + beside_m, TRUE_POSE[1], TRUE_POSE[2]]);
        if self.dice.one_in(6) {
            found = alignment::Alignment::nothing_yet();
        }
        self.is_align_touched = true;
        let has_job = self.daemons.aligner.finish(|job| result_of(job, &found));
        self.note(format!("the worker ends a job: {has_job}, {beside_m} m off, {}", found.verdict.name()));
        let ticked = self.daemons.align.tick();
        self.note(format!("slam-align ticks: {ticked:?}"));
    }

    /// The operator asks slam-align for something.
    fn confirm(&mut self) -> Result<(), Violation> {
        if self.unanswered.is_some() || self.waits.is_some() || !self.daemons.align.is_alive() {
            return Ok(());
        }
        let End::Done(AlignAnswer::Confirmations(seen)) = self.daemons.align.ask(AlignRequest::ListConfirmed) else {
            return Ok(());
        };
        let mut wanted = self.wanted.clone();
        let wall = || vec![east_wall().to_owned()];
        let nowhere = ListedPose { storey: 0, map_from_slam: Pose { x_m: 9.0, y_m: 9.0, yaw_rad: 0.0 } };
        let (what, request) = match self.dice.below(6) {
            0 => ("search", AlignRequest::Align { hint: None, storey: None, places: KnownPlaces::default() }),
            1 | 2 => {
                wanted.has_confirmed_pose = true;
                ("confirm the pose", AlignRequest::ConfirmPose { waiting: seen.waiting.unwrap_or(nowhere) })
            }
            3 => {
                wanted.has_confirmed_pose = false;
                (
                    "take the pose back",
                    AlignRequest::UndoPose { before: seen.before_confirmed.map_or(nowhere, |(pose, _)| pose) },
                )
            }
            4 => {
                wanted.has_confirmed_absence = true;
                ("confirm an absence", AlignRequest::ConfirmAbsent { elements: wall() })
            }
            _ => {
                wanted.has_confirmed_absence = false;
                ("take an absence back", AlignRequest::UndoAbsent { elements: wall() })
            }
        };
        self.is_align_touched = true;
        let end = self.daemons.align.ask(request);
        if what == "search" && matches!(end, End::Done(_)) {
            self.finish_job();
        }
        self.asked(what, end, wanted, |answer| match answer {
            AlignAnswer::Pose(published) => Some(*published),
            _ => None,
        })
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
        if self.unanswered.is_some() || self.waits.is_some() {
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
                let end = self
                    .daemons
                    .schedule
                    .ask_so_often(times, ScheduleRequest::SetActuals { file, source, robot: None });
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
                let models = vec![models().paths[model].clone()];
                let dry_run = self.dice.one_in(4);
                if !dry_run {
                    wanted.model = model;
                }
                let end =
                    self.daemons.ingest.ask_so_often(times, IngestRequest::Load { models, dry_run, force: !dry_run });
                let what = if dry_run { "compare a model" } else { "load a model" };
                self.asked(what, end, wanted, |answer| (!dry_run).then_some(answer.site))
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
            End::Waits => {
                self.waits = Some(wanted);
                Ok(())
            }
            End::Died => {
                self.unanswered = Some(wanted);
                Ok(())
            }
        }
    }

    /// Takes the answer to a load that waited for it.
    fn late_answer(&mut self) -> Result<(), Violation> {
        let Some(wanted) = self.waits.take() else { return Ok(()) };
        let Some(end) = self.daemons.ingest.late_answer() else {
            self.waits = Some(wanted);
            return Ok(());
        };
        let changes_nothing = wanted == self.wanted;
        let is_as_asked =
            |effect| effect == RevisionEffect::InForce || changes_nothing && effect == RevisionEffect::DryRun;
        assert!(!matches!(&end, End::Done(answer) if !is_as_asked(answer.effect)), "{end:?}");
        self.asked("load a model", end, wanted, |answer| Some(answer.site))
    }

    /// A reader looks at the bus: no epoch falls, and what it takes for a set belongs together.
    fn look(&mut self) -> Result<(), Violation> {
        self.late_answer()?;
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
                TopicName::Alignment => {
                    let alignment = sample.of(topics::Alignment).map(|s| s.check().unwrap());
                    let says = alignment.as_ref().map(|alignment| alignment.view().head.site_hash);
                    if says != Some(header.inputs.site) {
                        return Err(format!("the alignment {seen:?} is of another site than it says"));
                    }
                    newest.alignment = alignment;
                }
                TopicName::Grids => {
                    newest.robot = sample.of(topics::Grids).map(|s| s.check().unwrap().view().head.robot);
                }
                _ => {}
            }
        }
        sets.take().map_err(|why| daemon::chain(&why))?;
        if self.fault == Fault::MixedSet {
            let Newest { site: Some(site), state: Some(state), grids, robot: Some(robot), .. } = newest else {
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

    /// What slam-align has in force, which is what it has published and saved; `None` where nothing has become of it since.
    fn confirmations(&mut self) -> Result<Option<Confirmations>, Violation> {
        if !std::mem::take(&mut self.is_align_touched) {
            return Ok(None);
        }
        let confirmations = match self.daemons.align.ask(AlignRequest::ListConfirmed) {
            End::Done(AlignAnswer::Confirmations(confirmations)) => confirmations,
            _ => return Ok(None),
        };
        let path = self.daemons.shared.config.state.join("alignment.json");
        let saved: Value = std::fs::read(path).map_or(Value::Null, |saved| serde_json::from_slice(&saved).unwrap());
        let is_saved = saved["before_confirmed"].is_array() == confirmations.before_confirmed.is_some()
            && saved["observed"]["absent"].as_array().map_or(0, Vec::len) == confirmations.absent.len();
        let told = self.daemons.align.facts().and_then(|facts| facts.alignment).and_then(|told| told.map_from_slam);
        let is_near = |pose: Pose| (saved["pose"]["map_from_slam"][0].as_f64().unwrap() - pose.x_m).abs() < 0.05;
        // What cannot be taken back from a full disk stays there until it is saved again.
        if self.unanswered.is_some() || (is_saved && told.is_none_or(is_near)) {
            return Ok(Some(confirmations));
        }
        Err(format!("slam-align has saved {saved}, in force {confirmations:?} {told:?}"))
    }

    /// The daemons have in force what was answered, whoever died since.
    fn check_answers(&mut self) -> Result<(), Violation> {
        let confirmations = self.confirmations()?;
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
                && confirmations.as_ref().is_none_or(|confirmations| {
                    confirmations.before_confirmed.is_some() == wanted.has_confirmed_pose
                        && (confirmations.absent.is_empty() || wanted.has_confirmed_absence)
                })
        };
        let is_wanted_so = is_so(&self.wanted);
        match self.unanswered.take() {
            // Two plan times that run alike differ by what is rounded: which of them is in force shows later.
            Some(unanswered) if is_so(&unanswered) && is_wanted_so && unanswered != self.wanted => {
                self.unanswered = Some(unanswered);
            }
            Some(unanswered) if is_so(&unanswered) => self.wanted = unanswered,
            _ if is_wanted_so => {}
            _ => {
                return Err(format!(
                    "wanted {:?}, in force {:?} {:?} {:?} {:?} {confirmations:?}",
                    self.wanted, schedule.plan_time_s, schedule.progress, rasterize.robot, ingest.models
                ));
            }
        }
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
        self.daemons.aligner.take_tables(true);
        // The first may be the publication that was to fail.
        (0..2).filter(|_| self.has_robot).for_each(|map| self.robot.publish(map));
        // Files are read again at two looks, and a publication that was to fail fails for somebody.
        for round in 0..6 {
            self.clock.pass(if round < 3 { 1_500 } else { 0 });
            for daemon in DAEMONS {
                self.daemons.start(daemon);
                let ticked = self.daemons.tick(daemon);
                self.note(format!("{daemon} ticks: {ticked:?}"));
                for input in 0..4 {
                    let taken = self.daemons.deliver(daemon, input);
                    self.note(format!("{daemon} takes input {input}: {taken:?}"));
                }
                self.look()?;
            }
        }
        while self.daemons.aligner.finish(|job| result_of(job, &accepted(TRUE_POSE))) {
            let ticked = self.daemons.align.tick();
            self.note(format!("slam-align ends a job: {ticked:?}"));
        }
        // What the last of them has shown goes to schedule-eval.
        let ticked = self.daemons.align.tick();
        self.note(format!("slam-align ticks: {ticked:?}"));
        self.look()?;
        self.is_align_touched = true;
        self.check_answers()?;
        self.is_align_touched = true;
        self.check_alignment()?;
        self.check_site()
    }

    /// What is published of the robot's map is of the site, in force and known to schedule-eval.
    fn check_alignment(&mut self) -> Result<(), Violation> {
        let absent = self.confirmations()?.map_or(0, |confirmations| confirmations.absent.len());
        let table = self.daemons.aligner.table().unwrap_or_default();
        if table.matches("absent").count() != absent {
            return Err(format!("{absent} elements are absent, and schedule-eval has {table:?}"));
        }
        let told = self.daemons.align.facts().and_then(|facts| facts.alignment);
        let Newest { site, alignment, .. } = &self.reader.newest;
        match (told, alignment, site) {
            (None, None, _) => Ok(()),
            (Some(told), Some(alignment), Some(site))
                if alignment.bytes().header().epoch == told.epoch
                    && alignment.view().head.site_hash == site.content_hash() =>
            {
                Ok(())
            }
            (told, ..) => {
                Err(format!("what is published of the robot's map is not in force, or of another site: {told:?}"))
            }
        }
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

#[test]
fn no_history_mixes_what_does_not_belong_together_or_makes_an_answer_false() {
    if let Some((seed, why)) = first_violation(N_HISTORIES, |seed| History::new(seed, Fault::None).run()) {
        panic!("seed {seed}: {why}");
    }
}

#[test]
fn faults_that_are_put_in_are_found() {
    let expected =
        [(Fault::LostWayBack, "wanted"), (Fault::MixedSet, "taken for a set"), (Fault::FallingEpoch, "epoch")];
    for (fault, told) in expected {
        let found = first_violation(N_HISTORIES_OF_FAULT, |seed| History::new(seed, fault).run());
        let (seed, why) = found.unwrap_or_else(|| panic!("{fault:?} is not found"));
        assert!(why.contains(told), "{fault:?}, seed {seed}: {why}");
    }
}
