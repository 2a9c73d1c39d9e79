//! Calendars of schedule files give the same working time in the evaluation as in the file.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

mod support;

use frames::PlanTime;
use jiff::civil::{Date, date};
use messages::{Site, Tasks};
use proptest::prelude::*;
use schedule::{Overrides, Rules, evaluate};
use schedule_files::{CalendarException, Length, PlanCalendar, PlanDate, PlanDates, PlanFile, PlanTask};
use support::{ScheduledSite, text};
use tasks::{LinkRules, Links, ScheduleFile, tasks_of};

const QUARTER_S: u32 = 900;
const DAY_S: u32 = 86_400;
/// A Monday.
const FIRST: Date = date(2024, 3, 4);

/// Periods of a day: in order and apart, in quarters of an hour; a night shift is the end of a day and the beginning of the next.
fn day() -> impl Strategy<Value = Vec<[u32; 2]>> {
    prop::collection::btree_set(0..=96_u32, 0..6).prop_map(|ends| {
        let ends: Vec<u32> = ends.into_iter().map(|quarter| quarter * QUARTER_S).collect();
        ends.chunks_exact(2).map(|ends| [ends[0], ends[1]]).collect()
    })
}

/// A calendar with exceptions on some of the first forty days.
fn calendars() -> impl Strategy<Value = PlanCalendar> {
    let days = prop::collection::btree_map(0..20_i64, (0..=1_i64, day()), 0..6);
    (prop::array::uniform7(day()), days).prop_map(|(week, days)| PlanCalendar {
        uid: "1".to_owned(),
        name: "calendar".to_owned(),
        is_default: true,
        week,
        exceptions: days
            .into_iter()
            .map(|(at, (more, periods_s))| {
                let [first, last] = [2 * at, 2 * at + more].map(|days| FIRST + jiff::Span::new().days(days));
                CalendarException { first, last, periods_s }
            })
            .collect(),
    })
}

/// When a task ends, quarter by quarter of an hour; `None` after half a year.
fn slow_finish(calendar: &PlanCalendar, start_s: u32, mut left_s: i64) -> Option<PlanTime> {
    for quarter in start_s / QUARTER_S..183 * 96 {
        let day = FIRST + jiff::Span::new().days(i64::from(quarter / 96));
        let exception = calendar.exceptions.iter().find(|days| days.first <= day && day <= days.last);
        let weekday = usize::from(day.weekday().to_monday_zero_offset().unsigned_abs());
        let periods_s = exception.map_or(&calendar.week[weekday], |days| &days.periods_s);
        let at_s = quarter % 96 * QUARTER_S;
        if periods_s.iter().any(|[from, to]| *from <= at_s && at_s < *to) {
            left_s -= i64::from(QUARTER_S);
        }
        if left_s == 0 {
            let end_s = i64::from(at_s + QUARTER_S);
            return Some(PlanTime(day.to_datetime(jiff::civil::Time::midnight()) + jiff::Span::new().seconds(end_s)));
        }
    }
    None
}

/// Finish of a task with a start and a duration.
fn finish(calendar: &PlanCalendar, start_s: u32, duration_s: i64) -> Option<String> {
    let day = FIRST.to_datetime(jiff::civil::Time::midnight());
    let at = PlanTime(day + jiff::Span::new().seconds(i64::from(start_s)));
    let task = PlanTask {
        uid: "1".to_owned(),
        duration: Some(Length { seconds: duration_s, is_elapsed: false }),
        dates: PlanDates {
            current: [Some(PlanDate { at, is_day: false, offset: None }), None],
            ..PlanDates::default()
        },
        ..PlanTask::default()
    };
    let plan = PlanFile { calendars: vec![calendar.clone()], tasks: vec![task], ..PlanFile::default() };
    let plans = [ScheduleFile { file: "plan.xer".to_owned(), sha256: [0; 32], plan }];
    let bytes = ScheduledSite::new().builder.finish();
    let site = Site::open(bytes.bytes()).unwrap();
    let archive = tasks_of(&site, &plans, &LinkRules::default(), &Links::default()).finish();
    let tasks = Tasks::open(archive.bytes()).unwrap();
    let timeline = evaluate(&site.with_tasks(&tasks).unwrap(), &Rules::default(), &Overrides::default()).unwrap();
    timeline.task(0).map(|dates| text(dates.finish_s))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]
    #[test]
    fn working_time_of_calendars_is_that_of_the_file(
        calendar in calendars(),
        start in 0..20 * 96_u32,
        quarters in 1..200_i64,
    ) {
        let (start_s, duration_s) = (start * QUARTER_S, quarters * i64::from(QUARTER_S));
        if let Some(expected) = slow_finish(&calendar, start_s, duration_s) {
            prop_assert_eq!(finish(&calendar, start_s, duration_s), Some(expected.to_string()));
        }
    }
}

#[test]
fn night_shifts_holidays_and_worked_holidays_count() {
    let night = vec![[0, 6 * 3600], [22 * 3600, DAY_S]];
    let off = |days: i64, periods_s| {
        let day = FIRST + jiff::Span::new().days(days);
        CalendarException { first: day, last: day, periods_s }
    };
    let mut calendar = PlanCalendar {
        is_default: true,
        week: [night.clone(), night.clone(), night.clone(), night.clone(), night, vec![], vec![]],
        ..PlanCalendar::default()
    };
    // Monday 20:00, one shift.
    assert_eq!(finish(&calendar, 20 * 3600, 8 * 3600).unwrap(), "2024-03-05T06:00:00");
    calendar.exceptions = vec![off(1, vec![])];
    assert_eq!(
        finish(&calendar, 20 * 3600, 8 * 3600).unwrap(),
        "2024-03-06T06:00:00",
        "a holiday takes the morning, too"
    );
    calendar.exceptions = vec![off(1, vec![]), off(5, vec![[8 * 3600, 12 * 3600]])];
    assert_eq!(finish(&calendar, 4 * DAY_S + 23 * 3600, 4 * 3600).unwrap(), "2024-03-09T11:00:00", "a worked Saturday");
}
