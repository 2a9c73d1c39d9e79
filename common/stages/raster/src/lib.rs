//! Rasterisation: site, schedule state and robot in, one grid per map storey out.
//!
//! [`Rasterizer::new`] slices every element to the slab of every storey once, into runs of cells per element; slices change
//! only with site, robot or resolution. [`Rasterizer::draw`] brings the grids to a schedule state: what it drew before is
//! kept, and only cells that can differ are redrawn.
//!
//! # Layers
//!
//! - `planning`: 0 free where nothing stands and floor covers the cell whole, or it is in the passage of a door that the robot
//!   passes; 100 where an obstacle overlaps it by a tenth of a millimetre and in closed spaces; -1 elsewhere. An atrium, a stair
//!   hole, a shaft and a missing slab are unknown; the outline of a room is no floor.
//! - `localization`: a shell of two cells of finished structure at the height of the lidar, where it faces floor, also
//!   across a gap narrower than 0.20 m; without glass and furniture.
//! - `keepout`: drop-offs, work from this floor to the next, and closed rooms, with margins that never leak through a wall.
//! - `class`, `floor`, `space`: what stands in a cell, whether it has floor, and in which space it lies.
//!
//! # Modules
//!
//! `build` makes the `model` of each storey, `layers` computes from model and schedule state, `incremental` keeps the grids
//! and redraws with `layers` only the cells that differ. Each module imports only those before it.
//!
//! If every storey would be blank, [`check_not_blank`] gives an error with what each storey lacks.
//!
//! `cargo run --example planning_map -- config/demo/demo.ifc planning.pgm` makes a planning map with the stages alone.
//!
//! # Guarantees
//!
//! - Origin and size of a grid come from site and resolution alone, not from robot or date.
//! - What a cell is made from is a byte of cell flags: planning follows from the byte, keep-out and localization from the
//!   bytes around it.
//! - A storey before its first slab is all unknown and all keep-out (`no_floor_yet`).
//! - What is not built yet is not there, work in progress is an obstacle and the floor under it, with a margin, is keep-out,
//!   whether it stands on the floor or hangs above it; a space in which a task works is closed. A map says until when it
//!   holds.
//! - A gap narrower than 0.20 m between floor and wall is modelling: the lidar sees the wall across it. Only beside rooms
//!   whose floor is assumed is it floor too, also between spaces and under doors, where no stair, ramp, lift or shaft comes
//!   up; beside built floor it stays a drop-off.
//! - An assumed floor ends where the floor of another map storey is built, up to a metre lower or in the robot's way.
//! - A door is passable only if it hangs, and the robot can open it and fits through; leaves of one opening without a mullion
//!   between them count together: two leaves of 0.5 m are a way of 0.9 m if the robot opens both.
//! - A passable door joins two sides: cells without obstacle, with floor where its sides have floor, join them within its
//!   outline (`layers/doorway_connection.rs`). Every door that is closed, or narrowed by the resolution, is in the report. A
//!   door carries no robot: beside its passage it is free where floor is.
//! - A wall that the opening of a door only touches is cut where the door's body stands in it; nothing else is cut that the
//!   file does not cut.
//! - Ramps and sloped slabs within the robot's limit are floor of every storey to which steps that the robot takes join them, as far as the
//!   next floors; obstacles count by their height above the ground of their cell (`build/ground_patches.rs`). A cell shows one surface: the
//!   nearest to the storey's floor below which the robot fits. From a cell beside which the ground is lower by more than a step it breaks
//!   off: a drop-off, as the end of a slab.
//! - Terrain counts up to the slope that the robot may have across its way, ramps and roads up to that along it.
//! - Stairs are obstacles, but for a robot with a `stair_cost`: for it each tread is such a face, at its height, and joins others over
//!   risers of up to 0.25 m. Its cells have floor and the class of a stair, which no other free cell has.
//! - The map storey of the ground outdoors has no level: the highest terrain or road counts, and of the floor to which one gets from
//!   there what is nearest to it. Below a bridge that is a road the ground is not on it. A door belongs to it where it begins at the height
//!   of the ground; whether the robot passes it is told of the storey of the door.
//! - Only such storeys have heights and slopes of their cells.
//! - Cells of a map storey where the floor of another one stands in the robot's way are keep-out, and have the colour of
//!   another level on `semantic.png`.
//! - A storey's outline is that of the complete model: what is not poured yet is a drop-off inside it.
//! - An incremental redraw gives what a full draw gives; property tests (`common/stages/raster/tests/incremental.rs`) draw
//!   sequences of states, of buildings and of the ground outdoors.
//! - The floor outdoors is united in tiles of 256 cells: a cell may differ from one of the union of all faces where an edge passes
//!   within a tenth of a millimetre of its corner.
//!
//! # Where
//!
//! - floor: of a cell: `src/layers/floor.rs`
//! - ground: which belongs to a storey: `src/build/ground_patches.rs`, `src/build/surface_joins.rs`; which surface a cell shows:
//!   `src/layers/shown_surface.rs`; where it breaks off: `src/layers/ground_floor.rs`; what stands on it: `src/incremental/shown_patches.rs`
//! - incremental redraw: elements that can change a grid: `src/build/dependents.rs`
//! - keep-out mask: which cells are under work: `src/incremental/storey_grid.rs`, `src/build/slicing.rs`
//! - localization layer: `src/layers/localization.rs`

