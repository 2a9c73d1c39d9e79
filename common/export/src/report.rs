//! `report.json`: counts, assumptions, substitutions, omissions and diagnostics of a conversion.

use crate::diagnostics::{Diagnostic, schedule_diagnostics, site_diagnostics};
use crate::door_report::{DoorReport, door_reports};
use crate::geographic::GeographicReport;
use crate::input::ExportInput;
use crate::manifest::schedule_ignored;
use crate::reach::{self, FloorReach, RoomNotMapped};
use crate::schedule_report::ScheduleReport;
use crate::text::{rounded, text_or_null};
use crate::waypoints::space_name;
use frames::metres;
use grid::Class;
use messages::{ScheduleState, Site, element_flags};
use schemars::JsonSchema;
use serde::Serialize;
use std::collections::BTreeMap;

/// What was counted, assumed, replaced and left out.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Report {
    /// Number of elements by class.
    elements: BTreeMap<&'static str, usize>,
    /// Elements in the slab of each map storey, by class.
    storeys: Vec<StoreyCounts>,
    /// Rooms without a slab whose floor is assumed, from large to small.
    assumed_rooms: Vec<AssumedRoom>,
    /// Rooms that are on no map, from large to small.
    spaces_not_mapped: Vec<SpaceNotMapped>,
    /// Storeys of the files without a map of their own, and why.
    storeys_not_mapped: Vec<StoreyNotMapped>,
    /// True if the files hold a schedule that this map does not follow.
    schedule_ignored: bool,
    /// Where dates come from, and what is wrong with them.
    schedule: ScheduleReport,
    /// Elements whose body could not be made: a box stands in, or nothing.
    failed_geometry: Vec<FailedGeometry>,
    /// Elements with openings, by how these were cut.
    cuts: Cuts,
    /// Doors that are closed to the robot, lead to no floor, or whose clear width is assumed; each once, on the storey on which
    /// it stands.
    doors: Vec<DoorReport>,
    /// Floor at another level than its map storey's: not free there.
    regions: Vec<Region>,
    /// Spaces without a waypoint.
    spaces_without_waypoint: Vec<SpaceReport>,
    /// Latitudes and longitudes of the waypoints, or why there are none.
    geographic: GeographicReport,
    /// All other diagnostics.
    diagnostics: Vec<Diagnostic>,
}

#[derive(Debug, Serialize, JsonSchema)]
struct StoreyCounts {
    /// Index of the map storey.
    index: u32,
    /// Null if it has none; so are the names of everything below.
    name: Option<String>,
    /// Number of elements in its slab by class.
    elements: BTreeMap<&'static str, usize>,
    /// Number of spaces on it.
    spaces: usize,
    /// How much of its floor the robot gets to.
    reach: FloorReach,
}

#[derive(Debug, Serialize, JsonSchema)]
struct AssumedRoom {
    global_id: String,
    /// Name and long name.
    name: Option<String>,
    /// Index of its map storey.
    storey: u32,
    area_m2: f64,
}

#[derive(Debug, Serialize, JsonSchema)]
struct SpaceNotMapped {
    global_id: String,
    /// Name and long name.
    name: Option<String>,
    area_m2: f64,
    /// Height of its floor in `map`.
    floor_z_m: f64,
    /// Why it is on no map.
    reason: &'static str,
}

#[derive(Debug, Serialize, JsonSchema)]
struct StoreyNotMapped {
    global_id: Option<String>,
    name: Option<String>,
    reason: String,
}

#[derive(Debug, Serialize, JsonSchema)]
struct FailedGeometry {
    global_id: String,
    /// Entity name, e.g. `IfcWall`.
    r#type: String,
    name: Option<String>,
    /// `bounding_box` or `nothing`.
    drawn_as: &'static str,
}

#[derive(Debug, Serialize, JsonSchema)]
struct Cuts {
    /// As polygon differences in the planes of the faces.
    polygons: usize,
    /// By the kernel that meshes: bodies with gaps, and those that polygons would leave open.
    kernel: usize,
    /// Drawn without some of their openings, which would have taken too long; each has a diagnostic.
    partly: usize,
}

impl Cuts {
    fn of(site: &Site<'_>) -> Self {
        let n = |flag: u32| site.elements.iter().filter(|element| element.has(flag)).count();
        Self {
            polygons: n(element_flags::CUT_AS_POLYGONS),
            kernel: n(element_flags::CUT_BY_KERNEL),
            partly: n(element_flags::PARTLY_CUT),
        }
    }
}

#[derive(Debug, Serialize, JsonSchema)]
struct Region {
    /// Index of the map storey on which it is not free.
    storey: u32,
    /// GlobalId of the element whose face it is.
    global_id: String,
    /// Its height in `map`.
    level_z_m: f64,
    area_m2: f64,
    centre_m: [f64; 2],
}

#[derive(Debug, Serialize, JsonSchema)]
struct SpaceReport {
    global_id: String,
    name: Option<String>,
    reason: String,
}

