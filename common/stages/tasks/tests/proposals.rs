//! Rules that are proposed for conventions of planners, and none where there is none.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

mod support;

use messages::{NONE, Site};
use schedule_files::{PlanTask, PlanTaskKind};
use support::{Building, plan, rules, task, task_with};
use tasks::{EffectWords, LinkRules, Proposals, ScheduleFile, WhyNot, propose};

/// Proposals whose counts are those of the links that the rules of their TOML make.
fn proposed(building: &Building, tasks: Vec<PlanTask>) -> (Proposals, Vec<ScheduleFile>) {
    let plans = vec![plan("plan.csv", tasks)];
    let bytes = building.builder.finish();
    let found = propose(&Site::open(bytes.bytes()).unwrap(), &plans, &EffectWords::default());
    for proposal in &found.proposals {
        let read = rules(&proposal.toml);
        assert_eq!(read.rules[0].effect, proposal.rule.effect, "{}", proposal.toml);
        assert_eq!(building.link(&plans, &read, &[]).links.len(), proposal.n_links, "{}", proposal.toml);
    }
    let all: String = found.proposals.iter().map(|proposal| proposal.toml.as_str()).collect();
    if !all.is_empty() {
        assert_eq!(building.link(&plans, &rules(&all), &[]).links.len(), found.n_links);
    }
    (found, plans)
}

fn equalities(found: &Proposals) -> Vec<&str> {
    found.proposals.iter().map(|proposal| proposal.what.as_str()).collect()
}

/// So many walls, with the properties of each.
fn walls(n: usize, properties: impl Fn(usize) -> Vec<[String; 3]>) -> Building {
    let mut building = Building::new();
    for k in 0..n {
        let wall = building.wall(&format!("3vQ{k:03}xYz${k}"));
        let properties = properties(k);
        let texts: Vec<[&str; 3]> = properties.iter().map(|p| [p[0].as_str(), p[1].as_str(), p[2].as_str()]).collect();
        building.properties(wall, &texts);
    }
    building
}

fn property(name: &str, value: String) -> [String; 3] {
    ["Pset".to_owned(), name.to_owned(), value]
}

fn codes(n: usize) -> Vec<PlanTask> {
    (0..n).map(|k| task(&format!("A{}", 1000 + 10 * k))).collect()
}

#[test]
fn a_property_with_the_code_is_proposed_with_what_stays_unlinked() {
    // Two walls for each task, and walls of a task that does not exist.
    let building = walls(60, |k| {
        vec![
            property("Takt no. \"4D\"", format!(" a{} ", 1000 + 10 * (k % 30))),
            property("Width", (200 + k % 3).to_string()),
        ]
    });
    let mut tasks = codes(32);
    tasks[31].kind = PlanTaskKind::Milestone;
    let (found, _) = proposed(&building, tasks);
    assert_eq!(equalities(&found), ["property \"Takt no. \\\"4D\\\"\" of elements is code of tasks"]);
    let best = &found.proposals[0];
    assert_eq!((best.n_links, best.n_tasks, best.n_targets, best.n_with_value), (60, [30, 30], 60, [60, 60]));
    assert_eq!((best.unlinked_work.as_slice(), found.n_work, best.n_shared), (&[30][..], 31, 30));
    assert_eq!((best.examples[0].text.as_str(), best.examples[0].n_tasks, best.examples[0].n_targets), ("a1000", 1, 2));
    assert!(best.bits > found.needed_bits);
}

#[test]
fn lists_global_ids_and_names_are_proposed() {
    let building = walls(40, |k| vec![property("Activities", format!("A{}; A{}", 1000 + 10 * k, 1010 + 10 * k))]);
    let (found, _) = proposed(&building, codes(41));
    assert_eq!(equalities(&found), ["property \"Activities\" of elements is code of tasks"]);
    assert_eq!(found.proposals[0].n_links, 80);
    let ids = |k: usize| format!("3vQ{:03}xYz${}; 3vQ{:03}xYz${}", 2 * k, 2 * k, 2 * k + 1, 2 * k + 1);
    let tasks = (0..10).map(|k| task_with(&format!("A{k}"), "BIM ids", &ids(k))).collect();
    let (found, _) = proposed(&walls(200, |_| Vec::new()), tasks);
    // Names of these walls are their GlobalIds.
    assert_eq!(equalities(&found), ["global id of elements is field \"BIM ids\" of tasks"]);
    assert_eq!((found.proposals[0].n_links, found.proposals[0].n_targets), (20, 20));
    assert!(found.not_proposed.iter().any(|not| not.why == WhyNot::Covered && not.what.starts_with("name of")));
}

