//! The `grids` archive: index of a set of grids that belong together.

use crate::archive::ArchiveError;
use crate::content_hash::ContentHash;
use crate::declaration::declare_archive;
use crate::robot::RobotProfile;
use crate::safety_rules::{SafetyRuleRecord, SafetyRules, check_archive};
use crate::site_records::BoxRecord;
use crate::tag::{Tag, check_tags};
use bytemuck::{CheckedBitPattern, NoUninit, Pod, Zeroable};

/// Inputs of the set: one record.
#[derive(Debug, Clone, Copy, PartialEq, Zeroable, Pod)]
#[repr(C)]
pub struct GridsHead {
    /// Content hash of the site.
    pub site_hash: ContentHash,
    /// Content hash of the schedule state.
    pub schedule_state_hash: ContentHash,
    /// Plan time as in [`crate::ScheduleStateHead`].
    pub plan_time_s: i64,
    /// Robot that the maps are for.
    pub robot: RobotProfile,
}
const _: () = assert!(size_of::<GridsHead>() == 136);

/// One grid of the set.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Zeroable, Pod)]
#[repr(C)]
pub struct GridSlotRecord {
    /// Map storey of the site.
    pub map_storey: u32,
    /// Side of a cell in tenths of a millimetre.
    pub cell_tenths: i32,
    /// Content hash of the grid.
    pub content_hash: ContentHash,
}
const _: () = assert!(size_of::<GridSlotRecord>() == 16);

/// Passage of a robot through a door of a map storey.
#[derive(Debug, Clone, Copy, PartialEq, Zeroable, Pod)]
#[repr(C)]
pub struct DoorPassageRecord {
    /// Door of the site.
    pub door: u32,
    /// Map storey of the site.
    pub map_storey: u32,
    /// Whether the robot can pass, and the first reason if it cannot.
    pub passage: Tag<DoorPassage>,
    /// On how many of its sides there is floor.
    pub sides_with_floor: u32,
    /// Width of the narrowest row of free cells through it, in metres.
    pub width_in_map_m: f64,
    /// Clear width of the leaves that count together, this door among them, in metres.
    pub clear_width_m: f64,
    /// Width that obstacles leave of the way through it, independent of the resolution, in metres. Measured where the
    /// cells are too narrow, else 0.
    pub width_between_obstacles_m: f64,
    /// A finer resolution at which it is passable, in metres, where the resolution alone closes it; else 0.
    pub needed_resolution_m: f64,
    /// The way through it: the passages of the leaves that count together.
    pub way: BoxRecord,
    /// Every reason for which it is closed: a bit for each [`DoorPassage`], see [`DoorPassage::bit`].
    pub reasons: u32,
    /// Element that stands in the way, or `NONE`.
    pub obstacle: u32,
}
const _: () = assert!(size_of::<DoorPassageRecord>() == 104);

/// Whether a robot can pass a door, and the first reason if it cannot.
#[derive(Debug, Clone, Copy, PartialEq, Eq, CheckedBitPattern, NoUninit)]
#[repr(u32)]
pub enum DoorPassage {
    /// It can.
    Passable = 0,
    /// The robot does not manage this operation type.
    CannotOpen = 1,
    /// The clear width is less than the robot's diameter and its margin.
    TooNarrow = 2,
    /// The free cells are narrower than the robot: the resolution is too coarse.
    ClosedByResolution = 3,
    /// The wall in which it is to hang is not built, or the door itself is gone.
    Absent = 4,
    /// It is being hung or taken down.
    InProgress = 5,
    /// There is no floor of the storey on either of its sides.
    NoFloor = 6,
    /// The wall that it stands in has no opening there.
    NoOpening = 7,
    /// An element stands in the way.
    Obstructed = 8,
    /// Its opening begins above the floor, by more than a step of the robot.
    Threshold = 9,
    /// It has an opening, and its wall stands there uncut.
    WallUncut = 10,
}

/// What a door is to a robot.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DoorUse {
    /// It hangs, and the robot passes it.
    Passes,
    /// It keeps the robot out.
    Closed,
    /// It does not hang: there is an opening, or not even a wall.
    NotHung,
}

