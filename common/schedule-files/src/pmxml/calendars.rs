//! Calendars of P6 XML.

use super::element::Element;
use crate::PlanFileError;
use crate::calendars::{WrittenCalendar, week_of};
use crate::p6::{Record, exception_day, fill_week};
use crate::plan::{CalendarException, Finding, FindingKind};
use crate::values::{date, time_of_day};
use crate::xml::Xml;

/// Names of days from Monday on; the numbers are those of version 6, which begins with Sunday.
const DAYS: [[&str; 2]; 7] = [
    ["Monday", "2"],
    ["Tuesday", "3"],
    ["Wednesday", "4"],
    ["Thursday", "5"],
    ["Friday", "6"],
    ["Saturday", "7"],
    ["Sunday", "1"],
];

/// The last minute of a day.
const LAST_MINUTE_S: u32 = 23 * 3600 + 59 * 60;

/// Reads a calendar.
///
/// # Errors
/// XML that is not well-formed.
pub(super) fn read(xml: &mut Xml<'_>, findings: &mut Vec<Finding>) -> Result<WrittenCalendar, PlanFileError> {
    let mut week = [const { None }; 7];
    let mut exceptions = Vec::new();
    let mut unread = Vec::new();
    let calendar = Element::read(xml, |name, xml| {
        match name {
            "StandardWorkWeek" => {
                while let Some(name) = xml.child()? {
                    match name {
                        "StandardWorkHours" => read_day(xml, &mut week, &mut unread)?,
                        _ => xml.skip()?,
                    }
                }
            }
            "HolidayOrExceptions" => {
                while let Some(name) = xml.child()? {
                    match name {
                        "HolidayOrException" => exceptions.extend(read_exception(xml, &mut unread)?),
                        _ => xml.skip()?,
                    }
                }
            }
            _ => return Ok(false),
        }
        Ok(true)
    })?;
    let name = calendar.cell("Name").to_owned();
    if !unread.is_empty() {
        let message = format!("of calendar {name:?} {} cannot be read", unread.join(", "));
        findings.push(Finding { task: None, kind: FindingKind::UnreadableValue, message });
    }
    let mut week = week_of(week);
    fill_week(&mut week);
    Ok(WrittenCalendar {
        uid: calendar.cell("ObjectId").to_owned(),
        name,
        is_default: ["1", "true"].contains(&calendar.cell("IsDefault")),
        base: calendar.given("BaseCalendarObjectId").map(str::to_owned),
        week,
        exceptions,
    })
}

fn read_day(
    xml: &mut Xml<'_>,
    week: &mut [Option<Vec<[u32; 2]>>; 7],
    unread: &mut Vec<String>,
) -> Result<(), PlanFileError> {
    let (day, periods) = read_periods(xml, unread)?;
    let word = day.cell("DayOfWeek");
    match DAYS.iter().position(|names| names.contains(&word)) {
        Some(k) => week[k] = Some(periods),
        None => unread.push(format!("the day {word:?}")),
    }
    Ok(())
}

/// One day. The whole of it as its only period is how P6 writes a day without work.
fn read_exception(xml: &mut Xml<'_>, unread: &mut Vec<String>) -> Result<Option<CalendarException>, PlanFileError> {
    let (exception, mut periods) = read_periods(xml, unread)?;
    if periods == [[0, LAST_MINUTE_S + 60]] {
        periods.clear();
    }
    let word = exception.cell("Date");
    let Some(day) = date(word).map(|day| day.at.0.date()) else {
        unread.push(format!("the exception {word:?}"));
        return Ok(None);
    };
    Ok(Some(CalendarException { first: day, last: day, periods_s: exception_day(periods) }))
}

/// An element with periods in it. The finish that is written is the last minute of a period.
fn read_periods<'a>(
    xml: &mut Xml<'a>,
    unread: &mut Vec<String>,
) -> Result<(Element<'a>, Vec<[u32; 2]>), PlanFileError> {
    let mut periods = Vec::new();
    let element = Element::read(xml, |name, xml| {
        if name != "WorkTime" {
            return Ok(false);
        }
        let period = Element::flat(xml)?;
        let words = ["Start", "Finish"].map(|end| period.cell(end));
        match words.map(time_of_day) {
            [Some(from), Some(0)] => periods.push([from, 0]),
            [Some(from), Some(last)] => periods.push([from, last + 60]),
            _ if words == ["", ""] => {}
            _ => unread.push(format!("the hours {words:?}")),
        }
        Ok(true)
    })?;
    Ok((element, periods))
}
