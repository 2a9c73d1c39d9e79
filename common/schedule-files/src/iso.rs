//! Dates and durations of ISO 8601 as XML Schema has them.

use crate::plan::PlanDate;
use crate::values::{number, seconds};
use frames::PlanTime;
use jiff::civil::Time;
use jiff::fmt::temporal::Pieces;
use jiff::tz::Offset;

/// A date with or without time of day, and with the offset that is written.
pub(crate) fn date(text: &str) -> Option<PlanDate> {
    let pieces = Pieces::parse(text).ok()?;
    let offset = match text.strip_suffix(['Z', 'z']) {
        Some(_) => Some(Offset::UTC),
        None => pieces.to_numeric_offset(),
    };
    let at = pieces.date().to_datetime(pieces.time().unwrap_or(Time::midnight()));
    Some(PlanDate { at: PlanTime(at), is_day: pieces.time().is_none(), offset })
}

/// A duration of XML Schema in seconds: days, hours, minutes and seconds of it, as no program writes others.
pub(crate) fn duration_s(text: &str) -> Option<i64> {
    let (sign, rest) = text.strip_prefix('-').map_or((1.0, text), |rest| (-1.0, rest));
    let (days, times) = rest.strip_prefix('P')?.split_once('T').unwrap_or((rest.strip_prefix('P')?, ""));
    let mut sum_s = 0.0;
    let mut n_parts = 0;
    for (mut part, units) in [(days, &[('D', 86_400.0)][..]), (times, &[('H', 3600.0), ('M', 60.0), ('S', 1.0)])] {
        for (unit, unit_s) in units {
            if let Some((value, after)) = part.split_once(*unit) {
                sum_s += number(value)? * unit_s;
                part = after;
                n_parts += 1;
            }
        }
        if !part.is_empty() {
            return None;
        }
    }
    if n_parts == 0 { None } else { seconds(sum_s, sign) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn durations_are_days_hours_minutes_and_seconds() {
        assert_eq!(duration_s("PT8H30M0S"), Some(30_600));
        assert_eq!(duration_s("P1DT0.5H"), Some(88_200));
        assert_eq!(duration_s("-PT1H"), Some(-3600));
        assert_eq!(duration_s("P2D"), Some(172_800));
        for text in ["", "P", "PT", "8", "P1Y", "P1M", "PT1X", "PT1S1H", "PTH", "PT1e300H"] {
            assert_eq!(duration_s(text), None, "{text}");
        }
    }

    #[test]
    fn dates_have_the_offset_that_is_written() {
        let check = |text: &str| date(text).map(|date| (date.at.to_string(), date.is_day, date.offset));
        let at = || "2024-03-04T08:00:00".to_owned();
        assert_eq!(check("2024-03-04T08:00:00"), Some((at(), false, None)));
        assert_eq!(check("2024-03-04T08:00:00Z"), Some((at(), false, Some(Offset::UTC))));
        assert_eq!(check("2024-03-04T08:00:00+02:00"), Some((at(), false, Offset::from_hours(2).ok())));
        assert_eq!(check("2024-03-04"), Some(("2024-03-04T00:00:00".to_owned(), true, None)));
        assert_eq!(check("2024-02-30T08:00:00"), None);
        assert_eq!(check("NA"), None);
    }
}
