//! The request for a storey, the tour goals that follow from it, and the stops of its tour.

use crate::options::MissionPlanOptions;
use crate::scan_registration::RegisteredScan;
use frames::{Map, Point2};
use messages::WaypointKind;

/// What is to be planned on a storey.
pub(crate) struct StoreyRequest<'a> {
    pub(crate) options: &'a MissionPlanOptions,
    /// Selected open spaces of this storey.
    pub(crate) spaces: &'a [usize],
    /// Spaces of this storey that need no waypoint, of which it is told whether the robot gets there.
    pub(crate) others: &'a [usize],
    /// Whether scans may be made in a cell, by its space plus 1; 0 is outside of spaces.
    pub(crate) may_scan: &'a [bool],
    /// Elements that are targets, ascending; `None` for all.
    pub(crate) changed: Option<&'a [usize]>,
    /// Cells of these elements.
    pub(crate) targets: Option<&'a [bool]>,
    /// Points at which the robot enters the parts of the storey.
    pub(crate) entries: &'a [Point2<Map>],
    /// Cells of staging poses, with the elements of their portals.
    pub(crate) stagings: &'a [(usize, u32)],
}

/// A stop of a tour.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct TourStop {
    pub(crate) at: Point2<Map>,
    pub(crate) purpose: StopPurpose,
    /// Space in which it lies.
    pub(crate) space: Option<usize>,
    pub(crate) yaw_rad: f64,
    pub(crate) clearance_m: f64,
    pub(crate) leg_m: f64,
}

impl TourStop {
    /// The scan that is made there.
    pub(crate) fn scan(&self) -> Option<&StopScan> {
        match &self.purpose {
            StopPurpose::Centre => None,
            StopPurpose::Scan(scan) => Some(scan),
        }
    }
}

/// What a stop is for.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum StopPurpose {
    /// It is the centre of its space.
    Centre,
    /// The robot scans there.
    Scan(StopScan),
}

impl StopPurpose {
    /// The kind of waypoint that it makes.
    pub(crate) fn kind(&self) -> WaypointKind {
        match self {
            Self::Centre => WaypointKind::Centre,
            Self::Scan(_) => WaypointKind::Scan,
        }
    }
}

/// A scan at a stop.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct StopScan {
    pub(crate) planned: PlannedScan,
    /// Faces that it sees.
    pub(crate) n_faces: u32,
    /// Floor that it sees and no scan before it on the tour.
    pub(crate) covers_m2: f64,
    /// Share of its faces that scans before it on the tour see.
    pub(crate) overlap: f64,
}

/// A scan of the plan.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct PlannedScan {
    /// Place in the order in which the scans of the storey register.
    pub(crate) registration_order: u32,
    pub(crate) scan: RegisteredScan,
}

/// A place to visit, before the tour is ordered.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct TourGoal {
    pub(crate) at: Point2<Map>,
    pub(crate) part: u32,
    pub(crate) space: Option<usize>,
    pub(crate) purpose: GoalPurpose,
}

/// What a place is to be visited for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum GoalPurpose {
    /// It is the centre of its space.
    Centre,
    /// The robot is to scan there.
    Scan(PlannedScan),
}
