//! Storeys of the site: what they are found from in its elements and rooms, and their records.

use crate::assumed_rooms::mark_assumed_rooms;
use crate::classify::{is_a, is_landing};
use crate::diagnostics::add_diagnostic;
use crate::floor_levels::FloorFaces;
use crate::merge::Merged;
use crate::outdoors::around;
use crate::shafts::holds_lift;
use crate::site_frame::SiteFrame;
use crate::split_levels::{Access, LevelInputs, add_levels};
use crate::storeys::{BuildingInputs, MapStorey, SpaceFloor, StoreyCandidate, StoreyOutcome, map_storeys};
use frames::{TENTHS_PER_M, metres, tenths};
use geometry::{Bounds, MeshView, Slab, clip_to_slab, ramp_faces, upward_triangles};
use grid::Class;
use ifc::{Diagnostic, DiagnosticCode, Severity};
use messages::{
    ElementRecord, FloorKind, GroundClass, MapStoreyRecord, NONE, RobotProfile, SiteBuilder, StoreyRecord,
    element_flags, space_flags,
};

/// A storey's grid contains what of bodies lies between these heights above its floor, independent of the robot.
const BOUNDS_BELOW: i32 = -TENTHS_PER_M / 2;
const BOUNDS_ABOVE: i32 = 3 * TENTHS_PER_M;

/// Steeper floor is no level of its own.
const LEVEL_SLOPE_RAD: f64 = 0.01;

/// Finds the storeys to be mapped and their levels from elements and floors of rooms, writes them, and puts the rooms on them. Returns
/// the floors without those of shafts.
pub(crate) fn add_storeys(
    builder: &mut SiteBuilder,
    merged: &Merged,
    mut floors: Vec<Option<SpaceFloor>>,
    frame: SiteFrame,
) -> Vec<Option<SpaceFloor>> {
    let shafts = take_shafts(builder, merged, &mut floors);
    let faces = floor_faces_of(builder);
    let (mut mapped, outcomes) = find_storeys(builder, merged, (&floors, &faces), frame);
    let n_left_out = find_levels(builder, merged, &floors, &mut mapped, &outcomes);
    if n_left_out > 0 {
        add_diagnostic(builder, NONE, &levels_left_out(n_left_out));
    }
    write_storeys(builder, merged, &mapped, &outcomes, frame);
    place_spaces(builder, &floors);
    set_bounds(builder, merged);
    mark_assumed_rooms(builder, &floors, &shafts, &faces);
    floors
}

/// Takes shafts out of the rooms: those that are named so, and those around a lift.
fn take_shafts(builder: &mut SiteBuilder, merged: &Merged, floors: &mut [Option<SpaceFloor>]) -> Vec<SpaceFloor> {
    let is_lift = |(element, record): &(&ifc::Element, &ElementRecord)| {
        is_a(element, "IfcTransportElement")
            && ["", "ELEVATOR", "NOTDEFINED"].contains(&element.predefined_type.as_str())
            && record.n_parts > 0
    };
    let elements = merged.model.elements.iter().zip(&builder.elements).filter(is_lift);
    let lifts: Vec<([i32; 3], [i32; 3])> = elements.map(|(_, e)| (e.min_tenths, e.max_tenths)).collect();
    let mut shafts = Vec::new();
    for (record, floor) in builder.spaces.iter_mut().zip(floors) {
        let heights = [record.floor_z_tenths, record.floor_z_tenths + record.height_tenths];
        let plan = floor.as_ref().and_then(|f| Some((f.polygon.bounds()?, f.area_m2, heights)));
        if plan.is_some_and(|plan| lifts.iter().any(|lift| holds_lift(plan, *lift))) {
            record.flags |= space_flags::SHAFT;
        }
        if record.has(space_flags::SHAFT) {
            shafts.extend(floor.take());
        }
    }
    shafts
}

