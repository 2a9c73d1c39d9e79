//! The daemons of a site in one process: their rules and what commits them, on a bus, a disk and a clock that a test drives.
//!
//! A process is its rules with a disk of its own. It dies where a test wants it, by a panic that is caught, and starts again with what is
//! on disk. Nothing happens by itself: a test says who takes a sample, who looks at its clock, who is asked.

#![expect(clippy::unwrap_used, reason = "a simulation panics where it fails")]

pub mod replicas;
pub mod simulated_store;

use bus::{Bus, Daemon, DeathAtLoan, InProcessBus, RawSubscriber, RobotName};
use daemon::{
    Asked, Caller, Clock, Committed, CurrentActivity, Decide, Disk, Event, Failure, FileText, HistoryEvent, Input,
    MachineTime, Reporter, Request, Save, ScheduleRequest, ScheduleVerdict, Service, SiteConfig, Standing, StateError,
    StateFolder,
};
use ifc_ingest::judge::Judge;
use ifc_ingest::service::Ingest;
use messages::ContentHash;
use rasterize::service::Rasterize;
use schedule_eval::service::ScheduleEval;
use slam_align::background_worker::{Outcome, Worker};
use slam_align::job::{Job, JobResult};
use slam_align::service::SlamAlign;
use std::panic::{AssertUnwindSafe, catch_unwind, panic_any, resume_unwind};
use std::path::Path;
use std::sync::atomic::{AtomicI64, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex};
use waypoint_gen::service::WaypointGen;

/// The end of a process, as a panic.
struct Death;

/// A clock that a test sets: milliseconds since 1970 in UTC.
#[derive(Clone)]
pub struct SimulatedClock(pub Arc<AtomicI64>);

impl SimulatedClock {
    /// Lets time pass.
    pub fn pass(&self, ms: i64) {
        self.0.fetch_add(ms, Ordering::Relaxed);
    }
}

impl Clock for SimulatedClock {
    fn now(&self) -> MachineTime {
        let wall_ms = self.0.load(Ordering::Relaxed);
        MachineTime { wall_ms, since_boot_ms: wall_ms, boot: Some(1) }
    }
}

/// What happens to a disk.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct DiskFaults {
    /// No write succeeds.
    pub is_full: bool,
    /// The process dies at the write after so many: before it, or right after it.
    pub death: Option<(u32, bool)>,
    /// What is taken back after a failure is not written: a fault that the test puts in.
    pub loses_way_back: bool,
}

/// The disk of one daemon: files in memory, and what happens to them.
#[derive(Clone)]
struct SimulatedDisk {
    state: Arc<Mutex<StateFolder>>,
    faults: Arc<Mutex<DiskFaults>>,
}

impl DiskFaults {
    /// A write: whether its process dies of it, and if so, whether after it.
    fn write(&mut self) -> Option<bool> {
        let (left, is_after) = self.death.as_mut()?;
        if *left == 0 {
            return Some(*is_after);
        }
        *left -= 1;
        None
    }
}

/// A write of a process, which may die before it or after it.
fn mortal<T, E>(faults: &Mutex<DiskFaults>, write: impl FnOnce() -> Result<T, E>) -> Result<T, E> {
    let dies = faults.lock().unwrap().write();
    if dies == Some(false) {
        panic_any(Death);
    }
    let written = write()?;
    if dies == Some(true) {
        panic_any(Death);
    }
    Ok(written)
}

impl SimulatedDisk {
    /// The state folder of a process.
    fn of(config: &SiteConfig, faults: &Arc<Mutex<DiskFaults>>) -> Self {
        Self { state: Arc::new(Mutex::new(StateFolder::at(&config.state))), faults: Arc::clone(faults) }
    }

    fn full() -> StateError {
        StateError::Io { path: "state".into(), source: std::io::ErrorKind::StorageFull.into() }
    }

    /// A step of the disk, on which the process may die.
    fn step(&self, write: impl FnOnce() -> Result<(), StateError>) -> Result<(), StateError> {
        if self.faults.lock().unwrap().is_full {
            return Err(Self::full());
        }
        mortal(&self.faults, write)
    }
}

impl Disk for SimulatedDisk {
    fn write(&mut self, save: &Save) -> Result<(), StateError> {
        self.step(|| save.write())
    }

    fn take_back(&mut self, save: &Save) -> Result<(), StateError> {
        if self.faults.lock().unwrap().loses_way_back { Ok(()) } else { self.step(|| save.write()) }
    }

    fn record(&mut self, event: HistoryEvent) -> Result<(), StateError> {
        self.step(|| self.state.lock().unwrap().record(event))
    }
}

