//! Constraints, lags, data dates and progress of schedule files: each counts where dates are computed, or is told.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

mod support;

use jiff::civil::DateTime;
use messages::{Site, Tasks};
use schedule::{Delay, Overrides, Period, Rules, Timeline, evaluate, probabilities};
use schedule_files::*;
use support::{ScheduledSite, diagnostic, text};
use tasks::{Effect, Link, LinkOrigin, LinkRules, Links, ScheduleFile, Target, tasks_of};

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
    evaluated_by(plan, delays, &Rules::default())
}

fn evaluated_by(plan: &PlanFile, delays: &[&str], rules: &Rules) -> Timeline {
    let plans = [ScheduleFile { file: "plan.xer".to_owned(), sha256: [0; 32], plan: plan.clone() }];
    let bytes = ScheduledSite::new().builder.finish();
    let site = Site::open(bytes.bytes()).unwrap();
    let archive = tasks_of(&site, &plans, &LinkRules::default(), &Links::default()).finish();
    let tasks = Tasks::open(archive.bytes()).unwrap();
    let delays = delays.iter().map(|text| Delay::parse(text).unwrap()).collect();
    let overrides = Overrides { delays, ..Overrides::default() };
    evaluate(&site.with_tasks(&tasks).unwrap(), rules, &overrides).unwrap()
}

/// Start and finish of a task, without the year.
fn dates(timeline: &Timeline, task: usize) -> [String; 2] {
    let dates = timeline.task(task).unwrap();
    [dates.start_s, dates.finish_s].map(|s| text(s)["2024-".len()..][..11].to_owned())
}