mod build;
mod error;
mod incremental;
mod layers;
mod model;

pub use error::{RasterizeError, check_not_blank};

pub use build::slice_count::SliceProgress;

use build::slice_count::SliceCount;
use build::slicing::slice_storey;
use geometry::LazyFootprint;
use grid::GridSpec;
use incremental::storey_grid::StoreyGrid;
use messages::{
    ArchiveBuffer, ContentHash, DoorPassageRecord, GridSlotRecord, GridsBuilder, GridsHead, RegionRecord, RobotProfile,
    SafetyRules, ScheduleState, Site,
};
use model::storey_inputs::StoreyInputs;
use model::storey_slice::StoreySlice;
use rayon::prelude::*;

/// The slices of a site for one robot and resolution, and the grids of its map storeys as drawn last.
#[derive(Debug)]
pub struct Rasterizer {
    robot: RobotProfile,
    storeys: Vec<StoreySlice>,
    /// One per map storey after the first draw, empty before.
    storey_grids: Vec<StoreyGrid>,
    index: Index,
}

/// Records of the index of the grids as drawn last, in buffers that each draw reuses.
#[derive(Debug, Default)]
struct Index {
    slots: Vec<GridSlotRecord>,
    doors: Vec<DoorPassageRecord>,
    regions: Vec<RegionRecord>,
}

impl Index {
    fn clear(&mut self) {
        self.slots.clear();
        self.doors.clear();
        self.regions.clear();
    }

    fn add(&mut self, storey: &StoreySlice, grid: &StoreyGrid) {
        let (map_storey, cell_tenths) = (storey.map_storey, storey.spec.cell_tenths);
        self.slots.push(GridSlotRecord { map_storey, cell_tenths, content_hash: grid.content_hash() });
        self.doors.extend_from_slice(grid.doors());
        self.regions.extend_from_slice(grid.regions());
    }
}

/// Storeys of more cells are drawn one after the other by [`Rasterizer::draw_once`]: nine bytes a cell are alive meanwhile.
const MAX_CELLS_AT_ONCE: usize = 20_000_000;

/// The grid of a map storey, as drawn last.
#[derive(Debug, Clone, Copy)]
pub struct DrawnGrid<'a> {
    /// The `grid` archive.
    pub archive: &'a [u8],
    /// Its content hash.
    pub content_hash: ContentHash,
    /// Hash of all inputs from the schedule state: the presence of the storey's dependents, which of its spaces are blocked,
    /// and whether there is a plan time.
    pub input_hash: ContentHash,
    grid: &'a StoreyGrid,
}

