//! The thread that has the link with the robots: it tells them of indices, and takes what they tell. Observed progress goes to
//! schedule-eval, which merges it; all else is in the document of the fleet.

use crate::publication::Shared as Published;
use bus::{Bus, RobotName};
use daemon::{
    AbsentByRobot, ActualsSource, ElementObservation, Failure, FileText, FleetDocument, FleetRobot, KeptFile,
    MAX_TABLE_BYTES, Observations, ObservedTables, ReportAnswer, RequestTimeouts, RobotReport, ScheduleRequest,
    ServeConfig, ServeLinkConfig, ToldAbsence, ToldByRobot, ToldObservation, chain, fleet_elements, replace_file,
};
use fleet_link::{Message, MessageKind, ServerIdentity, ServerLink, ServerSettings};
use jiff::Timestamp;
use messages::{ContentId, Observation};
use schedule::{ABSENT, Actual, parse_actuals};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
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

/// schedule-eval answers within seconds, and is started again within seconds.
const TIMEOUT: Duration = Duration::from_secs(30);
const RETRY_INTERVAL: Duration = Duration::from_millis(2);

/// What robots told, in the state folder.
const KEPT_FOLDER: &str = "fleet";

/// A longer report is none of a robot.
const MAX_REPORT_BYTES: usize = 256 << 10;

/// Shared with the service.
#[derive(Default)]
pub(crate) struct Shared {
    state: Mutex<State>,
}

#[derive(Default)]
struct State {
    bus: Option<Bus>,
    /// Why there is no link.
    error: Option<String>,
    is_stopped: bool,
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The bus of the site, in a new generation.
    pub(crate) fn attach(&self, bus: &Bus) {
        self.lock().bus = Some(bus.clone());
    }

    /// Why robots have no link.
    pub(crate) fn error(&self) -> Option<String> {
        self.lock().error.clone()
    }

    /// Ends the thread, with the service.
    pub(crate) fn stop(&self) {
        self.lock().is_stopped = true;
    }
}

/// What is kept of a robot.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
#[serde(default)]
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
    /// The robot that saw an element stand after this one told that it is absent: the row does not count.
    withdrawn_by: Option<String>,
}

impl ToldRow {
    fn is_absence(&self) -> bool {
        self.start == ABSENT
    }
}

impl KeptRobot {
    /// The rows that count, as schedule-eval has them.
    fn counting(&self) -> Rows {
        let counting = self.rows.iter().filter(|(_, row)| row.withdrawn_by.is_none());
        counting.map(|(id, row)| (id.clone(), [row.start.clone(), row.finish.clone()])).collect()
    }

    /// Takes a table; rows that are as before keep their time, and what became of them.
    fn take_rows(&mut self, rows: Vec<Actual>, now: Timestamp) {
        let rows = rows.into_iter().map(|Actual { id, start, finish, .. }| {
            let same = self.rows.get(&id).filter(|row| row.start == start && row.finish == finish).cloned();
            let row = same.unwrap_or(ToldRow { start, finish, since: now, withdrawn_by: None });
            (id, row)
        });
        self.rows = rows.collect();
    }

    /// Takes observations; the answer are elements that it did not tell to stand before.
    fn take_elements(&mut self, told: Observations, now: Timestamp) -> Vec<String> {
        let stands = |observed: &ElementObservation| observed.observation != Observation::Absent.name();
        let mut found = Vec::new();
        let elements = told.elements.into_iter().map(|(id, observed)| {
            let before = self.elements.get(&id);
            if stands(&observed) && before.is_none_or(|before| !stands(&before.observed)) {
                found.push(id.clone());
            }
            let since = before.filter(|before| before.observed == observed).map_or(now, |before| before.since);
            (id, ToldObservation { observed, since })
        });
        self.elements = elements.collect();
        found
    }
}

/// Rows of a table of progress by element: start, finish.
type Rows = BTreeMap<String, [String; 2]>;

/// The rows as text.
fn table_text(rows: &Rows) -> String {
    let mut text = "id,start,finish\n".to_owned();
    let quoted = |text: &str| format!("\"{}\"", text.replace('"', "\"\""));
    for (id, [start, finish]) in rows {
        // Writing to a string does not fail.
        let _ = writeln!(text, "{},{},{}", quoted(id), quoted(start), quoted(finish));
    }
    text
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
    /// The rows of robots that schedule-eval has.
    given: BTreeMap<String, Rows>,
    /// When giving them failed last.
    ungiven: Option<Instant>,
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
        identity: identity.map(|(certificate, key)| ServerIdentity { certificate, key }),
        robots_authority: link.robots_authority.clone(),
    }
}

