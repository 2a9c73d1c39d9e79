//! The event loop of a daemon: latest sample of each input, commands, heartbeats, timers, re-attachment to new bus generations.

use crate::config::SiteConfig;
use crate::failure::{Failure, chain};
use crate::input::Input;
use crate::log::Log;
use crate::request::Request;
use crate::service::{Done, Event, Service, Stages};
use crate::stop::{ReloadSignal, StopSignal};
use bus::{
    Bus, Command, CommandServer, Daemon, Domain, HEARTBEAT_PERIOD, Nudger, RawSample, RawSubscriber, StatusWriter,
    TopicName, Waiter,
};
use messages::{ArchiveKind, Stage, StatusRecord};
use std::collections::{BTreeMap, VecDeque};
use std::path::PathBuf;
use std::sync::mpsc::{Receiver, Sender, TryRecvError, channel};
use std::time::{Duration, Instant};
use tracing::{debug, info, warn};

/// How often a bus that is not there is looked for.
const RETRY: Duration = Duration::from_millis(200);

/// Requests that wait while the service works; more are refused.
const MAX_WAITING: usize = 16;

/// What the service is told. Samples are validated on its thread, because that takes time.
enum ToService {
    Attach(Bus, Nudger),
    Sample(RawSample),
    Request(Request),
    Configuration(Box<SiteConfig>),
    Tick,
}

/// The service's own thread.
fn work<S: Service>(mut service: S, events: &Receiver<ToService>, results: Sender<Result<Done, Failure>>) {
    let mut outbox = Outbox { results: Some(results), nudger: None };
    for event in events {
        let result = match event {
            ToService::Attach(bus, nudger) => {
                outbox.nudger = Some(nudger);
                service.attach(&bus).and_then(|()| service.handle(Event::Attached))
            }
            ToService::Sample(sample) => S::Input::check(sample).and_then(|input| service.handle(Event::Input(input))),
            ToService::Request(request) => service.handle(Event::Request(request)),
            ToService::Configuration(config) => service.handle(Event::Configuration(config)),
            ToService::Tick => service.handle(Event::Tick),
        };
        if outbox.results.as_ref().is_some_and(|results| results.send(result).is_err()) {
            return;
        }
        outbox.nudger.iter().for_each(Nudger::nudge);
    }
}

/// Where results go. A service that panics closes it, and the loop hears of that at once.
struct Outbox {
    results: Option<Sender<Result<Done, Failure>>>,
    nudger: Option<Nudger>,
}

impl Drop for Outbox {
    fn drop(&mut self) {
        drop(self.results.take());
        self.nudger.iter().for_each(Nudger::nudge);
    }
}

/// A daemon's side of the loop.
pub(crate) struct Life {
    daemon: Daemon,
    inputs: &'static [TopicName],
    stages: Stages,
    to_service: Sender<ToService>,
    from_service: Receiver<Result<Done, Failure>>,
    is_busy: bool,
    /// Samples that the service has not seen.
    newest: BTreeMap<TopicName, RawSample>,
    waiting: VecDeque<(Command, Request)>,
    /// Whose request the service works on.
    asked: Option<Command>,
    /// What went wrong last, and what the service warns of.
    error: String,
    warning: Option<String>,
    /// When the service wants to be woken.
    alarm: Option<Instant>,
    reload: Reload,
    /// A configuration that the service has not seen.
    configuration: Option<Box<SiteConfig>>,
    /// Of the newest inputs that the service was given, and of what it published.
    epochs: [u64; 16],
}

/// Reading the configuration again.
pub(crate) struct Reload {
    pub(crate) signal: ReloadSignal,
    pub(crate) path: PathBuf,
    pub(crate) config: SiteConfig,
    pub(crate) log: Log,
}

impl Reload {
    /// The configuration, if it is to be used from now on.
    fn read(&mut self) -> Result<Box<SiteConfig>, Failure> {
        let config = SiteConfig::read(&self.path)?;
        if config.bus != self.config.bus || config.state != self.config.state {
            return Err("the bus and the state folder cannot change while daemons run: restart them".into());
        }
        if config.log.format != self.config.log.format {
            return Err("the format of the log cannot change while a daemon runs: restart it".into());
        }
        self.log.set_level(&config.log)?;
        self.config = config.clone();
        Ok(Box::new(config))
    }
}

