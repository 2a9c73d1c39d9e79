//! Everything of a storey that does not depend on the date: runs of cells per element, space and passage.

use crate::RasterizeError;
use crate::doors::DoorAt;
use crate::gaps;
use crate::near::{Near, near};
use frames::TENTHS_PER_M;
use geometry::{Bounds, Footprint, MultiPolygon, OrientedBox, Ring, Slab, floor_faces, footprint};
use grid::{CellRect, Class, GridSpec, Run, covered_cells, overlapped_cells};
use messages::{
    ElementRecord, FloorKind, MapStoreyRecord, NONE, RobotProfile, Site, SpaceRecord, element_flags, space_flags,
};
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
    /// Around the runs.
    pub(crate) rect: Option<CellRect>,
    pub(crate) door: Option<DoorAt>,
}

/// Upward faces of an element within a step of the floor.
#[derive(Debug)]
pub(crate) struct FloorPiece {
    pub(crate) element: u32,
    pub(crate) rings: Vec<Ring>,
    /// Cells that they can reach.
    pub(crate) rect: Option<CellRect>,
}

/// A space on the storey.
#[derive(Debug)]
pub(crate) struct SpaceRuns {
    pub(crate) space: u32,
    pub(crate) polygon: MultiPolygon,
    pub(crate) runs: Vec<Run>,
    /// Around the runs.
    pub(crate) rect: Option<CellRect>,
}

/// An opening through a wall at the height of the floor.
#[derive(Debug)]
pub(crate) struct Passage {
    pub(crate) host: u32,
    pub(crate) plan: OrientedBox,
    pub(crate) runs: Vec<Run>,
    /// Around the runs.
    pub(crate) rect: Option<CellRect>,
    /// Cells in which floor is looked for.
    pub(crate) around: Option<CellRect>,
}

/// A map storey, cut.
#[derive(Debug)]
pub(crate) struct StoreyCut {
    pub(crate) map_storey: u32,
    pub(crate) spec: GridSpec,
    pub(crate) floor_z: i32,
    pub(crate) floor_kind: FloorKind,
    pub(crate) footprints: Vec<(u32, Footprint)>,
    /// From the class that is drawn first to that which is drawn over all others.
    pub(crate) obstacles: Vec<ElementRuns>,
    /// Sections of lasting elements at the lidar's height.
    pub(crate) lidar: Vec<ElementRuns>,
    pub(crate) floor: Vec<FloorPiece>,
    /// Upward faces in the slab: floor of another level, in the robot's way.
    pub(crate) floor_above: Vec<FloorPiece>,
    /// From the largest to the smallest: where spaces overlap the smaller wins.
    pub(crate) spaces: Vec<SpaceRuns>,
    pub(crate) passages: Vec<Passage>,
    /// Cells of the floor that is assumed from spaces; none on a storey of another kind.
    pub(crate) assumed_floor: Vec<Run>,
    /// Elements between this floor and the next.
    pub(crate) overhead: Vec<Overhead>,
    /// Elements whose state can change the storey's grid, and where.
    pub(crate) near: Vec<Near>,
}

/// An element between this floor and the next, in plan: where nobody must be while it is worked on.
#[derive(Debug)]
pub(crate) struct Overhead {
    pub(crate) element: u32,
    /// Its cells and the rectangle around them, made when it is worked on for the first time.
    cells: OnceLock<(Vec<Run>, Option<CellRect>)>,
}

