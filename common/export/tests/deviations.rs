//! Files about differences between the model and a robot's map.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

use bcf::{BcfVersion, Container, Snapshot};
use bytemuck::Zeroable;
use export::{DeviationExport, ExportFile, deviation_files, deviation_files_after, deviation_files_in, progress_mspdi};
use frames::PlanTime;
use messages::*;
use quick_xml::events::Event;
use std::collections::BTreeMap;
use std::io::{Cursor, Read};
use std::path::Path;

const WALL: &str = "2O2Fr$t4X7Zf8NOew3FLOH";
const EARLY: &str = "0xScRe4drECQ4DMSqUjd6d";

/// Two walls, one displaced and one early, a door that was not observed, and an obstacle; all of it a quarter turn from
/// the world.
struct Storey {
    site: ArchiveBuffer,
    schedule_state: ArchiveBuffer,
    deviations: ArchiveBuffer,
}

fn storey(name: &str) -> Storey {
    let mut b = SiteBuilder::default();
    b.head.map_from_world_yaw_rad = std::f64::consts::FRAC_PI_2;
    b.head.map_from_world_m = [1.0, 2.0, 3.0];
    let texts =
        ["Ground <0>", WALL, EARLY, "wall & co.", "IfcWall", name, "house & garden.ifc"].map(|t| b.texts.add(t));
    b.sources.push(SourceRecord { file: texts[6], schema: texts[4], sha256: [1; 32], length_unit_m: 1.0 });
    b.map_storeys.push(MapStoreyRecord {
        name: texts[0],
        global_id: Text::default(),
        floor_z_tenths: 30_000,
        floor: FloorKind::Built.into(),
        bounds_tenths: [0, 0, 40_000, 30_000],
    });
    // Bodies of no triangles: only that there are some matters here.
    b.parts = vec![PartRecord::zeroed(); 3];
    for (index, id) in [texts[1], texts[2], texts[3]].into_iter().enumerate() {
        b.elements.push(ElementRecord {
            global_id: id,
            name: texts[5],
            ifc_type: texts[4],
            first_part: index as u32,
            n_parts: 1,
            min_tenths: [0, 10_000 * index as i32, 30_000],
            max_tenths: [20_000, 10_000 * index as i32 + 1_000, 55_000],
            class: grid::Class::Wall.into(),
            step_id: 42,
            whole: NONE,
            storey: NONE,
            space: NONE,
            door: NONE,
            stair: NONE,
            ..Zeroable::zeroed()
        });
    }
    let site = b.finish();
    let hash = Site::open(site.bytes()).unwrap().content_hash();
    let mut schedule_state = ScheduleStateBuilder::everything_built(hash, 3, 0);
    schedule_state.head.plan_time_s = 1_710_000_000;
    schedule_state.set_element(1, ElementState::NotStarted, ElementState::NotStarted);
    let head = DeviationsHead {
        site_hash: hash,
        plan_time_s: 1_710_000_000,
        slam_map_hash: ContentHash::from_bits(5),
        lidar_z_m: 3.3,
        cell_tenths: 1_000,
        width: 40,
        height: 30,
        ..Zeroable::zeroed()
    };
    Storey { site, schedule_state: schedule_state.finish(), deviations: seen(head) }
}

