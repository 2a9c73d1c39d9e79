//! The limits of the Python package, and the table of cases by which it says what the rule says: `_map_limits.py` and
//! `map_verdicts.json`, written with UPDATE_GOLDEN=1.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

use bus::{Daemon, Stamp};
use messages::{ContentHash, GridsHead, RobotProfile, ScheduleStateBuilder};
use serde_json::{Value, json};
use site_view::{
    ClockTime, FOLLOWER, FRESH_TOLERANCE, GRIDS_LATE, MISSED_HEARTBEATS, MapRule, MapVerdict, NextState,
    SCHEDULE_REPORTERS, SILENT_AFTER, WATCHED, newest_schedule_report,
};
use std::path::Path;
use std::time::Duration;

/// What the rule hears.
#[derive(Clone, Copy)]
enum Event {
    Joined,
    Heartbeat(Daemon),
    /// Hash and site.
    State(u64, u64),
    /// Schedule state, site, and whether its grids are there.
    Index(u64, u64, bool),
    Grids(bool),
    /// Milliseconds since 1970; the cases begin there.
    Due(i64),
    Distrust,
    PlanTimeStands,
    /// Nothing.
    Wait,
}

use Event::{Distrust, Due, Grids, Heartbeat, Index, Joined, PlanTimeStands, State, Wait};

impl Event {
    fn tell(self, rule: &mut MapRule, now: Stamp) {
        match self {
            Joined => rule.joined(now),
            Heartbeat(daemon) => rule.insert_heartbeat(now, daemon),
            State(hash, site) => {
                let head = ScheduleStateBuilder::everything_built(ContentHash::from_bits(site), 0, 0).head;
                rule.insert_schedule_state(now, ContentHash::from_bits(hash), &head);
            }
            Index(state, site, has_grids) => {
                let [schedule_state_hash, site_hash] = [state, site].map(ContentHash::from_bits);
                let robot = RobotProfile::DEFAULT;
                rule.insert_index(now, &GridsHead { site_hash, schedule_state_hash, plan_time_s: 0, robot }, has_grids);
            }
            Grids(has_grids) => rule.set_grids(now, has_grids),
            Due(utc_ms) => rule.set_next_state(NextState::Due { utc_ms }),
            Distrust => rule.set_next_state(NextState::Unknown { why: "clock_untrusted".to_owned() }),
            PlanTimeStands => rule.set_next_state(NextState::None),
            Wait => {}
        }
    }

    fn json(self) -> Value {
        match self {
            Joined => json!(["joined"]),
            Heartbeat(daemon) => json!(["heartbeat", daemon.name()]),
            State(hash, site) => json!(["state", hash, site]),
            Index(state, site, has_grids) => json!(["index", state, site, has_grids]),
            Grids(has_grids) => json!(["grids", has_grids]),
            Due(utc_ms) => json!(["due", utc_ms]),
            Distrust => json!(["distrust", "clock_untrusted"]),
            PlanTimeStands => json!(["stands"]),
            Wait => json!(["wait"]),
        }
    }
}

/// What is said after each event: time, event, verdict, and why there is no map.
fn case(events: &[(u64, Event)]) -> Value {
    let began = Stamp(1_000_000_000_000);
    let mut rule = MapRule::default();
    let mut step = |&(ms, event): &(u64, Event)| {
        let now = began + Duration::from_millis(ms);
        event.tell(&mut rule, now);
        let (verdict, why) = match rule.verdict(now, ClockTime::Machine(i64::try_from(ms).unwrap())) {
            MapVerdict::Current => ("current", None),
            MapVerdict::Overtaken => ("overtaken", None),
            MapVerdict::Hold => ("hold", None),
            MapVerdict::NoMap(why) => ("no_map", Some(why.to_string())),
        };
        json!([ms, event.json(), verdict, why])
    };
    events.iter().map(&mut step).collect()
}

/// Maps of state 1 and site 1, and what comes then.
fn begun(then: &[(u64, Event)]) -> Value {
    let begin = [(0, Joined), (0, State(1, 1)), (10, Index(1, 1, true))];
    case(&[&begin, then].concat())
}

