//! `semantic.json`: elements and spaces by GlobalId.

use crate::input::ExportInput;
use crate::outlines::{FootprintTolerance, outlines};
use crate::painted_outline::Outline;
use crate::provenance::{link_rule, schedule_file};
use crate::semantic_geometry::Geometry;
use crate::text::{rounded, text_or_null};
use frames::metres;
use geometry::MultiPolygon;
use messages::{
    AttributeKind, AttributeRecord, ClearWidth, DoorRecord, ElementRecord, NONE, ScheduleStateHead, SpaceRecord,
    StairRecord, element_flags, space_flags, stair_flags,
};
use schemars::JsonSchema;
use serde::Serialize;
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;

/// What everything is, by GlobalId. Lengths in metres in `map`.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Semantic {
    /// Version of this layout: 2.
    version: u32,
    /// `map`: the frame of all coordinates and heights.
    frame: &'static str,
    /// Epoch of the map frame.
    frame_epoch: u32,
    /// How far footprints may deviate from the bodies.
    footprint_tolerance: FootprintTolerance,
    /// Elements by GlobalId.
    elements: BTreeMap<String, Element>,
    /// Spaces by GlobalId.
    spaces: BTreeMap<String, Space>,
}

#[derive(Debug, Serialize, JsonSchema)]
struct Element {
    /// Entity name, e.g. `IfcWall`.
    r#type: String,
    /// Class as in `classes.png`, e.g. `wall`.
    class: &'static str,
    /// Name; null if it has none.
    name: Option<String>,
    /// Map storeys whose slab it meets.
    storeys: Vec<u32>,
    /// Upright box around its body in `map`; null without a body.
    aabb_m: Option<Aabb>,
    #[serde(flatten)]
    footprints: Footprints,
    schedule: Schedule,
    attributes: Attributes,
    #[serde(flatten)]
    geometry: Option<Geometry>,
}

#[derive(Debug, Default, Serialize, JsonSchema)]
struct Footprints {
    /// Plan in the slab of each map storey it meets, by index: coordinates of a GeoJSON MultiPolygon, metres in `map`. Within
    /// `footprint_tolerance` of its body; exact for doors and floors.
    footprints: BTreeMap<u32, Coordinates>,
    /// How far these may deviate from its body, if that is more than `footprint_tolerance`: it has too much detail.
    #[serde(skip_serializing_if = "Option::is_none")]
    footprint_tolerance_m: Option<f64>,
}

impl Footprints {
    fn add(&mut self, storey: u32, outline: &Outline) {
        self.footprints.insert(storey, coordinates(&outline.area));
        let own_m = outline.own_tolerance.map(metres);
        self.footprint_tolerance_m = self.footprint_tolerance_m.into_iter().chain(own_m).reduce(f64::max);
    }
}

/// Polygons of rings of points; exteriors counter-clockwise, first point repeated.
type Coordinates = Vec<Vec<Vec<[f64; 2]>>>;

/// Corners of an upright box in metres.
#[derive(Debug, Serialize, JsonSchema)]
struct Aabb {
    min: [f64; 3],
    max: [f64; 3],
}

/// When it is built and removed; nulls where the site has no dates for it.
#[derive(Debug, Serialize, JsonSchema)]
struct Schedule {
    /// Plan time at which work begins; null where only the finish is known.
    start: Option<String>,
    /// Plan time at which it stands.
    finish: Option<String>,
    /// Plan time at which its removal begins.
    #[serde(skip_serializing_if = "Option::is_none")]
    removal_start: Option<String>,
    /// Plan time at which it is gone.
    #[serde(skip_serializing_if = "Option::is_none")]
    removal_finish: Option<String>,
    /// Working hours by which its task can slip without moving the end of the schedule.
    #[serde(skip_serializing_if = "Option::is_none")]
    total_float_h: Option<f64>,
    /// Working hours by which its task can slip without moving another.
    #[serde(skip_serializing_if = "Option::is_none")]
    free_float_h: Option<f64>,
    /// GlobalId of the last task that builds it, else of the last that removes it.
    #[serde(skip_serializing_if = "Option::is_none")]
    task: Option<String>,
    /// Name of that task; absent if it has none.
    #[serde(skip_serializing_if = "Option::is_none")]
    task_name: Option<String>,
    /// Base name of the schedule file of that task; absent for a task of the models.
    #[serde(skip_serializing_if = "Option::is_none")]
    file: Option<String>,
    /// Rule, or row of the table of links, that links that task with it; absent for links of the models.
    #[serde(skip_serializing_if = "Option::is_none")]
    rule: Option<String>,
    /// Where the dates come from: `reported`, `task_actual`, `task_schedule`, `task_early`, `task_computed`,
    /// `property_actual`, `property`, `phase`, `status`, or `none`: it exists.
    source: &'static str,
    /// State at the plan time: `not_started`, `in_progress`, `built`, `being_removed`, `removed`; for a period what it
    /// comes to. Null without a plan time.
    state: Option<&'static str>,
}

