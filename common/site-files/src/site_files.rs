//! The files of archives that belong together, each as soon as it is made.

use crate::error::SiteFilesError;
use crate::optional_files::OptionalFiles;
use export::{ExportFile, ExportInput};
use messages::{ContentHash, Diagnostic, Grids, MapGrids, MissionPlan, OtherSite, RobotProfile, ScheduleState, Site};
use raster::Rasterizer;
use world::WorldFiles;

/// Archives that belong together.
pub struct SiteArchives<'a> {
    /// The site, with the tasks of schedule files if there are any.
    pub site: &'a Site<'a>,
    /// States at the plan time.
    pub schedule_state: &'a ScheduleState<'a>,
    /// Index of the grids.
    pub index: &'a Grids<'a>,
    /// The grids, in the order of the index.
    pub grids: &'a dyn MapGrids,
    /// Waypoints.
    pub mission_plan: &'a MissionPlan<'a>,
    /// Metres per cell where there is no grid.
    pub resolution_m: f64,
}

impl SiteArchives<'_> {
    /// Checks that the archives speak of one site.
    ///
    /// # Errors
    /// One of another site.
    pub fn check(&self) -> Result<(), OtherSite> {
        self.schedule_state.check_site(self.site)?;
        self.index.check_site(self.site)?;
        (0..self.grids.count()).try_for_each(|at| self.grids.with(at, |grid| grid.check_site(self.site)))?;
        self.mission_plan.check_site(self.site)
    }
}

/// What makes the files of one date after another.
pub struct SiteFiles {
    optional: OptionalFiles,
    /// Footprints are in no archive: cutting gives the same again. With what it was made from.
    cut: Option<(CutInputs, Rasterizer)>,
}

/// What footprints depend on.
#[derive(Debug, Clone, Copy, PartialEq)]
struct CutInputs {
    site_hash: ContentHash,
    robot: RobotProfile,
    resolution_m: f64,
}

impl SiteFiles {
    /// With these formats beside the files of every output.
    pub fn new(optional: OptionalFiles) -> Self {
        Self { optional, cut: None }
    }

    /// Calls `write` with each file, the manifest last. The answer is what is to be told about the world.
    ///
    /// `is_wanted` is asked while formats are made, see [`OptionalFiles::files`].
    ///
    /// # Errors
    /// Those of `write`; formats that cannot be made, or are not wanted any more.
    pub fn each_file<E: From<SiteFilesError>>(
        &mut self,
        archives: &SiteArchives<'_>,
        is_wanted: &dyn Fn() -> bool,
        write: impl FnMut(ExportFile) -> Result<(), E>,
    ) -> Result<Vec<Diagnostic>, E> {
        let SiteArchives { site, schedule_state, index, grids, mission_plan, resolution_m } = *archives;
        let robot = index.head.robot;
        // What the grids were drawn with, which a configuration may not name any more.
        let resolution_m = grids.heads().next().map_or(resolution_m, |head| head.spec().resolution_m());
        let inputs = CutInputs { site_hash: site.content_hash(), robot, resolution_m };
        let cut = match self.cut.take().filter(|(of, _)| *of == inputs) {
            Some(same) => self.cut.insert(same),
            None => {
                let rasterizer = Rasterizer::new(site, &robot, resolution_m).map_err(SiteFilesError::from)?;
                self.cut.insert((inputs, rasterizer))
            }
        };
        let footprints: Vec<_> = (0..site.map_storeys.len()).map(|storey| cut.1.footprints(storey)).collect();
        let input = ExportInput {
            site,
            schedule_state,
            index,
            grids,
            mission_plan,
            footprints: &footprints,
            resolution_m,
            with_geometry: false,
            exact_footprints: false,
            probability: None,
        };
        let WorldFiles { files, diagnostics } = self.optional.files(&input, grids, is_wanted)?;
        export::each_file(&input, files, write)?;
        Ok(diagnostics)
    }
}