impl Report {
    /// Of the inputs of an export.
    pub fn of(input: &ExportInput<'_>) -> Self {
        let site = input.site;
        let schedule_state: &ScheduleState<'_> = input.schedule_state;
        Self {
            elements: count(site.elements.iter().map(|e| e.class())),
            storeys: storey_counts(input),
            assumed_rooms: assumed_rooms(site),
            spaces_not_mapped: spaces_not_mapped(input),
            storeys_not_mapped: storeys_not_mapped(site),
            schedule_ignored: schedule_ignored(site, schedule_state),
            schedule: ScheduleReport::of(site, schedule_state),
            failed_geometry: failed_geometry(site),
            cuts: Cuts::of(site),
            doors: door_reports(input),
            regions: regions(input),
            spaces_without_waypoint: spaces_without_waypoint(input),
            geographic: GeographicReport::of(site),
            diagnostics: site_diagnostics(site).chain(schedule_diagnostics(site, schedule_state)).collect(),
        }
    }
}

fn count(classes: impl Iterator<Item = Class>) -> BTreeMap<&'static str, usize> {
    let mut counts = BTreeMap::new();
    for class in classes {
        *counts.entry(class.name()).or_insert(0) += 1;
    }
    counts
}

fn storey_counts(input: &ExportInput<'_>) -> Vec<StoreyCounts> {
    let site = input.site;
    let storeys = (0..).zip(site.map_storeys).zip(input.footprints);
    storeys
        .map(|((index, storey), cuts)| StoreyCounts {
            index,
            name: text_or_null(site.text(storey.name)),
            elements: count(cuts.iter().map(|(element, _)| site.elements[*element as usize].class())),
            spaces: site.spaces.iter().filter(|s| s.map_storey == index).count(),
            reach: FloorReach::of(input.mission_plan, index),
        })
        .collect()
}

fn assumed_rooms(site: &Site<'_>) -> Vec<AssumedRoom> {
    let room = |space: u32| {
        let record = &site.spaces[space as usize];
        AssumedRoom {
            global_id: site.text(record.global_id).to_owned(),
            name: space_name(site, space),
            storey: record.map_storey,
            area_m2: rounded(record.area_m2),
        }
    };
    crate::assumed_rooms(site).into_iter().map(room).collect()
}

fn spaces_not_mapped(input: &ExportInput<'_>) -> Vec<SpaceNotMapped> {
    let space = |room: RoomNotMapped| {
        let record = &input.site.spaces[room.space as usize];
        SpaceNotMapped {
            global_id: input.site.text(record.global_id).to_owned(),
            name: space_name(input.site, room.space),
            area_m2: rounded(record.area_m2),
            floor_z_m: metres(record.floor_z_tenths),
            reason: room.reason.text(),
        }
    };
    reach::spaces_not_mapped(input).into_iter().map(space).collect()
}

fn storeys_not_mapped(site: &Site<'_>) -> Vec<StoreyNotMapped> {
    let without = site.storeys.iter().filter(|s| s.why.length > 0);
    let text = |t| text_or_null(site.text(t));
    let reason = |why| site.text(why).to_owned();
    without
        .map(|s| StoreyNotMapped { global_id: text(s.global_id), name: text(s.name), reason: reason(s.why) })
        .collect()
}

fn failed_geometry(site: &Site<'_>) -> Vec<FailedGeometry> {
    let text = |t| site.text(t).to_owned();
    let failed = site.elements.iter().filter_map(|e| {
        let drawn_as = match e.flags {
            f if f & element_flags::BOUNDING_BOX != 0 => "bounding_box",
            f if f & element_flags::FAILED != 0 => "nothing",
            _ => return None,
        };
        let name = text_or_null(site.text(e.name));
        Some(FailedGeometry { global_id: text(e.global_id), r#type: text(e.ifc_type), name, drawn_as })
    });
    failed.collect()
}

fn regions(input: &ExportInput<'_>) -> Vec<Region> {
    let region = |r: &messages::RegionRecord| Region {
        storey: r.map_storey,
        global_id: input.site.text(input.site.elements[r.element as usize].global_id).to_owned(),
        level_z_m: metres(r.level_z_tenths),
        area_m2: rounded(r.area_m2),
        centre_m: r.centre_m.map(rounded),
    };
    input.index.regions.iter().map(region).collect()
}

fn spaces_without_waypoint(input: &ExportInput<'_>) -> Vec<SpaceReport> {
    let site = input.site;
    let without = site.spaces.iter().enumerate().filter(|(k, _)| !input.mission_plan.reason(*k).is_empty());
    let report = |(k, s): (usize, &messages::SpaceRecord)| SpaceReport {
        global_id: site.text(s.global_id).to_owned(),
        name: text_or_null(site.text(s.name)),
        reason: input.mission_plan.reason(k).to_owned(),
    };
    without.map(report).collect()
}