impl Schedule {
    fn of(input: &ExportInput<'_>, element: usize) -> Self {
        let record = input.schedule_state.schedule_of(element);
        let time = |seconds: i64| messages::plan_time(seconds).map(|t| t.to_string());
        let hours = |seconds: i64| (seconds != ScheduleStateHead::NO_TIME).then(|| rounded(seconds as f64 / 3600.0));
        let task = input.site.schedule.tasks.get(record.task as usize).filter(|_| record.task != NONE);
        Self {
            start: time(record.start_s),
            finish: time(record.finish_s),
            removal_start: time(record.removal_start_s),
            removal_finish: time(record.removal_finish_s),
            total_float_h: hours(record.total_float_s),
            free_float_h: hours(record.free_float_s),
            task: task.map(|t| input.site.schedule.text(t.global_id).to_owned()),
            task_name: task.and_then(|t| text_or_null(input.site.schedule.text(t.name))),
            file: task.and_then(|t| schedule_file(input.site, t)).map(str::to_owned),
            rule: task.and_then(|_| link_rule(input.site, record.task, element as u32)).map(str::to_owned),
            source: record.source.get().name(),
            state: input.schedule_state.head.plan_time().map(|_| input.schedule_state.effective(element).name()),
        }
    }
}

/// What is known about an element; doors and stairs have keys of their own.
#[derive(Debug, Serialize, JsonSchema)]
struct Attributes {
    /// PredefinedType.
    #[serde(skip_serializing_if = "Option::is_none")]
    predefined_type: Option<String>,
    /// Names of its materials.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    materials: Vec<String>,
    /// True if it is transparent to a lidar.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    glass: bool,
    /// True if its body could not be made, or a door has none, and a box stands in.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    bounding_box: bool,
    /// GlobalId of the element it is a part of.
    #[serde(skip_serializing_if = "Option::is_none")]
    part_of: Option<String>,
    #[serde(flatten, skip_serializing_if = "Option::is_none")]
    door: Option<Door>,
    #[serde(flatten, skip_serializing_if = "Option::is_none")]
    stair: Option<Stair>,
    /// Properties by set and name, numbers in the file's units; null where the file has an empty text.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    property_sets: PropertySets,
}

/// By set and name; null where the file has an empty text. What several groups or classifications have is joined with `, `.
type PropertySets = BTreeMap<String, BTreeMap<String, Option<PropertyValue>>>;

#[derive(Debug, Serialize, JsonSchema)]
#[serde(untagged)]
enum PropertyValue {
    Text(String),
    Number(f64),
    Boolean(bool),
}

#[derive(Debug, Serialize, JsonSchema)]
struct Door {
    /// As the schema spells it; null if unknown.
    operation_type: Option<String>,
    /// OverallWidth, else the width of its opening or body.
    overall_width_m: f64,
    /// OverallHeight, else the height of its body.
    overall_height_m: f64,
    /// Width between what remains when it is open, together with the leaves beside it that this robot can have open.
    clear_width_m: f64,
    /// `lining_and_panel` or `assumed`.
    clear_width_from: &'static str,
    /// GlobalIds of the spaces it joins; null where there is none.
    spaces: [Option<String>; 2],
    /// GlobalIds of the leaves next to it in the same opening, without a mullion between them.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    beside: Vec<String>,
    /// Map storey on which it stands; null in a site without any.
    storey: Option<u32>,
    /// Whether the robot can pass, for each map storey whose slab it meets: `passable`, `absent` where it leaves a hole, or the
    /// first reason why it is closed: `in_progress`, `no_floor`, `operation`, `too_narrow`, `no_opening`, `threshold`,
    /// `wall_uncut`, `obstructed`, `resolution`.
    passage: BTreeMap<u32, &'static str>,
}

/// Measures of a stair; nulls where neither the file nor its body has them.
#[derive(Debug, Serialize, JsonSchema)]
struct Stair {
    /// Number of risers.
    n_risers: Option<u32>,
    /// Number of treads.
    n_treads: Option<u32>,
    /// Height of a riser.
    riser_height_m: Option<f64>,
    /// Length of a tread.
    tread_length_m: Option<f64>,
    /// Those of `n_risers`, `riser_height_m` and `tread_length_m` that are measured on its body, because the file has none or
    /// one that the body contradicts.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    measured: Vec<&'static str>,
}

