//! Dates of a table as spreadsheets and planners' tools print them.

use crate::options::CsvColumn;
use crate::plan::PlanDate;
use crate::values::time_of_day;
use crate::{PlanFileError, iso};
use frames::PlanTime;
use frames::written_date::{self, DateOrder};
use jiff::tz::TimeZone;

/// Columns of dates: start and finish of each kind.
pub(crate) const COLUMNS: [[CsvColumn; 2]; 6] = [
    [CsvColumn::Start, CsvColumn::Finish],
    [CsvColumn::PlannedStart, CsvColumn::PlannedFinish],
    [CsvColumn::EarlyStart, CsvColumn::EarlyFinish],
    [CsvColumn::LateStart, CsvColumn::LateFinish],
    [CsvColumn::ActualStart, CsvColumn::ActualFinish],
    [CsvColumn::BaselineStart, CsvColumn::BaselineFinish],
];

/// Three letters of the months in English and German.
const MONTHS: [&[&str]; 12] = [
    &["jan"],
    &["feb"],
    &["mar", "mär", "mrz"],
    &["apr"],
    &["may", "mai"],
    &["jun"],
    &["jul"],
    &["aug"],
    &["sep"],
    &["oct", "okt"],
    &["nov"],
    &["dec", "dez"],
];

/// A date in an order.
pub(crate) fn date(text: &str, order: DateOrder) -> Option<PlanDate> {
    let text = plain(text)?;
    if written_date::is_iso(&text) {
        return iso::date(&text);
    }
    let read = written_date::parse(&text, order, None).ok()?;
    Some(PlanDate { at: PlanTime::from_civil_seconds(read.start_s())?, is_day: !text.contains(' '), offset: None })
}

/// The order that the dates themselves decide.
///
/// # Errors
/// Dates that can be read in two orders, or that are in two.
pub(crate) fn decided<'a>(dates: impl Iterator<Item = &'a str>) -> Result<DateOrder, PlanFileError> {
    let mut only: [Option<&str>; 2] = [None; 2];
    let mut both = None;
    for text in dates {
        match plain(text).map(|text| readings(&text)) {
            Some([Some(_), None]) => only[0] = only[0].or(Some(text)),
            Some([None, Some(_)]) => only[1] = only[1].or(Some(text)),
            Some([Some(dmy), Some(mdy)]) if dmy != mdy => both = both.or(Some((text, dmy, mdy))),
            _ => {}
        }
    }
    match (only, both) {
        ([Some(dmy), Some(mdy)], _) => {
            Err(PlanFileError::ContradictingDates { dmy: dmy.to_owned(), mdy: mdy.to_owned() })
        }
        ([None, Some(_)], _) => Ok(DateOrder::Mdy),
        ([None, None], Some((text, as_dmy, as_mdy))) => {
            Err(PlanFileError::AmbiguousDates { text: text.to_owned(), as_dmy, as_mdy })
        }
        _ => Ok(DateOrder::Dmy),
    }
}

/// The day in both orders; none if it is a date of ISO 8601.
fn readings(text: &str) -> [Option<String>; 2] {
    if written_date::is_iso(text) {
        return [None, None];
    }
    [DateOrder::Dmy, DateOrder::Mdy].map(|order| {
        let read = written_date::in_order(text, order, &TimeZone::UTC)?;
        Some(PlanTime::from_civil_seconds(read.start_s())?.0.date().to_string())
    })
}

