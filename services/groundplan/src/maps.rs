//! Draws the grids of a schedule state, their index and the mission plan, for commands without daemons.

use crate::failure::Failure;
use crate::progress_line::ProgressLine;
use daemon::Robot;
use export::{ExportFile, ExportInput};
use geometry::LazyFootprint;
use messages::{Grid, Grids, MissionPlan, ScheduleState, Site};
use raster::Rasterizer;
use waypoints::{MissionPlanInput, MissionPlanOptions, MissionPlanner, Start};
use world::WorldOptions;

/// The files of the simulation world, if there is to be one.
pub(crate) fn world_files(input: &ExportInput<'_>, options: Option<&WorldOptions>) -> Vec<ExportFile> {
    options.map_or_else(Vec::new, |options| world::files(input, options))
}

/// Maps of all storeys at a schedule state.
pub(crate) struct Maps<'a> {
    pub(crate) grids: &'a [Grid<'a>],
    pub(crate) index: &'a Grids<'a>,
    pub(crate) mission_plan: &'a MissionPlan<'a>,
    /// By map storey.
    pub(crate) footprints: &'a [&'a [(u32, LazyFootprint)]],
    rasterizer: &'a Rasterizer,
}

impl Maps<'_> {
    /// Unites the footprints on all threads, for files that have all of them.
    pub(crate) fn unite_footprints(&self, site: &Site<'_>) {
        self.rasterizer.unite_footprints(site);
    }

    /// True if the robot can stand at a start; false where there is no floor yet.
    ///
    /// # Errors
    /// Why it cannot, and where it can.
    pub(crate) fn check_start(
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

/// Draws the maps of a schedule state and works on them.
///
/// # Errors
/// Those of the work, and archives that cannot be.
pub(crate) fn with_maps<T>(
    site: &Site<'_>,
    schedule_state: &ScheduleState<'_>,
    rasterizer: &mut Rasterizer,
    robot: &Robot,
    options: &MissionPlanOptions,
    progress: &ProgressLine,
    work: impl FnOnce(&Maps<'_>) -> Result<T, Failure>,
) -> Result<T, Failure> {
    progress.stage("drawing");
    rasterizer.draw(site, schedule_state);
    let index = rasterizer.index(site, schedule_state, &robot.name, &robot.footprint_m).finish();
    let index = Grids::open(index.bytes()).map_err(Failure::work)?;
    let grids: Vec<Grid<'_>> =
        rasterizer.drawn().map(|grid| Grid::open(grid.archive)).collect::<Result<_, _>>().map_err(Failure::work)?;
    let input = MissionPlanInput { site, schedule_state, index: &index, grids: &grids, options };
    progress.stage("planning");
    let mission_plan = MissionPlanner::default().plan(&input);
    let mission_plan = MissionPlan::open(mission_plan.bytes()).map_err(Failure::work)?;
    let footprints: Vec<_> = (0..grids.len()).map(|k| rasterizer.footprints(k)).collect();
    work(&Maps { grids: &grids, index: &index, mission_plan: &mission_plan, footprints: &footprints, rasterizer })
}
