//! Meaning of dates, sequences, links and properties.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

mod support;

use messages::{ElementState, LinkKind, ScheduleStateHead, SequenceKind, link_flags};
use schedule::{Delay, EvaluateError, Overrides, Period, Rules, parse_actuals};
use support::{ScheduledSite, at, dates, diagnostic, states, text};

/// Two tasks of three and two working days in this relation; dates of the second.
fn second(kind: SequenceKind, lag: &str, change: impl Fn(&mut ScheduledSite)) -> (String, String) {
    let mut site = ScheduledSite::starting();
    let (first, second) = (site.lasting("first", "P3D"), site.lasting("second", "P2D"));
    site.office_hours(&[first, second]);
    site.sequence(first, second, kind, lag);
    change(&mut site);
    dates(&site.evaluate(), second).unwrap()
}

fn pair(start: &str, finish: &str) -> (String, String) {
    (text(at(start)), text(at(finish)))
}

#[test]
fn the_forward_pass_knows_four_relations_and_lags() {
    use SequenceKind::*;
    let none = |_: &mut ScheduledSite| {};
    // The first task ends on Wednesday at 17:00, the second goes on at 08:00 the next day.
    assert_eq!(second(FinishStart, "", none), pair("2024-03-07T08:00", "2024-03-08T17:00"));
    assert_eq!(second(FinishStart, "P1D", none), pair("2024-03-08T08:00", "2024-03-11T17:00"));
    assert_eq!(second(FinishStart, "-PT4H", none), pair("2024-03-06T13:00", "2024-03-08T12:00"));
    assert_eq!(second(StartStart, "PT4H", none), pair("2024-03-04T13:00", "2024-03-06T12:00"));
    assert_eq!(second(FinishFinish, "", none), pair("2024-03-05T08:00", "2024-03-06T17:00"));
    assert_eq!(second(StartFinish, "P4D", none), pair("2024-03-06T08:00", "2024-03-07T17:00"));
    let elapsed =
        |p: &mut ScheduledSite| p.builder.schedule.sequences[0].lag_kind = messages::DurationKind::ElapsedTime.into();
    // Friday 17:00 is no working instant: the task waits for Monday.
    assert_eq!(second(FinishStart, "P2D", elapsed), pair("2024-03-11T08:00", "2024-03-12T17:00"));
    let half = |p: &mut ScheduledSite| p.builder.schedule.sequences[0].lag_ratio = 0.5;
    assert_eq!(second(FinishStart, "", half), pair("2024-03-08T13:00", "2024-03-12T12:00"));
}

#[test]
fn a_day_is_a_working_day_or_24_hours_by_configuration() {
    let mut site = ScheduledSite::new();
    let task = site.task("task");
    let (start, duration) = (site.text("2024-03-04T08:00:00"), site.text("P1D"));
    (site.builder.schedule.tasks[task].schedule_start, site.builder.schedule.tasks[task].schedule_duration) =
        (start, duration);
    site.office_hours(&[task]);
    assert_eq!(dates(&site.evaluate(), task), Some(pair("2024-03-04T08:00", "2024-03-04T17:00")));
    assert_eq!(dates(&site.ruled("duration_day = \"24h\""), task), Some(pair("2024-03-04T08:00", "2024-03-06T17:00")));
    assert!(diagnostic(&site.evaluate(), "duration_in_days").is_some());
}

#[test]
fn whole_days_end_at_the_next_midnight_and_summaries_roll_up() {
    let mut site = ScheduledSite::new();
    let root = site.dated("root", "2024-01-01", "2024-01-02");
    let (a, b) = (site.dated("a", "2024-03-04", "2024-03-05"), site.dated("b", "2024-03-05T12:00:00", "2024-03-08"));
    site.nest(root, &[a, b]);
    let timeline = site.evaluate();
    assert_eq!(dates(&timeline, a), Some(pair("2024-03-04", "2024-03-06")));
    assert_eq!(dates(&timeline, root), Some(pair("2024-03-04", "2024-03-09")));
    assert!(diagnostic(&timeline, "summary_dates_differ").is_some_and(|f| f.name() == "root"));
}

#[test]
fn a_task_without_a_time_takes_that_of_what_it_is_nested_in() {
    let mut site = ScheduledSite::new();
    let (root, part) = (site.dated("root", "2024-03-04", "2024-03-05"), site.task("part"));
    site.nest(root, &[part]);
    assert_eq!(dates(&site.evaluate(), part), Some(pair("2024-03-04", "2024-03-06")));
}