#[derive(Debug, Serialize, JsonSchema)]
struct Space {
    /// Name, often a number; null if it has none.
    name: Option<String>,
    /// LongName; null if it has none.
    long_name: Option<String>,
    /// PredefinedType.
    #[serde(skip_serializing_if = "Option::is_none")]
    predefined_type: Option<String>,
    /// True for gross areas and spaces made of spaces: for the record, not for robots.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    metadata_only: bool,
    /// True outdoors: it gets no waypoint.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    external: bool,
    /// Map storey; null if its floor is on none.
    storey: Option<u32>,
    /// Area centroid of its floor; null without a body.
    centroid_m: Option<[f64; 2]>,
    /// Area of its floor.
    area_m2: f64,
    /// Height of its body.
    height_m: f64,
    /// Height of its floor in `map`.
    floor_z_m: f64,
    /// Its floor: coordinates of a GeoJSON MultiPolygon, metres in `map`.
    polygon_m: Coordinates,
    /// GlobalIds of the doors that lead into it.
    doors: Vec<String>,
    /// `open` or `blocked`.
    state: &'static str,
    /// When it will be blocked, if it is open and that is soon.
    #[serde(skip_serializing_if = "Option::is_none")]
    closes_at: Option<String>,
    /// Why it is blocked, e.g. `task:` and a GlobalId, `before_room_date`, `private`; empty if it is open.
    why: Vec<String>,
    /// Properties by set and name, numbers in the file's units; null where the file has an empty text.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    property_sets: PropertySets,
}

impl Semantic {
    /// Of the inputs of an export.
    pub fn of(input: &ExportInput<'_>) -> Self {
        let site = input.site;
        let mut footprints: Vec<Footprints> = site.elements.iter().map(|_| Footprints::default()).collect();
        let mut storeys: Vec<Vec<u32>> = site.elements.iter().map(|_| Vec::new()).collect();
        for (storey, outlines) in (0..).zip(outlines(input)) {
            for (element, outline) in outlines {
                footprints[element as usize].add(storey, &outline);
                storeys[element as usize].push(storey);
            }
        }
        let rest = site.elements.iter().enumerate().zip(storeys).zip(footprints);
        let elements = rest.map(|(((index, record), storeys), footprints)| {
            let id = site.text(record.global_id).to_owned();
            (id, Element::of(input, index, record, storeys, footprints))
        });
        let spaces = site.spaces.iter().enumerate();
        let spaces = spaces.map(|(k, record)| (site.text(record.global_id).to_owned(), Space::of(input, k, record)));
        Self {
            version: 2,
            frame: "map",
            frame_epoch: site.head.frame_epoch,
            footprint_tolerance: FootprintTolerance::of(input),
            elements: elements.collect(),
            spaces: spaces.collect(),
        }
    }
}

impl Element {
    fn of(
        input: &ExportInput<'_>,
        index: usize,
        record: &ElementRecord,
        storeys: Vec<u32>,
        footprints: Footprints,
    ) -> Self {
        let site = input.site;
        let text = |t| site.text(t).to_owned();
        let door = (record.door != NONE).then(|| Door::of(input, record.door, &site.doors[record.door as usize]));
        let stair = (record.stair != NONE).then(|| Stair::of(&site.stairs[record.stair as usize]));
        let part_of = (record.whole != NONE).then(|| text(site.elements[record.whole as usize].global_id));
        Self {
            r#type: text(record.ifc_type),
            class: record.class().name(),
            name: text_or_null(site.text(record.name)),
            storeys,
            aabb_m: (record.n_parts > 0)
                .then(|| Aabb { min: record.min_tenths.map(metres), max: record.max_tenths.map(metres) }),
            footprints,
            schedule: Schedule::of(input, index),
            attributes: Attributes {
                predefined_type: text_or_null(site.text(record.predefined_type)),
                materials: site.element_materials(record).map(str::to_owned).collect(),
                glass: record.has(element_flags::GLASS),
                bounding_box: record.has(element_flags::BOUNDING_BOX),
                part_of,
                door,
                stair,
                property_sets: property_sets(input, site.element_attributes(record)),
            },
            geometry: (input.with_geometry && record.n_parts > 0).then(|| Geometry::of(site.element_meshes(record))),
        }
    }
}