fn seen(head: DeviationsHead) -> ArchiveBuffer {
    let mut d = DeviationsBuilder::new(head);
    let record = |element: u32, observation: Observation, verdict: DeviationVerdict| ElementDeviationRecord {
        element,
        observation: observation.into(),
        verdict: verdict.into(),
        planned: ElementState::Built.into(),
        sample_m: 0.05,
        n_samples: 40,
        n_visible: 20,
        n_confirmed: 15,
        n_contradicted: 5,
        ..Zeroable::zeroed()
    };
    d.elements = vec![
        ElementDeviationRecord {
            offset_m: 0.3,
            displacement_m: [0.0, 0.3],
            ..record(0, Observation::Displaced, DeviationVerdict::Displaced)
        },
        ElementDeviationRecord {
            planned: ElementState::NotStarted.into(),
            ..record(1, Observation::Observed, DeviationVerdict::Early)
        },
        ElementDeviationRecord {
            reason: UnseenReason::NotSeen.into(),
            n_visible: 0,
            n_confirmed: 0,
            n_contradicted: 0,
            ..record(2, Observation::Unseen, DeviationVerdict::Unknown)
        },
    ];
    d.points = vec![[25_000, 5_000], [30_000, 5_000], [30_000, 10_000], [25_000, 10_000]];
    d.rings = vec![RingRecord { first_point: 0, n_points: 4 }];
    d.obstacles = vec![ObstacleRecord {
        area_m2: 0.25,
        length_m: 0.5,
        centroid_m: [2.75, 0.75],
        n_rings: 1,
        space: NONE,
        ..Zeroable::zeroed()
    }];
    d.seen = [SlamCell::Unknown, SlamCell::Free, SlamCell::Occupied].map(Tag::from).repeat(400);
    d.finish()
}

fn files(storey: &Storey) -> BTreeMap<String, Vec<u8>> {
    files_by(storey, deviation_files)
}

