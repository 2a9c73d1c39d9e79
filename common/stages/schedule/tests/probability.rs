//! Probabilities: worked examples with known answers.

mod support;

use messages::{LinkKind, SequenceKind, Site, SpaceState};
use schedule::{Overrides, Period, Probabilities, ProbabilityError, Rules, evaluate, parse_actuals, probabilities};
use support::{ScheduledSite, at};

const RUNS: u32 = 20_000;

/// Asserts that a share of the runs is a probability: within four standard deviations of a share.
fn assert_share(found: f64, expected: f64) {
    let deviation = (expected * (1.0 - expected) / f64::from(RUNS)).sqrt();
    assert!((found - expected).abs() <= 4.0 * deviation + 1e-12, "{found} is not {expected}");
}

fn with_runs<T>(site: &ScheduledSite, look: impl FnOnce(&Probabilities<'_>) -> T) -> T {
    let rules = format!("[uncertainty]\nruns = {RUNS}");
    site.with_probabilities(&rules, &Overrides::default(), |_, probabilities| look(probabilities))
}

/// Probability that an element stands some hours after the work schedule starts.
fn stands_after_h(probabilities: &Probabilities<'_>, element: usize, hours: i64) -> f64 {
    probabilities.elements(Period::instant(at("2024-03-04T08:00:00") + hours * 3600))[element].stands
}

#[test]
fn a_single_task_finishes_as_its_triangular_distribution_says() {
    let mut site = ScheduledSite::starting();
    let (task, wall) = (site.lasting("walls", "PT100H"), site.element("IfcWall"));
    site.builds(task, wall);
    site.three_point_h(task, [80, 100, 150]);
    with_runs(&site, |probabilities| {
        // Areas of a triangle from 80 over 100 to 150: 10 * 10 / (70 * 20), 20 / 70, 1 - 25 * 25 / (70 * 50).
        for (hours, expected) in [(80, 0.0), (90, 1.0 / 14.0), (100, 2.0 / 7.0), (125, 1.0 - 25.0 / 140.0), (150, 1.0)]
        {
            assert_share(stands_after_h(probabilities, wall, hours), expected);
        }
        let started = probabilities.elements(Period::instant(at("2024-03-04T08:00:00")))[wall];
        assert_eq!((started.there, started.stands), (1.0, 0.0), "its start is certain");
    });
}

#[test]
fn without_three_points_the_rules_spread_the_planned_duration() {
    let mut site = ScheduledSite::starting();
    let (task, wall) = (site.lasting("walls", "PT100H"), site.element("IfcWall"));
    site.builds(task, wall);
    with_runs(&site, |probabilities| {
        // From 90 over 100 to 150 hours.
        for (hours, expected) in [(90, 0.0), (100, 1.0 / 6.0), (125, 1.0 - 25.0 * 25.0 / (60.0 * 50.0)), (150, 1.0)] {
            assert_share(stands_after_h(probabilities, wall, hours), expected);
        }
    });
}

#[test]
fn an_element_that_needs_two_independent_tasks_stands_with_the_product_of_their_probabilities() {
    let mut site = ScheduledSite::starting();
    let (frame, wall) = (site.lasting("frame", "PT100H"), site.element("IfcWall"));
    let boards = site.lasting("boards", "PT100H");
    let [framed, boarded] = [frame, boards].map(|task| {
        let element = site.element("IfcColumn");
        site.builds(task, element);
        site.builds(task, wall);
        element
    });
    with_runs(&site, |probabilities| {
        let expected = 1.0 - 25.0 * 25.0 / (60.0 * 50.0);
        for element in [framed, boarded] {
            assert_share(stands_after_h(probabilities, element, 125), expected);
        }
        assert_share(stands_after_h(probabilities, wall, 125), expected * expected);
    });
}

#[test]
fn durations_of_a_chain_add_up_in_working_time() {
    let mut site = ScheduledSite::starting();
    let (first, second) = (site.lasting("first", "PT8H"), site.lasting("second", "PT8H"));
    let wall = site.element("IfcWall");
    site.builds(second, wall);
    site.office_hours(&[first, second]);
    site.sequence(first, second, SequenceKind::FinishStart, "");
    site.three_point_h(first, [8, 8, 16]);
    site.three_point_h(second, [8, 8, 8]);
    with_runs(&site, |probabilities| {
        let stands = |text: &str| probabilities.elements(Period::instant(at(text)))[wall].stands;
        assert_eq!(stands("2024-03-05T16:59:59"), 0.0);
        // The first task takes up to four hours more than a day: 1 - 4 * 4 / (8 * 8) of the area.
        assert_share(stands("2024-03-06T12:00:00"), 0.75);
        assert_eq!(stands("2024-03-06T13:00:00"), stands("2024-03-06T12:00:00"), "nothing ends in the lunch break");
        assert_share(stands("2024-03-06T17:00:00"), 1.0);
    });
}

#[test]
fn a_written_start_is_kept_until_float_is_used_up() {
    let mut site = ScheduledSite::new();
    let first = site.dated("first", "2024-03-04T00:00:00", "2024-03-06T00:00:00");
    let second = site.dated("second", "2024-03-07T00:00:00", "2024-03-08T00:00:00");
    let wall = site.element("IfcWall");
    site.builds(second, wall);
    site.sequence(first, second, SequenceKind::FinishStart, "");
    site.three_point_h(first, [24, 48, 120]);
    site.three_point_h(second, [24, 24, 24]);
    with_runs(&site, |probabilities| {
        let there = |text: &str| probabilities.elements(Period::instant(at(text)))[wall].there;
        assert_eq!(there("2024-03-06T23:59:59"), 0.0, "an early predecessor does not bring it forward");
        // The first task may take 72 hours before it moves the second: 1 - 48 * 48 / (96 * 72).
        assert_share(there("2024-03-07T00:00:00"), 1.0 - 48.0 * 48.0 / (96.0 * 72.0));
        assert_eq!(there("2024-03-09T00:00:00"), 1.0);
    });
}

#[test]
fn finished_tasks_do_not_vary_and_begun_ones_vary_in_what_is_left() {
    let mut site = ScheduledSite::starting();
    let tasks = ["finished", "begun"].map(|name| site.dated(name, "2024-03-04T00:00:00", "2024-03-08T04:00:00"));
    let walls = tasks.map(|task| {
        let wall = site.element("IfcWall");
        site.builds(task, wall);
        wall
    });
    site.builder.schedule.tasks[tasks[1]].completion = 0.5;
    let actuals = parse_actuals(
        b"id,start,finish\nfinished,2024-03-04T00:00:00,2024-03-08T04:00:00\nbegun,2024-03-04T00:00:00,\n",
    );
    let overrides = Overrides { actuals: actuals.unwrap(), ..Overrides::default() };
    let rules = format!("[uncertainty]\nruns = {RUNS}");
    site.with_probabilities(&rules, &overrides, |_, probabilities| {
        let stands = |hours: i64| {
            let elements = probabilities.elements(Period::instant(at("2024-03-04") + hours * 3600));
            walls.map(|wall| elements[wall].stands)
        };
        // Of the 100 hours 50 are done, and 45 to 75 are left.
        assert_eq!([stands(94), stands(125)], [[0.0, 0.0], [1.0, 1.0]]);
        assert_eq!(stands(100)[0], 1.0);
        assert_share(stands(100)[1], 1.0 / 6.0);
    });
}

#[test]
fn the_safest_days_of_a_space_are_those_on_which_least_is_likely_to_go_on_in_it() {
    let mut site = ScheduledSite::new();
    let task = site.dated("floor", "2024-03-05T00:00:00", "2024-03-07T00:00:00");
    site.kind(task, "MAINTENANCE");
    let [lab, hall] = ["lab", "hall"].map(|name| site.space(name));
    site.link(task, LinkKind::Space, lab, 0);
    site.three_point_h(task, [48, 48, 96]);
    with_runs(&site, |probabilities| {
        let first_day = at("2024-03-05") / 86_400;
        let safest = probabilities.safest_days(first_day, 5, 3);
        let days: Vec<i64> = safest[lab].iter().map(|d| d.day - first_day).collect();
        assert_eq!(days, [4, 3, 0], "9 and 8 March, then the first of those on which somebody works");
        assert_eq!(safest[lab][0].open, 1.0);
        assert_share(safest[lab][1].open, 0.75);
        assert_share(safest[lab][2].open, 0.0);
        assert_eq!(
            safest[hall].iter().map(|d| (d.day - first_day, d.open)).collect::<Vec<_>>(),
            [(0, 1.0), (1, 1.0), (2, 1.0)]
        );
        let day =
            |day: i64| Period { from_s: (first_day + day) * 86_400, until_s: Some((first_day + day + 1) * 86_400) };
        assert_eq!(probabilities.spaces_open(day(3))[lab], safest[lab][1].open);
    });
}

#[test]
fn a_space_that_may_be_worked_in_is_blocked_as_uncertain() {
    let mut site = ScheduledSite::new();
    let task = site.dated("floor", "2024-03-05T00:00:00", "2024-03-07T00:00:00");
    let lab = site.space("lab");
    site.link(task, LinkKind::Space, lab, 0);
    with_runs(&site, |probabilities| {
        let period = Period::instant(at("2024-03-07T12:00:00"));
        let state = probabilities.schedule_state(period).finish();
        let state = messages::ScheduleState::open(state.bytes()).unwrap();
        assert_eq!(state.spaces[lab].state, SpaceState::Blocked);
        assert_eq!(state.why(lab).collect::<Vec<_>>(), ["uncertain"]);
        assert_eq!(state.head.valid_until_s, messages::ScheduleStateHead::NO_TIME);
    });
}

#[test]
fn any_number_of_threads_draws_the_same() {
    let mut site = ScheduledSite::starting();
    let mut before = None;
    for k in 0..40 {
        let (task, wall) = (site.lasting(&format!("task-{k}"), "PT9H"), site.element("IfcWall"));
        site.builds(task, wall);
        before.map(|before| site.sequence(before, task, SequenceKind::FinishStart, "PT1H"));
        before = Some(task);
    }
    let drawn = |n_threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(n_threads).build().unwrap();
        pool.install(|| with_runs(&site, |p| p.elements(Period::instant(at("2024-03-10")))))
    };
    let one = drawn(1);
    assert!(one.iter().any(|e| 0.0 < e.stands && e.stands < 1.0));
    assert_eq!(one, drawn(7));
}

