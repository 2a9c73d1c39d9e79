//! The newest site set, and the files of it.

use crate::failure::Failure;
use crate::optional_files::OptionalFiles;
use bus::Bus;
use daemon::SiteConfig;
use export::{ExportFile, ExportInput};
use messages::{ContentHash, Diagnostic, GridSlotRecord, RobotProfile};
use raster::Rasterizer;
use site_view::{SiteSet, SiteSetReader, SiteViews};
use tracing::warn;
use world::WorldFiles;

/// The newest site set with its mission plan.
pub(super) struct Sets {
    reader: SiteSetReader,
    /// Footprints are not on the bus: cutting gives the same again. With what it was made from.
    cut: Option<(CutInputs, Rasterizer)>,
}

/// What footprints depend on.
#[derive(Debug, Clone, Copy, PartialEq)]
struct CutInputs {
    site_hash: ContentHash,
    robot: RobotProfile,
    resolution_m: f64,
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

    /// Hash of the site of the samples, which belong together, and their grids.
    pub(super) fn grids(&self) -> Result<(ContentHash, Vec<GridSlotRecord>), Failure> {
        let set = self.reader.set().ok_or_else(no_maps)?;
        Ok((set.site.content_hash(), set.index.view().slots.to_vec()))
    }

    /// The files of the samples, which belong together.
    pub(super) fn files(&mut self, config: &SiteConfig, optional: &OptionalFiles) -> Result<Vec<ExportFile>, Failure> {
        let set: SiteSet<'_> = self.reader.set().ok_or_else(no_maps)?;
        let SiteViews { site, state: schedule_state, index, grids, mission_plan } =
            set.views().map_err(Failure::work)?;
        let mission_plan = mission_plan.ok_or_else(no_maps)?;
        let profile = index.head.robot;
        // What the grids were drawn with, which the configuration may not name any more; without a storey there is no cell.
        let resolution_m = grids.first().map_or(config.robot.resolution_m, |grid| grid.spec().resolution_m());
        let inputs = CutInputs { site_hash: site.content_hash(), robot: profile, resolution_m };
        if self.cut.as_ref().is_none_or(|(of, _)| *of != inputs) {
            let rasterizer = Rasterizer::new(&site, &profile, resolution_m).map_err(Failure::work)?;
            self.cut = Some((inputs, rasterizer));
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
            resolution_m,
            with_geometry: false,
            exact_footprints: false,
            probability: None,
        };
        let WorldFiles { files, diagnostics } = optional.files(&input, &grids)?;
        for Diagnostic { code, entity, message, .. } in &diagnostics {
            let global_id = entity.as_ref().map(|e| e.global_id.as_str());
            warn!(code = code.name(), global_id, %message, "finding about the world");
        }
        Ok(export::files(&input, files))
    }
}

fn no_maps() -> Failure {
    Failure::work("there are no maps yet")
}
