//! Finds the ground that leads from the floor of a storey to other heights, and cuts what stands on it.
//!
//! A face belongs to a storey if one gets to it from the storey's floor over steps that the robot takes, at most as far up and down
//! as the next floors. That is decided for the complete model, on cells (`surface_joins.rs`): two surfaces meet where their heights in a
//! cell, or at the border of two cells, differ by a step at most. For a robot that drives on stairs each tread is such a face, and a
//! riser a step.

use super::place::{Place, is_lasting};
use super::surface_joins::{SurfaceJoins, Walked};
use crate::model::cell_area::{cells_around, slab_above_floor, to_tenths};
use crate::model::element_runs::ElementRuns;
use crate::model::ground_patch::{GroundPatch, LevelFace, z_at};
use crate::model::obstacle_squares::ObstacleSquares;
use crate::model::storey_slice::{MIN_STOREY_HEIGHT, StoreySlice};
use frames::TENTHS_PER_M;
use geometry::{
    Bounds, DisjointSets, FillRule, MeshView, MultiPolygon, Plane, Ring, Slab, SlabCut, Tread, clip_to_slab,
    ring_area_doubled, treads, union, upward_triangles,
};
use grid::{CellRect, GridSpec, Run, grown_runs, overlapped_cells};
use ground::upward_faces;
use messages::{ElementRecord, FloorKind, GroundClass, MAX_RISER_M, NONE, element_flags};
use rayon::prelude::*;
use std::collections::HashMap;

/// How far beside a patch obstacles are looked for that bound the way: half a metre.
const BESIDE: i32 = TENTHS_PER_M / 2;

/// The patches of a storey whose floor is built, by element.
pub(super) fn ground_patches(place: Place<'_>, storey: &StoreySlice) -> Vec<GroundPatch> {
    if !matches!(storey.floor_kind, FloorKind::Built | FloorKind::AssumedFromSpaces) {
        return Vec::new();
    }
    let near: Vec<Drawn> = drawn(near_floor(candidates(place, storey.floor_z), place, storey.floor_z), place.spec);
    if near.is_empty() {
        return Vec::new();
    }
    let rings: Vec<Ring> = storey.floor.iter().flat_map(|piece| piece.rings.iter().cloned()).collect();
    let cells = overlapped_cells(&union(&rings, FillRule::NonZero), &[], place.spec);
    let level = Walked { plane: Plane::level(storey.floor_z), cells: &cells, is_tread: false, is_seed: true };
    let kept = joined(near, 0, Some(level), place);
    patches(kept, place, |_| true)
}

/// The patches of the ground outdoors: of terrain and roads, and of floor to which one gets from there.
pub(super) fn outdoor_patches(place: Place<'_>) -> Vec<GroundPatch> {
    let Place { site, robot, spec, .. } = place;
    let all = Slab { lo: i32::MIN / 2, hi: i32::MAX / 2 };
    let faces = |meshes: Vec<MeshView<'_>>, class: GroundClass| -> Vec<[[i32; 3]; 3]> {
        let is_terrain = class == GroundClass::Terrain;
        let limit = if is_terrain { robot.terrain_slope_rad() } else { robot.max_slope_rad } + SLOPE_TOLERANCE_RAD;
        let faces = meshes.into_iter().flat_map(|mesh| upward_faces(mesh, class));
        faces.filter(|(_, slope_rad)| f64::from(*slope_rad) <= limit).map(|(triangle, _)| triangle).collect()
    };
    let mut earth = Vec::new();
    for (record, element) in
        site.elements.iter().zip(0..).filter(|(e, _)| e.ground.get().is_outdoors() && e.n_parts > 0)
    {
        let faces = faces(site.element_meshes(record).collect(), record.ground.get());
        add_by_plane(&mut earth, (element, record.min_tenths), faces.into_iter(), all);
    }
    for record in site.terrains.iter().filter(|t| t.ground.get().is_outdoors()) {
        let faces = faces(site.terrain_meshes(record).collect(), record.ground.get());
        add_by_plane(&mut earth, (NONE, record.min_tenths), faces.into_iter(), all);
    }
    let mut surfaces = drawn(earth, spec);
    let n_earth = surfaces.len();
    let is_floor = |k: usize| {
        let class = site.elements[k].ground.get();
        class.is_floor_of_maps() && class != GroundClass::Foundation && !class.is_outdoors()
    };
    let floors = faces_by_plane(place, all, |_| true).into_iter().filter(|c| is_floor(c.element as usize));
    surfaces.extend(drawn(floors.chain(tread_faces(place, all)).collect(), spec));
    // What is terrain itself is no obstacle on terrain: where it is too steep or breaks off there is no floor.
    patches(joined(surfaces, n_earth, None, place), place, |record| !record.ground.get().is_outdoors())
}

