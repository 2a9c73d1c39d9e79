//! Records of the `mission-plan` archive.

use crate::archive::{NONE, Text};
use crate::content_hash::ContentHash;
use crate::drive_model::DriveModel;
use crate::tag::Tag;
use bytemuck::{CheckedBitPattern, NoUninit, Pod, Zeroable};
use frames::Attitude;

/// The sensor of scans; lengths in metres, angles in radians.
#[derive(Debug, Clone, Copy, PartialEq, Zeroable, Pod)]
#[repr(C)]
pub struct ScanSensor {
    /// Farthest that it measures.
    pub range_m: f64,
    /// Nearest that it measures.
    pub min_range_m: f64,
    /// Largest angle between a ray and the normal of the face that it meets.
    pub max_incidence_rad: f64,
    /// Horizontal field of view; a full turn for a rotating scanner.
    pub field_of_view_rad: f64,
    /// Lowest elevation of its rays, for the check on the meshes.
    pub min_elevation_rad: f64,
    /// Highest elevation of its rays, for the check on the meshes.
    pub max_elevation_rad: f64,
}
const _: () = assert!(size_of::<ScanSensor>() == 48);

impl ScanSensor {
    /// A rotating scanner for rooms.
    pub const DEFAULT: Self = Self {
        range_m: 8.0,
        min_range_m: 0.3,
        max_incidence_rad: 70.0 * std::f64::consts::PI / 180.0,
        field_of_view_rad: std::f64::consts::TAU,
        min_elevation_rad: -std::f64::consts::FRAC_PI_3,
        max_elevation_rad: std::f64::consts::FRAC_PI_2,
    };

    /// True if it sees all around, so that a heading does not matter.
    pub fn sees_around(&self) -> bool {
        self.field_of_view_rad >= std::f64::consts::TAU - 1e-9
    }
}

/// Inputs of the mission plan: one record.
#[derive(Debug, Clone, Copy, PartialEq, Zeroable, Pod)]
#[repr(C)]
pub struct MissionPlanHead {
    /// Content hash of the site.
    pub site_hash: ContentHash,
    /// Content hash of the schedule state.
    pub schedule_state_hash: ContentHash,
    /// Plan time as in [`crate::ScheduleStateHead`].
    pub plan_time_s: i64,
    /// The sensor of scans.
    pub sensor: ScanSensor,
    /// Share of the faces that scans were to see.
    pub coverage_goal: f64,
    /// Length of faces that a scan was to see and no other, in metres.
    pub min_gain_m: f64,
    /// Share of each scan's faces that scans registered before it were to have seen.
    pub overlap_goal: f64,
    /// Smallest distance between two scans, in metres.
    pub separation_m: f64,
    /// Longest duration of all tours in minutes; infinite without such a budget.
    pub minutes_max: f64,
    /// How the robot drives, and by what its ways are chosen.
    pub drive: DriveModel,
    /// Driving time and scanning time of all tours, in seconds.
    pub mission_s: [f64; 2],
    /// Energy of driving and scanning on all tours, in joules; 0 if the mass of the robot is unknown.
    pub mission_j: f64,
    /// Faces of elements that changed since this time are targets, civil seconds; [`crate::ScheduleStateHead::NO_TIME`]
    /// if all are.
    pub changed_since_s: i64,
    /// 1 if tours come back to where they begin.
    pub closed_tours: u32,
    /// Largest number of scans; `NONE` without such a budget.
    pub scans_max: u32,
    /// Classes whose faces are targets: a bit per class.
    pub classes: u32,
    /// Zero.
    pub reserved: u32,
}
const _: () = assert!(size_of::<MissionPlanHead>() == 216);

/// Kind of a waypoint.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, CheckedBitPattern, NoUninit)]
#[repr(u32)]
pub enum WaypointKind {
    /// The centre of a space.
    Centre = 1,
    /// A pose from which to scan.
    Scan = 2,
}

impl WaypointKind {
    /// All kinds.
    pub const ALL: [Self; 2] = [Self::Centre, Self::Scan];

