//! Records of the `deviations` archive.

use crate::content_hash::ContentHash;
use crate::schedule_state::ElementState;
use crate::tag::Tag;
use bytemuck::{CheckedBitPattern, NoUninit, Pod, Zeroable};
use grid::GridSpec;

/// Inputs and pose of a comparison: one record. Lengths in metres, angles in radians.
#[derive(Debug, Clone, Copy, PartialEq, Zeroable, Pod)]
#[repr(C)]
pub struct DeviationsHead {
    /// Content hash of the site.
    pub site_hash: ContentHash,
    /// Content hash of the schedule state.
    pub schedule_state_hash: ContentHash,
    /// Hash of the SLAM map.
    pub slam_map_hash: ContentHash,
    /// Plan time as in [`crate::ScheduleStateHead`].
    pub plan_time_s: i64,
    /// `map_from_slam`: x, y, yaw.
    pub map_from_slam: [f64; 3],
    /// Standard deviations of the position of the middle of the SLAM map (x, y) and of yaw.
    pub pose_deviation: [f64; 3],
    /// Height of the lidar's plane in `map`.
    pub lidar_z_m: f64,
    /// Side of the SLAM map's cells.
    pub slam_cell_m: f64,
    /// Root mean square of the local residuals: the distortion of the SLAM map.
    pub residual_rms_m: f64,
    /// Map storey of the site.
    pub map_storey: u32,
    /// Occupied cells of the SLAM map that lie outside of the storey and were not compared.
    pub n_outside: u32,
    /// Side of a cell of [`crate::Deviations::seen`] in tenths of a millimetre.
    pub cell_tenths: i32,
    /// Column and row of its lower left cell, counted from the frame's origin.
    pub first_cell: [i32; 2],
    /// Its columns.
    pub width: u32,
    /// Its rows.
    pub height: u32,
    /// Zero.
    pub reserved: u32,
}
const _: () = assert!(size_of::<DeviationsHead>() == 136);

impl DeviationsHead {
    /// Where [`crate::Deviations::seen`] lies.
    pub fn spec(&self) -> GridSpec {
        let Self { cell_tenths, first_cell, width, height, .. } = *self;
        GridSpec { cell_tenths, first_cell, width, height }
    }
}

/// State of a cell of the SLAM map.
#[derive(Debug, Clone, Copy, PartialEq, Eq, CheckedBitPattern, NoUninit)]
#[repr(u8)]
pub enum SlamCell {
    /// Not observed.
    Unknown = 0,
    /// No obstacle.
    Free = 1,
    /// An obstacle.
    Occupied = 2,
}

/// Observation of an element by the robot.
#[derive(Debug, Clone, Copy, PartialEq, Eq, CheckedBitPattern, NoUninit)]
#[repr(u32)]
pub enum Observation {
    /// It is in its place.
    Observed = 1,
    /// The robot saw through its place.
    Absent = 2,
    /// It is beside its place.
    Displaced = 3,
    /// Not observed.
    Unseen = 4,
}

impl Observation {
    /// All observations.
    pub const ALL: [Self; 4] = [Self::Observed, Self::Absent, Self::Displaced, Self::Unseen];

    /// Its name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Observed => "observed",
            Self::Absent => "absent",
            Self::Displaced => "displaced",
            Self::Unseen => "unseen",
        }
    }
}

/// A difference from the planned state, of which people are told: see [`DeviationVerdict::deviation`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Deviation {
    /// Planned to be built, or removed, and is not yet.
    Late,
    /// Built before it is planned.
    Early,
    /// Built, but not in its place.
    Displaced,
}

/// An observation compared with the planned state.
#[derive(Debug, Clone, Copy, PartialEq, Eq, CheckedBitPattern, NoUninit)]
#[repr(u32)]
pub enum DeviationVerdict {
    /// As planned.
    OnPlan = 1,
    /// Planned to be built, or removed, and is not yet.
    Late = 2,
    /// Built before it is planned.
    Early = 3,
    /// Built, but not in its place.
    Displaced = 4,
    /// It was not seen.
    Unknown = 5,
}

impl DeviationVerdict {
    /// All verdicts.
    pub const ALL: [Self; 5] = [Self::OnPlan, Self::Late, Self::Early, Self::Displaced, Self::Unknown];

    /// How what was seen differs from the plan; `None` if it does not, or if nothing was seen: of these nobody is told.
    pub fn deviation(self) -> Option<Deviation> {
        match self {
            Self::OnPlan | Self::Unknown => None,
            Self::Late => Some(Deviation::Late),
            Self::Early => Some(Deviation::Early),
            Self::Displaced => Some(Deviation::Displaced),
        }
    }

    /// Its name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::OnPlan => "on_plan",
            Self::Late => "late",
            Self::Early => "early",
            Self::Displaced => "displaced",
            Self::Unknown => "unknown",
        }
    }
}

