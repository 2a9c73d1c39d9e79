//! Malicious archives with valid hashes: rejected with an error or read without a panic.

mod support;

use bytemuck::Zeroable;
use messages::{
    Alignment, ArchiveBuffer, ArchiveError, ArchiveKind, CivilDate, Deviations, FloorKind, Grid, Grids,
    MapStoreyRecord, MissionPlan, NONE, PartRecord, ScheduleDate, ScheduleDateKind, ScheduleDateRecord, ScheduleState,
    Section, SectionCount, Site, SiteBuilder, TaskConstraintKind, TaskConstraintRecord, TaskRecord,
    TaskUncertaintyRecord,
};
use proptest::prelude::*;
use support::{
    alignment, deviations, every_archive, grid, grids, mission_plan, reseal, schedule_state, site, walk, whole,
};

/// Miri takes a thousand times as long.
const CASES: u32 = if cfg!(miri) { 6 } else { 20_000 };

fn archive() -> impl Strategy<Value = ArchiveBuffer> {
    prop::sample::select(every_archive())
}

/// What tends to hurt.
fn word() -> impl Strategy<Value = u32> {
    prop_oneof![
        any::<u32>(),
        0u32..40,
        prop::sample::select(vec![u32::MAX, u32::MAX - 1, i32::MAX as u32, i32::MIN as u32, 1 << 24, 0x7ff0_0000])
    ]
}

#[test]
fn whole_archives_are_read_to_the_end() {
    for archive in every_archive() {
        assert!(walk(archive.bytes()) > 4);
        let mut again = archive.clone();
        reseal(again.bytes_mut());
        assert_eq!(again.bytes(), archive.bytes());
    }
}

/// An archive whose entry of a section in the table has these bytes in this place.
fn with_entry(archive: &ArchiveBuffer, id: u32, at: usize, bytes: &[u8]) -> ArchiveBuffer {
    let mut changed = archive.clone();
    let entry = entry_of(archive, id);
    changed.bytes_mut()[entry + at..][..bytes.len()].copy_from_slice(bytes);
    reseal(changed.bytes_mut());
    changed
}

/// Where the entry of a section begins in the table behind the preamble.
fn entry_of(archive: &ArchiveBuffer, id: u32) -> usize {
    let ids =
        archive.bytes()[64..].chunks(24).map(|entry| u32::from_le_bytes(entry[..4].try_into().expect("four bytes")));
    64 + 24 * ids.take(64).position(|found| found == id).expect("whole archives have every section")
}

/// An archive in which a section has this many records, all of them zeros.
fn with_records(archive: &ArchiveBuffer, section: &Section, n: usize) -> ArchiveBuffer {
    let start = archive.bytes().len().next_multiple_of(64);
    let mut changed = ArchiveBuffer::zeroed(start + n * section.record_len);
    changed.bytes_mut()[..archive.bytes().len()].copy_from_slice(archive.bytes());
    let place = [start as u64, n as u64].map(u64::to_le_bytes).concat();
    with_entry(&changed, section.id, 8, &place)
}

/// Every kind with every section that it declares.
fn every_section(check: impl Fn(ArchiveKind, &ArchiveBuffer, &Section)) {
    for &kind in ArchiveKind::ALL {
        let archive = whole(kind);
        kind.sections().iter().for_each(|section| check(kind, &archive, section));
    }
}

#[test]
fn whole_archives_have_records_in_every_section() {
    every_section(|kind, archive, section| {
        let count = &archive.bytes()[entry_of(archive, section.id)..][16..24];
        assert_ne!(count, [0; 8], "{} of {kind:?}", section.name);
    });
}

#[test]
fn a_section_that_is_missing_is_refused_by_its_number_unless_it_is_optional() {
    every_section(|kind, archive, section| {
        let found = kind.check(with_entry(archive, section.id, 0, &9_999u32.to_le_bytes()).bytes());
        let missing = ArchiveError::Section { id: section.id };
        assert!(section.is_optional || found == Err(missing), "{} of {kind:?}: {found:?}", section.name);
    });
}

