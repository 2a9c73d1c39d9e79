//! The model into the records of the `site` archive.

use crate::SourceFile;
use crate::classify::{class_of, flags_of, is_a, is_footing, is_landing};
use crate::contacts::contacts;
use crate::levels::Faces;
use crate::merge::Merged;
use crate::meshes::{Body, OutOfReach, add_body};
use crate::passages::add_openings_and_doors;
use crate::schedule::add_schedule;
use crate::site_frame::SiteFrame;
use crate::spaces::add_spaces;
use crate::split_levels::{Access, Surroundings, add_levels};
use crate::stairs::add_stairs;
use crate::storeys::{Building, Candidate, Fate, MapStorey, SpaceFloor, map_storeys};
use frames::{TENTHS_PER_M, metres, tenths};
use geometry::{Bounds, MeshView, ramp_faces, upward_triangles};
use grid::Class;
use ifc::{Diagnostic, GeometryStatus, Named, Property, PropertyValue, Severity};
use messages::*;
use sha2::{Digest, Sha256};

/// A storey's grid holds what has a body between these heights above its floor, whatever the robot's size.
const BOUNDS_BELOW: i32 = -TENTHS_PER_M / 2;
const BOUNDS_ABOVE: i32 = 3 * TENTHS_PER_M;

/// Steeper floor is no level of its own.
const LEVEL_SLOPE_RAD: f64 = 0.01;

/// All records of the site.
pub(crate) fn site_of(files: &[SourceFile], merged: &Merged, frame: SiteFrame) -> SiteBuilder {
    let mut builder = SiteBuilder::default();
    add_head(&mut builder, merged, frame);
    add_sources(&mut builder, files, merged);
    add_elements(&mut builder, merged, frame);
    add_stairs(&mut builder, merged);
    let floors = add_spaces(&mut builder, merged, frame);
    let (mut mapped, fates) = find_storeys(&builder, merged, &floors, frame);
    let n_left_out = find_levels(&builder, merged, &floors, &mut mapped, &fates);
    if n_left_out > 0 {
        add_diagnostic(&mut builder, NONE, &levels_left_out(n_left_out));
    }
    add_storeys(&mut builder, merged, &mapped, &fates, frame);
    place_spaces(&mut builder, &floors);
    set_bounds(&mut builder);
    add_openings_and_doors(&mut builder, merged, &floors, frame);
    builder.boundaries.extend(
        merged.model.boundaries.iter().map(|b| BoundaryRecord { space: b.space as u32, element: b.element as u32 }),
    );
    if !merged.model.schedule.links.is_empty() {
        builder.contacts = contacts(&builder, merged, frame);
    }
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
    for (index, element) in elements.iter().enumerate() {
        let source = merged.element_source[index];
        let (body, mut flags) = match add_body(builder, &element.geometry, &frame.map_from_world) {
            Ok(body) => (body, flags_of(elements, index)),
            Err(OutOfReach) => {
                add_diagnostic(builder, source, &out_of_reach(&element.id, element.ifc_type));
                (None, element_flags::FAILED)
            }
        };
        match &element.geometry.status {
            // A box may stop a robot, but it must not carry one: its top is no floor.
            GeometryStatus::BoundingBox { .. } => {
                flags = flags & !element_flags::FLOOR | element_flags::BOUNDING_BOX;
            }
            GeometryStatus::Failed { .. } => flags |= element_flags::FAILED,
            GeometryStatus::None | GeometryStatus::Meshed => {}
        }
        let (first_attribute, n_attributes) = add_attributes(builder, &element.properties);
        let first_material = builder.materials.len() as u32;
        for material in &element.materials {
            let text = builder.texts.add(material);
            builder.materials.push(text);
        }
        let body_range = body.unwrap_or(Body { first_part: 0, n_parts: 0, min: [0; 3], max: [0; 3] });
        let record = ElementRecord {
            global_id: builder.texts.add(&element.id.global_id),
            name: builder.texts.add(&element.id.name),
            ifc_type: builder.texts.add(element.ifc_type),
            lineage: builder.texts.add(&element.supertypes.join(" ")),
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
            class: u32::from(class_of(elements, index).id()),
            flags,
        };
        builder.elements.push(record);
    }
}