/// A walk through the events by whole numbers from a linear congruential generator, with heartbeats of these daemons.
fn walk(seed: u64, heard: &[Daemon]) -> Value {
    let mut state = seed;
    let mut below = |n: u64| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) % n
    };
    let mut ms = 0;
    let mut events = vec![(0, Joined)];
    for _ in 0..40 {
        ms += below(700);
        events.push((
            ms,
            match below(16) {
                0..=4 => Heartbeat(heard[below(heard.len() as u64) as usize]),
                5 | 6 => State(1 + below(3), 1),
                7 | 8 => Index(1 + below(3), 1, below(4) > 0),
                9 | 10 => Grids(below(3) > 0),
                11 => Due(i64::try_from(ms + below(4_000)).unwrap()),
                12 => PlanTimeStands,
                13 if below(4) == 0 => Distrust,
                14 if below(4) == 0 => Joined,
                _ => Wait,
            },
        ));
    }
    case(&events)
}

fn table() -> Value {
    let [schedule_eval, rasterize] = WATCHED.map(Heartbeat);
    let follower = Heartbeat(FOLLOWER);
    let mut cases = json!({
        "nothing was heard": case(&[(0, Wait), (0, State(1, 1)), (0, Index(1, 1, true)), (9_000, Wait)]),
        "a set comes together": case(&[(0, Joined), (1, Index(1, 1, false)), (2, State(1, 1)), (3, Grids(true))]),
        "another site is another set": case(&[(0, Joined), (1, State(1, 1)), (2, Index(1, 2, true))]),
        "late grids": begun(&[(20, State(2, 1)), (1_019, Wait), (1_020, Wait), (1_100, Index(2, 1, true))]),
        "a state that is sent again": begun(&[(500, State(1, 1)), (2_000, Wait)]),
        "states faster than grids": begun(&[
            (100, State(2, 1)), (1_000, State(3, 1)), (1_900, State(4, 1)), (2_700, schedule_eval), (2_700, rasterize),
            (2_800, State(5, 1)), (3_099, Wait), (3_100, Wait),
        ]),
        "grids of the same state that do not come": begun(&[
            (100, Index(1, 1, false)), (2_000, schedule_eval), (2_000, rasterize), (3_099, Wait), (3_100, Wait),
            (3_200, Grids(true)),
        ]),
        "silence": begun(&[(2_000, schedule_eval), (2_999, Wait), (3_000, Wait), (3_100, rasterize), (5_000, Wait)]),
        "a daemon that is none of them": begun(&[(2_000, Heartbeat(Daemon::SlamAlign)), (2_999, Wait), (3_000, Wait)]),
        "what follows a server": begun(&[
            (2_000, follower), (3_000, Wait), (4_999, follower), (7_998, Wait), (7_999, Wait), (8_100, follower),
        ]),
        "what follows a server, and a daemon from before": begun(&[
            (100, schedule_eval), (100, rasterize), (2_000, follower), (4_999, schedule_eval), (5_000, Wait), (8_000, Wait),
        ]),
        "an earlier state in a new bus": begun(&[
            (2_000, Joined), (2_000, State(1, 1)), (2_100, Index(9, 1, true)), (4_500, schedule_eval), (4_500, rasterize),
            (4_999, Wait), (5_000, Wait),
        ]),
        "a newer state in a new bus": begun(&[(2_000, Joined), (2_000, State(2, 1)), (2_999, Wait), (3_000, Wait)]),
        "overdue": begun(&[(20, Due(-1_500)), (1_499, Wait), (1_500, Wait), (1_600, PlanTimeStands)]),
        "distrust": begun(&[(20, Distrust), (30, Due(100))]),
    });
    for seed in 0..30 {
        cases[format!("walk {seed}")] = walk(seed, &WATCHED);
    }
    for seed in 30..40 {
        cases[format!("walk {seed}, following")] = walk(seed, &[FOLLOWER]);
    }
    json!({ "schedule_reports": schedule_reports(), "cases": cases })
}

