//! The frame of a robot's map as it lies in the model's, from place to place.

use crate::alignment::Alignment;
use crate::alignment_records::{PoseRecord, PoseValidity};
use crate::local_poses::{LocalPoseRecord, LocalPosesHead, part_at};
use frames::{BentMotion, Map, PoseCovariance, Rigid2, Slam};

/// See [`SlamFrame::is_known_at`]: robots leave so much room anyway, and walls farther than that from where they are expected are others.
/// The validity of a pose asks for more, 0.1 m (`pose_field.rs` of `alignment`).
const USABLE_WITHIN_M: f64 = 0.2;

/// Where a robot's map, which bends, lies in the model's map.
#[derive(Debug)]
pub struct SlamFrame {
    /// From the robot's map into the model's.
    pub motion: BentMotion<Map, Slam>,
    /// Of the whole map.
    whole: PoseRecord,
    parts: Vec<LocalPoseRecord>,
    blocks: Vec<u32>,
    head: Option<LocalPosesHead>,
}

impl SlamFrame {
    /// A map that does not bend, by a pose of all of it.
    pub fn rigid(whole: &PoseRecord) -> Self {
        let motion = BentMotion::rigid(whole.map_from_slam());
        Self { motion, whole: *whole, parts: Vec::new(), blocks: Vec::new(), head: None }
    }

    /// The pose of the whole map.
    pub fn map_from_slam(&self) -> Rigid2<Map, Slam> {
        self.whole.map_from_slam()
    }

    /// Index of the map storey.
    pub fn map_storey(&self) -> u32 {
        self.whole.map_storey
    }

    /// How far the pose of the whole map puts a part of it from where that is known to lie, at most, in metres.
    pub fn largest_bend_m(&self) -> f64 {
        let whole = self.map_from_slam();
        let off_m2 = |part: &LocalPoseRecord| square_m2(self.motion.apply(part.about_m), whole.apply(part.about_m));
        self.parts.iter().filter(|part| is_known(part)).map(off_m2).fold(0.0, f64::max).sqrt()
    }

    /// True if the place in the model of a place in the robot's map, in metres, is known well enough to say what is there: to a deviation
    /// of 0.2 m. What lies beyond the robot's map is taken as known as its border is: nothing has shown yet how the map will bend there.
    pub fn is_known_at(&self, in_slam_m: [f64; 2]) -> bool {
        self.part_around(in_slam_m).is_none_or(is_known)
    }

    /// The covariance of where a place of the robot's map, in metres, lies in the model's, and of yaw.
    pub fn covariance_at(&self, in_slam_m: [f64; 2]) -> PoseCovariance {
        let own = self.part_around(in_slam_m).map(|part| (part.pose_covariance(), part.about_m));
        let (covariance, about_m) = own.unwrap_or((self.whole.pose_covariance(), self.whole.about_m));
        let (at, about) = (self.motion.apply(in_slam_m), self.motion.apply(about_m));
        covariance.transported([at[0] - about[0], at[1] - about[1]])
    }

    /// True if another frame puts what both know elsewhere by more than a limit in metres, or knows other parts.
    pub fn differs_from(&self, other: &Self, limit_m: f64) -> bool {
        let places = |frame: &Self| -> Vec<[f64; 2]> {
            let parts = frame.parts.iter().map(|part| part.about_m);
            parts.chain(frame.parts.is_empty().then_some(frame.whole.about_m)).collect()
        };
        let differs = |place: [f64; 2]| match (self.is_known_at(place), other.is_known_at(place)) {
            (true, true) => square_m2(self.motion.apply(place), other.motion.apply(place)) > limit_m * limit_m,
            (of_self, of_other) => of_self != of_other,
        };
        self.whole.map_storey != other.whole.map_storey || places(self).into_iter().chain(places(other)).any(differs)
    }