/// What came of an event.
#[derive(Debug)]
pub enum End<T> {
    /// It was done.
    Done(T),
    /// It was refused or failed; why.
    Failed(String),
    /// It is under way: [`Process::late_answer`] comes.
    Waits,
    /// The process died.
    Died,
}

/// A daemon that runs.
struct Running<D: Decide> {
    service: Committed<D>,
    subscribers: Vec<RawSubscriber>,
}

/// Starts the rules of a process.
type Start<D> = dyn Fn(&SiteConfig, CurrentActivity) -> Result<Committed<D>, Failure> + Send;

/// A process that may run, and its disk.
pub struct Process<D: Decide> {
    start: Box<Start<D>>,
    running: Option<Running<D>>,
    /// What happens to its disk.
    pub faults: Arc<Mutex<DiskFaults>>,
}

impl<D: Decide> Process<D> {
    fn new(start: impl Fn(&SiteConfig, CurrentActivity) -> Result<Committed<D>, Failure> + Send + 'static) -> Self {
        Self { start: Box::new(start), running: None, faults: Arc::default() }
    }

    /// True while it runs.
    pub fn is_alive(&self) -> bool {
        self.running.is_some()
    }

    /// It dies.
    pub fn kill(&mut self) {
        self.running = None;
    }

    /// Starts the process if it does not run; it joins the bus.
    fn start(&mut self, site: &Circumstances) -> End<()> {
        self.start_on(&site.config, &site.bus, Box::new(site.clock.clone()))
    }

    /// The same with a clock of its own.
    fn start_on(&mut self, config: &SiteConfig, bus: &InProcessBus, clock: Box<dyn Clock>) -> End<()> {
        if self.running.is_some() {
            return End::Done(());
        }
        let disk = SimulatedDisk::of(config, &self.faults);
        let made = (self.start)(config, CurrentActivity::default());
        let service = match made {
            Ok(service) => service.driven_by(Box::new(disk), clock),
            Err(why) => return End::Failed(daemon::chain(why.as_ref())),
        };
        self.running = Some(Running { service, subscribers: Vec::new() });
        self.join(bus, config.robot_name)
    }

    /// Joins a generation of the bus, with a robot that has a name if it is one of a robot.
    fn join(&mut self, bus: &InProcessBus, robot: Option<RobotName>) -> End<()> {
        self.step(|running| {
            let bus = match robot {
                Some(robot) => Bus::in_process_of_robot(bus, D::Request::DAEMON, robot),
                None => Bus::in_process(bus, D::Request::DAEMON),
            };
            running.subscribers =
                D::Input::TOPICS.iter().map(|topic| bus.raw_subscriber(*topic)).collect::<Result<_, _>>()?;
            running.service.attach(&bus).expect("a bus inside one process refuses no daemon");
            running.service.handle(Event::Attached).map(drop)
        })
    }

    /// Something that the process does; it may die of it.
    fn step<T>(&mut self, act: impl FnOnce(&mut Running<D>) -> Result<T, Failure>) -> End<T> {
        let Some(running) = &mut self.running else { return End::Died };
        match catch_unwind(AssertUnwindSafe(|| act(running))) {
            Ok(Ok(done)) => End::Done(done),
            Ok(Err(why)) => End::Failed(daemon::chain(why.as_ref())),
            Err(panic) if panic.is::<Death>() || panic.is::<DeathAtLoan>() => {
                self.faults.lock().unwrap().death = None;
                self.running = None;
                End::Died
            }
            Err(panic) => resume_unwind(panic),
        }
    }

    /// Gives it the newest sample of one of its inputs; true if there was one.
    pub fn deliver(&mut self, input: usize) -> End<bool> {
        self.step(|running| {
            let n = running.subscribers.len().max(1);
            let Some(subscriber) = running.subscribers.get(input % n) else { return Ok(false) };
            let Some(sample) = subscriber.take()? else { return Ok(false) };
            let input = D::Input::check(sample)?;
            running.service.handle(Event::Input(input)).map(|_| true)
        })
    }

    /// A heartbeat has passed.
    pub fn tick(&mut self) -> End<()> {
        self.step(|running| running.service.handle(Event::Tick).map(drop))
    }

    /// Asks it for something.
    pub fn ask(&mut self, request: D::Request) -> End<<D::Request as Request>::Answer> {
        let asked = Asked { by: Caller { uid: 7 }, reporter: Reporter::default() };
        match self.step(|running| Ok(running.service.answer(request, &asked)?.answer)) {
            End::Done(Some(answer)) => End::Done(answer),
            End::Done(None) | End::Waits => End::Waits,
            End::Failed(why) => End::Failed(why),
            End::Died => End::Died,
        }
    }

