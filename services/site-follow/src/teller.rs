//! The thread that has the link with the server: it wakes the fetcher when an index is new, and tells how the robot is and what it saw.

use crate::observer::Observer;
use bus::{Bus, Daemon};
use daemon::facts::{AlignFacts, FollowFacts, RosBridgeFacts};
use daemon::{
    DaemonReport, Failure, FollowConfig, FollowLinkConfig, REPORT_INTERVAL_S, Report, ReportAnswer, RobotPlace,
    RobotReport, SiteConfig, StatusBoard, Watched, chain,
};
use fleet_link::{Identity, LinkError, MessageKind, RobotLink, RobotSettings};
use jiff::Timestamp;
use messages::{ContentId, plan_time};
use serde::de::IgnoredAny;
use std::sync::Arc;
use std::time::{Duration, Instant};
use tracing::{info, warn};

/// The robot is looked at this often; what has changed is told.
const LOOK_INTERVAL: Duration = Duration::from_secs(1);

/// Where nobody listens, or the server refuses, it is tried again after this long.
const RETRY_INTERVAL: Duration = Duration::from_secs(5);

/// A link over which nothing was told for so long is opened anew.
const DEAD_AFTER: Duration = Duration::from_secs(30);

/// A robot that stands still is told of this often.
const REPORT_INTERVAL: Duration = Duration::from_secs(REPORT_INTERVAL_S);

/// Observations change with each map that the robot publishes: they are told this often at most.
const OBSERVATIONS_INTERVAL: Duration = Duration::from_secs(30);

/// Shared with the service.
#[derive(Default)]
pub(crate) struct ToTell(Watched<State>);

#[derive(Default)]
struct State {
    /// The table of progress that the robot observed.
    progress: Option<Arc<str>>,
    bus: Option<Bus>,
    /// Why the server does not hear the robot; `None` while it does, and before the first try.
    error: Option<String>,
    is_stopped: bool,
}

impl ToTell {
    /// This is the table of progress from now on.
    pub(crate) fn set_progress(&self, progress: Option<Arc<str>>) {
        self.0.change(|state| state.progress = progress);
    }

    /// The bus of the robot, in a new generation.
    pub(crate) fn attach(&self, bus: &Bus) {
        self.0.lock().bus = Some(bus.clone());
    }

    /// Why the server does not hear the robot.
    pub(crate) fn error(&self) -> Option<String> {
        self.0.lock().error.clone()
    }

    /// Ends the thread, with the service.
    pub(crate) fn stop(&self) {
        self.0.change(|state| state.is_stopped = true);
    }
}

/// The settings of a link.
pub(crate) fn link_settings(config: &FollowConfig, link: &FollowLinkConfig) -> RobotSettings {
    let identity = link.certificate.clone().zip(link.key.clone());
    RobotSettings {
        site: config.site.clone(),
        robot: link.name.to_string(),
        connect: link.connect.clone(),
        password: link.password.clone(),
        authority: link.authority.clone(),
        identity: identity.map(|(certificate, key)| Identity { certificate, key }),
    }
}

/// The thread.
pub(crate) struct Teller<W> {
    config: SiteConfig,
    settings: RobotSettings,
    to_tell: Arc<ToTell>,
    /// Called when an index is new.
    wake: W,
    link: Option<RobotLink>,
    observer: Observer,
    /// The last report that the server took.
    told: Option<(Instant, RobotReport)>,
    /// What the server has, as it said last.
    server: ReportAnswer,
    observations_told: Option<Instant>,
    /// When the server last took something, or the link was opened.
    heard: Instant,
}

