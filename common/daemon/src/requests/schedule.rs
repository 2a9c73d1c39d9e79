//! Requests to schedule-eval.

use crate::facts::ProgressRows;
use crate::file_text::FileText;
use crate::request::{Published, Request};
use bus::Daemon;
use messages::ContentHash;
use serde::{Deserialize, Serialize};

/// The slowest rate of a plan time: a second of it in twelve days.
pub const MIN_RATE: f64 = 1e-6;
/// The fastest rate of a plan time: thirty years of it a second.
pub const MAX_RATE: f64 = 1e9;

/// A rate at which no plan time runs.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error("a rate of {rate:e} is none: it must be {MIN_RATE:e} to {MAX_RATE:e} seconds of plan time a second")]
pub struct RateError {
    /// The rate.
    pub rate: f64,
}

/// The rate, if a plan time can run at it.
///
/// # Errors
/// A rate below [`MIN_RATE`], above [`MAX_RATE`], or that is no number.
pub fn checked_rate(rate: f64) -> Result<f64, RateError> {
    if (MIN_RATE..=MAX_RATE).contains(&rate) { Ok(rate) } else { Err(RateError { rate }) }
}

/// Requests to schedule-eval.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum ScheduleRequest {
    /// This plan time, civil seconds since 1970.
    SetPlanTime {
        /// The instant.
        at_s: i64,
    },
    /// The first instant after a plan time at which anything changes.
    NextChange {
        /// The plan time that the client saw, civil seconds since 1970; `None` for everything built: the first instant of all.
        after_s: Option<i64>,
    },
    /// The plan time follows the clock of its machine.
    FollowWallClock,
    /// The plan time runs at a rate.
    Simulate {
        /// Plan seconds per second, from [`MIN_RATE`] to [`MAX_RATE`].
        rate: f64,
        /// Where it starts, civil seconds since 1970; where the plan time is if left out.
        from_s: Option<i64>,
    },
    /// The plan time that is in effect; nothing changes.
    GetPlanTime,
    /// What was found of the newest candidate for a site; nothing changes.
    GetVerdict,
    /// Progress that was reported or observed, a CSV table with the columns id, start, finish; without a file there is
    /// none.
    SetActuals {
        /// The table, which the client has read.
        file: Option<FileText>,
        /// Each source has a table of its own.
        #[serde(default)]
        source: ActualsSource,
        /// The robot that observed, of a site with several: each has a table of its own.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        robot: Option<String>,
    },
    /// The progress that was reported before this table. Nothing changes if the table was taken back before.
    UndoActuals {
        /// The table that the client saw in force, see [`ScheduleAnswer::table`].
        table: String,
    },
}

/// The source of progress. What people report ranks before what a robot observes.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ActualsSource {
    /// People.
    #[default]
    Reported,
    /// A robot.
    Observed,
}

/// Answer of schedule-eval.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct ScheduleAnswer {
    /// The schedule state that it published.
    pub state: Published,
    /// The plan time in effect, civil seconds since 1970; `None` if everything is built.
    pub plan_time_s: Option<i64>,
    /// How the plan time moves, in words.
    pub clock: String,
    /// Rows of progress in force.
    pub progress: ProgressRows,
    /// The table of reported progress in force, by its number and content; `None` before the first report.
    #[serde(default)]
    pub table: Option<String>,
    /// What was found of a candidate, for who asks for it; `None` if nothing was yet.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub verdict: Option<ScheduleVerdict>,
}

/// Whether a candidate for a site has a schedule with the rules, files and progress in force.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct ScheduleVerdict {
    /// Content hash of the candidate.
    pub site_hash: ContentHash,
    /// Why it has none; `None` if it has one.
    pub refused: Option<String>,
}

impl Request for ScheduleRequest {
    const DAEMON: Daemon = Daemon::ScheduleEval;
    type Answer = ScheduleAnswer;

    fn may_be_sent_twice(&self) -> bool {
        match self {
            // It starts where the plan time is when it comes.
            Self::Simulate { from_s, .. } => from_s.is_some(),
            Self::SetPlanTime { .. }
            | Self::NextChange { .. }
            | Self::FollowWallClock
            | Self::GetPlanTime
            | Self::GetVerdict
            | Self::SetActuals { .. }
            | Self::UndoActuals { .. } => true,
        }
    }
}
