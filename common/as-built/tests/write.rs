//! Observations written into small models of each schema: what changes, what stays, and what is refused.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

use as_built::{
    AdditionalElement, AsBuilt, ElementFinding, ElementObservation, FileEntry, LineChangeKind, Observations,
    Provenance, TaskObservation, write,
};
use frames::PlanTime;
use proptest::prelude::*;

const WALL: &str = "1walwalwalwalwalwalwal";
const OTHER: &str = "1othothothothothothoth";
const OPENING: &str = "1opeopeopeopeopeopeope";
const DOOR: &str = "1doodoodoodoodoodoodoo";
const STOREY: &str = "1stostostostostostosto";
const TASK: &str = "1tastastastastastastas";

/// A wall with an opening and a door, another wall, a storey turned by 90 degrees, a task without a time: in millimetres.
fn model(schema: &str) -> String {
    let history = if schema == "IFC2X3" { "#2" } else { "$" };
    let task = match schema {
        "IFC2X3" => format!("#60=IFCTASK('{TASK}',{history},'Walls',$,$,'1',$,$,.F.,$);"),
        _ => format!(
            "#60=IFCTASK('{TASK}',{history},'Walls',$,$,'1',$,$,$,.F.,$,#61,$);\n#61=IFCTASKTIME($,$,$,.WORKTIME.,'P5D','2024-03-04T08:00:00',$,$,$,$,$,$,$,$,$,$,$,$,$,$);"
        ),
    };
    let door = if schema == "IFC2X3" { "" } else { ",$,$,$" };
    format!(
        "ISO-10303-21;
HEADER;
FILE_DESCRIPTION((''),'2;1');
FILE_NAME('m.ifc','2024-01-01T00:00:00',(''),(''),'','','');
FILE_SCHEMA(('{schema}'));
ENDSEC;
DATA;
#2=IFCOWNERHISTORY(#3,#6,$,.ADDED.,$,$,$,1700000000);
#3=IFCPERSONANDORGANIZATION(#4,#5,$);
#4=IFCPERSON($,'Someone',$,$,$,$,$,$);
#5=IFCORGANIZATION($,'Somewhere',$,$,$);
#6=IFCAPPLICATION(#5,'1','Editor','editor');
#8=IFCPROJECT('1propropropropropropro',{history},'P',$,$,$,$,(#12),#9);
#9=IFCUNITASSIGNMENT((#10));
#10=IFCSIUNIT(*,.LENGTHUNIT.,.MILLI.,.METRE.);
#12=IFCGEOMETRICREPRESENTATIONCONTEXT($,'Model',3,1.E-05,#13,$);
#13=IFCAXIS2PLACEMENT3D(#14,$,$);
#14=IFCCARTESIANPOINT((0.,0.,0.));
/* the storey is turned */
#20=IFCBUILDINGSTOREY('{STOREY}',{history},'Ground',$,$,#21,$,$,.ELEMENT.,0.);
#21=IFCLOCALPLACEMENT($,#22);
#22=IFCAXIS2PLACEMENT3D(#14,#23,#24);
#23=IFCDIRECTION((0.,0.,1.));
#24=IFCDIRECTION((0.,1.,0.));
#30=IFCWALL('{WALL}',{history},'W; ''1''',$,$,#31,$,$);
#31=IFCLOCALPLACEMENT(#21,#32);
#32=IFCAXIS2PLACEMENT3D(#33,$,$);
#33=IFCCARTESIANPOINT((1000.,2000.,0.));
#40=IFCOPENINGELEMENT('{OPENING}',{history},$,$,$,#41,$,$);
#41=IFCLOCALPLACEMENT(#31,#13);
#42=IFCRELVOIDSELEMENT('1voivoivoivoivoivoivoi',{history},$,$,#30,#40);
#43=IFCDOOR('{DOOR}',{history},'D',$,$,#44,$,$,$,${door});
#44=IFCLOCALPLACEMENT(#21,#13);
#45=IFCRELFILLSELEMENT('1filfilfilfilfilfilfil',{history},$,$,#40,#43);
#50=IFCWALL('{OTHER}',{history},'O',$,$,#51,$,$);
#51=IFCLOCALPLACEMENT(#21,#13);
{task}
ENDSEC;
END-ISO-10303-21;
"
    )
}

fn at(text: &str) -> PlanTime {
    PlanTime::parse(text, None).unwrap().at
}

fn provenance() -> Provenance {
    Provenance {
        source: 0,
        row: "line 2".to_owned(),
        observer: "Kübra".to_owned(),
        at: Some(at("2024-03-07T17:00:00")),
    }
}