    /// Its name in files and configurations.
    pub fn name(self) -> &'static str {
        match self {
            Self::Centre => "centre",
            Self::Scan => "scan",
        }
    }

    /// The kind of this name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| kind.name() == name)
    }
}

/// A pose to drive to.
#[derive(Debug, Clone, Copy, PartialEq, Zeroable, Pod)]
#[repr(C)]
pub struct WaypointRecord {
    /// Position in `map`, on the floor, in metres.
    pub position_in_map_m: [f64; 3],
    /// Place of the sensor in `map`: above the position, along `up_in_map`.
    pub sensor_in_map_m: [f64; 3],
    /// Normal of the ground on which the robot stands, a unit vector in `map`; straight up on level ground, and for what flies.
    pub up_in_map: [f64; 3],
    /// Heading in `map`: the angle in plan of where the robot looks, whatever the slope.
    pub yaw_rad: f64,
    /// Area centroid of the space's floor, not moved, in `map`; the position outside of spaces.
    pub centroid_in_map_m: [f64; 3],
    /// Distance to the nearest cell that is not free.
    pub clearance_m: f64,
    /// Floor that a scan from here sees and none before it; 0 for centres.
    pub covers_m2: f64,
    /// Share of the faces that it sees that scans before it saw; 0 for centres and the first scan.
    pub overlap: f64,
    /// Share of the faces that it sees that scans registered before it saw; 0 for centres and what registers first.
    pub registration_overlap: f64,
    /// For a scan that joins another: the share of the other's faces that scans registered without this one saw; else 0.
    pub overlap_without: f64,
    /// Way from the waypoint before it on this storey; 0 for the first.
    pub leg_m: f64,
    /// Number in the mission plan.
    pub id: u32,
    /// Place in the tour, from 0 over all storeys.
    pub order: u32,
    /// What it is for.
    pub kind: Tag<WaypointKind>,
    /// Map storey of the site.
    pub map_storey: u32,
    /// Space of the site; `NONE` outside of spaces.
    pub space: u32,
    /// For a scan that is there to join others: the number of one that does not register without it; else `NONE`.
    pub joins: u32,
    /// Faces that a scan from here sees.
    pub n_faces: u32,
    /// Place in the order in which the scans of the storey register, from 0; `NONE` for centres.
    pub registration_order: u32,
}
const _: () = assert!(size_of::<WaypointRecord>() == 184);

impl WaypointRecord {
    /// How the robot stands there.
    pub fn attitude(&self) -> Attitude {
        Attitude { yaw_rad: self.yaw_rad, up: self.up_in_map }
    }

    /// What it is for, with what only such a waypoint has.
    pub fn purpose(&self) -> WaypointPurpose {
        match self.kind.get() {
            WaypointKind::Centre => WaypointPurpose::Centre,
            WaypointKind::Scan => WaypointPurpose::Scan(WaypointScan {
                registration_order: self.registration_order,
                registration_overlap: self.registration_overlap,
                joins: (self.joins != NONE)
                    .then_some(JoinedScan { waypoint: self.joins, overlap_without: self.overlap_without }),
            }),
        }
    }
}

/// What a waypoint is for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum WaypointPurpose {
    /// The robot comes to the centre of a space.
    Centre,
    /// The robot scans there.
    Scan(WaypointScan),
}

/// What only a scan has.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WaypointScan {
    /// Place in the order in which the scans of the storey register, from 0.
    pub registration_order: u32,
    /// The share of its faces that scans registered before it see; 0 for the first.
    pub registration_overlap: f64,
    /// The scan for whose sake it is there, if it is there to join others and not for what it sees.
    pub joins: Option<JoinedScan>,
}

/// A scan that does not register without the one that joins it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JoinedScan {
    /// Number of its waypoint.
    pub waypoint: u32,
    /// The share of its faces that scans registered without the joining one saw.
    pub overlap_without: f64,
}

impl WaypointPurpose {
    /// The kind of waypoint that is for it.
    pub fn kind(&self) -> WaypointKind {
        match self {
            Self::Centre => WaypointKind::Centre,
            Self::Scan(_) => WaypointKind::Scan,
        }
    }

