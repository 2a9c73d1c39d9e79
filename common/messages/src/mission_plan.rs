//! The `mission-plan` archive: waypoints, tours, the route graph.

use crate::archive::{Archive, ArchiveBuffer, ArchiveError, ArchiveKind, NONE, SectionList};
use crate::archive_writer::ArchiveWriter;
use crate::diagnostic_record::{DiagnosticRecord, check_diagnostics};
use crate::mission_plan_records::*;
use crate::payload;
use crate::tag::check_tags;
use crate::text_pool::TextPool;

mod section {
    pub(super) const HEAD: u32 = 1;
    pub(super) const STRINGS: u32 = 2;
    pub(super) const WAYPOINTS: u32 = 3;
    pub(super) const SPACES: u32 = 4;
    pub(super) const STOREYS: u32 = 5;
    pub(super) const TOUR: u32 = 6;
    pub(super) const NODES: u32 = 7;
    pub(super) const EDGES: u32 = 8;
    pub(super) const POINTS: u32 = 9;
    pub(super) const DIAGNOSTICS: u32 = 10;
    pub(super) const FLOOR_PARTS: u32 = 11;
    pub(super) const GROWTH: u32 = 12;
}

/// Waypoints, tours and the route graph, read in place.
#[derive(Debug, Clone, Copy)]
pub struct MissionPlan<'a> {
    archive: Archive<'a>,
    strings: &'a str,
    /// Inputs of the mission plan.
    pub head: &'a MissionPlanHead,
    /// The waypoints, in order of their ids.
    pub waypoints: &'a [WaypointRecord],
    /// One record per space of the site.
    pub spaces: &'a [MissionPlanSpaceRecord],
    /// One record per map storey, in their order.
    pub storeys: &'a [MissionPlanStoreyRecord],
    /// Points of the storeys' tours in `map`, in metres.
    pub tour_points: &'a [[f64; 2]],
    /// Places of the route graph, storey by storey.
    pub nodes: &'a [RouteNodeRecord],
    /// Ways between them.
    pub edges: &'a [RouteEdgeRecord],
    /// Points of the edges in `map`, in metres.
    pub points: &'a [[f64; 3]],
    /// Diagnostics.
    pub diagnostics: &'a [DiagnosticRecord],
    /// Parts of the floors of at least [`FloorPartRecord::MIN_AREA_M2`], storey by storey, from large to small.
    pub floor_parts: &'a [FloorPartRecord],
    /// Scans in the order in which a plan grows, from the first to all that see anything new.
    pub growth: &'a [GrownScanRecord],
}

impl<'a> MissionPlan<'a> {
    /// Validates and views an archive.
    ///
    /// # Errors
    /// Bytes that are no whole mission plan archive, or records that point outside.
    pub fn open(bytes: &'a [u8]) -> Result<Self, ArchiveError> {
        let mission_plan = Self::of(Archive::open(bytes, ArchiveKind::MissionPlan)?)?;
        mission_plan.check_tags()?;
        mission_plan.check_waypoints()?;
        mission_plan.check_graph()?;
        Ok(mission_plan)
    }

    /// The sections of an archive, without validation of their records.
    pub(crate) fn of(archive: Archive<'a>) -> Result<Self, ArchiveError> {
        Ok(Self {
            archive,
            strings: archive.strings(section::STRINGS)?,
            head: archive.record(section::HEAD)?,
            waypoints: archive.section(section::WAYPOINTS)?,
            spaces: archive.section(section::SPACES)?,
            storeys: archive.section(section::STOREYS)?,
            tour_points: archive.section(section::TOUR)?,
            nodes: archive.section(section::NODES)?,
            edges: archive.section(section::EDGES)?,
            points: archive.section(section::POINTS)?,
            diagnostics: archive.section(section::DIAGNOSTICS)?,
            floor_parts: archive.section(section::FLOOR_PARTS)?,
            growth: archive.section(section::GROWTH)?,
        })
    }

    /// Hash of the content.
    pub fn content_hash(&self) -> u64 {
        self.archive.content_hash()
    }