fn out_of_reach(id: &Named, ifc_type: &str) -> Diagnostic {
    Diagnostic {
        severity: Severity::Error,
        code: "coordinates_out_of_reach",
        entity: Some(id.clone()),
        message: format!("{ifc_type} lies farther than 107 km from the rest of the building and is left out"),
    }
}

/// Writes properties: (first record, number of records).
pub(crate) fn add_attributes(builder: &mut SiteBuilder, properties: &[Property]) -> (u32, u32) {
    let first = builder.attributes.len() as u32;
    for property in properties {
        let (kind, number, text) = match &property.value {
            PropertyValue::Text(text) => (AttributeKind::Text, 0.0, text.as_str()),
            PropertyValue::Number(number) => (AttributeKind::Number, *number, ""),
            PropertyValue::Boolean(yes) => (AttributeKind::Boolean, f64::from(u8::from(*yes)), ""),
        };
        let record = AttributeRecord {
            set: builder.texts.add(&property.set),
            name: builder.texts.add(&property.name),
            text: builder.texts.add(text),
            number,
            kind: kind as u32,
            reserved: 0,
        };
        builder.attributes.push(record);
    }
    (first, properties.len() as u32)
}

pub(crate) fn add_diagnostic(builder: &mut SiteBuilder, source: u32, diagnostic: &Diagnostic) {
    let nobody = Named::default();
    let entity = diagnostic.entity.as_ref().unwrap_or(&nobody);
    let record = DiagnosticRecord {
        code: builder.texts.add(diagnostic.code),
        global_id: builder.texts.add(&entity.global_id),
        name: builder.texts.add(&entity.name),
        message: builder.texts.add(&diagnostic.message),
        severity: match diagnostic.severity {
            Severity::Info => 0,
            Severity::Warning => 1,
            Severity::Error => 2,
        },
        step_id: entity.step_id,
        source,
        reserved: 0,
    };
    builder.diagnostics.push(record);
}

fn find_storeys(
    builder: &SiteBuilder,
    merged: &Merged,
    floors: &[Option<SpaceFloor>],
    frame: SiteFrame,
) -> (Vec<MapStorey>, Vec<Fate>) {
    let faces = floor_faces_of(builder, merged);
    let rise = frame.map_from_world.translation_m()[2];
    let is_floor = |e: &(usize, &ElementRecord)| e.1.has(element_flags::FLOOR);
    let bodies = || builder.elements.iter().enumerate().filter(|(_, e)| e.n_parts > 0);
    let candidates: Vec<Candidate> = (0..merged.model.storeys.len())
        .map(|k| {
            let storey = &merged.model.storeys[k];
            let height = storey.placement_z_m.or(storey.elevation_m);
            let own = || bodies().filter(move |(_, e)| e.storey == k as u32);
            let (footings, floors): (Vec<_>, Vec<_>) =
                own().filter(is_floor).partition(|(element, _)| is_footing(&merged.model.elements, *element));
            let tops = |elements: Vec<(usize, &ElementRecord)>| -> Vec<i32> {
                let mut tops: Vec<i32> = elements.iter().map(|(_, e)| e.max_tenths[2]).collect();
                tops.sort_unstable();
                tops
            };
            Candidate {
                placement_z: height.and_then(|z| tenths(z + rise)),
                n_elements: own().count(),
                bodies: own().map(|(_, e)| [e.min_tenths[2], e.max_tenths[2]]).collect(),
                own_floors: tops(floors),
                own_footings: tops(footings),
            }
        })
        .collect();
    let spaces: Vec<SpaceFloor> = floors.iter().flatten().cloned().collect();
    let elements = &merged.model.elements;
    let has_walls = elements.iter().zip(&builder.elements).any(|(element, record)| {
        record.n_parts > 0 && record.class() == Class::Wall || is_a(element, "IfcCurtainWall")
    });
    let lowest_body = bodies().map(|(_, e)| e.min_tenths[2]).min();
    map_storeys(&Building { candidates: &candidates, spaces: &spaces, faces: &faces, lowest_body, has_walls })
}

