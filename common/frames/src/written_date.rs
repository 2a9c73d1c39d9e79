//! Dates as files and people write them: ISO 8601, or day, month and year in a configured order.

use crate::{PlanTime, PlanTimeError};
use jiff::Timestamp;
use jiff::civil::DateTime;
use jiff::tz::{Offset, TimeZone};
use serde::Deserialize;

/// Seconds of a civil day.
pub const DAY_S: i64 = 86_400;

/// Order of day, month and year in text dates.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum DateOrder {
    /// 15/04/2024.
    Dmy,
    /// 04/15/2024.
    Mdy,
    /// 2024-04-15, and nothing else.
    Iso,
}

impl DateOrder {
    /// For people.
    pub fn words(self) -> &'static str {
        match self {
            Self::Dmy => "day/month/year",
            Self::Mdy => "month/day/year",
            Self::Iso => "year-month-day",
        }
    }
}

/// A date that was read: civil seconds since 1970-01-01T00:00.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct WrittenDate {
    at_s: i64,
    /// No time of day was given.
    is_day: bool,
}

impl WrittenDate {
    /// A date that was read already: civil seconds at the site, or of a clock with this offset to UTC in seconds.
    ///
    /// # Errors
    /// An offset where the zone of the site is not known, or a date beyond the calendar.
    pub fn of_seconds(
        at_s: i64,
        is_day: bool,
        offset_s: Option<i64>,
        site_zone: Option<&TimeZone>,
    ) -> Result<Self, DateError> {
        let Some(offset_s) = offset_s else { return Ok(Self { at_s, is_day }) };
        let utc_s = at_s.saturating_sub(offset_s);
        let instant = Timestamp::from_second(utc_s).map_err(|_| DateError::Unreadable(utc_s.to_string()))?;
        let written = || {
            let offset = i32::try_from(offset_s).ok().and_then(|s| Offset::from_seconds(s).ok());
            instant.display_with_offset(offset.unwrap_or(Offset::UTC)).to_string()
        };
        let zone = site_zone.ok_or_else(|| DateError::NoSiteZone(written()))?;
        Ok(Self { at_s: seconds(zone.to_datetime(instant)), is_day: false })
    }

    /// As a start: a day begins at its midnight.
    pub fn start_s(self) -> i64 {
        self.at_s
    }

    /// As a finish: a day ends at the next midnight, the last one of the calendar with its last second.
    pub fn finish_s(self) -> i64 {
        if self.is_day { self.end_of_day_s() } else { self.at_s }
    }

    /// The end of its day at any time of day.
    pub fn end_of_day_s(self) -> i64 {
        ((self.at_s.div_euclid(DAY_S) + 1) * DAY_S).min(PlanTime::LAST.civil_seconds())
    }
}

/// Why a text is no date.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum DateError {
    /// It has no digit.
    #[error("{0:?} is a placeholder, not a date")]
    Placeholder(String),
    /// It is no date in any order.
    #[error("{0:?} is no date")]
    Unreadable(String),
    /// It is a date in another order only.
    #[error("{text:?} is no date in the order {}", order.words())]
    OtherOrder {
        /// As written.
        text: String,
        /// The order that was asked for.
        order: DateOrder,
    },
    /// It has an offset or `Z`, and the zone of the site is not known.
    #[error("{0:?} carries a time zone; say which zone the site is in (site_zone)")]
    NoSiteZone(String),
}

/// Reads an ISO 8601 date or date-time; one with an offset is converted to the site's zone.
///
/// # Errors
/// See [`DateError`].
pub fn parse_iso(text: &str, site_zone: Option<&TimeZone>) -> Result<WrittenDate, DateError> {
    let text = text.trim();
    let unreadable =
        || if text.bytes().any(|b| b.is_ascii_digit()) { DateError::Unreadable } else { DateError::Placeholder };
    let wrong = || unreadable()(text.to_owned());
    if !is_iso(text) {
        return Err(wrong());
    }
    let written = PlanTime::parse(text, site_zone).map_err(|error| match error {
        PlanTimeError::NoSiteZone { text } => DateError::NoSiteZone(text),
        PlanTimeError::Unreadable { .. } => wrong(),
    })?;
    Ok(WrittenDate { at_s: written.at.civil_seconds(), is_day: written.is_day })
}

