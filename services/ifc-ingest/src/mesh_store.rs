//! The file of the meshes of the files that were read last. It is a cache: what is damaged, of another program or of other files
//! changes no site.

use daemon::{SiteConfig, program_hash, replace_file, state_files};
use ingest::{MeshCache, MeshCacheCounts};
use std::path::PathBuf;
use tracing::{info, warn};

/// Where meshes are kept from revision to revision.
#[derive(Debug, Clone)]
pub(crate) struct MeshStore {
    path: PathBuf,
}

impl MeshStore {
    /// In the state folder of a site.
    pub(crate) fn new(config: &SiteConfig) -> Self {
        Self { path: config.state.join(state_files::MESH_CACHE) }
    }

    /// The meshes of the last reading, none if there are none that can be used; `None` if the program does not know itself.
    pub(crate) fn load(&self) -> Option<MeshCache> {
        let program = program_hash()?;
        let (cache, unusable) = MeshCache::of_file(std::fs::read(&self.path), program);
        if let Some(error) = unusable {
            let path = self.path.display();
            warn!(service = "ifc-ingest", %path, error, "the cache of meshes cannot be used; all is meshed anew");
        }
        Some(cache)
    }

    /// Writes the meshes of this reading. A file that cannot be written is told, and costs time alone.
    pub(crate) fn save(&self, cache: &MeshCache) {
        let MeshCacheCounts { found, made, bytes } = cache.counts();
        info!(service = "ifc-ingest", found, made, bytes, "meshes");
        if !cache.has_changed() {
            return;
        }
        if let Err(why) = replace_file(&self.path, &cache.finish()) {
            let (path, error) = (self.path.display(), why.to_string());
            warn!(service = "ifc-ingest", %path, error, "the cache of meshes cannot be written");
        }
    }
}
