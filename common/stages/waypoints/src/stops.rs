//! Requests for a storey, the goals that follow from them, and the stops of its tour.

use crate::centre::Storey;
use crate::options::PlanOptions;
use crate::scans::Scans;
use frames::{Map, Point2};
use messages::WaypointKind;

/// What is asked of a storey beside the map.
pub(crate) struct Wanted<'a> {
    pub(crate) options: &'a PlanOptions,
    /// Spaces of this storey in which the robot has business.
    pub(crate) spaces: &'a [usize],
    /// Whether a cell may be scanned from, by its space plus 1; 0 is outside of spaces.
    pub(crate) may_scan: &'a [bool],
    /// Elements that are targets, ascending, if not all are.
    pub(crate) changed: Option<&'a [usize]>,
    /// The cells of those.
    pub(crate) targets: Option<&'a [bool]>,
    /// Where the robot comes onto the parts of the storey.
    pub(crate) entries: &'a [Point2<Map>],
    /// Places before portals: nodes of the graph, with their elements.
    pub(crate) stagings: &'a [(usize, u32)],
}

/// A place to go to, in the order of the tour.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Stop {
    pub(crate) at: Point2<Map>,
    pub(crate) kind: WaypointKind,
    /// Space that it lies in.
    pub(crate) space: Option<usize>,
    pub(crate) yaw_rad: f64,
    pub(crate) clearance_m: f64,
    pub(crate) n_faces: u32,
    pub(crate) covers_m2: f64,
    pub(crate) overlap: f64,
    pub(crate) leg_m: f64,
    /// True for a scan that is there to join others.
    pub(crate) connects: bool,
}

/// A place to go to, before it has an order.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Goal {
    pub(crate) at: Point2<Map>,
    pub(crate) part: u32,
    pub(crate) space: Option<usize>,
    /// Which pose of the scans; a centre has none.
    pub(crate) pose: Option<usize>,
    /// True for a scan that is there to join others.
    pub(crate) connects: bool,
}

/// The goal of a pose of the scans.
pub(crate) fn goal_of(storey: &Storey<'_>, scans: &Scans, pose: usize, connects: bool) -> Goal {
    let place = scans.place(pose);
    Goal { at: place.at, part: place.part, space: storey.space_at(place.at), pose: Some(pose), connects }
}