/// Slopes are computed from vertices that were rounded to tenths of a millimetre.
const SLOPE_TOLERANCE_RAD: f64 = 1e-3;

/// Faces in one plane, not known yet to belong to the storey.
struct Candidate {
    element: u32,
    is_tread: bool,
    plane: Plane,
    rings: Vec<Ring>,
    bounds: Bounds,
    z: [i32; 2],
}

/// Heights between which ground belongs to a storey: as far as the floors of the next ones.
fn reach_of(place: Place<'_>, floor_z: i32) -> Slab {
    let step = to_tenths(place.robot.step_height_m);
    let others = || place.site.levels().map(|(_, s)| s.floor_z_tenths).filter(|z| (z - floor_z).abs() > step);
    let below = others().filter(|&z| z < floor_z).max();
    let above = others().filter(|&z| z > floor_z).min();
    // Where no storey follows, as high as one could be.
    Slab { lo: below.unwrap_or(floor_z - 2 * MIN_STOREY_HEIGHT), hi: above.unwrap_or(floor_z + 2 * MIN_STOREY_HEIGHT) }
}

/// The faces within reach that a robot may stand on, by plane, without those that are level with a floor.
fn candidates(place: Place<'_>, floor_z: i32) -> Vec<Candidate> {
    let step = to_tenths(place.robot.step_height_m);
    let floors: Vec<i32> = place.site.levels().map(|(_, s)| s.floor_z_tenths).collect();
    let is_level_with_a_floor = |[lo, hi]: [i32; 2]| floors.iter().any(|z| z - step <= lo && hi <= z + step);
    let reach = reach_of(place, floor_z);
    let mut found = faces_by_plane(place, reach, |z| !is_level_with_a_floor(z));
    found.extend(tread_faces(place, reach));
    found
}

/// The treads between two heights of stairs, for a robot that drives on them: each is floor of its own.
fn tread_faces(place: Place<'_>, heights: Slab) -> Vec<Candidate> {
    let Place { site, robot, .. } = place;
    if !robot.drives_on_stairs() {
        return Vec::new();
    }
    let stairs = site.elements.iter().zip(0..).filter(|(e, _)| {
        e.ground == GroundClass::StairTread && e.n_parts > 0 && heights.meets(e.min_tenths[2], e.max_tenths[2])
    });
    let of_stair = |(record, element): (&ElementRecord, u32)| {
        let treads = treads(site.element_meshes(record)).into_iter();
        let within = treads.filter(|tread| heights.lo <= tread.z && tread.z <= heights.hi);
        within.filter_map(move |tread| tread_candidate(element, &tread)).collect::<Vec<_>>()
    };
    stairs.flat_map(of_stair).collect()
}

fn tread_candidate(element: u32, tread: &Tread) -> Option<Candidate> {
    let rings: Vec<Ring> = tread.plan.rings().cloned().collect();
    let bounds = Bounds::of(rings.iter().flatten().copied())?;
    Some(Candidate { element, is_tread: true, plane: Plane::level(tread.z), rings, bounds, z: [tread.z; 2] })
}

/// Greatest difference of height between two surfaces of which one is reached from the other: a step of the robot, on a stair a riser.
fn climb(place: Place<'_>, of_stair: bool) -> i32 {
    let step = to_tenths(place.robot.step_height_m);
    if of_stair { step.max(to_tenths(MAX_RISER_M)) } else { step }
}

/// Floor within a step of the floor of a storey.
pub(super) fn level_faces(place: Place<'_>, floor_z: i32) -> Vec<LevelFace> {
    let step = to_tenths(place.robot.step_height_m);
    // The slab's faces lie half a unit inside its bounds: one unit more includes both heights.
    let faces = faces_by_plane(place, Slab { lo: floor_z - step - 1, hi: floor_z + step + 1 }, |_| true);
    let level_face = |face: Candidate| {
        let cells = overlapped_cells(&union(&face.rings, FillRule::NonZero), &[], place.spec);
        Some(LevelFace { element: face.element, plane: face.plane, rect: CellRect::around(&cells)?, cells })
    };
    faces.into_par_iter().filter_map(level_face).collect()
}

