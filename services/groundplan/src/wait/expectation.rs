//! Reasons why an awaited output cannot come at all, from the reports of the daemons that make it.

use super::reports::is_at_work;
use crate::failure::Failure;
use bus::Daemon;
use daemon::facts::IngestFacts;
use daemon::{Report, SiteConfig, StatusBoard};
use std::time::{Duration, Instant};

/// Each makes its output from those of the daemons before it.
const CHAIN: [Daemon; 4] = [Daemon::IfcIngest, Daemon::ScheduleEval, Daemon::Rasterize, Daemon::WaypointGen];

/// A reason holds if it is there for this long: a daemon may not have taken its newest input yet.
const SETTLED: Duration = Duration::from_millis(500);
/// A daemon that died or hangs is started again, and takes what it needs, within this time.
const AWAY_TIMEOUT: Duration = Duration::from_secs(15);
/// The board is read again after this time: another user's comes through the relay.
const READ_INTERVAL: Duration = Duration::from_millis(200);

/// What a client waits for: the output of a daemon.
pub(crate) struct Expectation {
    config: SiteConfig,
    /// The board, and when it was read.
    board: Option<(StatusBoard, Instant)>,
    makers: &'static [Daemon],
    /// Why it does not come, and since when.
    reason: Option<(Reason, Instant)>,
}

/// Why an output does not come.
#[derive(Debug, Clone, PartialEq, Eq)]
enum Reason {
    /// Nothing changes until an operator does something.
    Known(String),
    /// A daemon is away, and should come back.
    Away(Daemon),
    /// All are there, and none is at work.
    Idle,
}

impl Expectation {
    /// The output of a daemon that makes maps or mission plans.
    pub(crate) fn of(config: &SiteConfig, maker: Daemon) -> Self {
        if config.follow.is_some() {
            return Self { config: config.clone(), board: None, makers: &[Daemon::SiteFollow], reason: None };
        }
        let n_makers = CHAIN.iter().position(|daemon| *daemon == maker).map_or(CHAIN.len(), |at| at + 1);
        Self { config: config.clone(), board: None, makers: &CHAIN[..n_makers], reason: None }
    }

    /// Asked again and again while the client waits.
    ///
    /// # Errors
    /// Why it cannot come, in the words of the daemon that does not make it; as long as a daemon is at work it can.
    pub(crate) fn check(&mut self) -> Result<(), Failure> {
        let now = Instant::now();
        let makers = self.makers;
        let Some(reason) = reason_of(self.board()?, makers) else {
            self.reason = None;
            return Ok(());
        };
        let since = match self.reason.take() {
            Some((before, since)) if before == reason => since,
            _ => now,
        };
        let waited = now.duration_since(since);
        let failure = match &reason {
            Reason::Known(why) if waited >= SETTLED => Some(why.clone()),
            Reason::Away(daemon) if waited >= AWAY_TIMEOUT => {
                Some(format!("{daemon} does not run, or hangs: see groundplan status"))
            }
            Reason::Idle if waited >= AWAY_TIMEOUT => Some(
                "the daemons are idle, and what they published does not belong together: see groundplan status"
                    .to_owned(),
            ),
            _ => None,
        };
        self.reason = Some((reason, since));
        failure.map_or(Ok(()), |why| Err(Failure::work(why)))
    }

    /// Why it does not come; `None` while a daemon is at work on it.
    pub(crate) fn reason(&mut self) -> Option<String> {
        let makers = self.makers;
        match reason_of(self.board().ok()?, makers)? {
            Reason::Known(why) => Some(why),
            Reason::Away(daemon) => Some(format!("{daemon} does not run, or hangs")),
            Reason::Idle => None,
        }
    }

    /// What the daemons say of themselves.
    ///
    /// # Errors
    /// No relay that serves this user.
    pub(crate) fn board(&mut self) -> Result<&StatusBoard, Failure> {
        let board = match self.board.take() {
            Some((board, read)) if read.elapsed() < READ_INTERVAL => (board, read),
            _ => (StatusBoard::of_site(&self.config).map_err(Failure::work)?, Instant::now()),
        };
        Ok(&self.board.insert(board).0)
    }
}

fn reason_of(board: &StatusBoard, makers: &[Daemon]) -> Option<Reason> {
    let reports: Vec<(Daemon, Option<Report>)> =
        makers.iter().map(|daemon| (*daemon, report_of(board, *daemon))).collect();
    // A daemon that does not make what it should may be of no account: another is at work.
    if reports.iter().any(|(_, report)| report.as_ref().is_some_and(is_at_work)) {
        return None;
    }
    let reason = |(daemon, report): (Daemon, Option<Report>)| match report {
        None => Some(Reason::Away(daemon)),
        Some(report) => what_is_missing(daemon, report).map(Reason::Known),
    };
    Some(reports.into_iter().find_map(reason).unwrap_or(Reason::Idle))
}

/// The last report of a daemon that lives and does not hang.
fn report_of(board: &StatusBoard, daemon: Daemon) -> Option<Report> {
    let report: Report = board.report(daemon).filter(|_| board.is_alive(daemon))?;
    (!report.is_silent()).then_some(report)
}

/// Why a daemon that is idle has not made what it should.
fn what_is_missing(daemon: Daemon, report: Report) -> Option<String> {
    if let Some(error) = report.error {
        return Some(format!("{daemon}: {error}"));
    }
    let has_no_model = daemon == Daemon::IfcIngest
        && serde_json::from_value::<IngestFacts>(report.facts).is_ok_and(|facts| facts.models.is_empty());
    has_no_model.then(|| "no model is loaded: groundplan load MODEL.ifc".to_owned())
}
