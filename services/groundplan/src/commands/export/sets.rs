//! The newest site set, and the files of it.

use crate::failure::Failure;
use bus::Bus;
use daemon::SiteConfig;
use export::ExportFile;
use messages::{ContentHash, Diagnostic, GridSlotRecord};
use site_files::{SiteArchives, SiteFiles, SiteFilesError};
use site_view::{SiteSet, SiteSetReader, SiteViews};
use tracing::warn;

/// The newest site set with its mission plan.
pub(super) struct Sets {
    reader: SiteSetReader,
}

impl Sets {
    pub(super) fn of(bus: &Bus) -> Result<Self, Failure> {
        Ok(Self { reader: SiteSetReader::of(bus).map_err(Failure::work)? })
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
    pub(super) fn files(&mut self, config: &SiteConfig, files: &mut SiteFiles) -> Result<Vec<ExportFile>, Failure> {
        let set: SiteSet<'_> = self.reader.set().ok_or_else(no_maps)?;
        let SiteViews { site, state: schedule_state, index, grids, mission_plan } =
            set.views().map_err(Failure::work)?;
        let mission_plan = mission_plan.ok_or_else(no_maps)?;
        let archives = SiteArchives {
            site: &site,
            schedule_state: &schedule_state,
            index: &index,
            grids: &grids,
            mission_plan: &mission_plan,
            resolution_m: config.robot.resolution_m,
        };
        let mut made = Vec::new();
        let add = |file| {
            made.push(file);
            Ok::<(), SiteFilesError>(())
        };
        let diagnostics = files.each_file(&archives, &|| true, add).map_err(Failure::work)?;
        for Diagnostic { code, entity, message, .. } in &diagnostics {
            let global_id = entity.as_ref().map(|e| e.global_id.as_str());
            warn!(code = code.name(), global_id, %message, "finding about the world");
        }
        Ok(made)
    }
}

fn no_maps() -> Failure {
    Failure::work("there are no maps yet")
}
