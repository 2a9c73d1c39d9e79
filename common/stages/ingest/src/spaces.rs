//! Records of spaces and their floor polygons.

use crate::attributes::add_attributes;
use crate::diagnostics::add_diagnostic;
use crate::merge::Merged;
use crate::meshes::add_body;
use crate::shafts::{names_shaft, names_void};
use crate::site_frame::SiteFrame;
use crate::storeys::SpaceFloor;
use frames::TENTHS_PER_M;
use geometry::{MeshView, MultiPolygon, Slab, footprint};
use ifc::{Diagnostic, DiagnosticCode, PropertyValue, Severity, Space};
use messages::{NONE, RingRecord, SiteBuilder, SpaceRecord, space_flags};

/// A space's floor is what its body covers in the lowest 10 cm.
const FLOOR_LAYER: i32 = TENTHS_PER_M / 10;

/// Writes the spaces; returns the floors of those that are rooms and have a body.
pub(crate) fn add_spaces(builder: &mut SiteBuilder, merged: &Merged, frame: SiteFrame) -> Vec<Option<SpaceFloor>> {
    let spaces = merged.model.spaces.iter().zip(&merged.space_source);
    spaces.map(|(space, &source)| add_space(builder, space, source, frame)).collect()
}

fn add_space(builder: &mut SiteBuilder, space: &Space, source: u32, frame: SiteFrame) -> Option<SpaceFloor> {
    // A space out of reach is one without a body, and reported as that.
    let body = add_body(builder, &space.geometry, &frame.map_from_world).unwrap_or_default();
    let floor = body.and_then(|b| floor_of(builder.meshes(b.first_part, b.n_parts)));
    if floor.is_none() {
        let message = "the space has no body, so it has no floor and no waypoint".to_owned();
        let entity = Some(space.id.clone());
        add_diagnostic(
            builder,
            source,
            &Diagnostic {
                severity: Severity::Warning,
                code: DiagnosticCode::SpaceWithoutBody,
                entity,
                source: None,
                message,
            },
        );
    }
    let first_ring = builder.rings.len() as u32;
    let (polygon, bottom, top) = floor.unwrap_or_default();
    for ring in polygon.rings() {
        builder.rings.push(RingRecord { first_point: builder.points.len() as u32, n_points: ring.len() as u32 });
        builder.points.extend_from_slice(ring);
    }
    let (first_attribute, n_attributes) = add_attributes(builder, &space.properties);
    let flags = flags_of(space);
    let record = SpaceRecord {
        global_id: builder.texts.add(&space.id.global_id),
        name: builder.texts.add(&space.id.name),
        long_name: builder.texts.add(&space.long_name),
        predefined_type: builder.texts.add(&space.predefined_type),
        area_m2: polygon.area_m2(),
        centroid_m: polygon.centroid().unwrap_or_default().map(|c| c / f64::from(TENTHS_PER_M)),
        first_ring,
        n_rings: builder.rings.len() as u32 - first_ring,
        first_part: body.map_or(0, |b| b.first_part),
        n_parts: body.map_or(0, |b| b.n_parts),
        first_attribute,
        n_attributes,
        floor_z_tenths: bottom,
        height_tenths: top - bottom,
        map_storey: NONE,
        storey: space.storey.map_or(NONE, |k| k as u32),
        source,
        flags,
    };
    builder.spaces.push(record);
    let is_room = flags & space_flags::METADATA_ONLY == 0 && !polygon.is_empty();
    let is_external = flags & space_flags::EXTERNAL != 0;
    let is_void = names_of(space).into_iter().any(names_void);
    let area_m2 = record.area_m2;
    is_room.then_some(SpaceFloor { area_m2, polygon, z: bottom, storey: space.storey, is_external, is_void })
}

/// What a space is called, of what type it is, and its codes in classifications.
fn names_of(space: &Space) -> Vec<&str> {
    let own = [&space.id.name, &space.long_name, &space.object_type, &space.predefined_type].map(String::as_str);
    let classes = space.properties.iter().filter(|property| property.set == "IfcClassification");
    let classes = classes.filter_map(|property| match &property.value {
        PropertyValue::Text(text) => Some(text.as_str()),
        PropertyValue::Number(_) | PropertyValue::Boolean(_) => None,
    });
    own.into_iter().chain(classes).collect()
}

fn flags_of(space: &Space) -> u32 {
    let mut flags = 0;
    if space.has_parts || space.predefined_type == "GFA" {
        flags |= space_flags::METADATA_ONLY;
    }
    if space.predefined_type == "EXTERNAL" {
        flags |= space_flags::EXTERNAL;
    }
    if names_of(space).into_iter().any(names_shaft) {
        flags |= space_flags::SHAFT;
    }
    flags
}

/// Plan of a space's floor, its height and that of its top, from its meshes; `None` without a body.
fn floor_of<'a>(meshes: impl Iterator<Item = MeshView<'a>> + Clone) -> Option<(MultiPolygon, i32, i32)> {
    let ranges = || meshes.clone().filter_map(MeshView::z_range);
    let (bottom, top) = (ranges().map(|r| r.0).min()?, ranges().map(|r| r.1).max()?);
    let layer = Slab { lo: bottom, hi: bottom.saturating_add(FLOOR_LAYER).min(top.max(bottom + 2)) };
    let floor = footprint(meshes, layer).area;
    (!floor.is_empty()).then_some((floor, bottom, top))
}
