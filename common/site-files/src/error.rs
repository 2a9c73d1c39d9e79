//! Errors of the files of a site: archives of different sites, clouds and octrees that cannot be made.

use cloud::{CloudError, OctomapError};
use messages::{ArchiveError, OtherSite};
use raster::RasterizeError;

/// Why there are no files.
#[derive(Debug, thiserror::Error)]
pub enum SiteFilesError {
    /// A cloud of too many points.
    #[error(transparent)]
    Cloud(#[from] CloudError),
    /// An octree of too many cells.
    #[error(transparent)]
    Octomap(#[from] OctomapError),
    /// Archives of different sites.
    #[error(transparent)]
    OtherSite(#[from] OtherSite),
    /// An archive that cannot be read.
    #[error(transparent)]
    Archive(#[from] ArchiveError),
    /// Nobody waits for them any more.
    #[error("the files are not wanted any more")]
    NotWanted,
    /// A robot or a resolution that nothing can be cut for.
    #[error(transparent)]
    Rasterize(#[from] RasterizeError),
}
