//! Ranks of links, and their effects.

mod support;

use messages::{DiagnosticCode, LinkKind, link_flags};
use schedule_files::PlanTask;
use support::{Building, plan, row, rules, task, task_with};
use tasks::{Effect, LinkError, LinkOrigin, LinkRules, ScheduleFile};

fn walls(names: &[&str]) -> Building {
    let mut building = Building::new();
    for name in names {
        building.wall(name);
    }
    building
}

#[test]
fn the_table_ranks_before_the_rules_and_these_in_their_order() {
    let building = walls(&["a", "b", "c"]);
    let plans = [plan("p.csv", vec![task("1"), task("2"), task("3")])];
    let rules = rules(
        "[[link]]\nname = \"first\"\ntask = { code = \"1\" }\nelements = { name = \"b\" }\n\
         [[link]]\ntask = { code = \"2\" }\nelements = { name = \"*\" }",
    );
    let table = [row(2, "a", "3", Effect::Removes), row(3, "a", "1", Effect::Builds)];
    assert_eq!(building.linked(&plans, &rules, &table), ["1 builds a", "1 builds b", "2 builds c", "3 removes a"]);
    let origins: Vec<LinkOrigin> = building.link(&plans, &rules, &table).links.iter().map(|link| link.origin).collect();
    assert_eq!(origins, [LinkOrigin::Table(3), LinkOrigin::Rule(0), LinkOrigin::Rule(1), LinkOrigin::Table(2)]);
    assert_eq!(building.linked(&plans, &rules, &[]), ["1 builds b", "2 builds a", "2 builds c"]);
}

#[test]
fn the_usual_rules_prefer_a_field_of_the_number_to_the_row() {
    let mut building = walls(&["a", "b", "c"]);
    building.properties(0, &[["Construction", "4D_Number", "2"]]);
    building.properties(1, &[["Data", "Activity ID", "1"]]);
    let tasks = vec![
        task("1"),
        task_with("2", "4D_Number", "7"),
        task_with("3", "4D_Number", "2"),
        task_with("4", "GlobalId", "c"),
    ];
    let lines = building.linked(&[plan("p.xml", tasks)], &LinkRules::default(), &[]);
    assert_eq!(lines, ["1 builds b", "3 builds a", "4 builds c"]);
}

#[test]
fn effects_are_fixed_or_told_by_words_of_the_task() {
    let building = walls(&["a"]);
    let tasks = ["Construction", "Demolition", "Inspection", "Temporary works", "Paperwork", ""];
    let tasks = (1..).zip(tasks).map(|(k, kind)| task_with(&k.to_string(), "Kind", kind)).collect();
    let plans = [plan("p.csv", tasks)];
    let told = rules("[[link]]\nname = \"all\"\nelements = { name = \"a\" }\neffect = \"=field:Kind\"");
    let expected = ["1 builds a", "2 removes a", "3 works_in a", "4 uses a", "5 works_in a", "6 works_in a"];
    assert_eq!(building.linked(&plans, &told, &[]), expected);
    assert_eq!(building.link(&plans, &told, &[]).untold_effects, [(4, 0), (5, 0)]);
    building.with_tasks(&plans, &told, |site, tasks| {
        let flags: Vec<u32> = site.schedule.task_links.iter().map(|link| link.flags).collect();
        use link_flags::{BUILDS, REMOVES, USES, WORKS_IN};
        assert_eq!(flags, [BUILDS, REMOVES, WORKS_IN, USES, WORKS_IN, WORKS_IN]);
        assert!(tasks.schedule().link_rules.iter().all(|rule| tasks.schedule().text(*rule) == "all"));
    });
    for effect in Effect::ALL {
        let fixed = rules(&format!("[[link]]\nelements = {{ name = \"a\" }}\neffect = \"{}\"", effect.name()));
        let lines = building.linked(&plans, &fixed, &[]);
        assert!(lines.len() == 6 && lines.iter().all(|line| line.contains(effect.name())), "{lines:?}");
    }
    let own = rules(
        "[[link]]\nelements = { name = \"a\" }\neffect = \"=field:Kind\"\n[link_words]\nbuilds = [\"paper*\"]\nremoves = []",
    );
    assert_eq!(building.linked(&plans, &own, &[])[4], "5 builds a");
    assert_eq!(building.linked(&plans, &own, &[])[1], "2 works_in a", "no word of removal is left");
}

#[test]
fn tasks_that_are_switched_off_work_on_nothing_and_have_no_dates() {
    let building = walls(&["a"]);
    let off = PlanTask { is_inactive: true, duration: Some(length(3600)), ..task("1") };
    let plans = [plan("p.xml", vec![off, task("2")])];
    let rules = rules("[[link]]\nelements = { name = \"a\" }");
    assert_eq!(building.linked(&plans, &rules, &[]), ["2 builds a"]);
    let by_table = building.link(&plans, &LinkRules::default(), &[row(2, "a", "1", Effect::Builds)]);
    assert!(by_table.links.is_empty() && by_table.unmatched_rows.len() == 1);
    building.with_tasks(&plans, &rules, |site, _| {
        assert!(site.schedule.duration(0).is_none());
        assert_eq!(site.schedule.tasks[0].flags, 0);
    });
}

