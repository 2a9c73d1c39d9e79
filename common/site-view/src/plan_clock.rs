//! The end of a schedule state: the time at which the next one is due, by the clock of who asks.

use jiff::Timestamp;

/// When the schedule state after the newest one is due, as schedule-eval says.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub enum NextState {
    /// None is: the plan time stands, or there is no later change.
    #[default]
    None,
    /// By the machine's clock.
    Due {
        /// Milliseconds since 1970 in UTC.
        utc_ms: i64,
    },
    /// Nothing tells: the plan time moves, but does not follow the machine's clock.
    Unknown {
        /// Why.
        why: String,
    },
}

/// What the clock of a consumer shows when it asks whether maps may be used.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ClockTime {
    /// It has none, or it stands: no schedule state runs out by it.
    Unknown,
    /// The plan time, in civil seconds since 1970: of a robot that keeps it itself.
    Plan(i64),
    /// The machine's clock, in milliseconds since 1970 in UTC: of who knows when the next schedule state is due.
    Machine(i64),
}

/// A due time in UTC (RFC 3339); empty for one that no calendar has.
pub(crate) fn utc_text(utc_ms: i64) -> String {
    Timestamp::from_millisecond(utc_ms).map(|due| due.to_string()).unwrap_or_default()
}
