//! Everything of a storey that does not depend on the date: runs of cells per element, space and passage.

use crate::RasterizeError;
use frames::{TENTHS_PER_M, metres};
use geometry::{Bounds, Footprint, MultiPolygon, OrientedBox, Ring, Slab, floor_faces, footprint};
use grid::{Class, GridSpec, Run, covered_cells, overlapped_cells};
use messages::{ElementRecord, MapStoreyRecord, NONE, RobotProfile, Site, element_flags, space_flags};
use rayon::prelude::*;
use std::sync::OnceLock;

/// Unknown cells around everything: a planner can see that the map ends.
const MARGIN: i32 = TENTHS_PER_M;

/// How far above the floor the sill of a passage may lie: a door's threshold.
const MAX_SILL: i32 = TENTHS_PER_M / 10;

/// An element that stands in a storey's slab.
#[derive(Debug)]
pub(crate) struct ElementRuns {
    pub(crate) element: u32,
    pub(crate) class: Class,
    pub(crate) runs: Vec<Run>,
}

/// Upward faces of an element within a step of the floor.
#[derive(Debug)]
pub(crate) struct FloorPiece {
    pub(crate) element: u32,
    pub(crate) rings: Vec<Ring>,
}

/// A space on the storey.
#[derive(Debug)]
pub(crate) struct SpaceRuns {
    pub(crate) space: u32,
    pub(crate) polygon: MultiPolygon,
    pub(crate) runs: Vec<Run>,
}

/// An opening through a wall at the height of the floor.
#[derive(Debug)]
pub(crate) struct Passage {
    pub(crate) host: u32,
    pub(crate) plan: OrientedBox,
    pub(crate) runs: Vec<Run>,
}

/// A map storey, cut.
#[derive(Debug)]
pub(crate) struct StoreyCut {
    pub(crate) map_storey: u32,
    pub(crate) spec: GridSpec,
    pub(crate) floor_z: i32,
    pub(crate) footprints: Vec<(u32, Footprint)>,
    pub(crate) obstacles: Vec<ElementRuns>,
    /// Sections of lasting elements at the lidar's height.
    pub(crate) lidar: Vec<ElementRuns>,
    pub(crate) floor: Vec<FloorPiece>,
    /// From the largest to the smallest: where spaces overlap the smaller wins.
    pub(crate) spaces: Vec<SpaceRuns>,
    pub(crate) passages: Vec<Passage>,
    /// Stairs, ramps, lifts and shafts that reach an assumed floor from below.
    pub(crate) from_below: MultiPolygon,
    /// Elements between this floor and the next.
    pub(crate) overhead: Vec<Overhead>,
    /// Elements whose state can change the storey's grid.
    pub(crate) near: Vec<u32>,
    /// Cells that floor covers when everything is built; made when somebody asks.
    complete_floor: OnceLock<Vec<Run>>,
}

/// An element between this floor and the next, in plan: where nobody must be while it is worked on.
#[derive(Debug)]
pub(crate) struct Overhead {
    pub(crate) element: u32,
    /// Made when it is worked on for the first time.
    runs: OnceLock<Vec<Run>>,
}

/// The next floor is at least this high above: what is nearer is another level of the same storey.
const LEAST_STOREY_HEIGHT: i32 = 2 * TENTHS_PER_M;

/// Bottom and top of the slab above the floor, in tenths of a millimetre.
pub(crate) fn slab_above_floor(robot: &RobotProfile) -> [i32; 2] {
    robot.slab_m().map(to_tenths)
}

/// A robot's measure in tenths of a millimetre.
pub(crate) fn to_tenths(metres: f64) -> i32 {
    frames::tenths(metres).unwrap_or(i32::MAX / 4)
}

impl StoreyCut {
    pub(crate) fn new(
        site: &Site<'_>,
        robot: &RobotProfile,
        resolution_m: f64,
        map_storey: usize,
    ) -> Result<Self, RasterizeError> {
        let record = &site.map_storeys[map_storey];
        let spec = spec_of(site, record, resolution_m)?;
        let floor_z = record.floor_z_tenths;
        let [lo, hi] = slab_above_floor(robot).map(|h| floor_z + h);
        let footprints = cut_elements(site, Slab { lo, hi }, |_| true);
        let lidar_z = floor_z + to_tenths(robot.lidar_height_m);
        let lidar = cut_elements(site, Slab { lo: lidar_z, hi: lidar_z + 2 }, is_lasting);
        let runs_of = |cuts: &[(u32, Footprint)]| cuts.par_iter().map(|c| element_runs(site, &spec, c)).collect();
        Ok(Self {
            map_storey: map_storey as u32,
            spec,
            floor_z,
            obstacles: runs_of(&footprints),
            lidar: runs_of(&lidar),
            footprints,
            floor: floor_pieces(site, floor_z, robot),
            spaces: spaces_of(site, &spec, map_storey),
            passages: passages_of(site, &spec, floor_z, hi),
            from_below: from_below(site, floor_z),
            overhead: overhead(site, floor_z),
            near: near(site, floor_z),
            complete_floor: OnceLock::new(),
        })
    }