/// Why an element is unseen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, CheckedBitPattern, NoUninit)]
#[repr(u32)]
pub enum UnseenReason {
    /// It is not unseen.
    Seen = 0,
    /// Light passes through it.
    Glass = 1,
    /// It does not cross the lidar's plane.
    NoSection = 2,
    /// Its place was not observed.
    NotSeen = 3,
    /// A door, or a part of one: its leaf moves.
    Door = 4,
    /// Other elements cover all of its sides, or it is a thin layer on them.
    Covered = 5,
    /// Too few samples, or contradicting ones.
    Inconclusive = 6,
    /// The model has a box instead of its shape.
    StandIn = 7,
}

impl UnseenReason {
    /// Its name in files; empty for `Seen`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Seen => "",
            Self::Glass => "glass",
            Self::NoSection => "no_section",
            Self::NotSeen => "not_seen",
            Self::Door => "door",
            Self::Covered => "covered",
            Self::Inconclusive => "inconclusive",
            Self::StandIn => "stand_in",
        }
    }
}

/// The evidence for an element that stands in the storey's slab or crosses the lidar's plane. Samples lie on its sides, as far
/// apart as [`ElementDeviationRecord::sample_m`] says.
#[derive(Debug, Clone, Copy, PartialEq, Zeroable, Pod)]
#[repr(C)]
pub struct ElementDeviationRecord {
    /// Along the outward normal of the side that most samples look from, the local residual taken off; 0 if nothing of it was met.
    pub offset_m: f64,
    /// The same as a vector in `map`; across directions in which nothing was seen it is 0.
    pub displacement_m: [f64; 2],
    /// How sure that is: a standard deviation.
    pub deviation_m: f64,
    /// The local residual that was taken off.
    pub residual_m: [f64; 2],
    /// Distance between samples.
    pub sample_m: f64,
    /// Element of the site.
    pub element: u32,
    /// Observation of it by the robot.
    pub observation: Tag<Observation>,
    /// The observation compared with the planned state.
    pub verdict: Tag<DeviationVerdict>,
    /// Why it is unseen.
    pub reason: Tag<UnseenReason>,
    /// Samples on sides that no other element covers.
    pub n_samples: u32,
    /// Those of them that the robot could judge.
    pub n_visible: u32,
    /// Those where it met the side in its place.
    pub n_confirmed: u32,
    /// Those where free cells lie inside the solid.
    pub n_contradicted: u32,
    /// Its planned state.
    pub planned: Tag<ElementState>,
    /// Zero.
    pub reserved: [u8; 7],
}
const _: () = assert!(size_of::<ElementDeviationRecord>() == 96);

/// A stretch of an element that the robot saw through, while the rest of it stands or was not seen. Metres.
#[derive(Debug, Clone, Copy, PartialEq, Zeroable, Pod)]
#[repr(C)]
pub struct AbsentPartRecord {
    /// Where it begins along the element's axis: from the end with the smaller x, or the smaller y of one that runs along y.
    pub from_m: f64,
    /// Where it ends.
    pub to_m: f64,
    /// The same two places in `map`, on the middle line of the element at the lidar's height.
    pub ends_m: [[f64; 2]; 2],
    /// Standard deviation of each end along the axis.
    pub deviation_m: f64,
    /// Element of the site.
    pub element: u32,
    /// The absence compared with the planned state of the element.
    pub verdict: Tag<DeviationVerdict>,
}
const _: () = assert!(size_of::<AbsentPartRecord>() == 64);

/// Something that stands on the storey and is not in the model.
#[derive(Debug, Clone, Copy, PartialEq, Zeroable, Pod)]
#[repr(C)]
pub struct ObstacleRecord {
    /// Of what was seen of it, in square metres.
    pub area_m2: f64,
    /// The longer side of the smallest box along the map's axes.
    pub length_m: f64,
    /// Area centroid in `map`.
    pub centroid_m: [f64; 2],
    /// First ring of its polygon; exteriors counter-clockwise, holes clockwise.
    pub first_ring: u32,
    /// Number of rings.
    pub n_rings: u32,
    /// Space of the site that its centroid lies in, or `NONE`.
    pub space: u32,
    /// Zero.
    pub reserved: u32,
}
const _: () = assert!(size_of::<ObstacleRecord>() == 48);

/// How far the SLAM map is off around a place: what is bent there.
#[derive(Debug, Clone, Copy, PartialEq, Zeroable, Pod)]
#[repr(C)]
pub struct ResidualRecord {
    /// The place in `map`.
    pub at_m: [f64; 2],
    /// SLAM map less model.
    pub residual_m: [f64; 2],
    /// Standard deviation in the direction that is held worst.
    pub deviation_m: f64,
    /// Samples that say so.
    pub n_samples: u32,
    /// Zero.
    pub reserved: u32,
}
const _: () = assert!(size_of::<ResidualRecord>() == 48);