/// Parts between two heights of the faces that a robot may stand on, by element and plane; `wanted` is asked with the heights of each.
fn faces_by_plane(place: Place<'_>, heights: Slab, wanted: impl Fn([i32; 2]) -> bool) -> Vec<Candidate> {
    let Place { site, robot, .. } = place;
    let elements = site.elements.iter().zip(0..).filter(|(e, _)| {
        e.has(element_flags::FLOOR) && e.n_parts > 0 && heights.meets(e.min_tenths[2], e.max_tenths[2])
    });
    let mut found = Vec::new();
    for (record, element) in elements {
        let faces = site.element_meshes(record).flat_map(|mesh| upward_triangles(mesh, robot.max_slope_rad));
        add_by_plane(&mut found, (element, record.min_tenths), faces.filter(|t| wanted(z_range(t))), heights);
    }
    found
}

/// Adds the parts between two heights of faces of a body, those in one plane as one candidate.
fn add_by_plane(
    found: &mut Vec<Candidate>,
    (element, min_tenths): (u32, [i32; 3]),
    faces: impl Iterator<Item = [[i32; 3]; 3]>,
    heights: Slab,
) {
    let mut by_plane: HashMap<[i64; 3], usize> = HashMap::new();
    let origin = [min_tenths[0], min_tenths[1]].map(f64::from);
    let mut plan = Vec::new();
    for triangle in faces {
        let z = z_range(&triangle);
        if !heights.meets(z[0], z[1]) {
            continue;
        }
        clip_to_slab(&triangle, heights, &mut plan);
        let Some(bounds) = Bounds::of(plan.iter().copied()).filter(|_| ring_area_doubled(&plan) > 0) else {
            continue;
        };
        let plane = Plane::of(&triangle);
        let at = *by_plane.entry(plane.key(origin)).or_insert_with(|| {
            found.push(Candidate { element, is_tread: false, plane, rings: Vec::new(), bounds, z });
            found.len() - 1
        });
        let candidate = &mut found[at];
        candidate.bounds = candidate.bounds.joined(bounds);
        candidate.z = [candidate.z[0].min(z[0]), candidate.z[1].max(z[1])];
        candidate.rings.push(plan.clone());
    }
}

fn z_range(triangle: &[[i32; 3]; 3]) -> [i32; 2] {
    let z = triangle.map(|v| v[2]);
    [z[0].min(z[1]).min(z[2]), z[0].max(z[1]).max(z[2])]
}

/// Those that a chain of boxes that touch joins to the height of the floor: few are left where the floor is level.
fn near_floor(candidates: Vec<Candidate>, place: Place<'_>, floor_z: i32) -> Vec<Candidate> {
    let step = to_tenths(place.robot.step_height_m);
    let cell = place.spec.cell_tenths;
    let is_seed = |c: &Candidate| {
        let near = climb(place, c.is_tread) + step;
        c.z[0] <= floor_z + near && floor_z - near <= c.z[1]
    };
    let (mut near, mut rest): (Vec<Candidate>, Vec<Candidate>) = candidates.into_iter().partition(is_seed);
    let mut at = 0;
    while at < near.len() {
        let Candidate { bounds, z, is_tread, .. } = near[at];
        let around = Bounds { min: bounds.min.map(|c| c - 2 * cell), max: bounds.max.map(|c| c + 2 * cell) };
        let touches = |other: &Candidate| {
            let most = climb(place, is_tread || other.is_tread);
            around.meets(&other.bounds) && other.z[0] <= z[1] + most && z[0] - most <= other.z[1]
        };
        let (found, left): (Vec<_>, Vec<_>) = rest.into_iter().partition(touches);
        near.extend(found);
        rest = left;
        at += 1;
    }
    near
}

/// A candidate with its area in plan and the cells that it overlaps.
struct Drawn {
    element: u32,
    is_tread: bool,
    plane: Plane,
    area: MultiPolygon,
    cells: Vec<Run>,
}

fn drawn(candidates: Vec<Candidate>, spec: &GridSpec) -> Vec<Drawn> {
    let drawn = |candidate: Candidate| {
        let Candidate { element, is_tread, plane, rings, .. } = candidate;
        let area = union(&rings, FillRule::NonZero);
        let cells = overlapped_cells(&area, &[], spec);
        (!cells.is_empty()).then_some(Drawn { element, is_tread, plane, area, cells })
    };
    candidates.into_par_iter().filter_map(drawn).collect()
}

