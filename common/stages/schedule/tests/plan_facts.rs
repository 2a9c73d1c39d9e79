//! What a schedule file says of its tasks counts where dates are computed, or is told.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

mod support;

use jiff::civil::DateTime;
use messages::{Site, Tasks};
use schedule::{Delay, Overrides, Rules, Timeline, evaluate};
use schedule_files::*;
use support::{ScheduledSite, diagnostic, text};
use tasks::{LinkRules, Links, ScheduleFile, tasks_of};

const HOUR_S: i64 = 3600;

/// A date and time of 2024.
fn at(text: &str) -> Option<PlanDate> {
    let at: DateTime = format!("2024-{text}:00").parse().unwrap();
    Some(PlanDate { at: frames::PlanTime(at), is_day: false, offset: None })
}

fn hours(hours: i64) -> Option<Length> {
    Some(Length { seconds: hours * HOUR_S, is_elapsed: false })
}

/// A calendar of eight hours on the first weekdays of each week.
fn calendar(uid: &str, n_days: usize) -> PlanCalendar {
    let periods = vec![[8 * 3600, 12 * 3600], [13 * 3600, 17 * 3600]];
    let week = std::array::from_fn(|day| if day < n_days { periods.clone() } else { Vec::new() });
    PlanCalendar { uid: uid.into(), name: uid.into(), is_default: uid == "five", week, exceptions: Vec::new() }
}

/// A plan that starts on Monday, 4 March 2024; calendar 0 has five days a week, and is that of the project, calendar 1 has seven.
fn plan(tasks: Vec<PlanTask>, dependencies: Vec<Dependency>) -> PlanFile {
    let calendars = vec![calendar("five", 5), calendar("seven", 7)];
    PlanFile { start: at("03-04T08:00"), calendars, tasks, dependencies, ..PlanFile::default() }
}

fn task(uid: &str, n_hours: i64) -> PlanTask {
    PlanTask { uid: uid.into(), name: uid.into(), duration: hours(n_hours), ..PlanTask::default() }
}

fn after(predecessor: usize, successor: usize, kind: DependencyKind, lag_h: i64) -> Dependency {
    let lag = hours(lag_h).filter(|lag| lag.seconds != 0).map(PlanLag::Length);
    Dependency { predecessor, successor, kind, lag }
}

fn evaluated(plan: &PlanFile, delays: &[&str]) -> Timeline {
    let plans = [ScheduleFile { file: "plan.xer".to_owned(), sha256: [0; 32], plan: plan.clone() }];
    let bytes = ScheduledSite::new().builder.finish();
    let site = Site::open(bytes.bytes()).unwrap();
    let archive = tasks_of(&site, &plans, &LinkRules::default(), &Links::default()).finish();
    let tasks = Tasks::open(archive.bytes()).unwrap();
    let delays = delays.iter().map(|text| Delay::parse(text).unwrap()).collect();
    let overrides = Overrides { delays, ..Overrides::default() };
    evaluate(&site.with_tasks(&tasks).unwrap(), &Rules::default(), &overrides).unwrap()
}

/// Start and finish of a task, without the year.
fn dates(timeline: &Timeline, task: usize) -> [String; 2] {
    let dates = timeline.task(task).unwrap();
    [dates.start_s, dates.finish_s].map(|s| text(s)["2024-".len()..][..11].to_owned())
}

