//! Records of openings and doors.

use crate::bodiless_doors::hang_leaves_for_bodies;
use crate::classify::is_a;
use crate::diagnostics::add_diagnostic;
use crate::door_leaves::join_leaves;
use crate::door_width::{ImplausibleWidth, measured_width_m, overall_width_m};
use crate::doors::{clear_width_m, joined_spaces, map_storey_of, opens, operation_is_known};
use crate::filled_openings::report_filled_openings;
use crate::merge::Merged;
use crate::meshes::points_in_map;
use crate::openings::plan_of_opening;
use crate::site_frame::SiteFrame;
use crate::storeys::SpaceFloor;
use frames::{Map, TENTHS_PER_M, UprightRigid3, World, metres};
use geometry::{MultiPolygon, OrientedBox, Point};
use ifc::{Diagnostic, DiagnosticCode, Element, Severity};
use messages::{
    BoxRecord, DoorHanging, DoorPanelRecord, DoorRecord, LeafPanel, MovingLeaves, NONE, OpeningRecord, SiteBuilder,
    element_flags,
};

/// A door and a space whose floors are this near are on one level.
const ONE_LEVEL: i32 = TENTHS_PER_M / 2;

/// Writes openings, then doors.
pub(crate) fn add_openings_and_doors(
    builder: &mut SiteBuilder,
    merged: &Merged,
    floors: &[Option<SpaceFloor>],
    frame: SiteFrame,
) {
    for opening in &merged.model.openings {
        let record = opening_record(builder, merged, opening, &frame.map_from_world);
        builder.openings.push(record);
    }
    hang_leaves_for_bodies(builder, merged);
    report_filled_openings(builder, merged);
    let mut n_fillings = vec![0; builder.openings.len()];
    merged.model.elements.iter().filter_map(|e| e.fills).for_each(|opening| n_fillings[opening] += 1);
    for (index, element) in merged.model.elements.iter().enumerate() {
        if let Some(door) = &element.door {
            let is_shared = element.fills.is_some_and(|opening| n_fillings[opening] > 1);
            add_door(builder, floors, frame, (index, element), door, is_shared);
        }
    }
    join_leaves(builder);
}

fn opening_record(
    builder: &mut SiteBuilder,
    merged: &Merged,
    opening: &ifc::Opening,
    map_from_world: &UprightRigid3<Map, World>,
) -> OpeningRecord {
    let points = points_in_map(&opening.geometry, map_from_world);
    let z = || points.iter().map(|p| p[2]);
    let host = opening.host.map(|k| &merged.model.elements[k]);
    let wall = host.filter(|h| is_a(h, "IfcWall") || is_a(h, "IfcCurtainWall"));
    let plan = wall.and_then(|wall| {
        let host_record = &builder.elements[opening.host?];
        let parts = builder.meshes(host_record.first_part, host_record.n_parts);
        let host_points: Vec<Point> = parts.flat_map(|m| m.vertices.iter().map(|v| [v[0], v[1]])).collect();
        plan_of_opening(&in_plan(&points), &host_points, axis_of(wall, map_from_world))
    });
    OpeningRecord {
        global_id: builder.texts.add(&opening.id.global_id),
        host: opening.host.map_or(NONE, |k| k as u32),
        filling: opening.filling.map_or(NONE, |k| k as u32),
        bottom_z_tenths: z().min().unwrap_or(0),
        top_z_tenths: z().max().unwrap_or(0),
        plan: plan.map_or_else(BoxRecord::default, BoxRecord::from),
    }
}

fn door_warning(element: &Element, code: DiagnosticCode, message: String) -> Diagnostic {
    Diagnostic { severity: Severity::Warning, code, entity: Some(element.id.clone()), source: None, message }
}

