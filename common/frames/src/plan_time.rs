//! The time of the construction schedule.

use jiff::Timestamp;
use jiff::civil::DateTime;
use jiff::tz::TimeZone;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::str::FromStr;

/// An instant of the schedule: civil date and time at the site, without a zone.
///
/// Another type than a monotonic stamp, so that the two clocks cannot be mixed up.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(transparent)]
pub struct PlanTime(pub DateTime);

/// A text that is no plan time.
#[derive(Debug, thiserror::Error)]
#[error("{text:?} is no date; write 2024-04-15 or 2024-04-15T08:30:00")]
pub struct PlanTimeError {
    text: String,
    source: jiff::Error,
}

impl PlanTime {
    /// Seconds of the civil calendar since 1970-01-01T00:00: for archives.
    pub fn civil_seconds(self) -> i64 {
        TimeZone::UTC.to_timestamp(self.0).map_or(i64::MAX, |t| t.as_second())
    }

    /// The plan time of [`Self::civil_seconds`]; `None` outside the years -9999 to 9999.
    pub fn from_civil_seconds(seconds: i64) -> Option<Self> {
        Timestamp::from_second(seconds).ok().map(|t| Self(TimeZone::UTC.to_datetime(t)))
    }
}

impl FromStr for PlanTime {
    type Err = PlanTimeError;

    /// Reads `2024-04-15` (its midnight) or `2024-04-15T08:30:00`.
    fn from_str(text: &str) -> Result<Self, Self::Err> {
        text.parse().map(PlanTime).map_err(|source| PlanTimeError { text: text.to_owned(), source })
    }
}

impl fmt::Display for PlanTime {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_date_without_a_time_is_its_midnight() {
        let day: PlanTime = "2024-04-15".parse().unwrap();
        assert_eq!(day.to_string(), "2024-04-15T00:00:00");
        assert_eq!(PlanTime::from_civil_seconds(day.civil_seconds()), Some(day));
        assert!("yesterday".parse::<PlanTime>().is_err());
    }
}
