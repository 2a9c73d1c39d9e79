//! Draws the grids of a schedule state, their index and the mission plan, without daemons.

use crate::progress::DrawingProgress;
use daemon::Robot;
use geometry::LazyFootprint;
use messages::{ArchiveBuffer, ArchiveError, Grid, Grids, HeldGrid, MapGrids, MissionPlan, ScheduleState, Site};
use raster::Rasterizer;
use waypoints::{MissionPlanInput, MissionPlanOptions, MissionPlanner, Start};

/// Maps of all storeys at a schedule state.
pub struct Maps<'a> {
    /// The grids.
    pub grids: &'a dyn MapGrids,
    /// Their index.
    pub index: &'a Grids<'a>,
    /// The mission plan of them.
    pub mission_plan: &'a MissionPlan<'a>,
    /// Footprints by map storey.
    pub footprints: &'a [&'a [(u32, LazyFootprint)]],
    rasterizer: &'a Rasterizer,
}

impl Maps<'_> {
    /// Unites the footprints on all threads, for files that have all of them.
    pub fn unite_footprints(&self, site: &Site<'_>) {
        self.rasterizer.unite_footprints(site);
    }

    /// True if the robot can stand at a start; false where there is no floor yet.
    ///
    /// # Errors
    /// Why it cannot, and where it can.
    pub fn check_start(
        &self,
        site: &Site<'_>,
        schedule_state: &ScheduleState<'_>,
        options: &MissionPlanOptions,
        start: Start,
    ) -> Result<bool, String> {
        let input = MissionPlanInput { site, schedule_state, index: self.index, grids: self.grids, options };
        waypoints::check_start(&input, start)
    }
}

/// What the maps of a schedule state are drawn and planned with.
#[derive(Clone, Copy)]
pub struct MapInputs<'a> {
    /// The site.
    pub site: &'a Site<'a>,
    /// Its states.
    pub schedule_state: &'a ScheduleState<'a>,
    /// The robot.
    pub robot: &'a Robot,
    /// What is planned.
    pub options: &'a MissionPlanOptions,
    /// Takes what is done.
    pub progress: &'a dyn DrawingProgress,
}

/// Grids of more cells in total are packed when maps are drawn once: all of them together would take 7 bytes a cell.
const MAX_CELLS_OPEN: usize = 8_000_000;

/// Draws the maps of a schedule state and works on them; what is drawn is kept for the next schedule state.
///
/// # Errors
/// Those of the work, and archives that cannot be.
pub fn with_maps<T, E: From<ArchiveError>>(
    inputs: &MapInputs<'_>,
    rasterizer: &mut Rasterizer,
    work: impl FnOnce(&Maps<'_>) -> Result<T, E>,
) -> Result<T, E> {
    inputs.progress.stage("drawing");
    rasterizer.draw(inputs.site, inputs.schedule_state);
    let grids: Vec<Grid<'_>> =
        rasterizer.drawn().map(|grid| Grid::open(grid.archive)).collect::<Result<_, ArchiveError>>()?;
    planned(inputs, rasterizer, &grids, work)
}

/// The same for a single schedule state: of large sites one storey at a time is dense in memory.
///
/// # Errors
/// Those of the work, and archives that cannot be.
pub fn with_maps_once<T, E: From<ArchiveError>>(
    inputs: &MapInputs<'_>,
    rasterizer: &mut Rasterizer,
    work: impl FnOnce(&Maps<'_>) -> Result<T, E>,
) -> Result<T, E> {
    inputs.progress.stage("drawing");
    let is_large = rasterizer.n_cells() > MAX_CELLS_OPEN;
    let keep = |archive: ArchiveBuffer| if is_large { HeldGrid::packed(archive) } else { HeldGrid::open(archive) };
    let grids = rasterizer.draw_once(inputs.site, inputs.schedule_state, keep);
    let grids: Vec<HeldGrid> = grids.into_iter().collect::<Result<_, _>>()?;
    let grids: Vec<&HeldGrid> = grids.iter().collect();
    planned(inputs, rasterizer, &grids, work)
}

/// Plans on the grids that were drawn last and works on all maps.
fn planned<T, E: From<ArchiveError>>(
    inputs: &MapInputs<'_>,
    rasterizer: &Rasterizer,
    grids: &dyn MapGrids,
    work: impl FnOnce(&Maps<'_>) -> Result<T, E>,
) -> Result<T, E> {
    let MapInputs { site, schedule_state, robot, options, progress } = *inputs;
    let index = rasterizer.index(site, schedule_state, &robot.name, &robot.footprint_m, &robot.safety).finish();
    let index = Grids::open(index.bytes())?;
    let input = MissionPlanInput { site, schedule_state, index: &index, grids, options };
    progress.stage("planning");
    let mission_plan = MissionPlanner::default().plan(&input);
    let mission_plan = MissionPlan::open(mission_plan.bytes())?;
    let footprints: Vec<_> = (0..grids.count()).map(|k| rasterizer.footprints(k)).collect();
    work(&Maps { grids, index: &index, mission_plan: &mission_plan, footprints: &footprints, rasterizer })
}