#[test]
fn zone_and_trade_are_proposed_together_where_each_alone_is_ambiguous() {
    let mut building = Building::new();
    for k in 0..120 {
        let wall = building.element("IfcWall", &format!("e{k}"), [NONE, NONE], [0.0, 0.0]);
        let (zone, trade) = (
            format!("Bauabschnitt {}", ["Nord", "Ost", "Süd", "West"][k % 4]),
            ["Rohbau", "Ausbau", "Fassade", "Technik", "Estrich"][k / 4 % 5],
        );
        building.properties(wall, &[["IfcZone", "Name", &zone], ["Pset", "Gewerk", trade]]);
    }
    let tasks = (0..20).map(|k| {
        let mut task = task_with(
            &format!("T-{}", 7 * k),
            "Zone",
            &format!("Bauabschnitt {}", ["Nord", "Ost", "Süd", "West"][k % 4]),
        );
        task.fields.push(("Trade".to_owned(), ["Rohbau", "Ausbau", "Fassade", "Technik", "Estrich"][k / 4].to_owned()));
        task
    });
    let (found, _) = proposed(&building, tasks.collect());
    let expected =
        "zone of elements is field \"Zone\" of tasks, and property \"Gewerk\" of elements is field \"Trade\" of tasks";
    let other =
        "property \"Gewerk\" of elements is field \"Trade\" of tasks, and zone of elements is field \"Zone\" of tasks";
    assert!([expected, other].contains(&equalities(&found)[0]), "{:?} {:?}", equalities(&found), found.not_proposed);
    assert_eq!((found.proposals[0].n_links, found.proposals[0].n_tasks), (120, [20, 20]));
    assert!(found.not_proposed.iter().any(|not| matches!(not.why, WhyNot::Ambiguous(_))));
}

#[test]
fn effects_are_those_that_a_field_tells() {
    let building = walls(30, |k| vec![property("Job", format!("J-{}", 100 + 7 * k))]);
    let mut tasks: Vec<PlanTask> =
        (0..30).map(|k| task_with(&format!("J-{}", 100 + 7 * k), "Type", "Construction")).collect();
    tasks[3].fields[0].1 = "Demolition".to_owned();
    let (found, _) = proposed(&building, tasks.clone());
    assert!(found.proposals[0].toml.ends_with("effect = \"=field:Type\"\n"), "{}", found.proposals[0].toml);
    tasks.iter_mut().for_each(|task| task.fields.clear());
    tasks[3].name = "Demolition of the shed".to_owned();
    let (found, _) = proposed(&building, tasks);
    assert_eq!((found.proposals[0].n_other_effects, found.proposals[0].toml.contains("effect")), (1, false));
}

#[test]
fn numbers_that_are_equal_by_chance_are_not_proposed() {
    // Rows of a schedule, doors by number, round measures beside round codes, storeys that everything has.
    let properties = |k: usize| {
        vec![
            property("Mark", (k + 1).to_string()),
            property("Height", (1000 + 50 * (k % 30)).to_string()),
            property("Ratio", format!("{}.{}", 1 + k % 5, k % 9)),
            property("Fire", ["F30", "F60", "F90"][k % 3].to_owned()),
        ]
    };
    let mut tasks: Vec<PlanTask> = (1..=150).map(|k| task(&k.to_string())).collect();
    for (k, task) in tasks.iter_mut().enumerate() {
        task.uid = (1000 + 10 * k).to_string();
        task.wbs = format!("{}.{}", 1 + k / 9, k % 9);
        task.name = format!("Vorgang {}", ["Schalen", "Bewehren", "Betonieren"][k % 3]);
    }
    let (found, _) = proposed(&walls(100, properties), tasks);
    assert_eq!(equalities(&found), [""; 0]);
    let chance = found.not_proposed.iter().filter(|not| matches!(not.why, WhyNot::Coincidence(_))).count();
    assert!(chance >= 3, "{:?}", found.not_proposed);
}

#[test]
fn values_that_are_near_are_told_and_not_proposed() {
    let building = walls(30, |k| vec![property("Activity", format!("A-{}.3", 1000 + 10 * k))]);
    let tasks = (0..30).map(|k| task(&format!("A-{}", 1000 + 10 * k))).collect();
    let (found, _) = proposed(&building, tasks);
    assert!(found.proposals.is_empty());
    let near = found.not_proposed.iter().find(|not| not.what.contains("Activity")).unwrap();
    assert_eq!(near.why, WhyNot::Near(30));
}

#[test]
fn a_property_whose_name_has_a_point_is_found_again() {
    let building = walls(30, |k| vec![property("Plan.4D no.", format!("A{}", 1000 + 10 * k))]);
    let (found, plans) = proposed(&building, codes(30));
    assert_eq!(found.proposals[0].n_links, 30);
    assert!(found.proposals[0].toml.contains("\"*.Plan.4D no.\""));
    let none = LinkRules { rules: Vec::new(), words: EffectWords::default() };
    assert!(building.link(&plans, &none, &[]).links.is_empty());
}

#[test]
fn large_sites_and_schedules_are_compared() {
    let building = walls(20_000, |k| {
        vec![
            property("Activity", format!("A{}", 10_000 + 7 * (k % 2000))),
            property("Mark", k.to_string()),
            property("Room", format!("R{}", k % 300)),
        ]
    });
    let tasks = (0..2000).map(|k| task(&format!("A{}", 10_000 + 7 * k))).collect();
    let (found, _) = proposed(&building, tasks);
    assert_eq!(found.proposals[0].n_links, 20_000);
}