#[test]
fn a_section_of_other_records_or_of_more_or_fewer_than_it_may_have_is_refused_by_its_number() {
    every_section(|kind, archive, section| {
        let (id, n) = (section.id, |n| kind.check(with_records(archive, section, n).bytes()));
        let damaged = Err(ArchiveError::Section { id });
        let record_len = (section.record_len as u32 - 1).to_le_bytes();
        assert_eq!(kind.check(with_entry(archive, id, 4, &record_len).bytes()), damaged, "{section:?}");
        match section.count {
            SectionCount::One => assert_eq!([n(0), n(2)], [damaged.clone(), damaged], "{section:?}"),
            // Miri takes too long to hash so many.
            SectionCount::AtMost(max) if !cfg!(miri) => {
                assert_eq!(n(max + 1), Err(ArchiveError::Limit { id, max }), "{section:?}");
                assert_ne!(n(max), Err(ArchiveError::Limit { id, max }), "{section:?}");
            }
            SectionCount::AtMost(_) | SectionCount::Any => {}
        }
    });
}

#[test]
fn a_task_that_is_nested_in_itself_is_refused() {
    let whole = site();
    let parents = {
        let view = Site::open(whole.bytes()).unwrap();
        let start = whole.bytes().as_ptr() as usize;
        view.schedule.tasks.iter().map(|t| &raw const t.parent as usize - start).collect::<Vec<_>>()
    };
    for (task, parent) in [(0, 2u32), (1, 1), (0, 0)] {
        let mut buffer = whole.clone();
        buffer.bytes_mut()[parents[task]..][..4].copy_from_slice(&parent.to_le_bytes());
        reseal(buffer.bytes_mut());
        assert_eq!(Site::open(buffer.bytes()).unwrap_err(), ArchiveError::Index { what: "the schedule" });
    }
}

#[test]
fn constraints_of_tasks_that_are_not_there_or_out_of_order_are_refused() {
    let opened = |constraints: &[(u32, i64)]| {
        let mut builder = SiteBuilder::default();
        let task = TaskRecord { parent: NONE, control: NONE, calendar: NONE, ..TaskRecord::zeroed() };
        builder.schedule.tasks.extend([task, task]);
        let kind = TaskConstraintKind::MandatoryStart.into();
        let record = |&(task, at_s)| TaskConstraintRecord { at_s, task, kind, ..TaskConstraintRecord::zeroed() };
        builder.schedule.constraints = constraints.iter().map(record).collect();
        let archive = builder.finish();
        Site::open(archive.bytes()).map(|site| site.schedule.constraints.len()).ok()
    };
    assert_eq!(opened(&[(0, 5), (0, 3), (1, -5)]), Some(3));
    for refused in [[(1, 0), (0, 0)], [(0, 0), (2, 0)], [(0, i64::MAX), (1, 0)], [(0, i64::MIN), (1, 0)]] {
        assert_eq!(opened(&refused), None, "{refused:?}");
    }
}

#[test]
fn typed_dates_of_nothing_or_twice_or_beside_a_text_are_refused() {
    use ScheduleDateKind::{ActualStart, ScheduleStart, WorkStart};
    let opened = |dates: &[(ScheduleDateKind, u32, i64)], has_text: bool| {
        let mut builder = SiteBuilder::default();
        let mut task = TaskRecord { parent: NONE, control: NONE, calendar: NONE, ..TaskRecord::zeroed() };
        if has_text {
            task.schedule_start = builder.texts.add("2024-03-04").into();
        }
        builder.schedule.tasks.extend([task, task]);
        let date = |at_s| CivilDate { at_s, offset_s: None, is_day: true };
        let record = |&(kind, owner, at_s): &_| ScheduleDateRecord::new(date(at_s), kind, owner);
        builder.schedule.dates = dates.iter().map(record).collect();
        let archive = builder.finish();
        Site::open(archive.bytes()).map(|site| format!("{:?}", site.schedule.date(ScheduleStart, 1))).ok()
    };
    let found = Some(ScheduleDate::Civil(CivilDate { at_s: -5, offset_s: None, is_day: true }));
    let all = [(ScheduleStart, 0, 3), (ScheduleStart, 1, -5), (ActualStart, 0, 3)];
    assert_eq!(opened(&all, false), Some(format!("{found:?}")));
    let text = Some(ScheduleDate::Text("2024-03-04"));
    assert_eq!(opened(&[(ActualStart, 0, 3)], true), Some(format!("{text:?}")));
    assert_eq!(opened(&[(ScheduleStart, 0, 3)], true), None, "a text and a typed date");
    for refused in [(WorkStart, 0, 0), (ScheduleStart, 2, 0), (ScheduleStart, 0, i64::MAX), (ActualStart, 0, i64::MIN)]
    {
        assert_eq!(opened(&[refused], false), None, "{refused:?}");
    }
    assert_eq!(opened(&[(ScheduleStart, 1, 0), (ScheduleStart, 0, 0)], false), None);
    assert_eq!(opened(&[(ScheduleStart, 1, 0), (ScheduleStart, 1, 0)], false), None);
}

