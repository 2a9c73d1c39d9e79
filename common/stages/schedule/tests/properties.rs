//! Properties of every schedule.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

mod support;

use messages::{ElementState, LinkKind, SequenceKind, SpaceState};
use proptest::prelude::*;
use schedule::{Delay, Overrides, Period, Rules, Timeline};
use support::ScheduledSite;

/// Monday, 4 March 2024.
const MONDAY_S: i64 = 19_786 * 86_400;
const HOUR_S: i64 = 3_600;
const N_ELEMENTS: usize = 6;
const N_SPACES: usize = 3;

/// A task as drawn: start and length in hours, what it does, what it works on.
#[derive(Debug, Clone)]
struct Drawn {
    start_h: i64,
    length_h: i64,
    kind: usize,
    elements: Vec<usize>,
    spaces: Vec<usize>,
    /// Written dates; otherwise only a duration.
    is_dated: bool,
    /// Predecessors among earlier tasks, with relation and lag in hours.
    waits_for: Vec<(usize, usize, i64)>,
}

const KINDS: [&str; 5] = ["CONSTRUCTION", "INSTALLATION", "MAINTENANCE", "REMOVAL", "DEMOLITION"];
const RELATIONS: [SequenceKind; 4] =
    [SequenceKind::FinishStart, SequenceKind::StartStart, SequenceKind::FinishFinish, SequenceKind::StartFinish];

prop_compose! {
    fn drawn(kinds: usize)(
        (start_h, length_h) in (0i64..200, 0i64..60),
        kind in 0..kinds,
        elements in prop::collection::vec(0..N_ELEMENTS, 0..3),
        spaces in prop::collection::vec(0..N_SPACES, 0..2),
        is_dated in any::<bool>(),
        waits_for in prop::collection::vec((0usize..100, 0usize..4, 0i64..20), 0..3),
    ) -> Drawn {
        Drawn { start_h, length_h, kind, elements, spaces, is_dated, waits_for }
    }
}

fn schedules(kinds: usize) -> impl Strategy<Value = Vec<Drawn>> {
    prop::collection::vec(drawn(kinds), 1..10)
}

fn scheduled_site_of(tasks: &[Drawn], with_calendar: bool) -> ScheduledSite {
    let mut site = ScheduledSite::starting();
    for k in 0..N_SPACES {
        site.space(&format!("space-{k}"));
    }
    for k in 0..N_ELEMENTS {
        site.element("IfcWall");
        site.bounds(k % N_SPACES, k);
    }
    for (k, drawn) in tasks.iter().enumerate() {
        let name = format!("task-{k}");
        let task = if drawn.is_dated {
            let (start_s, length_s) = (MONDAY_S + drawn.start_h * HOUR_S, drawn.length_h * HOUR_S);
            site.dated(&name, &support::text(start_s), &support::text(start_s + length_s))
        } else {
            site.lasting(&name, &format!("PT{}H", drawn.length_h))
        };
        site.kind(task, KINDS[drawn.kind]);
        drawn.elements.iter().for_each(|e| site.builds(task, *e));
        drawn.spaces.iter().for_each(|s| site.link(task, LinkKind::Space, *s, 0));
        for (predecessor, relation, lag_h) in drawn.waits_for.iter().filter(|_| k > 0) {
            site.sequence(predecessor % k.max(1), task, RELATIONS[*relation], &format!("PT{lag_h}H"));
        }
    }
    if with_calendar {
        site.office_hours(&(0..tasks.len()).collect::<Vec<_>>());
    }
    site
}

/// Instants around all changes, in order.
fn probes(timeline: &Timeline) -> Vec<i64> {
    let around = timeline.instants_s().iter().flat_map(|s| [s - 1, *s, s + 1]);
    let mut probes: Vec<i64> = around.chain([MONDAY_S - 86_400, MONDAY_S + 1_000 * HOUR_S]).collect();
    probes.sort_unstable();
    probes
}

