//! The zones of a map storey.

use super::areas::{areas, rectangle};
use super::keepout_reasons::{KeepoutReason, keepout_reasons};
use crate::ids::{element_text, id_of};
use export::{ExportInput, each_door, reason_text, rounded, space_name};
use frames::metres;
use geometry::{FillRule, Ring, intersection, union};
use messages::{DoorPassage, DoorPassageRecord, Grid, SafetySubject};
use safety::{NO_SOURCE, SafetyInput, SafetyLayer};
use serde::Serialize;

/// A zone, with the keys of the format.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Zone {
    zone_id: String,
    zone_type: &'static str,
    zone_descriptor: String,
    vertices: Vec<Vertex>,
    #[serde(skip_serializing_if = "Option::is_none")]
    maximum_speed: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    release_loss_behavior: Option<&'static str>,
}

#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
struct Vertex {
    x: f64,
    y: f64,
}

/// What the pieces of an area have in common.
struct ZoneKind {
    id: String,
    zone_type: &'static str,
    descriptor: String,
    maximum_speed: Option<f64>,
}

/// All zones of a storey: blocked ones, limits of speed, releases.
pub(super) fn zones(input: &ExportInput<'_>, grid: &Grid<'_>) -> Vec<Zone> {
    let mut zones = blocked_zones(input, grid);
    zones.extend(speed_zones(input, grid));
    zones.extend(release_zones(input, grid));
    zones
}

fn blocked_zones(input: &ExportInput<'_>, grid: &Grid<'_>) -> Vec<Zone> {
    let spec = grid.spec();
    let reasons = keepout_reasons(input, grid);
    let of_reason = |(reason, polygons)| {
        let (id, descriptor) = words(input, reason);
        ZoneKind { id, zone_type: "BLOCKED", descriptor, maximum_speed: None }.pieces(polygons)
    };
    areas(&spec, |cell| reasons[cell]).flat_map(of_reason).collect()
}

/// Id and descriptor of what is blocked for a reason.
fn words(input: &ExportInput<'_>, reason: KeepoutReason) -> (String, String) {
    match reason {
        KeepoutReason::ClosedRoom(space) => {
            let id = input.site.text(input.site.spaces[space as usize].global_id);
            let name = space_name(input.site, space).map_or(String::new(), |name| format!("{name} "));
            let why = input.schedule_state.why(space as usize).collect::<Vec<_>>().join(", ");
            (format!("closed-room:{}", id_of(id)), format!("Closed room {name}{id}: {why}"))
        }
        KeepoutReason::Work(element) => {
            let id = input.site.text(input.site.elements[element as usize].global_id);
            let state = input.schedule_state.effective(element as usize).name();
            (format!("work:{}", id_of(id)), format!("Work at {}: {state}", element_text(input, element)))
        }
        KeepoutReason::DropOff => (
            "drop-off".to_owned(),
            "Drop-off: no floor at this level that this robot drives on, or the margin around it".to_owned(),
        ),
    }
}

fn speed_zones(input: &ExportInput<'_>, grid: &Grid<'_>) -> Vec<Zone> {
    let of = SafetyInput { site: input.site, schedule_state: input.schedule_state, index: input.index };
    let Some(layer) = SafetyLayer::of(of, grid) else { return Vec::new() };
    let rule_of = |cell: usize| match layer.speed_source[cell] {
        NO_SOURCE => None,
        source => Some(layer.sources[source as usize].rule as usize),
    };
    let of_rule = |(number, polygons): (usize, Vec<Ring>)| {
        let rule = &layer.rules.records()[number];
        let near = match layer.rules.subject(rule) {
            SafetySubject::Material(words) => format!("material {words}"),
            SafetySubject::Class(class) => format!("class {}", class.name()),
            _ => rule.kind.get().name().to_owned(),
        };
        let speed_m_s = rounded(rule.speed_m_s);
        let descriptor = match rounded(rule.distance_m) {
            0.0 => format!("{speed_m_s} m/s: {near}"),
            distance_m => format!("{speed_m_s} m/s: within {distance_m} m of {near}"),
        };
        let kind = ZoneKind {
            id: format!("speed:{number}"),
            zone_type: "SPEED_LIMIT",
            descriptor,
            maximum_speed: Some(speed_m_s),
        };
        kind.pieces(polygons)
    };
    areas(&layer.spec, rule_of).flat_map(of_rule).collect()
}

/// Zones in doors that are closed to this robot only because it cannot open them.
fn release_zones(input: &ExportInput<'_>, grid: &Grid<'_>) -> Vec<Zone> {
    let is_shut = |door: &DoorPassageRecord| {
        door.map_storey == grid.head.map_storey && door.reasons == DoorPassage::CannotOpen.bit()
    };
    let shut = each_door(input.site, input.index.doors).into_iter().filter(is_shut);
    let zones = shut.flat_map(|door| {
        let element = input.site.doors[door.door as usize].element;
        let why = reason_text(input.site, &input.index.head.robot, &door, DoorPassage::CannotOpen);
        let kind = ZoneKind {
            id: format!("release:{}", id_of(input.site.text(input.site.elements[element as usize].global_id))),
            zone_type: "RELEASE",
            descriptor: format!("{}: {why}; released once someone has opened it", element_text(input, element)),
            maximum_speed: None,
        };
        kind.pieces(way_on_map(&door, grid))
    });
    zones.collect()
}

/// The way through a door, as far as the map reaches.
fn way_on_map(door: &DoorPassageRecord, grid: &Grid<'_>) -> Vec<Ring> {
    let spec = grid.spec();
    let whole = rectangle(&spec, [0, 0], [spec.width, spec.height]);
    let [way, whole] = [door.way.to_box().ring(), whole].map(|ring| union(&[ring], FillRule::NonZero));
    intersection(&way, &whole).0.into_iter().map(|polygon| polygon.exterior).collect()
}

impl ZoneKind {
    /// A zone for each polygon.
    fn pieces(self, polygons: Vec<Ring>) -> impl Iterator<Item = Zone> {
        (1..).zip(polygons).map(move |(piece, polygon): (u32, Ring)| Zone {
            zone_id: format!("{}:{piece}", self.id),
            zone_type: self.zone_type,
            zone_descriptor: self.descriptor.clone(),
            vertices: polygon.into_iter().map(|[x, y]| Vertex { x: metres(x), y: metres(y) }).collect(),
            maximum_speed: self.maximum_speed,
            release_loss_behavior: (self.zone_type == "RELEASE").then_some("STOP"),
        })
    }
}
