//! The table of observed progress that schedule-eval has: sent again until it is that in force, also after a death.

use bus::{Bus, RobotName};
use daemon::{
    ActualsSource, Epochs, Failure, FileText, FollowRequest, OutputEnd, RequestTimeouts, ScheduleRequest, SiteConfig,
    write_durably,
};
use std::path::PathBuf;
use std::time::Duration;
use tracing::info;

/// Schedule evaluation answers within milliseconds, and is started again within seconds.
const TIMEOUT: Duration = Duration::from_secs(30);
const RETRY_INTERVAL: Duration = Duration::from_millis(2);

/// Gives schedule-eval a table, which is in force there when this returns. It is waited for where the last argument says so.
pub type GiveTable = dyn FnMut(&Bus, FileText, bool) -> Result<(), Failure> + Send;

/// Who takes what a robot observed.
#[derive(Debug, Clone, Copy)]
pub(crate) enum TableTaker {
    /// schedule-eval, of a site that is drawn here: the table is of this robot.
    ScheduleEval(Option<RobotName>),
    /// site-follow, which tells the server of the site.
    SiteFollow,
}

impl TableTaker {
    pub(crate) fn of(config: &SiteConfig) -> Self {
        config.follow.as_ref().map_or(Self::ScheduleEval(config.robot_name), |_| Self::SiteFollow)
    }
}

/// Gives a table of this robot by a request.
pub(crate) fn give_table(bus: &Bus, taker: TableTaker, table: FileText, waits: bool) -> Result<(), Failure> {
    let timeouts = RequestTimeouts { starting: if waits { TIMEOUT } else { Duration::ZERO }, answer: TIMEOUT };
    let pause = || {
        std::thread::sleep(RETRY_INTERVAL);
        Ok(())
    };
    match taker {
        TableTaker::ScheduleEval(robot) => {
            let robot = robot.map(|robot| robot.to_string());
            let request = ScheduleRequest::SetActuals { file: Some(table), source: ActualsSource::Observed, robot };
            daemon::ask(bus, &request, timeouts, |_| {}, pause)?;
            info!(service = "slam-align", "observations applied");
        }
        TableTaker::SiteFollow => {
            daemon::ask(bus, &FollowRequest::SetObserved { table }, timeouts, |_| {}, pause)?;
            info!(service = "slam-align", "observations are told to the server of the site");
        }
    }
    Ok(())
}

/// The table in force.
pub(crate) struct ObservedTable {
    give: Box<GiveTable>,
    bus: Option<Bus>,
    table: FileText,
    is_pending: bool,
    /// What was in force before the decision that is underway.
    before: Option<String>,
}

impl ObservedTable {
    /// This table is in force. The file holds the last one that was given; without it that was `empty`.
    pub(crate) fn new(give: Box<GiveTable>, file: PathBuf, table: String, empty: &str) -> Self {
        let given = std::fs::read_to_string(&file);
        let is_pending = given.as_deref().unwrap_or(empty) != table;
        Self { give, bus: None, table: FileText { path: file, text: table }, is_pending, before: None }
    }

    /// Another table is in force. It is given at once where a client waits for that, else as what is pending.
    ///
    /// # Errors
    /// A client waits, and the table cannot be given.
    pub(crate) fn set(&mut self, table: String, is_asked: bool) -> Result<(), Failure> {
        self.before = Some(std::mem::replace(&mut self.table.text, table));
        self.is_pending = true;
        if is_asked { self.give(true) } else { Ok(()) }
    }

    /// Gives the table that is pending.
    ///
    /// # Errors
    /// It cannot be given.
    fn give(&mut self, waits: bool) -> Result<(), Failure> {
        if self.is_pending {
            let bus = self.bus.as_ref().ok_or("it is not attached to a bus")?;
            (self.give)(bus, self.table.clone(), waits)?;
            // A death before this gives it once more.
            write_durably(&self.table.path, self.table.text.as_bytes())?;
            self.is_pending = false;
        }
        Ok(())
    }
}

impl OutputEnd for ObservedTable {
    fn attach(&mut self, bus: &Bus, _: &mut Epochs) -> Result<(), Failure> {
        self.bus = Some(bus.clone());
        Ok(())
    }

    fn settle(&mut self) {
        self.before = None;
    }

    /// The table before is in force, and pending.
    fn go_back(&mut self, _: &mut Epochs) {
        if let Some(before) = self.before.take() {
            (self.table.text, self.is_pending) = (before, true);
        }
    }

    /// True while schedule-eval has another table.
    fn is_pending(&self) -> bool {
        self.is_pending
    }

    fn retry(&mut self, _: &mut Epochs) -> Result<(), Failure> {
        self.give(false)
    }
}
