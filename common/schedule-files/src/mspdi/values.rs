//! Dates, lengths and formats of MS Project XML.

use crate::plan::{Length, PlanDate, PlanLag};
use crate::values::{number, seconds};
use frames::PlanTime;
use jiff::civil::Time;
use jiff::fmt::temporal::Pieces;
use jiff::tz::Offset;

/// A date of XML Schema; MS Project writes no offset, other programs do.
pub(super) fn date(text: &str) -> Option<PlanDate> {
    let pieces = Pieces::parse(text).ok()?;
    let offset = match text.strip_suffix(['Z', 'z']) {
        Some(_) => Some(Offset::UTC),
        None => pieces.to_numeric_offset(),
    };
    let at = pieces.date().to_datetime(pieces.time().unwrap_or(Time::midnight()));
    Some(PlanDate { at: PlanTime(at), is_day: pieces.time().is_none(), offset })
}

/// A duration of XML Schema in seconds: days, hours, minutes and seconds of it, as no program writes others.
pub(super) fn duration_s(text: &str) -> Option<i64> {
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

/// True for the formats of elapsed lengths.
pub(super) fn is_elapsed(format: &str) -> bool {
    matches!(format, "4" | "6" | "8" | "10" | "12" | "20" | "36" | "38" | "40" | "42" | "44" | "52")
}

/// A length in its format.
pub(super) fn length(text: &str, format: &str) -> Option<Length> {
    Some(Length { seconds: duration_s(text)?, is_elapsed: is_elapsed(format) })
}

/// A lag in its format; none for a lag of nothing.
pub(super) fn lag(value: &str, format: &str) -> Option<Option<PlanLag>> {
    let value = if value.is_empty() { 0.0 } else { number(value)? };
    if value == 0.0 {
        return Some(None);
    }
    let is_elapsed = is_elapsed(format);
    Some(Some(match format {
        "19" | "20" | "51" | "52" => PlanLag::Ratio { ratio: value / 100.0, is_elapsed },
        _ => PlanLag::Length(Length { seconds: seconds(value, 6.0)?, is_elapsed }),
    }))
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

    #[test]
    fn lags_are_tenths_of_minutes_or_percentages() {
        let length = |seconds, is_elapsed| Some(Some(PlanLag::Length(Length { seconds, is_elapsed })));
        assert_eq!(lag("4800", "7"), length(28_800, false));
        assert_eq!(lag("-14400", "8"), length(-86_400, true));
        assert_eq!(lag("50", "19"), Some(Some(PlanLag::Ratio { ratio: 0.5, is_elapsed: false })));
        assert_eq!(lag("-25", "52"), Some(Some(PlanLag::Ratio { ratio: -0.25, is_elapsed: true })));
        assert_eq!(lag("0", "7"), Some(None));
        assert_eq!(lag("", ""), Some(None));
        assert_eq!(lag("one", "7"), None);
    }
}
