//! The pose of a SLAM map from place to place: one for each part of the map, since a map bends.

use crate::alignment_records::PoseRecord;
use crate::archive::NONE;
use crate::declaration::declare_sections;
use bytemuck::{Pod, Zeroable};
use frames::{PoseCovariance, Rigid2, Slam};

/// What is known of a SLAM map as a whole: one record.
#[derive(Debug, Clone, Copy, PartialEq, Zeroable, Pod)]
#[repr(C)]
pub struct LocalPosesHead {
    /// Pose of the lower left corner of the blocks in the SLAM map: x, y in metres, yaw in radians.
    pub slam_from_blocks: [f64; 3],
    /// Side of a block, in metres.
    pub block_m: f64,
    /// How far any place of the map lies from where the current pose puts it, as a standard deviation in metres, on average over its
    /// floor.
    pub anywhere_m: f64,
    /// The same of yaw, in radians.
    pub anywhere_rad: f64,
    /// Share of the map's walls for which the current pose holds.
    pub walls_share: f64,
    /// Share of its floor.
    pub area_share: f64,
    /// Of the parts of which the place is known: how far the current pose puts one from it, at most, in metres.
    pub largest_off_m: f64,
    /// Share of the floor of which is not known how far off the current pose is.
    pub unknown_share: f64,
    /// Standard deviations up to which a pose may be used, in metres and radians.
    pub max_deviation: [f64; 2],
    /// Where the robot is in its map, if that was told; then the current pose is that of the map around it.
    pub robot_m: [f64; 2],
    /// 1 if that was told.
    pub has_robot: u32,
    /// Blocks in a row.
    pub n_columns: u32,
}

const _: () = assert!(size_of::<LocalPosesHead>() == 120);

impl LocalPosesHead {
    /// A place in the SLAM map, in metres, in blocks from their lower left corner.
    pub(crate) fn in_blocks(&self, in_slam_m: [f64; 2]) -> [f64; 2] {
        let slam_from_blocks = Rigid2::<Slam, ()>::of_x_y_yaw(self.slam_from_blocks);
        slam_from_blocks.apply_inverse(in_slam_m).map(|c| c / self.block_m)
    }

    /// True if what is known so well may be used.
    pub(crate) fn is_enough(&self, covariance: &PoseCovariance) -> bool {
        let [max_m, max_rad] = self.max_deviation;
        covariance.worst_m() <= max_m && covariance.deviations()[2] <= max_rad
    }
}

/// The pose of a part of a SLAM map.
#[derive(Debug, Clone, Copy, PartialEq, Zeroable, Pod)]
#[repr(C)]
pub struct LocalPoseRecord {
    /// `map_from_slam` there: x, y in metres, yaw in radians.
    pub map_from_slam: [f64; 3],
    /// Covariance of where [`LocalPoseRecord::about_m`] comes to lie (x, y) and of yaw, row-major.
    pub covariance: [f64; 9],
    /// The middle of the part in the SLAM map, in metres.
    pub about_m: [f64; 2],
    /// Area of its floor, in square metres.
    pub area_m2: f64,
    /// Length of its walls, by weight: furniture counts little. In metres.
    pub walls_m: f64,
    /// Length of those that the model has there.
    pub explained_m: f64,
    /// 1 if that bears the pose out; 0 if the parts around foretell it.
    pub is_borne_out: u32,
    /// Zero.
    pub reserved: u32,
}

const _: () = assert!(size_of::<LocalPoseRecord>() == 144);

impl LocalPoseRecord {
    /// The covariance of where [`LocalPoseRecord::about_m`] comes to lie and of yaw.
    pub fn pose_covariance(&self) -> PoseCovariance {
        PoseCovariance::from_rows(std::array::from_fn(|row| std::array::from_fn(|k| self.covariance[3 * row + k])))
    }
}

/// A loop of the outline of the part for which the current pose holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Zeroable, Pod)]
#[repr(C)]
pub struct OutlineRingRecord {
    /// Its first corner among all.
    pub first_corner: u32,
    /// Number of its corners.
    pub n_corners: u32,
    /// 1 if it is the border of a hole of the loop before that is none.
    pub is_hole: u32,
    /// Zero.
    pub reserved: u32,
}

const _: () = assert!(size_of::<OutlineRingRecord>() == 16);

declare_sections! {
    /// The pose of a SLAM map from place to place, read in place.
    view LocalPoses;
    /// The pose of a SLAM map from place to place, to be written.
    #[derive(Clone)]
    owned LocalPosesParts;
    sections {
        /// Of the map as a whole.
        pub head: one(8, LocalPosesHead),
        /// One for each part.
        pub parts: many(9, LocalPoseRecord),
        /// The part of each block, row-major from the lower left corner; [`NONE`] without floor.
        pub(crate) blocks: many(10, u32),
        /// Loops of the outline of the part for which the pose holds.
        rings: many(11, OutlineRingRecord),
        /// Corners of all loops in the SLAM map, in metres.
        corners: many(12, [f64; 2]),
    }
}