fn width_implausible(element: &Element, why: &ImplausibleWidth) -> Diagnostic {
    let ImplausibleWidth { told_m, measured_m } = why;
    let message = format!(
        "OverallWidth is {told_m:.3} m, opening and body leave {measured_m:.3} m; the door counts as {measured_m:.3} m wide"
    );
    door_warning(element, DiagnosticCode::DoorWidthImplausible, message)
}

fn add_door(
    builder: &mut SiteBuilder,
    floors: &[Option<SpaceFloor>],
    frame: SiteFrame,
    (index, element): (usize, &Element),
    door: &ifc::Door,
    shares_opening: bool,
) {
    let record = builder.elements[index];
    let opening = element.fills.map(|k| (k, builder.openings[k])).filter(|(_, o)| o.is_in_wall());
    let body: Vec<Point> = builder
        .meshes(record.first_part, record.n_parts)
        .flat_map(|m| m.vertices.iter().map(|v| [v[0], v[1]]))
        .collect();
    let own = || door_box(&body, axis_of(element, &frame.map_from_world), door.overall_width_m);
    let passage = match opening {
        Some((_, o)) if shares_opening => Some(part_of_opening(&o.plan.to_box(), &body)),
        Some((_, o)) => Some(o.plan.to_box()),
        None => own(),
    };
    let measured_m = passage.map(|p| measured_width_m(&p, &body));
    if door.overall_width_m.is_none() {
        let message = "the door has no OverallWidth: its width is measured".to_owned();
        let (severity, code, entity) = (Severity::Info, DiagnosticCode::DoorWidthMissing, Some(element.id.clone()));
        add_diagnostic(builder, record.source, &Diagnostic { severity, code, entity, source: None, message });
    }
    let overall_width_m = overall_width_m(door.overall_width_m, measured_m).unwrap_or_else(|why| {
        add_diagnostic(builder, record.source, &width_implausible(element, &why));
        why.measured_m
    });
    let height = door.overall_height_m.filter(|h| *h > 0.0);
    let leaves = moving_leaves(door);
    let operation = leaves.and_then(|_| opens(&door.operation_type, &element.predefined_type));
    let share = leaves.map_or(0.0, |l| l.share);
    let (clear_width_m, clear_width_from) = clear_width_m(share * overall_width_m, door, operation);
    let hanging = hanging_of(builder, door, &frame.map_from_world);
    let passage = passage.map(|p| leaves.map_or(p, |l| l.part_of(&p, hanging.along)));
    if !operation_is_known(&door.operation_type) {
        let message = "the door has no operation type, swing is assumed".to_owned();
        let warning = door_warning(element, DiagnosticCode::DoorOperationUnknown, message);
        add_diagnostic(builder, record.source, &warning);
    }
    let bottom = opening.map_or(record.min_tenths[2], |(_, o)| o.bottom_z_tenths);
    let level: Vec<(usize, &MultiPolygon)> = floors
        .iter()
        .enumerate()
        .filter_map(|(k, f)| f.as_ref().filter(|f| (f.z - bottom).abs() <= ONE_LEVEL).map(|f| (k, &f.polygon)))
        .collect();
    let spaces = passage.map_or([None; 2], |p| joined_spaces(&p, &level));
    let has_body = record.n_parts > 0 && !record.has(element_flags::BOUNDING_BOX);
    let sill = if has_body { record.min_tenths[2] } else { bottom };
    let map_storey = map_storey_of(builder, sill, record.storey);
    builder.elements[index].door = builder.doors.len() as u32;
    let operation_text = builder.texts.add(&door.operation_type);
    builder.doors.push(DoorRecord {
        element: index as u32,
        opening: element.fills.map_or(NONE, |k| k as u32),
        spaces: spaces.map(|s| s.map_or(NONE, |k| k as u32)),
        operation: operation_text,
        opens: operation.map_or(0, |o| o as u32),
        clear_width_from: clear_width_from.into(),
        overall_width_m,
        overall_height_m: height.unwrap_or(metres(record.max_tenths[2] - record.min_tenths[2])),
        clear_width_m,
        passage: passage.map_or_else(BoxRecord::default, BoxRecord::from),
        hanging,
        beside: [NONE; 2],
        map_storey,
        reserved: 0,
    });
}