/// The first `n_seeds` surfaces, and those that cells join to them or to the level of the storey.
fn joined(mut surfaces: Vec<Drawn>, n_seeds: usize, level: Option<Walked<'_>>, place: Place<'_>) -> Vec<Drawn> {
    // The last of the sets is the level of the storey, and what is of it from the beginning.
    let floor = surfaces.len() as u32;
    let mut sets = DisjointSets::new(surfaces.len() + 1);
    (0..n_seeds as u32).for_each(|seed| sets.join(seed, floor));
    let walked = surfaces.iter().enumerate().map(|(k, Drawn { plane, cells, is_tread, .. })| Walked {
        plane: *plane,
        cells,
        is_tread: *is_tread,
        is_seed: k < n_seeds,
    });
    let walked: Vec<Walked<'_>> = walked.chain(level).collect();
    let climb = [false, true].map(|of_stair| climb(place, of_stair));
    SurfaceJoins { surfaces: &walked, spec: place.spec, climb }.join(&mut sets);
    let floor = sets.first(floor);
    let mut numbers = 0..;
    surfaces.retain(|_| numbers.next().is_some_and(|k| sets.first(k) == floor));
    surfaces
}

/// The patches of surfaces; what is `in_the_way` on them by its kind is cut.
fn patches(surfaces: Vec<Drawn>, place: Place<'_>, in_the_way: impl Fn(&ElementRecord) -> bool) -> Vec<GroundPatch> {
    let Place { site, spec, .. } = place;
    let corners = |e: &ElementRecord| [e.min_tenths, e.max_tenths].map(|c| [c[0], c[1]].map(f64::from));
    let rect = |e: &ElementRecord| {
        let is_there = e.n_parts > 0 && in_the_way(e);
        if is_there { cells_around(corners(e).into_iter(), 0.0, spec) } else { None }
    };
    let elements = ObstacleSquares::of(site.elements.iter().map(rect), spec);
    surfaces.into_par_iter().map(|surface| patch(surface, place, &elements)).collect()
}

/// Cuts what stands above a surface and beside it.
fn patch(surface: Drawn, place: Place<'_>, elements: &ObstacleSquares) -> GroundPatch {
    let Drawn { element, is_tread, plane, area, cells } = surface;
    let Place { site, robot, spec, .. } = place;
    let beside = BESIDE.unsigned_abs().div_ceil(spec.cell_tenths.unsigned_abs());
    let around = grown_runs(&cells, beside, &CellRect::whole(spec.width, spec.height));
    let rect = CellRect::around(&around).unwrap_or(CellRect { min: [0; 2], max: [0; 2] });
    let corners = [0, 1, 2, 3].map(|k| {
        let corner = |axis: usize, is_high: bool| f64::from(if is_high { rect.max[axis] } else { rect.min[axis] });
        z_at(&plane, [corner(0, k & 1 == 1), corner(1, k & 2 == 2)], spec)
    });
    let [low, high] =
        [corners.into_iter().fold(f64::INFINITY, f64::min), corners.into_iter().fold(f64::NEG_INFINITY, f64::max)];
    let mut near: Vec<u32> = elements.around(rect).collect();
    near.sort_unstable();
    near.dedup();
    let cut = |slab: Slab, wanted: &dyn Fn(&ElementRecord) -> bool| -> Vec<ElementRuns> {
        let reaches = |e: &ElementRecord| {
            let (lo, hi) = (low + f64::from(slab.lo), high + f64::from(slab.hi));
            f64::from(e.min_tenths[2]) <= hi && lo <= f64::from(e.max_tenths[2])
        };
        let records = near.iter().map(|&element| (element, &site.elements[element as usize]));
        let mut found: Vec<ElementRuns> = records
            .filter(|(_, record)| reaches(record) && wanted(record))
            .filter_map(|(element, record)| {
                let parts: Vec<(Vec<[i32; 3]>, MeshView<'_>)> =
                    site.element_meshes(record).map(|mesh| (plane.heights_above(mesh.vertices), mesh)).collect();
                let above = parts.iter().map(|(vertices, mesh)| MeshView { vertices, ..*mesh });
                let own = place.element_runs(element, &SlabCut::of(above, slab), Some((&plane, &around)));
                (!own.runs.is_empty()).then_some(own)
            })
            .collect();
        found.sort_by_key(|o| o.class.draw_priority());
        found
    };
    let [lo, hi] = slab_above_floor(robot);
    let lidar_z = to_tenths(robot.lidar_height_m);
    let (obstacles, lidar) = (cut(Slab { lo, hi }, &|_| true), cut(Slab { lo: lidar_z, hi: lidar_z + 2 }, &is_lasting));
    let stands = obstacles.iter().chain(&lidar).filter_map(|element| element.rect);
    GroundPatch {
        element,
        is_outdoors: site.elements.get(element as usize).is_none_or(|e| e.ground.get().is_outdoors()),
        climb: climb(place, is_tread),
        is_tread,
        plane,
        stands: CellRect::around_all(stands),
        obstacles,
        lidar,
        area,
        cells,
        rect,
    }
}
