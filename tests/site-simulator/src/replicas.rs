//! The server of a site and the robots that follow it, each with a disk, a clock and a link to the store that a test drives.

use crate::simulated_store::{LinkFaults, Meantime, StoreLink};
use crate::{Death, DiskFaults, End, Process, SimulatedClock, SimulatedDisk, mortal};
use bus::{DeathAtLoan, InProcessBus};
use daemon::{Clock, Failure, MachineTime, ServeConfig, SiteConfig};
use site_follow::archive_folder::ArchiveDisk;
use site_follow::fetcher::Fetcher;
use site_follow::service::{SiteFollow, Surroundings};
use site_server::pieces::SetPieces;
use site_server::publication::{self, Job, Outcome, Publisher, Shared};
use std::io;
use std::panic::{AssertUnwindSafe, catch_unwind, panic_any, resume_unwind};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, Weak};
use std::time::Duration;
use store::Objects;

/// The clock of a robot: it may be off the true time, and begins anew with each boot.
#[derive(Clone)]
pub struct RobotClock {
    true_time: SimulatedClock,
    state: Arc<Mutex<RobotClockState>>,
}

/// How the clock of a robot differs from the true time.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct RobotClockState {
    /// How far it is ahead, in milliseconds.
    pub ahead_ms: i64,
    /// Which boot.
    pub boot: u64,
    /// What is added to the time since the boot, in milliseconds: a machine that counts wrong.
    pub counts_more_ms: i64,
}

impl RobotClock {
    /// A clock that is right.
    pub fn new(true_time: SimulatedClock) -> Self {
        Self { true_time, state: Arc::default() }
    }

    /// What is wrong with it, to be changed.
    pub fn change(&self, change: impl FnOnce(&mut RobotClockState)) {
        change(&mut self.state.lock().unwrap());
    }
}

impl Clock for RobotClock {
    fn now(&self) -> MachineTime {
        let (now_ms, state) = (self.true_time.now().wall_ms, *self.state.lock().unwrap());
        MachineTime {
            wall_ms: now_ms + state.ahead_ms,
            since_boot_ms: now_ms + state.counts_more_ms,
            boot: Some(state.boot),
        }
    }
}

/// What runs for as long as its process lives.
fn survives<T>(act: impl FnOnce() -> T) -> Option<T> {
    match catch_unwind(AssertUnwindSafe(act)) {
        Ok(done) => Some(done),
        Err(panic) if panic.is::<Death>() || panic.is::<DeathAtLoan>() => None,
        Err(panic) => resume_unwind(panic),
    }
}

/// Draws later sets in the place of the stages.
pub type DrawLater = Arc<dyn Fn(&Job, usize) -> Result<Vec<SetPieces>, Failure> + Send + Sync>;

/// What a server is started with.
#[derive(Clone)]
pub struct ServerStart {
    /// Its configuration: keys, how many sets ahead, how much of the past.
    pub config: ServeConfig,
    /// The configuration of its machine.
    pub site: SiteConfig,
    /// Draws later sets.
    pub draw: DrawLater,
}

/// The server of a site, which may run.
pub struct Server {
    clock: SimulatedClock,
    open: Arc<dyn Fn() -> Box<dyn Objects> + Send + Sync>,
    running: Option<(Publisher, Arc<Shared>)>,
    /// What happens to its disk, and at writes into the store.
    pub faults: Arc<Mutex<DiskFaults>>,
}

impl Server {
    /// A server that does not run, with its end of the store.
    pub fn new(
        clock: SimulatedClock,
        faults: Arc<Mutex<DiskFaults>>,
        open: Arc<dyn Fn() -> Box<dyn Objects> + Send + Sync>,
    ) -> Self {
        Self { clock, open, running: None, faults }
    }

    /// True while it runs.
    pub fn is_alive(&self) -> bool {
        self.running.is_some()
    }

    /// It dies.
    pub fn kill(&mut self) {
        self.running = None;
    }

    /// Starts it, if it does not run.
    pub fn start(&mut self, start: &ServerStart) -> End<()> {
        if self.running.is_some() {
            return End::Done(());
        }
        let (open, draw) = (Arc::clone(&self.open), Arc::clone(&start.draw));
        let surroundings = publication::Surroundings {
            open: Box::new(move || Ok(open())),
            draw: Box::new(move |job, ahead| draw(job, ahead)),
            clock: Box::new(self.clock.clone()),
            disk: Box::new(SimulatedDisk::of(&start.site, &self.faults)),
        };
        let shared = Arc::new(Shared::default());
        match Publisher::new(start.config.clone(), &start.site.state, Arc::clone(&shared), surroundings) {
            Ok(publisher) => {
                self.running = Some((publisher, shared));
                End::Done(())
            }
            Err(why) => End::Failed(daemon::chain(why.as_ref())),
        }
    }

    /// Gives it what is to be published.
    pub fn give(&self, job: Job) {
        if let Some((_, shared)) = &self.running {
            shared.give(job);
        }
    }

