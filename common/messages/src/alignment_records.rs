//! Records of an alignment: poses with their evidence, places that decide between them, what hints excluded.

use crate::archive::{NONE, Text};
use crate::content_hash::ContentHash;
use crate::tag::Tag;
use bytemuck::{CheckedBitPattern, NoUninit, Pod, Zeroable};
use frames::{Map, PoseCovariance, Rigid2, Slam};

/// Verdict on an alignment.
#[derive(Debug, Clone, Copy, PartialEq, Eq, CheckedBitPattern, NoUninit)]
#[repr(u32)]
pub enum AlignmentVerdict {
    /// One pose, wrong with a probability below 0.1 %.
    Accepted = 0,
    /// Several poses that fit almost alike.
    Ambiguous = 1,
    /// No pose fits well enough.
    Refused = 2,
}

impl AlignmentVerdict {
    /// Its name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Accepted => "accepted",
            Self::Ambiguous => "ambiguous",
            Self::Refused => "refused",
        }
    }
}

/// How the current pose was obtained.
#[derive(Debug, Clone, Copy, PartialEq, Eq, CheckedBitPattern, NoUninit)]
#[repr(u32)]
pub enum PoseState {
    /// No pose was accepted yet.
    None = 0,
    /// A search of all poses accepted it, of the newest map.
    Found = 1,
    /// The last pose was refined with the newest map.
    Tracked = 2,
    /// The newest map does not confirm it: the last pose is kept.
    Held = 3,
}

impl PoseState {
    /// Its name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Found => "found",
            Self::Tracked => "tracked",
            Self::Held => "held",
        }
    }
}

/// What the pose of an alignment is worth for the newest SLAM map in the current frame. Only an effective pose may be used
/// to move a robot.
#[derive(Debug, Clone, Copy, PartialEq, Eq, CheckedBitPattern, NoUninit)]
#[repr(u32)]
pub enum PoseValidity {
    /// The newest map bears the pose out.
    Effective = 0,
    /// Another pose waits for an operator, who says which of both is right.
    WaitsForConfirm = 1,
    /// The newest map does not bear the pose out, or waits for a search.
    Held = 2,
    /// The newest map was searched, and no pose was accepted.
    Refused = 3,
    /// The newest map bears the pose out, but it is known less well than the site asks for.
    Uncertain = 4,
}

impl PoseValidity {
    /// Its name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Effective => "effective",
            Self::WaitsForConfirm => "waits_for_confirm",
            Self::Held => "held",
            Self::Refused => "refused",
            Self::Uncertain => "uncertain",
        }
    }
}

/// Evidence for a pose. Shares are from 0 to 1.
#[derive(Debug, Clone, Copy, Default, PartialEq, Zeroable, Pod)]
#[repr(C)]
pub struct PoseEvidence {
    /// By which poses are compared: between two poses of one map the difference is the natural logarithm of their odds.
    pub log_odds: f64,
    /// Agreement of walls, from 0 to 1: of precision and recall.
    pub score: f64,
    /// Share of the SLAM map's walls that the model has.
    pub precision: f64,
    /// Share of the visible walls of the model that the SLAM map has.
    pub recall: f64,
    /// Share of the SLAM map's free cells that are free in the model.
    pub free: f64,
    /// Length of the faces of the model's walls that the robot would have had in sight, in metres.
    pub seen_m: f64,
    /// Share of them that it saw through.
    pub seen_through: f64,
    /// Share of the SLAM map's occupied cells that lie in walls of the model.
    pub in_walls: f64,
    /// Share of them that lie where the model knows nothing.
    pub outside: f64,
    /// Share of the SLAM map's free cells that lie in walls of the model.
    pub free_in_walls: f64,
    /// Length of the SLAM map's walls that lie on faces of the model, of each face at most half a metre, in metres.
    pub distinct_m: f64,
}

/// A pose of the robot's map in the model's.
#[derive(Debug, Clone, Copy, PartialEq, Zeroable, Pod)]
#[repr(C)]
pub struct PoseRecord {
    /// `map_from_slam`: x, y in metres, yaw in radians.
    pub map_from_slam: [f64; 3],
    /// Covariance of the position of [`PoseRecord::about_m`] (x, y) and of yaw, row-major.
    pub covariance: [f64; 9],
    /// The middle of the mapped area, in the frame of the SLAM map.
    pub about_m: [f64; 2],
    /// Evidence for it.
    pub evidence: PoseEvidence,
    /// Map storey; [`NONE`] for a map without a site.
    pub map_storey: u32,
    /// Zero.
    pub reserved: u32,
}
const _: () = assert!(size_of::<PoseRecord>() == 208);

impl PoseRecord {
    /// No pose.
    pub const NONE: Self = Self {
        map_from_slam: [0.0; 3],
        covariance: [0.0; 9],
        about_m: [0.0; 2],
        evidence: PoseEvidence {
            log_odds: 0.0,
            score: 0.0,
            precision: 0.0,
            recall: 0.0,
            free: 0.0,
            seen_m: 0.0,
            seen_through: 0.0,
            in_walls: 0.0,
            outside: 0.0,
            free_in_walls: 0.0,
            distinct_m: 0.0,
        },
        map_storey: NONE,
        reserved: 0,
    };

