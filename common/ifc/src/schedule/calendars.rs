//! Work calendars: IfcWorkCalendar, IfcWorkTime, IfcRecurrencePattern.

use rustc_hash::FxHashMap;

use super::context::{Context, tell};
use super::model::{Recurrence, RecurrenceType, WorkCalendar, WorkTime};
use crate::kernel::{File, Record, Value};
use crate::products::named;
use diagnostics::{DiagnosticCode, Report, Severity};

/// Work times and exceptions of a calendar that are read: holidays of many years.
const WORK_TIMES_MAX: usize = 1_000;

/// Seconds of a day.
const DAY_S: u32 = 86_400;

/// IfcWorkCalendar, and where each is. Work times that cannot be read are reported and left out.
pub(super) fn calendars(context: &Context<'_, '_>, report: &mut Report) -> (Vec<WorkCalendar>, FxHashMap<u32, usize>) {
    let file = context.file;
    let records = file.records("IfcWorkCalendar", report);
    let index = records.iter().enumerate().map(|(k, record)| (record.id, k)).collect();
    let calendars = records.iter().map(|record| {
        let id = named(file, record);
        let mut times = |name: &str| {
            let mut ids = file.attribute(record, name).references();
            if ids.len() > WORK_TIMES_MAX {
                let message =
                    format!("{name} has {} members; those behind the first {WORK_TIMES_MAX} are left out", ids.len());
                tell(report, Severity::Error, DiagnosticCode::CalendarUnreadable, &id, message);
                ids.truncate(WORK_TIMES_MAX);
            }
            let read = |id| {
                file.short_record_of(id, "IFCWORKTIME")
                    .ok_or("it is missing".to_owned())
                    .and_then(|t| work_time(file, &t))
            };
            let mut times = Vec::new();
            for time in ids {
                match read(time) {
                    Ok(time) => times.push(time),
                    Err(why) => {
                        let message = format!("{name} #{} is left out: {why}", file.written_id(time));
                        tell(report, Severity::Error, DiagnosticCode::CalendarUnreadable, &id, message);
                    }
                }
            }
            times
        };
        let (working, exceptions) = (times("WorkingTimes"), times("ExceptionTimes"));
        WorkCalendar { id, working, exceptions }
    });
    (calendars.collect(), index)
}

fn work_time(file: &File<'_>, time: &Record<'_>) -> Result<WorkTime, String> {
    let day = |names: [&str; 2]| {
        let text = names.iter().find_map(|name| file.attribute(time, name).text());
        text.filter(|t| !t.trim().is_empty()).map(|t| day(&t)).transpose()
    };
    let pattern = file.attribute(time, "RecurrencePattern");
    let recurrence = match pattern.reference() {
        None if *pattern == Value::Null => None,
        None => return Err("its pattern is no reference".to_owned()),
        Some(id) => {
            let pattern = file
                .short_record_of(id, "IFCRECURRENCEPATTERN")
                .ok_or_else(|| format!("its pattern #{} is missing", file.written_id(id)))?;
            Some(recurrence(file, &pattern)?)
        }
    };
    let (first_day, last_day) = (day(["Start", "StartDate"])?, day(["Finish", "FinishDate"])?);
    if first_day.zip(last_day).is_some_and(|(first, last)| last < first) {
        return Err("its last day is before its first".to_owned());
    }
    Ok(WorkTime { first_day, last_day, recurrence })
}

fn recurrence(file: &File<'_>, pattern: &Record<'_>) -> Result<Recurrence, String> {
    let get = |name: &str| file.attribute(pattern, name);
    let kind = match get("RecurrenceType").enumeration().unwrap_or_default().to_ascii_uppercase().as_str() {
        "DAILY" => RecurrenceType::Daily,
        "WEEKLY" => RecurrenceType::Weekly,
        "MONTHLY_BY_DAY_OF_MONTH" => RecurrenceType::MonthlyByDayOfMonth,
        "MONTHLY_BY_POSITION" => RecurrenceType::MonthlyByPosition,
        "BY_DAY_COUNT" => RecurrenceType::ByDayCount,
        "BY_WEEKDAY_COUNT" => RecurrenceType::ByWeekdayCount,
        "YEARLY_BY_DAY_OF_MONTH" => RecurrenceType::YearlyByDayOfMonth,
        "YEARLY_BY_POSITION" => RecurrenceType::YearlyByPosition,
        other => return Err(format!("there is no recurrence {other:?}")),
    };
    let whole = |name: &str, least: f64| match get(name).number() {
        None => Ok(None),
        Some(n) if n.fract() == 0.0 && least <= n && n < 1e6 => Ok(Some(n)),
        Some(n) => Err(format!("{name} {n} means nothing")),
    };
    let periods = get("TimePeriods").references().into_iter().map(|id| {
        let period = file
            .short_record_of(id, "IFCTIMEPERIOD")
            .ok_or_else(|| format!("its period #{} is missing", file.written_id(id)))?;
        Ok([seconds(period.at(0))?, seconds(period.at(1))?])
    });
    Ok(Recurrence {
        kind,
        days_of_month: members(get("DayComponent"), 31)?,
        weekdays: members(get("WeekdayComponent"), 7)?,
        months: members(get("MonthComponent"), 12)?,
        position: whole("Position", -1e6)?.map(|n| n as i32).filter(|n| *n != 0),
        interval: whole("Interval", 1.0)?.map_or(1, |n| n as u32),
        occurrences: whole("Occurrences", 1.0)?.map(|n| n as u32),
        periods_s: periods.collect::<Result<_, String>>()?,
    })
}