fn element(global_id: &str, what: ElementFinding) -> ElementObservation {
    ElementObservation { global_id: global_id.to_owned(), what, provenance: provenance() }
}

fn of(observations: Observations) -> Observations {
    let sources = vec![FileEntry { file: "t.csv".to_owned(), sha256: "e7".repeat(32) }];
    Observations { sources, ..observations }
}

fn written(model: &str, observations: &Observations) -> AsBuilt {
    write(model.as_bytes(), ["m.ifc", "n.ifc"], observations).unwrap()
}

/// Lines of the new file, by id.
fn line(written: &AsBuilt, id: u64) -> String {
    let text = String::from_utf8(written.bytes.clone()).unwrap();
    let start = format!("#{id}=");
    text.lines().find(|line| line.starts_with(&start)).unwrap().to_owned()
}

/// The one new line of an entity.
fn new(written: &AsBuilt, entity: &str) -> String {
    let of = written.changes.lines.iter().filter(|line| line.change == LineChangeKind::Added);
    let mut of = of.filter(|line| line.new.contains(&format!("={entity}(")));
    let found = of.next().unwrap_or_else(|| panic!("no {entity}")).new.clone();
    assert!(of.next().is_none(), "several {entity}");
    found
}

/// The old file with the changes of the list is the new one.
fn assert_listed(model: &str, written: &AsBuilt) {
    let mut text = model.to_owned();
    let mut added = String::new();
    for line in &written.changes.lines {
        match &line.old {
            Some(old) => {
                assert_eq!(text.matches(old.as_str()).count(), 1, "{old}");
                text = text.replace(old.as_str(), &line.new);
            }
            None => added = format!("{added}{}\n", line.new),
        }
        assert!(!line.observations.is_empty(), "{line:?}");
    }
    let end = text.rfind("ENDSEC;").unwrap();
    text.insert_str(end, &added);
    assert_eq!(text.as_bytes(), written.bytes);
}

fn progress_of_task() -> Observations {
    of(Observations {
        tasks: vec![TaskObservation {
            global_id: TASK.to_owned(),
            start: Some(at("2024-03-04T08:00:00")),
            finish: Some(at("2024-03-07T17:00:00")),
            completion: None,
            provenance: provenance(),
        }],
        ..Observations::default()
    })
}

#[test]
fn a_task_gets_its_dates_where_its_schema_has_them() {
    for schema in ["IFC4", "IFC4X3_ADD2"] {
        let model = model(schema);
        let found = written(&model, &progress_of_task());
        assert_eq!(
            line(&found, 61),
            "#61=IFCTASKTIME($,$,$,.WORKTIME.,'P5D','2024-03-04T08:00:00',$,$,$,$,$,$,$,$,'2024-03-07T17:00:00',$,\
             '2024-03-04T08:00:00','2024-03-07T17:00:00',$,1.);"
        );
        assert!(line(&found, 60).contains(",'1',$,'Completed',$,.F.,"), "{}", line(&found, 60));
        assert_listed(&model, &found);
    }
    let model = model("IFC2X3");
    let found = written(&model, &progress_of_task());
    let control = new(&found, "IFCSCHEDULETIMECONTROL");
    let ends: Vec<&str> = control.split(',').collect();
    let [start, finish, status, completion] = [5, 9, 19, 22].map(|k| ends[k]);
    assert!([start, finish, status].iter().all(|date| date.starts_with('#')) && completion == "1.);", "{control}");
    let day = found.changes.lines.iter().find(|line| line.new.contains("IFCCALENDARDATE(4,3,2024)"));
    assert!(day.is_some());
    assert!(new(&found, "IFCRELASSIGNSTASKS").contains("(#60),$,#"), "the task hangs on the schedule with its time");
    assert!(new(&found, "IFCWORKSCHEDULE").contains(".ACTUAL."));
    assert_listed(&model, &found);
}

#[test]
fn dates_that_are_not_known_stay() {
    let model = model("IFC4");
    let mut observations = progress_of_task();
    observations.tasks[0].finish = None;
    let found = written(&model, &observations);
    assert!(line(&found, 61).ends_with("'2024-03-04T08:00:00',$,$,$);"), "{}", line(&found, 61));
    assert!(line(&found, 60).contains("'Started'"));
}

