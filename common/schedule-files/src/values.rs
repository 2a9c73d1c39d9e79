//! Single values as the products write them.

use crate::plan::PlanDate;
use frames::PlanTime;
use jiff::civil::DateTime;

/// No length of a schedule is longer, in seconds: a thousand years.
const MAX_S: f64 = 366.0 * 86_400.0 * 1000.0;

/// A date with time of day, as `2024-03-04 08:00` or `2024-03-04T08:00:00`; without a zone.
pub(crate) fn date(text: &str) -> Option<PlanDate> {
    let at: DateTime = text.parse().ok()?;
    Some(PlanDate { at: PlanTime(at), is_day: text.len() <= "2024-03-04".len(), offset: None })
}

/// A finite number, with a decimal point or comma.
pub(crate) fn number(text: &str) -> Option<f64> {
    let value: f64 = if text.contains(',') { text.replace(',', ".").parse() } else { text.parse() }.ok()?;
    value.is_finite().then_some(value)
}

/// So many units of so many seconds, as whole seconds.
pub(crate) fn seconds(value: f64, unit_s: f64) -> Option<i64> {
    let seconds = value * unit_s;
    (seconds.abs() <= MAX_S).then_some(seconds.round() as i64)
}

/// Seconds of the day of `8:00`, `08:00:00`, `08:00:00.000` or `8:00 PM`; midnight at the end of the day is given as 0.
///
/// Parts of a second and an offset to UTC behind the seconds do not count: working time is that of the site.
pub(crate) fn time_of_day(text: &str) -> Option<u32> {
    let upper = text.trim().to_ascii_uppercase();
    let (clock, is_afternoon) = match (upper.strip_suffix("AM"), upper.strip_suffix("PM")) {
        (Some(clock), _) => (clock, Some(false)),
        (_, Some(clock)) => (clock, Some(true)),
        _ => (upper.as_str(), None),
    };
    let mut parts = clock.trim().splitn(3, ':');
    let (hour, minute) = (parts.next()?.parse::<u32>().ok()?, parts.next()?.parse::<u32>().ok()?);
    let second = parts.next().map_or(Some(0), whole_second)?;
    let hour = match is_afternoon {
        Some(is_afternoon) if (1..=12).contains(&hour) => hour % 12 + if is_afternoon { 12 } else { 0 },
        Some(_) => return None,
        None if hour == 24 && minute == 0 && second == 0 => 0,
        None => hour,
    };
    (hour < 24 && minute < 60 && second < 60).then_some(hour * 3600 + minute * 60 + second)
}

/// Seconds of `30`, `30.250`, `30Z` and `30+02:00`.
fn whole_second(text: &str) -> Option<u32> {
    let (clock, offset) = text.split_at(text.find(['Z', '+', '-']).unwrap_or(text.len()));
    let is_offset = match offset.get(1..).and_then(|offset| offset.split_once(':')) {
        Some((hours, minutes)) => [hours, minutes].iter().all(|part| part.len() == 2 && is_digits(part)),
        None => ["", "Z"].contains(&offset),
    };
    let (whole, fraction) = clock.split_once(['.', ',']).unwrap_or((clock, "0"));
    if is_offset && is_digits(fraction) { whole.parse().ok() } else { None }
}

fn is_digits(text: &str) -> bool {
    !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_of_day_are_read_with_12_and_24_hours() {
        assert_eq!(time_of_day("08:30"), Some(30_600));
        assert_eq!(time_of_day("8:30:10 PM"), Some(20 * 3600 + 1810));
        assert_eq!(time_of_day("12:00 AM"), Some(0));
        assert_eq!(time_of_day("24:00"), Some(0));
        for text in ["07:00:30.000", "07:00:30.9", "07:00:30Z", "07:00:30.5+02:00", "7:00:30.0 AM"] {
            assert_eq!(time_of_day(text), Some(7 * 3600 + 30), "{text}");
        }
        assert!(
            [
                "",
                "8",
                "8:60",
                "25:00",
                "24:30",
                "13:00 PM",
                "8:00:00:00",
                "8:00:00.",
                "8:00:00.x",
                "8:00:00+2",
                "8:00.5",
                "24:00:01"
            ]
            .iter()
            .all(|text| time_of_day(text).is_none())
        );
    }

    #[test]
    fn dates_are_read_with_a_space_or_a_t() {
        assert_eq!(date("2024-03-04 08:00"), date("2024-03-04T08:00:00"));
        assert!(date("2024-03-04").unwrap().is_day);
        assert!(date("2024-02-30 08:00").is_none());
    }

    #[test]
    fn numbers_are_finite_and_lengths_are_bounded() {
        assert_eq!(number("8,5"), Some(8.5));
        assert!(number("inf").is_none() && number("1.2.3").is_none());
        assert!(seconds(1e12, 3600.0).is_none());
        assert_eq!(seconds(-0.5, 3600.0), Some(-1800));
    }
}