    /// The scan; `None` for a centre.
    pub fn scan(&self) -> Option<WaypointScan> {
        match self {
            Self::Centre => None,
            Self::Scan(scan) => Some(*scan),
        }
    }
}

/// A scan in the order in which a plan grows, over all storeys: each sees the most of what those before it do not see.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Zeroable, Pod)]
#[repr(C)]
pub struct GrownScanRecord {
    /// Map storey of the site.
    pub map_storey: u32,
    /// Faces that it sees and none before it.
    pub n_new: u32,
}
const _: () = assert!(size_of::<GrownScanRecord>() == 8);

/// Why a space has no waypoint.
#[derive(Debug, Clone, Copy, PartialEq, Eq, CheckedBitPattern, NoUninit)]
#[repr(u32)]
pub enum NoWaypoint {
    /// It has one.
    Has = 0,
    /// A gross area, or made of other spaces.
    MetadataOnly = 1,
    /// Outdoors.
    External = 2,
    /// Without a body.
    NoBody = 3,
    /// Its floor is on no map storey.
    NotMapped = 4,
    /// Blocked at the plan time.
    Blocked = 5,
    /// Open, and blocked soon.
    Closing = 6,
    /// No floor at the level of its map storey.
    NoFloor = 7,
    /// All of its free floor is keep-out.
    Keepout = 8,
    /// No free place as wide as the robot.
    TooNarrow = 9,
    /// A door is closed to the robot.
    ClosedDoor = 10,
    /// No way leads there.
    Unreachable = 11,
    /// None was requested.
    NotAsked = 12,
    /// All of its floor lies in other spaces of the same place.
    Shared = 13,
}

impl NoWaypoint {
    /// Its name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Has => "",
            Self::MetadataOnly => "metadata_only",
            Self::External => "external",
            Self::NoBody => "no_body",
            Self::NotMapped => "not_mapped",
            Self::Blocked => "blocked",
            Self::Closing => "closing",
            Self::NoFloor => "no_floor",
            Self::Keepout => "keepout",
            Self::TooNarrow => "too_narrow",
            Self::ClosedDoor => "closed_door",
            Self::Unreachable => "unreachable",
            Self::NotAsked => "not_asked",
            Self::Shared => "shared",
        }
    }
}

/// Whether a robot gets to a space at the plan time: what the schedule says, and whether a way leads there from where it starts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, CheckedBitPattern, NoUninit)]
#[repr(u32)]
pub enum SpaceAccess {
    /// Nobody looked: a gross area, a space without a body, or one whose map storey has no grid.
    NotJudged = 0,
    /// Open, and the robot gets there.
    Reached = 1,
    /// Open by the schedule, and no way leads this robot there.
    NoWay = 2,
    /// Closed by the schedule.
    Closed = 3,
}

impl SpaceAccess {
    /// Its name in files; `None` if it was not judged.
    pub fn name(self) -> Option<&'static str> {
        match self {
            Self::NotJudged => None,
            Self::Reached => Some("reached"),
            Self::NoWay => Some("no_way"),
            Self::Closed => Some("closed"),
        }
    }
}

/// How the robot comes to a map storey.
#[derive(Debug, Clone, Copy, PartialEq, Eq, CheckedBitPattern, NoUninit)]
#[repr(u32)]
pub enum StoreyEntry {
    /// It does not get there.
    None = 0,
    /// It starts there.
    Start = 1,
    /// From another storey, by a stair, ramp, lift or step that it uses.
    Portal = 2,
    /// Through an outer door, because no other storey leads there and no start is given.
    OuterDoor = 3,
    /// It has to be put there: no start, no outer door and nothing that it uses leads there.
    Placed = 4,
}

impl StoreyEntry {
    /// Its name in files; `None` if the robot does not get there.
    pub fn name(self) -> Option<&'static str> {
        match self {
            Self::None => None,
            Self::Start => Some("start"),
            Self::Portal => Some("portal"),
            Self::OuterDoor => Some("outer_door"),
            Self::Placed => Some("placed"),
        }
    }
}

