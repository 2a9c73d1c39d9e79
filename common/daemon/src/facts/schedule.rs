//! Facts of schedule-eval.

use crate::request::Published;
use crate::setting::SettingInForce;
use messages::ContentHash;
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
    /// Content hash of the site whose schedule it is of.
    pub site_hash: ContentHash,
    /// Plan time of the published schedule state; `None` if it shows everything as built.
    pub state_plan_time_s: Option<i64>,
    /// The plan time that it should be of: that of the clock, or of the last change before it while the clock moves.
    pub due_plan_time_s: Option<i64>,
    /// The plan time; `None` if everything is built.
    pub plan_time_s: Option<i64>,
    /// How the plan time moves, in words.
    pub clock: String,
    /// True if it follows the clock of the machine.
    pub is_wall_clock: bool,
    /// The instant after which the published schedule state is not valid; `None` if it is for good.
    pub valid_until_s: Option<i64>,
    /// When the schedule state after the published one is due by the machine's clock, milliseconds since 1970 in UTC; in the past
    /// if it is late; `None` if the plan time stands, or there is none.
    pub next_update_ms: Option<i64>,
    /// Why a plan time that moves does not follow the machine's clock: nothing tells when the next schedule state is due.
    pub clock_distrust: Option<String>,
    /// Rows of progress in force.
    pub progress: ProgressRows,
    /// Name of the time zone of the site; `None` if the rules in force name none.
    pub site_zone: Option<String>,
    /// Where rules and plan time come from.
    pub settings: Vec<SettingInForce>,
}