#[test]
fn a_lag_counts_in_the_calendar_that_the_file_names() {
    // A, on seven days, ends on Friday; B, on five, waits for two days of eight hours.
    let first = PlanTask { calendar: Some(1), ..task("A", 40) };
    let mut plan = plan(vec![first, task("B", 8)], vec![after(0, 1, DependencyKind::FinishStart, 16)]);
    let check = |plan: &PlanFile, start: &str, float_days: i64| {
        let timeline = evaluated(plan, &[]);
        assert_eq!(dates(&timeline, 1)[0], start, "{:?}", plan.lag_calendar);
        let float = timeline.float(0).unwrap();
        assert_eq!((float.total_s, float.free_s), (float_days * 8 * HOUR_S, float_days * 8 * HOUR_S), "{start}");
    };
    plan.lag_calendar = LagCalendar::Predecessor;
    check(&plan, "03-11T08:00", 0);
    plan.lag_calendar = LagCalendar::Successor;
    check(&plan, "03-13T08:00", 2);
    plan.lag_calendar = LagCalendar::Project;
    check(&plan, "03-13T08:00", 2);
    plan.calendars[0].is_default = false;
    plan.calendars[1].is_default = true;
    plan.tasks[1].calendar = Some(0);
    check(&plan, "03-11T08:00", 0);
}

#[test]
fn a_delay_goes_on_through_the_calendar_of_the_lag() {
    let dated = |task: PlanTask, start: &str, finish: &str| PlanTask {
        dates: PlanDates { current: [at(start), at(finish)], ..PlanDates::default() },
        ..task
    };
    let first = PlanTask { calendar: Some(1), ..dated(task("A", 40), "03-18T08:00", "03-22T17:00") };
    let second = dated(task("B", 24), "03-25T08:00", "03-27T17:00");
    let mut plan = plan(vec![first, second], vec![after(0, 1, DependencyKind::FinishStart, 16)]);
    plan.lag_calendar = LagCalendar::Predecessor;
    // A ends on Wednesday, 27 March, the lag on Friday.
    assert_eq!(dates(&evaluated(&plan, &["A=5d"]), 1), ["04-01T08:00", "04-03T17:00"]);
}

#[test]
fn work_that_is_ahead_and_planned_before_the_data_date_is_told() {
    let dated = |uid: &str, start: &str, finish: &str| PlanTask {
        dates: PlanDates { current: [at(start), at(finish)], ..PlanDates::default() },
        ..task(uid, 8)
    };
    let mut tasks = vec![
        dated("late", "03-04T08:00", "03-12T17:00"),
        dated("in time", "03-11T08:00", "03-12T17:00"),
        dated("overdue", "03-04T08:00", "03-08T17:00"),
        dated("done", "03-04T08:00", "03-08T17:00"),
    ];
    tasks[2].dates.actual[0] = at("03-04T08:00");
    tasks[3].dates.actual = [at("03-04T08:00"), at("03-08T17:00")];
    let mut plan = plan(tasks, vec![]);
    let found = |plan: &PlanFile| -> Vec<String> {
        let timeline = evaluated(plan, &[]);
        let of_code = timeline.diagnostics().iter().filter(|d| d.code.name() == "task_before_data_date");
        of_code.map(|d| d.message.clone()).collect()
    };
    assert_eq!(found(&plan), Vec::<String>::new(), "without a data date");
    plan.data_date = at("03-11T08:00");
    assert_eq!(
        found(&plan),
        [
            "1 task planned to begin before the data date 2024-03-11T08:00:00 and not begun: late; shown as planned",
            "1 task begun and planned to finish before the data date 2024-03-11T08:00:00: overdue; shown as planned",
        ]
    );
    assert_eq!(dates(&evaluated(&plan, &[]), 0), ["03-04T08:00", "03-12T17:00"]);
}

#[test]
fn an_actual_finish_with_0_per_cent_is_told() {
    let mut done = task("done", 8);
    done.dates.actual = [at("03-04T08:00"), at("03-08T17:00")];
    let check = |complete: Option<f64>, is_told: bool| {
        let timeline = evaluated(&plan(vec![PlanTask { complete, ..done.clone() }], vec![]), &[]);
        assert_eq!(diagnostic(&timeline, "finish_without_completion").is_some(), is_told, "{complete:?}");
        assert_eq!(dates(&timeline, 0), ["03-04T08:00", "03-08T17:00"]);
    };
    check(Some(0.0), true);
    check(Some(0.5), false);
    check(None, false);
}