    /// The part of a place, or the nearest one.
    fn part_around(&self, in_slam_m: [f64; 2]) -> Option<&LocalPoseRecord> {
        let head = self.head.as_ref()?;
        let beside = part_at(&self.blocks, head.n_columns as usize, head.in_blocks(in_slam_m), head.block_m);
        let far = |part: &&LocalPoseRecord| square_m2(part.about_m, in_slam_m);
        let nearest = || self.parts.iter().min_by(|a, b| far(a).total_cmp(&far(b)));
        beside.map(|part| &self.parts[part]).or_else(nearest)
    }
}

fn is_known(part: &LocalPoseRecord) -> bool {
    part.pose_covariance().worst_m() <= USABLE_WITHIN_M
}

/// Square of the distance of two places.
fn square_m2(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1])
}

impl Alignment<'_> {
    /// The frame of the robot's map, to move maps and goals into it; `None` without a pose that may be used, or of which no part of the
    /// map is known well enough. A pose that is uncertain may be used around some of its parts ([`Alignment::usable`]): then there is a
    /// frame, which says of each place whether it is known there.
    pub fn slam_frame(&self) -> Option<SlamFrame> {
        let (whole, validity) = (self.pose()?, self.validity());
        match (self.local_poses, validity) {
            (None, PoseValidity::Effective) => Some(SlamFrame::rigid(whole)),
            (Some(local), PoseValidity::Effective | PoseValidity::Uncertain) => {
                let motion = BentMotion::of(
                    local.parts.iter().map(|part| (part.about_m, part.map_from_slam(), part.deviation_m())),
                )?;
                let is_known = |part: &LocalPoseRecord| local.head.is_enough(&part.pose_covariance());
                local.parts.iter().any(is_known).then(|| SlamFrame {
                    motion,
                    whole: *whole,
                    parts: local.parts.to_vec(),
                    blocks: local.blocks.to_vec(),
                    head: Some(*local.head),
                })
            }
            _ => None,
        }
    }
}

impl LocalPoseRecord {
    fn map_from_slam(&self) -> Rigid2<Map, Slam> {
        Rigid2::of_x_y_yaw(self.map_from_slam)
    }