#[test]
fn actual_dates_beat_planned_ones_and_push_what_is_computed() {
    let mut site = ScheduledSite::starting();
    let (first, second) =
        (site.dated("first", "2024-03-04T08:00:00", "2024-03-05T17:00:00"), site.lasting("second", "P1D"));
    site.sequence(first, second, SequenceKind::FinishStart, "");
    site.office_hours(&[first, second]);
    assert_eq!(dates(&site.evaluate(), second), Some(pair("2024-03-06T08:00", "2024-03-06T17:00")));
    let started = site.text("2024-03-06T08:00:00");
    site.builder.schedule.tasks[first].actual_start = started;
    site.builder.schedule.tasks[first].completion = 1.0;
    let timeline = site.evaluate();
    assert_eq!(dates(&timeline, first), Some(pair("2024-03-06T08:00", "2024-03-07T17:00")), "it lasts as planned");
    assert_eq!(dates(&timeline, second), Some(pair("2024-03-08T08:00", "2024-03-08T17:00")));
    assert!(diagnostic(&timeline, "completion_without_finish").is_some());
}

#[test]
fn elements_are_built_when_the_last_task_at_them_ends() {
    let mut site = ScheduledSite::new();
    let wall = site.element("IfcWall");
    let (a, b) = (site.dated("a", "2024-03-04T08:00:00", "2024-03-05"), site.dated("b", "2024-03-08", "2024-03-08"));
    [a, b].into_iter().for_each(|task| site.builds(task, wall));
    // Both directions of a link are one.
    site.link(a, LinkKind::Element, wall, link_flags::INPUT);
    let timeline = site.evaluate();
    let found =
        states(&timeline, wall, &["2024-03-04", "2024-03-04T08:00", "2024-03-07", "2024-03-08T23:59:59", "2024-03-09"]);
    assert_eq!(found, ["not_started", "in_progress", "in_progress", "in_progress", "built"]);
    assert_eq!(timeline.instants_s().len(), 2, "a pause between two tasks is no change");
}

#[test]
fn what_a_task_does_depends_on_its_type() {
    let check = |kind: &str, flags: u32, rules: &str| {
        let mut site = ScheduledSite::new();
        let (task, element) = (site.dated("task", "2024-03-04", "2024-03-04"), site.element("IfcFurniture"));
        site.kind(task, kind);
        site.link(task, LinkKind::Element, element, flags);
        let found = states(&site.ruled(rules), element, &["2024-03-03", "2024-03-04", "2024-03-05"]);
        [found[0], found[1], found[2]]
    };
    let (constructed, removed) = (["not_started", "in_progress", "built"], ["built", "being_removed", "removed"]);
    for kind in ["CONSTRUCTION", "INSTALLATION", "NOTDEFINED", ""] {
        assert_eq!((check(kind, 0, ""), check(kind, link_flags::INPUT, "")), (constructed, constructed), "{kind}");
    }
    for kind in ["DEMOLITION", "REMOVAL", "DISMANTLE", "DISPOSAL"] {
        assert_eq!((check(kind, 0, ""), check(kind, link_flags::INPUT, "")), (removed, removed), "{kind}");
    }
    for kind in ["MOVE", "LOGISTIC"] {
        assert_eq!((check(kind, 0, ""), check(kind, link_flags::INPUT, "")), (constructed, removed), "{kind}");
    }
    for kind in ["RENOVATION", "MAINTENANCE", "ATTENDANCE", "ROOMCLOSED", "USERDEFINED"] {
        assert_eq!(check(kind, 0, ""), ["built"; 3], "{kind}");
    }
    assert_eq!(check("CONSTRUCTION", link_flags::INPUT, "inputs = \"consume\""), removed);
}

#[test]
fn what_is_built_can_be_removed_and_built_again() {
    let mut site = ScheduledSite::new();
    let wall = site.element("IfcWall");
    for (name, day, kind) in
        [("up", "2024-03-04", "CONSTRUCTION"), ("down", "2024-03-06", "DISMANTLE"), ("again", "2024-03-08", "")]
    {
        let task = site.dated(name, day, day);
        site.kind(task, kind);
        site.builds(task, wall);
    }
    let days = ["2024-03-03", "2024-03-05", "2024-03-06", "2024-03-07", "2024-03-08", "2024-03-09"];
    let found = states(&site.evaluate(), wall, &days);
    assert_eq!(found, ["not_started", "built", "being_removed", "removed", "in_progress", "built"]);
}