impl DoorPassage {
    /// Those that keep a robot out, from the one that matters most.
    const REASONS: [Self; 9] = {
        use DoorPassage::*;
        [InProgress, NoFloor, CannotOpen, TooNarrow, NoOpening, Threshold, WallUncut, Obstructed, ClosedByResolution]
    };

    /// The bits of all reasons.
    const REASON_BITS: u32 = {
        let (mut bits, mut k) = (0, 0);
        while k < Self::REASONS.len() {
            bits |= Self::REASONS[k].bit();
            k += 1;
        }
        bits
    };

    /// Its bit in [`DoorPassageRecord::reasons`].
    pub const fn bit(self) -> u32 {
        1 << self as u32
    }

    /// What the door is to the robot: the one place that says which passages are closed.
    pub fn for_robot(self) -> DoorUse {
        match self {
            Self::Passable => DoorUse::Passes,
            Self::Absent => DoorUse::NotHung,
            Self::CannotOpen
            | Self::TooNarrow
            | Self::ClosedByResolution
            | Self::InProgress
            | Self::NoFloor
            | Self::NoOpening
            | Self::Obstructed
            | Self::Threshold
            | Self::WallUncut => DoorUse::Closed,
        }
    }

    /// True if the door is closed to this robot. A door that does not hang yet leaves an opening.
    pub fn is_closed(self) -> bool {
        self.for_robot() == DoorUse::Closed
    }

    /// Its name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Passable => "passable",
            Self::CannotOpen => "operation",
            Self::TooNarrow => "too_narrow",
            Self::ClosedByResolution => "resolution",
            Self::Absent => "absent",
            Self::InProgress => "in_progress",
            Self::NoFloor => "no_floor",
            Self::NoOpening => "no_opening",
            Self::Obstructed => "obstructed",
            Self::Threshold => "threshold",
            Self::WallUncut => "wall_uncut",
        }
    }
}

impl DoorPassageRecord {
    /// True if a robot can pass; `None` if no door hangs there, and the map does not show that the robot fits through what is there.
    ///
    /// An opening whose door does not hang yet can be passed if it has floor and is as wide on the map as the robot.
    pub fn is_passable(&self, robot: &RobotProfile) -> Option<bool> {
        match self.passage.get().for_robot() {
            DoorUse::Passes => Some(true),
            DoorUse::Closed => Some(false),
            DoorUse::NotHung => {
                let is_way = self.sides_with_floor > 0 && self.width_in_map_m >= 2.0 * robot.radius_m;
                is_way.then_some(true)
            }
        }
    }

    /// Every reason for which it is closed, the first first.
    pub fn closed_by(&self) -> impl Iterator<Item = DoorPassage> + use<> {
        let reasons = self.reasons;
        DoorPassage::REASONS.into_iter().filter(move |p| reasons & p.bit() != 0)
    }
}

/// A region of floor at another level than its map storey: not free, not to be entered.
#[derive(Debug, Clone, Copy, PartialEq, Zeroable, Pod)]
#[repr(C)]
pub struct RegionRecord {
    /// Map storey of the site.
    pub map_storey: u32,
    /// Height of the region in `map`.
    pub level_z_tenths: i32,
    /// Its area in square metres.
    pub area_m2: f64,
    /// Its area centroid in `map`, in metres.
    pub centre_m: [f64; 2],
    /// Element whose face it is.
    pub element: u32,
    /// Zero.
    pub reserved: u32,
}
const _: () = assert!(size_of::<RegionRecord>() == 40);

declare_archive! {
    /// Index of a set of grids, read in place.
    view Grids;
    /// Records of a `grids` archive to be.
    #[derive(Clone, Copy)]
    borrowed GridsBuilder;
    sections {
        /// Inputs of the set.
        pub head: one(1, GridsHead),
        /// One record per grid.
        pub slots: many(2, GridSlotRecord),
        /// Name of the robot profile.
        pub robot_name: utf8(3),
        /// Doors of the mapped storeys.
        pub doors: many(4, DoorPassageRecord),
        /// Regions at other levels.
        pub regions: many(5, RegionRecord),
        /// Outline of the robot in its frame, in metres; may be empty.
        pub robot_footprint_m: many(6, [f64; 2]),
        /// Distances that the robot keeps from elements, and its speed near them.
        pub safety_rules: if_any(7, SafetyRuleRecord),
        /// Words of materials that rules name, one after the other, UTF-8.
        pub safety_materials: if_any(8, u8),
    }
}

