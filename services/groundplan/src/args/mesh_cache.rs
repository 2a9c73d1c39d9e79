//! `--cache`: a folder that keeps meshes from one conversion to the next.

use crate::failure::Failure;
use daemon::state_files::MESH_CACHE;
use daemon::{program_hash, replace_file};
use ingest::MeshCache;
use std::fs;
use std::path::PathBuf;

/// Where meshes are kept.
#[derive(Debug, Clone, clap::Args)]
pub struct MeshCacheArgs {
    /// Keep meshes of the models in this folder, and take those of the last conversion with it: of a revision only what
    /// changed is meshed and cut. The output is the same. The folder takes at most 512 MiB; a file that is damaged or of another
    /// build of groundplan is not used, which a warning says
    #[arg(long, value_name = "DIR")]
    cache: Option<PathBuf>,
}

impl MeshCacheArgs {
    /// The meshes of the last conversion; `None` if none are to be kept.
    ///
    /// # Errors
    /// A folder that cannot be made.
    pub(crate) fn load(&self) -> Result<Option<MeshCache>, Failure> {
        let Some(folder) = &self.cache else { return Ok(None) };
        fs::create_dir_all(folder)
            .map_err(|why| Failure::usage(format!("--cache {} cannot be made: {why}", folder.display())))?;
        let Some(program) = program_hash() else {
            eprintln!("groundplan: the program cannot read its own file, by which it knows its meshes: none are kept");
            return Ok(None);
        };
        let path = folder.join(MESH_CACHE);
        let (cache, unusable) = MeshCache::of_file(fs::read(&path), program);
        if let Some(error) = unusable {
            eprintln!("groundplan: {} is not used, and all is meshed anew: {error}", path.display());
        }
        Ok(Some(cache))
    }

    /// Writes the meshes of this conversion.
    pub(crate) fn save(&self, cache: &MeshCache) {
        let Some(folder) = &self.cache else { return };
        if !cache.has_changed() {
            return;
        }
        let path = folder.join(MESH_CACHE);
        if let Err(why) = replace_file(&path, &cache.finish()) {
            eprintln!(
                "groundplan: {} cannot be written, and the next conversion meshes all anew: {why}",
                path.display()
            );
        }
    }
}
