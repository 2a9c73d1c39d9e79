//! A way from a place to another over storeys, and what is in the way where there is none.

use crate::drive_cost::Driven;
use frames::{Map, Point2};
use messages::{DoorPassageRecord, EdgeKind, NoWaypoint};

/// An end of a way.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum WayEnd {
    /// A space of the site: the place nearest to the centroid of its floor at which the robot can stand.
    Space(usize),
    /// A point of a map storey, or the nearest place within 0.3 m at which the robot can stand.
    Point {
        /// Map storey of the site.
        map_storey: u32,
        /// In `map`.
        at: Point2<Map>,
    },
}

/// A way that this robot can take: it can stand on each of the cells, and each is beside the one before it.
#[derive(Debug, Clone, PartialEq)]
pub struct Way {
    /// Its legs in their order; a leg over floor at both ends.
    pub legs: Vec<WayLeg>,
    /// Length of all legs in metres, as walked, up the slope.
    pub length_m: f64,
    /// Time and energy of all legs.
    pub driven: Driven,
}

/// A leg of a way.
#[derive(Debug, Clone, PartialEq)]
pub enum WayLeg {
    /// Over the floor of a storey.
    Floor(FloorLeg),
    /// Through a stair, ramp, lift or step to another storey, or from its map to that of the ground outdoors.
    Portal(PortalLeg),
}

/// A leg over the floor of a storey.
#[derive(Debug, Clone, PartialEq)]
pub struct FloorLeg {
    /// Map storey of the site.
    pub map_storey: u32,
    /// Cells of the grid of the storey, from the first to the last.
    pub cells: Vec<usize>,
    /// Corners of the shortest line along the cells, in `map`.
    pub line: Vec<Point2<Map>>,
    /// Height of the ground at each corner, in metres.
    pub z_m: Vec<f64>,
    /// Length of the line in metres, along slopes.
    pub length_m: f64,
    /// Sum of its rises in metres.
    pub climb_m: f64,
    /// Sum of its falls in metres.
    pub descent_m: f64,
    /// Slope of the steepest ground under it.
    pub slope_rad: f64,
    /// Time and energy of the line.
    pub driven: Driven,
    /// Doorways in their order, each once: passages that the robot can pass, or openings where a door will hang.
    pub doors: Vec<DoorPassageRecord>,
    /// Spaces in the order in which the leg enters them.
    pub spaces: Vec<usize>,
}

/// A leg through a portal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PortalLeg {
    /// Number of its edge in the mission plan, which has kind, element and line.
    pub edge: usize,
    /// True if it is taken from the first node of the edge to the second.
    pub is_forward: bool,
    /// Length in metres, as walked.
    pub length_m: f64,
    /// Time and energy.
    pub driven: Driven,
}

/// Why there is no way.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct NoWay {
    /// Why the robot cannot stand where it would begin; `None` if it can.
    pub from: Option<NoPlace>,
    /// Why it cannot stand at its end.
    pub to: Option<NoPlace>,
    /// What is in the way, from the beginning on, on the way that has the fewest obstacles. Empty where nothing of the model that
    /// is closed, missing or not for this robot lies between the ends.
    pub obstacles: Vec<WayObstacle>,
}

/// Why a robot cannot stand at an end.
#[derive(Debug, Clone, PartialEq)]
pub struct NoPlace {
    /// The reason.
    pub why: NoWaypoint,
    /// The same in words.
    pub reason: String,
}

/// What is in the way.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum WayObstacle {
    /// A door that is closed to the robot.
    Door(DoorPassageRecord),
    /// A space that is closed by the schedule.
    Space(usize),
    /// A stair, ramp, lift or step.
    Portal {
        /// What it is.
        kind: EdgeKind,
        /// Element of the site; `NONE` for a step to floor that no element carries.
        element: u32,
        /// False if it is not built at the plan time.
        is_built: bool,
        /// True if this robot could take it; for a lift that is not built nobody knows.
        is_usable: Option<bool>,
    },
    /// Floor on which nothing stands, and the robot cannot stand.
    Floor {
        /// Map storey of the site.
        map_storey: u32,
        /// Where it begins.
        at: Point2<Map>,
        /// True if it is keep-out; false if it is only narrower than the robot.
        is_keepout: bool,
    },
}
