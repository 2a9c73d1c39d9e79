//! Calendars with week days, exceptions and working weeks.

use super::recurrence::Recurrence;
use crate::PlanFileError;
use crate::calendars::{DAY_S, USUAL_DAY_S, WrittenCalendar, in_order, week_of};
use crate::iso;
use crate::plan::{CalendarException, Finding, FindingKind};
use crate::xml::Xml;
use jiff::ToSpan;
use jiff::civil::Date;

/// Days of exceptions and working weeks of all calendars together.
const MAX_DAYS: usize = 1_000_000;

/// A week day, exception or working week as it is written: a range of days and what they are.
#[derive(Debug, Default)]
struct WrittenDays {
    /// From 1 for Sunday; 0 for an exception.
    day_type: u32,
    range: [Option<Date>; 2],
    is_working: bool,
    periods: Vec<[u32; 2]>,
    recurrence: Recurrence,
    by_occurrences: bool,
    /// Text that cannot be read.
    unreadable: Option<String>,
}

/// The element `Calendars`.
pub(super) fn read(xml: &mut Xml<'_>, findings: &mut Vec<Finding>) -> Result<Vec<WrittenCalendar>, PlanFileError> {
    let mut calendars = Vec::new();
    let mut n_days = 0;
    while let Some(element) = xml.child()? {
        if element == "Calendar" {
            let calendar: WrittenCalendar = read_calendar(xml, findings)?;
            n_days += 1 + calendar.exceptions.len();
            if n_days > MAX_DAYS {
                return Err(PlanFileError::TooMany { max: MAX_DAYS, what: "calendars and exceptions in them" });
            }
            calendars.push(calendar);
        } else {
            xml.skip()?;
        }
    }
    if calendars.iter().all(|calendar| calendar.uid != "0") {
        calendars.iter_mut().for_each(|calendar| calendar.base = calendar.base.take().filter(|base| base != "0"));
    }
    Ok(calendars)
}

fn read_calendar(xml: &mut Xml<'_>, findings: &mut Vec<Finding>) -> Result<WrittenCalendar, PlanFileError> {
    let mut calendar = WrittenCalendar::default();
    let (mut week_days, mut exceptions, mut working_weeks) = (Vec::new(), Vec::new(), Vec::new());
    while let Some(element) = xml.child()? {
        match element {
            "UID" => calendar.uid = xml.text()?.into_owned(),
            "Name" => calendar.name = xml.text()?.into_owned(),
            "BaseCalendarUID" => {
                let text = xml.text()?;
                calendar.base = (text != "-1" && !text.is_empty()).then(|| text.into_owned());
            }
            "WeekDays" => week_days = read_list(xml, "WeekDay")?,
            "Exceptions" => exceptions = read_list(xml, "Exception")?,
            "WorkWeeks" => {
                while let Some(element) = xml.child()? {
                    if element == "WorkWeek" { working_weeks.push(read_work_week(xml)?) } else { xml.skip()? }
                }
            }
            _ => xml.skip()?,
        }
    }
    // Days of their own rank before those that recur.
    exceptions.sort_by_key(|exception| !exception.recurrence.is_range());
    let mut days = Days { name: &calendar.name, out: Vec::new(), findings };
    for exception in exceptions.iter().chain(week_days.iter().filter(|day| day.day_type == 0)) {
        days.add_exception(exception)?;
    }
    for (range, week) in &working_weeks {
        days.add_working_week(*range, week)?;
    }
    let mut week = std::array::from_fn(|_| None);
    for day in &week_days {
        if let Some(k) = from_monday(day.day_type) {
            days.check(day);
            week[k] = Some(day.hours());
        } else if day.day_type != 0 {
            days.find(format!("has a week day of type {}", day.day_type));
        }
    }
    calendar.exceptions = days.out;
    calendar.week = week_of(week);
    Ok(calendar)
}