fn kept_file(state: &Path, robot: &str) -> KeptFile {
    KeptFile::at(state, format!("{KEPT_FOLDER}/{robot}.json"))
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
    ) -> Result<Self, Failure> {
        settings.check()?;
        let names: Vec<RobotName> = serve.link.iter().flat_map(|link| link.robots.clone()).collect();
        // After a death between both, schedule-eval and what is kept here may say different things.
        let in_force = ObservedTables::load(state, &names)?;
        let rows_in_force = |name: &RobotName| {
            let rows = in_force.rows_of(*name)?.iter();
            Some((
                name.to_string(),
                rows.map(|(id, row)| (id.clone(), [row.start.clone(), row.finish.clone()])).collect(),
            ))
        };
        let given = names.iter().filter_map(rows_in_force).collect();
        let folder = state.join(KEPT_FOLDER);
        std::fs::create_dir_all(&folder).map_err(|why| format!("{} cannot be made: {why}", folder.display()))?;
        let mut robots = BTreeMap::new();
        for robot in &settings.robots {
            let kept = match kept_file(state, robot).load() {
                Ok(Some(bytes)) => serde_json::from_slice(&bytes)?,
                Ok(None) => KeptRobot::default(),
                // The robot tells it again.
                Err(why) => {
                    warn!(service = "site-server", robot, error = chain(&why), "what the robot told is lost here");
                    KeptRobot::default()
                }
            };
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
            given,
            ungiven: Some(Instant::now()),
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
            if self.shared.lock().is_stopped {
                self.keep();
                return;
            }
            if self.link.is_none() && tried.is_none_or(|tried| tried.elapsed() >= OPEN_INTERVAL) {
                tried = Some(Instant::now());
                self.open(sender.clone());
            }
            self.announce();
            self.take(&messages);
            if self.ungiven.is_some_and(|since| since.elapsed() >= OPEN_INTERVAL) {
                self.give_all();
            }
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
        let mut state = self.shared.lock();
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
        match link.announce(epoch) {
            Ok(()) => self.announced = epoch,
            // Robots look by themselves meanwhile.
            Err(why) => warn!(service = "site-server", error = chain(&why), "robots are not told of the index"),
        }
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
        if payload.len() > MAX_REPORT_BYTES {
            return Err("the report is larger than any can be".to_owned());
        }
        let report = serde_json::from_slice(payload).map_err(|why| format!("the report cannot be read: {why}"))?;
        let epoch = self.published.epoch();
        let robot = self.robot(name);
        robot.told = Some((Timestamp::now(), report));
        let answer = ReportAnswer { epoch, progress: robot.progress, observations: robot.observations };
        self.unkept.insert(name.to_owned());
        serde_json::to_vec(&answer).map_err(|why| why.to_string())
    }

    fn take_progress(&mut self, name: &str, payload: &[u8]) -> Result<Vec<u8>, String> {
        if payload.len() as u64 > MAX_TABLE_BYTES {
            return Err("the table is larger than any can be".to_owned());
        }
        let rows = parse_actuals(payload).map_err(|why| chain(&why))?;
        let before = self.robot(name).clone();
        let robot = self.robot(name);
        robot.take_rows(rows, Timestamp::now());
        robot.progress = Some(ContentId::of(payload));
        let taken = self.give(name).and_then(|()| self.save(name));
        if taken.is_err() {
            *self.robot(name) = before;
        }
        taken.map(|()| Vec::new())
    }

    fn take_observations(&mut self, name: &str, payload: &[u8]) -> Result<Vec<u8>, String> {
        let told: Observations =
            serde_json::from_slice(payload).map_err(|why| format!("the observations cannot be read: {why}"))?;
        told.check()?;
        let robot = self.robot(name);
        let found = robot.take_elements(told, Timestamp::now());
        robot.observations = Some(ContentId::of(payload));
        // An element that stands is an obstacle, whoever confirmed before that it is absent.
        for id in found {
            for (other, robot) in self.robots.iter_mut().filter(|(other, _)| *other != name) {
                let absence = robot.rows.get_mut(&id).filter(|row| row.is_absence() && row.withdrawn_by.is_none());
                if let Some(row) = absence {
                    warn!(
                        service = "site-server",
                        id,
                        confirmed_on = other,
                        seen_by = name,
                        "an absent element is seen to stand"
                    );
                    row.withdrawn_by = Some(name.to_owned());
                    self.unkept.insert(other.clone());
                }
            }
        }
        self.keep();
        self.give_all();
        self.save(name).map(|()| Vec::new())
    }

    /// Gives schedule-eval the rows of a robot that count, unless it has them.
    fn give(&mut self, name: &str) -> Result<(), String> {
        let rows = self.robots.get(name).map(KeptRobot::counting).unwrap_or_default();
        if self.given.get(name).is_some_and(|given| *given == rows) {
            return Ok(());
        }
        let bus = self.shared.lock().bus.clone().ok_or("the server has no bus yet")?;
        let table = FileText { path: format!("told by {name}").into(), text: table_text(&rows) };
        let request = ScheduleRequest::SetActuals {
            file: Some(table),
            source: ActualsSource::Observed,
            robot: Some(name.to_owned()),
        };
        let timeouts = RequestTimeouts { starting: TIMEOUT, answer: TIMEOUT };
        let pause = || {
            std::thread::sleep(RETRY_INTERVAL);
            Ok(())
        };
        daemon::ask(&bus, &request, timeouts, |_| {}, pause).map_err(|why| chain(&why))?;
        info!(service = "site-server", robot = name, rows = rows.len(), "observed progress is applied");
        self.given.insert(name.to_owned(), rows);
        Ok(())
    }

    /// The same for all robots; what fails is given again later.
    fn give_all(&mut self) {
        let has_told = |robot: &KeptRobot| robot.progress.is_some();
        let names: Vec<String> =
            self.robots.iter().filter(|(_, robot)| has_told(robot)).map(|(name, _)| name.clone()).collect();
        self.ungiven = None;
        for name in names {
            if let Err(error) = self.give(&name) {
                warn!(service = "site-server", robot = name, error, "observed progress is not applied yet");
                self.ungiven = Some(Instant::now());
                return;
            }
        }
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
        let robots = self
            .robots
            .iter()
            .map(|(name, robot)| (name.clone(), FleetRobot::of(robot.told.clone(), here.contains(name), epoch, now)));
        let told: ToldByRobot =
            self.robots.iter().map(|(name, robot)| (name.clone(), robot.elements.clone())).collect();
        let absent: AbsentByRobot = self
            .robots
            .iter()
            .map(|(name, robot)| {
                let absences = robot.rows.iter().filter(|(_, row)| row.is_absence());
                let absence = |(id, row): (&String, &ToldRow)| {
                    (id.clone(), ToldAbsence { since: row.since, withdrawn_by: row.withdrawn_by.clone() })
                };
                (name.clone(), absences.map(absence).collect())
            })
            .collect();
        let (elements, n_elements) = fleet_elements(&told, &absent);
        FleetDocument {
            site: self.serve.site.clone(),
            written: now,
            error: self.shared.lock().error.clone(),
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

    #[test]
    fn rows_that_are_as_before_keep_their_time_and_what_became_of_them() {
        let mut robot = KeptRobot::default();
        let rows = |text: &str| parse_actuals(format!("id,start,finish\n{text}").as_bytes()).unwrap();
        robot.take_rows(rows("wall,absent,\ndoor,,2024-03-04\n"), at(1));
        robot.rows.get_mut("wall").unwrap().withdrawn_by = Some("b".to_owned());
        robot.take_rows(rows("wall,absent,\ndoor,,2024-03-05\n"), at(2));
        assert_eq!((robot.rows["wall"].since, robot.rows["door"].since), (at(1), at(2)));
        assert_eq!(table_text(&robot.counting()), "id,start,finish\n\"door\",\"\",\"2024-03-05\"\n");
        // Taken back and confirmed again, it counts.
        robot.take_rows(rows("door,,2024-03-05\n"), at(3));
        robot.take_rows(rows("wall,absent,\ndoor,,2024-03-05\n"), at(4));
        assert_eq!(robot.counting()["wall"], ["absent", ""]);
    }

    #[test]
    fn an_element_is_found_when_it_was_not_told_to_stand_before() {
        let mut robot = KeptRobot::default();
        assert_eq!(robot.take_elements(observed("observed"), at(1)), ["wall"]);
        assert!(robot.take_elements(observed("observed"), at(2)).is_empty());
        assert_eq!(robot.elements["wall"].since, at(1));
        assert!(robot.take_elements(observed("absent"), at(3)).is_empty());
        assert_eq!(robot.take_elements(observed("displaced"), at(4)), ["wall"]);
        assert!(robot.take_elements(Observations::default(), at(5)).is_empty());
        assert_eq!(robot.take_elements(observed("observed"), at(6)), ["wall"]);
    }
}