/// Adds the levels of the storeys at other heights; returns how many there are beyond the number of maps.
fn find_levels(
    builder: &SiteBuilder,
    merged: &Merged,
    floors: &[Option<SpaceFloor>],
    mapped: &mut Vec<MapStorey>,
    fates: &[Fate],
) -> usize {
    let elements = &merged.model.elements;
    let records = || builder.elements.iter().enumerate().filter(|(_, e)| e.n_parts > 0);
    let meshes = |e: &ElementRecord| builder.meshes(e.first_part, e.n_parts);
    let is_level = |k: usize, e: &ElementRecord| {
        e.has(element_flags::FLOOR)
            && !e.has(element_flags::VERTICAL)
            && !is_footing(elements, k)
            && !is_landing(elements, k)
    };
    let level_faces = records().filter(|(k, e)| is_level(*k, e)).flat_map(|(_, e)| meshes(e));
    let level_faces = level_faces.flat_map(|mesh| upward_triangles(mesh, LEVEL_SLOPE_RAD)).collect();
    let hangs = |e: &ElementRecord| !matches!(e.class(), Class::Door | Class::Furniture | Class::Mep | Class::Railing);
    let bodies: Vec<([i32; 2], Vec<MeshView<'_>>)> = records()
        .filter(|(_, e)| hangs(e))
        .map(|(_, e)| ([e.min_tenths[2], e.max_tenths[2]], meshes(e).collect()))
        .collect();
    let access = |e: &ElementRecord| match e.class() {
        Class::Door => {
            let [min, max] = [e.min_tenths, e.max_tenths].map(|c| [c[0], c[1]]);
            Some(Access::Door { plan: Bounds { min, max }, sill_z: e.min_tenths[2] })
        }
        Class::Stair | Class::Ramp => {
            Some(Access::Flight { vertices: meshes(e).flat_map(|m| m.vertices.iter().copied()).collect() })
        }
        Class::Slab if e.has(element_flags::FLOOR) => {
            let faces = ramp_faces(meshes(e), RobotProfile::DEFAULT.max_slope_rad);
            (!faces.is_empty()).then(|| Access::Slope { vertices: faces.concat() })
        }
        _ => None,
    };
    let map_storey_of = fates.iter().map(|fate| match fate {
        Fate::Mapped(k) | Fate::Joined(k) => Some(*k),
        Fate::NotMapped(_) => None,
    });
    let around = Surroundings {
        level_faces: &level_faces,
        bodies: &bodies,
        accesses: &records().filter_map(|(_, e)| access(e)).collect::<Vec<_>>(),
        spaces: &floors.iter().flatten().cloned().collect::<Vec<_>>(),
        map_storey_of: &map_storey_of.collect::<Vec<_>>(),
    };
    add_levels(mapped, &around)
}

fn levels_left_out(n: usize) -> Diagnostic {
    let message = format!("levels at other heights that have no map, because a site has at most 64 maps: {n}");
    Diagnostic { severity: Severity::Warning, code: "levels_left_out", entity: None, message }
}

/// The upward faces of everything that is floor.
fn floor_faces_of(builder: &SiteBuilder, merged: &Merged) -> Faces {
    let mut faces = Faces::default();
    for (index, element) in builder.elements.iter().enumerate().filter(|(_, e)| e.has(element_flags::FLOOR)) {
        let is_footing = is_footing(&merged.model.elements, index);
        let list = if is_footing { &mut faces.footings } else { &mut faces.slabs };
        for mesh in builder.meshes(element.first_part, element.n_parts) {
            list.extend(upward_triangles(mesh, RobotProfile::DEFAULT.max_slope_rad));
        }
    }
    faces
}

fn add_storeys(builder: &mut SiteBuilder, merged: &Merged, mapped: &[MapStorey], fates: &[Fate], frame: SiteFrame) {
    let storeys = &merged.model.storeys;
    for storey in mapped {
        let id = storey.named_after.map_or(&merged.model.container, |k| &storeys[k].id);
        let name = match storey.level_of {
            Some(of) => format!("{} {:+.2} m", id.name, metres(storey.z - mapped[of].z)),
            None => id.name.clone(),
        };
        let record = MapStoreyRecord {
            global_id: builder.texts.add(&id.global_id),
            name: builder.texts.add(&name),
            floor_z_tenths: storey.z,
            floor: storey.floor as u32,
            bounds_tenths: [0; 4],
        };
        builder.map_storeys.push(record);
    }
    let rise = frame.map_from_world.translation_m()[2];
    for ((storey, fate), &source) in storeys.iter().zip(fates).zip(&merged.storey_source) {
        let (map_storey, why) = match fate {
            Fate::Mapped(k) => (*k as u32, String::new()),
            Fate::Joined(k) => (*k as u32, format!("its floor is that of {}", name_of(merged, mapped[*k].named_after))),
            Fate::NotMapped(why) => (NONE, (*why).to_owned()),
        };
        let placement = storey.placement_z_m.and_then(|z| tenths(z + rise));
        let record = StoreyRecord {
            global_id: builder.texts.add(&storey.id.global_id),
            name: builder.texts.add(&storey.id.name),
            why: builder.texts.add(&why),
            placement_z_tenths: placement.unwrap_or(0),
            has_placement: u32::from(placement.is_some()),
            map_storey,
            source,
        };
        builder.storeys.push(record);
    }
}

fn name_of(merged: &Merged, storey: Option<usize>) -> &str {
    let Some(k) = storey else { return "the building" };
    let id = &merged.model.storeys[k].id;
    if id.name.is_empty() { &id.global_id } else { &id.name }
}

/// A space belongs to the nearest map storey within half a metre of its floor.
fn place_spaces(builder: &mut SiteBuilder, floors: &[Option<SpaceFloor>]) {
    for (record, floor) in builder.spaces.iter_mut().zip(floors) {
        let Some(floor) = floor else { continue };
        let far = |k: &usize| (builder.map_storeys[*k].floor_z_tenths - floor.z).abs();
        let nearest = (0..builder.map_storeys.len()).min_by_key(far);
        record.map_storey = nearest.filter(|k| far(k) <= TENTHS_PER_M / 2).map_or(NONE, |k| k as u32);
    }
}

/// Plan bounds of each map storey: of bodies near its floor and of its spaces.
fn set_bounds(builder: &mut SiteBuilder) {
    let corner = |min: [i32; 3], max: [i32; 3]| Bounds { min: [min[0], min[1]], max: [max[0], max[1]] };
    for k in 0..builder.map_storeys.len() {
        let floor_z = builder.map_storeys[k].floor_z_tenths;
        let near = |e: &&ElementRecord| {
            e.n_parts > 0 && e.min_tenths[2] < floor_z + BOUNDS_ABOVE && floor_z + BOUNDS_BELOW < e.max_tenths[2]
        };
        let bodies = builder.elements.iter().filter(near).map(|e| corner(e.min_tenths, e.max_tenths));
        let spaces = builder.spaces.iter().filter(|s| s.map_storey == k as u32).filter_map(|s| {
            let rings = &builder.rings[s.first_ring as usize..][..s.n_rings as usize];
            Bounds::of(
                rings
                    .iter()
                    .flat_map(|r| builder.points[r.first_point as usize..][..r.n_points as usize].iter().copied()),
            )
        });
        let bounds = bodies.chain(spaces).reduce(Bounds::joined);
        let Bounds { min, max } = bounds.unwrap_or(Bounds { min: [0; 2], max: [0; 2] });
        builder.map_storeys[k].bounds_tenths = [min[0], min[1], max[0], max[1]];
    }
}