    /// The plan of an element between this floor and the next.
    pub(crate) fn overhead_runs<'s>(&'s self, site: &Site<'_>, overhead: &'s Overhead) -> &'s [Run] {
        overhead.runs.get_or_init(|| {
            let slab = Slab { lo: self.floor_z, hi: next_floor_z(site, self.floor_z) };
            let plan = footprint(site.element_meshes(&site.elements[overhead.element as usize]), slab);
            overlapped_cells(&plan.area, &plan.lines, &self.spec)
        })
    }

    /// Cells that floor covers whole when everything is built, of a storey whose floor is not assumed.
    pub(crate) fn complete_floor(&self) -> &[Run] {
        self.complete_floor.get_or_init(|| covered_cells(&crate::floor::plan_of(&self.floor, |_| true), &self.spec))
    }
}

/// Height of the floor above, or of everything.
fn next_floor_z(site: &Site<'_>, floor_z: i32) -> i32 {
    let above = site.map_storeys.iter().map(|s| s.floor_z_tenths).filter(|z| *z >= floor_z + LEAST_STOREY_HEIGHT);
    let top = site.elements.iter().filter(|e| e.n_parts > 0).map(|e| e.max_tenths[2]).max();
    above.min().or(top).unwrap_or(floor_z).max(floor_z + LEAST_STOREY_HEIGHT)
}

/// Elements from a storey below what counts as floor to above what is overhead: rather too many than too few.
fn near(site: &Site<'_>, floor_z: i32) -> Vec<u32> {
    let slab = Slab { lo: floor_z - LEAST_STOREY_HEIGHT, hi: next_floor_z(site, floor_z) + LEAST_STOREY_HEIGHT };
    let reaches = |e: &ElementRecord| e.n_parts > 0 && slab.meets(e.min_tenths[2], e.max_tenths[2]);
    site.elements.iter().zip(0..).filter(|(e, _)| reaches(e)).map(|(_, element)| element).collect()
}

fn overhead(site: &Site<'_>, floor_z: i32) -> Vec<Overhead> {
    let slab = Slab { lo: floor_z, hi: next_floor_z(site, floor_z) };
    let reaches = |e: &ElementRecord| e.n_parts > 0 && slab.meets(e.min_tenths[2], e.max_tenths[2]);
    let elements = site.elements.iter().zip(0..).filter(|(e, _)| reaches(e));
    elements.map(|(_, element)| Overhead { element, runs: OnceLock::new() }).collect()
}

fn spec_of(site: &Site<'_>, record: &MapStoreyRecord, resolution_m: f64) -> Result<GridSpec, RasterizeError> {
    let [x0, y0, x1, y1] = record.bounds_tenths;
    GridSpec::around(Bounds { min: [x0, y0], max: [x1, y1] }, MARGIN, resolution_m).map_err(|source| {
        let at_bounds = |e: &&ElementRecord| {
            e.n_parts > 0
                && (e.min_tenths[0] == x0 || e.min_tenths[1] == y0 || e.max_tenths[0] == x1 || e.max_tenths[1] == y1)
        };
        let name = |e: &ElementRecord| format!("{} {}", site.text(e.ifc_type), site.text(e.global_id));
        let outermost: Vec<String> = site.elements.iter().filter(at_bounds).take(4).map(name).collect();
        RasterizeError::Spec { storey: site.text(record.name).to_owned(), outermost: outermost.join(", "), source }
    })
}

/// Footprints in a slab of the elements that reach into it, by element.
fn cut_elements(site: &Site<'_>, slab: Slab, wanted: impl Fn(&ElementRecord) -> bool + Sync) -> Vec<(u32, Footprint)> {
    let reaches = |e: &ElementRecord| e.n_parts > 0 && slab.meets(e.min_tenths[2], e.max_tenths[2]);
    site.elements
        .par_iter()
        .enumerate()
        .filter(|(_, e)| reaches(e) && wanted(e))
        .map(|(k, e)| (k as u32, footprint(site.element_meshes(e), slab)))
        .filter(|(_, f)| !f.is_empty())
        .collect()
}

