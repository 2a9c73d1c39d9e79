//! The `mission-plan` archive: waypoints, tours, the route graph.

use crate::archive::{ArchiveError, NONE};
use crate::declaration::declare_archive;
use crate::diagnostic_record::{DiagnosticRecord, check_diagnostics};
use crate::flight::{Flight, FlightRecords};
use crate::mission_plan_records::*;
use crate::tag::check_tags;

declare_archive! {
    /// Waypoints, tours and the route graph, read in place.
    view MissionPlan;
    /// Records of a `mission-plan` archive to be.
    owned MissionPlanBuilder;
    sections {
        /// Inputs of the mission plan.
        pub head: one(1, MissionPlanHead),
        /// The waypoints, in order of their ids.
        pub waypoints: many(3, WaypointRecord),
        /// One record per space of the site.
        pub spaces: many(4, MissionPlanSpaceRecord),
        /// One record per map storey, in their order.
        pub storeys: many(5, MissionPlanStoreyRecord),
        /// Points of the storeys' tours in `map`, in metres.
        pub tour_points: many(6, [f64; 2]),
        /// Places of the route graph, storey by storey.
        pub nodes: many(7, RouteNodeRecord),
        /// Ways between them.
        pub edges: many(8, RouteEdgeRecord),
        /// Points of the edges in `map`, in metres.
        pub points: many(9, [f64; 3]),
        /// Diagnostics.
        pub diagnostics: many(10, DiagnosticRecord),
        /// Parts of the floors of at least [`FloorPartRecord::MIN_AREA_M2`], storey by storey, from large to small.
        pub floor_parts: many(11, FloorPartRecord),
        /// Scans in the order in which a plan grows, from the first to all that see anything new.
        pub growth: many(12, GrownScanRecord),
        /// Flight waypoints, where they were asked for.
        pub flight: optional_group(32, Flight, FlightRecords),
        /// All texts.
        texts: texts(2),
    }
}

impl<'a> MissionPlan<'a> {
    fn check(&self) -> Result<(), ArchiveError> {
        self.check_tags()?;
        self.check_waypoints()?;
        self.check_graph()?;
        let is_whole = self.flight.as_ref().is_none_or(|flight| flight.is_whole(self.spaces.len()));
        if is_whole { Ok(()) } else { Err(ArchiveError::Index { what: "a flight waypoint" }) }
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
        self.texts.get(text)
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
        check_tags([self.head.drive.cost], "cost of ways")?;
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
        // Places that pictures and files are made from are numbers, and a pose has a direction that is up.
        let finite = self
            .waypoints
            .iter()
            .flat_map(|w| [w.position_in_map_m, w.sensor_in_map_m])
            .flatten()
            .all(f64::is_finite)
            && self.waypoints.iter().all(|w| is_up(w.up_in_map))
            && self.head.drive.is_finite()
            && self.tour_points.as_flattened().iter().all(|c| c.is_finite())
            && self.points.as_flattened().iter().all(|c| c.is_finite())
            && self.floor_parts.iter().flat_map(|p| [p.area_m2, p.room_m2, p.at_m[0], p.at_m[1]]).all(f64::is_finite);
        let diagnostics = self.diagnostics.iter().flat_map(DiagnosticRecord::texts);
        let mut texts = self.spaces.iter().flat_map(|s| [s.reason, s.access_reason]).chain(diagnostics);
        let whole = texts.all(|text| self.texts.has(text));
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

/// True for a unit vector above the plane, but for rounding.
fn is_up([x, y, z]: [f64; 3]) -> bool {
    z > 0.0 && (x * x + y * y + z * z - 1.0).abs() < 1e-9
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
        Self { head, spaces: vec![nothing; n_spaces], ..Self::default() }
    }
}