impl Door {
    fn of(input: &ExportInput<'_>, index: u32, door: &DoorRecord) -> Self {
        let site = input.site;
        let space = |s: u32| (s != NONE).then(|| site.text(site.spaces[s as usize].global_id).to_owned());
        let records = || input.index.doors.iter().filter(|d| d.door == index);
        let passage = records().map(|d| (d.map_storey, d.passage.get().name()));
        let clear_width_m = records().next().map_or(door.clear_width_m, |d| d.clear_width_m);
        let beside = door.beside.iter().filter_map(|&d| site.doors.get(d as usize));
        Self {
            operation_type: text_or_null(site.text(door.operation)),
            overall_width_m: rounded(door.overall_width_m),
            overall_height_m: rounded(door.overall_height_m),
            clear_width_m: rounded(clear_width_m),
            clear_width_from: clear_width_word(door),
            spaces: door.spaces.map(space),
            beside: beside.map(|d| site.text(site.elements[d.element as usize].global_id).to_owned()).collect(),
            storey: (door.map_storey != NONE).then_some(door.map_storey),
            passage: passage.collect(),
        }
    }
}

pub(crate) fn clear_width_word(door: &DoorRecord) -> &'static str {
    match door.clear_width_from.get() {
        ClearWidth::LiningAndPanel => "lining_and_panel",
        ClearWidth::Assumed => "assumed",
    }
}

impl Stair {
    fn of(stair: &StairRecord) -> Self {
        let count = |n: u32| (n != NONE).then_some(n);
        let length = |m: f64| (m > 0.0).then(|| rounded(m));
        let measured = [
            (stair_flags::RISERS_MEASURED, "n_risers"),
            (stair_flags::RISER_HEIGHT_MEASURED, "riser_height_m"),
            (stair_flags::TREAD_LENGTH_MEASURED, "tread_length_m"),
        ];
        let measured = measured.into_iter();
        Self {
            n_risers: count(stair.n_risers),
            n_treads: count(stair.n_treads),
            riser_height_m: length(stair.riser_height_m),
            tread_length_m: length(stair.tread_length_m),
            measured: measured.filter(|(flag, _)| stair.flags & flag != 0).map(|(_, name)| name).collect(),
        }
    }
}

impl Space {
    fn of(input: &ExportInput<'_>, index: usize, record: &SpaceRecord) -> Self {
        let site = input.site;
        let text = |t| site.text(t).to_owned();
        let doors = site.doors.iter().filter(|d| d.spaces.contains(&(index as u32)));
        Self {
            name: text_or_null(site.text(record.name)),
            long_name: text_or_null(site.text(record.long_name)),
            predefined_type: text_or_null(site.text(record.predefined_type)),
            metadata_only: record.has(space_flags::METADATA_ONLY),
            external: record.has(space_flags::EXTERNAL),
            storey: (record.map_storey != NONE).then_some(record.map_storey),
            centroid_m: (record.n_rings > 0).then(|| record.centroid_m.map(rounded)),
            area_m2: rounded(record.area_m2),
            height_m: metres(record.height_tenths),
            floor_z_m: metres(record.floor_z_tenths),
            polygon_m: coordinates(&site.floor_polygon(record)),
            doors: doors.map(|d| text(site.elements[d.element as usize].global_id)).collect(),
            state: if input.schedule_state.is_blocked(index) { "blocked" } else { "open" },
            closes_at: messages::plan_time(input.schedule_state.spaces[index].closes_at_s).map(|t| t.to_string()),
            why: input.schedule_state.why(index).map(str::to_owned).collect(),
            property_sets: property_sets(input, site.space_attributes(record)),
        }
    }
}

fn property_sets(input: &ExportInput<'_>, attributes: &[AttributeRecord]) -> PropertySets {
    let mut sets = PropertySets::new();
    for attribute in attributes {
        let value = match attribute.kind.get() {
            // JSON has no infinity, which a file can write as 1.E999.
            AttributeKind::Number => Some(PropertyValue::Number(attribute.number.clamp(f64::MIN, f64::MAX))),
            AttributeKind::Boolean => Some(PropertyValue::Boolean(attribute.number == 1.0)),
            AttributeKind::Text => text_or_null(input.site.text(attribute.text)).map(PropertyValue::Text),
        };
        let set_name = input.site.text(attribute.set);
        let set = sets.entry(set_name.to_owned()).or_default();
        match set.entry(input.site.text(attribute.name).to_owned()) {
            Entry::Vacant(place) => {
                place.insert(value);
            }
            Entry::Occupied(mut place) if messages::MEMBERSHIP_SETS.contains(&set_name) => {
                if let (Some(PropertyValue::Text(all)), Some(PropertyValue::Text(text))) = (place.get_mut(), value) {
                    all.push_str(", ");
                    all.push_str(&text);
                }
            }
            Entry::Occupied(_) => {}
        }
    }
    sets
}

/// Coordinates of a GeoJSON MultiPolygon: rings closed.
fn coordinates(area: &MultiPolygon) -> Coordinates {
    let ring = |r: &geometry::Ring| r.iter().chain(r.first()).map(|p| p.map(metres)).collect();
    area.0.iter().map(|polygon| polygon.rings().map(ring).collect()).collect()
}