impl Grids<'_> {
    fn check(&self) -> Result<(), ArchiveError> {
        self.head.robot.check().map_err(ArchiveError::Robot)?;
        let is_corner = |corner: &[f64; 2]| corner.iter().all(|c| c.abs() <= self.head.robot.radius_m);
        if !self.robot_footprint_m.iter().all(is_corner) {
            return Err(ArchiveError::Index { what: "a corner of the robot" });
        }
        check_tags(self.doors.iter().map(|d| d.passage), "passage of a door")?;
        if self.doors.iter().any(|d| d.reasons & !DoorPassage::REASON_BITS != 0) {
            return Err(ArchiveError::Unknown { what: "reason for a closed door" });
        }
        check_archive(self.safety_rules, self.safety_materials)
    }
}

impl<'a> GridsBuilder<'a> {
    /// An index without doors and regions, of a robot without an outline and rules.
    pub fn of(head: GridsHead, slots: &'a [GridSlotRecord], robot_name: &'a str) -> Self {
        Self {
            head,
            slots,
            robot_name,
            robot_footprint_m: &[],
            doors: &[],
            regions: &[],
            safety_rules: &[],
            safety_materials: &[],
        }
    }
}

impl SafetyRules {
    /// The rules of an index.
    pub fn of(index: &Grids<'_>) -> Self {
        Self::read(index.safety_rules, index.safety_materials)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_opening_whose_door_does_not_hang_yet_can_be_passed_if_the_robot_fits_through_it() {
        let robot = RobotProfile { radius_m: 0.3, ..RobotProfile::DEFAULT };
        let can_pass = |passage: DoorPassage, sides_with_floor, width_in_map_m| {
            let passage = passage.into();
            let record = DoorPassageRecord { passage, sides_with_floor, width_in_map_m, ..Zeroable::zeroed() };
            record.is_passable(&robot)
        };
        assert_eq!(can_pass(DoorPassage::Passable, 2, 0.9), Some(true));
        assert_eq!(can_pass(DoorPassage::Absent, 2, 0.6), Some(true));
        assert_eq!(can_pass(DoorPassage::Absent, 1, 0.6), Some(true));
        assert_eq!(can_pass(DoorPassage::Absent, 0, 0.6), None);
        assert_eq!(can_pass(DoorPassage::Absent, 2, 0.55), None);
        for closed in DoorPassage::REASONS {
            assert!(closed.is_closed() && can_pass(closed, 2, 0.9) == Some(false), "{closed:?}");
        }
    }

    #[test]
    fn the_index_names_its_grids_and_its_robot() {
        let head = GridsHead {
            site_hash: ContentHash::from_bits(1),
            schedule_state_hash: ContentHash::from_bits(2),
            plan_time_s: 3,
            robot: RobotProfile::DEFAULT,
        };
        let slot = GridSlotRecord { map_storey: 0, cell_tenths: 500, content_hash: ContentHash::from_bits(9) };
        let buffer = GridsBuilder::of(head, &[slot], "default").finish();
        let grids = Grids::open(buffer.bytes()).unwrap();
        assert_eq!((grids.head, grids.slots, grids.robot_name), (&head, &[slot][..], "default"));
    }

    #[test]
    fn an_index_of_a_robot_that_cannot_be_is_refused() {
        let refused = |robot: RobotProfile| {
            let head = GridsHead {
                site_hash: ContentHash::from_bits(1),
                schedule_state_hash: ContentHash::from_bits(2),
                plan_time_s: 3,
                robot,
            };
            let buffer = GridsBuilder::of(head, &[], "r").finish();
            Grids::open(buffer.bytes()).unwrap_err().to_string()
        };
        let usual = RobotProfile::DEFAULT;
        for radius_m in [f64::NAN, f64::INFINITY, -0.3, 1e30] {
            let expected = format!("the robot of the archive: radius_m is {radius_m}, it must be from 0.01 to 5");
            assert_eq!(refused(RobotProfile { radius_m, ..usual }), expected);
        }
        let climber = RobotProfile { height_m: 0.2, step_height_m: 0.3, ..usual };
        assert_eq!(refused(climber), "the robot of the archive: step_height_m 0.3 is not below height_m 0.2");
    }
}
