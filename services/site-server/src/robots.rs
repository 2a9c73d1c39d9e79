//! The thread that has the link with the robots: it tells them of indices, and takes what they tell. Observed progress goes to
//! schedule-eval, which merges it; all else is in the document of the fleet.

use crate::giver::{Giver, Rows};
use crate::publication::Shared as Published;
use bus::{Daemon, RobotName};
use daemon::facts::ScheduleFacts;
use daemon::state_files::TOLD;
use daemon::{
    AbsentByRobot, ElementObservation, Failure, FleetDocument, FleetRobot, KeptFile, Observations, ObservedTables,
    Report, ReportAnswer, RobotReport, ServeConfig, ServeLinkConfig, StatusBoard, ToldAbsence, ToldByRobot,
    ToldObservation, Watched, chain, fleet_elements, replace_file,
};
use fleet_link::{Identity, Message, MessageKind, ServerLink, ServerSettings};
use frames::PlanTime;
use jiff::Timestamp;
use messages::{ContentId, Observation};
use schedule::{ABSENT, Actual, parse_actuals};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::time::{Duration, Instant};
use tracing::{info, warn};

/// An index is told of this soon, and a robot that came or went is noticed.
const LOOK_INTERVAL: Duration = Duration::from_millis(100);

/// An address that is taken is tried again after this long.
const OPEN_INTERVAL: Duration = Duration::from_secs(5);

/// The document is written this often.
const WRITE_INTERVAL: Duration = Duration::from_secs(1);

/// What robots told last is on disk at least this often.
const KEEP_INTERVAL: Duration = Duration::from_secs(60);

/// So many elements no site has.
const MAX_ELEMENTS: usize = 500_000;

/// Shared with the service.
#[derive(Default)]
pub(crate) struct Shared(Watched<State>);

#[derive(Default)]
struct State {
    /// Why there is no link.
    error: Option<String>,
    is_stopped: bool,
}

impl Shared {
    /// Why robots have no link.
    pub(crate) fn error(&self) -> Option<String> {
        self.0.lock().error.clone()
    }

    /// Ends the thread, with the service.
    pub(crate) fn stop(&self) {
        self.0.lock().is_stopped = true;
    }
}

/// What is kept of a robot.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct KeptRobot {
    told: Option<(Timestamp, RobotReport)>,
    /// The table of progress that it told last, and its rows by element.
    progress: Option<ContentId>,
    rows: BTreeMap<String, ToldRow>,
    /// The observations that it told last.
    observations: Option<ContentId>,
    elements: BTreeMap<String, ToldObservation>,
}

/// A row of a table of observed progress.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
struct ToldRow {
    start: String,
    finish: String,
    /// Since when the robot tells it.
    since: Timestamp,
}

impl ToldRow {
    fn is_absence(&self) -> bool {
        self.start == ABSENT
    }
}

/// True for an observation of an element that is there, in its place or beside it.
fn stands(observed: &ElementObservation) -> bool {
    observed.observation != Observation::Absent.name()
}

impl KeptRobot {
    /// Takes a table; rows that are as before keep their time.
    ///
    /// # Errors
    /// A row that no robot tells: an element is seen to stand by a date, or its absence was confirmed.
    fn take_rows(&mut self, rows: Vec<Actual>, now: Timestamp) -> Result<(), String> {
        let is_told = |row: &Actual| if row.start == ABSENT { row.finish.is_empty() } else { row.start.is_empty() };
        if let Some(row) = rows.iter().find(|row| !is_told(row)) {
            return Err(format!("{}: a robot tells that an element stands by a date, or is absent", row.id));
        }
        let rows = rows.into_iter().map(|Actual { id, start, finish, .. }| {
            let same = self.rows.get(&id).filter(|row| row.start == start && row.finish == finish).cloned();
            let row = same.unwrap_or(ToldRow { start, finish, since: now });
            (id, row)
        });
        self.rows = rows.collect();
        Ok(())
    }

    /// Takes observations. Of an element that is not seen any more what was told last stays: that nobody looks there does not make it
    /// absent.
    ///
    /// # Errors
    /// More elements than any site has.
    fn take_elements(&mut self, told: Observations, now: Timestamp) -> Result<(), String> {
        let mut elements = self.elements.clone();
        for (id, observed) in told.elements {
            let is_same = elements.get(&id).is_some_and(|before| before.observed == observed);
            if !is_same {
                elements.insert(id, ToldObservation { observed, since: now });
            }
        }
        if elements.len() > MAX_ELEMENTS {
            return Err("these are more elements than any site has".to_owned());
        }
        self.elements = elements;
        Ok(())
    }
}