    /// What came of a request that waited; `None` as long as it does, [`End::Died`] if its process is gone.
    pub fn late_answer(&mut self) -> Option<End<<D::Request as Request>::Answer>> {
        let Some(running) = &mut self.running else { return Some(End::Died) };
        Some(match running.service.late_answer()? {
            Ok(answer) => End::Done(answer),
            Err(why) => End::Failed(daemon::chain(why.as_ref())),
        })
    }

    /// Asks it for the same so often, as a client does whose answers were lost; the last answer. What is in force is not known if it
    /// fails after it was done.
    pub fn ask_so_often(&mut self, times: u32, request: D::Request) -> End<<D::Request as Request>::Answer>
    where
        D::Request: Clone,
    {
        let times = if request.may_be_sent_twice() { times } else { 1 };
        let mut end = self.ask(request.clone());
        for _ in 1..times {
            let End::Done(_) = end else { return end };
            end = match self.ask(request.clone()) {
                End::Failed(_) => End::Died,
                again => again,
            };
        }
        end
    }

    /// What an operator has to see of it; nothing if it is dead.
    pub fn standing(&self) -> Option<Standing> {
        self.running.as_ref().map(|running| running.service.standing())
    }

    /// What it tells of itself; nothing if it is dead.
    pub fn facts(&self) -> Option<D::Facts> {
        self.running.as_ref().map(|running| running.service.facts())
    }
}

/// The worker of slam-align, and what schedule-eval has from it.
#[derive(Clone, Default)]
pub struct Aligner(Arc<Mutex<AlignerEnds>>);

#[derive(Default)]
struct AlignerEnds {
    jobs: Option<Receiver<Job>>,
    outcomes: Option<Sender<Outcome<Job, JobResult>>>,
    table: Option<String>,
    takes_no_tables: bool,
}

impl Aligner {
    /// A process of slam-align starts with a worker of its own.
    fn start(&self, config: &SiteConfig, activity: CurrentActivity) -> Result<Committed<SlamAlign>, Failure> {
        let ((to_worker, jobs), (done, outcomes)) = (channel(), channel());
        let mut ends = self.0.lock().unwrap();
        (ends.jobs, ends.outcomes) = (Some(jobs), Some(done));
        drop(ends);
        let schedule = self.clone();
        let give = move |_: &Bus, FileText { text, .. }: FileText, _: bool| {
            let mut ends = schedule.0.lock().unwrap();
            if ends.takes_no_tables {
                return Err("schedule-eval takes no tables".into());
            }
            ends.table = Some(text);
            Ok(())
        };
        SlamAlign::start_with(config, activity, Worker { jobs: to_worker, outcomes }, Box::new(give))
    }

    /// The worker ends its job; false if it has none.
    pub fn finish(&self, work: impl FnOnce(&Job) -> Result<JobResult, Failure>) -> bool {
        let ends = self.0.lock().unwrap();
        let (Some(jobs), Some(outcomes)) = (&ends.jobs, &ends.outcomes) else { return false };
        let Ok(job) = jobs.try_recv() else { return false };
        let result = work(&job);
        outcomes.send(Outcome { job, result }).is_ok()
    }

    /// From now on schedule-eval takes no tables of slam-align, or takes them again.
    pub fn take_tables(&self, takes: bool) {
        self.0.lock().unwrap().takes_no_tables = !takes;
    }

    /// The table that it took last; `None` for none.
    pub fn table(&self) -> Option<String> {
        self.0.lock().unwrap().table.clone()
    }
}

/// What all daemons of a site share.
pub struct Circumstances {
    /// The configuration.
    pub config: SiteConfig,
    /// The bus.
    pub bus: InProcessBus,
    /// The machine's clock.
    pub clock: SimulatedClock,
}

/// What schedule-eval has said of a candidate, on its way to ifc-ingest.
#[derive(Clone, Default)]
struct Verdicts(Arc<Mutex<Option<ScheduleVerdict>>>);

impl Judge for Verdicts {
    fn attach(&mut self, _: &Bus) {}

    fn verdict(&mut self, site_hash: ContentHash) -> Option<ScheduleVerdict> {
        self.0.lock().unwrap().clone().filter(|verdict| verdict.site_hash == site_hash)
    }

    fn rest(&mut self) {}
}