#[test]
fn another_seed_draws_other_durations_and_the_same_seed_the_same() {
    let mut site = ScheduledSite::starting();
    let (task, wall) = (site.lasting("walls", "PT100H"), site.element("IfcWall"));
    site.builds(task, wall);
    let stands = |seed: u32| {
        let rules = format!("[uncertainty]\nseed = {seed}");
        site.with_probabilities(&rules, &Overrides::default(), |_, p| stands_after_h(p, wall, 110))
    };
    assert_eq!(stands(1), stands(1));
    assert_ne!(stands(1), stands(2));
}

#[test]
fn more_runs_than_there_is_room_for_are_an_error_that_says_how_many_there_is() {
    let mut site = ScheduledSite::starting();
    (0..500).for_each(|k| {
        site.lasting(&format!("task-{k}"), "PT1H");
    });
    let site = site.builder.finish();
    let (site, rules) = (Site::open(site.bytes()).unwrap(), Rules::parse("[uncertainty]\nruns = 100000").unwrap());
    let timeline = evaluate(&site, &rules, &Overrides::default()).unwrap();
    let refused = probabilities(&site, &rules, &Overrides::default(), &timeline).err().unwrap();
    assert!(matches!(refused, ProbabilityError::TooMany { n_tasks: 500, most: 80_000, .. }), "{refused}");
}

#[test]
fn the_mode_of_the_prototype_has_no_probabilities() {
    let site = ScheduledSite::new().builder.finish();
    let (site, rules) = (Site::open(site.bytes()).unwrap(), Rules::parse("mode = \"paper\"").unwrap());
    let timeline = evaluate(&site, &rules, &Overrides::default()).unwrap();
    let refused = probabilities(&site, &rules, &Overrides::default(), &timeline).err();
    assert!(matches!(refused, Some(ProbabilityError::Paper)));
}