/// Outcome of a space.
#[derive(Debug, Clone, Copy, PartialEq, Zeroable, Pod)]
#[repr(C)]
pub struct MissionPlanSpaceRecord {
    /// Why it has no waypoint, in words; empty if it has one.
    pub reason: Text,
    /// Why it has no waypoint.
    pub why: Tag<NoWaypoint>,
    /// The closed door, or `NONE`.
    pub door: u32,
    /// Its centre waypoint, or `NONE`.
    pub centre: u32,
    /// Target faces in it that can be seen from some place.
    pub n_faces: u32,
    /// Those of them that the scans see.
    pub n_seen: u32,
    /// Whether the robot gets there.
    pub access: Tag<SpaceAccess>,
    /// Why no way leads there, in words; empty unless that is so.
    pub access_reason: Text,
}
const _: () = assert!(size_of::<MissionPlanSpaceRecord>() == 40);

/// Outcome of a map storey.
#[derive(Debug, Clone, Copy, PartialEq, Zeroable, Pod)]
#[repr(C)]
pub struct MissionPlanStoreyRecord {
    /// Length of the tour through all its waypoints.
    pub tour_m: f64,
    /// No tour through them is shorter than this.
    pub tour_bound_m: f64,
    /// Floor that the robot's centre can get to.
    pub reached_m2: f64,
    /// Floor that it could stand on and cannot get to.
    pub unreached_m2: f64,
    /// Map storey of the site.
    pub map_storey: u32,
    /// Target faces, each a side of a cell.
    pub n_targets: u32,
    /// Those of them that can be seen from some place.
    pub n_faces: u32,
    /// Those of them that the scans see.
    pub n_seen: u32,
    /// Places from which a scan was tried.
    pub n_places: u32,
    /// Scans, those that join others included.
    pub n_scans: u32,
    /// Scans that are there to join others.
    pub n_connecting: u32,
    /// Separate parts of the storey that the waypoints lie in.
    pub n_parts: u32,
    /// Points on the meshes of elements that the check looked at; 0 if it was not asked for.
    pub n_mesh_points: u32,
    /// Those of them that the scans see.
    pub n_mesh_seen: u32,
    /// First point of its tour.
    pub first_tour_point: u32,
    /// Number of points of its tour.
    pub n_tour_points: u32,
    /// How the robot comes there.
    pub entry: Tag<StoreyEntry>,
    /// Zero.
    pub reserved: u32,
}
const _: () = assert!(size_of::<MissionPlanStoreyRecord>() == 88);

/// A connected part of the floor of a map storey on which the middle of the robot can stand.
#[derive(Debug, Clone, Copy, PartialEq, Zeroable, Pod)]
#[repr(C)]
pub struct FloorPartRecord {
    /// Its area.
    pub area_m2: f64,
    /// That of it which lies in indoor rooms; all of it on a storey without any.
    pub room_m2: f64,
    /// The place in it that is farthest from what is not free, in `map`, in metres.
    pub at_m: [f64; 2],
    /// Map storey of the site.
    pub map_storey: u32,
    /// 1 if the robot gets to it.
    pub is_reached: u32,
    /// 1 if a stair, ramp, lift or outer door leads to it.
    pub has_way_in: u32,
    /// Zero.
    pub reserved: u32,
}
const _: () = assert!(size_of::<FloorPartRecord>() == 48);

impl FloorPartRecord {
    /// Smaller parts are left out.
    pub const MIN_AREA_M2: f64 = 0.1;
}

/// Kind of a node of the route graph.
#[derive(Debug, Clone, Copy, PartialEq, Eq, CheckedBitPattern, NoUninit)]
#[repr(u32)]
pub enum NodeKind {
    /// Where ways meet.
    Junction = 0,
    /// The centre of a space.
    Space = 1,
    /// A passage with a door, or where one will hang.
    Door = 2,
    /// Where to stand before a stair, ramp, lift or step.
    Staging = 3,
}

