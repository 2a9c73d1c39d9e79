//! A door of a storey with its date-independent data, and the test whether a robot can open it and fits through.

use super::door_leaves::{Leaf, doorway};
use grid::{CellRect, Run};
use messages::{RobotProfile, ScheduleState};

/// Widths that differ by less are equal: a door of exactly the robot's width and margin is passable.
const WIDTH_TOLERANCE_M: f64 = 1e-6;

/// A door of a storey, with its date-independent data.
#[derive(Debug, Clone)]
pub(crate) struct StoreyDoor {
    /// Door of the site.
    pub(crate) door: u32,
    /// Cells on which the passage of the door depends.
    pub(crate) around: Option<CellRect>,
    /// Cells of its body within its passage: free even without floor. Leaves and thresholds beside the passage carry no
    /// robot.
    pub(crate) passage_runs: Vec<Run>,
    /// Cells of its body that stay closed when it is open: those of a fixed leaf and beyond.
    pub(crate) fixed_runs: Vec<Run>,
    /// True if the door belongs to this map storey; a door of another level is not passable here.
    pub(crate) stands_here: bool,
    /// The leaves of its opening, in the order in which they adjoin.
    pub(crate) leaves: Vec<Leaf>,
    /// Index of this door in `leaves`.
    pub(crate) leaf_index: usize,
}

impl StoreyDoor {
    /// The leaf of the door itself.
    pub(crate) fn leaf(&self) -> &Leaf {
        &self.leaves[self.leaf_index]
    }

    /// True if the robot can open the hung door and fits through, independent of the resolution of the map.
    pub(crate) fn can_pass(&self, schedule_state: &ScheduleState<'_>, robot: &RobotProfile) -> bool {
        self.leaf().opens && is_wide_enough(robot, doorway(&self.leaves, self.leaf_index, schedule_state).clear_width_m)
    }

    /// True if the host wall stands, or there is none.
    pub(crate) fn is_hung(&self, schedule_state: &ScheduleState<'_>) -> bool {
        self.leaf().host_stands(schedule_state)
    }
}

/// True if this clear width is at least the diameter of the robot and its door margin.
pub(crate) fn is_wide_enough(robot: &RobotProfile, clear_width_m: f64) -> bool {
    clear_width_m + WIDTH_TOLERANCE_M >= robot.needed_width_m()
}
