//! Selectors of rules, one by one.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

mod support;

use messages::NONE;
use schedule_files::PlanTask;
use support::{Building, plan, rules, task, task_with};

/// Two storeys with a room each; elements in both, and a duct in neither.
fn house() -> Building {
    let mut house = Building::new();
    let (ground, upper) = (house.storey("EG"), house.storey("1. OG"));
    let (kitchen, bath) = (house.space("Kitchen", ground), house.space("Bath", upper));
    house.space_properties(kitchen, &[["IfcZone", "Name", "BA1"]]);
    house.builder.spaces[kitchen as usize].centroid_m = [2.0, 2.0];
    house.builder.spaces[bath as usize].centroid_m = [f64::NAN, 0.0];
    let wall = house.element("IfcWall", "wall", [ground, NONE], [1.0, 1.0]);
    house.properties(
        wall,
        &[["Planning", "4D_Number", "A10; A20"], ["IfcZone", "Name", "BA2"], ["DIN 276", "Cost", "x"]],
    );
    let sink = house.element("IfcSanitaryTerminal", "sink", [NONE, kitchen], [3.0, 1.0]);
    house.properties(sink, &[["IfcClassification", "DIN 276", "412"], ["Other", "4D_Number", "a30 "]]);
    let duct = house.element("IfcDuctSegment", "duct", [NONE, NONE], [9.0, 9.0]);
    house.properties(duct, &[["IfcSystem", "Name", "Lüftung"]]);
    let door = house.element("IfcDoor", "door", [upper, NONE], [3.0, 3.0]);
    house.number(door, ["Planning", "Step"], 40.0);
    house
}

/// GlobalIds of what one task is linked with by a rule.
fn taken(elements: &str, task: PlanTask) -> Vec<String> {
    let rules = rules(&format!("[[link]]\nelements = {{ {elements} }}"));
    let lines = house().linked(&[plan("p.xer", vec![task])], &rules, &[]);
    lines.iter().map(|line| line.rsplit(' ').next().unwrap().to_owned()).collect()
}

#[test]
fn patterns_take_elements_and_spaces_by_what_they_are_and_where() {
    for (elements, expected) in [
        ("global_id = \"sink\"", vec!["sink"]),
        ("name = \"D*\"", vec!["duct", "door"]),
        ("class = \"IfcWall\"", vec!["wall"]),
        ("class = \"IfcElement\"", vec!["wall", "sink", "duct", "door"]),
        ("class = \"IfcSpace\"", vec!["Kitchen", "Bath"]),
        // What is in a room is on its storey.
        ("storey = \"eg\"", vec!["wall", "sink", "Kitchen"]),
        ("storey = \"? OG\"", vec![]),
        ("storey = \"?. OG\"", vec!["door", "Bath"]),
        ("space = \"kitchen\"", vec!["sink", "Kitchen"]),
        // A zone of a room is that of what is in it.
        ("zone = \"BA1\"", vec!["sink", "Kitchen"]),
        ("zone = \"BA*\"", vec!["wall", "sink", "Kitchen"]),
        ("group = \"lüft*\"", vec!["duct"]),
        ("classification = \"41?\"", vec!["sink"]),
        ("property = \"4D_Number\", value = \"A20\"", vec!["wall"]),
        ("property = \"4D_*\", value = \"A?0\"", vec!["wall", "sink"]),
        ("property = \"Planning.4D_Number\", value = \"*\"", vec!["wall"]),
        ("property = \"Plan*.Step\", value = \"40\"", vec!["door"]),
        ("box_m = [0, 0, 4, 2]", vec!["wall", "sink"]),
        ("polygon_m = [[0, 0], [4, 4], [0, 4]]", vec![]),
        ("polygon_m = [[0, 0], [4, 0], [4, 2.5], [0, 2.5]]", vec!["wall", "sink", "Kitchen"]),
        // All that is given has to fit.
        ("storey = \"EG\", zone = \"BA2\"", vec!["wall"]),
        ("storey = \"EG\", box_m = [2, 0, 4, 4]", vec!["sink", "Kitchen"]),
        ("name = \"nothing\"", vec![]),
    ] {
        assert_eq!(taken(elements, task("A10")), expected, "{elements}");
    }
}

#[test]
fn values_of_the_task_take_what_has_the_same() {
    for (elements, task, expected) in [
        ("property = \"4D_Number\", value = \"=code\"", task("A20"), vec!["wall"]),
        ("property = \"4D_Number\", value = \"=code\"", task("A30"), vec!["sink"]),
        ("property = \"4D_Number\", value = \"=id\"", task("A10"), vec!["wall"]),
        ("property = \"4D_Number\", value = \"=code\"", task("A1"), vec![]),
        ("property = \"4D_Number\", value = \"=code\"", task(""), vec![]),
        ("property = \"Step\", value = \"=code\"", task("40"), vec!["door"]),
        ("global_id = \"=field:GlobalId\"", task_with("1", "globalid", "duct, sink"), vec!["sink", "duct"]),
        ("storey = \"=field:Level\"", task_with("1", "Level", "1. og"), vec!["door", "Bath"]),
        ("space = \"=name\"", PlanTask { name: "bath".into(), ..task("1") }, vec!["Bath"]),
        ("zone = \"=wbs\"", PlanTask { wbs: "BA1".into(), ..task("1") }, vec!["sink", "Kitchen"]),
        ("storey = \"=field:Level\", class = \"IfcWall\"", task_with("1", "Level", "EG"), vec!["wall"]),
        (
            "storey = \"=field:Level\", zone = \"=wbs\"",
            PlanTask { wbs: "BA2".into(), ..task_with("1", "Level", "EG") },
            vec!["wall"],
        ),
    ] {
        assert_eq!(taken(elements, task), expected, "{elements}");
    }
}

#[test]
fn tasks_are_taken_by_file_id_code_wbs_name_and_field() {
    let plans = [
        plan(
            "rough.xer",
            vec![PlanTask { wbs: "P.1.2".into(), ..task("A10") }, task_with("A20", "Trade", "Dry lining")],
        ),
        plan("fit-out.xml", vec![PlanTask { uid: "7".into(), ..task("B10") }]),
    ];
    for (selector, expected) in [
        ("{}", vec!["A10", "A20", "B10"]),
        ("{ file = \"*.XER\" }", vec!["A10", "A20"]),
        ("{ id = \"7\" }", vec!["B10"]),
        ("{ code = \"?10\" }", vec!["A10", "B10"]),
        ("{ wbs = \"p.1*\" }", vec!["A10"]),
        ("{ name = \"task b*\" }", vec!["B10"]),
        ("{ field = \"TRADE\", value = \"dry*\" }", vec!["A20"]),
        ("{ code = \"?10\", file = \"rough*\" }", vec!["A10"]),
    ] {
        let rules = rules(&format!("[[link]]\ntask = {selector}\nelements = {{ name = \"duct\" }}"));
        let lines = house().linked(&plans, &rules, &[]);
        let codes: Vec<&str> = lines.iter().map(|line| line.split(' ').next().unwrap()).collect();
        assert_eq!(codes, expected, "{selector}");
    }
}
