//! The newest site set, and the files of it.

use crate::failure::Failure;
use crate::maps::world_files;
use bus::{Bus, SiteSet, SiteSetReader, SiteViews};
use daemon::SiteConfig;
use export::{ExportFile, ExportInput};
use raster::Rasterizer;
use world::WorldOptions;

/// The newest site set with its mission plan.
pub(super) struct Sets {
    reader: SiteSetReader,
    /// Footprints are not on the bus: cutting gives the same again. With the hashes of what it was made from.
    cut: Option<([u64; 2], Rasterizer)>,
}

impl Sets {
    pub(super) fn of(bus: &Bus) -> Result<Self, Failure> {
        Ok(Self { reader: SiteSetReader::of(bus).map_err(Failure::work)?, cut: None })
    }

    /// Takes what has come. If the newest samples belong together, this is the epoch of their mission plan, which is
    /// the last of a set.
    pub(super) fn take(&mut self) -> Result<Option<u64>, Failure> {
        self.reader.take().map_err(Failure::work)?;
        let mission_plan = self.reader.set().and_then(|set| set.mission_plan);
        Ok(mission_plan.map(|mission_plan| mission_plan.bytes().header().epoch))
    }

    /// The files of the samples, which belong together.
    pub(super) fn files(
        &mut self,
        config: &SiteConfig,
        world: Option<&WorldOptions>,
    ) -> Result<Vec<ExportFile>, Failure> {
        let missing = || Failure::work("there are no maps yet");
        let set: SiteSet<'_> = self.reader.set().ok_or_else(missing)?;
        let SiteViews { site, state: schedule_state, index, grids, mission_plan } =
            set.views().map_err(Failure::work)?;
        let mission_plan = mission_plan.ok_or_else(missing)?;
        let inputs = set.index.bytes().header().inputs;
        let profile = index.head.robot;
        let made_from = [inputs.site, inputs.robot];
        if self.cut.as_ref().is_none_or(|(of, _)| *of != made_from) {
            let rasterizer = Rasterizer::new(&site, &profile, config.robot.resolution_m).map_err(Failure::work)?;
            self.cut = Some((made_from, rasterizer));
        }
        let footprints: Vec<_> =
            self.cut.iter().flat_map(|(_, cut)| (0..grids.len()).map(|k| cut.footprints(k))).collect();
        let input = ExportInput {
            site: &site,
            schedule_state: &schedule_state,
            index: &index,
            grids: &grids,
            mission_plan: &mission_plan,
            footprints: &footprints,
            resolution_m: config.robot.resolution_m,
            with_geometry: false,
        };
        Ok(export::files(&input, world_files(&input, world)))
    }
}