/// Floor in the robot's way that is steeper than this is part of a ramp or of a roof, and no other level.
const LEVEL_SLOPE_RAD: f64 = 0.01;

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
        let step = to_tenths(robot.step_height_m);
        let footprints = cut_elements(site, Slab { lo, hi }, |_| true);
        let lidar_z = floor_z + to_tenths(robot.lidar_height_m);
        let lidar = cut_elements(site, Slab { lo: lidar_z, hi: lidar_z + 2 }, is_lasting);
        let runs_of = |cuts: &[(u32, Footprint)]| -> Vec<ElementRuns> {
            cuts.par_iter().map(|c| element_runs(site, robot, &spec, map_storey, c)).collect()
        };
        let mut obstacles = runs_of(&footprints);
        // Elements of one class do not differ in a cell; a stable order keeps doors by element.
        obstacles.sort_by_key(|o| o.class.draw_priority());
        let mut storey = Self {
            map_storey: map_storey as u32,
            spec,
            floor_z,
            floor_kind: FloorKind::from_id(record.floor).unwrap_or(FloorKind::Built),
            obstacles,
            lidar: runs_of(&lidar),
            footprints,
            floor: floor_pieces(site, &spec, [floor_z - step, floor_z + step], robot.max_slope_rad),
            floor_above: floor_pieces(site, &spec, [lo + 1, hi], LEVEL_SLOPE_RAD),
            spaces: spaces_of(site, &spec, map_storey),
            passages: passages_of(site, &spec, floor_z, hi),
            assumed_floor: Vec::new(),
            overhead: overhead(site, floor_z),
            near: Vec::new(),
        };
        if storey.floor_kind == FloorKind::AssumedFromSpaces {
            storey.assumed_floor = assumed_floor(site, robot, &storey);
        }
        let heights =
            Slab { lo: floor_z - LEAST_STOREY_HEIGHT, hi: hi.max(next_floor_z(site, floor_z) + LEAST_STOREY_HEIGHT) };
        storey.near = near(site, &storey, heights);
        Ok(storey)
    }

    /// All cells.
    pub(crate) fn whole(&self) -> CellRect {
        CellRect::whole(self.spec.width, self.spec.height)
    }

    /// The plan of an element between this floor and the next, by its place in [`Self::overhead`].
    pub(crate) fn overhead_runs(&self, site: &Site<'_>, place: u32) -> &[Run] {
        &self.overhead_cells(site, place).0
    }

    /// The rectangle around it.
    pub(crate) fn overhead_rect(&self, site: &Site<'_>, place: u32) -> Option<CellRect> {
        self.overhead_cells(site, place).1
    }

    fn overhead_cells(&self, site: &Site<'_>, place: u32) -> &(Vec<Run>, Option<CellRect>) {
        let overhead = &self.overhead[place as usize];
        overhead.cells.get_or_init(|| {
            let slab = Slab { lo: self.floor_z, hi: next_floor_z(site, self.floor_z) };
            let plan = footprint(site.element_meshes(&site.elements[overhead.element as usize]), slab);
            let runs = overlapped_cells(&plan.area, &plan.lines, &self.spec);
            let rect = CellRect::around(&runs);
            (runs, rect)
        })
    }
}

/// Height of the floor above, or of everything.
fn next_floor_z(site: &Site<'_>, floor_z: i32) -> i32 {
    let above = site.map_storeys.iter().map(|s| s.floor_z_tenths).filter(|z| *z >= floor_z + LEAST_STOREY_HEIGHT);
    let top = site.elements.iter().filter(|e| e.n_parts > 0).map(|e| e.max_tenths[2]).max();
    above.min().or(top).unwrap_or(floor_z).max(floor_z + LEAST_STOREY_HEIGHT)
}