#[test]
fn own_links_win_over_those_of_the_whole_and_these_over_those_of_the_storey() {
    let mut site = ScheduledSite::new();
    let (storey, stair, flight, wall) =
        (site.storey(), site.element("IfcStair"), site.element("IfcStairFlight"), site.element("IfcWall"));
    for element in [stair, flight, wall] {
        site.builder.elements[element].storey = storey as u32;
    }
    site.builder.elements[flight].whole = stair as u32;
    let (all, own) = (site.dated("all", "2024-03-04", "2024-03-04"), site.dated("own", "2024-04-01", "2024-04-01"));
    site.link(all, LinkKind::Storey, storey, 0);
    site.builds(own, stair);
    let building = site.dated("building", "2024-05-01", "2024-05-01");
    site.link(building, LinkKind::Storey, storey, link_flags::FROM_ABOVE);
    let timeline = site.evaluate();
    assert_eq!(states(&timeline, wall, &["2024-03-05"]), ["built"], "the storey, not the building");
    assert_eq!(states(&timeline, flight, &["2024-03-05", "2024-04-02"]), ["not_started", "built"]);
}

#[test]
fn spaces_are_blocked_by_work_at_what_bounds_them_is_in_them_or_touches_them() {
    let mut site = ScheduledSite::new();
    let (wall, chair, stair) = (site.element("IfcWall"), site.element("IfcFurniture"), site.element("IfcStair"));
    let flight = site.element("IfcStairFlight");
    site.builder.elements[flight].whole = stair as u32;
    let spaces = ["bounded", "holding", "touched", "linked", "beside"].map(|name| site.space(name));
    site.bounds(spaces[0], wall);
    site.builder.elements[chair].space = spaces[1] as u32;
    let contact = messages::BoundaryRecord { space: spaces[2] as u32, element: flight as u32 };
    site.builder.contacts.push(contact);
    let task = site.dated("work", "2024-03-04T08:00:00", "2024-03-04T17:00:00");
    site.kind(task, "MAINTENANCE");
    [wall, chair, stair].into_iter().for_each(|element| site.builds(task, element));
    site.link(task, LinkKind::Space, spaces[3], 0);
    let timeline = site.evaluate();
    let blocked = |t: &str| spaces.map(|s| timeline.is_blocked(s, at(t)));
    assert_eq!(blocked("2024-03-04T08:00"), [true, true, true, true, false]);
    assert_eq!((blocked("2024-03-04T07:59:59"), blocked("2024-03-04T17:00")), ([false; 5], [false; 5]));
    assert_eq!(timeline.why(0, Period::instant(at("2024-03-04T12:00"))), ["task:work"]);
}

#[test]
fn rooms_open_at_the_end_of_their_date_and_reasons_are_sorted() {
    let mut site = ScheduledSite::new();
    let lab = site.space("Lab 3.1");
    site.space_properties(lab, &[("Room Schedule", "RoomDate", "15/04/2024")]);
    for name in ["b", "a"] {
        let task = site.dated(name, "2024-04-15", "2024-04-15");
        site.link(task, LinkKind::Space, lab, 0);
    }
    let timeline = site.ruled("[[closed_spaces]]\nmatch = \"Lab 3*\"\nuntil = 2024-04-20");
    let why = |t: &str| timeline.why(lab, Period::instant(at(t)));
    assert_eq!(why("2024-04-15T12:00"), ["task:a", "task:b", "before_room_date", "private"]);
    assert_eq!(why("2024-04-16"), ["private"]);
    assert!(why("2024-04-21").is_empty() && !timeline.is_blocked(lab, at("2024-04-21")));
    let unknown = site.ruled("[[closed_spaces]]\nmatch = \"Attic\"");
    assert!(diagnostic(&unknown, "closed_space_unknown").is_some_and(|f| f.message.contains("Attic")));
}