/// A robot, not this one, that told last that an element stands.
fn seen_by<'a>(robots: &'a BTreeMap<String, KeptRobot>, not_by: &str, id: &str) -> Option<&'a String> {
    let others = robots.iter().filter(|(name, _)| *name != not_by);
    let mut seen = others.filter(|(_, robot)| robot.elements.get(id).is_some_and(|told| stands(&told.observed)));
    seen.next().map(|(name, _)| name)
}

/// The rows of a robot that count at a plan time. An element that another robot told last to stand is an obstacle, whatever this one
/// tells; and nobody has seen what will be.
fn counting(robots: &BTreeMap<String, KeptRobot>, name: &str, plan_time_s: Option<i64>) -> Rows {
    let Some(robot) = robots.get(name) else { return Rows::new() };
    let counts = |id: &str, row: &ToldRow| match row.is_absence() {
        true => seen_by(robots, name, id).is_none(),
        false => {
            let seen_s = row.finish.parse().ok().map(|at: PlanTime| at.civil_seconds());
            plan_time_s.is_none_or(|now_s| seen_s.is_some_and(|seen_s| seen_s <= now_s))
        }
    };
    let rows = robot.rows.iter().filter(|(id, row)| counts(id, row));
    rows.map(|(id, row)| (id.clone(), [row.start.clone(), row.finish.clone()])).collect()
}

/// The rows of robots that schedule-eval has, as its state says.
///
/// # Errors
/// A state that cannot be read.
pub(crate) fn rows_in_force(state: &Path, robots: &[RobotName]) -> Result<BTreeMap<String, Rows>, Failure> {
    let tables = ObservedTables::load(state, robots)?;
    let rows = robots.iter().filter_map(|name| {
        let rows = tables.rows_of(*name)?.iter();
        Some((name.to_string(), rows.map(|(id, row)| (id.clone(), [row.start.clone(), row.finish.clone()])).collect()))
    });
    Ok(rows.collect())
}

/// The thread.
pub(crate) struct Robots {
    serve: ServeConfig,
    settings: ServerSettings,
    shared: Arc<Shared>,
    published: Arc<Published>,
    state: PathBuf,
    document: PathBuf,
    link: Option<ServerLink>,
    robots: BTreeMap<String, KeptRobot>,
    giver: Arc<Giver>,
    board: StatusBoard,
    /// When the giver was last told what counts.
    given: Instant,
    /// Robots whose kept file is not what is known of them.
    unkept: BTreeSet<String>,
    kept: Instant,
    announced: u64,
    /// What the document is made from has changed.
    is_changed: bool,
    written: Option<(Instant, BTreeSet<String>)>,
}

/// The settings of a link.
pub(crate) fn link_settings(serve: &ServeConfig, link: &ServeLinkConfig) -> ServerSettings {
    let identity = link.certificate.clone().zip(link.key.clone());
    ServerSettings {
        site: serve.site.clone(),
        listen: link.listen.clone(),
        robots: link.robots.iter().map(ToString::to_string).collect(),
        passwords: link.passwords.clone(),
        identity: identity.map(|(certificate, key)| Identity { certificate, key }),
        robots_authority: link.robots_authority.clone(),
    }
}

fn kept_file(state: &Path, robot: &str) -> KeptFile {
    KeptFile::at(state, format!("{TOLD}/{robot}.json"))
}

impl Robots {
    /// The thread, with what was told before.
    ///
    /// # Errors
    /// Settings that cannot be used; what was kept cannot be read.
    pub(crate) fn new(
        serve: &ServeConfig,
        settings: ServerSettings,
        state: &Path,
        document: PathBuf,
        published: Arc<Published>,
        shared: Arc<Shared>,
        (giver, board): (Arc<Giver>, StatusBoard),
    ) -> Result<Self, Failure> {
        settings.check()?;
        let folder = state.join(TOLD);
        std::fs::create_dir_all(&folder).map_err(|why| format!("{} cannot be made: {why}", folder.display()))?;
        let mut robots = BTreeMap::new();
        for robot in &settings.robots {
            let read = || -> Result<KeptRobot, Failure> {
                let bytes = kept_file(state, robot).load()?;
                Ok(bytes.map(|bytes| serde_json::from_slice(&bytes)).transpose()?.unwrap_or_default())
            };
            let kept = read().unwrap_or_else(|why| {
                // It tells all of it again.
                let error = chain(why.as_ref());
                warn!(service = "site-server", robot, error, "what the robot told is not known here any more");
                KeptRobot::default()
            });
            robots.insert(robot.clone(), kept);
        }
        Ok(Self {
            serve: serve.clone(),
            settings,
            shared,
            published,
            state: state.to_owned(),
            document,
            link: None,
            robots,
            giver,
            board,
            given: Instant::now(),
            unkept: BTreeSet::new(),
            kept: Instant::now(),
            announced: 0,
            is_changed: true,
            written: None,
        })
    }

