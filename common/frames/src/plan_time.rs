//! Plan time: civil date and time at the site, without a zone.

use jiff::civil::{DateTime, datetime};
use jiff::fmt::temporal::Pieces;
use jiff::tz::TimeZone;
use jiff::{SignedDuration, Timestamp, Zoned};
use serde::{Deserialize, Serialize};
use std::fmt;
use std::str::FromStr;

/// An instant of the schedule: civil date and time at the site, without a zone.
///
/// Another type than a monotonic stamp, so that the two clocks cannot be mixed up.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(transparent)]
pub struct PlanTime(pub DateTime);

/// The instant from which civil seconds are counted.
const EPOCH: DateTime = datetime(1970, 1, 1, 0, 0, 0, 0);

/// A text that is no plan time.
#[derive(Debug, thiserror::Error)]
pub enum PlanTimeError {
    /// It is no date of ISO 8601.
    #[error("{text:?} is no date; write 2024-04-15 or 2024-04-15T08:30:00")]
    Unreadable {
        /// As written.
        text: String,
        /// Why.
        source: jiff::Error,
    },
    /// It has an offset, `Z` or a time zone, and the zone of the site is not known.
    #[error(
        "{text:?} carries a time zone: set site_zone in the schedule rules (see config/schedule.toml), or write the time at the \
         site without one"
    )]
    NoSiteZone {
        /// As written.
        text: String,
    },
}

/// A plan time as it was written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct WrittenPlanTime {
    /// The instant; midnight if no time of day was written.
    pub at: PlanTime,
    /// True if no time of day was written.
    pub is_day: bool,
}

impl PlanTime {
    /// The last second of the calendar: 9999-12-31T23:59:59.
    pub const LAST: Self = Self(datetime(9999, 12, 31, 23, 59, 59, 0));

    /// Reads a date or date-time of ISO 8601; one with an offset, `Z` or a time zone is converted to the zone of the site.
    ///
    /// # Errors
    /// A text that is no date, or that carries a time zone while the site's is not known.
    pub fn parse(text: &str, site_zone: Option<&TimeZone>) -> Result<WrittenPlanTime, PlanTimeError> {
        let unreadable = |source| PlanTimeError::Unreadable { text: text.to_owned(), source };
        let pieces = Pieces::parse(text).map_err(unreadable)?;
        let instant: Timestamp = match (pieces.time_zone_annotation(), pieces.offset()) {
            (Some(_), _) => text.parse::<Zoned>().map_err(unreadable)?.timestamp(),
            (None, Some(_)) => text.parse().map_err(unreadable)?,
            (None, None) => {
                let at = text.parse().map(PlanTime).map_err(unreadable)?;
                return Ok(WrittenPlanTime { at, is_day: pieces.time().is_none() });
            }
        };
        let zone = site_zone.ok_or_else(|| PlanTimeError::NoSiteZone { text: text.to_owned() })?;
        Ok(WrittenPlanTime { at: Self(zone.to_datetime(instant)), is_day: false })
    }

    /// Seconds of the civil calendar since 1970-01-01T00:00: for archives.
    pub fn civil_seconds(self) -> i64 {
        self.0.duration_since(EPOCH).as_secs()
    }

    /// The plan time of [`Self::civil_seconds`]; `None` outside the years -9999 to 9999.
    pub fn from_civil_seconds(seconds: i64) -> Option<Self> {
        EPOCH.checked_add(SignedDuration::from_secs(seconds)).ok().map(Self)
    }
}

impl FromStr for PlanTime {
    type Err = PlanTimeError;

    /// Reads `2024-04-15` (its midnight) or `2024-04-15T08:30:00`, at the site.
    fn from_str(text: &str) -> Result<Self, Self::Err> {
        Self::parse(text, None).map(|written| written.at)
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
        let is_day = |text: &str| PlanTime::parse(text, None).unwrap().is_day;
        assert!(is_day("2024-04-15") && !is_day("2024-04-15T00:00") && !is_day("2024-04-15 00:00:00"));
    }

    #[test]
    fn civil_seconds_reach_from_the_first_to_the_last_second_of_the_calendar() {
        for text in ["-009999-01-01T00:00:00", "1969-12-31T23:59:59", "9999-12-31T00:00:00", "9999-12-31T23:59:59"] {
            let at: PlanTime = text.parse().unwrap();
            assert_eq!(at.to_string(), text);
            assert_eq!(PlanTime::from_civil_seconds(at.civil_seconds()), Some(at), "{text}");
        }
        let last: PlanTime = "9999-12-31T23:59:59".parse().unwrap();
        assert_eq!(PlanTime::from_civil_seconds(last.civil_seconds() + 1), None);
        assert_eq!([i64::MIN, i64::MAX].map(PlanTime::from_civil_seconds), [None, None]);
    }

    #[test]
    fn a_time_zone_is_converted_to_that_of_the_site_or_refused() {
        let zone = TimeZone::get("Europe/Amsterdam").unwrap();
        for (text, expected) in [
            ("2024-04-15T08:00:00+02:00", "2024-04-15T08:00:00"),
            ("2024-04-15T06:00:00Z", "2024-04-15T08:00:00"),
            ("2024-04-15t06:00z", "2024-04-15T08:00:00"),
            ("2024-04-15 23:30:00-05:00", "2024-04-16T06:30:00"),
            ("2024-01-15T08:00:00+00:00", "2024-01-15T09:00:00"),
            ("2024-04-15T08:00:00[Asia/Tokyo]", "2024-04-15T01:00:00"),
            ("2024-04-15T08:00:00+09:00[Asia/Tokyo]", "2024-04-15T01:00:00"),
            ("2024-04-15T08:00:00", "2024-04-15T08:00:00"),
        ] {
            assert_eq!(PlanTime::parse(text, Some(&zone)).unwrap().at.to_string(), expected, "{text}");
            let carries_zone = text != "2024-04-15T08:00:00";
            let without = PlanTime::parse(text, None);
            assert_eq!(matches!(without, Err(PlanTimeError::NoSiteZone { .. })), carries_zone, "{text}");
            assert_eq!(text.parse::<PlanTime>().is_err(), carries_zone, "{text}");
        }
        // The offset is not that of the zone.
        assert!(PlanTime::parse("2024-04-15T08:00:00+02:00[Asia/Tokyo]", Some(&zone)).is_err());
        for text in ["2024-04-15Z", "2024-04-15+02:00", "08:00:00+02:00", "2024-04-15T25:00:00Z", ""] {
            let refused = PlanTime::parse(text, Some(&zone));
            assert!(matches!(refused, Err(PlanTimeError::Unreadable { .. })), "{text}");
        }
    }
}