#[test]
fn tasks_rank_before_properties_these_before_construction_phases_and_status_says_nothing_of_time() {
    let mut site = ScheduledSite::new();
    let walls: Vec<usize> = (0..5).map(|_| site.element("IfcWall")).collect();
    let task = site.dated("task", "2024-03-04", "2024-03-04");
    site.builds(task, walls[0]);
    let date = ("Wall Schedule", "ConstructionDate", "15/04/2024");
    let actual = ("As built", "Finished", "2024-05-01");
    let construction_phase = ("Phasing", "Phase Created", "Phase 1");
    let status = ("Pset_WallCommon", "Status", "TEMPORARY");
    site.properties(walls[0], &[date]);
    site.properties(walls[1], &[date, actual]);
    site.properties(walls[2], &[construction_phase, date]);
    site.properties(walls[3], &[status, construction_phase]);
    site.properties(walls[4], &[status]);
    let rules = "[[property_dates]]\napplies_to = \"IfcWall\"\nset = \"Wall Schedule\"\nproperty = \"ConstructionDate\"\n\
        [[property_dates]]\napplies_to = \"IfcElement\"\nset = \"As built\"\nproperty = \"Finished\"\nkind = \"actual\"\n\
        [[phases]]\nname = \"Phase 1\"\nstart = 2024-06-01\nfinish = 2024-06-30";
    let timeline = site.ruled(rules);
    let built: Vec<&str> = ["2024-03-05", "2024-05-02", "2024-04-16", "2024-07-01", "1970-01-01"].to_vec();
    for (wall, from) in walls.iter().zip(built) {
        assert_eq!(states(&timeline, *wall, &[from]), ["built"], "wall {wall}");
        let before = timeline.element(*wall, at(from) - 1);
        assert!(before != ElementState::Built || *wall == walls[4], "wall {wall}");
    }
    assert!(diagnostic(&timeline, "status_without_date").is_some_and(|f| f.global_id() == "element-4"));
    assert_eq!(
        states(&site.ruled("undated = \"absent\""), walls[3], &["2024-07-01"]),
        ["built"],
        "its status says that it exists"
    );
}

#[test]
fn elements_without_any_date_exist_unless_the_rules_say_otherwise() {
    let mut site = ScheduledSite::new();
    let chair = site.element("IfcFurniture");
    assert_eq!(states(&site.evaluate(), chair, &["1970-01-01"]), ["built"]);
    assert_eq!(states(&site.ruled("undated = \"absent\""), chair, &["2030-01-01"]), ["not_started"]);
}

#[test]
fn the_published_rule_draws_walls_and_doors_from_the_day_behind_their_date() {
    let mut site = ScheduledSite::new();
    let (wall, undated, slab) = (site.element("IfcWall"), site.element("IfcWall"), site.element("IfcSlab"));
    site.properties(wall, &[("Wall Schedule", "ConstructionDate", "08/04/2024")]);
    let (room, other) = (site.space("room"), site.space("other"));
    site.space_properties(room, &[("Room Schedule", "RoomDate", "08/04/2024")]);
    let timeline = site.ruled("mode = \"paper\"");
    assert_eq!(states(&timeline, wall, &["2024-04-08", "2024-04-09"]), ["not_started", "built"]);
    assert_eq!(states(&timeline, undated, &["2030-01-01"]), ["not_started"]);
    assert_eq!(states(&timeline, slab, &["2030-01-01"]), ["not_started"]);
    assert!(timeline.is_blocked(room, at("2024-04-08")) && !timeline.is_blocked(room, at("2024-04-09")));
    assert!(timeline.is_blocked(other, at("2030-01-01")) && diagnostic(&timeline, "room_undated").is_some());
}

