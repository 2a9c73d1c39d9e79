//! The `slam-map` archive: an occupancy grid in the robot's SLAM frame.

use crate::archive::{ArchiveBuffer, ArchiveError};
use crate::declaration::declare_archive;
use bytemuck::{Pod, Zeroable};

/// Where the map lies in the robot's frame: one record, the fields of `nav_msgs/MapMetaData`.
#[derive(Debug, Clone, Copy, PartialEq, Zeroable, Pod)]
#[repr(C)]
pub struct SlamMapHead {
    /// Side of a cell.
    pub resolution_m: f64,
    /// Pose of the lower left corner: x, y in metres, yaw in radians.
    pub origin: [f64; 3],
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
}
const _: () = assert!(size_of::<SlamMapHead>() == 40);

impl SlamMapHead {
    /// Cells of the largest map.
    pub const MAX_CELLS: u64 = 1 << 28;
    /// Sides of cells.
    pub const RESOLUTION_M: [f64; 2] = [0.001, 10.0];
    /// Places of corners are nearer than this to the frame's origin.
    pub const MAX_COORDINATE_M: f64 = 1e7;

    fn is_usable(&self) -> bool {
        let [least_m, most_m] = Self::RESOLUTION_M;
        least_m <= self.resolution_m
            && self.resolution_m <= most_m
            && self.origin.iter().all(|c| c.abs() < Self::MAX_COORDINATE_M)
            && u64::from(self.width) * u64::from(self.height) <= Self::MAX_CELLS
    }
}

declare_archive! {
    /// A robot's map, read in place.
    view SlamMap;
    /// A `slam-map` archive to be.
    borrowed SlamMapBuilder;
    sections {
        /// Where it lies.
        pub head: one(1, SlamMapHead),
        /// Row-major from the lower left: -1 unknown, 0 free to 100 occupied, as in `nav_msgs/OccupancyGrid`.
        pub occupancy: many(2, i8),
    }
}

impl SlamMap<'_> {
    fn check(&self) -> Result<(), ArchiveError> {
        let n_cells = u64::from(self.head.width) * u64::from(self.head.height);
        let is_whole = self.head.is_usable() && n_cells == self.occupancy.len() as u64;
        if is_whole { Ok(()) } else { Err(ArchiveError::Index { what: "the SLAM map" }) }
    }

    /// Writes an archive into the heap.
    pub fn write(head: &SlamMapHead, occupancy: &[i8]) -> ArchiveBuffer {
        SlamMapBuilder { head: *head, occupancy }.finish()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_map_comes_back_and_one_of_another_size_is_refused() {
        let head = SlamMapHead { resolution_m: 0.05, origin: [-1.0, 2.0, 0.5], width: 3, height: 2 };
        let cells = [0, 100, -1, 50, 0, 0];
        let buffer = SlamMap::write(&head, &cells);
        let map = SlamMap::open(buffer.bytes()).unwrap();
        assert_eq!((*map.head, map.occupancy), (head, &cells[..]));
        assert!(SlamMap::open(SlamMap::write(&head, &cells[1..]).bytes()).is_err());
        for wrong in [
            SlamMapHead { resolution_m: f64::NAN, ..head },
            SlamMapHead { resolution_m: 0.0, ..head },
            SlamMapHead { origin: [f64::INFINITY, 0.0, 0.0], ..head },
        ] {
            assert!(SlamMap::open(SlamMap::write(&wrong, &cells).bytes()).is_err(), "{wrong:?}");
        }
    }
}
