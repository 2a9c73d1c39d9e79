//! Malformed schedules: diagnostics name the task and evaluation continues.

mod support;

use messages::{Diagnostic, DiagnosticCode, SequenceKind, Severity};
use schedule::EvaluateError;
use support::{ScheduledSite, dates, diagnostic};

#[test]
fn tasks_in_a_circle_are_named_and_written_dates_stand() {
    let mut site = ScheduledSite::starting();
    let (a, b) = (site.lasting("Walls", "P1D"), site.lasting("Doors", "P1D"));
    let (behind, dated) = (site.lasting("Paint", "P1D"), site.dated("Roof", "2024-03-04", "2024-03-05"));
    for (from, to) in [(a, b), (b, a), (b, behind), (dated, dated)] {
        site.sequence(from, to, SequenceKind::FinishStart, "");
    }
    let timeline = site.evaluate();
    assert_eq!([a, b, behind].map(|t| dates(&timeline, t)), [None, None, None]);
    assert!(dates(&timeline, dated).is_some());
    let circle = diagnostic(&timeline, "task_cycle").unwrap();
    assert!(circle.message.contains("Walls") && circle.message.contains("Doors") && circle.severity == Severity::Error);
    let undated: Vec<&str> =
        timeline.diagnostics().iter().filter(|f| f.code == DiagnosticCode::TaskUndated).map(Diagnostic::name).collect();
    assert_eq!(undated, ["Walls", "Doors", "Paint"]);
}

#[test]
fn a_task_that_ends_before_it_starts_is_ignored_and_named() {
    let mut site = ScheduledSite::new();
    let (task, wall) = (site.dated("Walls", "2024-03-05T08:00:00", "2024-03-04T08:00:00"), site.element("IfcWall"));
    site.builds(task, wall);
    let timeline = site.evaluate();
    assert!(dates(&timeline, task).is_none() && timeline.instants_s().is_empty());
    assert!(
        diagnostic(&timeline, "task_reversed")
            .is_some_and(|f| f.name() == "Walls" && f.message.contains("2024-03-04T08:00:00"))
    );
}

#[test]
fn a_date_that_cannot_be_read_makes_its_task_count_for_nothing() {
    let mut site = ScheduledSite::new();
    let task = site.dated("Walls", "2024-02-30", "2024-03-04");
    let lasting = site.lasting("Doors", "three days");
    let timeline = site.evaluate();
    assert!(dates(&timeline, task).is_none() && dates(&timeline, lasting).is_none());
    let found: Vec<&str> = timeline
        .diagnostics()
        .iter()
        .filter(|f| f.code == DiagnosticCode::TaskDateUnreadable)
        .map(Diagnostic::name)
        .collect();
    assert_eq!(found, ["Walls", "Doors"]);
}

#[test]
fn dates_that_fit_two_orders_are_an_error_with_both_readings() {
    let mut site = ScheduledSite::new();
    let (a, b) = (site.element("IfcWall"), site.element("IfcWall"));
    site.properties(a, &[("Wall Schedule", "ConstructionDate", "08/04/2024")]);
    site.properties(b, &[("Wall Schedule", "ConstructionDate", "04/04/2024")]);
    let evaluate = |site: &ScheduledSite, rules: &str| {
        site.evaluate_with(&schedule::Rules::parse(rules).unwrap(), &schedule::Overrides::default())
    };
    let error = evaluate(&site, "").unwrap_err().to_string();
    for word in ["site.ifc", "08/04/2024", "2024-04-08", "2024-08-04", "element-0", "date_format"] {
        assert!(error.contains(word), "{error}");
    }
    assert!(evaluate(&site, "date_format = \"dmy\"").is_ok());
    // One date that has a single reading decides, and the others are listed.
    site.properties(b, &[("Wall Schedule", "ConstructionDate", "15/04/2024")]);
    let timeline = evaluate(&site, "").unwrap();
    assert!(diagnostic(&timeline, "date_ambiguous").is_some_and(|f| f.global_id() == "element-0"));
    let wrong = evaluate(&site, "date_format = \"mdy\"").unwrap();
    assert!(diagnostic(&wrong, "date_order").is_some_and(|f| f.global_id() == "element-1"));
    // Two that contradict each other decide nothing.
    site.properties(a, &[("Wall Schedule", "ConstructionDate", "04/25/2024")]);
    assert!(matches!(evaluate(&site, ""), Err(EvaluateError::ContradictingDates { .. })));
}