/// True if the text begins like an ISO 8601 date: `2024-04-..`.
pub fn is_iso(text: &str) -> bool {
    let b = text.trim().as_bytes();
    b.len() >= 10 && b[..4].iter().all(u8::is_ascii_digit) && b[4] == b'-' && b[7] == b'-'
}

/// Reads a date as a property holds it: ISO 8601 always, else day, month and year in this order.
///
/// # Errors
/// See [`DateError`].
pub fn parse(text: &str, order: DateOrder, site_zone: Option<&TimeZone>) -> Result<WrittenDate, DateError> {
    if is_iso(text) || order == DateOrder::Iso {
        return parse_iso(text, site_zone).map_err(|error| match error {
            DateError::Unreadable(text) if numbers(&text).is_some() => DateError::OtherOrder { text, order },
            error => error,
        });
    }
    // In which orders it is a date does not depend on the zone.
    match [order, other(order)].map(|order| in_order(text, order, &TimeZone::UTC).is_some()) {
        [true, _] => parse_iso(&iso_text(text, order).unwrap_or_default(), site_zone).map_err(|error| match error {
            DateError::NoSiteZone(_) => DateError::NoSiteZone(text.trim().to_owned()),
            error => error,
        }),
        [false, true] => Err(DateError::OtherOrder { text: text.trim().to_owned(), order }),
        // Its error says what is wrong with the text.
        [false, false] => parse_iso(text, site_zone),
    }
}

/// Reads day, month and year in this order, with an optional time of day and offset.
pub fn in_order(text: &str, order: DateOrder, site_zone: &TimeZone) -> Option<WrittenDate> {
    parse_iso(&iso_text(text, order)?, Some(site_zone)).ok()
}

/// Day, month and year in this order as ISO 8601 has them, with what follows.
fn iso_text(text: &str, order: DateOrder) -> Option<String> {
    let ([first, second, year], time) = numbers(text)?;
    let (day, month) = if order == DateOrder::Mdy { (second, first) } else { (first, second) };
    let time = time.map_or_else(String::new, |time| format!("T{time}"));
    Some(format!("{year:04}-{month:02}-{day:02}{time}"))
}

/// Seconds since 1970-01-01 UTC, as IfcTimeStamp counts.
///
/// # Errors
/// A number that is no instant, or no zone of the site.
pub fn from_timestamp(number: f64, site_zone: Option<&TimeZone>) -> Result<WrittenDate, DateError> {
    let whole = || Timestamp::from_second(number as i64).ok().filter(|_| number.is_finite());
    let instant = whole().ok_or_else(|| DateError::Unreadable(number.to_string()))?;
    let zone = site_zone.ok_or_else(|| DateError::NoSiteZone(number.to_string()))?;
    Ok(WrittenDate { at_s: seconds(zone.to_datetime(instant)), is_day: false })
}

/// Three numbers with one kind of separator, the last of four digits, and what follows a blank.
fn numbers(text: &str) -> Option<([u32; 3], Option<&str>)> {
    let text = text.trim();
    let (date, time) = match text.split_once([' ', 'T']) {
        Some((date, time)) => (date, Some(time.trim())),
        None => (text, None),
    };
    let separator = date.chars().find(|c| !c.is_ascii_digit()).filter(|c| ['/', '-', '.'].contains(c))?;
    let parts: Vec<&str> = date.split(separator).collect();
    let &[first, second, year] = parts.as_slice() else { return None };
    let is_number =
        |part: &str, digits: &[usize]| digits.contains(&part.len()) && part.bytes().all(|b| b.is_ascii_digit());
    if !is_number(first, &[1, 2]) || !is_number(second, &[1, 2]) || !is_number(year, &[4]) {
        return None;
    }
    Some(([first.parse().ok()?, second.parse().ok()?, year.parse().ok()?], time))
}

fn other(order: DateOrder) -> DateOrder {
    if order == DateOrder::Dmy { DateOrder::Mdy } else { DateOrder::Dmy }
}

