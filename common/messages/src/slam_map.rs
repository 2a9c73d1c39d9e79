//! The `slam-map` archive: an occupancy grid in the robot's SLAM frame.

use crate::archive::{Archive, ArchiveBuffer, ArchiveError, ArchiveKind, SectionList};
use bytemuck::{Pod, Zeroable};

mod section {
    pub(super) const HEAD: u32 = 1;
    pub(super) const OCCUPANCY: u32 = 2;
}

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

/// A robot's map, read in place.
#[derive(Debug, Clone, Copy)]
pub struct SlamMap<'a> {
    archive: Archive<'a>,
    /// Where it lies.
    pub head: &'a SlamMapHead,
    /// Row-major from the lower left: -1 unknown, 0 free to 100 occupied, as in `nav_msgs/OccupancyGrid`.
    pub occupancy: &'a [i8],
}

impl<'a> SlamMap<'a> {
    /// Validates and views an archive.
    ///
    /// # Errors
    /// Bytes that are no whole archive of a robot's map, a size that is not that of the cells, or a place that is none.
    pub fn open(bytes: &'a [u8]) -> Result<Self, ArchiveError> {
        let map = Self::of(Archive::open(bytes, ArchiveKind::SlamMap)?)?;
        let n_cells = u64::from(map.head.width) * u64::from(map.head.height);
        if map.head.is_usable() && n_cells == map.occupancy.len() as u64 {
            Ok(map)
        } else {
            Err(ArchiveError::Index { what: "the SLAM map" })
        }
    }

    /// The sections of an archive, without validation of their records.
    pub(crate) fn of(archive: Archive<'a>) -> Result<Self, ArchiveError> {
        let (head, occupancy) = (archive.record(section::HEAD)?, archive.section(section::OCCUPANCY)?);
        Ok(Self { archive, head, occupancy })
    }

    /// Hash of the content.
    pub fn content_hash(&self) -> u64 {
        self.archive.content_hash()
    }

    /// Writes an archive into the heap.
    pub fn write(head: &SlamMapHead, occupancy: &[i8]) -> ArchiveBuffer {
        let mut list = SectionList::default();
        list.add(section::HEAD, std::slice::from_ref(head));
        list.add(section::OCCUPANCY, occupancy);
        let mut buffer = ArchiveBuffer::zeroed(list.length());
        list.write(buffer.bytes_mut(), ArchiveKind::SlamMap);
        buffer
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