/// The state of an element the slow way: from the dates of all its tasks, every time anew.
fn slow_state(timeline: &Timeline, tasks: &[Drawn], element: usize, at_s: i64) -> ElementState {
    let mut works: Vec<(i64, i64, bool)> = tasks
        .iter()
        .enumerate()
        .filter(|(_, t)| t.elements.contains(&element) && KINDS[t.kind] != "MAINTENANCE")
        .filter_map(|(k, t)| timeline.task(k).map(|d| (d.start_s, d.finish_s, t.kind >= 3)))
        .collect();
    works.sort_unstable();
    let Some(begun) = works.iter().rposition(|w| w.0 <= at_s) else {
        let constructs = works.first().is_some_and(|w| !w.2);
        return if constructs { ElementState::NotStarted } else { ElementState::Built };
    };
    let removes = works[begun].2;
    let same = |w: &&(i64, i64, bool)| w.2 == removes;
    let before = works[..begun].iter().rev().take_while(same);
    let end_s = before.chain(works[begun..].iter().take_while(same)).map(|w| w.1).max().unwrap();
    match (removes, at_s < end_s) {
        (false, true) => ElementState::InProgress,
        (false, false) => ElementState::Built,
        (true, true) => ElementState::BeingRemoved,
        (true, false) => ElementState::Removed,
    }
}