#[test]
fn a_delay_moves_what_depends_on_the_task_and_uses_up_float_first() {
    let mut site = ScheduledSite::starting();
    let (a, b) = (site.lasting("a", "P2D"), site.lasting("b", "P1D"));
    let c = site.dated("c", "2024-03-08T08:00:00", "2024-03-08T17:00:00");
    site.sequence(a, b, SequenceKind::FinishStart, "");
    site.sequence(b, c, SequenceKind::FinishStart, "");
    site.office_hours(&[a, b, c]);
    let delayed = |by: &str| {
        let overrides = Overrides { delays: vec![Delay::parse(by).unwrap()], ..Overrides::default() };
        site.evaluate_with(&Rules::default(), &overrides).unwrap()
    };
    let timeline = delayed("a=1d");
    assert_eq!(dates(&timeline, a), Some(pair("2024-03-05T08:00", "2024-03-06T17:00")));
    assert_eq!(dates(&timeline, b), Some(pair("2024-03-07T08:00", "2024-03-07T17:00")));
    assert_eq!(dates(&timeline, c), Some(pair("2024-03-08T08:00", "2024-03-08T17:00")), "one day of float");
    assert_eq!(dates(&delayed("a=12h"), b), Some(pair("2024-03-07T13:00", "2024-03-08T12:00")));
    assert_eq!(dates(&delayed("a=12h"), c), Some(pair("2024-03-08T13:00", "2024-03-11T12:00")));
    let unknown = Overrides { delays: vec![Delay::parse("nobody=1d").unwrap()], ..Overrides::default() };
    assert!(site.evaluate_with(&Rules::default(), &unknown).unwrap_err().to_string().contains("nobody"));
}

#[test]
fn floats_say_how_much_a_task_can_slip() {
    let mut site = ScheduledSite::starting();
    let (long, short, last) = (site.lasting("long", "P3D"), site.lasting("short", "P1D"), site.lasting("last", "P1D"));
    site.sequence(long, last, SequenceKind::FinishStart, "");
    site.sequence(short, last, SequenceKind::FinishStart, "");
    site.office_hours(&[long, short, last]);
    let timeline = site.evaluate();
    let hours = |task: usize| timeline.float(task).map(|f| (f.total_s / 3600, f.free_s / 3600));
    assert_eq!([long, short, last].map(hours), [Some((0, 0)), Some((16, 16)), Some((0, 0))]);
}

#[test]
fn what_a_robot_observed_beats_the_plan_and_is_beaten_by_reports() {
    let mut site = ScheduledSite::new();
    let task = site.dated("task", "2024-03-04", "2024-03-05");
    let (wall, door) = (site.element("IfcWall"), site.element("IfcDoor"));
    site.builds(task, wall);
    let with = |actuals: &str, observed: &str| {
        let overrides = Overrides {
            actuals: parse_actuals(actuals.as_bytes()).unwrap(),
            observed: parse_actuals(observed.as_bytes()).unwrap(),
            ..Overrides::default()
        };
        site.evaluate_with(&Rules::default(), &overrides)
    };
    let observed = "id,start,finish\nelement-0,,2024-03-01T09:00:00\nelement-1,absent,\nof-an-earlier-model,absent,\n";
    let timeline = with("id,start,finish\n", observed).unwrap();
    assert_eq!(states(&timeline, wall, &["2024-03-01T08:00", "2024-03-01T09:00"]), ["not_started", "built"]);
    assert_eq!(states(&timeline, door, &["2024-03-01", "2050-01-01"]), ["not_started", "not_started"]);
    let timeline = with("id,start,finish\nelement-0,2024-03-07,2024-03-07\n", observed).unwrap();
    assert_eq!(states(&timeline, wall, &["2024-03-02", "2024-03-08"]), ["not_started", "built"]);
    for wrong in ["task,absent,", "element-0,absent,2024-03-01"] {
        assert!(with(&format!("id,start,finish\n{wrong}\n"), "id,start,finish\n").is_err(), "{wrong}");
    }
}

#[test]
fn reports_of_what_a_revision_no_longer_has_are_a_warning_and_those_of_a_new_table_an_error() {
    let mut site = ScheduledSite::new();
    let wall = site.element("IfcWall");
    let table = b"id,start,finish\ngone,2024-03-01,2024-03-02\nelement-0,2024-03-05,2024-03-06\nalso-gone,absent,\n";
    let with = |is_of_earlier_revision| {
        let actuals = parse_actuals(table).unwrap();
        site.evaluate_with(&Rules::default(), &Overrides { actuals, is_of_earlier_revision, ..Overrides::default() })
    };
    assert!(matches!(with(false), Err(EvaluateError::Reported { id, .. }) if id == "gone"));
    let timeline = with(true).unwrap();
    assert_eq!(states(&timeline, wall, &["2024-03-04", "2024-03-07"]), ["not_started", "built"]);
    let warning = diagnostic(&timeline, "reported_progress_gone").unwrap();
    assert!(warning.message.contains("2 rows") && warning.message.contains("\"gone\""), "{}", warning.message);
}

