//! Slices the elements to the slab of a storey.

use super::assumed_floor::{assumed_floor_of, open_to_below, shafts_at};
use super::dependents::dependents;
use super::floor_faces::{LEVEL_SLOPE_RAD, floor_pieces};
use super::ground_patches::{ground_patches, level_faces, outdoor_patches};
use super::place::{Place, is_lasting};
use super::slice_count::{SliceCount, slab_of};
use crate::error::RasterizeError;
use crate::layers::floor::sides_with_floor;
use crate::model::cell_area::{cells_beside, to_tenths};
use crate::model::obstacle_squares::ObstacleSquares;
use crate::model::storey_slice::{
    MIN_STOREY_HEIGHT, Overhead, Passage, SpaceRuns, StoreySlice, next_floor_z, overhead_slab,
};
use frames::TENTHS_PER_M;
use geometry::{Bounds, Slab};
use grid::{CellRect, Class, GridSpec, Mask, covered_cells, overlapped_cells};
use messages::{
    ElementRecord, FloorKind, MAX_SILL_TENTHS, MapStoreyRecord, NONE, RobotProfile, Site, SpaceRecord, space_flags,
};

/// Width of unknown cells around the contents of a grid, so that planners see the end of the map.
const MARGIN: i32 = TENTHS_PER_M;

/// Cuts the elements of a map storey to its slab.
pub(crate) fn slice_storey(
    site: &Site<'_>,
    robot: &RobotProfile,
    resolution_m: f64,
    map_storey: usize,
    count: &SliceCount<'_>,
) -> Result<StoreySlice, RasterizeError> {
    let record = &site.map_storeys[map_storey];
    let spec = spec_of(site, record, resolution_m)?;
    let floor_z = record.floor_z_tenths;
    let slab = slab_of(record, robot);
    let Slab { lo, hi } = slab;
    let step = to_tenths(robot.step_height_m);
    let place = Place { site, robot, spec: &spec, map_storey };
    if record.floor == FloorKind::Ground {
        return Ok(slice_outdoors(place, record));
    }
    let (mut obstacles, footprints) = place.cut_elements(slab, |_| true, || count.sliced());
    let lidar_z = floor_z + to_tenths(robot.lidar_height_m);
    let (lidar, _) = place.cut_elements(Slab { lo: lidar_z, hi: lidar_z + 2 }, is_lasting, || {});
    // Elements of one class do not differ in a cell; a stable order keeps doors by element.
    obstacles.sort_by_key(|o| o.class.draw_priority());
    let mut storey = StoreySlice {
        obstacle_squares: ObstacleSquares::of(obstacles.iter().map(|o| o.rect), &spec),
        obstacles,
        lidar,
        footprints,
        floor: floor_pieces(site, &spec, [floor_z - step, floor_z + step], robot.max_slope_rad),
        floor_above: floor_pieces(site, &spec, [lo + 1, hi], LEVEL_SLOPE_RAD),
        spaces: spaces_of(site, &spec, map_storey),
        passages: passages_of(site, &spec, floor_z, hi),
        shafts: shafts_at(site, floor_z),
        overhead: overhead(site, record),
        ..StoreySlice::empty(map_storey, spec, record)
    };
    storey.assumed_floor = assumed_floor_of(site, robot, &storey);
    storey.assumed_runs = covered_cells(&storey.assumed_floor, &storey.spec);
    mark_beside_assumed(&mut storey);
    if storey.floor_kind == FloorKind::AssumedFromEnclosure {
        storey.open_to_below = open_to_below(site, &storey.spec, floor_z);
    }
    storey.ground = ground_patches(place, &storey);
    if !storey.ground.is_empty() {
        storey.level_faces = level_faces(place, floor_z);
    }
    let heights = Slab { lo: floor_z - MIN_STOREY_HEIGHT, hi: hi.max(next_floor_z(site, floor_z) + MIN_STOREY_HEIGHT) };
    storey.dependents = dependents(site, &storey, heights);
    Ok(storey)
}

/// Tells the passages at whose sides floor is assumed.
fn mark_beside_assumed(storey: &mut StoreySlice) {
    let StoreySlice { spec, assumed_runs, passages, .. } = storey;
    if assumed_runs.is_empty() {
        return;
    }
    let mut assumed = Mask::new(spec.width as usize, spec.height as usize);
    assumed.set_runs(assumed_runs);
    for passage in passages {
        passage.is_beside_assumed = sides_with_floor(&passage.plan, spec, |i| assumed.cells[i]) > 0;
    }
}

