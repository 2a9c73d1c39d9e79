//! The model as the records of the `site` archive.

use crate::attributes::add_attributes;
use crate::classify::{class_of, flags_of};
use crate::contacts::add_contacts;
use crate::diagnostics::add_diagnostic;
use crate::door_parts::join_parts_of_doors;
use crate::ground_class::ground_class_of;
use crate::input::SourceFile;
use crate::merge::Merged;
use crate::meshes::{MeshedBody, OutOfRange, add_body};
use crate::outdoors::add_outdoors;
use crate::passages::add_openings_and_doors;
use crate::schedule_records::add_schedule;
use crate::site_frame::SiteFrame;
use crate::site_storeys::add_storeys;
use crate::spaces::add_spaces;
use crate::stairs::add_stairs;
use crate::terrain::{add_terrains, finish_terrain};
use ifc::{CutPath, Diagnostic, DiagnosticCode, GeometryStatus, Named, Severity};
use messages::*;
use sha2::{Digest, Sha256};
use std::collections::HashMap;

/// All records of the site.
pub(crate) fn site_of(files: &[SourceFile], merged: &Merged, frame: SiteFrame) -> SiteBuilder {
    let mut builder = SiteBuilder::default();
    add_head(&mut builder, merged, frame);
    add_sources(&mut builder, files, merged);
    add_elements(&mut builder, merged, frame);
    add_terrains(&mut builder, merged, frame);
    join_parts_of_doors(&mut builder, merged);
    add_stairs(&mut builder, merged);
    let floors = add_spaces(&mut builder, merged, frame);
    let floors = add_storeys(&mut builder, merged, floors, frame);
    add_openings_and_doors(&mut builder, merged, &floors, frame);
    builder.boundaries.extend(
        merged.model.boundaries.iter().map(|b| BoundaryRecord { space: b.space as u32, element: b.element as u32 }),
    );
    add_contacts(&mut builder, merged, frame);
    add_outdoors(&mut builder, &merged.model.container.global_id);
    add_schedule(&mut builder, merged);
    for (source, diagnostic) in &merged.diagnostics {
        add_diagnostic(&mut builder, *source, diagnostic);
    }
    builder
}

fn add_head(builder: &mut SiteBuilder, merged: &Merged, frame: SiteFrame) {
    let georeference = &merged.model.georeference;
    let mut head = SiteHead {
        map_from_world_m: frame.map_from_world.translation_m(),
        map_from_world_yaw_rad: frame.map_from_world.yaw_rad(),
        frame_epoch: frame.frame_epoch,
        has_schedule: u32::from(merged.model.schedule != ifc::Schedule::default()),
        ..Default::default()
    };
    if let Some(conversion) = &georeference.map_conversion {
        head.has_earth = 1;
        head.earth_m = conversion.origin_m;
        head.earth_x_axis = conversion.x_axis;
        head.earth_scale = conversion.scale;
        head.earth_crs = builder.texts.add(&conversion.crs);
        head.earth_unit = builder.texts.add(&conversion.map_unit);
        head.earth_unit_m = conversion.map_unit_m;
    }
    if let Some(direction) = georeference.true_north {
        head.has_true_north = 1;
        head.true_north = direction;
    }
    builder.head = head;
}

fn add_sources(builder: &mut SiteBuilder, files: &[SourceFile], merged: &Merged) {
    for (file, (schema, length_unit_m)) in files.iter().zip(&merged.schemas) {
        builder.sources.push(SourceRecord {
            file: builder.texts.add(&file.name()),
            schema: builder.texts.add(schema),
            sha256: Sha256::digest(&file.bytes).into(),
            length_unit_m: *length_unit_m,
        });
    }
}

fn add_elements(builder: &mut SiteBuilder, merged: &Merged, frame: SiteFrame) {
    let elements = &merged.model.elements;
    // Elements of an entity share the list of its supertypes.
    let mut lists: HashMap<&[&str], TextList> = HashMap::new();
    for (index, element) in elements.iter().enumerate() {
        let source = merged.element_source[index];
        let (body, mut flags) = match add_body(builder, &element.geometry, &frame.map_from_world) {
            Ok(body) => (body, flags_of(elements, index)),
            Err(OutOfRange) => {
                add_diagnostic(builder, source, &out_of_range(&element.id, element.ifc_type));
                (None, element_flags::FAILED)
            }
        };
        let class =
            if flags & element_flags::FAILED == 0 { ground_class_of(elements, index) } else { GroundClass::None };
        if class.is_floor_of_maps() {
            flags |= element_flags::FLOOR;
        }
        let ground = if body.is_some() { class } else { GroundClass::None };
        if let Some(body) = body {
            finish_terrain(builder, ground, (body.first_part, body.n_parts), source, &element.id);
        }
        match &element.geometry.status {
            // A box may stop a robot, but it must not carry one: its top is no ground.
            GeometryStatus::BoundingBox { .. } => flags |= element_flags::BOUNDING_BOX,
            GeometryStatus::Failed { .. } => flags |= element_flags::FAILED,
            GeometryStatus::None | GeometryStatus::Meshed => {}
        }
        flags |= match element.geometry.cut {
            CutPath::None => 0,
            CutPath::Polygons => element_flags::CUT_AS_POLYGONS,
            CutPath::Kernel => element_flags::CUT_BY_KERNEL,
            CutPath::LeftOut => element_flags::PARTLY_CUT,
        };
        let (first_attribute, n_attributes) = add_attributes(builder, &element.properties);
        let first_material = builder.materials.len() as u32;
        for material in &element.materials {
            let text = builder.texts.add(material);
            builder.materials.push(text);
        }
        let entities = element.supertypes.as_slice();
        let supertypes = *lists.entry(entities).or_insert_with(|| builder.texts.add_list(entities.iter().copied()));
        let body_range = body.unwrap_or(MeshedBody { first_part: 0, n_parts: 0, min: [0; 3], max: [0; 3] });
        let record = ElementRecord {
            global_id: builder.texts.add(&element.id.global_id),
            name: builder.texts.add(&element.id.name),
            ifc_type: builder.texts.add(element.ifc_type),
            supertypes,
            predefined_type: builder.texts.add(&element.predefined_type),
            min_tenths: body_range.min,
            max_tenths: body_range.max,
            first_part: body_range.first_part,
            n_parts: body_range.n_parts,
            first_attribute,
            n_attributes,
            first_material,
            n_materials: element.materials.len() as u32,
            whole: element.whole.map_or(NONE, |k| k as u32),
            storey: element.storey.map_or(NONE, |k| k as u32),
            space: element.space.map_or(NONE, |k| k as u32),
            door: NONE,
            stair: NONE,
            source,
            step_id: element.id.step_id,
            class: class_of(elements, index).into(),
            ground: ground.into(),
            reserved: [0; 2],
            flags,
        };
        builder.elements.push(record);
    }
}

fn out_of_range(id: &Named, ifc_type: &str) -> Diagnostic {
    Diagnostic {
        severity: Severity::Error,
        code: DiagnosticCode::CoordinatesOutOfReach,
        entity: Some(id.clone()),
        source: None,
        message: format!("{ifc_type} lies farther than 107 km from the rest of the building and is left out"),
    }
}