impl NodeKind {
    /// Its name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Junction => "junction",
            Self::Space => "space",
            Self::Door => "door",
            Self::Staging => "staging",
        }
    }
}

/// A place of the route graph.
#[derive(Debug, Clone, Copy, PartialEq, Zeroable, Pod)]
#[repr(C)]
pub struct RouteNodeRecord {
    /// Position in `map`, on the floor, in metres.
    pub position_in_map_m: [f64; 3],
    /// Distance to the nearest cell that is not free.
    pub clearance_m: f64,
    /// What it is.
    pub kind: Tag<NodeKind>,
    /// Map storey of the site.
    pub map_storey: u32,
    /// Space, door or element of the site, by kind; `NONE` for a junction, and before a step to a floor that no element
    /// carries.
    pub of: u32,
    /// Space that it lies in, or `NONE`.
    pub space: u32,
}
const _: () = assert!(size_of::<RouteNodeRecord>() == 48);

/// Kind of an edge of the route graph.
#[derive(Debug, Clone, Copy, PartialEq, Eq, CheckedBitPattern, NoUninit)]
#[repr(u32)]
pub enum EdgeKind {
    /// Over the floor of one storey.
    Floor = 0,
    /// Through a door, or the opening where one will hang.
    Door = 1,
    /// A stair to another storey.
    Stair = 2,
    /// A ramp to another storey.
    Ramp = 3,
    /// A lift to another storey.
    Lift = 4,
    /// An escalator to another storey: no robot takes it.
    Escalator = 5,
    /// A step to another level beside this one.
    Step = 6,
    /// From the map of a storey to that of the ground outdoors, at a place that both show.
    Ground = 7,
}

impl EdgeKind {
    /// Its name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Floor => "floor",
            Self::Door => "door",
            Self::Stair => "stair",
            Self::Ramp => "ramp",
            Self::Lift => "lift",
            Self::Escalator => "escalator",
            Self::Step => "step",
            Self::Ground => "ground",
        }
    }
}

/// A way between two nodes, in both directions.
#[derive(Debug, Clone, Copy, PartialEq, Zeroable, Pod)]
#[repr(C)]
pub struct RouteEdgeRecord {
    /// Length of the way; between storeys as walked, up the slope.
    pub length_m: f64,
    /// Least distance to a cell that is not free; 0 between storeys.
    pub clearance_m: f64,
    /// How steep a ramp, or the ground under the way, is where it is steepest; 0 for everything else.
    pub slope_rad: f64,
    /// Time from the first node to the second and back, in seconds.
    pub duration_s: [f64; 2],
    /// Energy there and back, in joules; 0 if the mass of the robot is unknown.
    pub energy_j: [f64; 2],
    /// Clear width of a flight of stairs where it is narrowest, in metres; 0 if unknown and for everything else.
    pub clear_width_m: f64,
    /// Nodes at its ends.
    pub nodes: [u32; 2],
    /// What it is.
    pub kind: Tag<EdgeKind>,
    /// Door of the site, for a door; element of the site, between storeys; else `NONE`. A step to a floor that no
    /// element carries has none.
    pub of: u32,
    /// First point of the way.
    pub first_point: u32,
    /// Number of points of the way, its ends included.
    pub n_points: u32,
    /// 1 if this robot can take it.
    pub usable: u32,
    /// Risers between its ends, for a stair; `NONE` if unknown and for everything else.
    pub n_risers: u32,
}
const _: () = assert!(size_of::<RouteEdgeRecord>() == 96);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_kind_of_waypoint_is_among_all_and_has_a_name_of_its_own() {
        let known = |number: u32| Tag::<WaypointKind>::numbered(number).known();
        let numbered: Vec<WaypointKind> = (0..64).filter_map(known).collect();
        assert_eq!(numbered, WaypointKind::ALL);
        for kind in WaypointKind::ALL {
            assert_eq!(WaypointKind::from_name(kind.name()), Some(kind));
        }
        assert_eq!(WaypointKind::from_name("center"), None);
    }
}