/// Without the day of the week and the marks of P6, with a year of four digits, and with a time of 24 hours behind a blank. A date with
/// the name of its month is one of ISO 8601. `None` for an empty cell, or a time that is none.
fn plain(text: &str) -> Option<String> {
    let text = text.trim().trim_end_matches('*').trim_end();
    let text = text.strip_suffix(" A").unwrap_or(text);
    if written_date::is_iso(text) {
        return Some(text.to_owned());
    }
    let text = match text.split_once(' ') {
        Some((weekday, rest)) if weekday.chars().all(|c| c.is_alphabetic() || ".,".contains(c)) => rest.trim(),
        _ => text,
    };
    let (day, time) = match text.find(':') {
        Some(colon) => text[..colon].rsplit_once(' ').map(|(day, _)| text.split_at(day.len()))?,
        None => (text, ""),
    };
    let time = time.trim();
    // That would be the next day.
    let time = Some(time).filter(|time| !time.starts_with("24"))?;
    let clock = if time.is_empty() { String::new() } else { clock_text(time_of_day(time)?) };
    if day.is_empty() {
        return None;
    }
    let parts: Vec<&str> = day.split(['/', '-', '.', ' ']).filter(|part| !part.is_empty()).collect();
    let &[first, second, year] = parts.as_slice() else { return Some(day.to_owned() + &clock) };
    let year = if year.len() == 2 { format!("20{year}") } else { year.to_owned() };
    match month(second) {
        Some(month) => Some(format!("{year}-{month:02}-{first:0>2}{clock}")),
        None => Some(format!("{first}/{second}/{year}{clock}")),
    }
}

fn clock_text(time_s: u32) -> String {
    format!(" {:02}:{:02}:{:02}", time_s / 3600, time_s / 60 % 60, time_s % 60)
}

/// Month of a name that begins with the letters of one.
fn month(name: &str) -> Option<usize> {
    let letters: String = name.chars().take(3).flat_map(char::to_lowercase).collect();
    MONTHS.iter().position(|names| names.contains(&letters.as_str())).map(|k| k + 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dates_are_read_as_the_tools_print_them() {
        let check = |text: &str, expected: &str, is_day: bool| {
            let read = date(text, DateOrder::Dmy).map(|date| (date.at.to_string(), date.is_day));
            assert_eq!(read, Some((expected.to_owned(), is_day)), "{text}");
        };
        check("15.04.2024", "2024-04-15T00:00:00", true);
        check("Mo 15.04.24", "2024-04-15T00:00:00", true);
        check("Mon, 15/04/24 8:30", "2024-04-15T08:30:00", false);
        check("15/04/2024 05:00 PM", "2024-04-15T17:00:00", false);
        check("15-Apr-24 A", "2024-04-15T00:00:00", true);
        check("5-Mrz-24 08:00*", "2024-03-05T08:00:00", false);
        check("15. Oktober 2024", "2024-10-15T00:00:00", true);
        check("2024-04-15", "2024-04-15T00:00:00", true);
        check("2024-04-15T08:00:00+02:00", "2024-04-15T08:00:00", false);
        for text in [
            "",
            "soon",
            "31.02.2024",
            "15.04.2024 25:00",
            "15.04.2024 24:00",
            "8:00",
            "04/15/2024",
            "15-Abc-24",
            "1.2.3.4",
        ] {
            assert_eq!(date(text, DateOrder::Dmy), None, "{text}");
        }
        assert_eq!(date("04/15/24", DateOrder::Mdy), date("15.4.2024", DateOrder::Dmy));
    }

    #[test]
    fn the_order_is_decided_by_dates_that_fit_one_only() {
        let check = |dates: &[&str]| decided(dates.iter().copied());
        assert_eq!(check(&["08/04/2024", "15/04/2024"]).unwrap(), DateOrder::Dmy);
        assert_eq!(check(&["04/08/24", "04/15/24"]).unwrap(), DateOrder::Mdy);
        assert_eq!(check(&["2024-04-08", "", "04/04/2024"]).unwrap(), DateOrder::Dmy);
        assert!(matches!(check(&["15/04/2024", "04/15/2024"]), Err(PlanFileError::ContradictingDates { .. })));
        match check(&["2024-04-08", "08/04/2024", "09/04/2024"]) {
            Err(PlanFileError::AmbiguousDates { text, as_dmy, as_mdy }) => {
                assert_eq!([&*text, &*as_dmy, &*as_mdy], ["08/04/2024", "2024-04-08", "2024-08-04"]);
            }
            other => panic!("{other:?}"),
        }
    }
}