/// Which report tells when the next schedule state is due: when each daemon reported, and the one that counts at 100 ms.
fn schedule_reports() -> Value {
    let stamps = [None, Some(0), Some(99), Some(100), Some(101)];
    let chosen = |[a, b]: [Option<u64>; 2]| {
        let k = newest_schedule_report([a, b].map(|ms| ms.map(|ms| Stamp(ms * 1_000_000))), Stamp(100_000_000));
        json!([a, b, k.map(|k| SCHEDULE_REPORTERS[k].name())])
    };
    stamps.iter().flat_map(|a| stamps.iter().map(move |b| chosen([*a, *b]))).collect()
}

/// The module of the package with the limits of the rule.
fn limits() -> String {
    let names = |daemons: &[Daemon]| {
        let names: Vec<String> = daemons.iter().map(|daemon| format!("\"{daemon}\"")).collect();
        format!("({})", names.join(", "))
    };
    let ns = |limit: Duration| limit.as_nanos().to_string();
    let lines = [
        ("WATCHED", "tuple[str, ...]", names(&WATCHED), "Daemons without which maps grow old unnoticed."),
        (
            "FOLLOWER",
            "str",
            format!("\"{FOLLOWER}\""),
            "Publishes the maps in the place of these on a robot that follows a server.",
        ),
        (
            "SCHEDULE_REPORTERS",
            "tuple[str, ...]",
            names(&SCHEDULE_REPORTERS),
            "Daemons that report when the next schedule state is due.",
        ),
        ("MISSED_HEARTBEATS", "int", MISSED_HEARTBEATS.to_string(), "A daemon that has missed so many is silent."),
        ("SILENT_AFTER_NS", "int", ns(SILENT_AFTER), "Age of the last heartbeat of a daemon that is silent."),
        (
            "GRIDS_LATE_NS",
            "int",
            ns(GRIDS_LATE),
            "After this time without its grids a newer schedule state stops the robot.",
        ),
        (
            "FRESH_TOLERANCE_NS",
            "int",
            ns(FRESH_TOLERANCE),
            "After this time maps of which something else is unknown are not used.",
        ),
    ];
    let line = |(name, kind, value, what): &(&str, &str, String, &str)| {
        format!("{name}: {kind} = {value}\n\"\"\"{what}\"\"\"\n")
    };
    format!(
        "\"\"\"Limits of the rule by which maps may be used.\n\nWritten by a test of common/site-view with UPDATE_GOLDEN=1 from \
         those there: not to be edited.\n\"\"\"\n\nfrom __future__ import annotations\n\n{}",
        lines.iter().map(line).collect::<String>()
    )
}

/// A case a line.
fn text(table: &Value) -> String {
    let cases: Vec<String> = table["cases"]
        .as_object()
        .unwrap()
        .iter()
        .map(|(name, steps)| format!("    {}: {steps}", json!(name)))
        .collect();
    format!(
        "{{\n  \"schedule_reports\": {},\n  \"cases\": {{\n{}\n  }}\n}}\n",
        table["schedule_reports"],
        cases.join(",\n")
    )
}

#[test]
fn the_table_of_the_python_package_is_that_of_the_rule() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/map_verdicts.json");
    let table = table();
    let verdicts = ["current", "overtaken", "hold", "no_map"];
    let steps: Vec<&Value> =
        table["cases"].as_object().unwrap().values().flat_map(|case| case.as_array().unwrap()).collect();
    for verdict in verdicts {
        assert!(steps.iter().filter(|step| step[2] == verdict).count() > 20, "too few cases say {verdict}");
    }
    if std::env::var_os("UPDATE_GOLDEN").is_some() {
        std::fs::write(&path, text(&table)).unwrap();
    }
    let written: Value = serde_json::from_str(&std::fs::read_to_string(&path).unwrap()).unwrap();
    assert!(written == table, "map_verdicts.json is not what the rule says: UPDATE_GOLDEN=1 writes it");
}

#[test]
fn the_limits_of_the_python_package_are_those_of_the_rule() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../python/src/groundplan/_map_limits.py");
    if std::env::var_os("UPDATE_GOLDEN").is_some() {
        std::fs::write(&path, limits()).unwrap();
    }
    assert_eq!(std::fs::read_to_string(path).unwrap(), limits(), "UPDATE_GOLDEN=1 writes it");
}