#[test]
fn a_time_that_tasks_share_is_copied() {
    let model = model("IFC4").replace(
        "#61=IFCTASKTIME",
        "#62=IFCTASK('1secsecsecsecsecsecsec',$,'T',$,$,'2',$,$,$,.F.,$,#61,$);\n#61=IFCTASKTIME",
    );
    let found = written(&model, &progress_of_task());
    assert!(line(&found, 61).ends_with("$,$,$,$,$,$);"), "that of the other task stays");
    assert!(new(&found, "IFCTASKTIME").contains(".WORKTIME.,'P5D'"));
    assert!(!line(&found, 60).contains("#61"), "{}", line(&found, 60));
    assert_listed(&model, &found);
}

#[test]
fn elements_have_a_property_set_and_a_task_where_none_builds_them() {
    for schema in ["IFC2X3", "IFC4", "IFC4X3"] {
        let model = model(schema);
        let progress =
            ElementFinding::Progress { start: None, finish: Some(at("2024-03-07T17:00:00")), needs_task: true };
        let observations = of(Observations { elements: vec![element(WALL, progress)], ..Observations::default() });
        let found = written(&model, &observations);
        assert!(new(&found, "IFCPROPERTYSET").contains("'Groundplan_AsBuilt'"));
        assert!(new(&found, "IFCRELDEFINESBYPROPERTIES").contains("(#30)"));
        assert!(new(&found, "IFCRELASSIGNSTOPRODUCT").ends_with(",#30);"));
        assert!(new(&found, "IFCTASK").contains("'W; ''1'''"), "the name of the element");
        let text = String::from_utf8(found.bytes.clone()).unwrap();
        assert!(text.contains(r"IFCTEXT('K\X2\00FC\X0\bra')") && text.contains("IFCLABEL('built')"));
        assert_eq!(text.contains("IFCDATETIME('2024-03-07T17:00:00')"), schema != "IFC2X3");
        assert!(!text.contains(",$,'Groundplan"), "what is new has an owner history");
        assert_listed(&model, &found);
        // What is written is not written again.
        let again = written(&text, &observations);
        assert_eq!(String::from_utf8(again.bytes).unwrap(), text, "{schema}");
        // Another observation changes what is there.
        let later = ElementFinding::Progress { start: None, finish: Some(at("2024-03-08T17:00:00")), needs_task: true };
        let later = of(Observations { elements: vec![element(WALL, later)], ..Observations::default() });
        let later = written(&text, &later);
        assert!(later.changes.lines.iter().all(|line| !line.new.contains("=IFCTASK(") || line.old.is_some()));
        assert!(
            later.changes.lines.iter().all(|line| !line.new.contains("=IFCPROPERTYSINGLEVALUE(") || line.old.is_some())
        );
        assert_eq!(String::from_utf8(later.bytes).unwrap().matches("=IFCTASK(").count(), 2);
    }
}

#[test]
fn a_displaced_wall_moves_in_the_world_and_takes_opening_and_door_along() {
    for schema in ["IFC2X3", "IFC4"] {
        let model = model(schema);
        let displaced = ElementFinding::Displaced { by_m: [0.1, 0.0], deviation_m: 0.01 };
        let observations = of(Observations { elements: vec![element(WALL, displaced)], ..Observations::default() });
        let found = written(&model, &observations);
        // The storey is turned by 90 degrees: x of the world is -y of the storey.
        let points: Vec<&str> = found
            .changes
            .lines
            .iter()
            .filter(|line| line.new.contains("IFCCARTESIANPOINT"))
            .map(|line| line.new.split_once('(').unwrap().1)
            .collect();
        assert_eq!(
            points,
            ["(1000.,1900.,0.));", "(0.,-100.,0.));"],
            "the wall, and the door, which lies in the storey"
        );
        assert_eq!(line(&found, 41), "#41=IFCLOCALPLACEMENT(#31,#13);", "the opening follows the wall");
        assert!(line(&found, 31).starts_with("#31=IFCLOCALPLACEMENT(#21,#") && !line(&found, 31).contains("#32"));
        assert_eq!(line(&found, 51), "#51=IFCLOCALPLACEMENT(#21,#13);", "the other wall stays");
        let notes = &found.changes.observations[0].notes;
        assert!(notes[0].contains(OPENING) && notes[0].contains(DOOR) && !notes[0].contains(OTHER), "{notes:?}");
        assert!(!line(&found, 30).contains("#2,"), "a history of the change");
        assert_listed(&model, &found);
        // The same evidence moves nothing twice.
        let text = String::from_utf8(found.bytes.clone()).unwrap();
        let again = written(&text, &observations);
        assert_eq!((again.bytes, again.changes.not_written.len()), (found.bytes, 1));
    }
}