impl<'a> LocalPoses<'a> {
    /// The pose of the map around a place in it, as the current pose's record; `None` where the map shows no floor.
    pub fn at(&self, in_slam_m: [f64; 2], whole: &PoseRecord) -> Option<PoseRecord> {
        let in_blocks = self.head.in_blocks(in_slam_m);
        let part = &self.parts[part_at(self.blocks, self.head.n_columns as usize, in_blocks, self.head.block_m)?];
        let own = PoseRecord { map_from_slam: part.map_from_slam, covariance: part.covariance, ..*whole };
        let (at, about) = (own.map_from_slam().apply(in_slam_m), own.map_from_slam().apply(part.about_m));
        let covariance = own.pose_covariance().transported([at[0] - about[0], at[1] - about[1]]);
        Some(PoseRecord { covariance: flat(&covariance), about_m: in_slam_m, ..own })
    }

    /// True if a pose is known less well than asked for.
    pub fn is_uncertain(&self, pose: &PoseRecord) -> bool {
        !self.head.is_enough(&pose.pose_covariance())
    }

    /// Where the robot is in its map, if that was told.
    pub fn robot_m(&self) -> Option<[f64; 2]> {
        (self.head.has_robot == 1).then_some(self.head.robot_m)
    }

    /// The outline of the part for which the current pose holds: loops in the SLAM map in metres, a hole after its border; true for
    /// holes.
    pub fn outline_m(&self) -> impl Iterator<Item = (bool, &'a [[f64; 2]])> + use<'a> {
        let Self { rings, corners, .. } = *self;
        rings.iter().map(move |ring| {
            let corners =
                corners.get(ring.first_corner as usize..).and_then(|rest| rest.get(..ring.n_corners as usize));
            (ring.is_hole == 1, corners.expect("they were checked when the archive was opened"))
        })
    }

    /// True if all of it lies within its sections and is finite.
    pub(crate) fn is_whole(&self) -> bool {
        let LocalPosesHead { slam_from_blocks, block_m, anywhere_m, anywhere_rad, walls_share, .. } = self.head;
        let LocalPosesHead { area_share, largest_off_m, unknown_share, max_deviation, robot_m, .. } = self.head;
        let shares = [*walls_share, *area_share, *unknown_share, *largest_off_m, *anywhere_m, *anywhere_rad];
        let in_head = slam_from_blocks.iter().chain(max_deviation).chain(robot_m).chain(&shares);
        let is_part = |part: &LocalPoseRecord| {
            let own = [part.area_m2, part.walls_m, part.explained_m];
            let mut numbers = part.map_from_slam.iter().chain(&part.covariance).chain(&part.about_m).chain(&own);
            numbers.all(|n| n.is_finite()) && part.is_borne_out <= 1
        };
        let is_ring = |ring: &OutlineRingRecord| {
            let end = u64::from(ring.first_corner) + u64::from(ring.n_corners);
            end <= self.corners.len() as u64 && ring.is_hole <= 1
        };
        let n_columns = self.head.n_columns as usize;
        in_head.into_iter().all(|n| n.is_finite())
            && block_m.is_finite()
            && *block_m > 0.0
            && self.head.has_robot <= 1
            && (self.blocks.is_empty() || (n_columns > 0 && self.blocks.len().is_multiple_of(n_columns)))
            && self.blocks.iter().all(|part| *part == NONE || (*part as usize) < self.parts.len())
            && self.parts.iter().all(is_part)
            && self.rings.iter().all(is_ring)
            && self.corners.iter().flatten().all(|n| n.is_finite())
    }
}

/// Farther from every part than this nothing is known, in metres.
const MAX_BESIDE_M: f64 = 1.5;

/// The part of a place given in blocks from their lower left corner, or the nearest one beside it. `blocks` are those of
/// [`LocalPoses`].
pub fn part_at(blocks: &[u32], n_columns: usize, [x, y]: [f64; 2], block_m: f64) -> Option<usize> {
    let reach = (MAX_BESIDE_M / block_m).min(64.0) as i64;
    let (column, row) = (x.floor() as i64, y.floor() as i64);
    let n_rows = blocks.len().checked_div(n_columns)? as i64;
    let rows = row.saturating_sub(reach).max(0)..row.saturating_add(reach + 1).min(n_rows);
    let columns = column.saturating_sub(reach).max(0)..column.saturating_add(reach + 1).min(n_columns as i64);
    let around = rows.flat_map(|row| columns.clone().map(move |column| [column, row]));
    let known = around.filter_map(|[c, r]| {
        let part = *blocks.get(r as usize * n_columns + c as usize).filter(|part| **part != NONE)?;
        let (dx, dy) = (c as f64 + 0.5 - x, r as f64 + 0.5 - y);
        Some((if [c, r] == [column, row] { 0.0 } else { dx * dx + dy * dy }, part))
    });
    known.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1))).map(|(_, part)| part as usize)
}

/// A covariance row by row.
pub fn flat(covariance: &PoseCovariance) -> [f64; 9] {
    let rows = covariance.rows();
    std::array::from_fn(|k| rows[k / 3][k % 3])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_place_is_that_of_its_block_or_of_the_nearest_one() {
        let blocks = [NONE, NONE, NONE, NONE, 0, NONE, NONE, NONE, NONE, NONE, NONE, 1];
        let at = |x: f64, y: f64| part_at(&blocks, 4, [x, y], 0.5);
        assert_eq!((at(0.5, 1.5), at(3.5, 2.5)), (Some(0), Some(1)));
        assert_eq!((at(1.2, 1.5), at(3.4, 1.5)), (Some(0), Some(1)));
        assert_eq!((at(-9.0, 0.5), at(0.5, 1e300)), (None, None));
    }
}
