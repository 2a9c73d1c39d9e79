//! Site, phase and robot in, one grid per map storey out.
//!
//! [`Rasterizer::new`] cuts every element to the slab of every storey once, into runs of cells per element, and keeps
//! them; they change only with site, robot or resolution. [`Rasterizer::rasterize`] composes the layers of one storey
//! at one phase from them.

mod compose;
mod cut;
mod doors;
mod error;
mod floor;
mod keepout;
mod localization;
mod regions;

pub mod service;

pub use error::{RasterizeError, check_not_blank};

use cut::StoreyCut;
use geometry::Footprint;
use grid::GridSpec;
use messages::{
    ArchiveBuffer, DoorPassageRecord, Grid, GridHead, GridSlotRecord, GridWriter, GridsBuilder, GridsHead, Phase,
    RegionRecord, RobotProfile, Site,
};
use rayon::prelude::*;
use xxhash_rust::xxh3::Xxh3;

/// What a site looks like to a robot at a resolution, before any date is known.
#[derive(Debug)]
pub struct Rasterizer {
    robot: RobotProfile,
    storeys: Vec<StoreyCut>,
}

impl Rasterizer {
    /// Cuts all elements for all map storeys, on all threads of the current pool.
    ///
    /// # Errors
    /// A resolution that is no whole number of tenths of a millimetre, or a storey too large for a grid.
    pub fn new(site: &Site<'_>, robot: &RobotProfile, resolution_m: f64) -> Result<Self, RasterizeError> {
        let storeys = (0..site.map_storeys.len())
            .into_par_iter()
            .map(|k| StoreyCut::new(site, robot, resolution_m, k))
            .collect::<Result<_, _>>()?;
        Ok(Self { robot: *robot, storeys })
    }

    /// Where the grid of a map storey lies: a function of site and resolution alone.
    pub fn spec(&self, map_storey: usize) -> GridSpec {
        self.storeys[map_storey].spec
    }

    /// The footprints of the elements in a storey's slab, by element.
    pub fn footprints(&self, map_storey: usize) -> &[(u32, Footprint)] {
        &self.storeys[map_storey].footprints
    }

    /// Writes the grid of a map storey at a phase.
    pub fn rasterize(&self, site: &Site<'_>, phase: &Phase<'_>, map_storey: usize, out: GridWriter<'_>) {
        let storey = &self.storeys[map_storey];
        let GridSpec { cell_tenths, first_cell, width, height } = storey.spec;
        let record = &site.map_storeys[map_storey];
        let head = GridHead {
            cell_tenths,
            first_cell,
            width,
            height,
            map_storey: map_storey as u32,
            floor_z_tenths: record.floor_z_tenths,
            slab_tenths: cut::slab_above_floor(&self.robot),
            floor: record.floor,
            frame_epoch: site.head.frame_epoch,
            reserved: 0,
        };
        out.write(&head, |layers| compose::compose(site, phase, &self.robot, storey, layers));
    }

    /// Writes the index of a set of grids: what they were made from, what a robot finds at doors, regions at other levels.
    pub fn index(&self, site: &Site<'_>, phase: &Phase<'_>, robot_name: &str, grids: &[Grid<'_>]) -> ArchiveBuffer {
        let findings: Vec<StoreyFindings> = grids.iter().map(|grid| self.findings(site, phase, grid)).collect();
        self.index_of(site.content_hash(), phase, robot_name, &findings)
    }

    /// What the index says of one grid.
    pub fn findings(&self, site: &Site<'_>, phase: &Phase<'_>, grid: &Grid<'_>) -> StoreyFindings {
        let storey = &self.storeys[grid.head.map_storey as usize];
        StoreyFindings {
            slot: GridSlotRecord {
                map_storey: grid.head.map_storey,
                cell_tenths: grid.head.cell_tenths,
                content_hash: grid.content_hash(),
            },
            doors: doors::passages(site, phase, &self.robot, storey, grid),
            regions: regions::at_other_levels(site, phase, &self.robot, storey),
        }
    }

    /// The index of what was found in all grids, by map storey.
    pub fn index_of(
        &self,
        site_hash: u64,
        phase: &Phase<'_>,
        robot_name: &str,
        findings: &[StoreyFindings],
    ) -> ArchiveBuffer {
        let head = GridsHead {
            site_hash,
            phase_hash: phase.content_hash(),
            plan_time_s: phase.head.plan_time_s,
            robot: self.robot,
        };
        GridsBuilder {
            head,
            slots: findings.iter().map(|f| f.slot).collect(),
            robot_name,
            doors: findings.iter().flat_map(|f| f.doors.iter().copied()).collect(),
            regions: findings.iter().flat_map(|f| f.regions.iter().copied()).collect(),
        }
        .finish()
    }

    /// Hash of everything of a phase that can change a map storey's grid and what the index says of it: the states of
    /// elements near the storey and of its spaces. Equal hashes, equal grids, as long as site and robot are the same.
    pub fn input_hash(&self, phase: &Phase<'_>, map_storey: usize) -> u64 {
        let storey = &self.storeys[map_storey];
        let mut hash = Xxh3::new();
        hash.update(&[u8::from(phase.head.plan_time().is_some())]);
        storey.near.iter().for_each(|element| hash.update(&[phase.effective(*element as usize) as u8]));
        storey.spaces.iter().for_each(|s| hash.update(&[u8::from(phase.is_blocked(s.space as usize))]));
        hash.digest()
    }

    /// Number of map storeys.
    pub fn n_storeys(&self) -> usize {
        self.storeys.len()
    }
}

/// What the index says of one grid.
#[derive(Debug, Clone)]
pub struct StoreyFindings {
    slot: GridSlotRecord,
    doors: Vec<DoorPassageRecord>,
    regions: Vec<RegionRecord>,
}
