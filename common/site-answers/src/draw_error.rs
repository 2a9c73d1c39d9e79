//! Why no maps can be drawn for an answer.

use messages::ArchiveError;
use raster::RasterizeError;

/// Why no maps can be drawn for an answer.
#[derive(Debug, thiserror::Error)]
pub enum DrawError {
    /// A site that cannot be drawn for this robot.
    #[error(transparent)]
    Rasterize(#[from] RasterizeError),
    /// An archive that cannot be read.
    #[error(transparent)]
    Archive(#[from] ArchiveError),
}