/// The days of a calendar that differ from its week.
struct Days<'a> {
    name: &'a str,
    out: Vec<CalendarException>,
    findings: &'a mut Vec<Finding>,
}

impl Days<'_> {
    fn find(&mut self, why: String) {
        let message = format!("calendar {:?} {why}; it is left out", self.name);
        self.findings.push(Finding { task: None, kind: FindingKind::NotUnderstood, message });
    }

    fn check(&mut self, day: &WrittenDays) {
        if let Some(text) = &day.unreadable {
            self.find(format!("has a date, time or number {text:?} that cannot be read"));
        }
    }

    /// Periods of one day; what is after its midnight is found and left out.
    fn periods_of(&mut self, day: &WrittenDays) -> Vec<[u32; 2]> {
        let mut hours = day.hours();
        for period in &mut hours {
            if period[0] >= period[1] {
                self.find("has an exception that goes on after midnight, which belongs to the next day".to_owned());
                period[1] = DAY_S;
            }
        }
        in_order(hours)
    }

    fn add_exception(&mut self, day: &WrittenDays) -> Result<(), PlanFileError> {
        self.check(day);
        let [Some(first), Some(last)] = day.range else {
            self.find("has an exception without days".to_owned());
            return Ok(());
        };
        let periods_s = self.periods_of(day);
        if day.recurrence.is_range() {
            return self.push(CalendarException { first, last, periods_s });
        }
        let occurrences = day.recurrence.occurrences.filter(|_| day.by_occurrences);
        let recurrence = Recurrence { occurrences, ..day.recurrence };
        let Some(on) = recurrence.days(first, last, MAX_DAYS + 1) else {
            self.find(format!("has an exception of type {}, which means nothing", recurrence.kind));
            return Ok(());
        };
        on.into_iter()
            .try_for_each(|day| self.push(CalendarException { first: day, last: day, periods_s: periods_s.clone() }))
    }

    fn add_working_week(&mut self, range: [Option<Date>; 2], week: &[WrittenDays]) -> Result<(), PlanFileError> {
        let [Some(first), Some(last)] = range else {
            self.find("has a working week without days".to_owned());
            return Ok(());
        };
        let mut week_s: [Option<Vec<[u32; 2]>>; 7] = Default::default();
        for day in week {
            self.check(day);
            if let Some(k) = from_monday(day.day_type) {
                week_s[k] = Some(self.periods_of(day));
            }
        }
        let mut day = Some(first).filter(|_| week_s.iter().any(Option::is_some));
        while let Some(at) = day.filter(|day| *day <= last) {
            if let Some(periods_s) = &week_s[usize::from(at.weekday().to_monday_zero_offset().unsigned_abs())] {
                self.push(CalendarException { first: at, last: at, periods_s: periods_s.clone() })?;
            }
            day = at.checked_add(1.day()).ok();
        }
        Ok(())
    }

    fn push(&mut self, exception: CalendarException) -> Result<(), PlanFileError> {
        if self.out.len() == MAX_DAYS {
            return Err(PlanFileError::TooMany { max: MAX_DAYS, what: "exceptions in a calendar" });
        }
        self.out.push(exception);
        Ok(())
    }
}

impl WrittenDays {
    /// As they are written, with 0 for midnight at the end of the day made to be that.
    fn hours(&self) -> Vec<[u32; 2]> {
        match (self.is_working, self.periods.is_empty()) {
            (false, _) => Vec::new(),
            (true, true) => USUAL_DAY_S.to_vec(),
            (true, false) => {
                self.periods.iter().map(|[from, to]| [*from, if *to == 0 { DAY_S } else { *to }]).collect()
            }
        }
    }
}

/// Index of a weekday from Monday on; `None` for exceptions and types that are none.
fn from_monday(day_type: u32) -> Option<usize> {
    (1..=7).contains(&day_type).then(|| (day_type as usize + 5) % 7)
}

