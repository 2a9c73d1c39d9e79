//! The layouts that the Python package reads, as a Python module: `common/python/src/groundplan/_layouts.py`.

use crate::archive::{self, LAYOUT_VERSION, NONE, Preamble, SectionEntry};
use crate::{
    AlignmentHead, ArchiveKind, ContentHash, DecidingPlaceRecord, ElementState, GridHead, GridSlotRecord, GridsHead,
    HintRecord, InputHashes, NO_HEIGHT, NO_SLOPE, PlacedRecord, PoseEvidence, PosePairRecord, PoseRecord, RobotProfile,
    SampleHeader, ScheduleStateHead, Section, SlamCell, Tag, TagOf, Text, WaypointKind, WaypointRecord, sample_header,
};
use std::any::type_name;
use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::Path;

/// A type of fields, with its name in numpy.
trait NumpyType {
    fn numpy() -> String;
}

macro_rules! numbers {
    ($($number:ty => $name:literal),*) => {
        $(impl NumpyType for $number {
            fn numpy() -> String {
                format!("\"{}\"", $name)
            }
        })*
    };
}
numbers!(u8 => "u1", i8 => "i1", u16 => "<u2", u32 => "<u4", i32 => "<i4", u64 => "<u8", i64 => "<i8", f64 => "<f8");

impl NumpyType for ContentHash {
    fn numpy() -> String {
        u64::numpy()
    }
}

impl<B: NumpyType, M> NumpyType for TagOf<B, M> {
    fn numpy() -> String {
        B::numpy()
    }
}

impl<T: NumpyType, const N: usize> NumpyType for [T; N] {
    fn numpy() -> String {
        format!("({}, ({N},))", T::numpy())
    }
}

/// The type of the field that a function shows.
fn numpy_of<R, T: NumpyType>(_: impl Fn(&R) -> &T) -> (String, usize) {
    (T::numpy(), size_of::<T>())
}

/// A record as a Python list of (name, type) that numpy takes. Every field is named: there is no room between them.
macro_rules! record {
    ($record:ty: $($field:ident),*) => {{
        let mut text = String::from("[");
        let mut end = 0;
        $(
            let (numpy, size) = numpy_of(|r: &$record| &r.$field);
            assert_eq!(std::mem::offset_of!($record, $field), end, "a field before `{}` is missing", stringify!($field));
            end += size;
            write!(text, "\n    (\"{}\", {numpy}),", stringify!($field)).unwrap();
        )*
        assert_eq!(end, size_of::<$record>(), "the last field is missing");
        let nested: String = text + "\n]";
        nested
    }};
}

macro_rules! nested_records {
    ($($record:ty => $name:literal),*) => {
        $(impl NumpyType for $record {
            fn numpy() -> String {
                $name.to_owned()
            }
        })*
    };
}
nested_records!(
    InputHashes => "INPUT_HASHES", GridHead => "GRID_HEAD", RobotProfile => "ROBOT_PROFILE", GridsHead => "GRIDS_HEAD",
    GridSlotRecord => "GRID_SLOT", ScheduleStateHead => "SCHEDULE_STATE_HEAD", Text => "TEXT",
    PoseEvidence => "POSE_EVIDENCE", PoseRecord => "POSE", AlignmentHead => "ALIGNMENT_HEAD",
    DecidingPlaceRecord => "DECIDING_PLACE", PlacedRecord => "PLACED", PosePairRecord => "POSE_PAIR",
    HintRecord => "HINT", WaypointRecord => "WAYPOINT"
);

/// Records of sections whose fields Python knows: numbers, and what is written out below.
macro_rules! known_records {
    ($($record:ty),* $(,)?) => {
        BTreeMap::from([$((type_name::<$record>(), <$record as NumpyType>::numpy())),*])
    };
}

/// Sections of a kind whose records Python knows, by name: number, and type of a record.
fn sections(kind: ArchiveKind) -> String {
    let known = known_records!(
        u8,
        i8,
        u16,
        u32,
        i32,
        [u32; 2],
        [u32; 3],
        [i32; 2],
        [i32; 3],
        [f64; 2],
        [f64; 3],
        Tag<ElementState>,
        Tag<SlamCell>,
        GridHead,
        GridsHead,
        GridSlotRecord,
        ScheduleStateHead,
        Text,
        PoseRecord,
        AlignmentHead,
        DecidingPlaceRecord,
        PlacedRecord,
        PosePairRecord,
        HintRecord,
        WaypointRecord,
    );
    let line = |section: Section| {
        known.get(section.record).map(|numpy| format!("\n    \"{}\": ({}, {numpy}),", section.name, section.id))
    };
    format!("{{{}\n}}", kind.sections().into_iter().filter_map(line).collect::<String>())
}