impl<W: Fn() + Clone + Send + Sync + 'static> Teller<W> {
    pub(crate) fn new(config: SiteConfig, settings: RobotSettings, to_tell: Arc<ToTell>, wake: W) -> Self {
        let (observer, server) = (Observer::default(), ReportAnswer::default());
        Self {
            config,
            settings,
            to_tell,
            wake,
            link: None,
            observer,
            told: None,
            server,
            observations_told: None,
            heard: Instant::now(),
        }
    }

    /// Tells until it is stopped.
    pub(crate) fn run(mut self) {
        loop {
            let progress = self.to_tell.0.lock().progress.clone();
            let told = self.tell(progress.as_ref());
            if told.is_err() && self.heard.elapsed() > DEAD_AFTER {
                self.link = None;
            }
            let interval = if told.is_ok() { LOOK_INTERVAL } else { RETRY_INTERVAL };
            let mut state = self.to_tell.0.lock();
            let error = told.err().map(|why| chain(why.as_ref()));
            match (&error, &state.error) {
                (Some(error), before) if before.as_ref() != Some(error) => {
                    warn!(service = "site-follow", error, "the server does not hear this robot");
                }
                (None, Some(_)) => info!(service = "site-follow", "the server hears this robot"),
                _ => {}
            }
            state.error = error;
            drop(state);
            let is_idle = |state: &mut State| !state.is_stopped && state.progress == progress;
            if self.to_tell.0.wait_while(Some(interval), is_idle).is_stopped {
                return;
            }
        }
    }

    /// Tells what the server does not know.
    fn tell(&mut self, progress: Option<&Arc<str>>) -> Result<(), Failure> {
        let bus = self.to_tell.0.lock().bus.clone();
        let observations = self.observer.look(bus.as_ref())?;
        let observations_id = observations.as_deref().map(ContentId::of);
        let report = self.report(progress, observations_id);
        let link = match self.link.take() {
            Some(link) => self.link.insert(link),
            None => {
                let link = RobotLink::open(&self.settings, self.wake.clone())?;
                self.heard = Instant::now();
                self.link.insert(link)
            }
        };
        let is_known =
            |(at, before): &(Instant, RobotReport)| at.elapsed() < REPORT_INTERVAL && is_as_before(before, &report);
        if !self.told.as_ref().is_some_and(is_known) {
            // What fails is told again.
            self.told = None;
            let answer = link.tell(MessageKind::Report, serde_json::to_vec(&report)?)?;
            self.heard = Instant::now();
            let had = std::mem::replace(&mut self.server, serde_json::from_slice(&answer)?);
            if self.server.epoch > had.epoch {
                (self.wake)();
            }
        }
        // What the server does not take of the one does not keep the other back.
        let progress = match progress.filter(|_| self.server.progress != report.progress) {
            Some(progress) => {
                let told = link.tell(MessageKind::Progress, progress.as_bytes().to_vec());
                told.map(|_| self.server.progress = report.progress).map_err(of_what("observed progress"))
            }
            None => Ok(()),
        };
        let is_early = self.observations_told.is_some_and(|at| at.elapsed() < OBSERVATIONS_INTERVAL);
        if let Some(bytes) = observations.filter(|_| self.server.observations != observations_id && !is_early) {
            let told = link.tell(MessageKind::Observations, bytes.to_vec());
            told.map_err(of_what("observations of elements"))?;
            (self.server.observations, self.observations_told) = (observations_id, Some(Instant::now()));
        }
        progress?;
        self.told.get_or_insert((Instant::now(), report));
        Ok(())
    }

    /// How the robot is now.
    fn report(&self, progress: Option<&Arc<str>>, observations: Option<ContentId>) -> RobotReport {
        let board = StatusBoard::of_own(&self.config);
        let daemons = board.processes(&self.config).filter_map(|process| {
            let report: Report<IgnoredAny> = board.report(process)?;
            process.daemon()?;
            let runs = board.is_alive(process) && !report.is_silent();
            Some((process.to_string(), DaemonReport { runs, error: report.error, warning: report.warning }))
        });
        let facts =
            board.report(Daemon::SiteFollow).map(|report: Report<FollowFacts>| report.facts).unwrap_or_default();
        let align = board.report(Daemon::SlamAlign).map(|report: Report<AlignFacts>| report.facts);
        let bridge: Option<Report<RosBridgeFacts>> = board.report(Daemon::RosBridge);
        let place = bridge.filter(|report| !report.is_silent()).and_then(|report| {
            let RosBridgeFacts { storey, robot_in_map, robot_seen_ns, .. } = report.facts;
            let age_s = bus::Stamp::now().since(bus::Stamp(robot_seen_ns?)).as_secs_f64();
            Some(RobotPlace { map_storey: storey?, pose: robot_in_map?, age_s })
        });
        let text = |time_s: Option<i64>| time_s.and_then(plan_time).map(|at| at.to_string());
        RobotReport {
            written_ms: Timestamp::now().as_millisecond(),
            maps_of: self.config.follow.as_ref().map_or("", FollowConfig::robot_in_index).to_owned(),
            storeys: facts.maps.storeys,
            epoch: facts.epoch,
            newest_epoch: facts.newest_epoch,
            plan_time: text(facts.schedule.state_plan_time_s),
            valid_until: text(facts.schedule.valid_until_s),
            asked_ms: facts.asked_ms,
            daemons: daemons.collect(),
            alignment: align.and_then(|facts| facts.alignment),
            place,
            progress: progress.map(|table| ContentId::of(table.as_bytes())),
            observations,
        }
    }
}

/// Names what the server does not take.
fn of_what(what: &'static str) -> impl FnOnce(LinkError) -> Failure {
    move |why| format!("{what}: {}", chain(&why)).into()
}

/// True if a report says nothing that one before it did not say, apart from the time. A robot that drives is told of with each report.
fn is_as_before(before: &RobotReport, now: &RobotReport) -> bool {
    let RobotReport { written_ms, asked_ms, place, .. } = before.clone();
    let still = RobotReport { written_ms, asked_ms, place: now.place.and(place), ..now.clone() };
    let moved_m = before.place.zip(now.place).map_or(0.0, |(before, now)| {
        let [x_m, y_m] = [now.pose.x_m - before.pose.x_m, now.pose.y_m - before.pose.y_m];
        if before.map_storey == now.map_storey { x_m.abs().max(y_m.abs()) } else { f64::INFINITY }
    });
    still == *before && moved_m < MIN_MOVE_M && before.place.is_some() == now.place.is_some()
}

/// A robot that moved by this much is somewhere else.
const MIN_MOVE_M: f64 = 0.5;
