//! A door of a storey, with what does not depend on the date, and whether a robot can open it and fits through it.

use super::door_leaves::{Leaf, way_through};
use grid::{CellRect, Run};
use messages::{Phase, RobotProfile};

/// Widths that differ by less are equal: a door of exactly the robot's width and margin is passable.
const WIDTH_TOLERANCE_M: f64 = 1e-6;

/// A door of a storey, with what does not depend on the date.
#[derive(Debug, Clone)]
pub(crate) struct DoorAt {
    /// Door of the site.
    pub(crate) door: u32,
    /// Cells that decide what a robot finds there.
    pub(crate) around: Option<CellRect>,
    /// Cells of its body in its passage: they stay free without floor. Leaves and thresholds beside it carry no robot.
    pub(crate) passage_runs: Vec<Run>,
    /// True if it stands on this map storey: one of another level is no way on this one.
    pub(crate) stands_here: bool,
    /// The leaves that count together when all of them open, in their order.
    pub(crate) leaves: Vec<Leaf>,
    /// Place of the door among them.
    pub(crate) place: usize,
}

impl DoorAt {
    /// The leaf of the door itself.
    pub(crate) fn leaf(&self) -> &Leaf {
        &self.leaves[self.place]
    }

    /// What the robot can do with it when it hangs, whatever the map's resolution.
    pub(crate) fn can_pass(&self, phase: &Phase<'_>, robot: &RobotProfile) -> bool {
        self.leaf().opens && is_wide_enough(robot, way_through(&self.leaves, self.place, phase).clear_width_m)
    }

    /// True if the wall that it hangs in stands, or it hangs in none.
    pub(crate) fn is_hung(&self, phase: &Phase<'_>) -> bool {
        self.leaf().host_stands(phase)
    }
}

/// True if a way of this clear width is wide enough for the robot and its margin.
pub(crate) fn is_wide_enough(robot: &RobotProfile, clear_width_m: f64) -> bool {
    clear_width_m + WIDTH_TOLERANCE_M >= 2.0 * robot.radius_m + robot.door_margin_m
}
