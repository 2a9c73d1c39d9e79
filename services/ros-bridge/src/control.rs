//! Changes of the site that other nodes ask for, where it allows them.

use bus::Daemon;
use daemon::facts::{AlignFacts, AlignmentSummary, RosBridgeFacts};
use daemon::{
    AlignAnswer, AlignRequest, Confirmations, Failure, IngestRequest, KnownPlaces, Published, Report, Request,
    Revision, RevisionEffect, RosBridgeRequest, ScheduleAnswer, ScheduleRequest, SearchState, SiteConfig, StatusBoard,
    ask_site,
};
use frames::PlanTime;
use messages::{AlignmentVerdict, plan_time};
use std::time::{Duration, Instant};

/// For the alignment that came of a search to be told.
const TOLD_TIMEOUT: Duration = Duration::from_secs(20);
/// For a search; after it the search goes on, and its alignment comes when it has ended.
const SEARCH_TIMEOUT: Duration = Duration::from_secs(60);
/// Interval between two looks.
const POLL_INTERVAL: Duration = Duration::from_millis(50);

/// Asks the daemons of a site.
pub(crate) struct Control {
    pub(crate) config: SiteConfig,
}

impl Control {
    fn ask<R: Request>(&self, request: &R) -> Result<R::Answer, Failure> {
        ask_site(&self.config, request)
    }

    /// The plan time goes on to the next change.
    ///
    /// # Errors
    /// The daemon refuses or does not answer.
    pub(crate) fn next_change(&self) -> Result<String, Failure> {
        self.config.check_draws()?;
        let after_s = self.ask(&ScheduleRequest::GetPlanTime)?.plan_time_s;
        Ok(plan_time_text(&self.ask(&ScheduleRequest::NextChange { after_s })?))
    }

    /// Another plan time, as `2024-04-15` or `2024-04-15T08:30:00` at the site.
    ///
    /// # Errors
    /// A text that is none; the daemon refuses or does not answer.
    pub(crate) fn set_plan_time(&self, text: &str) -> Result<String, Failure> {
        let at: PlanTime = text.parse()?;
        Ok(plan_time_text(&self.set_plan_time_s(at.civil_seconds())?))
    }

    /// Another plan time, in civil seconds since 1970.
    ///
    /// # Errors
    /// The daemon refuses or does not answer.
    pub(crate) fn set_plan_time_s(&self, at_s: i64) -> Result<ScheduleAnswer, Failure> {
        self.config.check_draws()?;
        self.ask(&ScheduleRequest::SetPlanTime { at_s })
    }

    /// Another map storey; `None` for that of configuration or alignment.
    ///
    /// # Errors
    /// The bridge's own service does not answer.
    pub(crate) fn set_storey(&self, storey: Option<u32>) -> Result<(), Failure> {
        self.ask(&RosBridgeRequest::SetStorey { storey })
    }

    /// Searches the pose of the robot's map, first on the storey that the robot is known to be on, and waits for the end.
    ///
    /// # Errors
    /// There is no map, the search fails, no pose is accepted.
    pub(crate) fn align(&self) -> Result<String, Failure> {
        let of_storey = self.known_storey().map(|storey| self.search(Some(storey)));
        let found = match of_storey {
            Some(Ok(found)) if is_accepted(&found) => found,
            // The robot may have been carried since then.
            _ => self.search(None)?,
        };
        if is_accepted(&found) { Ok(found.to_string()) } else { Err(found.to_string().into()) }
    }

    fn search(&self, storey: Option<u32>) -> Result<AlignmentSummary, Failure> {
        let request = AlignRequest::Align { hint: None, storey, places: KnownPlaces::default() };
        let AlignAnswer::Search(search) = self.ask(&request)? else {
            return Err("slam-align answers in other words".into());
        };
        let begun = Instant::now();
        while begun.elapsed() < SEARCH_TIMEOUT {
            match self.ask(&AlignRequest::SearchResult { search })? {
                AlignAnswer::SearchState(SearchState::Done { alignment, .. }) => return self.published(&alignment),
                AlignAnswer::SearchState(SearchState::Failed { why }) => return Err(why.into()),
                _ => std::thread::sleep(POLL_INTERVAL),
            }
        }
        Err("the search has not ended: its alignment comes when it has".into())
    }

    /// The alignment that came of a search, or a later one.
    fn published(&self, alignment: &Published) -> Result<AlignmentSummary, Failure> {
        let begun = Instant::now();
        loop {
            if let Some(summary) = self.alignment().filter(|summary| summary.epoch >= alignment.epoch) {
                return Ok(summary);
            }
            if begun.elapsed() > TOLD_TIMEOUT {
                return Err("slam-align has not told its alignment".into());
            }
            std::thread::sleep(POLL_INTERVAL);
        }
    }

    fn known_storey(&self) -> Option<u32> {
        let board = StatusBoard::of_own(&self.config);
        let report: Report<RosBridgeFacts> = board.report(Daemon::RosBridge)?;
        report.facts.known_storey
    }

    fn alignment(&self) -> Option<AlignmentSummary> {
        let board = StatusBoard::of_own(&self.config);
        let report: Report<AlignFacts> = board.report(Daemon::SlamAlign)?;
        report.facts.alignment
    }

    /// Confirms the pose or the revision of the model that waits.
    ///
    /// # Errors
    /// Nothing waits, or both do: then an operator has to say which.
    pub(crate) fn confirm(&self) -> Result<String, Failure> {
        // Of a site that another machine draws, revisions wait there.
        let revision = match self.config.check_draws() {
            Ok(()) => Some(self.ask(&IngestRequest::GetRevision)?),
            Err(_) => None,
        };
        let revision =
            revision.filter(|answer| answer.effect == RevisionEffect::Waits).and_then(|answer| answer.revision);
        let AlignAnswer::Confirmations(Confirmations { waiting, .. }) = self.ask(&AlignRequest::ListConfirmed)? else {
            return Err("slam-align answers in other words".into());
        };
        match (revision, waiting) {
            (Some(_), Some(_)) => {
                Err("a revision of the model and a pose wait: groundplan confirm model, or pose".into())
            }
            (Some(Revision { sha256, .. }), None) => match self.ask(&IngestRequest::Confirm { sha256 })?.effect {
                RevisionEffect::InForce => Ok("the revision of the model is in force".to_owned()),
                _ => Err("its files have changed since it was compared: it waits again".into()),
            },
            (None, Some(waiting)) => {
                self.ask(&AlignRequest::ConfirmPose { waiting })?;
                Ok("the pose of the SLAM map is in effect".to_owned())
            }
            (None, None) => Err("neither a revision of the model nor a pose waits".into()),
        }
    }
}

fn plan_time_text(answer: &ScheduleAnswer) -> String {
    match answer.plan_time_s.and_then(plan_time) {
        Some(at) => format!("plan time {at}, {}", answer.clock),
        None => "everything is built".to_owned(),
    }
}

/// True if a search found the pose that is in effect.
fn is_accepted(found: &AlignmentSummary) -> bool {
    found.verdict == AlignmentVerdict::Accepted.name() && found.is_effective()
}
