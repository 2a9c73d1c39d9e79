//! Facts of schedule-eval.

use crate::request::Published;
use crate::setting::SettingInForce;
use serde::{Deserialize, Serialize};

/// Rows of progress in force.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct ProgressRows {
    /// Reported by people.
    pub reported: usize,
    /// Observed by a robot.
    pub observed: usize,
}

/// Facts of schedule-eval. Times are civil seconds since 1970.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct ScheduleFacts {
    /// The schedule state that is published.
    pub state: Published,
    /// The plan time; `None` if everything is built.
    pub plan_time_s: Option<i64>,
    /// How the plan time moves, in words.
    pub clock: String,
    /// The instant after which the published schedule state is not valid; `None` if it is for good.
    pub valid_until_s: Option<i64>,
    /// When the next schedule state is due by the machine's clock, milliseconds since 1970 in UTC; `None` if the plan time
    /// stands, or there is none.
    pub next_update_ms: Option<i64>,
    /// Rows of progress in force.
    pub progress: ProgressRows,
    /// Where rules and plan time come from.
    pub settings: Vec<SettingInForce>,
}