fn files_by(storey: &Storey, make: impl FnOnce(&DeviationExport<'_>) -> Vec<ExportFile>) -> BTreeMap<String, Vec<u8>> {
    let site = Site::open(storey.site.bytes()).unwrap();
    let deviations = Deviations::open(storey.deviations.bytes()).unwrap();
    let input = DeviationExport {
        site: &site,
        schedule_state: &ScheduleState::open(storey.schedule_state.bytes()).unwrap(),
        deviations: &deviations,
        created: PlanTime::from_civil_seconds(deviations.head.plan_time_s).unwrap(),
    };
    make(&input).into_iter().map(|ExportFile { path, bytes }| (path, bytes)).collect()
}

fn unpacked(bytes: &[u8]) -> BTreeMap<String, String> {
    let mut zip = zip::ZipArchive::new(Cursor::new(bytes)).unwrap();
    (0..zip.len())
        .filter_map(|k| {
            let mut file = zip.by_index(k).unwrap();
            let name = file.name().unwrap().into_owned();
            let mut bytes = Vec::new();
            file.read_to_end(&mut bytes).unwrap();
            // Pictures are no texts.
            if name.ends_with(".png") { None } else { Some((name, String::from_utf8(bytes).unwrap())) }
        })
        .collect()
}

/// Texts of all elements of this name, and values of all attributes of it.
fn values(xml: &str, name: &str) -> Vec<String> {
    let (mut found, mut inside) = (Vec::new(), false);
    let mut reader = quick_xml::Reader::from_str(xml);
    loop {
        match reader.read_event().unwrap() {
            Event::Eof => return found,
            Event::Start(e) | Event::Empty(e) => {
                inside = e.name().as_ref() == name;
                if inside {
                    found.push(String::new());
                }
                let attributes = e.attributes().map(Result::unwrap).filter(|a| a.key.as_ref() == name);
                found.extend(attributes.map(|a| a.value.into_owned()));
            }
            Event::Text(t) if inside => found.last_mut().unwrap().push_str(&t),
            Event::GeneralRef(r) if inside => {
                found.last_mut().unwrap().push_str(quick_xml::escape::resolve_xml_entity(&r).unwrap());
            }
            Event::End(_) => inside = false,
            _ => {}
        }
    }
}

#[test]
fn every_deviation_is_a_topic_with_its_component_and_nothing_else_is() {
    let files = files(&storey("north <wall> \"A\" & B\u{7}"));
    let topics = unpacked(&files["deviations.bcfzip"]);
    assert!(values(&topics["bcf.version"], "VersionId").contains(&"2.1".to_owned()));
    let markups: Vec<&String> =
        topics.iter().filter(|(path, _)| path.ends_with("/markup.bcf")).map(|(_, t)| t).collect();
    let views: Vec<&String> =
        topics.iter().filter(|(path, _)| path.ends_with("/viewpoint.bcfv")).map(|(_, t)| t).collect();
    assert_eq!((markups.len(), views.len(), topics.len()), (3, 3, 7));
    let mut components: Vec<String> = views.iter().flat_map(|v| values(v, "IfcGuid")).collect();
    components.sort();
    assert_eq!(components, [EARLY, WALL]);
    for markup in &markups {
        let guid = &values(markup, "Guid")[0];
        assert!(topics.contains_key(&format!("{guid}/viewpoint.bcfv")), "{guid}");
        assert_eq!(guid.as_bytes()[14], b'8', "a UUID that says it is made from other data");
        assert_eq!(values(markup, "CreationDate"), ["2024-03-09T16:00:00"]);
        assert_eq!(values(markup, "Filename"), ["house & garden.ifc"]);
    }
    let titles: Vec<String> = markups.iter().flat_map(|m| values(m, "Title")).collect();
    assert!(
        titles.contains(&"IfcWall north <wall> \"A\" & B\u{fffd} is built before it is planned".to_owned()),
        "{titles:?}"
    );
    let described: String = markups.iter().flat_map(|m| values(m, "Description")).collect();
    assert!(described.contains("Displaced by 300 mm: 0 mm along x, 300 mm along y"), "{described}");
}

#[test]
fn views_look_from_above_in_the_coordinates_of_the_files() {
    let topics = unpacked(&files(&storey("wall"))["deviations.bcfzip"]);
    let view = topics.values().find(|t| values(t, "IfcGuid").contains(&WALL.to_owned())).unwrap();
    // The middle of the wall is (1, 0.05) in the map, which is turned by a quarter and moved by (1, 2, 3).
    let number = |name: &str, k: usize| values(view, name)[k].parse::<f64>().unwrap();
    let eye = ["X", "Y", "Z"].map(|axis| number(axis, 0));
    assert!((eye[0] + 1.95).abs() < 1e-3 && eye[1].abs() < 1e-3 && (eye[2] - 20.3).abs() < 1e-3, "{eye:?}");
    assert_eq!(["X", "Y", "Z"].map(|axis| number(axis, 1)), [0.0, 0.0, -1.0]);
    assert_eq!(["X", "Y", "Z"].map(|axis| number(axis, 2)), [1.0, 0.0, 0.0]);
    let obstacle = topics.iter().find(|(path, t)| path.ends_with("bcfv") && values(t, "IfcGuid").is_empty()).unwrap();
    assert_eq!(values(obstacle.1, "Line").len(), 4);
}

#[test]
fn only_what_stands_early_is_reported_as_progress() {
    let files = files(&storey("wall"));
    let table = String::from_utf8(files["actuals.csv"].clone()).unwrap();
    assert_eq!(table, format!("id,start,finish\n{EARLY},,2024-03-09T16:00:00\n"));
}

/// The document is the one from which MPXJ reads the progress of these tasks: `scripts/check_progress.py` holds its reading against the
/// same values.
fn check_golden(text: &str, seen: &str) {
    let golden = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden/progress.xml");
    if std::env::var_os("UPDATE_GOLDEN").is_some() {
        std::fs::write(&golden, text).unwrap();
    }
    assert_eq!(text, std::fs::read_to_string(&golden).unwrap_or_default(), "UPDATE_GOLDEN=1 rewrites it");
    let read = std::fs::read(golden.with_extension("mpxj.json")).unwrap();
    let read: serde_json::Value = serde_json::from_slice(&read).unwrap();
    let minute = seen.strip_suffix(":00");
    let expected = serde_json::json!({
        "7": [100.0, minute, minute],
        "8": [50.0, "2024-03-01T07:00", null],
        "10": [null, null, null],
    });
    assert_eq!(read, expected);
}

/// A plan of four tasks: walls 0 and 1 built, walls 1 and 2 built, wall 0 removed, and one that works on nothing.
fn plan(site: &Site<'_>) -> ArchiveBuffer {
    let mut b = TasksBuilder::default();
    b.head = TasksHead { site_hash: site.content_hash(), n_elements: 3, ..b.head };
    let file = b.texts.add("plan.xml").into();
    b.sources.push(ScheduleSourceRecord { file, written_by: ScheduleText::default(), sha256: [2; 32] });
    let at_s = "2024-03-01T07:00:00".parse::<PlanTime>().unwrap().civil_seconds();
    let began = CivilDate { at_s, offset_s: Some(3_600), is_day: false };
    b.schedule.dates.push(ScheduleDateRecord::new(began, ScheduleDateKind::ActualStart, 1));
    for id in ["A1", "A2", "D1", "M1"] {
        let task = TaskRecord {
            global_id: b.texts.add(id).into(),
            name: b.texts.add("walls, inner").into(),
            parent: NONE,
            control: NONE,
            calendar: NONE,
            completion: -1.0,
            duration_kind: DurationKind::WorkTime.into(),
            ..Zeroable::zeroed()
        };
        b.schedule.tasks.push(task);
    }
    let (builds, removes) = (link_flags::BUILDS, link_flags::REMOVES);
    for (task, target, flags) in [(0, 0, builds), (0, 1, builds), (1, 1, builds), (1, 2, builds), (2, 0, removes)] {
        b.schedule.task_links.push(TaskLinkRecord { task, kind: LinkKind::Element.into(), target, flags });
        b.link_rules.push(file);
    }
    b.finish()
}

#[test]
fn progress_of_the_planners_tasks_is_what_was_seen_of_their_elements() {
    let storey = storey("wall");
    let site = Site::open(storey.site.bytes()).unwrap();
    let plan = plan(&site);
    let tasks = Tasks::open(plan.bytes()).unwrap();
    let site = site.with_tasks(&tasks).unwrap();
    let deviations = Deviations::open(storey.deviations.bytes()).unwrap();
    let input = DeviationExport {
        site: &site,
        schedule_state: &ScheduleState::open(storey.schedule_state.bytes()).unwrap(),
        deviations: &deviations,
        created: PlanTime::from_civil_seconds(deviations.head.plan_time_s).unwrap(),
    };
    let files = deviation_files(&input);
    let table = files.iter().find(|file| file.path == "progress.csv").unwrap();
    let table = String::from_utf8(table.bytes.clone()).unwrap();
    let lines: Vec<&str> = table.lines().skip(1).collect();
    let seen = "2024-03-09T16:00:00";
    assert_eq!(
        lines,
        [
            format!("A1,\"walls, inner\",plan.xml,100,2,2,0,{seen},seen,{seen},seen,{seen}"),
            format!("A2,\"walls, inner\",plan.xml,50,2,1,1,2024-03-01T07:00:00,plan,,,{seen}"),
            format!("D1,\"walls, inner\",plan.xml,0,1,0,0,,,,,{seen}"),
            format!("M1,\"walls, inner\",plan.xml,,0,0,0,,,,,{seen}"),
        ]
    );
    let xml = progress_mspdi(&input, &["7", "8", "wbs:9", "10"]);
    assert_eq!(xml.iter().map(|file| file.path.as_str()).collect::<Vec<_>>(), ["progress.xml"]);
    let text = String::from_utf8(xml[0].bytes.clone()).unwrap();
    assert_eq!(values(&text, "UID"), ["7", "8", "10"]);
    assert_eq!(values(&text, "PercentComplete"), ["100", "50"]);
    assert_eq!(values(&text, "ActualFinish"), [seen]);
    check_golden(&text, seen);
    assert!(progress_mspdi(&input, &[]).is_empty());
}

#[test]
fn the_document_tells_all_by_global_id() {
    let files = files(&storey("wall"));
    let document: serde_json::Value = serde_json::from_slice(&files["deviations.json"]).unwrap();
    let wall = &document["elements"][WALL];
    assert_eq!((wall["observation"].as_str(), wall["judgement"].as_str()), (Some("displaced"), Some("displaced")));
    assert_eq!(wall["displacement_m"], serde_json::json!([0.0, 0.3]));
    assert_eq!(document["elements"]["wall & co."]["reason"], "not_seen");
    assert_eq!(document["elements"]["wall & co."]["confirmed"], serde_json::Value::Null);
    assert_eq!(document["obstacles"][0]["judgement"], "not_in_the_model");
    assert_eq!(document["obstacles"][0]["polygon_m"][0].as_array().unwrap().len(), 4);
    assert_eq!(
        (document["judgements"]["early"].as_u64(), document["observations"]["absent"].as_u64()),
        (Some(1), Some(0))
    );
}

#[test]
fn the_same_archives_give_the_same_bytes_and_topics_keep_their_names() {
    assert_eq!(files(&storey("wall")), files(&storey("wall")));
    let names = |storey: &Storey| unpacked(&files(storey)["deviations.bcfzip"]).into_keys().collect::<Vec<_>>();
    assert_eq!(names(&storey("wall")), names(&storey("another name")));
}

/// A later look: the wall that was displaced is seen in place, or nothing is known of it.
fn later(name: &str, observation: Observation, verdict: DeviationVerdict) -> Storey {
    let before = storey(name);
    let found = Deviations::open(before.deviations.bytes()).unwrap();
    let mut d = DeviationsBuilder::new(DeviationsHead { slam_map_hash: ContentHash::from_bits(6), ..*found.head });
    d.elements = found.elements.to_vec();
    d.elements[0] = ElementDeviationRecord {
        observation: observation.into(),
        verdict: verdict.into(),
        displacement_m: [0.0; 2],
        ..d.elements[0]
    };
    (d.points, d.rings) = (found.points.to_vec(), found.rings.to_vec());
    d.obstacles = found.obstacles.to_vec();
    d.obstacles[0].centroid_m = [2.8, 0.72];
    d.seen = found.seen.to_vec();
    let deviations = d.finish();
    Storey { deviations, ..before }
}

fn topics_after(earlier: &[u8], storey: &Storey) -> Vec<u8> {
    let earlier = Container::read(earlier).unwrap();
    files_by(storey, |input| deviation_files_after(input, earlier).unwrap())["deviations.bcfzip"].clone()
}

#[test]
fn a_topic_closes_when_its_element_is_seen_in_place_and_opens_when_it_is_not_again() {
    for version in [BcfVersion::V2_1, BcfVersion::V3_0] {
        let first = files_by(&storey("wall"), |input| deviation_files_in(input, version))["deviations.bcfzip"].clone();
        let before = Container::read(&first).unwrap();
        assert_eq!(before.version(), version);
        let pictures =
            before.topics().iter().flat_map(|topic| &topic.viewpoints).filter_map(|view| view.snapshot.as_ref());
        assert_eq!(pictures.filter(|picture| matches!(picture, Snapshot::Png(_))).count(), before.topics().len());
        let of_wall = |container: &Container| {
            let is_own =
                |topic: &&bcf::Topic| topic.viewpoints.iter().flat_map(|v| &v.components).any(|c| c.global_id == WALL);
            container.topics().iter().find(is_own).cloned().unwrap()
        };
        // Nothing is known of it: the topic stays as it is.
        let unseen = topics_after(&first, &later("wall", Observation::Unseen, DeviationVerdict::Unknown));
        assert_eq!(Container::read(&unseen).unwrap().topics(), before.topics());
        let in_place = later("wall", Observation::Observed, DeviationVerdict::OnPlan);
        let closed = topics_after(&first, &in_place);
        let after = Container::read(&closed).unwrap();
        let (was, is) = (of_wall(&before), of_wall(&after));
        assert_eq!((is.status.as_str(), is.comments.len(), &is.guid), ("Closed", 1, &was.guid));
        assert!(is.comments[0].text.starts_with("The robot saw it in place"), "{}", is.comments[0].text);
        // The others are as they were: none is lost, and the obstacle of another map in the same place is the same.
        let others = |container: &Container, guid: &str| {
            container.topics().iter().filter(|topic| topic.guid != guid).cloned().collect::<Vec<_>>()
        };
        assert_eq!(others(&after, &is.guid), others(&before, &was.guid));
        assert_eq!(topics_after(&closed, &in_place), closed, "the same look changes nothing");
        let again = Container::read(&topics_after(&closed, &storey("wall"))).unwrap();
        assert_eq!((of_wall(&again).status.as_str(), of_wall(&again).comments.len()), ("Open", 2));
    }
}
