//! Dates of questions: instants, days and periods.

use frames::{PlanTime, PlanTimeError, WrittenPlanTime};
use jiff::tz::TimeZone;
use schedule::Period;

const DAY_S: i64 = 86_400;

/// A text that is no period.
#[derive(Debug, thiserror::Error)]
pub enum PeriodError {
    /// No date, or an offset where the zone of the site is not known.
    #[error(transparent)]
    Date(#[from] PlanTimeError),
    /// Its end is not after its start.
    #[error("{until} is not after {from}")]
    Order {
        /// The start.
        from: String,
        /// The end.
        until: String,
    },
}

/// What a map serves: an instant, a whole day, or all from a date until the end of another.
///
/// # Errors
/// A text that is no date, an end that is not after the start.
pub fn period_of(from: &str, until: Option<&str>, site_zone: Option<&TimeZone>) -> Result<Period, PeriodError> {
    let written = PlanTime::parse(from, site_zone)?;
    let from_s = written.at.civil_seconds();
    let until_s = match until {
        Some(until) => Some(end_s(PlanTime::parse(until, site_zone)?)),
        None => written.is_day.then(|| end_s(written)),
    };
    if until_s.is_some_and(|until_s| until_s <= from_s) {
        let until = until.unwrap_or_default().to_owned();
        return Err(PeriodError::Order { from: from.to_owned(), until });
    }
    Ok(Period { from_s, until_s })
}

/// As a finish: one without a time is the end of its day, on the last day of the calendar its last second.
pub fn end_s(written: WrittenPlanTime) -> i64 {
    let at_s = written.at.civil_seconds();
    if written.is_day { (at_s + DAY_S).min(PlanTime::LAST.civil_seconds()) } else { at_s }
}
