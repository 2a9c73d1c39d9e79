//! The maps of a phase: grids, their index, waypoints.

use crate::failure::Failure;
use daemon::Robot;
use messages::{ArchiveBuffer, Grid, GridWriter, Grids, Phase, Plan, Site};
use rasterize::Rasterizer;
use rayon::prelude::*;

/// Maps of all storeys at a phase.
pub(crate) struct Maps<'a> {
    pub(crate) grids: &'a [Grid<'a>],
    pub(crate) index: &'a Grids<'a>,
    pub(crate) plan: &'a Plan<'a>,
}

/// Draws the maps of a phase and works on them.
///
/// # Errors
/// Those of the work, and archives that cannot be.
pub(crate) fn with_maps<T>(
    site: &Site<'_>,
    phase: &Phase<'_>,
    rasterizer: &Rasterizer,
    robot: &Robot,
    work: impl FnOnce(&Maps<'_>) -> Result<T, Failure>,
) -> Result<T, Failure> {
    let draw = |map_storey: usize| {
        let mut grid = ArchiveBuffer::zeroed(GridWriter::len_of(rasterizer.spec(map_storey).n_cells()));
        rasterizer.rasterize(site, phase, map_storey, GridWriter::new(grid.bytes_mut()));
        grid
    };
    let grids: Vec<ArchiveBuffer> = (0..site.map_storeys.len()).into_par_iter().map(draw).collect();
    let grids: Vec<Grid<'_>> =
        grids.iter().map(|g| Grid::open(g.bytes())).collect::<Result<_, _>>().map_err(Failure::work)?;
    let index = rasterizer.index(site, phase, &robot.name, &grids);
    let index = Grids::open(index.bytes()).map_err(Failure::work)?;
    let plan = waypoint_gen::plan(site, phase, &grids, &robot.profile);
    let plan = Plan::open(plan.bytes()).map_err(Failure::work)?;
    work(&Maps { grids: &grids, index: &index, plan: &plan })
}