#[test]
fn three_point_durations_that_do_not_ascend_or_are_of_no_task_or_of_one_twice_are_refused() {
    let opened = |uncertainties: &[(u32, [i64; 3], u32)]| {
        let mut builder = SiteBuilder::default();
        let task = TaskRecord { parent: NONE, control: NONE, calendar: NONE, ..Zeroable::zeroed() };
        builder.schedule.tasks = vec![task; 2];
        let record = |&(task, [optimistic_s, likely_s, pessimistic_s], is_elapsed): &(u32, [i64; 3], u32)| {
            TaskUncertaintyRecord {
                duration_optimistic_s: optimistic_s,
                duration_likely_s: likely_s,
                duration_pessimistic_s: pessimistic_s,
                task,
                is_elapsed,
            }
        };
        builder.schedule.uncertainties = uncertainties.iter().map(record).collect();
        let archive = builder.finish();
        Site::open(archive.bytes()).map(|site| site.schedule.uncertainties.len())
    };
    let fine = (0, [0, 5, 5], 0);
    assert_eq!(opened(&[]), Ok(0));
    assert_eq!(opened(&[fine, (1, [1, 2, TaskUncertaintyRecord::MAX_DURATION_S], 1)]), Ok(2));
    for wrong in [
        vec![(2, [0, 5, 5], 0)],
        vec![(NONE, [0, 5, 5], 0)],
        vec![(0, [-1, 5, 5], 0)],
        vec![(0, [6, 5, 7], 0)],
        vec![(0, [1, 8, 7], 0)],
        vec![(0, [1, 2, TaskUncertaintyRecord::MAX_DURATION_S + 1], 0)],
        vec![(0, [i64::MIN, 0, i64::MAX], 0)],
        vec![(0, [1, 2, 3], 2)],
        vec![fine, fine],
        vec![(1, [1, 2, 3], 0), fine],
    ] {
        assert_eq!(opened(&wrong), Err(ArchiveError::Index { what: "the schedule" }), "{wrong:?}");
    }
}

#[test]
fn a_map_storey_whose_bounds_are_turned_over_is_refused_because_grids_are_laid_around_them() {
    let opened = |bounds_tenths: [i32; 4]| {
        let mut builder = SiteBuilder::default();
        let (global_id, name) = (builder.texts.add("storey"), builder.texts.add("Storey"));
        builder.map_storeys.push(MapStoreyRecord {
            global_id,
            name,
            floor_z_tenths: 0,
            floor: FloorKind::Built.into(),
            bounds_tenths,
        });
        Site::open(builder.finish().bytes()).map(|_| ())
    };
    assert_eq!(opened([0, 0, 10, 10]), Ok(()));
    for turned in [[11, 0, 10, 10], [0, 11, 10, 10]] {
        assert_eq!(opened(turned), Err(ArchiveError::Index { what: "a coordinate" }));
    }
}

#[test]
fn parts_that_share_triangles_are_refused_because_walking_them_would_be_quadratic() {
    let part = PartRecord { first_vertex: 0, n_vertices: 3, first_triangle: 0, n_triangles: 1, closed: 0, colour: 0 };
    let opened = |n_parts: usize| {
        let mut builder = SiteBuilder::default();
        builder.vertices.extend([[0; 3]; 6]);
        builder.triangles.push([0, 1, 2]);
        builder.parts.extend(vec![part; n_parts]);
        Site::open(builder.finish().bytes()).map(|_| ())
    };
    assert_eq!(opened(1), Ok(()));
    assert_eq!(opened(2), Err(ArchiveError::Index { what: "a triangle" }));
}