    /// Tells and takes until it is stopped.
    pub(crate) fn run(mut self) {
        let (sender, messages) = channel();
        let mut tried: Option<Instant> = None;
        loop {
            if self.shared.0.lock().is_stopped {
                self.keep();
                return;
            }
            if self.link.is_none() && tried.is_none_or(|tried| tried.elapsed() >= OPEN_INTERVAL) {
                tried = Some(Instant::now());
                self.open(sender.clone());
            }
            self.announce();
            self.take(&messages);
            self.give();
            if self.kept.elapsed() >= KEEP_INTERVAL {
                self.keep();
            }
            self.write_document();
        }
    }

    fn open(&mut self, messages: Sender<Message>) {
        let opened = ServerLink::open(&self.settings, messages);
        let error = match opened {
            Ok(link) => {
                (self.link, self.announced) = (Some(link), 0);
                info!(service = "site-server", listen = ?self.settings.listen, "robots have a link");
                None
            }
            Err(why) => Some(chain(&why)),
        };
        let mut state = self.shared.0.lock();
        if state.error != error {
            self.is_changed = true;
            if let Some(error) = &error {
                warn!(service = "site-server", error, "robots have no link");
            }
        }
        state.error = error;
    }

    /// Tells the robots of an index that is new.
    fn announce(&mut self) {
        let epoch = self.published.epoch();
        let Some(link) = self.link.as_ref().filter(|_| epoch != self.announced) else { return };
        if let Err(why) = link.announce(epoch) {
            // Robots look by themselves.
            warn!(service = "site-server", error = chain(&why), "robots are not told of the index");
        }
        self.announced = epoch;
        self.is_changed = true;
    }

    /// Takes messages that wait, for a while at most.
    fn take(&mut self, messages: &Receiver<Message>) {
        let begun = Instant::now();
        while let Some(left) = LOOK_INTERVAL.checked_sub(begun.elapsed()) {
            match messages.recv_timeout(left) {
                Ok(message) => {
                    let answer = self.answer(message.robot(), message.kind(), message.payload());
                    if let Err(why) = &answer {
                        warn!(
                            service = "site-server",
                            robot = message.robot(),
                            error = why,
                            "what a robot tells is refused"
                        );
                    }
                    message.answer(answer);
                }
                Err(RecvTimeoutError::Timeout | RecvTimeoutError::Disconnected) => return,
            }
        }
    }

    /// Takes a message of a robot: it is on disk when this returns, apart from a report.
    fn answer(&mut self, robot: &str, kind: MessageKind, payload: &[u8]) -> Result<Vec<u8>, String> {
        self.is_changed = true;
        match kind {
            MessageKind::Report => self.take_report(robot, payload),
            MessageKind::Progress => self.take_progress(robot, payload),
            MessageKind::Observations => self.take_observations(robot, payload),
        }
    }

    fn robot(&mut self, robot: &str) -> &mut KeptRobot {
        self.robots.entry(robot.to_owned()).or_default()
    }

    fn take_report(&mut self, name: &str, payload: &[u8]) -> Result<Vec<u8>, String> {
        let report = serde_json::from_slice(payload).map_err(|why| format!("the report cannot be read: {why}"))?;
        let epoch = self.published.epoch();
        let robot = self.robot(name);
        robot.told = Some((Timestamp::now(), report));
        let answer = ReportAnswer { epoch, progress: robot.progress, observations: robot.observations };
        self.unkept.insert(name.to_owned());
        serde_json::to_vec(&answer).map_err(|why| why.to_string())
    }