/// The daemons of a site.
pub struct Daemons {
    /// What they share.
    pub shared: Circumstances,
    /// Reads models.
    pub ingest: Process<Ingest>,
    /// Holds the plan time.
    pub schedule: Process<ScheduleEval>,
    /// Draws grids.
    pub rasterize: Process<Rasterize>,
    /// Plans waypoints.
    pub waypoints: Process<WaypointGen>,
    verdicts: Verdicts,
    /// Follows the robot's map.
    pub align: Process<SlamAlign>,
    /// Its worker.
    pub aligner: Aligner,
}

/// Those that take part.
pub const DAEMONS: [Daemon; 5] =
    [Daemon::IfcIngest, Daemon::ScheduleEval, Daemon::Rasterize, Daemon::WaypointGen, Daemon::SlamAlign];

/// The same step of a daemon, whichever it is.
macro_rules! each {
    ($daemons:ident, $daemon:expr, |$process:ident| $step:expr) => {
        match $daemon {
            Daemon::IfcIngest => {
                let $process = &mut $daemons.ingest;
                $step
            }
            Daemon::ScheduleEval => {
                let $process = &mut $daemons.schedule;
                $step
            }
            Daemon::Rasterize => {
                let $process = &mut $daemons.rasterize;
                $step
            }
            Daemon::WaypointGen => {
                let $process = &mut $daemons.waypoints;
                $step
            }
            Daemon::SlamAlign => {
                let $process = &mut $daemons.align;
                $step
            }
            other => panic!("{other} does not take part"),
        }
    };
}

impl Daemons {
    /// A site whose configuration lies in this folder, with all daemons stopped.
    pub fn of(toml: &str, home: &Path, clock: SimulatedClock) -> Self {
        Self::with(SiteConfig::parse(toml, home).unwrap(), InProcessBus::new(), clock)
    }

    /// The daemons of a robot with a name, stopped, on the bus of its site; those of the site are in `site` alone.
    pub fn of_robot(site: &Self, robot: RobotName) -> Self {
        let Circumstances { config, bus, clock } = &site.shared;
        Self::with(config.of_robot(Some(robot)).unwrap(), bus.clone(), clock.clone())
    }

    fn with(config: SiteConfig, bus: InProcessBus, clock: SimulatedClock) -> Self {
        let verdicts = Verdicts::default();
        let judge = verdicts.clone();
        let aligner = Aligner::default();
        let of_process = aligner.clone();
        Self {
            verdicts,
            shared: Circumstances { config, bus, clock },
            ingest: Process::new(move |config, activity| {
                Ingest::start_judged(config, activity, Box::new(judge.clone()))
            }),
            schedule: Process::new(ScheduleEval::start),
            rasterize: Process::new(Rasterize::start),
            waypoints: Process::new(WaypointGen::start),
            align: Process::new(move |config, activity| of_process.start(config, activity)),
            aligner,
        }
    }

    /// True while a daemon runs.
    pub fn is_alive(&mut self, daemon: Daemon) -> bool {
        each!(self, daemon, |process| process.is_alive())
    }

    /// Starts a daemon, if it does not run.
    pub fn start(&mut self, daemon: Daemon) -> End<()> {
        let Self { shared, .. } = self;
        each!(self, daemon, |process| process.start(shared))
    }

    /// A daemon dies.
    pub fn kill(&mut self, daemon: Daemon) {
        each!(self, daemon, |process| process.kill());
    }

    /// Gives a daemon the newest sample of one of its inputs; true if there was one.
    pub fn deliver(&mut self, daemon: Daemon, input: usize) -> End<bool> {
        each!(self, daemon, |process| process.deliver(input))
    }

    /// A heartbeat of a daemon has passed.
    pub fn tick(&mut self, daemon: Daemon) -> End<()> {
        if daemon == Daemon::IfcIngest {
            let verdict = match self.schedule.ask(ScheduleRequest::GetVerdict) {
                End::Done(answer) => answer.verdict,
                _ => None,
            };
            *self.verdicts.0.lock().unwrap() = verdict;
        }
        each!(self, daemon, |process| process.tick())
    }

    /// Sets what happens to the disk of a daemon.
    pub fn set_faults(&mut self, daemon: Daemon, faults: DiskFaults) {
        each!(self, daemon, |process| *process.faults.lock().unwrap() = faults);
    }

    /// The keeper has died: all join the next generation of the bus. What they begin with there may fail.
    pub fn renew_bus(&mut self) {
        self.shared.bus = self.shared.bus.next_generation();
        let bus = &self.shared.bus;
        for daemon in DAEMONS {
            let _: End<()> = each!(self, daemon, |process| process.join(bus, self.shared.config.robot_name));
        }
    }
}
