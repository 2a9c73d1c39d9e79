//! The event loop of a daemon: latest sample of each input, requests, heartbeats, timers, re-attachment to new bus
//! generations.
//!
//! A service is woken by an input, by a request, when it asked for that (`Decision::wake_in`), or by the next heartbeat, whichever is
//! first; after a failure by the next heartbeat. A configuration that it could not take is given again after 1 s, then twice as long
//! each time, up to a minute.

use crate::config::SiteConfig;
use crate::failure::{Failure, chain};
use crate::input::Input;
use crate::log::Log;
use crate::request::Request;
use crate::request_queue::RequestQueue;
use crate::self_report::SelfReport;
use crate::service::{CurrentActivity, Service};
use crate::service_thread::{self, Job, Outcome, ServiceThread, WORK_THREAD};
use crate::stop::{ReloadSignal, StopSignal};
use crate::work_watch::WorkWatch;
use bus::{
    Bus, CommandServer, Daemon, Domain, HEARTBEAT_PERIOD, PortError, RawSample, RawSubscriber, ReceiveError, Stamp,
    StatusWriter, TopicName, Waiter, Waker,
};
use messages::Activity;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::mpsc::{Receiver, Sender, TryRecvError};
use std::time::{Duration, Instant};
use tracing::{debug, info};

/// Interval at which a missing bus is tried.
const RETRY: Duration = Duration::from_millis(200);

/// A configuration that is refused is tried again after a second, then less and less often, at least after this time.
const MAX_WAIT: Duration = Duration::from_secs(60);

/// The event loop of a daemon.
pub(crate) struct ServiceLoop<R> {
    daemon: Daemon,
    inputs: &'static [TopicName],
    activity: CurrentActivity,
    report: SelfReport,
    to_service: Sender<Job<R>>,
    from_service: Receiver<Outcome>,
    is_busy: bool,
    watch: WorkWatch,
    /// Samples that the service has not handled.
    newest: BTreeMap<TopicName, RawSample>,
    requests: RequestQueue<R>,
    /// When the service is to be woken.
    wake_at: Option<Instant>,
    reload: Reload,
    /// A configuration that the service has not handled.
    configuration: Option<Box<SiteConfig>>,
    /// When a configuration that the service refused is tried again, and how long it was waited for that: what is in the way,
    /// such as a full memory, may pass.
    next_try: Option<(Instant, Duration)>,
    /// True while the service handles one.
    is_configuring: bool,
    /// True while the service handles a request; a client may wait for longer.
    is_asked: bool,
    attachment: Attachment,
}

/// How far the service has joined the generation of the bus. It gets no input before: inputs come once.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Attachment {
    /// It is to attach, from this moment.
    Wanted(Instant),
    /// It attaches.
    Underway,
    /// It has attached, and is to be told so.
    Done,
    /// It knows.
    Told,
}

/// Reloads the configuration.
pub(crate) struct Reload {
    pub(crate) signal: ReloadSignal,
    pub(crate) path: PathBuf,
    pub(crate) config: SiteConfig,
    pub(crate) log: Log,
}