fn read_list(xml: &mut Xml<'_>, name: &str) -> Result<Vec<WrittenDays>, PlanFileError> {
    let mut list = Vec::new();
    while let Some(element) = xml.child()? {
        if element != name {
            xml.skip()?;
        } else if list.len() == MAX_DAYS {
            return Err(PlanFileError::TooMany { max: MAX_DAYS, what: "exceptions in a calendar" });
        } else {
            list.push(read_days(xml)?);
        }
    }
    Ok(list)
}

fn read_work_week(xml: &mut Xml<'_>) -> Result<([Option<Date>; 2], Vec<WrittenDays>), PlanFileError> {
    let mut range = WrittenDays::default();
    let mut week = Vec::new();
    while let Some(element) = xml.child()? {
        match element {
            "TimePeriod" => range.read_range(xml)?,
            "WeekDays" => week = read_list(xml, "WeekDay")?,
            _ => xml.skip()?,
        }
    }
    Ok((range.range, week))
}

fn read_days(xml: &mut Xml<'_>) -> Result<WrittenDays, PlanFileError> {
    let mut days = WrittenDays::default();
    while let Some(element) = xml.child()? {
        match element {
            "TimePeriod" => days.read_range(xml)?,
            "WorkingTimes" => {
                while let Some(element) = xml.child()? {
                    if element == "WorkingTime" { days.read_period(xml)? } else { xml.skip()? }
                }
            }
            "DayType" => days.day_type = days.number(xml)?,
            "DayWorking" => days.is_working = days.number(xml)? == 1,
            "EnteredByOccurrences" => days.by_occurrences = days.number(xml)? == 1,
            "Occurrences" => days.recurrence.occurrences = Some(days.number(xml)? as usize),
            "Type" => days.recurrence.kind = days.number(xml)?,
            "Period" => days.recurrence.period = days.number(xml)?,
            "DaysOfWeek" => days.recurrence.days_of_week = days.number(xml)?,
            "MonthItem" => days.recurrence.month_item = days.number(xml)?,
            "MonthPosition" => days.recurrence.month_position = days.number(xml)?,
            "Month" => days.recurrence.month = days.number(xml)?,
            "MonthDay" => days.recurrence.month_day = days.number(xml)?,
            _ => xml.skip()?,
        }
    }
    Ok(days)
}

impl WrittenDays {
    fn read_range(&mut self, xml: &mut Xml<'_>) -> Result<(), PlanFileError> {
        while let Some(element) = xml.child()? {
            let end = match element {
                "FromDate" => 0,
                "ToDate" => 1,
                _ => {
                    xml.skip()?;
                    continue;
                }
            };
            let text = xml.text()?;
            self.range[end] = iso::date(&text).map(|date| date.at.0.date());
            self.note(self.range[end].is_some(), &text);
        }
        Ok(())
    }

    fn read_period(&mut self, xml: &mut Xml<'_>) -> Result<(), PlanFileError> {
        let mut ends = [None; 2];
        while let Some(element) = xml.child()? {
            let end = match element {
                "FromTime" => 0,
                "ToTime" => 1,
                _ => {
                    xml.skip()?;
                    continue;
                }
            };
            let text = xml.text()?;
            ends[end] = crate::values::time_of_day(&text);
            self.note(ends[end].is_some(), &text);
        }
        if let [Some(from), Some(to)] = ends {
            self.periods.push([from, to]);
        }
        Ok(())
    }

    fn number(&mut self, xml: &mut Xml<'_>) -> Result<u32, PlanFileError> {
        let text = xml.text()?;
        let value = text.parse();
        self.note(value.is_ok() || text.is_empty(), &text);
        Ok(value.unwrap_or(0))
    }

    fn note(&mut self, is_readable: bool, text: &str) {
        if !is_readable {
            self.unreadable.get_or_insert_with(|| text.to_owned());
        }
    }
}