    /// Why a space has no waypoint; empty if it has one.
    pub fn reason(&self, space: usize) -> &'a str {
        self.text(self.spaces[space].reason)
    }

    /// Why no way leads to a space; empty unless that is so.
    pub fn access_reason(&self, space: usize) -> &'a str {
        self.text(self.spaces[space].access_reason)
    }

    /// The text of a record.
    pub fn text(&self, text: crate::Text) -> &'a str {
        text.of(self.strings).expect("texts were checked when the archive was opened")
    }

    /// The points of a storey's tour.
    pub fn tour_of(&self, storey: &MissionPlanStoreyRecord) -> &'a [[f64; 2]] {
        &self.tour_points[storey.first_tour_point as usize..][..storey.n_tour_points as usize]
    }

    /// The points of an edge, from its first node to its second.
    pub fn points_of(&self, edge: &RouteEdgeRecord) -> &'a [[f64; 3]] {
        &self.points[edge.first_point as usize..][..edge.n_points as usize]
    }

    fn check_tags(&self) -> Result<(), ArchiveError> {
        check_tags(self.waypoints.iter().map(|w| w.kind), "kind of waypoint")?;
        check_tags(self.spaces.iter().map(|s| s.why), "reason for having no waypoint")?;
        check_tags(self.spaces.iter().map(|s| s.access), "access to a space")?;
        check_tags(self.storeys.iter().map(|s| s.entry), "entry to a storey")?;
        check_tags(self.nodes.iter().map(|n| n.kind), "kind of node")?;
        check_tags(self.edges.iter().map(|e| e.kind), "kind of edge")?;
        check_diagnostics(self.diagnostics)
    }

    fn check_waypoints(&self) -> Result<(), ArchiveError> {
        let (waypoints, spaces) = (self.waypoints.len(), self.spaces.len());
        let optional = |index: u32, length: usize| index == NONE || (index as usize) < length;
        let inside = self.waypoints.iter().all(|w| optional(w.space, spaces) && optional(w.joins, waypoints))
            && self.spaces.iter().all(|s| optional(s.centre, waypoints));
        // Places that pictures and files are made from are numbers.
        let finite = self.waypoints.iter().all(|w| w.position_in_map_m.iter().all(|c| c.is_finite()))
            && self.tour_points.as_flattened().iter().all(|c| c.is_finite())
            && self.points.as_flattened().iter().all(|c| c.is_finite())
            && self.floor_parts.iter().flat_map(|p| [p.area_m2, p.room_m2, p.at_m[0], p.at_m[1]]).all(f64::is_finite);
        let diagnostics = self.diagnostics.iter().flat_map(DiagnosticRecord::texts);
        let mut texts = self.spaces.iter().flat_map(|s| [s.reason, s.access_reason]).chain(diagnostics);
        let whole = texts.all(|text| text.of(self.strings).is_some());
        if inside && finite && whole { Ok(()) } else { Err(ArchiveError::Index { what: "a waypoint" }) }
    }

    fn check_graph(&self) -> Result<(), ArchiveError> {
        let fits = |first: u32, n: u32, length: usize| u64::from(first) + u64::from(n) <= length as u64;
        let n_nodes = self.nodes.len();
        let whole = self.edges.iter().all(|e| {
                e.nodes.iter().all(|&n| (n as usize) < n_nodes)
                    && fits(e.first_point, e.n_points, self.points.len())
            })
            && self.storeys.iter().all(|s| fits(s.first_tour_point, s.n_tour_points, self.tour_points.len()))
            // Edges that share their points would be walked again and again.
            && self.edges.iter().map(|e| u64::from(e.n_points)).sum::<u64>() <= self.points.len() as u64
            && self.storeys.iter().map(|s| u64::from(s.n_tour_points)).sum::<u64>() <= self.tour_points.len() as u64;
        if whole { Ok(()) } else { Err(ArchiveError::Index { what: "the route graph" }) }
    }
}

/// Records of a `mission-plan` archive to be.
#[derive(Debug)]
pub struct MissionPlanBuilder {
    /// Texts.
    pub texts: TextPool,
    /// Inputs of the mission plan.
    pub head: MissionPlanHead,
    /// The waypoints, in order of their ids.
    pub waypoints: Vec<WaypointRecord>,
    /// One record per space of the site.
    pub spaces: Vec<MissionPlanSpaceRecord>,
    /// One record per map storey, in their order.
    pub storeys: Vec<MissionPlanStoreyRecord>,
    /// Points of the storeys' tours.
    pub tour_points: Vec<[f64; 2]>,
    /// Places of the route graph.
    pub nodes: Vec<RouteNodeRecord>,
    /// Ways between them.
    pub edges: Vec<RouteEdgeRecord>,
    /// Points of the edges.
    pub points: Vec<[f64; 3]>,
    /// Diagnostics.
    pub diagnostics: Vec<DiagnosticRecord>,
    /// Parts of the floors, storey by storey, from large to small.
    pub floor_parts: Vec<FloorPartRecord>,
    /// Scans in the order in which a plan grows.
    pub growth: Vec<GrownScanRecord>,
}

impl MissionPlanBuilder {
    /// Nothing but a head and `n_spaces` spaces without waypoints.
    pub fn new(head: MissionPlanHead, n_spaces: usize) -> Self {
        let nothing = MissionPlanSpaceRecord {
            reason: crate::Text::default(),
            why: NoWaypoint::NotAsked.into(),
            door: NONE,
            centre: NONE,
            n_faces: 0,
            n_seen: 0,
            access: SpaceAccess::NotJudged.into(),
            access_reason: crate::Text::default(),
        };
        Self {
            texts: TextPool::default(),
            head,
            waypoints: Vec::new(),
            spaces: vec![nothing; n_spaces],
            storeys: Vec::new(),
            tour_points: Vec::new(),
            nodes: Vec::new(),
            edges: Vec::new(),
            points: Vec::new(),
            diagnostics: Vec::new(),
            floor_parts: Vec::new(),
            growth: Vec::new(),
        }
    }

    /// Writes the archive into the heap.
    pub fn finish(&self) -> ArchiveBuffer {
        self.to_buffer()
    }

    fn sections(&self) -> SectionList<'_> {
        let mut list = SectionList::default();
        list.add(section::HEAD, std::slice::from_ref(&self.head));
        list.add(section::WAYPOINTS, &self.waypoints);
        list.add(section::SPACES, &self.spaces);
        list.add(section::STOREYS, &self.storeys);
        list.add(section::TOUR, &self.tour_points);
        list.add(section::NODES, &self.nodes);
        list.add(section::EDGES, &self.edges);
        list.add(section::POINTS, &self.points);
        list.add(section::DIAGNOSTICS, &self.diagnostics);
        list.add(section::FLOOR_PARTS, &self.floor_parts);
        list.add(section::GROWTH, &self.growth);
        list.add(section::STRINGS, self.texts.bytes());
        list
    }
}

impl ArchiveWriter for MissionPlanBuilder {
    type Payload = payload::MissionPlan;

    fn length(&self) -> usize {
        self.sections().length()
    }

    fn write(&self, out: &mut [u8]) -> u64 {
        self.sections().write(out, ArchiveKind::MissionPlan)
    }
}