#[test]
fn reported_progress_beats_the_plan_for_tasks_and_elements() {
    let mut site = ScheduledSite::new();
    let (task, other) =
        (site.dated("task", "2024-03-04", "2024-03-05"), site.dated("other", "2024-03-04", "2024-03-05"));
    let (wall, door, chair) = (site.element("IfcWall"), site.element("IfcDoor"), site.element("IfcFurniture"));
    site.builds(task, wall);
    site.builds(other, door);
    let report = |table: &str| {
        let overrides = Overrides { actuals: parse_actuals(table.as_bytes()).unwrap(), ..Overrides::default() };
        site.evaluate_with(&Rules::default(), &overrides)
    };
    let timeline =
        report("id,start,finish\ntask,2024-03-06,2024-03-06\nelement-1,2024-03-08,\nelement-2,2024-03-09,").unwrap();
    assert_eq!(
        states(&timeline, wall, &["2024-03-05", "2024-03-06", "2024-03-07"]),
        ["not_started", "in_progress", "built"]
    );
    assert_eq!(
        states(&timeline, door, &["2024-03-07", "2024-03-09", "2024-03-10"]),
        ["not_started", "in_progress", "built"]
    );
    assert_eq!(
        states(&timeline, chair, &["2024-03-08", "2050-01-01"]),
        ["not_started", "in_progress"],
        "its finish is not known"
    );
    let schedule_state = timeline.schedule_state(Period::instant(at("2024-03-05T00:00"))).finish();
    let schedule_state = messages::ScheduleState::open(schedule_state.bytes()).unwrap();
    assert_eq!(
        (schedule_state.planned(wall), schedule_state.effective(wall)),
        (messages::ElementState::InProgress, messages::ElementState::NotStarted),
        "the planned state stays"
    );
    assert_eq!(schedule_state.head.valid_until_s, at("2024-03-06T00:00"));
    for (table, word) in [
        ("id,start,finish\nnobody,2024-03-06,", "nobody"),
        ("id,start,finish\ntask,,", "neither"),
        ("id,start,finish\ntask,2024-03-06,2024-03-01", "before it starts"),
        ("id,start,finish\ntask,06/03/2024,", "06/03/2024"),
    ] {
        let error = report(table).unwrap_err().to_string();
        assert!(error.contains(word), "{error}");
    }
}

#[test]
fn a_day_is_the_union_of_its_instants() {
    let mut site = ScheduledSite::new();
    let (slab, room) = (site.element("IfcSlab"), site.space("room"));
    let task = site.dated("task", "2024-03-04T10:00:00", "2024-03-04T11:00:00");
    site.builds(task, slab);
    site.bounds(room, slab);
    let timeline = site.evaluate();
    let day = |from: &str, until: &str| Period { from_s: at(from), until_s: Some(at(until)) };
    let look = |period: Period| {
        ScheduledSite::schedule_state(&timeline, period, |p| {
            (p.planned(slab).name(), p.is_blocked(room), p.head.valid_from_s, p.head.valid_until_s)
        })
    };
    let none = ScheduleStateHead::NO_TIME;
    assert_eq!(look(day("2024-03-04", "2024-03-05")), ("in_progress", true, none, none));
    assert_eq!(look(day("2024-03-03", "2024-03-04")), ("not_started", false, none, at("2024-03-04T10:00")));
    assert_eq!(look(day("2024-03-04T11:00", "2024-03-05")), ("built", false, at("2024-03-04T11:00"), none));
    assert_eq!(look(day("2024-03-04T09:00", "2024-03-04T10:00")).3, at("2024-03-04T10:00"));
}

#[test]
fn spaces_that_are_closing_soon_say_when() {
    let mut site = ScheduledSite::new();
    let room = site.space("room");
    let task = site.dated("task", "2024-03-04T10:00:00", "2024-03-04T11:00:00");
    site.link(task, LinkKind::Space, room, 0);
    let timeline = site.evaluate();
    let closes =
        |t: &str| ScheduledSite::schedule_state(&timeline, Period::instant(at(t)), |p| p.spaces[room].closes_at_s);
    assert_eq!(
        (closes("2024-03-04T09:30"), closes("2024-03-04T09:29:59")),
        (at("2024-03-04T10:00"), ScheduleStateHead::NO_TIME)
    );
    assert_eq!(closes("2024-03-04T10:30"), ScheduleStateHead::NO_TIME, "it is blocked already");
}