/// Cuts the ground outdoors: there is no level, and what stands on it is in the way by its height above the ground below it.
fn slice_outdoors(place: Place<'_>, record: &MapStoreyRecord) -> StoreySlice {
    let Place { site, map_storey, spec, .. } = place;
    let mut storey = StoreySlice {
        obstacle_squares: ObstacleSquares::of(std::iter::empty(), spec),
        ground: outdoor_patches(place),
        overhead: overhead(site, record),
        ..StoreySlice::empty(map_storey, *spec, record)
    };
    storey.dependents = dependents(site, &storey, overhead_slab(site, FloorKind::Ground, record.floor_z_tenths));
    storey
}

fn overhead(site: &Site<'_>, record: &MapStoreyRecord) -> Vec<Overhead> {
    let slab = overhead_slab(site, record.floor.get(), record.floor_z_tenths);
    let reaches = |e: &ElementRecord| e.n_parts > 0 && slab.meets(e.min_tenths[2], e.max_tenths[2]);
    let elements = site.elements.iter().zip(0..).filter(|(e, _)| reaches(e));
    elements.map(|(_, element)| Overhead::new(element)).collect()
}

fn spec_of(site: &Site<'_>, record: &MapStoreyRecord, resolution_m: f64) -> Result<GridSpec, RasterizeError> {
    let [x0, y0, x1, y1] = record.bounds_tenths;
    GridSpec::around(Bounds { min: [x0, y0], max: [x1, y1] }, MARGIN, resolution_m).map_err(|source| {
        let at_bounds = |e: &&ElementRecord| {
            e.n_parts > 0
                && (e.min_tenths[0] == x0 || e.min_tenths[1] == y0 || e.max_tenths[0] == x1 || e.max_tenths[1] == y1)
        };
        let name = |e: &ElementRecord| format!("{} {}", site.text(e.ifc_type), site.text(e.global_id));
        let is_outer_space = |s: &&SpaceRecord| {
            let corners = Bounds::of(site.floor_polygon(s).rings().flatten().copied());
            corners.is_some_and(|c| c.min[0] == x0 || c.min[1] == y0 || c.max[0] == x1 || c.max[1] == y1)
        };
        let space_name = |s: &SpaceRecord| format!("IfcSpace {}", site.text(s.global_id));
        let elements = site.elements.iter().filter(at_bounds).map(name);
        let spaces = site.spaces.iter().filter(is_outer_space).map(space_name);
        let outermost: Vec<String> = elements.chain(spaces).take(4).collect();
        RasterizeError::Spec { storey: site.text(record.name).to_owned(), outermost, source }
    })
}

fn spaces_of(site: &Site<'_>, spec: &GridSpec, map_storey: usize) -> Vec<SpaceRuns> {
    let on_storey = site.spaces.iter().enumerate().filter(|(_, s)| s.map_storey == map_storey as u32);
    let mut spaces: Vec<SpaceRuns> = on_storey
        .filter(|(_, s)| !s.has(space_flags::METADATA_ONLY))
        .map(|(k, s)| {
            let polygon = site.floor_polygon(s);
            let runs = overlapped_cells(&polygon, &[], spec);
            SpaceRuns { space: k as u32, rect: CellRect::around(&runs), runs, polygon }
        })
        .collect();
    let area = |s: &SpaceRuns| site.spaces[s.space as usize].area_m2;
    spaces.sort_by(|a, b| area(b).total_cmp(&area(a)).then(a.space.cmp(&b.space)));
    spaces
}

fn passages_of(site: &Site<'_>, spec: &GridSpec, floor_z: i32, top: i32) -> Vec<Passage> {
    let is_passage = |o: &&messages::OpeningRecord| {
        let filled_by_door = o.filling != NONE && site.elements[o.filling as usize].class() == Class::Door;
        let at_floor = o.bottom_z_tenths <= floor_z + MAX_SILL_TENTHS && o.top_z_tenths >= top;
        (o.filling == NONE || filled_by_door) && o.host != NONE && o.plan.half[0] > 0.0 && at_floor
    };
    let passage = |o: &messages::OpeningRecord| {
        let plan = o.plan.to_box();
        let area = geometry::union(&[plan.ring()], geometry::FillRule::NonZero);
        let runs = overlapped_cells(&area, &[], spec);
        let around = cells_beside(&plan, spec);
        Passage { host: o.host, plan, rect: CellRect::around(&runs), runs, around, is_beside_assumed: false }
    };
    site.openings.iter().filter(is_passage).map(passage).collect()
}
