//! The frame of a robot's map as it lies in the model's, from place to place.

use crate::alignment::Alignment;
use crate::alignment_records::{PoseRecord, PoseValidity};
use crate::local_poses::{LocalPoseRecord, LocalPosesHead, part_at};
use frames::{BentMotion, Map, PoseCovariance, Rigid2, Slam};

/// See [`SlamFrame::is_known_at`]: robots leave so much room anyway, and walls farther than that from where they are expected are others.
const KNOWN_M: f64 = 0.2;

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

    /// How far the pose of the whole map puts a part of it from where it lies, at most, in metres.
    pub fn largest_bend_m(&self) -> f64 {
        let whole = self.map_from_slam();
        let off_m2 = |part: &LocalPoseRecord| square_m2(self.motion.apply(part.about_m), whole.apply(part.about_m));
        self.parts.iter().map(off_m2).fold(0.0, f64::max).sqrt()
    }

    /// True if the place in the model of a place in the robot's map, in metres, is known well enough to say what is there: to a deviation
    /// of 0.2 m. What lies beyond the robot's map is taken as known as its border is: nothing has shown yet how the map will bend there.
    pub fn is_known_at(&self, in_slam_m: [f64; 2]) -> bool {
        self.part_around(in_slam_m).is_none_or(|part| part.pose_covariance().worst_m() <= KNOWN_M)
    }

    /// The covariance of where a place of the robot's map, in metres, lies in the model's, and of yaw.
    pub fn covariance_at(&self, in_slam_m: [f64; 2]) -> PoseCovariance {
        let own = self.part_around(in_slam_m).map(|part| (part.pose_covariance(), part.about_m));
        let (covariance, about_m) = own.unwrap_or((self.whole.pose_covariance(), self.whole.about_m));
        let (at, about) = (self.motion.apply(in_slam_m), self.motion.apply(about_m));
        covariance.transported([at[0] - about[0], at[1] - about[1]])
    }

    /// True if another frame puts a part of this map, or this one a part of the other, elsewhere by more than a limit in metres, or if it
    /// is known of another part where that lies.
    pub fn differs_from(&self, other: &Self, limit_m: f64) -> bool {
        let places = |frame: &Self| -> Vec<[f64; 2]> {
            let parts = frame.parts.iter().map(|part| part.about_m);
            parts.chain(frame.parts.is_empty().then_some(frame.whole.about_m)).collect()
        };
        let differs = |place: [f64; 2]| {
            let (a, b) = (self.motion.apply(place), other.motion.apply(place));
            square_m2(a, b) > limit_m * limit_m || self.is_known_at(place) != other.is_known_at(place)
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

/// Square of the distance of two places.
fn square_m2(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1])
}

impl Alignment<'_> {
    /// The frame of the robot's map, to move maps and goals into it; `None` without a pose that may be used, or of which no part of the
    /// map is known well enough.
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
