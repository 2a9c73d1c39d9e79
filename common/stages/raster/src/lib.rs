//! Rasterisation: site, schedule state and robot in, one grid per map storey out.
//!
//! [`Rasterizer::new`] slices every element to the slab of every storey once, into runs of cells per element; slices change
//! only with site, robot or resolution. [`Rasterizer::draw`] brings the grids to a schedule state: what it drew before is
//! kept, and only cells whose appearance changed are drawn again.
//!
//! # Layers
//!
//! - `planning`: 0 free where built floor covers the cell whole and nothing stands, 100 where an obstacle overlaps it by a
//!   tenth of a millimetre, -1 elsewhere. An atrium, a stair hole, a shaft and a missing slab are unknown; the outline of a
//!   room is no floor.
//! - `localization`: a shell of two cells of finished structure at the height of the lidar, where it faces floor, also
//!   across a gap narrower than 0.20 m; without glass and furniture.
//! - `keepout`: drop-offs, work from this floor to the next, and closed rooms, with margins that never leak through a wall.
//! - `class`, `floor`, `space`: what stands in a cell, whether it has floor, and in which space it lies.
//!
//! # Modules
//!
//! `build` makes the `model` of each storey, `layers` computes from model and schedule state, `incremental` redraws with them
//! only what looks different. Each names only those before it.
//!
//! A map whose every storey would be blank is an error that says what each storey lacks ([`check_not_blank`]).
//!
//! `cargo run --example planning_map -- config/demo/demo.ifc planning.pgm` makes a planning map with the stages alone.

mod build;
mod error;
mod incremental;
mod layers;
mod model;

pub use error::{RasterizeError, check_not_blank};

use build::slicing::slice_storey;
use geometry::Footprint;
use grid::GridSpec;
use incremental::scene::Scene;
use incremental::storey_grid::Canvas;
use messages::{DoorPassageRecord, GridSlotRecord, GridsBuilder, GridsHead, Phase, RegionRecord, RobotProfile, Site};
use model::storey_slice::StoreyCut;
use rayon::prelude::*;

/// What a site looks like to a robot at a resolution: before any date is known, and as it was drawn last.
#[derive(Debug)]
pub struct Rasterizer {
    robot: RobotProfile,
    storeys: Vec<StoreyCut>,
    /// One per storey, once something was drawn.
    canvases: Vec<Canvas>,
    index: Index,
}

/// Records of the index, in memory that is used again.
#[derive(Debug, Default)]
struct Index {
    slots: Vec<GridSlotRecord>,
    doors: Vec<DoorPassageRecord>,
    regions: Vec<RegionRecord>,
}

/// The grid of a map storey, as drawn last.
#[derive(Debug, Clone, Copy)]
pub struct Drawn<'a> {
    /// The `grid` archive.
    pub archive: &'a [u8],
    /// Its content hash.
    pub content_hash: u64,
    /// Hash of everything of the phase that it depends on: the looks of the elements near the storey and of its spaces.
    pub input_hash: u64,
}

impl<'a> Drawn<'a> {
    fn of(canvas: &'a Canvas) -> Self {
        Self { archive: canvas.archive(), content_hash: canvas.content_hash(), input_hash: canvas.input_hash() }
    }
}

impl Rasterizer {
    /// Cuts all elements for all map storeys, on all threads of the current pool.
    ///
    /// # Errors
    /// A resolution that is no whole number of tenths of a millimetre, a margin of too many cells, or a storey too large for
    /// a grid.
    pub fn new(site: &Site<'_>, robot: &RobotProfile, resolution_m: f64) -> Result<Self, RasterizeError> {
        let margin_m = robot.work_margin_m.max(robot.edge_margin_m);
        if margin_m > grid::MAX_REACH_CELLS * resolution_m {
            return Err(RasterizeError::Margin { margin_m, max_cells: grid::MAX_REACH_CELLS, resolution_m });
        }
        let storeys = (0..site.map_storeys.len())
            .into_par_iter()
            .map(|k| slice_storey(site, robot, resolution_m, k))
            .collect::<Result<_, _>>()?;
        Ok(Self { robot: *robot, storeys, canvases: Vec::new(), index: Index::default() })
    }

    /// Where the grid of a map storey lies: a function of site and resolution alone.
    pub fn spec(&self, map_storey: usize) -> GridSpec {
        self.storeys[map_storey].spec
    }

    /// The footprints of the elements in a storey's slab, by element.
    pub fn footprints(&self, map_storey: usize) -> &[(u32, Footprint)] {
        &self.storeys[map_storey].footprints
    }

    /// Number of map storeys.
    pub fn n_storeys(&self) -> usize {
        self.storeys.len()
    }

    /// Draws the grids of a phase on all threads of the current pool: the first time as a whole, later only what differs. What
    /// was drawn before does not change the result. `site` is the one that it was made from, `phase` one of that site.
    pub fn draw(&mut self, site: &Site<'_>, phase: &Phase<'_>) {
        let Self { robot, storeys, canvases, .. } = self;
        let scene = |storey| Scene { site, robot, storey };
        if canvases.is_empty() {
            let draw = |storey| {
                let mut canvas = Canvas::new(scene(storey));
                canvas.draw(scene(storey), phase);
                canvas
            };
            storeys.par_iter().map(draw).collect_into_vec(canvases);
        } else {
            let both = storeys.par_iter().zip(canvases);
            both.for_each(|(storey, canvas)| canvas.draw(scene(storey), phase));
        }
    }

    /// The grids, as drawn last, by map storey; none before the first time.
    pub fn drawn(&self) -> impl ExactSizeIterator<Item = Drawn<'_>> {
        self.canvases.iter().map(Drawn::of)
    }

    /// The same, for all threads of the current pool.
    pub fn par_drawn(&self) -> impl IndexedParallelIterator<Item = Drawn<'_>> {
        self.canvases.par_iter().map(Drawn::of)
    }

    /// The `grids` archive of the grids as drawn last, to be written: what they were made from, what a robot finds at doors,
    /// regions at other levels.
    pub fn index<'a>(&'a mut self, site: &Site<'_>, phase: &Phase<'_>, robot_name: &'a str) -> GridsBuilder<'a> {
        let Index { slots, doors, regions } = &mut self.index;
        slots.clear();
        doors.clear();
        regions.clear();
        for (canvas, storey) in self.canvases.iter().zip(&self.storeys) {
            let (map_storey, cell_tenths) = (storey.map_storey, storey.spec.cell_tenths);
            slots.push(GridSlotRecord { map_storey, cell_tenths, content_hash: canvas.content_hash() });
            doors.extend_from_slice(canvas.doors());
            regions.extend_from_slice(canvas.regions());
        }
        let head = GridsHead {
            site_hash: site.content_hash(),
            phase_hash: phase.content_hash(),
            plan_time_s: phase.head.plan_time_s,
            robot: self.robot,
        };
        GridsBuilder { head, slots, robot_name, doors, regions }
    }
}