fn moving_leaves(door: &ifc::Door) -> Option<MovingLeaves> {
    let panels = door.panels.iter();
    let panels: Vec<LeafPanel<'_>> =
        panels.map(|p| LeafPanel { operation: &p.operation, position: &p.position, share: p.share }).collect();
    MovingLeaves::of(&door.operation_type, &panels)
}

fn hanging_of(builder: &mut SiteBuilder, door: &ifc::Door, map_from_world: &UprightRigid3<Map, World>) -> DoorHanging {
    let first_panel = builder.panels.len() as u32;
    for panel in &door.panels {
        let record = DoorPanelRecord {
            operation: builder.texts.add(&panel.operation),
            position: builder.texts.add(&panel.position),
            share: panel.share.unwrap_or(0.0),
        };
        builder.panels.push(record);
    }
    // A frame that lies on its side does not define a passage.
    let axis = |k: usize| door.frame.and_then(|f| direction_in_plan(f.axes[k], map_from_world));
    let (along, towards) = axis(0).zip(axis(1)).unwrap_or_default();
    let length = |m: Option<f64>| m.filter(|m| m.is_finite() && *m > 0.0).unwrap_or(0.0);
    DoorHanging {
        along,
        towards,
        lining_m: length(door.lining_thickness_m),
        leaf_m: length(door.panel_depth_m),
        first_panel,
        n_panels: door.panels.len() as u32,
    }
}

/// The part of a shared opening that a door fills.
fn part_of_opening(opening: &OrientedBox, body: &[Point]) -> OrientedBox {
    let Some(own) = OrientedBox::around(body.iter().copied(), opening.axis) else { return *opening };
    let along = |b: &OrientedBox| b.centre[0] * b.axis[0] + b.centre[1] * b.axis[1];
    let middle = along(opening);
    let low = (along(&own) - own.half[0]).max(middle - opening.half[0]);
    let high = (along(&own) + own.half[0]).min(middle + opening.half[0]);
    if low >= high {
        return *opening;
    }
    let centre = opening.at((low + high) / 2.0 - middle, 0.0);
    OrientedBox { centre, axis: opening.axis, half: [(high - low) / 2.0, opening.half[1]] }
}

/// The box of a door without an opening: along the placement's axis whose extent is nearest to the door's width.
fn door_box(body: &[Point], axis: Option<[f64; 2]>, width_m: Option<f64>) -> Option<OrientedBox> {
    let found = match axis {
        Some(axis) => OrientedBox::around(body.iter().copied(), axis)?,
        None => OrientedBox::smallest_around(body)?,
    };
    let turned = OrientedBox::around(body.iter().copied(), found.across())?;
    let off = |b: &OrientedBox| match width_m {
        Some(width) => (2.0 * b.half[0] - width * f64::from(TENTHS_PER_M)).abs(),
        None => -b.half[0],
    };
    Some(if off(&turned) < off(&found) { turned } else { found })
}

/// Unit direction in plan of a placement's x axis; `None` if it stands upright.
fn axis_of(element: &Element, map_from_world: &UprightRigid3<Map, World>) -> Option<[f64; 2]> {
    direction_in_plan(element.placement?.axes[0], map_from_world)
}

/// Unit direction in plan of a direction in the world; `None` if it stands upright.
fn direction_in_plan([x, y, _]: [f64; 3], map_from_world: &UprightRigid3<Map, World>) -> Option<[f64; 2]> {
    let length = libm::hypot(x, y);
    (length > 0.5).then(|| map_from_world.in_plane().rotate([x / length, y / length]))
}

fn in_plan(points: &[[i32; 3]]) -> Vec<Point> {
    points.iter().map(|p| [p[0], p[1]]).collect()
}