/// How a generation of the bus ended.
enum End {
    Stopped,
    Superseded,
}

impl Life {
    /// Starts the service's thread.
    pub(crate) fn of<S: Service + 'static>(
        daemon: Daemon,
        service: S,
        stages: Stages,
        reload: Reload,
    ) -> Result<Self, Failure> {
        let (to_service, events) = channel();
        let (results, from_service) = channel();
        // The service lives on a thread of the pool that its parallel work runs on: handing work to a pool from outside
        // costs an allocation now and then, and a thread.
        let pool = rayon::ThreadPoolBuilder::new().build()?;
        let worker = std::thread::Builder::new().name(daemon.name().to_owned());
        worker.spawn(move || pool.install(move || work(service, &events, results)))?;
        Ok(Self {
            daemon,
            inputs: S::Input::TOPICS,
            stages,
            to_service,
            from_service,
            is_busy: false,
            newest: BTreeMap::new(),
            waiting: VecDeque::new(),
            asked: None,
            error: String::new(),
            warning: None,
            alarm: None,
            reload,
            configuration: None,
            epochs: [0; 16],
        })
    }

    pub(crate) fn all_generations(&mut self, domain: &Domain, mut stop: StopSignal) -> Result<(), Failure> {
        let service = self.daemon.name();
        loop {
            let (bus, mut waiter) = match Bus::join(domain, self.daemon) {
                Ok(joined) => joined,
                Err(why) => {
                    debug!(service, error = chain(&why), "the bus is not there yet");
                    if stop.is_raised_within(RETRY) {
                        return Ok(());
                    }
                    continue;
                }
            };
            waiter.stop_on(stop.descriptor()?);
            let end = self.generation(&bus, &mut waiter);
            // Ends of a generation that is gone are of no use.
            self.newest.clear();
            self.waiting.clear();
            self.asked = None;
            match end? {
                End::Stopped => {
                    crate::stopping();
                    info!(service, "stopped");
                    return Ok(());
                }
                End::Superseded => info!(service, "the bus has a new generation"),
            }
        }
    }

    fn generation(&mut self, bus: &Bus, waiter: &mut Waiter) -> Result<End, Failure> {
        let server = bus.command_server()?;
        let status = bus.status_writer()?;
        let subscribers: Vec<RawSubscriber> =
            self.inputs.iter().map(|topic| bus.raw_subscriber(*topic)).collect::<Result<_, _>>()?;
        // The service may still be at work for the generation before.
        while self.is_busy {
            let result = self.from_service.recv()?;
            self.finish(result);
        }
        info!(service = self.daemon.name(), generation = bus.generation(), "joined the bus");
        crate::ready("joined the bus");
        self.send(ToService::Attach(bus.clone(), waiter.nudger()))?;
        let mut next_beat = Instant::now();
        loop {
            let now = Instant::now();
            let is_beat = next_beat <= now;
            if is_beat {
                self.beat(&status);
                next_beat = now + HEARTBEAT_PERIOD;
            }
            self.look_for_configuration();
            self.give_work(is_beat || self.alarm.is_some_and(|alarm| alarm <= now))?;
            // An alarm that rings while the service works waits until it is done.
            let alarm = self.alarm.filter(|_| !self.is_busy);
            let next = alarm.map_or(next_beat, |alarm| alarm.min(next_beat));
            let wake = waiter.wait(next.saturating_duration_since(Instant::now()))?;
            if wake.stopped {
                return Ok(End::Stopped);
            }
            if wake.superseded {
                return Ok(End::Superseded);
            }
            loop {
                match self.from_service.try_recv() {
                    Ok(result) => self.finish(result),
                    Err(TryRecvError::Empty) => break,
                    Err(TryRecvError::Disconnected) => return Err("the service has panicked".into()),
                }
                // What has changed is told at once.
                self.beat(&status);
            }
            self.take_samples(&subscribers);
            self.take_commands(&server);
        }
    }

    fn take_samples(&mut self, subscribers: &[RawSubscriber]) {
        for subscriber in subscribers {
            match subscriber.take() {
                Ok(Some(sample)) => drop(self.newest.insert(subscriber.topic(), sample)),
                Ok(None) => {}
                Err(why) => self.fail(&why),
            }
        }
    }

    fn take_commands(&mut self, server: &CommandServer) {
        loop {
            let command = match server.take() {
                Ok(Some(command)) => command,
                Ok(None) => return,
                Err(why) => return self.fail(&why),
            };
            let request = serde_json::from_slice::<Request>(command.bytes()).map_err(|e| e.to_string());
            let refused = match request {
                Ok(request) if self.waiting.len() < MAX_WAITING => {
                    self.waiting.push_back((command, request));
                    continue;
                }
                Ok(_) => command.failed(b"too many requests wait already"),
                Err(why) => command.failed(why.as_bytes()),
            };
            if let Err(why) = refused {
                self.fail(&why);
            }
        }
    }

    /// Gives the idle service what is most urgent: an input, so that requests meet the newest; a request; a tick.
    fn give_work(&mut self, is_tick: bool) -> Result<(), Failure> {
        if self.is_busy {
            return Ok(());
        }
        if let Some(config) = self.configuration.take() {
            return self.send(ToService::Configuration(config));
        }
        if let Some((topic, sample)) = self.newest.pop_first() {
            self.epochs[topic.kind() as usize] = sample.header().epoch;
            return self.send(ToService::Sample(sample));
        }
        if let Some((command, request)) = self.waiting.pop_front() {
            self.asked = Some(command);
            return self.send(ToService::Request(request));
        }
        if is_tick { self.send(ToService::Tick) } else { Ok(()) }
    }

    fn look_for_configuration(&mut self) {
        if !self.reload.signal.take() {
            return;
        }
        match self.reload.read() {
            Ok(config) => {
                info!(service = self.daemon.name(), "configuration read again");
                self.configuration = Some(config);
            }
            Err(why) => {
                self.error = chain(why.as_ref());
                warn!(service = self.daemon.name(), error = self.error, "the configuration stays as it was");
            }
        }
    }

    fn send(&mut self, event: ToService) -> Result<(), Failure> {
        self.is_busy = true;
        self.to_service.send(event).map_err(|_| "the service has panicked".into())
    }

    fn finish(&mut self, result: Result<Done, Failure>) {
        self.is_busy = false;
        let command = self.asked.take();
        let replied = match result {
            Ok(done) => {
                self.alarm = done.wake_in.map(|time| Instant::now() + time);
                if done.warning != self.warning {
                    if let Some(warning) = &done.warning {
                        warn!(service = self.daemon.name(), warning, "the service warns");
                    }
                    self.warning.clone_from(&done.warning);
                }
                if done.answer.epoch > 0 {
                    self.epochs[output(self.daemon) as usize] = done.answer.epoch;
                }
                // An error stays until the service has done something with success; ticks do nothing.
                if command.is_some() || done.answer.epoch > 0 {
                    self.error.clear();
                }
                let answer = serde_json::to_vec(&done.answer).unwrap_or_default();
                command.map(|command| command.done(&answer))
            }
            Err(failure) => {
                let text = chain(failure.as_ref());
                // What is tried again every second is told once.
                if self.error != text {
                    warn!(service = self.daemon.name(), error = text, "what it was asked cannot be done");
                }
                self.stages.set(Stage::Idle);
                self.error.clone_from(&text);
                command.map(|command| command.failed(text.as_bytes()))
            }
        };
        if let Some(Err(why)) = replied {
            self.fail(&why);
        }
    }

    fn fail(&mut self, why: &(dyn std::error::Error + 'static)) {
        self.error = chain(why);
        warn!(service = self.daemon.name(), error = self.error, "the bus refuses");
    }

    fn beat(&self, status: &StatusWriter) {
        let mut record = StatusRecord::of(self.stages.get(), resident_bytes());
        let text = if self.error.is_empty() { self.warning.as_deref().unwrap_or_default() } else { &self.error };
        record.set_error(text);
        record.epochs = self.epochs;
        crate::systemd::alive(if text.is_empty() { self.stages.get().name() } else { text });
        if !status.send(record) {
            warn!(service = self.daemon.name(), "a heartbeat found no room in shared memory");
        }
    }
}