impl<'a> DrawnGrid<'a> {
    fn of(grid: &'a StoreyGrid) -> Self {
        Self { archive: grid.archive(), content_hash: grid.content_hash(), input_hash: grid.input_hash(), grid }
    }

    /// Makes memory of the archive's length, at a multiple of 64, a copy of it. Of memory that holds one of the latest versions only
    /// cells are written that differ.
    pub fn copy_into(&self, memory: &mut [u8]) {
        self.grid.copy_into(memory);
    }
}

impl Rasterizer {
    /// Slices all elements for all map storeys, on all threads of the current pool.
    ///
    /// # Errors
    /// A resolution that is no whole number of tenths of a millimetre, a margin of too many cells, or a storey too large for
    /// a grid.
    pub fn new(site: &Site<'_>, robot: &RobotProfile, resolution_m: f64) -> Result<Self, RasterizeError> {
        Self::with_progress(site, robot, resolution_m, &|_, _| {})
    }

    /// The same; `progress` is called with elements sliced and in total, from any thread. An element counts once for each
    /// storey.
    ///
    /// # Errors
    /// As [`Rasterizer::new`].
    pub fn with_progress(
        site: &Site<'_>,
        robot: &RobotProfile,
        resolution_m: f64,
        progress: &SliceProgress<'_>,
    ) -> Result<Self, RasterizeError> {
        Self::of_storeys(site, robot, resolution_m, site.map_storeys.len(), progress)
    }

    /// The same of the levels of buildings alone, without the ground outdoors, which comes after them.
    ///
    /// # Errors
    /// As [`Rasterizer::new`].
    pub fn of_levels(site: &Site<'_>, robot: &RobotProfile, resolution_m: f64) -> Result<Self, RasterizeError> {
        Self::of_storeys(site, robot, resolution_m, site.levels().count(), &|_, _| {})
    }

    fn of_storeys(
        site: &Site<'_>,
        robot: &RobotProfile,
        resolution_m: f64,
        n_storeys: usize,
        progress: &SliceProgress<'_>,
    ) -> Result<Self, RasterizeError> {
        let margin_m = robot.work_margin_m.max(robot.edge_margin_m);
        if margin_m > grid::MAX_REACH_CELLS * resolution_m {
            return Err(RasterizeError::Margin { margin_m, max_cells: grid::MAX_REACH_CELLS, resolution_m });
        }
        let count = SliceCount::new(site, robot, progress);
        let storeys = (0..n_storeys)
            .into_par_iter()
            .map(|k| slice_storey(site, robot, resolution_m, k, &count))
            .collect::<Result<_, _>>()?;
        Ok(Self { robot: *robot, storeys, storey_grids: Vec::new(), index: Index::default() })
    }

    /// The specification of the grid of a map storey; it depends on site and resolution alone.
    pub fn spec(&self, map_storey: usize) -> GridSpec {
        self.storeys[map_storey].spec
    }

    /// The footprints of the elements in a storey's slab, by element.
    pub fn footprints(&self, map_storey: usize) -> &[(u32, LazyFootprint)] {
        &self.storeys[map_storey].footprints
    }

    /// Unites all footprints on all threads of the current pool, for those who ask for every one of them.
    pub fn unite_footprints(&self, site: &Site<'_>) {
        for storey in &self.storeys {
            storey.footprints.par_iter().for_each(|(element, _)| {
                storey.footprint(site, *element);
            });
        }
    }

    /// Number of map storeys.
    pub fn n_storeys(&self) -> usize {
        self.storeys.len()
    }