/// Finished structure that a lidar sees.
fn is_lasting(element: &ElementRecord) -> bool {
    let class = matches!(
        element.class(),
        Class::Wall | Class::Column | Class::CurtainWall | Class::Stair | Class::Ramp | Class::Slab
    );
    class && !element.has(element_flags::GLASS)
}

fn element_runs(site: &Site<'_>, spec: &GridSpec, (element, footprint): &(u32, Footprint)) -> ElementRuns {
    ElementRuns {
        element: *element,
        class: site.elements[*element as usize].class(),
        runs: overlapped_cells(&footprint.area, &footprint.lines, spec),
    }
}

fn floor_pieces(site: &Site<'_>, floor_z: i32, robot: &RobotProfile) -> Vec<FloorPiece> {
    let step = to_tenths(robot.step_height_m);
    let pieces = site.elements.iter().enumerate().filter(|(_, e)| e.has(element_flags::FLOOR)).map(|(k, e)| {
        let faces = |mesh| floor_faces(mesh, floor_z - step, floor_z + step, robot.max_slope_rad);
        FloorPiece { element: k as u32, rings: site.element_meshes(e).flat_map(faces).collect() }
    });
    pieces.filter(|p| !p.rings.is_empty()).collect()
}

fn spaces_of(site: &Site<'_>, spec: &GridSpec, map_storey: usize) -> Vec<SpaceRuns> {
    let on_storey = site.spaces.iter().enumerate().filter(|(_, s)| s.map_storey == map_storey as u32);
    let mut spaces: Vec<SpaceRuns> = on_storey
        .filter(|(_, s)| !s.has(space_flags::METADATA_ONLY))
        .map(|(k, s)| {
            let polygon = site.floor_polygon(s);
            SpaceRuns { space: k as u32, runs: overlapped_cells(&polygon, &[], spec), polygon }
        })
        .collect();
    let area = |s: &SpaceRuns| site.spaces[s.space as usize].area_m2;
    spaces.sort_by(|a, b| area(b).total_cmp(&area(a)).then(a.space.cmp(&b.space)));
    spaces
}

fn passages_of(site: &Site<'_>, spec: &GridSpec, floor_z: i32, top: i32) -> Vec<Passage> {
    let is_passage = |o: &&messages::OpeningRecord| {
        let filled_by_door = o.filling != NONE && site.elements[o.filling as usize].class() == Class::Door;
        let at_floor = o.bottom_z_tenths <= floor_z + MAX_SILL && o.top_z_tenths >= top;
        (o.filling == NONE || filled_by_door) && o.host != NONE && o.plan.half[0] > 0.0 && at_floor
    };
    let passage = |o: &messages::OpeningRecord| {
        let plan = o.plan.to_box();
        let area = geometry::union(&[plan.ring()], geometry::FillRule::NonZero);
        Passage { host: o.host, plan, runs: overlapped_cells(&area, &[], spec) }
    };
    site.openings.iter().filter(is_passage).map(passage).collect()
}

/// What is no floor although a space covers it: stairs, ramps, lifts and shafts from the storey below.
fn from_below(site: &Site<'_>, floor_z: i32) -> MultiPolygon {
    let half_metre = TENTHS_PER_M / 2;
    let reaches = |bottom: i32, top: i32| bottom < floor_z - half_metre && floor_z - half_metre < top;
    let stairs = site
        .elements
        .iter()
        .filter(|e| e.has(element_flags::VERTICAL) && e.n_parts > 0 && reaches(e.min_tenths[2], e.max_tenths[2]))
        .map(|e| footprint(site.element_meshes(e), Slab { lo: e.min_tenths[2], hi: e.max_tenths[2] }).area);
    let shafts = site
        .spaces
        .iter()
        .filter(|s| !s.has(space_flags::METADATA_ONLY) && reaches(s.floor_z_tenths, s.floor_z_tenths + s.height_tenths))
        .filter(|s| s.floor_z_tenths + s.height_tenths > floor_z + half_metre)
        .map(|s| site.floor_polygon(s));
    geometry::union_of(&stairs.chain(shafts).collect::<Vec<_>>())
}

/// Metres of a length in tenths of a millimetre, in cells.
pub(crate) fn cells_of(spec: &GridSpec, metres_m: f64) -> f64 {
    metres_m / metres(spec.cell_tenths)
}