fn module() -> String {
    let mut text = String::from(
        "\"\"\"Layouts of headers and archives, as numpy reads them.\n\nWritten by a test of common/messages with \
         UPDATE_GOLDEN=1 from the records there: not to be edited.\n\"\"\"\n\nfrom __future__ import annotations\n\n\
         from typing import Any\n",
    );
    let mut constant = |name: &str, kind: &str, value: String| write!(text, "\n{name}: {kind} = {value}").unwrap();
    constant("LAYOUT_VERSION", "int", LAYOUT_VERSION.to_string());
    constant("ARCHIVE_MAGIC", "int", archive::MAGIC.to_string());
    constant("SAMPLE_MAGIC", "int", sample_header::MAGIC.to_string());
    constant("NO_TIME", "int", ScheduleStateHead::NO_TIME.to_string());
    constant("NO_HEIGHT", "int", NO_HEIGHT.to_string());
    constant("NO_SLOPE", "int", NO_SLOPE.to_string());
    constant("NONE", "int", NONE.to_string());
    let kind = |kind: WaypointKind| format!("\n    {}: \"{}\",", kind as u32, kind.name());
    constant("WAYPOINT_KINDS", "dict[int, str]", format!("{{{}\n}}", WaypointKind::ALL.map(kind).concat()));
    let kind = |kind: &ArchiveKind| format!("\n    \"{}\": {},", kind.name(), *kind as u32);
    let kinds: Vec<String> = ArchiveKind::ALL.iter().map(kind).collect();
    constant("KINDS", "dict[str, int]", format!("{{{}\n}}", kinds.concat()));

    let fields = "list[tuple[str, Any]]";
    let hashes = record!(InputHashes: site, schedule_state, grids, robot, slam_map, own);
    constant("INPUT_HASHES", fields, hashes);
    let header = record!(SampleHeader: magic, layout_version, kind, flags, epoch, stamp_ns, payload_length, content_hash,
        frame_epoch, inputs, reserved);
    constant("SAMPLE_HEADER", fields, header);
    let preamble = record!(Preamble: magic, layout_version, kind, n_sections, length, content_hash, reserved);
    constant("PREAMBLE", fields, preamble);
    constant("SECTION_ENTRY", fields, record!(SectionEntry: id, record_len, offset, count));
    let grid = record!(GridHead: cell_tenths, first_cell, width, height, map_storey, floor_z_tenths, slab_tenths, floor,
        frame_epoch, reserved);
    constant("GRID_HEAD", fields, grid);
    let robot = record!(RobotProfile: height_m, clearance_above_m, step_height_m, radius_m, max_slope_rad,
        max_cross_slope_rad, door_margin_m, edge_margin_m, work_margin_m, lidar_height_m, lidar_range_m, sensor_height_m, opens,
        climbs_stairs, stair_cost, reserved);
    constant("ROBOT_PROFILE", fields, robot);
    let index = record!(GridsHead: site_hash, schedule_state_hash, plan_time_s, robot);
    constant("GRIDS_HEAD", fields, index);
    constant("GRID_SLOT", fields, record!(GridSlotRecord: map_storey, cell_tenths, content_hash));
    let state = record!(ScheduleStateHead: site_hash, tasks_hash, plan_time_s, plan_until_s, valid_from_s, valid_until_s, n_changes,
        paper);
    constant("SCHEDULE_STATE_HEAD", fields, state);
    constant("TEXT", fields, record!(Text: offset, length));
    let evidence = record!(PoseEvidence: log_odds, score, precision, recall, free, seen_m, seen_through, in_walls, outside,
        free_in_walls, distinct_m);
    constant("POSE_EVIDENCE", fields, evidence);
    let pose = record!(PoseRecord: map_from_slam, covariance, about_m, evidence, map_storey, reserved);
    constant("POSE", fields, pose);
    let head = record!(AlignmentHead: site_hash, slam_map_hash, searched_map_hash, plan_time_s, pose, waiting,
        wrong_probability, scale, scale_deviation, reason, decision, change, verdict, state, is_waiting, validity, first_undecided,
        reserved);
    constant("ALIGNMENT_HEAD", fields, head);
    let place =
        record!(DecidingPlaceRecord: in_slam_m, way_m, differing_m, first_placed, n_placed, first_pair, n_pairs);
    constant("DECIDING_PLACE", fields, place);
    let placed = record!(PlacedRecord: in_map_m, room_global_id, room_name, room_long_name);
    constant("PLACED", fields, placed);
    constant("POSE_PAIR", fields, record!(PosePairRecord: candidates));
    constant("HINT", fields, record!(HintRecord: label, n_excluded, reserved));
    let waypoint = record!(WaypointRecord: position_in_map_m, sensor_in_map_m, up_in_map, yaw_rad, centroid_in_map_m, clearance_m,
        covers_m2, overlap, registration_overlap, overlap_without, leg_m, id, order, kind, map_storey, space, joins, n_faces,
        registration_order);
    constant("WAYPOINT", fields, waypoint);

    for &kind in ArchiveKind::ALL {
        let name = format!("{}_SECTIONS", kind.name().to_uppercase().replace('-', "_"));
        constant(&name, "dict[str, tuple[int, Any]]", sections(kind));
    }
    text + "\n"
}

#[test]
fn the_layouts_of_the_python_package_are_those_of_the_records() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../python/src/groundplan/_layouts.py");
    let module = module();
    if std::env::var_os("UPDATE_GOLDEN").is_some() {
        std::fs::write(&path, &module).unwrap();
    }
    assert!(std::fs::read_to_string(path).unwrap() == module, "UPDATE_GOLDEN=1 writes it");
}
