//! The robot's SLAM map, from the bus or from a file.

use alignment::PreparedMap;
use frames::Slam;
use messages::{ArchiveError, ContentHash, SlamMap};
use occupancy::{MapFault, MapFileContent, MapFileError, OccupancyMap};
use std::path::Path;

/// A robot's map, ready to be compared.
pub struct RobotMap {
    pub(crate) map: OccupancyMap,
    pub(crate) prepared: PreparedMap<Slam>,
    pub(crate) content_hash: ContentHash,
}

/// A robot's map that cannot be used.
#[derive(Debug, thiserror::Error)]
pub(crate) enum RobotMapError {
    #[error(transparent)]
    File(#[from] MapFileError),
    #[error("the robot's map")]
    Archive(#[from] ArchiveError),
    #[error("the robot's map")]
    Fault(#[from] MapFault),
}

impl RobotMap {
    /// Hash of its content.
    pub fn content_hash(&self) -> ContentHash {
        self.content_hash
    }

    /// From a `slam-map` archive.
    pub(crate) fn of_archive(archive: &SlamMap<'_>) -> Result<Self, RobotMapError> {
        let map = OccupancyMap::of_archive(archive);
        map.check_extent()?;
        Ok(Self::prepared(map, archive.content_hash()))
    }

    /// From a map server's file, with its content.
    pub(crate) fn read(path: &Path) -> Result<(Self, MapFileContent), RobotMapError> {
        let (map, content) = OccupancyMap::read_with_content(path)?;
        Ok((Self::of(map)?, content))
    }

    /// From a map that was read.
    pub(crate) fn of(map: OccupancyMap) -> Result<Self, RobotMapError> {
        let content_hash = map.content_hash()?;
        Ok(Self::prepared(map, content_hash))
    }

    fn prepared(map: OccupancyMap, content_hash: ContentHash) -> Self {
        Self { prepared: PreparedMap::of_slam(&map), map, content_hash }
    }
}