    /// Its thread takes a turn; it may die of it.
    pub fn step(&mut self) -> End<Outcome> {
        let Some((publisher, shared)) = &mut self.running else { return End::Died };
        match survives(|| publisher.step()) {
            Some(()) => End::Done(shared.outcome()),
            None => {
                self.faults.lock().unwrap().death = None;
                self.running = None;
                End::Died
            }
        }
    }
}

/// A robot that follows a site, and the thread that asks the store for it.
pub struct Follower {
    /// The daemon.
    pub process: Arc<Mutex<Process<SiteFollow>>>,
    /// Its bus.
    pub bus: InProcessBus,
    /// Its clock.
    pub clock: RobotClock,
    /// What happens on its link to the store.
    pub link: Arc<Mutex<LinkFaults>>,
    /// What happens to its disk.
    pub faults: Arc<Mutex<DiskFaults>>,
    config: SiteConfig,
    fetcher: Arc<Mutex<Option<Fetcher>>>,
}

/// The disk under the archives of a robot.
struct RobotDisk {
    faults: Arc<Mutex<DiskFaults>>,
    link: Arc<Mutex<LinkFaults>>,
    meantime: Meantime,
}

impl ArchiveDisk for RobotDisk {
    fn allow(&self, _: &Path) -> io::Result<()> {
        let is_interrupted = {
            let mut link = self.link.lock().unwrap();
            let is_interrupted = link.meantime & 1 == 1;
            link.meantime >>= 1;
            is_interrupted
        };
        if is_interrupted {
            (self.meantime)();
        }
        if self.faults.lock().unwrap().is_full {
            return Err(io::ErrorKind::StorageFull.into());
        }
        // Death after a change is death before the next one.
        mortal(&self.faults, || Ok(()))
    }
}

/// While the thread waits for the store or the disk, the daemon looks what is to be done; if it dies, both do.
fn look_of(process: &Weak<Mutex<Process<SiteFollow>>>) -> Meantime {
    let process = Weak::clone(process);
    Arc::new(move || {
        let Some(process) = process.upgrade() else { return };
        let end = process.lock().unwrap().tick();
        if matches!(end, End::Died) {
            panic_any(Death);
        }
    })
}

impl Follower {
    /// A robot that does not run, with this configuration and end of the store.
    pub fn new(config: SiteConfig, link: StoreLink, clock: RobotClock) -> Self {
        let fetcher: Arc<Mutex<Option<Fetcher>>> = Arc::default();
        let (faults, of_link) = (Arc::clone(&link.deaths), Arc::clone(&link.faults));
        let process = Arc::new_cyclic(|process: &Weak<Mutex<Process<SiteFollow>>>| {
            let meantime = look_of(process);
            let (of_process, clock) = (Arc::clone(&fetcher), clock.clone());
            let disk = Arc::new(RobotDisk {
                faults: Arc::clone(&faults),
                link: Arc::clone(&of_link),
                meantime: Arc::clone(&meantime),
            });
            let link = StoreLink { meantime: Some(meantime), ..link };
            let mut process = Process::new(move |config, activity| {
                let link = link.clone();
                let open = move || -> Result<Box<dyn Objects>, Failure> { Ok(Box::new(link.clone())) };
                let disk: Arc<dyn ArchiveDisk> = Arc::<RobotDisk>::clone(&disk);
                let surroundings = Surroundings { open: Box::new(open), clock: Box::new(clock.clone()), disk };
                let (service, fetcher) = SiteFollow::within(config, activity, surroundings)?;
                *of_process.lock().unwrap() = Some(fetcher);
                Ok(service)
            });
            process.faults = Arc::clone(&faults);
            Mutex::new(process)
        });
        Self { process, bus: InProcessBus::new(), clock, link: of_link, faults, config, fetcher }
    }

    /// Its state folder.
    pub fn state(&self) -> PathBuf {
        self.config.state.clone()
    }

    /// True while it runs.
    pub fn is_alive(&self) -> bool {
        self.process.lock().unwrap().is_alive()
    }

    /// It dies.
    pub fn kill(&mut self) {
        self.process.lock().unwrap().kill();
        *self.fetcher.lock().unwrap() = None;
    }

    /// Starts it, if it does not run.
    pub fn start(&mut self) -> End<()> {
        let clock = Box::new(self.clock.clone());
        self.process.lock().unwrap().start_on(&self.config, &self.bus, clock)
    }

    /// The keeper of its bus has died: it joins the next generation.
    pub fn renew_bus(&mut self) -> End<()> {
        self.bus = self.bus.next_generation();
        self.process.lock().unwrap().join(&self.bus, None)
    }

    /// A heartbeat has passed, or something woke it.
    pub fn tick(&mut self) -> End<()> {
        self.process.lock().unwrap().tick()
    }

    /// Its thread takes a turn; the process may die of it.
    pub fn ask(&mut self) -> End<Duration> {
        let fetcher = self.fetcher.lock().unwrap().take();
        let Some(mut fetcher) = fetcher.filter(|_| self.is_alive()) else { return End::Died };
        match survives(|| fetcher.step()) {
            Some(wait) => {
                *self.fetcher.lock().unwrap() = Some(fetcher);
                End::Done(wait)
            }
            None => {
                self.faults.lock().unwrap().death = None;
                drop(fetcher);
                self.kill();
                End::Died
            }
        }
    }
}
