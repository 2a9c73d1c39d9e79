//! Calendars of schedule files give the same working time in the evaluation as in the file.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

mod support;

use frames::PlanTime;
use jiff::civil::{Date, date};
use messages::{Site, Tasks};
use proptest::prelude::*;
use schedule::{Overrides, Rules, evaluate};
use schedule_files::{CalendarException, Length, PlanCalendar, PlanDate, PlanDates, PlanFile, PlanTask, PlanTaskKind};
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

/// An instant, in seconds after the first day.
fn instant(at_s: u32) -> PlanDate {
    let day = FIRST.to_datetime(jiff::civil::Time::midnight());
    PlanDate { at: PlanTime(day + jiff::Span::new().seconds(i64::from(at_s))), is_day: false, offset: None }
}

/// Finish of a task with a start and a duration.
fn finish(calendar: &PlanCalendar, start_s: u32, duration_s: i64) -> Option<String> {
    let task = PlanTask {
        uid: "1".to_owned(),
        duration: Some(Length { seconds: duration_s, is_elapsed: false }),
        dates: PlanDates { current: [Some(instant(start_s)), None], ..PlanDates::default() },
        ..PlanTask::default()
    };
    task_dates(calendar, task).map(|[_, finish]| finish)
}

/// Start and finish of a task.
fn task_dates(calendar: &PlanCalendar, task: PlanTask) -> Option<[String; 2]> {
    let plan = PlanFile { calendars: vec![calendar.clone()], tasks: vec![task], ..PlanFile::default() };
    let plans = [ScheduleFile { file: "plan.xer".to_owned(), sha256: [0; 32], plan }];
    let bytes = ScheduledSite::new().builder.finish();
    let site = Site::open(bytes.bytes()).unwrap();
    let archive = tasks_of(&site, &plans, &LinkRules::default(), &Links::default()).finish();
    let tasks = Tasks::open(archive.bytes()).unwrap();
    let timeline = evaluate(&site.with_tasks(&tasks).unwrap(), &Rules::default(), &Overrides::default()).unwrap();
    timeline.task(0).map(|dates| [text(dates.start_s), text(dates.finish_s)])
}

/// How far a task is.
#[derive(Debug, Clone, Copy)]
enum Progress {
    NotBegun,
    Begun,
    Finished,
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

    #[test]
    fn written_dates_come_back_as_they_are_whatever_the_calendar(
        calendar in calendars(),
        start in 0..20 * 96_u32,
        length in 0..20 * 96_u32,
        quarters in 0..200_i64,
        kind in prop_oneof![Just(PlanTaskKind::Task), Just(PlanTaskKind::Span), Just(PlanTaskKind::Milestone)],
        progress in prop_oneof![Just(Progress::NotBegun), Just(Progress::Begun), Just(Progress::Finished)],
    ) {
        let length = if kind == PlanTaskKind::Milestone { 0 } else { length };
        let written = [start, start + length].map(|quarter| instant(quarter * QUARTER_S));
        let [first, last] = written.map(Some);
        let actual = match progress {
            Progress::NotBegun => [None; 2],
            Progress::Begun => [first, None],
            Progress::Finished => [first, last],
        };
        let task = PlanTask {
            uid: "1".to_owned(),
            kind,
            duration: Some(Length { seconds: quarters * i64::from(QUARTER_S), is_elapsed: false }),
            dates: PlanDates { current: [first, last], actual, ..PlanDates::default() },
            ..PlanTask::default()
        };
        let expected = written.map(|date| date.at.to_string());
        prop_assert_eq!(task_dates(&calendar, task), Some(expected));
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

/// Start and finish of the tasks of a schedule file; `None` for those without.
fn dates_of(name: &str, bytes: &[u8]) -> Vec<Option<[String; 2]>> {
    let plans = [ScheduleFile::read(name, bytes, &schedule_files::ReadOptions::default()).unwrap()];
    let site_bytes = ScheduledSite::new().builder.finish();
    let site = Site::open(site_bytes.bytes()).unwrap();
    let archive = tasks_of(&site, &plans, &LinkRules::default(), &Links::default()).finish();
    let tasks = Tasks::open(archive.bytes()).unwrap();
    let timeline = evaluate(&site.with_tasks(&tasks).unwrap(), &Rules::default(), &Overrides::default()).unwrap();
    let dates = |k| timeline.task(k).map(|dates| [text(dates.start_s), text(dates.finish_s)]);
    (0..plans[0].plan.tasks.len()).map(dates).collect()
}

#[test]
fn tasks_without_dates_begin_with_their_own_project_and_have_its_calendar() {
    let week = |from: &str, to: &str| {
        let day = |k| format!("(0||{k}()((0||0(s|{from}|f|{to})())))");
        format!("(0||CalendarData()((0||DaysOfWeek()({}))))", (1..=7).map(day).collect::<String>())
    };
    let text = format!(
        "ERMHDR\t19.12\n\
         %T\tPROJECT\n%F\tproj_id\tproj_short_name\tclndr_id\tplan_start_date\texport_flag\n\
         %R\t1\tNEXT\t1\t2020-01-01 00:00\t\n%R\t2\tHALL\t1\t2024-03-04 00:00\tY\n%R\t3\tROAD\t2\t2024-05-06 00:00\tY\n\
         %T\tCALENDAR\n%F\tclndr_id\tclndr_name\tclndr_data\n%R\t1\tDay\t{}\n%R\t2\tNight\t{}\n\
         %T\tPROJWBS\n%F\twbs_id\tproj_id\tproj_node_flag\twbs_short_name\tparent_wbs_id\n%R\t10\t1\tY\tNEXT\n%R\t20\t2\tY\tHALL\n%R\t30\t3\tY\tROAD\n\
         %T\tTASK\n%F\ttask_id\tproj_id\twbs_id\ttask_type\tstatus_code\ttarget_drtn_hr_cnt\n\
         %R\t11\t1\t10\tTT_Task\tTK_NotStart\t4\n%R\t21\t2\t20\tTT_Task\tTK_NotStart\t4\n%R\t31\t3\t30\tTT_Task\tTK_NotStart\t4\n%E\n",
        week("08:00", "16:00"),
        week("18:00", "23:00"),
    );
    let dates = dates_of("plan.xer", text.as_bytes());
    let finishes: Vec<_> = dates[2..].iter().map(|dates| dates.as_ref().map(|[_, finish]| finish.as_str())).collect();
    assert_eq!(finishes, [Some("2024-03-04T12:00:00"), Some("2024-05-06T22:00:00")]);
}

#[test]
fn times_with_fractions_are_working_times() {
    let day = |k: u32| {
        format!(
            "<WeekDay><DayType>{k}</DayType><DayWorking>1</DayWorking><WorkingTimes><WorkingTime>\
             <FromTime>07:00:00.000</FromTime><ToTime>15:00:00.000Z</ToTime></WorkingTime></WorkingTimes></WeekDay>"
        )
    };
    let text = format!(
        "<Project xmlns=\"http://schemas.microsoft.com/project\"><StartDate>2024-03-04T08:00:00.000</StartDate><CalendarUID>1</CalendarUID>\
         <Calendars><Calendar><UID>1</UID><WeekDays>{}{}</WeekDays></Calendar></Calendars>\
         <Tasks><Task><UID>1</UID><OutlineLevel>1</OutlineLevel><Duration>PT8H0M0.0S</Duration></Task></Tasks></Project>",
        day(2),
        day(3),
    );
    let [Some([_, finish])] = &dates_of("plan.xml", text.as_bytes())[..] else { panic!("one task") };
    assert_eq!(finish, "2024-03-05T08:00:00");
}