/// What a daemon's answers speak of.
fn output(daemon: Daemon) -> ArchiveKind {
    match daemon {
        Daemon::IfcIngest => ArchiveKind::Site,
        Daemon::ScheduleEval => ArchiveKind::Phase,
        Daemon::Rasterize | Daemon::Groundplan => ArchiveKind::Grids,
        Daemon::WaypointGen => ArchiveKind::Plan,
        Daemon::SlamAlign => ArchiveKind::Alignment,
        Daemon::Robot => ArchiveKind::SlamMap,
    }
}

/// Resident memory of this process; 0 if the system does not tell.
fn resident_bytes() -> u64 {
    let pages = std::fs::read_to_string("/proc/self/statm").ok();
    pages.and_then(|t| t.split(' ').nth(1)?.parse::<u64>().ok()).unwrap_or(0) * 4_096
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::input::NoInput;
    use bus::Keeper;
    use std::sync::Mutex;

    /// Writes down when it was asked what.
    struct Diary {
        asked: Sender<(Instant, &'static str)>,
        wake_in: Option<Duration>,
        panics_at_tick: bool,
    }

    impl Service for Diary {
        type Input = NoInput;

        fn attach(&mut self, _bus: &Bus) -> Result<(), Failure> {
            Ok(())
        }

        fn handle(&mut self, event: Event<NoInput>) -> Result<Done, Failure> {
            let what = match event {
                Event::Attached => "attached",
                Event::Tick => "tick",
                _ => "other",
            };
            self.asked.send((Instant::now(), what))?;
            assert!(!(self.panics_at_tick && what == "tick"), "as the test wants it");
            let wake_in = if what == "attached" { self.wake_in } else { None };
            Ok(Done { wake_in, ..Done::default() })
        }
    }

    /// A daemon of this service on a bus of its own, until it ends by itself or the result is read no more.
    fn live(wake_in: Option<Duration>, panics_at_tick: bool) -> (Receiver<(Instant, &'static str)>, Receiver<String>) {
        // One log for all tests of this process.
        static LOG: Mutex<Option<Log>> = Mutex::new(None);
        let log = {
            let mut log = LOG.lock().unwrap();
            log.get_or_insert_with(|| Log::start(&Default::default()).unwrap()).clone()
        };
        let (asked, diary) = channel();
        let (ended, end) = channel();
        std::thread::spawn(move || {
            let root = tempfile::Builder::new().prefix("bus").tempdir_in("/dev/shm").unwrap();
            let prefix = format!("gl{:x}x{}_", std::process::id(), u8::from(panics_at_tick));
            let domain = Domain::shared(&prefix, root.path()).unwrap();
            let _keeper = Keeper::start(&domain).unwrap();
            let home = tempfile::tempdir().unwrap();
            let path = home.path().join("site.toml");
            std::fs::write(&path, "state = \"state\"\n").unwrap();
            let config = SiteConfig::read(&path).unwrap();
            let reload = Reload { signal: ReloadSignal::listen().unwrap(), path, config, log };
            let service = Diary { asked, wake_in, panics_at_tick };
            let mut life = Life::of(Daemon::ScheduleEval, service, Stages::default(), reload).unwrap();
            let result = life.all_generations(&domain, StopSignal::listen(false).unwrap());
            let _ = ended.send(result.map_or_else(|why| why.to_string(), |()| "stopped".to_owned()));
        });
        (diary, end)
    }

    const DEADLINE: Duration = Duration::from_secs(60);

    #[test]
    fn a_service_is_woken_when_it_asked_for_it_and_not_before() {
        let wake_in = Duration::from_millis(150);
        let (diary, _end) = live(Some(wake_in), false);
        let (attached, first) = diary.recv_timeout(DEADLINE).unwrap();
        let (woken, second) = diary.recv_timeout(DEADLINE).unwrap();
        assert_eq!((first, second), ("attached", "tick"));
        assert!(wake_in <= woken - attached);
    }

    #[test]
    fn a_service_that_panics_ends_its_daemon() {
        let (_diary, end) = live(None, true);
        assert_eq!(end.recv_timeout(DEADLINE).unwrap(), "the service has panicked");
    }
}