impl Reload {
    /// Reads the configuration, if it can be applied while the daemon runs.
    fn read(&mut self) -> Result<Box<SiteConfig>, Failure> {
        let site = SiteConfig::read(&self.path)?;
        if site.robot_names() != self.config.robot_names() {
            return Err("the robots of a site cannot change while daemons run: restart them".into());
        }
        let config = match self.config.robot_name {
            Some(robot) => site.of_robot(Some(robot))?,
            None => site,
        };
        if config.bus != self.config.bus || config.state != self.config.state {
            return Err("the bus and the state folder cannot change while daemons run: restart them".into());
        }
        if config.threads != self.config.threads {
            return Err("the number of threads cannot change while a daemon runs: restart it".into());
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
enum GenerationEnd {
    Stopped,
    Superseded,
    /// It never began: a part of the bus is missing.
    Incomplete,
}

/// The ends of the bus that the loop has itself.
struct Ends {
    server: CommandServer,
    status: StatusWriter,
    subscribers: Vec<RawSubscriber>,
}

impl<R: Request> ServiceLoop<R> {
    /// Starts the service's thread.
    pub(crate) fn of<S: Service<Request = R> + 'static>(
        service: S,
        activity: CurrentActivity,
        reload: Reload,
    ) -> Result<Self, Failure> {
        let mut report = SelfReport::of(R::DAEMON, reload.config.robot_name, activity.clone(), &reload.config.bus.root);
        report.set(service.standing(), serde_json::to_value(service.facts())?);
        let n_threads = reload.config.n_threads();
        let ServiceThread { jobs, outcomes } = service_thread::start(R::DAEMON.name(), n_threads, service)?;
        Ok(Self {
            daemon: R::DAEMON,
            inputs: S::Input::TOPICS,
            report,
            activity,
            to_service: jobs,
            from_service: outcomes,
            is_busy: false,
            watch: WorkWatch::of(R::DAEMON.name(), WORK_THREAD),
            newest: BTreeMap::new(),
            requests: RequestQueue::new(),
            wake_at: None,
            reload,
            configuration: None,
            next_try: None,
            is_configuring: false,
            is_asked: false,
            attachment: Attachment::Wanted(Instant::now()),
        })
    }

    pub(crate) fn run_until_stopped(&mut self, domain: &Domain, mut stop: StopSignal) -> Result<(), Failure> {
        let service = self.daemon.name();
        let mut next_heartbeat = Instant::now();
        loop {
            let (bus, mut waiter) = match Bus::join(domain, self.daemon) {
                Ok(joined) => joined,
                Err(why) => {
                    self.report.cannot_join(&why);
                    if next_heartbeat <= Instant::now() {
                        self.tell(None);
                        next_heartbeat = Instant::now() + HEARTBEAT_PERIOD;
                    }
                    if stop.is_raised_within(RETRY) {
                        self.report.leave();
                        return Ok(());
                    }
                    continue;
                }
            };
            self.report.joined();
            waiter.stop_on(stop.descriptor()?);
            let end = self.generation(&bus, &mut waiter);
            // Ports of an earlier generation cannot be used.
            self.newest.clear();
            self.requests.clear();
            match end? {
                GenerationEnd::Stopped => {
                    self.report.leave();
                    info!(service, "stopped");
                    return Ok(());
                }
                GenerationEnd::Superseded => info!(service, "the bus has a new generation"),
                GenerationEnd::Incomplete => {
                    drop((bus, waiter));
                    if stop.is_raised_within(RETRY) {
                        self.report.leave();
                        return Ok(());
                    }
                }
            }
        }
    }

    /// Opens the ends of the loop.
    fn ends(&self, bus: &Bus) -> Result<Ends, PortError> {
        let subscribers = self.inputs.iter().map(|topic| bus.raw_subscriber(*topic)).collect::<Result<_, _>>()?;
        Ok(Ends { server: bus.command_server()?, status: bus.status_writer()?, subscribers })
    }

    fn generation(&mut self, bus: &Bus, waiter: &mut Waiter) -> Result<GenerationEnd, Failure> {
        let Ends { server, status, subscribers } = match self.ends(bus) {
            // The keeper died before it had created this, or after: its successor creates it.
            Err(why @ PortError::Missing { .. }) => {
                info!(service = self.daemon.name(), error = chain(&why), "the bus is not whole yet");
                return Ok(GenerationEnd::Incomplete);
            }
            ends => ends?,
        };
        info!(service = self.daemon.name(), generation = bus.generation(), "joined the bus");
        crate::ready("joined the bus");
        let waker = waiter.waker();
        self.attachment = Attachment::Wanted(Instant::now());
        let mut next_heartbeat = Instant::now();
        loop {
            let now = Instant::now();
            let is_heartbeat_due = next_heartbeat <= now;
            if is_heartbeat_due {
                self.tell(Some(&status));
                next_heartbeat = now + HEARTBEAT_PERIOD;
            }
            self.reload_configuration();
            // The service may still be at work for the generation before.
            if matches!(self.attachment, Attachment::Wanted(from) if from <= now) && !self.is_busy {
                self.attachment = Attachment::Underway;
                self.send(Job::Attach(bus.clone(), waker.clone()), "joining the bus".to_owned())?;
            }
            self.dispatch(is_heartbeat_due || self.wake_at.is_some_and(|wake_at| wake_at <= now), &waker)?;
            // A wake-up that is due while the service works waits until it is done.
            let wake_at = self.wake_at.filter(|_| !self.is_busy);
            let next = wake_at.map_or(next_heartbeat, |wake_at| wake_at.min(next_heartbeat));
            let wake = waiter.wait(next.saturating_duration_since(Instant::now()))?;
            if wake.stopped {
                return Ok(GenerationEnd::Stopped);
            }
            if wake.superseded {
                return Ok(GenerationEnd::Superseded);
            }
            loop {
                let answer = match self.from_service.try_recv() {
                    Ok(outcome) => self.finish(outcome),
                    Err(TryRecvError::Empty) => break,
                    Err(TryRecvError::Disconnected) => return Err("the service has panicked".into()),
                };
                // A change is reported at once, and before the answer: who has it finds in the report what was done.
                self.report.send(Some(&status), self.watch.busy());
                let told = answer.map(|answer| self.requests.finish(answer.as_deref().map_err(String::as_str)));
                if let Some(Err(why)) = told {
                    self.report_bus_error(&why);
                }
            }
            self.requests.send_progress();
            self.take_samples(&subscribers);
            self.take_requests(&server);
        }
    }

    fn take_samples(&mut self, subscribers: &[RawSubscriber]) {
        for subscriber in subscribers {
            match subscriber.take() {
                Ok(Some(sample)) => drop(self.newest.insert(subscriber.topic(), sample)),
                Ok(None) => {}
                // The service and its worker still hold the earlier ones: it waits, and is taken when one is dropped.
                Err(why @ ReceiveError::TooManyHeld { .. }) => {
                    debug!(service = self.daemon.name(), error = chain(&why), "a sample waits");
                }
                Err(why) => self.report_bus_error(&why),
            }
        }
    }

    fn take_requests(&mut self, server: &CommandServer) {
        loop {
            match self.requests.take(server) {
                Ok(true) => {}
                Ok(false) => return,
                Err(why) => return self.report_bus_error(&why),
            }
        }
    }

    /// Sends the idle service its next event: an input, so that requests meet the newest; then a request; then a tick.
    fn dispatch(&mut self, is_tick: bool, waker: &Waker) -> Result<(), Failure> {
        if self.is_busy {
            return Ok(());
        }
        if let Some(config) = self.configuration.take() {
            self.is_configuring = true;
            return self.send(Job::Configuration(config), "another configuration".to_owned());
        }
        match self.attachment {
            Attachment::Wanted(_) | Attachment::Underway => return Ok(()),
            Attachment::Done => {
                self.attachment = Attachment::Told;
                return self.send(Job::Attached, "its begin on the bus".to_owned());
            }
            Attachment::Told => {}
        }
        if let Some((topic, sample)) = self.newest.pop_first() {
            let header = sample.header();
            self.report.set_input(topic, header.epoch, Stamp(header.stamp_ns));
            return self.send(Job::Sample(sample), format!("the input {topic}"));
        }
        if let Some((request, asked)) = self.requests.next(waker) {
            self.is_asked = true;
            let (job, reporter) = (format!("the request {}", name_of(&request)), asked.reporter.clone());
            self.send(Job::Request(request, asked), job)?;
            self.watch.report_of(reporter);
            return Ok(());
        }
        if is_tick { self.send(Job::Tick, "a regular look".to_owned()) } else { Ok(()) }
    }

    fn reload_configuration(&mut self) {
        if self.next_try.is_some_and(|(at, _)| at <= Instant::now()) && !self.is_busy {
            self.configuration = Some(Box::new(self.reload.config.clone()));
        }
        if !self.reload.signal.take() {
            return;
        }
        self.next_try = None;
        let read = self.reload.read();
        self.report.configured(read.as_ref().map(drop));
        if let Ok(config) = read {
            info!(service = self.daemon.name(), "configuration read again");
            self.configuration = Some(config);
        }
    }

    /// Tells everybody of itself, unless the service hangs: silence is what readers and watchdogs understand.
    fn tell(&mut self, status: Option<&StatusWriter>) {
        self.watch.look();
        if !self.watch.hangs() {
            self.report.send(status, self.watch.busy());
        }
    }

    fn send(&mut self, job: Job<R>, words: String) -> Result<(), Failure> {
        self.is_busy = true;
        self.watch.begin(words);
        self.to_service.send(job).map_err(|_| "the service has panicked".into())
    }

    /// Takes what the service has done into the report; returns what the client that waits is told, if it is.
    fn finish(&mut self, outcome: Outcome) -> Option<Result<Vec<u8>, String>> {
        self.is_busy = false;
        let is_asked = std::mem::take(&mut self.is_asked);
        self.watch.end();
        self.report.set(outcome.standing, outcome.facts);
        let is_configuration = std::mem::take(&mut self.is_configuring);
        if self.attachment == Attachment::Underway {
            self.attachment = match &outcome.result {
                Ok(_) => {
                    // Why it could not attach before, maybe to an earlier generation, is over.
                    self.report.succeeded();
                    Attachment::Done
                }
                Err(_) => Attachment::Wanted(Instant::now() + HEARTBEAT_PERIOD),
            };
        }
        match outcome.result {
            Ok(done) => {
                self.wake_at = done.wake_in.map(|time| Instant::now() + time);
                let epoch = done.published.epoch;
                let is_new = epoch > 0 && self.report.set_output(epoch);
                if is_configuration {
                    self.next_try = None;
                    self.report.configured(Ok(()));
                }
                // An error of an event stays until one brings an output, or a request a new one; ticks do nothing.
                let is_cured = if is_asked { is_new } else { epoch > 0 };
                if is_cured {
                    self.report.succeeded();
                }
            }
            Err(failure) => {
                self.activity.set(Activity::Idle);
                if is_configuration {
                    // It stands until a configuration is taken.
                    self.report.configured(Err(&failure));
                    let wait = self.next_try.map_or(HEARTBEAT_PERIOD, |(_, wait)| (wait * 2).min(MAX_WAIT));
                    self.next_try = Some((Instant::now() + wait, wait));
                } else {
                    // The next tick tries again what is pending.
                    self.wake_at = None;
                    match is_asked {
                        // The client is told. What is in force is as it was, and only what is wrong with that stands.
                        true => self.report.refused_request(failure.as_ref()),
                        false => self.report.failed("the event cannot be handled", failure.as_ref()),
                    }
                }
            }
        }
        outcome.answer
    }

    fn report_bus_error(&mut self, why: &(dyn std::error::Error + 'static)) {
        self.report.failed("the bus refuses", why);
    }
}

/// The name of a request, as it is on the bus.
fn name_of<R: Request>(request: &R) -> String {
    match serde_json::to_value(request) {
        Ok(serde_json::Value::String(name)) => name,
        Ok(serde_json::Value::Object(request)) => request.into_iter().next().map(|(name, _)| name).unwrap_or_default(),
        _ => String::new(),
    }
}

#[cfg(test)]
mod tests {
    use crate::client::{Answer, Client, ClientError};
    use crate::progress::Progress;
    use crate::testing::{DEADLINE, RecordingService, TestRequest, spawn_daemon, wait_for};
    use bus::{Daemon, Reply};
    use std::sync::mpsc::channel;
    use std::time::Duration;

    #[test]
    fn a_service_is_woken_when_it_asked_for_it_and_not_before() {
        let wake_in = Duration::from_millis(150);
        let test_daemon = spawn_daemon(RecordingService { wake_in: Some(wake_in), ..RecordingService::default() });
        let (attached, first) = test_daemon.events.recv_timeout(DEADLINE).unwrap();
        let (woken, second) = test_daemon.events.recv_timeout(DEADLINE).unwrap();
        assert_eq!((first, second), ("attached", "tick"));
        assert!(wake_in <= woken - attached);
    }

    #[test]
    fn a_service_that_cannot_attach_tries_again_and_gets_nothing_before() {
        let test_daemon = spawn_daemon(RecordingService { n_refusals: 2, ..RecordingService::default() });
        let first: Vec<&str> = (0..4).map(|_| test_daemon.events.recv_timeout(DEADLINE).unwrap().1).collect();
        assert_eq!(first, ["refused", "refused", "attached", "tick"]);
    }

    #[test]
    fn a_service_that_panics_ends_its_daemon() {
        let test_daemon = spawn_daemon(RecordingService { panics_at_tick: true, ..RecordingService::default() });
        assert_eq!(test_daemon.end.recv_timeout(DEADLINE).unwrap(), "the service has panicked");
    }

    #[test]
    fn progress_comes_before_the_answer_and_its_end_is_not_left_out() {
        let test_daemon = spawn_daemon(RecordingService::default());
        let (bus, mut waiter) = test_daemon.client();
        let client = Client::<TestRequest>::of(&bus).unwrap();
        let open = wait_for(&mut waiter, || client.send(&TestRequest::Count { steps: 500 }).ok());
        let mut percents = Vec::new();
        let answer = loop {
            match wait_for(&mut waiter, || open.take().unwrap()) {
                Answer::Progress(Progress { doing, percent }) => percents.push((percent, doing)),
                Answer::Done(answer) => break answer,
            }
        };
        assert_eq!(answer, 500);
        assert!(percents.is_sorted() && percents.last().is_some_and(|(percent, _)| *percent == 100), "{percents:?}");
    }

    #[test]
    fn a_client_that_leaves_neither_stops_nor_fails_the_work() {
        let (go, gate) = channel();
        let test_daemon = spawn_daemon(RecordingService { gate: Some(gate), ..RecordingService::default() });
        let (bus, mut waiter) = test_daemon.client();
        let client = Client::<TestRequest>::of(&bus).unwrap();
        let open = wait_for(&mut waiter, || client.send(&TestRequest::Count { steps: 50 }).ok());
        let news = wait_for(&mut waiter, || open.take().unwrap());
        assert_eq!(news, Answer::Progress(Progress { doing: "counting".to_owned(), percent: 2 }));
        drop(open);
        go.send(()).unwrap();
        go.send(()).unwrap();
        let open = wait_for(&mut waiter, || client.send(&TestRequest::Count { steps: 3 }).ok());
        let answer = wait_for(&mut waiter, || match open.take().unwrap() {
            Some(Answer::Done(answer)) => Some(answer),
            _ => None,
        });
        assert_eq!(answer, 3);
        let counted = test_daemon.events.try_iter().filter(|(_, what)| *what == "counted").count();
        assert_eq!(counted, 2, "the request of the client that left was carried out");
    }

    #[test]
    fn bytes_that_are_no_request_get_an_error_and_the_daemon_goes_on() {
        let test_daemon = spawn_daemon(RecordingService::default());
        let (bus, mut waiter) = test_daemon.client();
        let port = bus.command_client(Daemon::ScheduleEval).unwrap();
        for bytes in [&b"\"next_change\""[..], b"\xff\x00", b"", b"{\"count\":{\"steps\":-1}}"] {
            let open = wait_for(&mut waiter, || port.send(bytes).ok());
            let Reply::Failed(text) = wait_for(&mut waiter, || open.take().unwrap()) else { panic!("it was taken") };
            let text = String::from_utf8(text).unwrap();
            assert!(text.starts_with("this is no request of schedule-eval: "), "{text}");
        }
        let client = Client::<TestRequest>::of(&bus).unwrap();
        let open = wait_for(&mut waiter, || client.send(&TestRequest::Refuse).ok());
        let refused = wait_for(&mut waiter, || open.take().err());
        assert!(matches!(&refused, ClientError::Refused { why, .. } if why == "no"), "{refused}");
    }
}