fn find_storeys(
    builder: &SiteBuilder,
    merged: &Merged,
    (floors, faces): (&[Option<SpaceFloor>], &FloorFaces),
    frame: SiteFrame,
) -> (Vec<MapStorey>, Vec<StoreyOutcome>) {
    let rise = frame.map_from_world.translation_m()[2];
    let is_floor = |e: &(usize, &ElementRecord)| e.1.has(element_flags::FLOOR);
    let bodies = || builder.elements.iter().enumerate().filter(|(_, e)| e.n_parts > 0);
    let candidates: Vec<StoreyCandidate> = (0..merged.model.storeys.len())
        .map(|k| {
            let storey = &merged.model.storeys[k];
            let height = storey.placement_z_m.or(storey.elevation_m);
            let own = || bodies().filter(move |(_, e)| e.storey == k as u32);
            let (footings, floors): (Vec<_>, Vec<_>) =
                own().filter(is_floor).partition(|(_, e)| e.ground == GroundClass::Foundation);
            let tops = |elements: Vec<(usize, &ElementRecord)>| -> Vec<i32> {
                let mut tops: Vec<i32> = elements.iter().map(|(_, e)| e.max_tenths[2]).collect();
                tops.sort_unstable();
                tops
            };
            StoreyCandidate {
                placement_z: height.and_then(|z| tenths(z + rise)),
                n_elements: own().count(),
                bodies: own().map(|(_, e)| [e.min_tenths[2], e.max_tenths[2]]).collect(),
                own_floors: tops(floors),
                own_footings: tops(footings),
            }
        })
        .collect();
    let spaces: Vec<SpaceFloor> = floors.iter().flatten().cloned().collect();
    // Most curtain walls have no body of their own: their plates and members stand for them.
    let walls = bodies().filter(|(_, e)| matches!(e.class(), Class::Wall | Class::CurtainWall));
    let walls: Vec<[i32; 2]> = walls.map(|(_, e)| [e.min_tenths[2], e.max_tenths[2]]).collect();
    let lowest_body = bodies().map(|(_, e)| e.min_tenths[2]).min();
    map_storeys(&BuildingInputs { candidates: &candidates, spaces: &spaces, faces, lowest_body, walls: &walls })
}