#[test]
fn what_was_moved_by_evidence_is_not_moved_by_it_again_after_other_evidence() {
    let displaced = ElementFinding::Displaced { by_m: [0.1, 0.0], deviation_m: 0.01 };
    let moved = of(Observations { elements: vec![element(WALL, displaced)], ..Observations::default() });
    let first = String::from_utf8(written(&model("IFC4"), &moved).bytes).unwrap();
    let progress = ElementFinding::Progress { start: None, finish: Some(at("2024-03-07T17:00:00")), needs_task: true };
    let report = Observations {
        sources: vec![FileEntry { file: "p.csv".to_owned(), sha256: "a1".repeat(32) }],
        elements: vec![element(WALL, progress)],
        ..Observations::default()
    };
    let second = String::from_utf8(written(&first, &report).bytes).unwrap();
    let third = written(&second, &moved);
    assert_eq!((String::from_utf8(third.bytes).unwrap(), third.changes.not_written.len()), (second, 1));
}

#[test]
fn dates_of_an_earlier_run_that_hold_no_more_leave_the_set() {
    let progress = |finish: Option<&str>| {
        let (start, finish) = (Some(at("2024-03-01")), finish.map(at));
        let finding = ElementFinding::Progress { start, finish, needs_task: false };
        of(Observations { elements: vec![element(WALL, finding)], ..Observations::default() })
    };
    let built = String::from_utf8(written(&model("IFC4"), &progress(Some("2024-03-05"))).bytes).unwrap();
    let found = written(&built, &progress(None));
    let set = found.changes.lines.iter().find(|line| line.new.contains("=IFCPROPERTYSET(")).unwrap();
    let finish = built.lines().find(|line| line.contains("'ActualFinish'")).unwrap().split('=').next().unwrap();
    assert!(set.old.as_ref().unwrap().contains(finish) && !set.new.contains(finish), "{set:?}");
}

#[test]
fn elements_that_are_placed_relative_to_each_other_do_not_move_twice() {
    // The other wall is placed relative to this one, without a relation.
    let model = model("IFC4").replace("#51=IFCLOCALPLACEMENT(#21,", "#51=IFCLOCALPLACEMENT(#31,");
    let displaced = || ElementFinding::Displaced { by_m: [0.1, 0.0], deviation_m: 0.01 };
    for order in [[WALL, OTHER], [OTHER, WALL], [STOREY, WALL]] {
        let elements = order.map(|id| element(id, displaced())).to_vec();
        let found = written(&model, &of(Observations { elements, ..Observations::default() }));
        let [refused] = found.changes.not_written.as_slice() else { panic!("{:?}", found.changes.not_written) };
        assert!(refused.reason.contains("placed relative to"), "{refused:?}");
    }
}

#[test]
fn names_in_an_encoding_of_long_ago_are_written_with_escapes() {
    let mut bytes = model("IFC4").into_bytes();
    let name = bytes.windows(3).position(|three| three == b"'W;").unwrap() + 1;
    bytes[name] = 0xC4;
    let progress = ElementFinding::Progress { start: None, finish: Some(at("2024-03-07")), needs_task: true };
    let observations = of(Observations { elements: vec![element(WALL, progress)], ..Observations::default() });
    let found = write(&bytes, ["m.ifc", "n.ifc"], &observations).unwrap();
    let task = found.changes.lines.iter().find(|line| line.old.is_none() && line.new.contains("=IFCTASK(")).unwrap();
    assert!(task.new.contains(r"'\X2\00C4\X0\; "), "{task:?}");
    assert!(found.bytes.windows(3).any(|three| three == b"'\xC4;"), "the line of the element stays as it is");
}

#[test]
fn a_task_that_the_model_has_as_finished_is_not_begun_again() {
    let model = model("IFC4");
    let (planned, dates) = ("'2024-03-04T08:00:00',$,$,$,$,$,$,$,$,$,$,$,$,$,$)", "$,'2024-03-05','2024-03-09',$,1.)");
    let finished = model.replace(planned, &format!("'2024-03-04T08:00:00',$,$,$,$,$,$,$,$,$,{dates}"));
    assert_ne!(model, finished);
    let task = TaskObservation {
        global_id: TASK.to_owned(),
        start: Some(at("2024-03-05")),
        finish: None,
        completion: Some(0.5),
        provenance: provenance(),
    };
    let found = written(&finished, &of(Observations { tasks: vec![task], ..Observations::default() }));
    assert!(found.changes.not_written[0].reason.contains("actual finish"), "{:?}", found.changes.not_written);
}