    fn take_progress(&mut self, name: &str, payload: &[u8]) -> Result<Vec<u8>, String> {
        let rows = parse_actuals(payload).map_err(|why| chain(&why))?;
        let before = self.robot(name).clone();
        let robot = self.robot(name);
        robot.take_rows(rows, Timestamp::now())?;
        robot.progress = Some(ContentId::of(payload));
        self.saved(name, before)
    }

    fn take_observations(&mut self, name: &str, payload: &[u8]) -> Result<Vec<u8>, String> {
        let told: Observations =
            serde_json::from_slice(payload).map_err(|why| format!("the observations cannot be read: {why}"))?;
        told.check()?;
        let before = self.robot(name).clone();
        let robot = self.robot(name);
        robot.take_elements(told, Timestamp::now())?;
        robot.observations = Some(ContentId::of(payload));
        self.saved(name, before)
    }

    /// What a robot told is on disk when this returns, or it is as before.
    fn saved(&mut self, name: &str, before: KeptRobot) -> Result<Vec<u8>, String> {
        let saved = self.save(name);
        if saved.is_err() {
            *self.robot(name) = before;
        }
        saved.map(|()| Vec::new())
    }

    /// Has schedule-eval given the rows that count now.
    fn give(&mut self) {
        if self.given.elapsed() < WRITE_INTERVAL {
            return;
        }
        self.given = Instant::now();
        let schedule: Option<Report<ScheduleFacts>> = self.board.report(Daemon::ScheduleEval);
        // Without a plan time everything is built; before it is known nothing is given.
        let Some(schedule) = schedule else { return };
        let has_told = self.robots.iter().filter(|(_, robot)| robot.progress.is_some());
        let plan_time_s = schedule.facts.plan_time_s;
        let wanted = has_told.map(|(name, _)| (name.clone(), counting(&self.robots, name, plan_time_s)));
        self.giver.want(wanted.collect());
    }

    /// What is known of a robot, on disk.
    fn save(&mut self, name: &str) -> Result<(), String> {
        let Some(robot) = self.robots.get(name) else { return Ok(()) };
        let bytes = serde_json::to_vec(robot).map_err(|why| why.to_string())?;
        let saved = kept_file(&self.state, name).saving(bytes).write();
        saved.map_err(|why| format!("the server cannot keep it: {}", chain(&why)))?;
        self.unkept.remove(name);
        Ok(())
    }

    fn keep(&mut self) {
        self.kept = Instant::now();
        for name in std::mem::take(&mut self.unkept) {
            if let Err(error) = self.save(&name) {
                warn!(service = "site-server", robot = name, error, "what a robot told is not kept");
                self.unkept.insert(name);
            }
        }
    }

    /// The document of the fleet, where it is not what it was, or robots may have become silent.
    fn write_document(&mut self) {
        let here = self.link.as_ref().map(ServerLink::here).unwrap_or_default();
        let is_due = match &self.written {
            Some((at, seen)) => {
                at.elapsed() >= WRITE_INTERVAL && (self.is_changed || *seen != here || at.elapsed() >= OPEN_INTERVAL)
            }
            None => true,
        };
        if !is_due {
            return;
        }
        let document = self.fleet(&here);
        let written = serde_json::to_vec(&document).map_err(std::io::Error::from);
        if let Err(why) = written.and_then(|bytes| replace_file(&self.document, &bytes)) {
            warn!(service = "site-server", error = chain(&why), "the document of the fleet is not written");
        }
        (self.written, self.is_changed) = (Some((Instant::now(), here)), false);
    }

