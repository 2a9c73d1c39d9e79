//! The `plan` archive: waypoints.

use crate::archive::{Archive, ArchiveBuffer, ArchiveError, ArchiveKind, NONE, SectionList, Text};
use crate::site_builder::TextPool;
use bytemuck::{Pod, Zeroable};

mod section {
    pub(super) const HEAD: u32 = 1;
    pub(super) const STRINGS: u32 = 2;
    pub(super) const WAYPOINTS: u32 = 3;
    pub(super) const SPACES: u32 = 4;
}

/// What the plan was made from: one record.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Zeroable, Pod)]
#[repr(C)]
pub struct PlanHead {
    /// Content hash of the site.
    pub site_hash: u64,
    /// Content hash of the phase.
    pub phase_hash: u64,
    /// Plan time as in [`crate::PhaseHead`].
    pub plan_time_s: i64,
}
const _: () = assert!(size_of::<PlanHead>() == 24);

/// What a waypoint is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u32)]
pub enum WaypointKind {
    /// The centre of a space.
    Centre = 1,
    /// A pose from which to scan.
    Scan = 2,
}

/// A pose to drive to.
#[derive(Debug, Clone, Copy, PartialEq, Zeroable, Pod)]
#[repr(C)]
pub struct WaypointRecord {
    /// Position in `map`, on the floor, in metres.
    pub position_in_map_m: [f64; 3],
    /// Height of the sensor in `map`.
    pub sensor_z_m: f64,
    /// Heading in `map`.
    pub yaw_rad: f64,
    /// Area centroid of the space's floor, not moved, in `map`.
    pub centroid_in_map_m: [f64; 3],
    /// Distance to the nearest cell that is not free.
    pub clearance_m: f64,
    /// Area that a scan from here adds; 0 for centres.
    pub covers_m2: f64,
    /// Number in the plan.
    pub id: u32,
    /// Place in the tour, from 0 over all storeys.
    pub order: u32,
    /// [`WaypointKind`] as a number.
    pub kind: u32,
    /// Map storey of the site.
    pub map_storey: u32,
    /// Space of the site.
    pub space: u32,
    /// Zero.
    pub reserved: u32,
}
const _: () = assert!(size_of::<WaypointRecord>() == 104);

/// What became of a space.
#[derive(Debug, Clone, Copy, PartialEq, Zeroable, Pod)]
#[repr(C)]
pub struct SpacePlanRecord {
    /// Share of what can be seen that scans cover, 0 to 1; 0 if there are centres only.
    pub coverage: f64,
    /// Why it has no waypoint; empty if it has one.
    pub reason: Text,
    /// Its centre waypoint, or `NONE`.
    pub centre: u32,
    /// Zero.
    pub reserved: u32,
}
const _: () = assert!(size_of::<SpacePlanRecord>() == 24);

/// Waypoints, read in place.
#[derive(Debug, Clone, Copy)]
pub struct Plan<'a> {
    archive: Archive<'a>,
    strings: &'a str,
    /// What the plan was made from.
    pub head: &'a PlanHead,
    /// The waypoints, in order of their ids.
    pub waypoints: &'a [WaypointRecord],
    /// One record per space of the site.
    pub spaces: &'a [SpacePlanRecord],
}

impl<'a> Plan<'a> {
    /// Validates and views an archive.
    ///
    /// # Errors
    /// Bytes that are no whole plan archive, or records that point outside.
    pub fn open(bytes: &'a [u8]) -> Result<Self, ArchiveError> {
        let archive = Archive::open(bytes, ArchiveKind::Plan)?;
        let plan = Self {
            archive,
            strings: archive.strings(section::STRINGS)?,
            head: archive.record(section::HEAD)?,
            waypoints: archive.section(section::WAYPOINTS)?,
            spaces: archive.section(section::SPACES)?,
        };
        let (waypoints, spaces, strings) = (plan.waypoints.len(), plan.spaces.len(), plan.strings);
        let inside = plan.waypoints.iter().all(|w| (w.space as usize) < spaces)
            && plan.spaces.iter().all(|s| s.centre == NONE || (s.centre as usize) < waypoints)
            && plan.spaces.iter().map(|s| s.reason).all(|t| {
                strings.get(t.offset as usize..(t.offset as usize).saturating_add(t.length as usize)).is_some()
            });
        if inside { Ok(plan) } else { Err(ArchiveError::Index { what: "a waypoint" }) }
    }

    /// Hash of the content.
    pub fn content_hash(&self) -> u64 {
        self.archive.content_hash()
    }

    /// Why a space has no waypoint; empty if it has one.
    pub fn reason(&self, space: usize) -> &'a str {
        let text = self.spaces[space].reason;
        &self.strings[text.offset as usize..][..text.length as usize]
    }
}

/// Records of a `plan` archive to be.
#[derive(Debug)]
pub struct PlanBuilder {
    /// Texts.
    pub texts: TextPool,
    /// What the plan was made from.
    pub head: PlanHead,
    /// The waypoints, in order of their ids.
    pub waypoints: Vec<WaypointRecord>,
    /// One record per space of the site.
    pub spaces: Vec<SpacePlanRecord>,
}

impl PlanBuilder {
    /// Writes the archive into the heap.
    pub fn finish(&self) -> ArchiveBuffer {
        let mut list = SectionList::default();
        list.add(section::HEAD, std::slice::from_ref(&self.head));
        list.add(section::WAYPOINTS, &self.waypoints);
        list.add(section::SPACES, &self.spaces);
        list.add(section::STRINGS, self.texts.bytes());
        let mut buffer = ArchiveBuffer::zeroed(list.len());
        list.write(buffer.bytes_mut(), ArchiveKind::Plan);
        buffer
    }
}
