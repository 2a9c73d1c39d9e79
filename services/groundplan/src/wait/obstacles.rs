//! Reasons why the maps of a certain sample do not come, from the last reports of the daemons.

use super::reports::is_at_work;
use crate::failure::Failure;
use bus::{Daemon, TopicName};
use daemon::facts::RasterizeFacts;
use daemon::{Report, SiteConfig, StatusBoard};
use serde::de::IgnoredAny;
use std::time::{Duration, Instant};

/// The daemons between a site and its maps, in the order of the data.
const WAY: [Daemon; 2] = [Daemon::ScheduleEval, Daemon::Rasterize];
/// An error that lasts for this time does not go away by itself.
const LASTS: Duration = Duration::from_secs(2);
/// Waiting without a word for longer looks like hanging.
const SILENT: Duration = Duration::from_secs(3);

/// Watches the daemons that are between a sample and the maps that are made from it.
pub(crate) struct Obstacles {
    board: StatusBoard,
    /// The sample.
    topic: TopicName,
    epoch: u64,
    begun: Instant,
    /// An error, and since when it is there.
    error: Option<(String, Instant)>,
    has_told: bool,
}

impl Obstacles {
    /// Between this sample and the maps.
    ///
    /// # Errors
    /// A user who may not see the reports.
    pub(crate) fn after(config: &SiteConfig, topic: TopicName, epoch: u64) -> Result<Self, Failure> {
        let board = StatusBoard::of_site(config).map_err(Failure::work)?;
        Ok(Self { board, topic, epoch, begun: Instant::now(), error: None, has_told: false })
    }

    /// The maps that are out; `None` before the first.
    pub(crate) fn maps(&self) -> Option<RasterizeFacts> {
        self.board.report(Daemon::Rasterize).map(|report: Report<RasterizeFacts>| report.facts)
    }

    /// Why no maps will come: a daemon has handled the sample and has had an error since. Says once on standard error what
    /// is waited for, if it takes long.
    pub(crate) fn reason(&mut self) -> Option<String> {
        let found = self.find();
        self.error = match (self.error.take(), found) {
            (Some((before, since)), Some(now)) if before == now => Some((now, since)),
            (_, now) => now.map(|now| (now, Instant::now())),
        };
        if !self.has_told && self.begun.elapsed() >= SILENT {
            self.has_told = true;
            eprintln!("groundplan: waits for new maps: {}", self.words());
        }
        self.error.as_ref().filter(|(_, since)| since.elapsed() >= LASTS).map(|(error, _)| error.clone())
    }

    fn find(&self) -> Option<String> {
        let epoch_of = |report: &Report<IgnoredAny>, topic: TopicName| report.epochs.get(&topic.to_string()).copied();
        let reports: Vec<(Daemon, Report<IgnoredAny>)> =
            WAY.into_iter().map(|daemon| Some((daemon, self.board.report(daemon)?))).collect::<Option<_>>()?;
        let mut newest_state = None;
        for (_, report) in &reports {
            let state = epoch_of(report, TopicName::ScheduleState);
            // What comes before the newest schedule state says nothing about the maps of it.
            if epoch_of(report, self.topic) < Some(self.epoch) || state < newest_state || is_at_work(report) {
                return None;
            }
            newest_state = state;
        }
        reports.into_iter().find_map(|(daemon, report)| Some(format!("{daemon}: {}", report.error?)))
    }

    /// What the daemons do.
    fn words(&self) -> String {
        let words = WAY.into_iter().map(|daemon| match self.board.report::<IgnoredAny>(daemon) {
            _ if !self.board.is_alive(daemon) => format!("{daemon} does not run"),
            Some(report) if report.is_silent() => format!("{daemon} hangs"),
            Some(report) => format!("{daemon} is {}", report.activity),
            None => format!("{daemon} has just started"),
        });
        words.collect::<Vec<_>>().join(", ")
    }
}
