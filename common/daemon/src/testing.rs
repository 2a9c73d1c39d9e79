//! A daemon on a thread of a test, on a bus of its own.

use crate::config::SiteConfig;
use crate::failure::Failure;
use crate::input::NoInput;
use crate::log::Log;
use crate::request::Request;
use crate::service::{Asked, CurrentActivity, Done, Event, Service};
use crate::service_loop::{Reload, ServiceLoop};
use crate::stop::{ReloadSignal, StopSignal};
use bus::{Bus, Daemon, Domain, Keeper, Waiter};
use serde::{Deserialize, Serialize};
use std::sync::Mutex;
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::time::{Duration, Instant};

/// The one deadline of every wait.
pub(crate) const DEADLINE: Duration = Duration::from_secs(60);

/// Requests of the service under test.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub(crate) enum TestRequest {
    /// Report so many steps, and answer their number.
    Count {
        /// How many.
        steps: u32,
    },
    /// Refuse.
    Refuse,
}

impl Request for TestRequest {
    const DAEMON: Daemon = Daemon::ScheduleEval;
    type Answer = u32;

    fn may_be_sent_twice(&self) -> bool {
        true
    }
}

/// Records its events.
#[derive(Default)]
pub(crate) struct RecordingService {
    pub(crate) recorded: Option<Sender<(Instant, &'static str)>>,
    pub(crate) wake_in: Option<Duration>,
    pub(crate) panics_at_tick: bool,
    /// How often it cannot attach.
    pub(crate) n_refusals: u32,
    /// If there is one, a count waits for it after the first step.
    pub(crate) gate: Option<Receiver<()>>,
}

impl RecordingService {
    fn note(&self, what: &'static str) {
        // A test that has seen enough reads no more.
        let _ = self.recorded.as_ref().map(|recorded| recorded.send((Instant::now(), what)));
    }
}

impl Service for RecordingService {
    type Input = NoInput;
    type Request = TestRequest;
    type Facts = u32;

    fn attach(&mut self, _bus: &Bus) -> Result<(), Failure> {
        let Some(left) = self.n_refusals.checked_sub(1) else { return Ok(()) };
        self.n_refusals = left;
        self.note("refused");
        Err("there is no room".into())
    }

    fn handle(&mut self, event: Event<NoInput>) -> Result<Done, Failure> {
        let what = match event {
            Event::Attached => "attached",
            Event::Tick => "tick",
            _ => "other",
        };
        self.note(what);
        assert!(!(self.panics_at_tick && what == "tick"), "as the test wants it");
        let wake_in = if what == "attached" { self.wake_in } else { None };
        Ok(Done { wake_in, ..Done::default() })
    }

    fn answer(&mut self, request: TestRequest, asked: &Asked) -> Result<Done<u32>, Failure> {
        let TestRequest::Count { steps } = request else { return Err("no".into()) };
        for step in 1..=steps {
            asked.reporter.report("counting", f64::from(step) / f64::from(steps));
            if let (1, Some(gate)) = (step, &self.gate) {
                gate.recv_timeout(DEADLINE)?;
            }
        }
        self.note("counted");
        Ok(Done::<()>::default().answered(steps))
    }

    fn facts(&self) -> u32 {
        7
    }
}

/// A running daemon.
pub(crate) struct TestDaemon {
    pub(crate) events: Receiver<(Instant, &'static str)>,
    /// Why it ended, if it did by itself.
    pub(crate) end: Receiver<String>,
    domain: Domain,
    _files: BusFiles,
}

/// Files of a bus whose daemon does not end: they go with the test.
struct BusFiles {
    prefix: String,
    _root: tempfile::TempDir,
}

impl Drop for BusFiles {
    fn drop(&mut self) {
        for entry in std::fs::read_dir("/dev/shm").into_iter().flatten().flatten() {
            if entry.file_name().to_string_lossy().starts_with(&self.prefix) {
                // The daemon may remove it at this moment.
                let _ = std::fs::remove_file(entry.path());
            }
        }
    }
}

impl TestDaemon {
    /// A client on its bus.
    pub(crate) fn client(&self) -> (Bus, Waiter) {
        let begun = Instant::now();
        loop {
            match Bus::join(&self.domain, Daemon::Groundplan) {
                Ok(joined) => return joined,
                Err(why) => assert!(begun.elapsed() < DEADLINE, "{why}"),
            }
        }
    }
}

/// Runs the service as a daemon until it ends by itself or the test process does.
pub(crate) fn spawn_daemon(service: RecordingService) -> TestDaemon {
    // One log for all tests of this process.
    static LOG: Mutex<Option<Log>> = Mutex::new(None);
    static NUMBER: AtomicU32 = AtomicU32::new(0);
    let log = LOG.lock().unwrap().get_or_insert_with(|| Log::start(&Default::default()).unwrap()).clone();
    let (recorded, events) = channel();
    let (ended, end) = channel();
    let root = tempfile::Builder::new().prefix("bus").tempdir_in("/dev/shm").unwrap();
    let prefix = format!("gl{:x}x{}_", std::process::id(), NUMBER.fetch_add(1, Ordering::Relaxed));
    let domain = Domain::shared(&prefix, root.path()).unwrap();
    let of_daemon = domain.clone();
    std::thread::spawn(move || {
        let _keeper = Keeper::start(&of_daemon).unwrap();
        let home = tempfile::tempdir().unwrap();
        let path = home.path().join("site.toml");
        std::fs::write(&path, "state = \"state\"\n").unwrap();
        let config = SiteConfig::read(&path).unwrap();
        let reload = Reload { signal: ReloadSignal::listen().unwrap(), path, config, log };
        let mut service_loop = ServiceLoop::of(
            RecordingService { recorded: Some(recorded), ..service },
            CurrentActivity::default(),
            reload,
        )
        .unwrap();
        let result = service_loop.run_until_stopped(&of_daemon, StopSignal::listen(false).unwrap());
        let _ = ended.send(result.map_or_else(|why| why.to_string(), |()| "stopped".to_owned()));
    });
    TestDaemon { events, end, domain, _files: BusFiles { prefix, _root: root } }
}

/// Waits until there is one.
pub(crate) fn wait_for<T>(waiter: &mut Waiter, mut look: impl FnMut() -> Option<T>) -> T {
    let begun = Instant::now();
    loop {
        if let Some(found) = look() {
            return found;
        }
        assert!(begun.elapsed() < DEADLINE, "it does not come");
        waiter.wait(Duration::from_millis(20)).unwrap();
    }
}
