//! The thread that gives schedule-eval what robots observed, until it has it: nobody who hears robots waits for that.

use bus::Bus;
use daemon::{ActualsSource, ClientError, FileText, RequestTimeouts, ScheduleRequest, Watched, chain, progress_table};
use std::collections::BTreeMap;
use std::time::Duration;
use tracing::{info, warn};

/// schedule-eval is started again within seconds; an evaluation takes seconds.
const TIMEOUTS: RequestTimeouts = RequestTimeouts { starting: Duration::from_secs(5), answer: Duration::from_secs(30) };
const POLL_INTERVAL: Duration = Duration::from_millis(5);

/// What failed is given again after this long.
const RETRY_INTERVAL: Duration = Duration::from_secs(5);

/// Rows of a table of progress by element: start, finish.
pub(crate) type Rows = BTreeMap<String, [String; 2]>;

/// What schedule-eval is to have of each robot, and what it has.
#[derive(Default)]
pub(crate) struct Giver(Watched<State>);

#[derive(Default)]
struct State {
    bus: Option<Bus>,
    wanted: BTreeMap<String, Rows>,
    given: BTreeMap<String, Rows>,
    /// Why rows of a robot are not in force.
    refused: BTreeMap<String, String>,
    is_stopped: bool,
}

impl State {
    /// A robot whose rows schedule-eval is to have and has not, of those that were not tried.
    fn next(&self, tried: &BTreeMap<String, Rows>) -> Option<(String, Rows)> {
        let is_due =
            |(name, rows): &(&String, &Rows)| self.given.get(*name) != Some(rows) && tried.get(*name) != Some(rows);
        self.wanted.iter().find(is_due).map(|(name, rows)| (name.clone(), rows.clone()))
    }
}

impl Giver {
    /// Schedule-eval has these rows, as its state says.
    pub(crate) fn having(given: BTreeMap<String, Rows>) -> Self {
        Self(Watched::new(State { given, ..State::default() }))
    }

    /// The bus of the site, in a new generation.
    pub(crate) fn attach(&self, bus: &Bus) {
        self.0.change(|state| state.bus = Some(bus.clone()));
    }

    /// Schedule-eval is to have these rows of these robots.
    pub(crate) fn want(&self, wanted: BTreeMap<String, Rows>) {
        self.0.change(|state| state.wanted = wanted);
    }

    /// Why the rows of a robot are not in force; `None` if they are, or there are none.
    pub(crate) fn refused(&self, robot: &str) -> Option<String> {
        self.0.lock().refused.get(robot).cloned()
    }

    /// True if schedule-eval has a row of an element by a robot.
    pub(crate) fn has(&self, robot: &str, id: &str) -> bool {
        self.0.lock().given.get(robot).is_some_and(|rows| rows.contains_key(id))
    }

    /// Ends the thread, with the service.
    pub(crate) fn stop(&self) {
        self.0.change(|state| state.is_stopped = true);
    }

    /// Gives until it is stopped.
    pub(crate) fn run(&self) {
        loop {
            self.give_all();
            let state = self.0.lock();
            // What failed waits for its time; what is wanted anew, or a bus that was missing, does not.
            let (wanted, has_bus) = (state.wanted.clone(), state.bus.is_some());
            drop(state);
            let is_idle =
                |state: &mut State| !state.is_stopped && state.wanted == wanted && state.bus.is_some() == has_bus;
            if self.0.wait_while(Some(RETRY_INTERVAL), is_idle).is_stopped {
                return;
            }
        }
    }

    /// Gives what schedule-eval has not, the rows of each robot once.
    fn give_all(&self) {
        let mut tried = BTreeMap::new();
        loop {
            let state = self.0.lock();
            let (next, bus) = (state.next(&tried), state.bus.clone());
            drop(state);
            let (Some((name, rows)), Some(bus)) = (next, bus) else { return };
            let given = self.give(&bus, &name, &rows);
            let mut state = self.0.lock();
            match given {
                Ok(()) => {
                    info!(
                        service = "site-server",
                        robot = name,
                        rows = rows.len(),
                        "what a robot observed is in force"
                    );
                    state.refused.remove(&name);
                    state.given.insert(name, rows);
                }
                Err(why) => {
                    let error = chain(&why);
                    if state.refused.get(&name) != Some(&error) {
                        warn!(service = "site-server", robot = name, error, "what a robot observed is not in force");
                    }
                    state.refused.insert(name.clone(), error);
                    tried.insert(name, rows);
                    // Who does not answer now does not answer for the next robot.
                    if state.is_stopped || !matches!(why, ClientError::Refused { .. }) {
                        return;
                    }
                }
            }
        }
    }

    fn give(&self, bus: &Bus, robot: &str, rows: &Rows) -> Result<(), ClientError> {
        let text = progress_table(rows.iter().map(|(id, [start, finish])| [id.as_str(), start, finish]));
        let table = FileText { path: format!("told by {robot}").into(), text };
        let request = ScheduleRequest::SetActuals {
            file: Some(table),
            source: ActualsSource::Observed,
            robot: Some(robot.to_owned()),
        };
        let pause = || {
            std::thread::sleep(POLL_INTERVAL);
            if self.0.lock().is_stopped { Err("site-server ends".into()) } else { Ok(()) }
        };
        daemon::ask(bus, &request, TIMEOUTS, |_| {}, pause).map(drop)
    }
}