    /// The motion from the robot's map to the model's.
    pub fn map_from_slam(&self) -> Rigid2<Map, Slam> {
        Rigid2::of_x_y_yaw(self.map_from_slam)
    }

    /// The covariance of where [`PoseRecord::about_m`] comes to lie and of yaw.
    pub fn pose_covariance(&self) -> PoseCovariance {
        PoseCovariance::from_rows([0, 1, 2].map(|r| [0, 1, 2].map(|c| self.covariance[3 * r + c])))
    }

    pub(crate) fn is_finite(&self) -> bool {
        let evidence: [f64; 11] = bytemuck::cast(self.evidence);
        let numbers = self.map_from_slam.iter().chain(&self.covariance).chain(&self.about_m).chain(&evidence);
        numbers.into_iter().all(|n| n.is_finite())
    }
}

/// Head of an alignment: one record.
#[derive(Debug, Clone, Copy, PartialEq, Zeroable, Pod)]
#[repr(C)]
pub struct AlignmentHead {
    /// Content hash of the site; 0 for maps without one.
    pub site_hash: ContentHash,
    /// Content hash of the newest SLAM map, for which the pose is valid or not.
    pub slam_map_hash: ContentHash,
    /// Content hash of the SLAM map that verdict, reason and candidates are of; another one than the newest while that waits
    /// for its search, 0 if none was searched.
    pub searched_map_hash: ContentHash,
    /// The plan time of the reference, or [`crate::ScheduleStateHead::NO_TIME`].
    pub plan_time_s: i64,
    /// The current pose; zeros unless [`AlignmentHead::state`] says that there is one.
    pub pose: PoseRecord,
    /// A pose that waits for an operator to confirm it; zeros unless [`AlignmentHead::is_waiting`].
    pub waiting: PoseRecord,
    /// Probability that the best pose of the map that was searched last is wrong; 1 before a search.
    pub wrong_probability: f64,
    /// Scale of the SLAM map against the model; 1 if its lengths are right.
    pub scale: f64,
    /// Standard deviation of the scale.
    pub scale_deviation: f64,
    /// Why the newest verdict is not `accepted`; empty if it is.
    pub reason: Text,
    /// What would decide between candidates that fit alike, for people; empty where nothing has to be decided.
    pub decision: Text,
    /// What became of the pose that an earlier look at the same map accepted; empty if it still is, or if none was.
    pub change: Text,
    /// Verdict on the map that was searched last.
    pub verdict: Tag<AlignmentVerdict>,
    /// How the current pose was obtained.
    pub state: Tag<PoseState>,
    /// 1 if there is a pending pose.
    pub is_waiting: u32,
    /// What the current pose is worth.
    pub validity: Tag<PoseValidity>,
    /// Of the pairs of candidates, the first of those that nothing in the model tells apart; those before are of deciding places.
    pub first_undecided: u32,
    /// Zero.
    pub reserved: u32,
}
const _: () = assert!(size_of::<AlignmentHead>() == 520);

/// A place at which the robot finds out which of the candidates is right.
#[derive(Debug, Clone, Copy, PartialEq, Zeroable, Pod)]
#[repr(C)]
pub struct DecidingPlaceRecord {
    /// In the frame of the SLAM map, in metres: there the robot can drive whichever pose is right.
    pub in_slam_m: [f64; 2],
    /// Way from the nearest place that the SLAM map shows, along its rows and columns, in metres.
    pub way_m: f64,
    /// Length of the walls in view that stand by one pose and not by another, averaged over all pairs of poses, in metres.
    pub differing_m: f64,
    /// Where it lies by each of the best candidates, in their order.
    pub first_placed: u32,
    /// Number of those.
    pub n_placed: u32,
    /// Pairs of candidates that are told apart here.
    pub first_pair: u32,
    /// Number of those.
    pub n_pairs: u32,
}
const _: () = assert!(size_of::<DecidingPlaceRecord>() == 48);

/// Where a place lies by a candidate.
#[derive(Debug, Clone, Copy, PartialEq, Zeroable, Pod)]
#[repr(C)]
pub struct PlacedRecord {
    /// In the model's map, in metres.
    pub in_map_m: [f64; 2],
    /// GlobalId of the room in which it lies; empty in no room.
    pub room_global_id: Text,
    /// Name of the room.
    pub room_name: Text,
    /// Long name of the room.
    pub room_long_name: Text,
}
const _: () = assert!(size_of::<PlacedRecord>() == 40);

/// Two candidates, by index.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Zeroable, Pod)]
#[repr(C)]
pub struct PosePairRecord {
    /// The indices.
    pub candidates: [u32; 2],
}
const _: () = assert!(size_of::<PosePairRecord>() == 8);

/// What a place hint has excluded.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Zeroable, Pod)]
#[repr(C)]
pub struct HintRecord {
    /// What people call it.
    pub label: Text,
    /// Number of the poses that fit about as well as the best one of all, and contradict the hint.
    pub n_excluded: u32,
    /// Zero.
    pub reserved: u32,
}
const _: () = assert!(size_of::<HintRecord>() == 16);