fn seconds(at: DateTime) -> i64 {
    crate::PlanTime(at).civil_seconds()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(text: &str) -> i64 {
        seconds(text.parse().unwrap())
    }

    #[test]
    fn a_day_starts_at_its_midnight_and_ends_at_the_next() {
        let day = parse_iso("2024-03-04", None).unwrap();
        assert_eq!((day.start_s(), day.finish_s()), (at("2024-03-04T00:00"), at("2024-03-05T00:00")));
        let noon = parse_iso("2024-03-04T12:00:00", None).unwrap();
        assert_eq!((noon.start_s(), noon.finish_s()), (at("2024-03-04T12:00"), at("2024-03-04T12:00")));
        assert_eq!(noon.end_of_day_s(), at("2024-03-05T00:00"));
    }

    #[test]
    fn the_last_day_of_the_calendar_is_a_date_like_any_other() {
        let last = parse_iso("9999-12-31", None).unwrap();
        assert_eq!((last.start_s(), last.finish_s()), (at("9999-12-31T00:00"), at("9999-12-31T23:59:59")));
        assert_eq!(last.end_of_day_s(), last.finish_s());
    }

    #[test]
    fn an_offset_is_converted_to_the_zone_of_the_site_and_never_ignored() {
        let zone = TimeZone::get("Europe/Amsterdam").unwrap();
        let check = |text: &str| parse_iso(text, Some(&zone)).unwrap().start_s();
        assert_eq!(check("2024-07-01T08:00:00Z"), at("2024-07-01T10:00"));
        assert_eq!(check("2024-07-01T08:00:00+05:30"), at("2024-07-01T04:30"));
        assert_eq!(check("2024-07-01T08:00:00[Asia/Tokyo]"), at("2024-07-01T01:00"));
        let text = "01/07/2024 08:00:00+01:00";
        assert_eq!(parse(text, DateOrder::Dmy, Some(&zone)).unwrap().start_s(), at("2024-07-01T09:00"));
        assert_eq!(parse(text, DateOrder::Dmy, None), Err(DateError::NoSiteZone(text.to_owned())));
        assert!(matches!(parse("15/07/2024 08:00Z", DateOrder::Mdy, None), Err(DateError::OtherOrder { .. })));
        assert!(matches!(parse_iso("2024-07-01T08:00:00+01:00", None), Err(DateError::NoSiteZone(_))));
        assert_eq!(from_timestamp(1_719_820_800.0, Some(&zone)).unwrap().start_s(), at("2024-07-01T10:00"));
    }

    #[test]
    fn what_is_no_date_is_an_error_and_a_placeholder_is_named_as_such() {
        for text in ["2024-02-30", "2024-13-01", "2024-03-04T25:00:00", "12/2024", "1/2/24", "31/31/2024", "8"] {
            assert!(matches!(parse(text, DateOrder::Dmy, None), Err(DateError::Unreadable(_))), "{text}");
        }
        for text in ["InstallationDate", "", "n/a"] {
            assert!(matches!(parse(text, DateOrder::Dmy, None), Err(DateError::Placeholder(_))), "{text}");
        }
    }

    #[test]
    fn orders_are_not_mixed() {
        assert_eq!(parse("08/04/2024", DateOrder::Dmy, None).unwrap().start_s(), at("2024-04-08T00:00"));
        assert_eq!(parse("08/04/2024", DateOrder::Mdy, None).unwrap().start_s(), at("2024-08-04T00:00"));
        assert_eq!(parse("6-2-2015", DateOrder::Dmy, None).unwrap().start_s(), at("2015-02-06T00:00"));
        assert_eq!(parse("1.2.2024 14:30", DateOrder::Dmy, None).unwrap().finish_s(), at("2024-02-01T14:30"));
        assert_eq!(parse("2024-04-08", DateOrder::Mdy, None).unwrap().start_s(), at("2024-04-08T00:00"));
        assert!(matches!(parse("15/04/2024", DateOrder::Mdy, None), Err(DateError::OtherOrder { .. })));
        assert!(matches!(parse("15/04/2024", DateOrder::Iso, None), Err(DateError::OtherOrder { .. })));
    }
}
