//! Parses durations: ISO 8601 in files, `5d` on command lines.

use frames::written_date::DAY_S;
use messages::ScheduleLength;

/// Longest duration that is accepted: ten thousand years.
const MAX_S: f64 = 10_000.0 * 366.0 * 86_400.0;

/// A duration with its days apart: what a day is depends on the calendar.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct WrittenDuration {
    weeks: f64,
    days: f64,
    seconds: f64,
}

/// How long a day is, and a week.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum DayLength {
    /// 24 hours, and seven days.
    Elapsed,
    /// So many working seconds, and five days.
    Working { day_s: i64 },
}

/// A text that is no duration.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub(crate) enum DurationError {
    #[error("{0:?} is no duration; write e.g. P3D or PT16H")]
    Unreadable(String),
    #[error("{0:?} counts years or months, whose length is not fixed")]
    Calendar(String),
}

impl WrittenDuration {
    /// A length of a schedule; a text is ISO 8601.
    pub(crate) fn of(length: ScheduleLength<'_>) -> Result<Self, DurationError> {
        match length {
            ScheduleLength::Text(text) => parse(text),
            ScheduleLength::Seconds(seconds) => Ok(Self { weeks: 0.0, days: 0.0, seconds: seconds as f64 }),
        }
    }

    /// In whole seconds.
    pub(crate) fn seconds(&self, day: DayLength) -> i64 {
        let (day_s, week_days) = match day {
            DayLength::Elapsed => (DAY_S, 7.0),
            DayLength::Working { day_s } => (day_s, 5.0),
        };
        ((self.weeks * week_days + self.days) * day_s as f64 + self.seconds).round() as i64
    }

    /// True if its length depends on what a day is.
    pub(crate) fn counts_days(&self) -> bool {
        self.weeks != 0.0 || self.days != 0.0
    }
}

/// Reads an ISO 8601 duration: `P3D`, `PT16H`, `P0Y0M1DT8H0M0S`, `-P1W`, fractions with point or comma.
///
/// jiff's durations are not used, because they fold a day into 24 hours or refuse to.
pub(crate) fn parse(text: &str) -> Result<WrittenDuration, DurationError> {
    let unreadable = || DurationError::Unreadable(text.to_owned());
    let upper = text.trim().to_ascii_uppercase().replace(',', ".");
    let (sign, rest) = match upper.strip_prefix('-') {
        Some(rest) => (-1.0, rest),
        None => (1.0, upper.strip_prefix('+').unwrap_or(&upper)),
    };
    let rest = rest.strip_prefix('P').ok_or_else(unreadable)?;
    let (date, time) = rest.split_once('T').map_or((rest, None), |(date, time)| (date, Some(time)));
    let parts = |text: &str, units: &str| parts(text, units).ok_or_else(unreadable);
    let date_parts = parts(date, "YMWD")?;
    let time_parts = time.map_or(Ok([0.0; 4]), |time| parts(time, "HMS").map(|[h, m, s, _]| [h, m, s, 0.0]))?;
    if date.is_empty() && time.is_none_or(str::is_empty) {
        return Err(unreadable());
    }
    let ([years, months, weeks, days], [hours, minutes, seconds, _]) = (date_parts, time_parts);
    if years != 0.0 || months != 0.0 {
        return Err(DurationError::Calendar(text.to_owned()));
    }
    let seconds = hours * 3600.0 + minutes * 60.0 + seconds;
    let found = WrittenDuration { weeks: sign * weeks, days: sign * days, seconds: sign * seconds };
    let longest_s = (weeks * 7.0 + days) * DAY_S as f64 + seconds;
    if longest_s <= MAX_S { Ok(found) } else { Err(unreadable()) }
}

/// Reads a shift of a command line: `5d`, `8h`, `1w2d`, `1d4h`, `30m`, or an ISO 8601 duration.
pub(crate) fn parse_shift(text: &str) -> Result<WrittenDuration, DurationError> {
    let upper = text.trim().to_ascii_uppercase();
    let (sign, plain) = upper.strip_prefix('-').map_or(("", upper.as_str()), |plain| ("-", plain));
    if plain.starts_with('P') {
        return parse(text);
    }
    // Minutes stand behind days here: there are no months.
    let split = plain.find(['W', 'D']).map_or(0, |_| plain.rfind(['W', 'D']).map_or(0, |at| at + 1));
    let (date, time) = plain.split_at(split);
    let time = if time.is_empty() { String::new() } else { format!("T{time}") };
    parse(&format!("{sign}P{date}{time}")).map_err(|_| DurationError::Unreadable(text.to_owned()))
}

/// Numbers before their units, in the order of the units; `None` if anything else stands there.
fn parts(text: &str, units: &str) -> Option<[f64; 4]> {
    let mut found = [0.0; 4];
    let (mut rest, mut next) = (text, 0);
    while !rest.is_empty() {
        let at = rest.find(|c: char| !c.is_ascii_digit() && c != '.')?;
        let unit = rest[at..].chars().next()?;
        let place = units[next..].find(unit)? + next;
        let number = &rest[..at];
        if !number.starts_with(|c: char| c.is_ascii_digit()) {
            return None;
        }
        found[place] = number.parse().ok()?;
        next = place + 1;
        rest = &rest[at + unit.len_utf8()..];
    }
    Some(found)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const EIGHT_HOURS: DayLength = DayLength::Working { day_s: 8 * 3600 };

    #[test]
    fn durations_of_real_files_are_read() {
        for (text, elapsed_s, working_s) in [
            ("P3D", 3 * 86_400, 3 * 28_800),
            ("PT16H", 57_600, 57_600),
            ("P0Y0M1DT8H0M0S", 86_400 + 28_800, 28_800 + 28_800),
            ("P2W", 14 * 86_400, 10 * 28_800),
            ("PT0.5H", 1_800, 1_800),
            ("PT1,5M", 90, 90),
            ("-P1D", -86_400, -28_800),
            ("PT28800.4S", 28_800, 28_800),
            ("p0d", 0, 0),
        ] {
            let found = parse(text).unwrap();
            assert_eq!(
                (found.seconds(DayLength::Elapsed), found.seconds(EIGHT_HOURS)),
                (elapsed_s, working_s),
                "{text}"
            );
        }
        assert!(parse("P1DT2H").unwrap().counts_days() && !parse("PT48H").unwrap().counts_days());
    }

    #[test]
    fn what_is_no_duration_is_refused() {
        for text in
            ["", "P", "PT", "3D", "P3", "P3X", "PT3D", "PDT", "P3D4D", "P1DT", "P 3D", "P1E3D", "P9999999999D", "P.D"]
        {
            let refused = parse(text);
            // A trailing T without a time is common and harmless.
            assert!(refused.is_err() || text == "P1DT", "{text}: {refused:?}");
        }
        assert!(matches!(parse("P1M"), Err(DurationError::Calendar(_))));
    }

    #[test]
    fn shifts_are_days_hours_and_weeks() {
        let check = |text: &str| parse_shift(text).unwrap().seconds(EIGHT_HOURS);
        assert_eq!(
            ["5d", "8h", "30m", "2w", "1d4h", "1w2d", "P3D", "-2d"].map(check),
            [144_000, 28_800, 1_800, 288_000, 43_200, 201_600, 86_400, -57_600]
        );
        assert!(["5", "d", "soon", "5d5d", ""].iter().all(|text| parse_shift(text).is_err()));
    }

    proptest! {
        #[test]
        fn no_text_panics(text in "\\PC{0,12}") {
            let _ = (parse(&text), parse_shift(&text), parse(&format!("P{text}")));
        }
    }
}