/// Where a field of a record lies in an archive.
fn place_of<T>(archive: &ArchiveBuffer, field: &T) -> usize {
    std::ptr::from_ref(field) as usize - archive.bytes().as_ptr() as usize
}

/// What is said of an archive in which an enumeration has a number that stands for nothing.
fn refusal(archive: &ArchiveBuffer, at: usize, open: fn(&[u8]) -> Result<(), ArchiveError>) -> String {
    let mut buffer = archive.clone();
    buffer.bytes_mut()[at] = 200;
    reseal(buffer.bytes_mut());
    open(buffer.bytes()).expect_err("nothing has the number 200").to_string()
}

/// Checks an archive with an unknown number in each of these fields.
fn check_tags(archive: &ArchiveBuffer, open: fn(&[u8]) -> Result<(), ArchiveError>, fields: &[(usize, &str)]) {
    for (at, what) in fields {
        assert_eq!(refusal(archive, *at, open), format!("the archive has an unknown {what}"));
    }
}

#[test]
fn a_site_with_an_unknown_kind_of_anything_is_refused() {
    let archive = site();
    let view = Site::open(archive.bytes()).unwrap();
    let (door, task, sequence) = (&view.doors[0], &view.schedule.tasks[0], &view.schedule.sequences[0]);
    let fields = [
        (place_of(&archive, &view.map_storeys[0].floor), "kind of floor"),
        (place_of(&archive, &view.elements[0].class), "class"),
        (place_of(&archive, &door.clear_width_from), "source of a clear width"),
        (place_of(&archive, &door.opens), "way of opening a door"),
        (place_of(&archive, &view.attributes[0].kind), "kind of attribute"),
        (place_of(&archive, &view.schedule.work_times[0].kind), "kind of recurrence"),
        (place_of(&archive, &task.duration_kind), "kind of duration"),
        (place_of(&archive, &sequence.lag_kind), "kind of duration"),
        (place_of(&archive, &sequence.kind), "kind of sequence"),
        (place_of(&archive, &view.schedule.task_links[0].kind), "kind of link"),
        (place_of(&archive, &view.diagnostics[0].code), "code of a diagnostic"),
        (place_of(&archive, &view.diagnostics[0].severity), "severity"),
    ];
    check_tags(&archive, |bytes| Site::open(bytes).map(|_| ()), &fields);
}

#[test]
fn a_phase_with_an_unknown_state_is_refused() {
    let archive = schedule_state();
    let start = archive.bytes().as_ptr() as usize;
    let view = ScheduleState::open(archive.bytes()).unwrap();
    let states = view.states().map(|states| states.as_ptr() as usize - start);
    let fields = [
        (states[0], "state of an element"),
        (states[1], "state of an element"),
        (place_of(&archive, &view.spaces[0].state), "state of a space"),
        (place_of(&archive, &view.schedule[0].source), "source of dates"),
        (place_of(&archive, &view.diagnostics[0].code), "code of a diagnostic"),
        (place_of(&archive, &view.diagnostics[0].severity), "severity"),
    ];
    check_tags(&archive, |bytes| ScheduleState::open(bytes).map(|_| ()), &fields);
}

#[test]
fn grids_with_an_unknown_class_floor_or_passage_are_refused() {
    let archive = grid();
    let view = Grid::open(archive.bytes()).unwrap();
    let fields =
        [(place_of(&archive, &view.head.floor), "kind of floor"), (place_of(&archive, &view.class[0]), "class")];
    check_tags(&archive, |bytes| Grid::open(bytes).map(|_| ()), &fields);
    let archive = grids();
    let view = Grids::open(archive.bytes()).unwrap();
    let fields = [
        (place_of(&archive, &view.doors[0].passage), "passage of a door"),
        (place_of(&archive, &view.doors[0].reasons) + 1, "reason for a closed door"),
    ];
    check_tags(&archive, |bytes| Grids::open(bytes).map(|_| ()), &fields);
}

