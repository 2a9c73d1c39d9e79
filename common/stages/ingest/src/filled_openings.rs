//! Openings of walls that something fills down to the floor which is neither door nor window: it closes the way.

use crate::classify::is_a;
use crate::diagnostics::add_diagnostic;
use crate::merge::Merged;
use frames::TENTHS_PER_M;
use geometry::{OrientedBox, Point};
use ifc::{Diagnostic, DiagnosticCode, Element, Severity};
use messages::{OpeningRecord, SiteBuilder};

/// An opening that begins within this height of a floor, and a body that does, reach down to it.
const REACH: i32 = 3 * TENTHS_PER_M / 10;

/// An opening that is narrower or ends lower above the floor is no way.
const MIN_WIDTH: f64 = 0.5 * TENTHS_PER_M as f64;
const MIN_HEIGHT: i32 = 3 * TENTHS_PER_M / 2;

/// Share of an opening's width that a body closes at least.
const MIN_SHARE: f64 = 0.5;

/// Fillings with a name of their own on the map: a door opens, and nobody expects a way through a window.
const KNOWN: [&str; 2] = ["IfcDoor", "IfcWindow"];

/// Reports every element that fills the opening of a wall down to a floor and is neither door nor window, unless a door fills
/// the opening as well.
pub(crate) fn report_filled_openings(builder: &mut SiteBuilder, merged: &Merged) {
    let elements = &merged.model.elements;
    let mut has_door = vec![false; builder.openings.len()];
    elements.iter().filter(|e| e.door.is_some()).filter_map(|e| e.fills).for_each(|k| has_door[k] = true);
    for (index, element) in elements.iter().enumerate() {
        let opening = element.fills.filter(|&k| !has_door[k]).map(|k| builder.openings[k]);
        let Some(opening) = opening.filter(|_| !KNOWN.iter().any(|entity| is_a(element, entity))) else { continue };
        if !closes(builder, index, &opening) {
            continue;
        }
        let host = elements.get(opening.host as usize).map_or(String::new(), of_host);
        let opening_id = element.fills.map_or("", |k| merged.model.openings[k].id.global_id.as_str());
        let message = format!(
            "{} fills the opening {opening_id}{host} down to the floor and is no door: it closes the way",
            element.ifc_type
        );
        let (severity, code) = (Severity::Warning, DiagnosticCode::OpeningFilled);
        let diagnostic = Diagnostic { severity, code, entity: Some(element.id.clone()), source: None, message };
        add_diagnostic(builder, merged.element_source[index], &diagnostic);
    }
}

fn of_host(host: &Element) -> String {
    format!(" of {} {}", host.ifc_type, host.id.global_id)
}

/// True if the body of an element stands in an opening that is a way, and leaves none.
fn closes(builder: &SiteBuilder, element: usize, opening: &OpeningRecord) -> bool {
    let record = &builder.elements[element];
    let is_near = |floor: i32, z: i32| (z - floor).abs() <= REACH;
    let is_way = builder.map_storeys.iter().map(|storey| storey.floor_z_tenths).any(|floor| {
        is_near(floor, opening.bottom_z_tenths)
            && opening.top_z_tenths - floor >= MIN_HEIGHT
            && record.min_tenths[2] <= floor + REACH
            && record.max_tenths[2] > floor + REACH
    });
    if !is_way || record.n_parts == 0 || !opening.is_in_wall() || 2.0 * opening.plan.half[0] < MIN_WIDTH {
        return false;
    }
    let way = opening.plan.to_box();
    let parts = builder.meshes(record.first_part, record.n_parts);
    let body: Vec<Point> = parts.flat_map(|m| m.vertices.iter().map(|v| [v[0], v[1]])).collect();
    let Some(body) = OrientedBox::around(body, way.axis) else { return false };
    let shared = |axis: [f64; 2], k: usize| {
        let off = (0..2).map(|i| (body.centre[i] - way.centre[i]) * axis[i]).sum::<f64>();
        (off + body.half[k]).min(way.half[k]) - (off - body.half[k]).max(-way.half[k])
    };
    shared(way.axis, 0) >= MIN_SHARE * 2.0 * way.half[0] && shared(way.across(), 1) > 0.0
}