/// Numbers from 1 to `most`.
fn members(value: &Value<'_>, most: u32) -> Result<Vec<u32>, String> {
    let member = |value: &Value<'_>| {
        let number = value.number().filter(|n| n.fract() == 0.0 && 1.0 <= *n && *n <= f64::from(most));
        number.map(|n| n as u32).ok_or_else(|| format!("its pattern has a number that is not from 1 to {most}"))
    };
    value.list().iter().map(member).collect()
}

/// Year, month, day of an ISO 8601 date that exists; a time behind it does not matter.
fn day(text: &str) -> Result<[i32; 3], String> {
    let wrong = || format!("{text:?} is no date");
    let (date, rest) = text.trim().split_at_checked(10).ok_or_else(wrong)?;
    if !rest.is_empty() && !rest.starts_with('T') {
        return Err(wrong());
    }
    let parts: Vec<i32> = date.split('-').map(str::parse).collect::<Result<_, _>>().map_err(|_| wrong())?;
    let &[year, month, day] = parts.as_slice() else { return Err(wrong()) };
    let leap = year % 4 == 0 && (year % 100 != 0 || year % 400 == 0);
    let length = match month {
        2 => 28 + i32::from(leap),
        4 | 6 | 9 | 11 => 30,
        1..=12 => 31,
        _ => return Err(wrong()),
    };
    if (1..=length).contains(&day) { Ok([year, month, day]) } else { Err(wrong()) }
}

/// Seconds of an ISO 8601 time; a zone behind it does not matter, calendars are local.
fn seconds(value: &Value<'_>) -> Result<u32, String> {
    let text = value.text().ok_or("a period has no time")?;
    let wrong = || format!("{text:?} is no time of day");
    let time = text.trim().split(['Z', 'z', '+', '.']).next().unwrap_or_default();
    let time = time.split('-').next().unwrap_or_default();
    let parts: Vec<u32> = time.split(':').map(str::parse).collect::<Result<_, _>>().map_err(|_| wrong())?;
    let (hour, minute, second) = match *parts.as_slice() {
        [hour, minute] => (hour, minute, 0),
        [hour, minute, second] => (hour, minute, second),
        _ => return Err(wrong()),
    };
    let in_range = hour <= 24 && minute < 60 && second < 60;
    let total = if in_range { hour * 3600 + minute * 60 + second } else { DAY_S + 1 };
    if total <= DAY_S { Ok(total) } else { Err(wrong()) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{file_of, read};

    fn first(schema: &str, records: &str) -> (WorkCalendar, Vec<String>) {
        let text = file_of(schema, &format!("#1=IFCWORKCALENDAR('c',$,'C',$,$,$,(#2),(#3),.FIRSTSHIFT.);{records}"));
        let (mut model, diagnostics) = read(&text).unwrap();
        let found = diagnostics.into_iter().filter(|d| d.code.name() == "calendar_unreadable").map(|d| d.message);
        (model.schedule.calendars.remove(0), found.collect())
    }

    #[test]
    fn weeks_with_hours_and_days_without_work_are_read_in_every_schema() {
        for schema in ["IFC4", "IFC4X3_ADD2"] {
            let (calendar, problems) = first(
                schema,
                "#2=IFCWORKTIME('Week',$,$,#4,$,$);#3=IFCWORKTIME('Easter',$,$,$,'2024-03-29','2024-04-01');
                 #4=IFCRECURRENCEPATTERN(.WEEKLY.,$,(1,2,5),$,$,$,$,(#5,#6));
                 #5=IFCTIMEPERIOD('08:00:00','12:00');#6=IFCTIMEPERIOD('22:00:00+01:00','24:00:00');",
            );
            assert!(problems.is_empty(), "{problems:?}");
            let week = calendar.working[0].recurrence.as_ref().unwrap();
            assert_eq!((week.kind, week.weekdays.as_slice()), (RecurrenceType::Weekly, &[1, 2, 5][..]));
            assert_eq!(week.periods_s, [[28_800, 43_200], [79_200, 86_400]]);
            assert_eq!(calendar.exceptions[0].first_day, Some([2024, 3, 29]));
            assert_eq!(calendar.exceptions[0].last_day, Some([2024, 4, 1]));
        }
    }

    #[test]
    fn what_cannot_be_read_is_left_out_and_named() {
        let (calendar, problems) = first(
            "IFC4",
            "#2=IFCWORKTIME('Week',$,$,#4,$,$);#3=IFCWORKTIME('Easter',$,$,$,'2024-02-30','2024-04-01');
             #4=IFCRECURRENCEPATTERN(.WEEKLY.,$,(1,9),$,$,$,$,$);",
        );
        assert!(calendar.working.is_empty() && calendar.exceptions.is_empty());
        assert!(problems[0].contains("1 to 7") && problems[1].contains("2024-02-30"), "{problems:?}");
        let (_, problems) = first("IFC4", "#2=IFCWORKTIME('Week',$,$,#9,$,$);");
        assert_eq!(problems.len(), 2, "a pattern and a work time that are missing: {problems:?}");
    }

    #[test]
    fn times_of_day_end_with_24_hours() {
        let check = |text: &'static str| seconds(&Value::Text(text.as_bytes())).ok();
        assert_eq!(
            ["24:00", "24:00:01", "12:60", "noon", "99999999999:00"].map(check),
            [Some(86_400), None, None, None, None]
        );
    }
}
