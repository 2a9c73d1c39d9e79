//! Flight waypoints in a `mission-plan` archive: places in the air that keep a distance from all that stands, and which of them are
//! joined by a straight way that keeps it too.

use crate::archive::NONE;
use crate::declaration::declare_sections;
use crate::spans::optional;
use crate::tag::Tag;
use bytemuck::{CheckedBitPattern, NoUninit, Pod, Zeroable};

/// What flight waypoints were planned with: one record.
#[derive(Debug, Clone, Copy, PartialEq, Zeroable, Pod)]
#[repr(C)]
pub struct FlightHead {
    /// Least distance from what stands and from rooms that are closed, in metres.
    pub clearance_m: f64,
    /// Largest distance in plan of waypoints that are joined, in metres.
    pub spacing_m: f64,
    /// Distance in plan of the places that were tried, in metres; 0 if none were.
    pub step_m: f64,
    /// Number of connected parts.
    pub n_parts: u32,
    /// Zero.
    pub reserved: u32,
}
const _: () = assert!(size_of::<FlightHead>() == 32);

impl FlightHead {
    /// Farther than this no distance is measured.
    pub const MEASURED_M: f64 = 5.0;
}

/// A place to fly to.
#[derive(Debug, Clone, Copy, PartialEq, Zeroable, Pod)]
#[repr(C)]
pub struct FlightWaypointRecord {
    /// Distance to the nearest face of what stands, at most [`FlightHead::MEASURED_M`], in metres.
    pub clearance_m: f64,
    /// Position in `map`.
    pub position_in_map_tenths: [i32; 3],
    /// Height of the highest ground of the storey within the clearance around it in plan, in `map`.
    pub ground_z_tenths: i32,
    /// Map storey of the site over whose floor it lies.
    pub map_storey: u32,
    /// Place of its height in the list of heights.
    pub height: u32,
    /// Space of the site over whose floor it lies; `NONE` outside of spaces.
    pub space: u32,
    /// Connected part, from 0.
    pub part: u32,
    /// Element of the site that is nearest; `NONE` if none is within [`FlightHead::MEASURED_M`], or if terrain is.
    pub element: u32,
    /// Terrain of the site that is nearest; else `NONE`.
    pub terrain: u32,
}
const _: () = assert!(size_of::<FlightWaypointRecord>() == 48);

/// Why there is no flight waypoint over a space at a height.
#[derive(Debug, Clone, Copy, PartialEq, Eq, CheckedBitPattern, NoUninit)]
#[repr(u32)]
pub enum NoFlight {
    /// There is one.
    Has = 0,
    /// None was requested.
    NotAsked = 1,
    /// The space is blocked at the plan time.
    Blocked = 2,
    /// No place that was tried lies over floor of it.
    NoFloor = 3,
    /// No place that was tried keeps the clearance.
    TooNarrow = 4,
    /// All places that keep the clearance lie within a body.
    WithinBody = 5,
    /// There are more places or waypoints than are planned: nothing is.
    TooLarge = 6,
    /// Another floor lies between the floor of the space and that height.
    OtherFloor = 7,
}

impl NoFlight {
    /// Its name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Has => "",
            Self::NotAsked => "not_asked",
            Self::Blocked => "blocked",
            Self::NoFloor => "no_floor",
            Self::TooNarrow => "too_narrow",
            Self::WithinBody => "within_body",
            Self::TooLarge => "too_large",
            Self::OtherFloor => "other_floor",
        }
    }
}

/// Outcome of a space at a height.
#[derive(Debug, Clone, Copy, PartialEq, Zeroable, Pod)]
#[repr(C)]
pub struct FlightSpaceRecord {
    /// The largest distance from what stands and from closed rooms that a place over it was found to have, in metres, where none keeps
    /// the clearance; else 0.
    pub largest_clearance_m: f64,
    /// Number of waypoints.
    pub n_waypoints: u32,
    /// Why there is none.
    pub why: Tag<NoFlight>,
}
const _: () = assert!(size_of::<FlightSpaceRecord>() == 16);

declare_sections! {
    /// Flight waypoints, read in place.
    view Flight;
    /// Records of flight waypoints to be.
    #[derive(Clone)]
    owned FlightRecords;
    sections {
        /// What they were planned with.
        pub head: one(32, FlightHead),
        /// Heights above ground, ascending, in metres.
        pub heights_m: many(33, f64),
        /// The waypoints.
        pub waypoints: many(34, FlightWaypointRecord),
        /// Pairs of waypoints between which the straight way keeps the clearance, each once, the lower number first, ascending.
        pub edges: many(35, [u32; 2]),
        /// Of each space of the site one record for each height.
        pub spaces: many(36, FlightSpaceRecord),
    }
}

impl<'a> Flight<'a> {
    /// The records of a space, one for each height.
    pub fn of_space(&self, space: usize) -> &'a [FlightSpaceRecord] {
        let n = self.heights_m.len();
        self.spaces.get(space * n..(space + 1) * n).unwrap_or_default()
    }

    /// True if numbers are numbers, and records meant by others are there.
    pub(crate) fn is_whole(&self, n_spaces: usize) -> bool {
        let FlightHead { clearance_m, spacing_m, step_m, n_parts, .. } = *self.head;
        let (n_heights, n_waypoints) = (self.heights_m.len(), self.waypoints.len() as u32);
        let lengths = [clearance_m, spacing_m, step_m].into_iter().chain(self.heights_m.iter().copied());
        let is_place = |w: &FlightWaypointRecord| {
            w.clearance_m.is_finite()
                && (w.height as usize) < n_heights
                && w.part < n_parts
                && optional(w.space, n_spaces)
                && (w.element == NONE || w.terrain == NONE)
        };
        lengths.into_iter().all(f64::is_finite)
            && n_parts <= n_waypoints
            && self.waypoints.iter().all(is_place)
            && self.edges.iter().all(|[a, b]| a < b && *b < n_waypoints)
            && self.spaces.len() == n_spaces * n_heights
            && self.spaces.iter().all(|s| s.largest_clearance_m.is_finite() && s.why.is_known())
    }
}