proptest! {
    #[test]
    fn evaluation_at_a_date_equals_a_slow_direct_one(tasks in schedules(5), with_calendar in any::<bool>()) {
        let timeline = scheduled_site_of(&tasks, with_calendar).evaluate();
        for at_s in probes(&timeline) {
            for element in 0..N_ELEMENTS {
                prop_assert_eq!(timeline.element(element, at_s), slow_state(&timeline, &tasks, element, at_s));
            }
            for space in 0..N_SPACES {
                let at_work = (0..tasks.len()).filter(|k| timeline.task(*k).is_some_and(|d| d.start_s <= at_s && at_s < d.finish_s));
                let is_near = |k: &usize| {
                    tasks[*k].spaces.contains(&space) || tasks[*k].elements.iter().any(|e| e % N_SPACES == space)
                };
                let why: Vec<String> = at_work.filter(is_near).map(|k| format!("task:task-{k}")).collect();
                prop_assert_eq!(timeline.is_blocked(space, at_s), !why.is_empty());
                prop_assert_eq!(timeline.why(space, Period::instant(at_s)), why);
            }
        }
    }

    #[test]
    fn every_change_instant_changes_something(tasks in schedules(5)) {
        let timeline = scheduled_site_of(&tasks, true).evaluate();
        let look = |at_s: i64| {
            let elements: Vec<ElementState> = (0..N_ELEMENTS).map(|e| timeline.element(e, at_s)).collect();
            (elements, (0..N_SPACES).map(|s| timeline.is_blocked(s, at_s)).collect::<Vec<_>>())
        };
        for &at_s in timeline.instants_s() {
            prop_assert_ne!(look(at_s - 1), look(at_s));
        }
        let changes = timeline.changes();
        prop_assert!(changes.iter().all(|c| !c.elements.is_empty() || !c.spaces.is_empty()));
        prop_assert_eq!(changes.len(), timeline.instants_s().len());
    }

    #[test]
    fn without_removal_the_built_set_only_grows(tasks in schedules(3)) {
        let timeline = scheduled_site_of(&tasks, true).evaluate();
        let built = |at_s: &i64| [0, 1, 2, 3, 4, 5].map(|e| timeline.element(e, *at_s) == ElementState::Built);
        let over_time: Vec<_> = probes(&timeline).iter().map(built).collect();
        for pair in over_time.windows(2) {
            prop_assert!((0..N_ELEMENTS).all(|e| !pair[0][e] || pair[1][e]));
        }
    }

    #[test]
    fn a_delay_never_makes_anything_earlier(tasks in schedules(3), delayed in 0usize..10, hours in 0i64..100) {
        let site = scheduled_site_of(&tasks, true);
        let before = site.evaluate();
        let delay = Delay::parse(&format!("task-{}={hours}h", delayed % tasks.len())).unwrap();
        let after = site.evaluate_with(&Rules::default(), &Overrides { delays: vec![delay], ..Overrides::default() }).unwrap();
        for k in 0..tasks.len() {
            let (Some(old), Some(new)) = (before.task(k), after.task(k)) else { continue };
            prop_assert!(old.start_s <= new.start_s && old.finish_s <= new.finish_s, "task {k}: {old:?} {new:?}");
        }
        let built_at = |timeline: &Timeline, element: usize| {
            let instants = timeline.instants_s().iter();
            instants.rev().find(|s| timeline.element(element, **s - 1) != ElementState::Built && timeline.element(element, **s) == ElementState::Built).copied()
        };
        for element in 0..N_ELEMENTS {
            prop_assert!(built_at(&before, element) <= built_at(&after, element));
        }
    }

    #[test]
    fn a_period_is_the_union_of_its_instants(tasks in schedules(5), from_h in 0i64..200, hours in 1i64..72) {
        let site = scheduled_site_of(&tasks, true);
        let timeline = site.evaluate();
        let (from_s, until_s) = (MONDAY_S + from_h * HOUR_S, MONDAY_S + (from_h + hours) * HOUR_S);
        let inside: Vec<i64> = (from_s..until_s).step_by(HOUR_S as usize / 2).chain(probes(&timeline)).filter(|s| (from_s..until_s).contains(s)).collect();
        ScheduledSite::schedule_state(&timeline, Period { from_s, until_s: Some(until_s) }, |schedule_state| {
            for element in 0..N_ELEMENTS {
                let states: Vec<ElementState> = inside.iter().map(|s| timeline.element(element, *s)).collect();
                let union = schedule_state.planned(element);
                assert_eq!(union.is_obstacle(), states.iter().any(|s| s.is_obstacle()));
                assert_eq!(union == ElementState::Built, states.iter().all(|s| *s == ElementState::Built));
            }
            for space in 0..N_SPACES {
                assert_eq!(schedule_state.is_blocked(space), inside.iter().any(|s| timeline.is_blocked(space, *s)));
            }
        });
    }

    #[test]
    fn without_spread_states_are_certain_and_those_of_the_timeline(
        tasks in schedules(5), with_calendar in any::<bool>(), delayed in 0usize..10, delay_h in 0i64..30, hours in 1i64..72,
    ) {
        let site = scheduled_site_of(&tasks, with_calendar);
        let delay = Delay::parse(&format!("task-{}={delay_h}h", delayed % tasks.len())).unwrap();
        let overrides = Overrides { delays: vec![delay], ..Overrides::default() };
        let rules = "[uncertainty]\noptimistic = 1.0\npessimistic = 1.0\nruns = 2";
        site.with_probabilities(rules, &overrides, |timeline, probabilities| {
            for from_s in probes(timeline) {
                for period in [Period::instant(from_s), Period { from_s, until_s: Some(from_s + hours * HOUR_S) }] {
                    let planned = timeline.schedule_state(period);
                    let share = |is_so: bool| if is_so { 1.0 } else { 0.0 };
                    for (state, found) in planned.effective.iter().zip(probabilities.elements(period)) {
                        assert_eq!(found.stands, share(*state == ElementState::Built));
                        assert_eq!(found.there, share(state.get().is_obstacle()));
                        assert_eq!(found.removed, share(*state == ElementState::Removed));
                    }
                    for (space, open) in planned.spaces.iter().zip(probabilities.spaces_open(period)) {
                        assert_eq!(open, share(space.state == SpaceState::Open));
                    }
                    let certain = probabilities.schedule_state(period);
                    assert_eq!(certain.effective, planned.effective);
                    assert_eq!(certain.spaces, planned.spaces);
                }
            }
        });
    }

    #[test]
    fn without_removal_elements_are_more_and_more_likely_to_stand(tasks in schedules(3), with_calendar in any::<bool>()) {
        let site = scheduled_site_of(&tasks, with_calendar);
        site.with_probabilities("[uncertainty]\nruns = 20", &Overrides::default(), |timeline, probabilities| {
            let mut before = [(0.0, 0.0); N_ELEMENTS];
            for at_s in probes(timeline) {
                for (before, found) in before.iter_mut().zip(probabilities.elements(Period::instant(at_s))) {
                    assert!(before.0 <= found.stands && before.1 <= found.there && found.stands <= found.there);
                    *before = (found.stands, found.there);
                }
            }
        });
    }
}