#[test]
fn dates_of_a_file_keep_their_offset_to_the_second() {
    let offset = jiff::tz::Offset::from_seconds(3600 + 1172).ok();
    let date = |text: &str| at(text).map(|date| PlanDate { offset, ..date });
    let dates = PlanDates { current: [date("03-04T08:19"), date("03-05T08:19")], ..PlanDates::default() };
    let plan = plan(vec![PlanTask { dates, ..task("a", 8) }], vec![]);
    let rules = Rules { site_zone: Some(jiff::tz::TimeZone::UTC), ..Rules::default() };
    let timeline = evaluated_by(&plan, &[], &rules);
    let dates = timeline.task(0).unwrap();
    assert_eq!([dates.start_s, dates.finish_s].map(text), ["2024-03-04T06:59:28", "2024-03-05T06:59:28"]);
    let faulty = evaluated(&plan, &[]);
    let message = &diagnostic(&faulty, "task_date_unreadable").unwrap().message;
    assert!(message.contains("2024-03-04T08:19:00+01:20") && message.contains("site_zone"), "{message}");
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

#[test]
fn a_finish_that_a_p6_relationship_asks_for_stands_for_those_who_wait_for_it() {
    // Seven days a week until Saturday, 17:00; then five days a week, ending with it; then by day and night.
    let last = |lag_h| after(1, 2, DependencyKind::FinishStart, lag_h);
    let mut plan = plan(
        vec![
            PlanTask { calendar: Some(1), ..task("a", 6 * 8) },
            task("b", 16),
            PlanTask { calendar: Some(1), ..task("c", 8) },
        ],
        vec![after(0, 1, DependencyKind::FinishFinish, 0), last(0)],
    );
    plan.lag_calendar = LagCalendar::Predecessor;
    let of = |plan: &PlanFile, k| dates(&evaluated(plan, &[]), k);
    assert_eq!(of(&plan, 1), ["03-07T08:00", "03-08T17:00"], "MS Project counts on from the start");
    assert_eq!(of(&plan, 2), ["03-09T08:00", "03-09T17:00"]);
    plan.is_primavera = true;
    assert_eq!(of(&plan, 1), ["03-07T08:00", "03-11T08:00"], "P6: not before the predecessor");
    assert_eq!(of(&plan, 2), ["03-11T08:00", "03-11T17:00"]);
    // A negative lag in the calendar of the predecessor ends where a working time begins.
    plan.dependencies = vec![after(0, 1, DependencyKind::FinishFinish, -8), last(0)];
    assert_eq!(of(&plan, 1), ["03-07T08:00", "03-09T08:00"]);
    assert_eq!(of(&plan, 2), ["03-09T08:00", "03-09T17:00"]);
}

#[test]
fn p6_activities_that_start_together_do_so_in_the_calendar_of_their_lag() {
    // On a Saturday, by calendars of seven days; the project has five.
    let on_saturday = bound(ConstraintKind::StartNotEarlierThan, "03-09T08:00", task("a", 8));
    let tasks = [on_saturday, task("b", 8)].map(|task| PlanTask { calendar: Some(1), ..task });
    let mut plan = plan(tasks.to_vec(), vec![after(0, 1, DependencyKind::StartStart, 0)]);
    plan.lag_calendar = LagCalendar::Project;
    assert_eq!(dates(&evaluated(&plan, &[]), 1), ["03-09T08:00", "03-09T17:00"]);
    plan.is_primavera = true;
    assert_eq!(dates(&evaluated(&plan, &[]), 1), ["03-11T08:00", "03-11T17:00"]);
}

fn bound(kind: ConstraintKind, date: &str, task: PlanTask) -> PlanTask {
    PlanTask { constraints: vec![Constraint { kind, date: at(date) }], ..task }
}

/// A, a week, before B, two days with a constraint, before C, a day.
fn chain(kind: ConstraintKind, date: &str) -> PlanFile {
    let kinds = [after(0, 1, DependencyKind::FinishStart, 0), after(1, 2, DependencyKind::FinishStart, 0)];
    plan(vec![task("A", 40), bound(kind, date, task("B", 16)), task("C", 8)], kinds.to_vec())
}

#[test]
fn constraints_bind_computed_dates_as_the_planners_tool_has_them() {
    use ConstraintKind::*;
    // Start and finish of B, float of A in days, in P6 and in MS Project: as MPXJ computes them.
    let free = ["03-11T08:00", "03-12T17:00"];
    let later = ["03-20T08:00", "03-21T17:00"];
    let sooner = ["03-06T08:00", "03-07T17:00"];
    let outside = ["03-14T08:00", "03-16T17:00"];
    let [finish_later, finish_sooner] = [["03-19T08:00", "03-20T17:00"], ["03-05T08:00", "03-06T17:00"]];
    for (kind, date, p6, project) in [
        (StartNotEarlierThan, "03-06T08:00", (free, 0), (free, 0)),
        (StartNotEarlierThan, "03-20T08:00", (later, 7), (later, 7)),
        (FinishNotEarlierThan, "03-20T17:00", (finish_later, 6), (finish_later, 6)),
        (StartNotLaterThan, "03-20T08:00", (free, 0), (free, 0)),
        (StartNotLaterThan, "03-06T08:00", (free, -3), (sooner, -3)),
        (FinishNotLaterThan, "03-06T17:00", (free, -4), (finish_sooner, -4)),
        (MustStartOn, "03-06T08:00", (free, -3), (sooner, -3)),
        (MustStartOn, "03-20T08:00", (later, 7), (later, 7)),
        (MustFinishOn, "03-06T17:00", (free, -4), (finish_sooner, -4)),
        (MandatoryStart, "03-06T08:00", (sooner, -3), (sooner, -3)),
        (MandatoryFinish, "03-20T17:00", (finish_later, 6), (finish_later, 6)),
        (MandatoryFinish, "03-16T17:00", (outside, 3), (outside, 3)),
    ] {
        for (honours_constraints, (expected, float_days)) in [(false, p6), (true, project)] {
            let timeline = evaluated(&PlanFile { honours_constraints, ..chain(kind, date) }, &[]);
            assert_eq!(dates(&timeline, 1), expected, "{kind:?} {date} {honours_constraints}");
            let float_s = timeline.float(0).unwrap().total_s;
            assert_eq!(float_s, float_days * 8 * HOUR_S, "{kind:?} {date} {honours_constraints}");
            let told = diagnostic(&timeline, "constraint_unmet");
            assert_eq!(told.is_some(), float_days < 0, "{kind:?} {date} {honours_constraints}");
            assert!(told.is_none_or(|told| told.entity.as_ref().unwrap().name == "B"));
        }
    }
}

#[test]
fn what_waits_for_a_constrained_task_is_pushed_by_its_constraint() {
    let timeline = evaluated(&chain(ConstraintKind::StartNotEarlierThan, "04-15T08:00"), &[]);
    assert_eq!(dates(&timeline, 2), ["04-17T08:00", "04-17T17:00"]);
}

#[test]
fn two_constraints_of_a_task_both_count() {
    let mut plan = chain(ConstraintKind::StartNotEarlierThan, "03-14T08:00");
    plan.tasks[1].constraints.push(Constraint { kind: ConstraintKind::FinishNotLaterThan, date: at("03-14T17:00") });
    let timeline = evaluated(&plan, &[]);
    assert_eq!(dates(&timeline, 1), ["03-14T08:00", "03-15T17:00"]);
    let message = &diagnostic(&timeline, "constraint_unmet").unwrap().message;
    assert_eq!(
        message,
        "its constraint to finish no later than 2024-03-14T17:00:00 is not kept: it finishes 2024-03-15T17:00:00"
    );
}

#[test]
fn a_deadline_moves_nothing_and_is_told() {
    let check = |date: &str, is_told: bool| {
        let timeline = evaluated(&chain(ConstraintKind::Deadline, date), &[]);
        assert_eq!((dates(&timeline, 1)[1].as_str(), timeline.float(1).unwrap().total_s), ("03-12T17:00", 0));
        assert_eq!(diagnostic(&timeline, "constraint_unmet").is_some(), is_told, "{date}");
    };
    check("03-12T17:00", false);
    check("03-12T16:00", true);
}

#[test]
fn as_late_as_possible_uses_up_the_free_float() {
    let late = PlanTask {
        constraints: vec![Constraint { kind: ConstraintKind::AsLateAsPossible, date: None }],
        ..task("late", 8)
    };
    let before = PlanTask { uid: "before".into(), name: "before".into(), ..late.clone() };
    let links = vec![
        after(0, 1, DependencyKind::FinishStart, 0),
        after(3, 2, DependencyKind::FinishStart, 0),
        after(2, 1, DependencyKind::FinishStart, 8),
    ];
    let timeline = evaluated(&plan(vec![task("long", 40), task("end", 8), late, before], links), &[]);
    assert_eq!(dates(&timeline, 1), ["03-11T08:00", "03-11T17:00"]);
    assert_eq!(dates(&timeline, 2), ["03-07T08:00", "03-07T17:00"]);
    assert_eq!(dates(&timeline, 3), ["03-06T08:00", "03-06T17:00"]);
}

#[test]
fn a_delay_stops_at_a_date_that_goes_before_dependencies() {
    let check = |kind, honours_constraints, start: &str| {
        let plan = PlanFile { honours_constraints, ..chain(kind, "03-12T08:00") };
        let timeline = evaluated(&plan, &["A=5d"]);
        assert_eq!(dates(&timeline, 1)[0], start, "{kind:?}");
        assert!(diagnostic(&timeline, "constraint_unmet").is_some(), "{kind:?}");
    };
    check(ConstraintKind::StartNotLaterThan, false, "03-18T08:00");
    check(ConstraintKind::StartNotLaterThan, true, "03-12T08:00");
    check(ConstraintKind::MandatoryStart, false, "03-12T08:00");
    let timeline = evaluated(&chain(ConstraintKind::MandatoryStart, "03-12T08:00"), &["B=1d"]);
    assert_eq!(dates(&timeline, 1)[0], "03-13T08:00", "its own delay moves it");
}

#[test]
fn drawn_dates_keep_constraints() {
    let check = |kind, date: &str, honours_constraints, range: [&str; 2]| {
        let plan = PlanFile { honours_constraints, ..chain(kind, date) };
        let plans = [ScheduleFile { file: "plan.xer".to_owned(), sha256: [0; 32], plan }];
        let mut site = ScheduledSite::new();
        site.element("IfcWall");
        let bytes = site.builder.finish();
        let site = Site::open(bytes.bytes()).unwrap();
        let link = Link { task: 1, target: Target::Element(0), effect: Effect::Builds, origin: LinkOrigin::Table(1) };
        let links = Links { links: vec![link], ..Links::default() };
        let archive = tasks_of(&site, &plans, &LinkRules::default(), &links).finish();
        let tasks = Tasks::open(archive.bytes()).unwrap();
        let (site, rules) = (site.with_tasks(&tasks).unwrap(), Rules::default());
        let timeline = evaluate(&site, &rules, &Overrides::default()).unwrap();
        let drawn = probabilities(&site, &rules, &Overrides::default(), &timeline).unwrap();
        let begun = range.map(|at| {
            let at = format!("2024-{at}:00").parse::<frames::PlanTime>().unwrap().civil_seconds();
            drawn.elements(Period::instant(at))[0].there
        });
        assert_eq!(begun, [0.0, 1.0], "{kind:?}");
    };
    // A ends within some days around 8 March: B begins on its date, never before.
    check(ConstraintKind::StartNotEarlierThan, "04-15T08:00", false, ["04-15T07:00", "04-15T09:00"]);
    check(ConstraintKind::FinishNotEarlierThan, "04-30T17:00", false, ["04-23T08:00", "04-30T17:00"]);
    check(ConstraintKind::MandatoryStart, "03-06T08:00", false, ["03-06T07:00", "03-06T09:00"]);
    check(ConstraintKind::StartNotLaterThan, "03-06T08:00", true, ["03-06T07:00", "03-06T09:00"]);
}

/// A node of the work breakdown with a chain of two tasks and a WBS summary beside it, and another node in it with a task.
fn work_breakdown() -> PlanFile {
    let nested = |parent, task: PlanTask| PlanTask { parent: Some(parent), ..task };
    let node = |uid: &str| PlanTask { kind: PlanTaskKind::Summary, duration: None, ..task(uid, 0) };
    let wbs = PlanTask { kind: PlanTaskKind::WbsSummary, ..task("wbs", 8) };
    let tasks = vec![
        node("node"),
        nested(0, wbs),
        nested(0, task("a", 16)),
        nested(0, task("b", 8)),
        nested(0, node("inner")),
        nested(4, task("c", 8)),
    ];
    plan(tasks, vec![after(2, 3, DependencyKind::FinishStart, 0), after(3, 5, DependencyKind::FinishStart, 0)])
}

#[test]
fn a_wbs_summary_spans_all_tasks_below_its_node() {
    let mut plan = work_breakdown();
    let spanned = |plan: &PlanFile, delays: &[&str]| dates(&evaluated(plan, delays), 1);
    assert_eq!(spanned(&plan, &[]), ["03-04T08:00", "03-07T17:00"]);
    assert_eq!(spanned(&plan, &["a=1d"]), ["03-05T08:00", "03-08T17:00"]);
    assert_eq!(spanned(&plan, &["c=1d"]), ["03-04T08:00", "03-08T17:00"]);
    assert_eq!(spanned(&plan, &["node=1d"]), ["03-05T08:00", "03-08T17:00"], "not once more by itself");
    // Written dates are those of the file, and move with what they span.
    plan.tasks[1].dates.current = [at("03-04T08:00"), at("03-07T17:00")];
    assert_eq!(spanned(&plan, &[]), ["03-04T08:00", "03-07T17:00"]);
    assert_eq!(spanned(&plan, &["c=2d"]), ["03-04T08:00", "03-11T17:00"]);
    plan.tasks[1].duration = None;
    plan.tasks[1].dates = PlanDates::default();
    assert_eq!(spanned(&plan, &[]), ["03-04T08:00", "03-07T17:00"], "without a length, too");
}

#[test]
fn a_level_of_effort_without_dates_spans_what_it_is_linked_with_and_drives_nothing() {
    use DependencyKind::{FinishFinish, FinishStart, StartStart};
    let effort = PlanTask { kind: PlanTaskKind::Span, ..task("effort", 400) };
    let tasks = vec![task("a", 16), task("b", 8), effort];
    let mut plan =
        plan(tasks, vec![after(0, 1, FinishStart, 0), after(0, 2, StartStart, 0), after(1, 2, FinishFinish, 0)]);
    let all = |plan: &PlanFile, delays: &[&str]| {
        let timeline = evaluated(plan, delays);
        [1, 2].map(|k| dates(&timeline, k))
    };
    assert_eq!(all(&plan, &[]), [["03-06T08:00", "03-06T17:00"], ["03-04T08:00", "03-06T17:00"]]);
    assert_eq!(all(&plan, &["b=2d"])[1], ["03-04T08:00", "03-08T17:00"]);
    // What stands behind it says when it ends, and does not wait for it.
    plan.dependencies[2] = after(2, 1, FinishStart, 0);
    assert_eq!(all(&plan, &[]), [["03-06T08:00", "03-06T17:00"], ["03-04T08:00", "03-06T08:00"]]);
    assert_eq!(all(&plan, &["b=2d"]), [["03-08T08:00", "03-08T17:00"], ["03-04T08:00", "03-08T08:00"]]);
    plan.dependencies.truncate(1);
    assert_eq!(all(&plan, &[])[1], ["03-04T08:00", "03-04T08:00"], "linked with nothing, it takes no time");
}