#[test]
fn an_element_that_shares_its_placement_gets_its_own() {
    let model = model("IFC4").replace("'O',$,$,#51", "'O',$,$,#31");
    let displaced = ElementFinding::Displaced { by_m: [0.0, 0.05], deviation_m: 0.01 };
    let observations = of(Observations { elements: vec![element(WALL, displaced)], ..Observations::default() });
    let found = written(&model, &observations);
    assert_eq!(line(&found, 31), "#31=IFCLOCALPLACEMENT(#21,#32);", "the other wall stays");
    assert!(!line(&found, 30).contains("#31,"), "{}", line(&found, 30));
    assert!(line(&found, 41).starts_with("#41=IFCLOCALPLACEMENT(#31,#") && !line(&found, 41).contains("#13"));
    assert_listed(&model, &found);
}

#[test]
fn what_is_no_element_is_a_proxy_in_its_storey() {
    let square = vec![[0.0, 0.0], [0.5, 0.0], [0.5, 0.5], [0.0, 0.5]];
    let hole: Vec<[f64; 2]> = [[0.2, 0.2], [0.2, 0.3], [0.3, 0.3], [0.3, 0.2]].to_vec();
    for schema in ["IFC2X3", "IFC4X3"] {
        let model = model(schema);
        let additional = AdditionalElement {
            rings_m: vec![square.clone(), hole.clone()],
            bottom_z_m: 0.0,
            top_z_m: 0.3,
            storey: STOREY.to_owned(),
            provenance: Provenance { row: "obstacle 1".to_owned(), ..provenance() },
        };
        let observations = of(Observations { additional: vec![additional], ..Observations::default() });
        let found = written(&model, &observations);
        assert!(new(&found, "IFCARBITRARYPROFILEDEFWITHVOIDS").contains(".AREA."));
        assert!(new(&found, "IFCEXTRUDEDAREASOLID").ends_with(",300.);"));
        assert!(new(&found, "IFCRELCONTAINEDINSPATIALSTRUCTURE").ends_with(",#20);"));
        let kind = if schema == "IFC2X3" { ".ELEMENT.);" } else { ".NOTDEFINED.);" };
        assert!(new(&found, "IFCBUILDINGELEMENTPROXY").ends_with(kind));
        let corner = found.changes.lines.iter().any(|line| line.new.ends_with("IFCCARTESIANPOINT((0.,-500.));"));
        assert!(corner, "a corner at x 0.5 m of the world lies at y -0.5 m of the storey");
        assert!(found.changes.observations[0].notes[0].contains("0.3 m"));
        assert_listed(&model, &found);
        let text = String::from_utf8(found.bytes.clone()).unwrap();
        let again = written(&text, &observations);
        assert_eq!((again.bytes, again.changes.not_written.len()), (found.bytes, 1));
    }
}

#[test]
fn what_is_not_there_is_listed_with_the_reason() {
    let model = model("IFC4");
    let observations = of(Observations {
        elements: vec![
            element("1nonnonnonnonnonnonnon", ElementFinding::Absent),
            element(TASK, ElementFinding::Absent),
            element(WALL, ElementFinding::Displaced { by_m: [1.0, 0.0], deviation_m: 0.0 }),
            element(DOOR, ElementFinding::Displaced { by_m: [1.0, 0.0], deviation_m: 0.0 }),
        ],
        ..Observations::default()
    });
    let found = written(&model, &observations);
    let reasons: Vec<&str> = found.changes.not_written.iter().map(|one| one.reason.as_str()).collect();
    assert!(
        reasons.len() == 3 && reasons[0].contains("no element") && reasons[2].contains("moves along"),
        "{reasons:?}"
    );
}

#[test]
fn lines_end_as_those_of_the_file() {
    let model = model("IFC4").replace('\n', "\r\n");
    let found = written(
        &model,
        &of(Observations { elements: vec![element(WALL, ElementFinding::Absent)], ..Observations::default() }),
    );
    let text = String::from_utf8(found.bytes).unwrap();
    assert_eq!(text.matches('\n').count(), text.matches("\r\n").count());
    assert!(text.starts_with(&model[..model.rfind("ENDSEC").unwrap()]));
}

proptest! {
    #[test]
    fn no_bytes_make_it_panic(cut in 0usize..3000, at_byte in 0usize..3000, byte in any::<u8>()) {
        let mut bytes = model("IFC4").into_bytes();
        let at_byte = at_byte % bytes.len();
        bytes[at_byte] = byte;
        bytes.truncate(bytes.len().min(cut + 600));
        let mut observations = progress_of_task();
        observations.elements = vec![
            element(WALL, ElementFinding::Displaced { by_m: [0.1, 0.2], deviation_m: 0.01 }),
            element(OTHER, ElementFinding::Absent),
        ];
        let _ = write(&bytes, ["m", "n"], &observations);
    }
}
