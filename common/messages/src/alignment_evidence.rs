//! The `alignment-evidence` archive: what looks at a growing SLAM map have said about its poses. It is on no topic; who aligns the
//! next map of the same robot hands it on.

use crate::archive::{ArchiveError, NONE};
use crate::content_hash::ContentHash;
use crate::declaration::declare_archive;
use crate::slam_map::SlamMapHead;
use bytemuck::{Pod, Zeroable};
use frames::{Map, Rigid2, Slam};

/// Head of the evidence: one record.
#[derive(Debug, Clone, Copy, PartialEq, Zeroable, Pod)]
#[repr(C)]
pub struct AlignmentEvidenceHead {
    /// What the model's maps were: evidence of others says nothing. Content hash of the site, or what identifies map files.
    pub references_hash: ContentHash,
    /// Content hash of the SLAM map of the last look that counted.
    pub slam_map_hash: ContentHash,
    /// Content hash of the evidence before that look; 0 before the first.
    pub before_hash: ContentHash,
    /// Lower left corner of the cells in the frame of the SLAM map: x, y in metres, yaw in radians. Its rows and columns are
    /// those of the first map.
    pub origin: [f64; 3],
    /// Columns and rows.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Looks that counted.
    pub n_looks: u32,
    /// Index of the pose that a look has accepted; [`NONE`] if none was, or if it was not found again.
    pub accepted: u32,
}
const _: () = assert!(size_of::<AlignmentEvidenceHead>() == 64);

/// What is known of a pose.
#[derive(Debug, Clone, Copy, PartialEq, Zeroable, Pod)]
#[repr(C)]
pub struct PoseHistoryRecord {
    /// `map_from_slam` at the last look that counted: x, y in metres, yaw in radians.
    pub map_from_slam: [f64; 3],
    /// The middle of the area that was mapped then, in the frame of the SLAM map.
    pub about_m: [f64; 2],
    /// Log odds that the SLAM map is of this building and storey, at the look from which the lengths count.
    pub of_this_building: f64,
    /// Length of the model's walls that came in sight since, in places that were unknown before.
    pub seen_m: f64,
    /// Length of them that the SLAM map has.
    pub recalled_m: f64,
    /// Length of them that the robot saw through.
    pub through_m: f64,
    /// Map storey; [`NONE`] for a map without a site.
    pub map_storey: u32,
    /// Zero.
    pub reserved: u32,
}
const _: () = assert!(size_of::<PoseHistoryRecord>() == 80);

impl PoseHistoryRecord {
    /// The motion from the robot's map to the model's.
    pub fn map_from_slam(&self) -> Rigid2<Map, Slam> {
        Rigid2::of_x_y_yaw(self.map_from_slam)
    }
}

declare_archive! {
    /// Evidence over looks, read in place.
    view AlignmentEvidence;
    /// An `alignment-evidence` archive to be.
    owned AlignmentEvidenceBuilder;
    sections {
        /// Head of the evidence.
        pub head: one(1, AlignmentEvidenceHead),
        /// Poses that fit the map of the last look that counted, best first.
        pub poses: at_most(2, PoseHistoryRecord, AlignmentEvidence::MAX_POSES),
        /// A bit for each cell, row-major from the lower left, the lowest bit of a byte first: 1 if any look has known the cell.
        known: many(3, u8),
    }
}

impl<'a> AlignmentEvidence<'a> {
    /// Poses of the most storeys that a site has.
    pub const MAX_POSES: usize = 4096;
    /// Side of a cell.
    pub const CELL_M: f64 = 0.05;

    fn check(&self) -> Result<(), ArchiveError> {
        let Self { head, poses, known, .. } = *self;
        let n_cells = u64::from(head.width) * u64::from(head.height);
        let is_place = |c: &f64| c.abs() < SlamMapHead::MAX_COORDINATE_M;
        let is_pose = |pose: &PoseHistoryRecord| {
            let lengths = [pose.seen_m, pose.recalled_m, pose.through_m];
            pose.map_from_slam.iter().chain(&pose.about_m).all(is_place)
                && pose.of_this_building.is_finite()
                && lengths.iter().all(|m| (0.0..SlamMapHead::MAX_COORDINATE_M).contains(m))
        };
        let whole = n_cells <= SlamMapHead::MAX_CELLS
            && known.len() as u64 == n_cells.div_ceil(8)
            && head.origin.iter().all(is_place)
            && (head.accepted == NONE || (head.accepted as usize) < poses.len())
            && poses.iter().all(is_pose);
        if whole { Ok(()) } else { Err(ArchiveError::Index { what: "evidence for a pose" }) }
    }

    /// True if any look has known a cell, by its number in row-major order.
    pub fn is_known(&self, index: usize) -> bool {
        self.known.get(index / 8).is_some_and(|byte| byte >> (index % 8) & 1 == 1)
    }

    /// The pose that a look has accepted.
    pub fn accepted(&self) -> Option<&'a PoseHistoryRecord> {
        self.poses.get(self.head.accepted as usize)
    }
}

impl AlignmentEvidenceBuilder {
    /// Nothing known yet. Poses, best first, beyond [`AlignmentEvidence::MAX_POSES`] are left out.
    pub fn new(head: AlignmentEvidenceHead, mut poses: Vec<PoseHistoryRecord>) -> Self {
        poses.truncate(AlignmentEvidence::MAX_POSES);
        let n_cells = head.width as usize * head.height as usize;
        Self { head, poses, known: vec![0; n_cells.div_ceil(8)] }
    }

    /// Marks a cell as known, by its number in row-major order.
    ///
    /// # Panics
    /// No such cell.
    pub fn mark_known(&mut self, index: usize) {
        self.known[index / 8] |= 1 << (index % 8);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn builder() -> AlignmentEvidenceBuilder {
        let head = AlignmentEvidenceHead { width: 5, height: 3, n_looks: 1, accepted: 0, ..Zeroable::zeroed() };
        let mut builder = AlignmentEvidenceBuilder::new(head, vec![Zeroable::zeroed(); 2]);
        [0, 7, 14].into_iter().for_each(|k| builder.mark_known(k));
        builder
    }

    #[test]
    fn what_was_known_comes_back_and_what_does_not_fit_is_refused() {
        let buffer = builder().finish();
        let evidence = AlignmentEvidence::open(buffer.bytes()).unwrap();
        let known: Vec<usize> = (0..20).filter(|k| evidence.is_known(*k)).collect();
        assert_eq!((known, evidence.accepted()), (vec![0, 7, 14], evidence.poses.first()));
        let refused = |change: fn(&mut AlignmentEvidenceBuilder)| {
            let mut builder = builder();
            change(&mut builder);
            AlignmentEvidence::open(builder.finish().bytes()).is_err()
        };
        assert!(refused(|b| b.head.width = 6));
        assert!(refused(|b| b.head.accepted = 2));
        assert!(refused(|b| b.head.origin[2] = f64::NAN));
        assert!(refused(|b| b.poses[1].of_this_building = f64::INFINITY));
        assert!(refused(|b| b.poses[0].seen_m = -1.0));
    }
}