#[test]
fn placeholders_are_told_from_dates_that_cannot_be_read() {
    let mut site = ScheduledSite::new();
    let (a, b) = (site.element("IfcWall"), site.element("IfcWall"));
    site.properties(a, &[("Wall Schedule", "ConstructionDate", "InstallationDate")]);
    site.properties(b, &[("Wall Schedule", "ConstructionDate", "31/02/2024")]);
    let timeline = site.evaluate();
    assert!(diagnostic(&timeline, "date_placeholder").is_some_and(|f| f.global_id() == "element-0"));
    assert!(diagnostic(&timeline, "date_unreadable").is_some_and(|f| f.global_id() == "element-1"));
    assert_eq!(support::states(&timeline, b, &["1970-01-01"]), ["built"], "the next source counts: it exists");
}

#[test]
fn working_time_without_a_calendar_counts_day_and_night_and_is_reported() {
    let mut site = ScheduledSite::starting();
    let task = site.lasting("Walls", "P1D");
    let timeline = site.evaluate();
    assert_eq!(dates(&timeline, task).unwrap().1, "2024-03-05T08:00:00");
    assert!(diagnostic(&timeline, "calendar_missing").is_some_and(|f| f.name() == "Walls"));
}

#[test]
fn a_calendar_without_work_gives_no_dates_and_is_named() {
    let mut site = ScheduledSite::starting();
    let task = site.lasting("Walls", "P1D");
    let calendar = site.office_hours(&[task]);
    site.builder.schedule.calendars[calendar].n_working = 0;
    let timeline = site.evaluate();
    assert!(dates(&timeline, task).is_none());
    assert!(diagnostic(&timeline, "calendar_without_work").is_some_and(|f| f.global_id() == "calendar"));
}

#[test]
fn a_calendar_of_more_work_times_than_can_be_worked_out_gives_no_dates_and_is_named() {
    let mut site = ScheduledSite::starting();
    let task = site.lasting("Walls", "P1D");
    let calendar = site.office_hours(&[task]);
    let week = site.builder.schedule.work_times[0];
    site.builder.schedule.work_times.resize(100_000, week);
    site.builder.schedule.calendars[calendar].n_exceptions = 99_999;
    let timeline = site.evaluate();
    assert!(dates(&timeline, task).is_none());
    assert!(diagnostic(&timeline, "calendar_too_large").is_some_and(|f| f.message.contains("100000 work times")));
}

#[test]
fn a_predecessor_without_dates_leaves_its_successor_without_and_both_are_named() {
    let mut site = ScheduledSite::starting();
    let (a, b) = (site.task("Walls"), site.lasting("Doors", "P1D"));
    site.sequence(a, b, SequenceKind::FinishStart, "");
    let timeline = site.evaluate();
    let why: Vec<&str> = timeline.diagnostics().iter().map(|f| f.message.as_str()).collect();
    assert!(dates(&timeline, b).is_none() && why.iter().any(|m| m.contains("predecessor \"Walls\"")), "{why:?}");
}

#[test]
fn a_work_schedule_without_tasks_is_named() {
    let site = ScheduledSite::starting();
    assert!(diagnostic(&site.evaluate(), "schedule_empty").is_some_and(|f| f.global_id() == "schedule"));
}

#[test]
fn dates_with_a_zone_need_the_zone_of_the_site() {
    let mut site = ScheduledSite::new();
    let task = site.dated("Walls", "2024-07-01T08:00:00Z", "2024-07-01T10:00:00+02:00");
    assert!(diagnostic(&site.evaluate(), "task_date_unreadable").is_some_and(|f| f.message.contains("site_zone")));
    let timeline = site.ruled("site_zone = \"Europe/Amsterdam\"");
    let both = |t: &str| Some((t.to_owned(), t.to_owned()));
    assert_eq!(dates(&timeline, task), both("2024-07-01T10:00:00"));
    assert_eq!(dates(&site.ruled("site_zone = \"Europe/London\""), task), both("2024-07-01T09:00:00"));
}