fn overhead(site: &Site<'_>, floor_z: i32) -> Vec<Overhead> {
    let slab = Slab { lo: floor_z, hi: next_floor_z(site, floor_z) };
    let reaches = |e: &ElementRecord| e.n_parts > 0 && slab.meets(e.min_tenths[2], e.max_tenths[2]);
    let elements = site.elements.iter().zip(0..).filter(|(e, _)| reaches(e));
    elements.map(|(_, element)| Overhead { element, cells: OnceLock::new() }).collect()
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

fn element_runs(
    site: &Site<'_>,
    robot: &RobotProfile,
    spec: &GridSpec,
    map_storey: usize,
    (element, footprint): &(u32, Footprint),
) -> ElementRuns {
    let record = &site.elements[*element as usize];
    let runs = overlapped_cells(&footprint.area, &footprint.lines, spec);
    let door = DoorAt::new(site, robot, (spec, map_storey), record.door, &runs);
    ElementRuns { element: *element, class: record.class(), rect: CellRect::around(&runs), runs, door }
}

/// Upward faces between two heights.
fn floor_pieces(site: &Site<'_>, spec: &GridSpec, heights: [i32; 2], max_slope_rad: f64) -> Vec<FloorPiece> {
    let [lowest, highest] = heights;
    let is_near = |e: &ElementRecord| e.min_tenths[2] <= highest && lowest <= e.max_tenths[2];
    let elements = site.elements.iter().enumerate().filter(|(_, e)| e.has(element_flags::FLOOR) && is_near(e));
    let pieces = elements.map(|(k, e)| {
        let faces = |mesh| floor_faces(mesh, lowest, highest, max_slope_rad);
        let rings: Vec<Ring> = site.element_meshes(e).flat_map(faces).collect();
        let rect = cells_around(rings.iter().flatten().map(|p| p.map(f64::from)), 0.0, spec);
        FloorPiece { element: k as u32, rings, rect }
    });
    pieces.filter(|p| !p.rings.is_empty()).collect()
}

/// The cells around points, in tenths of a millimetre, and everything within `reach` of them; `None` outside the grid.
pub(crate) fn cells_around(points: impl Iterator<Item = [f64; 2]>, reach: f64, spec: &GridSpec) -> Option<CellRect> {
    let (mut min, mut max) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    for point in points {
        for k in 0..2 {
            (min[k], max[k]) = (min[k].min(point[k] - reach), max[k].max(point[k] + reach));
        }
    }
    // One cell more on all sides: faces on a border touch both.
    let cell = |k: usize, c: f64| (c / f64::from(spec.cell_tenths)).floor() - f64::from(spec.first_cell[k]);
    let size = [spec.width, spec.height].map(f64::from);
    let low = [0, 1].map(|k| (cell(k, min[k]) - 1.0).clamp(0.0, size[k]) as u32);
    let high = [0, 1].map(|k| (cell(k, max[k]) + 2.0).clamp(0.0, size[k]) as u32);
    (low[0] < high[0] && low[1] < high[1]).then_some(CellRect { min: low, max: high })
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
        let at_floor = o.bottom_z_tenths <= floor_z + MAX_SILL && o.top_z_tenths >= top;
        (o.filling == NONE || filled_by_door) && o.host != NONE && o.plan.half[0] > 0.0 && at_floor
    };
    let passage = |o: &messages::OpeningRecord| {
        let plan = o.plan.to_box();
        let area = geometry::union(&[plan.ring()], geometry::FillRule::NonZero);
        let runs = overlapped_cells(&area, &[], spec);
        let around = crate::floor::cells_beside(&plan, spec);
        Passage { host: o.host, plan, rect: CellRect::around(&runs), runs, around }
    };
    site.openings.iter().filter(is_passage).map(passage).collect()
}

/// The cells of a floor that is assumed from the storey's spaces. What stands or not does not change it.
fn assumed_floor(site: &Site<'_>, robot: &RobotProfile, storey: &StoreyCut) -> Vec<Run> {
    let bounds_rooms =
        |class: Class| matches!(class, Class::Wall | Class::Column | Class::CurtainWall | Class::Window | Class::Door);
    let elements = storey.footprints.iter().filter(|(e, _)| bounds_rooms(site.elements[*e as usize].class()));
    let passages = storey.passages.iter().map(|p| geometry::union(&[p.plan.ring()], geometry::FillRule::NonZero));
    let beside: Vec<MultiPolygon> = elements.map(|(_, f)| gaps::solid_plan(f)).chain(passages).collect();
    let spaces = geometry::union_of(storey.spaces.iter().map(|s| &s.polygon));
    let elsewhere = [from_below(site, storey.floor_z), built_levels(site, robot, storey)];
    let floor = gaps::assumed_floor(&spaces, &geometry::union_of(&beside), &geometry::union_of(&elsewhere));
    covered_cells(&floor, &storey.spec)
}

/// What is no floor although a space covers it: the built floor of other map storeys up to a metre lower, and in the robot's
/// way. There people stand on that floor.
fn built_levels(site: &Site<'_>, robot: &RobotProfile, storey: &StoreyCut) -> MultiPolygon {
    let step = to_tenths(robot.step_height_m);
    let window = [storey.floor_z - TENTHS_PER_M, storey.floor_z + slab_above_floor(robot)[1]];
    let is_beside = |s: &&MapStoreyRecord| {
        let z = s.floor_z_tenths;
        let is_other = (z - storey.floor_z).abs() > 2 * step;
        s.floor == FloorKind::Built as u32 && is_other && window[0] <= z && z <= window[1]
    };
    let heights = site.map_storeys.iter().filter(is_beside).map(|s| s.floor_z_tenths);
    let pieces = heights.flat_map(|z| floor_pieces(site, &storey.spec, [z - step, z + step], LEVEL_SLOPE_RAD));
    let rings: Vec<Ring> = pieces.flat_map(|piece| piece.rings).collect();
    geometry::union(&rings, geometry::FillRule::NonZero)
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