    fn fleet(&self, here: &BTreeSet<String>) -> FleetDocument {
        let (now, epoch) = (Timestamp::now(), self.published.epoch());
        let robots = self.robots.iter().map(|(name, robot)| {
            let mut known = FleetRobot::of(robot.told.clone(), here.contains(name), epoch, now);
            let refused = self.giver.refused(name);
            known.findings.extend(refused.map(|why| format!("what it observed is not in force: {why}")));
            (name.clone(), known)
        });
        let told: ToldByRobot =
            self.robots.iter().map(|(name, robot)| (name.clone(), robot.elements.clone())).collect();
        let absences = |(name, robot): (&String, &KeptRobot)| {
            let rows = robot.rows.iter().filter(|(_, row)| row.is_absence());
            let absence = |(id, row): (&String, &ToldRow)| {
                let seen_by = seen_by(&self.robots, name, id).cloned();
                let is_in_force = self.giver.has(name, id);
                (id.clone(), ToldAbsence { since: row.since, seen_by, is_in_force })
            };
            (name.clone(), rows.map(absence).collect())
        };
        let absent: AbsentByRobot = self.robots.iter().map(absences).collect();
        let (elements, n_elements) = fleet_elements(&told, &absent);
        FleetDocument {
            site: self.serve.site.clone(),
            written: now,
            error: self.shared.0.lock().error.clone(),
            epoch,
            robots: robots.collect(),
            elements,
            n_elements,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(s: i64) -> Timestamp {
        Timestamp::from_second(s).unwrap()
    }

    fn observed(observation: &str) -> Observations {
        let observed = ElementObservation { observation: observation.to_owned(), verdict: "on_plan".to_owned() };
        Observations { plan_time_s: None, elements: [("wall".to_owned(), observed)].into() }
    }

    fn rows(text: &str) -> Vec<Actual> {
        parse_actuals(format!("id,start,finish\n{text}").as_bytes()).unwrap()
    }

    fn two() -> BTreeMap<String, KeptRobot> {
        ["a", "b"].map(|name| (name.to_owned(), KeptRobot::default())).into()
    }

    #[test]
    fn rows_that_are_as_before_keep_their_time() {
        let mut robot = KeptRobot::default();
        robot.take_rows(rows("wall,absent,\ndoor,,2024-03-04\n"), at(1)).unwrap();
        robot.take_rows(rows("wall,absent,\ndoor,,2024-03-05\n"), at(2)).unwrap();
        assert_eq!((robot.rows["wall"].since, robot.rows["door"].since), (at(1), at(2)));
    }

    #[test]
    fn an_absence_does_not_count_while_another_robot_told_last_that_the_element_stands() {
        let sees = |robots: &mut BTreeMap<String, KeptRobot>, observation: &str| {
            robots.get_mut("b").unwrap().take_elements(observed(observation), at(1)).unwrap();
        };
        for sees_first in [true, false] {
            let mut robots = two();
            if sees_first {
                sees(&mut robots, "observed");
            }
            robots.get_mut("a").unwrap().take_rows(rows("wall,absent,\n"), at(2)).unwrap();
            sees(&mut robots, "displaced");
            assert!(counting(&robots, "a", None).is_empty());
            // Taken back and confirmed again, or out of the other one's sight: it stands as far as is known.
            robots.get_mut("a").unwrap().take_rows(Vec::new(), at(3)).unwrap();
            robots.get_mut("a").unwrap().take_rows(rows("wall,absent,\n"), at(4)).unwrap();
            robots.get_mut("b").unwrap().take_elements(Observations::default(), at(5)).unwrap();
            assert!(counting(&robots, "a", None).is_empty());
            sees(&mut robots, "absent");
            assert_eq!(counting(&robots, "a", None)["wall"], ["absent", ""]);
        }
        // What a robot told before it saw through the place is of before.
        let mut robots = two();
        let own = robots.get_mut("a").unwrap();
        own.take_elements(observed("observed"), at(1)).unwrap();
        own.take_rows(rows("wall,absent,\n"), at(2)).unwrap();
        assert_eq!(counting(&robots, "a", None).len(), 1);
    }

    #[test]
    fn rows_of_the_future_do_not_count_and_dates_of_plans_are_refused() {
        let mut robots = two();
        let robot = robots.get_mut("a").unwrap();
        robot.take_rows(rows("wall,,2024-03-04T08:00:00\nroof,,2099-01-01T00:00:00\n"), at(1)).unwrap();
        for wrong in ["wall,2099-01-01,2099-01-02\n", "wall,2024-01-01,\n", "wall,absent,2024-01-01\n"] {
            assert!(robot.take_rows(rows(wrong), at(2)).is_err(), "{wrong}");
        }
        let now_s = "2024-03-05".parse::<PlanTime>().unwrap().civil_seconds();
        let counted = counting(&robots, "a", Some(now_s));
        assert_eq!(counted.keys().collect::<Vec<_>>(), ["wall"]);
    }

    #[test]
    fn more_elements_than_any_site_has_are_refused() {
        let mut robot = KeptRobot::default();
        let one = observed("observed").elements["wall"].clone();
        let elements = (0..=MAX_ELEMENTS).map(|n| (n.to_string(), one.clone())).collect();
        assert!(robot.take_elements(Observations { plan_time_s: None, elements }, at(1)).is_err());
        assert!(robot.elements.is_empty());
    }
}
