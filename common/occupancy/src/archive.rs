//! A robot's map as the `slam-map` archive, and back.

use crate::{Cell, OccupancyMap};
use messages::{ArchiveBuffer, ArchiveError, ContentHash, SlamMap, SlamMapHead};

impl OccupancyMap {
    /// A robot's map from the bus.
    pub fn of_archive(map: &SlamMap<'_>) -> Self {
        Self {
            width: map.head.width as usize,
            cells: map.occupancy.iter().map(|&value| Cell::of_occupancy(value)).collect(),
            resolution_m: map.head.resolution_m,
            origin: map.head.origin,
        }
    }

    /// The `slam-map` archive of this map; what is between free and occupied is unknown in it.
    pub fn to_archive(&self) -> ArchiveBuffer {
        let occupancy: Vec<i8> = self.cells.iter().map(|cell| cell.occupancy()).collect();
        let head = SlamMapHead {
            resolution_m: self.resolution_m,
            origin: self.origin,
            width: self.width as u32,
            height: self.cells.len().checked_div(self.width).unwrap_or(0) as u32,
        };
        SlamMap::write(&head, &occupancy)
    }

    /// The content hash of that archive.
    ///
    /// # Errors
    /// A map that no archive can hold.
    pub fn content_hash(&self) -> Result<ContentHash, ArchiveError> {
        SlamMap::open(self.to_archive().bytes()).map(|archive| archive.content_hash())
    }
}