#[test]
fn a_plan_with_an_unknown_kind_is_refused() {
    let archive = mission_plan();
    let view = MissionPlan::open(archive.bytes()).unwrap();
    let fields = [
        (place_of(&archive, &view.head.drive.cost), "cost of ways"),
        (place_of(&archive, &view.waypoints[0].kind), "kind of waypoint"),
        (place_of(&archive, &view.spaces[0].why), "reason for having no waypoint"),
        (place_of(&archive, &view.spaces[0].access), "access to a space"),
        (place_of(&archive, &view.storeys[0].entry), "entry to a storey"),
        (place_of(&archive, &view.nodes[0].kind), "kind of node"),
        (place_of(&archive, &view.edges[0].kind), "kind of edge"),
        (place_of(&archive, &view.diagnostics[0].code), "code of a diagnostic"),
        (place_of(&archive, &view.diagnostics[0].severity), "severity"),
    ];
    check_tags(&archive, |bytes| MissionPlan::open(bytes).map(|_| ()), &fields);
}

#[test]
fn a_plan_whose_poses_have_no_direction_that_is_up_or_whose_drive_has_no_number_is_refused() {
    let archive = mission_plan();
    let view = MissionPlan::open(archive.bytes()).unwrap();
    let [x, _, z] = view.waypoints[0].up_in_map.each_ref().map(|c| place_of(&archive, c));
    let sensor = place_of(&archive, &view.waypoints[0].sensor_in_map_m[1]);
    let mass = place_of(&archive, &view.head.drive.mass_kg);
    for (at, number) in [(x, 0.7), (x, f64::NAN), (z, -0.8), (sensor, f64::INFINITY), (mass, f64::NAN)] {
        let mut buffer = archive.clone();
        buffer.bytes_mut()[at..at + 8].copy_from_slice(&number.to_le_bytes());
        reseal(buffer.bytes_mut());
        let refused = MissionPlan::open(buffer.bytes()).expect_err("it is refused").to_string();
        assert!(refused.contains("waypoint"), "{number}: {refused}");
    }
}

#[test]
fn an_alignment_with_an_unknown_verdict_or_state_is_refused() {
    let archive = alignment();
    let view = Alignment::open(archive.bytes()).unwrap();
    let fields = [
        (place_of(&archive, &view.head.verdict), "verdict"),
        (place_of(&archive, &view.head.state), "state of a pose"),
    ];
    check_tags(&archive, |bytes| Alignment::open(bytes).map(|_| ()), &fields);
}

#[test]
fn deviations_with_an_unknown_observation_are_refused() {
    let archive = deviations();
    let view = Deviations::open(archive.bytes()).unwrap();
    let element = &view.elements[0];
    let fields = [
        (place_of(&archive, &view.seen[0]), "state of a cell"),
        (place_of(&archive, &element.observation), "observation"),
        (place_of(&archive, &element.verdict), "judgement"),
        (place_of(&archive, &element.reason), "reason for not seeing"),
        (place_of(&archive, &element.planned), "state of an element"),
        (place_of(&archive, &view.absent_parts[0].verdict), "judgement"),
    ];
    check_tags(&archive, |bytes| Deviations::open(bytes).map(|_| ()), &fields);
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(CASES) })]

    #[test]
    fn changed_words_are_refused_or_harmless(
        archive in archive(),
        changes in prop::collection::vec((any::<prop::sample::Index>(), word()), 1..6),
    ) {
        let mut buffer = archive;
        let n_words = buffer.bytes().len() / 4;
        for (at, word) in changes {
            let at = at.index(n_words) * 4;
            buffer.bytes_mut()[at..at + 4].copy_from_slice(&word.to_le_bytes());
        }
        walk(buffer.bytes());
        reseal(buffer.bytes_mut());
        walk(buffer.bytes());
    }

    #[test]
    fn cut_off_archives_are_refused_or_harmless(archive in archive(), length in any::<prop::sample::Index>()) {
        let cut = &archive.bytes()[..length.index(archive.bytes().len())];
        let mut buffer = ArchiveBuffer::zeroed(cut.len());
        buffer.bytes_mut().copy_from_slice(cut);
        walk(buffer.bytes());
        reseal(buffer.bytes_mut());
        walk(buffer.bytes());
    }

    #[test]
    fn any_bytes_are_refused(bytes in prop::collection::vec(any::<u8>(), 0..600)) {
        let mut buffer = ArchiveBuffer::zeroed(bytes.len());
        buffer.bytes_mut().copy_from_slice(&bytes);
        prop_assert_eq!(walk(buffer.bytes()), 0);
    }
}