    /// Draws the grids of a schedule state on all threads of the current pool: the first time completely, later
    /// incrementally. The result does not depend on what was drawn before. `site` must be the site of
    /// [`Rasterizer::new`], and `schedule-state` of that site.
    pub fn draw(&mut self, site: &Site<'_>, schedule_state: &ScheduleState<'_>) {
        let Self { robot, storeys, storey_grids, index } = self;
        let inputs = |storey| StoreyInputs { site, robot, storey };
        if storey_grids.is_empty() {
            let draw = |storey| {
                let mut grid = StoreyGrid::new(inputs(storey));
                grid.draw(inputs(storey), schedule_state);
                grid
            };
            storeys.par_iter().map(draw).collect_into_vec(storey_grids);
        } else {
            let both = storeys.par_iter().zip(&mut *storey_grids);
            both.for_each(|(storey, grid)| grid.draw(inputs(storey), schedule_state));
        }
        index.clear();
        storeys.iter().zip(storey_grids).for_each(|(storey, grid)| index.add(storey, grid));
    }

    /// Draws the grids of a schedule state completely and gives the archive of each to `keep` as soon as it is drawn. Large
    /// storeys are drawn one after the other. There are no grids as drawn last then; their index is kept.
    pub fn draw_once<T: Send>(
        &mut self,
        site: &Site<'_>,
        schedule_state: &ScheduleState<'_>,
        keep: impl Fn(ArchiveBuffer) -> T + Sync,
    ) -> Vec<T> {
        self.storey_grids.clear();
        let Self { robot, storeys, index, .. } = self;
        let draw = |storey| {
            let inputs = StoreyInputs { site, robot, storey };
            let mut grid = StoreyGrid::new(inputs);
            grid.draw(inputs, schedule_state);
            let mut records = Index::default();
            records.add(storey, &grid);
            (records, keep(grid.into_archive()))
        };
        let is_large = storeys.iter().any(|storey| storey.spec.n_cells() > MAX_CELLS_AT_ONCE);
        let drawn: Vec<(Index, T)> =
            if is_large { storeys.iter().map(draw).collect() } else { storeys.par_iter().map(draw).collect() };
        index.clear();
        let mut kept = Vec::with_capacity(drawn.len());
        for (records, grid) in drawn {
            index.slots.extend(records.slots);
            index.doors.extend(records.doors);
            index.regions.extend(records.regions);
            kept.push(grid);
        }
        kept
    }

    /// Number of cells of all grids.
    pub fn n_cells(&self) -> usize {
        self.storeys.iter().map(|storey| storey.spec.n_cells()).sum()
    }

    /// The grids as drawn last, by map storey; none before the first draw.
    pub fn drawn(&self) -> impl ExactSizeIterator<Item = DrawnGrid<'_>> {
        self.storey_grids.iter().map(DrawnGrid::of)
    }

    /// The same grids as a parallel iterator.
    pub fn par_drawn(&self) -> impl IndexedParallelIterator<Item = DrawnGrid<'_>> {
        self.storey_grids.par_iter().map(DrawnGrid::of)
    }

    /// Builder of the `grids` archive of the grids as drawn last: their inputs, the passages of doors, and regions at other
    /// levels. The distances that the robot keeps are passed on: no grid depends on them.
    pub fn index<'a>(
        &'a self,
        site: &Site<'_>,
        schedule_state: &ScheduleState<'_>,
        robot_name: &'a str,
        robot_footprint_m: &'a [[f64; 2]],
        safety: &'a SafetyRules,
    ) -> GridsBuilder<'a> {
        let Index { slots, doors, regions } = &self.index;
        let head = GridsHead {
            site_hash: site.content_hash(),
            schedule_state_hash: schedule_state.content_hash(),
            plan_time_s: schedule_state.head.plan_time_s,
            robot: self.robot,
        };
        let (safety_rules, safety_materials) = (safety.records(), safety.materials());
        GridsBuilder { head, slots, robot_name, robot_footprint_m, doors, regions, safety_rules, safety_materials }
    }
}
