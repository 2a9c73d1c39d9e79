//! Dates on the command line.

use crate::failure::Failure;
use frames::PlanTime;
use messages::PhaseHead;
use schedule_eval::Period;

const DAY_S: i64 = 86_400;

/// An instant; a date without a time is its midnight.
///
/// # Errors
/// A text that is no date.
pub(crate) fn instant_s(text: &str) -> Result<i64, Failure> {
    let time: PlanTime = text.parse().map_err(Failure::usage)?;
    Ok(time.civil_seconds())
}

/// What a map serves: an instant, a whole day, or all from `date` until the end of `until`.
///
/// # Errors
/// A text that is no date, an end that is not after the start.
pub(crate) fn period(date: &str, until: Option<&str>) -> Result<Period, Failure> {
    let from_s = instant_s(date)?;
    // A finish without a time is the end of its day.
    let end_s = |text: &str| Ok::<i64, Failure>(instant_s(text)? + if is_day(text) { DAY_S } else { 0 });
    let until_s = match until {
        Some(until) => Some(end_s(until)?),
        None if is_day(date) => Some(end_s(date)?),
        None => None,
    };
    if until_s.is_some_and(|until_s| until_s <= from_s) {
        return Err(Failure::usage(format!("--until {} is not after --date {date}", until.unwrap_or_default())));
    }
    Ok(Period { from_s, until_s })
}

fn is_day(text: &str) -> bool {
    text.parse::<jiff::civil::Date>().is_ok() && !text.contains(['T', 't', ' '])
}

/// A plan time for people and JSON.
pub(crate) fn text(seconds: i64) -> String {
    messages::plan_time(seconds).map(|t| t.to_string()).unwrap_or_default()
}

/// The seconds, unless they stand for none.
pub(crate) fn known(seconds: i64) -> Option<i64> {
    Some(seconds).filter(|s| *s != PhaseHead::NO_TIME)
}

/// The same for people and JSON.
pub(crate) fn optional_text(seconds: i64) -> Option<String> {
    known(seconds).map(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_day_counts_whole_and_an_instant_is_one() {
        let at = |text: &str| instant_s(text).unwrap();
        let check = |date: &str, until: Option<&str>| period(date, until).unwrap().until_s;
        assert_eq!(check("2024-04-15", None), Some(at("2024-04-16")));
        assert_eq!(check("2024-04-15T08:00:00", None), None);
        assert_eq!(check("2024-04-15T08:00:00", Some("2024-04-15T17:00:00")), Some(at("2024-04-15T17:00:00")));
        assert_eq!(check("2024-04-15", Some("2024-04-19")), Some(at("2024-04-20")));
        assert!(period("2024-04-15", Some("2024-04-14")).is_err());
        assert!(period("15/04/2024", None).is_err());
    }
}
