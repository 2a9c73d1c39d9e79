//! The layouts that the Python package reads, as a Python module: `common/python/src/groundplan/_layouts.py`.

use crate::archive::{self, ArchiveKind, LAYOUT_VERSION, Preamble, SectionEntry};
use crate::tag::TagOf;
use crate::{
    AlignmentHead, DecidingPlaceRecord, GridHead, GridSlotRecord, GridsHead, HintRecord, InputHashes, PlacedRecord,
    PoseEvidence, PosePairRecord, PoseRecord, RobotProfile, SampleHeader, ScheduleStateHead, Text, alignment,
    grid_archive, grids, sample_header, schedule_state,
};
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
    InputHashes => "INPUT_HASHES", RobotProfile => "ROBOT_PROFILE", Text => "TEXT", PoseEvidence => "POSE_EVIDENCE",
    PoseRecord => "POSE"
);

/// Sections by name: number, and type of a record.
fn sections(entries: &[(&str, u32, &str)]) -> String {
    let lines = entries.iter().map(|(name, id, numpy)| format!("\n    \"{name}\": ({id}, {numpy}),"));
    format!("{{{}\n}}", lines.collect::<String>())
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
    let kinds = [
        ("site", ArchiveKind::Site),
        ("schedule-state", ArchiveKind::ScheduleState),
        ("grid", ArchiveKind::Grid),
        ("grids", ArchiveKind::Grids),
        ("mission-plan", ArchiveKind::MissionPlan),
        ("slam-map", ArchiveKind::SlamMap),
        ("alignment", ArchiveKind::Alignment),
        ("deviations", ArchiveKind::Deviations),
        ("alignment-evidence", ArchiveKind::AlignmentEvidence),
        ("tasks", ArchiveKind::Tasks),
    ];
    let kinds = kinds.map(|(name, kind)| format!("\n    \"{name}\": {},", kind as u32));
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
    let robot = record!(RobotProfile: height_m, clearance_above_m, step_height_m, radius_m, max_slope_rad, door_margin_m,
        edge_margin_m, work_margin_m, lidar_height_m, lidar_range_m, sensor_height_m, opens, climbs_stairs);
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

    let of = "dict[str, tuple[int, Any]]";
    let (u8s, i8s) = ("\"u1\"", "\"i1\"");
    let layers = {
        use grid_archive::section::*;
        sections(&[
            ("head", HEAD, "GRID_HEAD"),
            ("class", CLASS, u8s),
            ("planning", PLANNING, i8s),
            ("localization", LOCALIZATION, i8s),
            ("keepout", KEEPOUT, i8s),
            ("floor", FLOOR, u8s),
            ("space", SPACE, "\"<u2\""),
        ])
    };
    constant("GRID_SECTIONS", of, layers);
    let index = {
        use grids::section::*;
        sections(&[("head", HEAD, "GRIDS_HEAD"), ("slots", SLOTS, "GRID_SLOT"), ("robot_name", ROBOT_NAME, u8s)])
    };
    constant("GRIDS_SECTIONS", of, index);
    let state = sections(&[("head", schedule_state::section::HEAD, "SCHEDULE_STATE_HEAD")]);
    constant("SCHEDULE_STATE_SECTIONS", of, state);
    let sections_of_alignment = {
        use alignment::section::*;
        sections(&[
            ("head", HEAD, "ALIGNMENT_HEAD"),
            ("candidates", CANDIDATES, "POSE"),
            ("deciding_places", DECIDING_PLACES, "DECIDING_PLACE"),
            ("placed", PLACED, "PLACED"),
            ("pose_pairs", POSE_PAIRS, "POSE_PAIR"),
            ("hints", HINTS, "HINT"),
            ("strings", STRINGS, u8s),
        ])
    };
    constant("ALIGNMENT_SECTIONS", of, sections_of_alignment);
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