    /// Of its place; at least a millimetre, since nothing is known better.
    fn deviation_m(&self) -> f64 {
        self.pose_covariance().worst_m().max(1e-3)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::alignment::AlignmentBuilder;
    use crate::alignment_records::{AlignmentHead, AlignmentVerdict, PoseState};
    use crate::archive::{ArchiveBuffer, NONE};
    use crate::local_poses::LocalPosesParts;
    use bytemuck::Zeroable;

    /// A part of 3 m whose place is known to a deviation, and lies that far beside where the pose of the whole map puts it.
    fn part(x_m: f64, deviation_m: f64, off_m: f64) -> LocalPoseRecord {
        let variance = deviation_m * deviation_m;
        LocalPoseRecord {
            map_from_slam: [0.0, off_m, 0.0],
            covariance: [variance, 0.0, 0.0, 0.0, variance, 0.0, 0.0, 0.0, 1e-6],
            about_m: [x_m, 1.5],
            ..LocalPoseRecord::zeroed()
        }
    }

    /// Three parts beside each other, of which the middle one belongs to no block.
    fn alignment(parts: [LocalPoseRecord; 3], validity: PoseValidity) -> ArchiveBuffer {
        let head = AlignmentHead {
            pose: PoseRecord { map_storey: 1, ..PoseRecord::NONE },
            waiting: PoseRecord::NONE,
            verdict: AlignmentVerdict::Accepted.into(),
            state: PoseState::Found.into(),
            validity: validity.into(),
            ..AlignmentHead::zeroed()
        };
        let local_head =
            LocalPosesHead { block_m: 3.0, n_columns: 3, max_deviation: [0.1, 0.1], ..LocalPosesHead::zeroed() };
        let blocks = vec![0, NONE, 2];
        let local_poses =
            LocalPosesParts { head: local_head, parts: parts.to_vec(), blocks, rings: vec![], corners: vec![] };
        let mut builder = AlignmentBuilder::new(head, "", Vec::new());
        builder.local_poses = Some(local_poses);
        builder.finish()
    }

    fn frame(parts: [LocalPoseRecord; 3], validity: PoseValidity) -> Option<SlamFrame> {
        Alignment::open(alignment(parts, validity).bytes()).unwrap().slam_frame()
    }

    #[test]
    fn a_frame_says_what_is_known_of_each_part_and_beyond_the_map_what_its_border_is() {
        let parts = [part(1.5, 0.05, 0.0), part(4.5, 0.15, 0.3), part(7.5, 0.5, 9.0)];
        let frame = frame(parts, PoseValidity::Uncertain).unwrap();
        assert_eq!(
            [[1.5, 1.5], [-40.0, 1.5], [7.5, 1.5], [60.0, 1.5]].map(|p| frame.is_known_at(p)),
            [true, true, false, false]
        );
        assert!((frame.covariance_at([1.5, 1.5]).worst_m() - 0.05).abs() < 1e-9);
        let bend_m = frame.largest_bend_m();
        assert!(0.1 < bend_m && bend_m < 1.0, "a part of which nothing is known bends nothing: {bend_m}");
        assert_eq!(frame.map_storey(), 1);
    }

    #[test]
    fn there_is_none_without_a_known_part_or_without_a_pose_that_may_be_used() {
        let parts = [part(1.5, 0.05, 0.0), part(4.5, 0.05, 0.0), part(7.5, 0.05, 0.0)];
        assert!(frame(parts, PoseValidity::Effective).is_some());
        for validity in [PoseValidity::Held, PoseValidity::Refused, PoseValidity::WaitsForConfirm] {
            assert!(frame(parts, validity).is_none());
        }
        assert!(frame([1.5, 4.5, 7.5].map(|x_m| part(x_m, 0.12, 0.0)), PoseValidity::Uncertain).is_none());
    }

    #[test]
    fn an_uncertain_pose_may_be_used_around_the_parts_that_are_known() {
        let parts = [part(1.5, 0.05, 0.0), part(4.5, 0.05, 0.0), part(7.5, 0.5, 0.0)];
        let usable = |validity, robot_m| {
            let buffer = alignment(parts, validity);
            let view = Alignment::open(buffer.bytes()).unwrap();
            let why = view.why_not_usable(robot_m).unwrap_or_default();
            (view.usable(robot_m).map(|pose| pose.about_m), why)
        };
        assert_eq!(usable(PoseValidity::Uncertain, Some([1.5, 1.5])), (Ok([1.5, 1.5]), String::new()));
        let (beyond, why) = usable(PoseValidity::Uncertain, Some([7.5, 1.5]));
        assert!(
            beyond == Err(PoseValidity::Uncertain) && why.contains("around the robot hold the pose to 0.5"),
            "{why}"
        );
        let (nowhere, why) = usable(PoseValidity::Effective, Some([40.0, 1.5]));
        assert!(nowhere == Err(PoseValidity::Uncertain) && why.contains("shows no floor around x 40.00 m"), "{why}");
        let (anywhere, why) = usable(PoseValidity::Uncertain, None);
        assert!(
            anywhere == Err(PoseValidity::Uncertain) && why.contains("may be used only where the robot is"),
            "{why}"
        );
        assert_eq!(usable(PoseValidity::Held, Some([1.5, 1.5])).0, Err(PoseValidity::Held));
    }

    #[test]
    fn frames_differ_by_what_both_know_and_by_what_they_know() {
        let of = |parts| frame(parts, PoseValidity::Uncertain).unwrap();
        let base = of([part(1.5, 0.05, 0.0), part(4.5, 0.05, 0.0), part(7.5, 0.5, 0.0)]);
        let same = of([part(1.5, 0.05, 0.02), part(4.5, 0.05, 0.02), part(7.5, 0.5, 0.9)]);
        assert!(!base.differs_from(&same, 0.05) && !same.differs_from(&base, 0.05));
        let moved = of([part(1.5, 0.05, 0.1), part(4.5, 0.05, 0.1), part(7.5, 0.5, 0.0)]);
        assert!(base.differs_from(&moved, 0.05));
        let known = of([part(1.5, 0.05, 0.0), part(4.5, 0.05, 0.0), part(7.5, 0.05, 0.0)]);
        assert!(base.differs_from(&known, 0.05) && known.differs_from(&base, 0.05));
    }
}