#[test]
fn equal_codes_of_several_files_are_tasks_of_their_own() {
    let mut building = walls(&["a", "b"]);
    building.properties(0, &[["Construction", "4D_Number", "A10"]]);
    let plans = [plan("one.csv", vec![task("A10")]), plan("two.csv", vec![task("A10"), task("A20")])];
    assert_eq!(building.linked(&plans, &LinkRules::default(), &[]), ["A10 builds a", "A10 builds a"]);
    let rows =
        [row(2, "b", "A10", Effect::Builds), row(3, "b", "A20", Effect::Builds), row(4, "z", "A20", Effect::Builds)];
    let links = building.link(&plans, &LinkRules { rules: Vec::new(), ..LinkRules::default() }, &rows);
    let lines: Vec<u64> = links.unmatched_rows.iter().map(|(line, _)| *line).collect();
    assert_eq!((links.links.len(), lines), (1, vec![2, 4]));
    assert!(links.unmatched_rows[0].1.contains("2 tasks are called \"A10\""));
    building.with_tasks(&plans, &LinkRules::default(), |site, tasks| {
        let ids: Vec<&str> = site.schedule.tasks.iter().map(|task| site.schedule.text(task.global_id)).collect();
        assert_eq!(ids, ["A10", "A10#A10", "A20"]);
        assert_eq!(site.schedule.tasks.iter().map(|task| task.source).collect::<Vec<_>>(), [0, 1, 1]);
        let linked: Vec<(u32, LinkKind)> =
            tasks.schedule().task_links.iter().map(|link| (link.task, link.kind.get())).collect();
        assert_eq!(linked, [(0, LinkKind::Element), (1, LinkKind::Element)]);
    });
}

#[test]
fn a_schedule_that_links_with_nothing_is_an_error_of_the_report() {
    let building = walls(&["a"]);
    let codes = |plans: &[ScheduleFile], rules: &LinkRules| {
        let bytes = building.builder.finish();
        let site = messages::Site::open(bytes.bytes()).unwrap();
        let links = building.link(plans, rules, &[]);
        let builder = tasks::tasks_of(&site, plans, rules, &links);
        builder.diagnostics.iter().map(|diagnostic| diagnostic.code.get()).collect::<Vec<DiagnosticCode>>()
    };
    let plans = [plan("p.csv", vec![task("1"), task("2")])];
    assert_eq!(codes(&plans, &LinkRules::default()), [DiagnosticCode::TasksWithoutLinks]);
    let one = rules("[[link]]\ntask = { code = \"1\" }\nelements = { name = \"a\" }");
    assert_eq!(codes(&plans, &one), [DiagnosticCode::TasksWithoutLinks]);
    assert_eq!(codes(&[plan("p.csv", vec![task("1")])], &one), []);
}

#[test]
fn tasks_of_one_storey_find_their_elements_by_a_second_value() {
    const N: usize = 100_000;
    let mut building = Building::new();
    let storey = building.storey("EG");
    for k in 0..N {
        building.element("IfcWall", &format!("wall-{k}"), [storey, messages::NONE], [0.0, 0.0]);
    }
    let tasks = (0..N).map(|k| PlanTask { wbs: format!("wall-{k}"), ..task_with(&k.to_string(), "Level", "EG") });
    let rules = rules("[[link]]\nelements = { storey = \"=field:Level\", name = \"=wbs\" }");
    let links = building.link(&[plan("p.xer", tasks.collect())], &rules, &[]).links;
    assert_eq!(links.len(), N);
    assert!(links.iter().all(|link| link.target == tasks::Target::Element(link.task as u32)));
}

#[test]
fn a_hundred_thousand_tasks_find_a_hundred_thousand_elements() {
    const N: usize = 100_000;
    let mut building = Building::new();
    for k in 0..N {
        let wall = building.wall(&format!("wall-{k}"));
        building.properties(wall, &[["Construction", "4D_Number", &format!("A{k}")]]);
    }
    let plans = [plan("p.xer", (0..N).rev().map(|k| task(&format!("A{k}"))).collect())];
    let links = building.link(&plans, &LinkRules::default(), &[]).links;
    assert_eq!(links.len(), N);
    assert!(links.iter().all(|link| link.target == tasks::Target::Element((N - 1 - link.task) as u32)));
    let bytes = building.builder.finish();
    let all = rules("[[link]]\nname = \"everything\"\nelements = { name = \"*\" }");
    let refused = tasks::link(&messages::Site::open(bytes.bytes()).unwrap(), &plans, &all, &[]).unwrap_err();
    assert_eq!(refused, LinkError::TooMany { origin: "everything".to_owned() });
}

fn length(seconds: i64) -> schedule_files::Length {
    schedule_files::Length { seconds, is_elapsed: false }
}
