//! Reads files as a revision of a site that could take effect: the site, and how it differs from the site in force.

use crate::mesh_store::MeshStore;
use crate::model_files::ModelFiles;
use bus::give_back_freed_memory;
use daemon::facts::MeshFacts;
use daemon::{CurrentActivity, Failure, FileStamp, Reporter, Revision, SiteConfig};
use ingest::{IngestOptions, MeshCacheCounts, SiteFrame, ingest};
use messages::{Activity, Checked, ContentId, SiteComparison, SiteOutline, payload};
use std::path::PathBuf;
use std::sync::Arc;

/// Shares of a load that are done when the files are in memory, and when the site is made.
const FILES_READ: f64 = 0.02;
const SITE_MADE: f64 = 0.95;

/// What revisions are read with.
pub(crate) struct RevisionReader {
    allow_boxes: bool,
    activity: CurrentActivity,
    meshes: MeshStore,
}

/// What a revision has to fit to.
#[derive(Clone, Copy)]
pub(crate) struct Compared<'a> {
    /// The frame that revisions of the building keep.
    pub(crate) frame: Option<SiteFrame>,
    /// The highest epoch that a frame of the site had; 0 before the first.
    pub(crate) last_epoch: u32,
    /// The site.
    pub(crate) outline: Option<&'a SiteOutline>,
}

/// A revision that could take effect.
pub(crate) struct ReadRevision {
    pub(crate) models: Vec<PathBuf>,
    /// What the files looked like when they were read.
    pub(crate) stamps: Vec<Option<FileStamp>>,
    pub(crate) site: Arc<Checked<payload::Site>>,
    pub(crate) outline: Arc<SiteOutline>,
    pub(crate) comparison: SiteComparison,
    /// What of its meshes was known.
    pub(crate) meshes: Option<MeshFacts>,
}

impl RevisionReader {
    /// As the configuration says.
    pub(crate) fn new(config: &SiteConfig, activity: CurrentActivity) -> Self {
        Self { allow_boxes: config.allow_boxes, activity, meshes: MeshStore::new(config) }
    }

    /// The same with another configuration.
    pub(crate) fn configured(&self, config: &SiteConfig) -> Self {
        Self::new(config, self.activity.clone())
    }

    /// Reads files.
    ///
    /// # Errors
    /// Files that cannot be read as a site.
    pub(crate) fn read(
        &self,
        files: ModelFiles,
        in_force: Compared<'_>,
        reporter: &Reporter,
    ) -> Result<ReadRevision, Failure> {
        self.activity.set(Activity::Reading);
        let ModelFiles { models, stamps, sources } = files;
        let activity = self.activity.clone();
        let meshes = self.meshes.load();
        // A robot is localised in the frame of its site: a revision keeps it, another building has another.
        let options = IngestOptions {
            frame: in_force.frame,
            frame_of: in_force.outline,
            frame_epoch: in_force.last_epoch.saturating_add(1),
            places: &[],
            prefer_last: false,
            allow_boxes: self.allow_boxes,
            isolation: Some(&daemon::in_mesh_process),
            cache: meshes.as_ref(),
            pool: None,
            progress: &|progress| {
                let stage =
                    if progress.stage == ingest::Stage::Meshing { Activity::Meshing } else { Activity::Reading };
                activity.set(stage);
                reporter.report(&progress.doing(), FILES_READ + (SITE_MADE - FILES_READ) * progress.share);
            },
        };
        reporter.report("reading files", FILES_READ);
        let site = Checked::<payload::Site>::new(ingest(&sources, &options)?)?;
        drop(sources);
        let facts = meshes.as_ref().map(|meshes| {
            self.meshes.save(meshes);
            let MeshCacheCounts { found, made, bytes } = meshes.counts();
            MeshFacts { found: found as u64, made: made as u64, bytes: bytes as u64 }
        });
        drop(meshes);
        give_back_freed_memory();
        self.activity.set(Activity::Writing);
        reporter.report("comparing with the site in force", SITE_MADE);
        let outline = SiteOutline::of(&site.view());
        let comparison = match in_force.outline {
            Some(before) => SiteComparison::of(before, &outline),
            None => SiteComparison::of_first(&outline),
        };
        Ok(ReadRevision { models, stamps, site: Arc::new(site), outline: Arc::new(outline), comparison, meshes: facts })
    }
}

impl ReadRevision {
    /// sha256 of each file.
    pub(crate) fn sha256(&self) -> Vec<ContentId> {
        self.site.view().sources.iter().map(|source| ContentId::from_sha256(source.sha256)).collect()
    }

    /// What clients get of it.
    pub(crate) fn described(&self) -> Revision {
        let (models, comparison) = (self.models.clone(), self.comparison.clone());
        Revision { models, sha256: self.sha256(), comparison }
    }
}