/// Adds the levels of the storeys at other heights; returns how many there are beyond the number of maps.
fn find_levels(
    builder: &SiteBuilder,
    merged: &Merged,
    floors: &[Option<SpaceFloor>],
    mapped: &mut Vec<MapStorey>,
    outcomes: &[StoreyOutcome],
) -> usize {
    let elements = &merged.model.elements;
    let records = || builder.elements.iter().enumerate().filter(|(_, e)| e.n_parts > 0);
    let meshes = |e: &ElementRecord| builder.meshes(e.first_part, e.n_parts);
    let is_level = |k: usize, e: &ElementRecord| {
        e.has(element_flags::FLOOR)
            && !e.has(element_flags::VERTICAL)
            && e.ground != GroundClass::Foundation
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
    let map_storey_of = outcomes.iter().map(|outcome| match outcome {
        StoreyOutcome::Mapped(k) | StoreyOutcome::Joined(k) => Some(*k),
        StoreyOutcome::NotMapped(_) => None,
    });
    let around = LevelInputs {
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
    Diagnostic { severity: Severity::Warning, code: DiagnosticCode::LevelsLeftOut, entity: None, source: None, message }
}

/// Upward faces of all floor elements.
fn floor_faces_of(builder: &SiteBuilder) -> FloorFaces {
    let mut faces = FloorFaces::default();
    for element in builder.elements.iter().filter(|e| e.has(element_flags::FLOOR)) {
        let list = if element.ground == GroundClass::Foundation { &mut faces.footings } else { &mut faces.slabs };
        for mesh in builder.meshes(element.first_part, element.n_parts) {
            list.extend(upward_triangles(mesh, RobotProfile::DEFAULT.max_slope_rad));
        }
    }
    faces
}

fn write_storeys(
    builder: &mut SiteBuilder,
    merged: &Merged,
    mapped: &[MapStorey],
    outcomes: &[StoreyOutcome],
    frame: SiteFrame,
) {
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
            floor: storey.floor.into(),
            bounds_tenths: [0; 4],
        };
        builder.map_storeys.push(record);
    }
    let rise = frame.map_from_world.translation_m()[2];
    for ((storey, outcome), &source) in storeys.iter().zip(outcomes).zip(&merged.storey_source) {
        let (map_storey, why) = match outcome {
            StoreyOutcome::Mapped(k) => (*k as u32, String::new()),
            StoreyOutcome::Joined(k) => {
                (*k as u32, format!("its floor is that of {}", name_of(merged, mapped[*k].named_after)))
            }
            StoreyOutcome::NotMapped(why) => (NONE, (*why).to_owned()),
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

/// Plan bounds of the part of a body between two heights.
fn bounds_within(builder: &SiteBuilder, element: &ElementRecord, band: Slab) -> Option<Bounds> {
    if band.lo <= element.min_tenths[2] && element.max_tenths[2] <= band.hi {
        let [min, max] = [element.min_tenths, element.max_tenths].map(|c| [c[0], c[1]]);
        return Some(Bounds { min, max });
    }
    // The section of a solid ends at its faces, so that these are enough.
    let mut plan = Vec::new();
    let triangles = builder.meshes(element.first_part, element.n_parts).flat_map(MeshView::corners);
    triangles.fold(None, |bounds, triangle| {
        clip_to_slab(&triangle, band, &mut plan);
        let own = Bounds::of(plan.iter().copied());
        bounds.into_iter().chain(own).reduce(Bounds::joined)
    })
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

/// Plan bounds of each map storey: of what lies near its floor and of its spaces. Of terrain and roofs that is a part only, and of
/// terrain what lies around the rest: its own map is that of the ground outdoors.
fn set_bounds(builder: &mut SiteBuilder, merged: &Merged) {
    let is_terrain: Vec<bool> = merged.model.elements.iter().map(|e| is_a(e, "IfcGeographicElement")).collect();
    for k in 0..builder.map_storeys.len() {
        let floor_z = builder.map_storeys[k].floor_z_tenths;
        let band = Slab { lo: floor_z + BOUNDS_BELOW, hi: floor_z + BOUNDS_ABOVE };
        let near = |e: &&ElementRecord| e.n_parts > 0 && band.meets(e.min_tenths[2], e.max_tenths[2]);
        // Where nothing can be free, the ground around what stands there is of no use.
        let is_bare = builder.map_storeys[k].floor == FloorKind::Missing;
        let elements = |terrain: bool| builder.elements.iter().zip(&is_terrain).filter(move |(_, t)| **t == terrain);
        let bounds_of = |terrain: bool| {
            elements(terrain).map(|(e, _)| e).filter(near).filter_map(|e| bounds_within(builder, e, band))
        };
        let spaces = builder.spaces.iter().filter(|s| s.map_storey == k as u32).filter_map(|s| {
            let rings = &builder.rings[s.first_ring as usize..][..s.n_rings as usize];
            Bounds::of(
                rings
                    .iter()
                    .flat_map(|r| builder.points[r.first_point as usize..][..r.n_points as usize].iter().copied()),
            )
        });
        let built = bounds_of(false).chain(spaces).reduce(Bounds::joined);
        let terrain = bounds_of(true).filter(|_| !is_bare).reduce(Bounds::joined);
        let terrain = terrain.and_then(|terrain| built.map_or(Some(terrain), |built| around(terrain, built)));
        let bounds = built.into_iter().chain(terrain).reduce(Bounds::joined);
        let Bounds { min, max } = bounds.unwrap_or(Bounds { min: [0; 2], max: [0; 2] });
        builder.map_storeys[k].bounds_tenths = [min[0], min[1], max[0], max[1]];
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use messages::PartRecord;

    #[test]
    fn of_a_slope_only_what_lies_between_the_heights_bounds_a_storey() {
        let mut builder = SiteBuilder::default();
        // Rises by 10 m over 100 m along x, 50 m wide.
        builder.vertices.extend([[0, 0, 0], [1_000_000, 0, 100_000], [1_000_000, 500_000, 100_000], [0, 500_000, 0]]);
        builder.triangles.extend([[0, 1, 2], [0, 2, 3]]);
        builder.parts.push(PartRecord { n_vertices: 4, n_triangles: 2, ..bytemuck::Zeroable::zeroed() });
        let element =
            ElementRecord { n_parts: 1, max_tenths: [1_000_000, 500_000, 100_000], ..bytemuck::Zeroable::zeroed() };
        let bounds = |lo: i32, hi: i32| bounds_within(&builder, &element, Slab { lo, hi });
        let Bounds { min, max } = bounds(20_000, 40_000).unwrap();
        assert!((min[0] - 200_000).abs() < 20 && (max[0] - 400_000).abs() < 20, "{min:?} {max:?}");
        assert_eq!((min[1], max[1]), (0, 500_000));
        assert_eq!(bounds(-1, 100_001).unwrap(), Bounds { min: [0; 2], max: [1_000_000, 500_000] });
        assert_eq!(bounds(100_000, 110_000), None);
    }
}
