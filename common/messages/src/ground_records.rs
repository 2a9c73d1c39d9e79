//! Records of the `ground` archive, and the classes of ground that `site` and `ground` share.

use crate::content_hash::ContentHash;
use crate::tag::Tag;
use bytemuck::{CheckedBitPattern, NoUninit, Pod, Zeroable};

/// What the upward faces of an element are to whoever walks or drives on them: decided once, when the site is made.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, CheckedBitPattern, NoUninit)]
#[repr(u8)]
pub enum GroundClass {
    /// Nothing: its faces carry nobody.
    None = 0,
    /// Slab, flooring, or a part of one.
    Floor = 1,
    /// Ramp and its flights.
    Ramp = 2,
    /// Stair and its flights, and what they are made of.
    StairTread = 3,
    /// A slab between the flights of a stair or ramp.
    Landing = 4,
    /// Terrain: of a geographic element, a stratum, earthworks, or of the site itself.
    Terrain = 5,
    /// Pavement, its courses, roads and their parts.
    Road = 6,
    /// Deck of a scaffold.
    ScaffoldDeck = 7,
    /// Footing: floor only where nothing lies on it.
    Foundation = 8,
}

impl GroundClass {
    /// All classes but none.
    pub const ALL: [Self; 8] = [
        Self::Floor,
        Self::Ramp,
        Self::StairTread,
        Self::Landing,
        Self::Terrain,
        Self::Road,
        Self::ScaffoldDeck,
        Self::Foundation,
    ];

    /// Its name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Floor => "floor",
            Self::Ramp => "ramp",
            Self::StairTread => "stair_tread",
            Self::Landing => "landing",
            Self::Terrain => "terrain",
            Self::Road => "road",
            Self::ScaffoldDeck => "scaffold_deck",
            Self::Foundation => "foundation",
        }
    }

    /// True if maps of storeys take its faces for floor: maps are level, and terrain is an obstacle on them.
    pub fn is_floor_of_maps(self) -> bool {
        matches!(self, Self::Floor | Self::Ramp | Self::Landing | Self::Road | Self::Foundation)
    }

    /// True for what the ground outdoors is made of: terrain and roads.
    pub fn is_outdoors(self) -> bool {
        matches!(self, Self::Terrain | Self::Road)
    }
}

/// What a `ground` archive was made from.
#[derive(Debug, Clone, Copy, PartialEq, Zeroable, Pod)]
#[repr(C)]
pub struct GroundHead {
    /// Content hash of the site.
    pub site_hash: ContentHash,
    /// Content hash of the schedule state.
    pub schedule_state_hash: ContentHash,
    /// Plan time as in [`crate::ScheduleStateHead`].
    pub plan_time_s: i64,
    /// Steepest slope of a face.
    pub max_slope_rad: f64,
}
const _: () = assert!(size_of::<GroundHead>() == 32);

/// An element or a terrain of the site that carries ground.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Zeroable, Pod)]
#[repr(C)]
pub struct GroundBodyRecord {
    /// Element of the site, or `NONE` for a terrain.
    pub element: u32,
    /// Terrain of the site, or `NONE` for an element.
    pub terrain: u32,
    /// Its class.
    pub class: Tag<GroundClass>,
    /// Zero.
    pub reserved: [u8; 3],
}
const _: () = assert!(size_of::<GroundBodyRecord>() == 12);

/// A triangle of ground.
#[derive(Debug, Clone, Copy, PartialEq, Zeroable, Pod)]
#[repr(C)]
pub struct GroundFaceRecord {
    /// Its vertices, counter-clockwise from above.
    pub vertices: [u32; 3],
    /// The body that carries it.
    pub body: u32,
    /// The surface that it is a part of.
    pub surface: u32,
    /// Angle between it and the horizontal plane, from 0 to the steepest slope of the archive.
    pub slope_rad: f32,
    /// Its class: that of its body.
    pub class: Tag<GroundClass>,
    /// Zero.
    pub reserved: [u8; 3],
}
const _: () = assert!(size_of::<GroundFaceRecord>() == 28);

/// A connected surface of one class.
#[derive(Debug, Clone, Copy, PartialEq, Zeroable, Pod)]
#[repr(C)]
pub struct GroundSurfaceRecord {
    /// Area in plan.
    pub area_m2: f64,
    /// Lower corner.
    pub min_tenths: [i32; 3],
    /// Upper corner.
    pub max_tenths: [i32; 3],
    /// First of its faces.
    pub first_face: u32,
    /// Number of its faces.
    pub n_faces: u32,
    /// Class of all of its faces.
    pub class: Tag<GroundClass>,
    /// Zero.
    pub reserved: [u8; 7],
}
const _: () = assert!(size_of::<GroundSurfaceRecord>() == 48);

/// How one gets from a surface to another beside it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, CheckedBitPattern, NoUninit)]
#[repr(u32)]
pub enum GroundConnection {
    /// They share an edge at one height.
    SharedEdge = 1,
    /// One lies a step higher, or one steps over a narrow gap.
    Step = 2,
    /// One is a tread of a stair.
    Stair = 3,
    /// One is a ramp, at its upper or lower end: steps of more than 2 cm down from its side are steps.
    Ramp = 4,
}

impl GroundConnection {
    /// Its name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::SharedEdge => "shared_edge",
            Self::Step => "step",
            Self::Stair => "stair",
            Self::Ramp => "ramp",
        }
    }
}

/// Where two surfaces meet.
#[derive(Debug, Clone, Copy, PartialEq, Zeroable, Pod)]
#[repr(C)]
pub struct GroundConnectionRecord {
    /// The surfaces, the lower number first.
    pub surfaces: [u32; 2],
    /// A place on the common border, the middle one of those that were looked at.
    pub at_tenths: [i32; 3],
    /// How much higher the second surface lies, the median over the border; negative if it is lower.
    pub step_tenths: i32,
    /// Length of the common border in metres.
    pub length_m: f32,
    /// How one gets over it.
    pub kind: Tag<GroundConnection>,
}
const _: () = assert!(size_of::<GroundConnectionRecord>() == 32);
