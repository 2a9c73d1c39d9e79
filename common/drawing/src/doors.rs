//! Whether a robot can pass a door.

use crate::cut::StoreyCut;
use crate::floor::{cells_beside, sides_with_floor};
use crate::near::Look;
use frames::{Map, Point2, TENTHS_PER_M};
use geometry::OrientedBox;
use grid::{CellRect, Class, GridSpec};
use messages::{DoorPassage, DoorPassageRecord, DoorRecord, NONE, Phase, RobotProfile, Site};

/// Widths that differ by less are equal: a door of exactly the robot's width and margin is passable.
const WIDTH_TOLERANCE_M: f64 = 1e-6;

/// What the robot can do with a door, whatever the map's resolution.
fn verdict(robot: &RobotProfile, door: &DoorRecord) -> DoorPassage {
    if door.opens & robot.opens == 0 {
        DoorPassage::CannotOpen
    } else if door.clear_width_m + WIDTH_TOLERANCE_M < 2.0 * robot.radius_m + robot.door_margin_m {
        DoorPassage::TooNarrow
    } else {
        DoorPassage::Passable
    }
}

/// A door of a storey, with what does not depend on the date.
#[derive(Debug, Clone)]
pub(crate) struct DoorAt {
    /// Door of the site.
    pub(crate) door: u32,
    /// Element in which it hangs, or [`NONE`].
    pub(crate) host: u32,
    /// Cells that decide what a robot finds there.
    pub(crate) around: Option<CellRect>,
    verdict: DoorPassage,
    plan: OrientedBox,
}

impl DoorAt {
    /// The door of the site with this number; `None` for [`NONE`].
    pub(crate) fn new(site: &Site<'_>, robot: &RobotProfile, spec: &GridSpec, door: u32) -> Option<Self> {
        let record = site.doors.get(door as usize)?;
        let plan = record.passage.to_box();
        let opening = site.openings.get(record.opening as usize);
        Some(Self {
            door,
            host: opening.map_or(NONE, |o| o.host),
            around: cells_beside(&plan, spec),
            verdict: verdict(robot, record),
            plan,
        })
    }

    /// What the robot can do with it when it hangs, whatever the map's resolution.
    pub(crate) fn can_pass(&self) -> bool {
        self.verdict == DoorPassage::Passable
    }

    /// True if the wall that it hangs in stands, or it hangs in none.
    pub(crate) fn is_hung(&self, phase: &Phase<'_>) -> bool {
        self.host == NONE || phase.effective(self.host as usize).is_obstacle()
    }

    /// What a robot finds there on a map of these layers, if the door's element looks like this.
    pub(crate) fn passage(
        &self,
        phase: &Phase<'_>,
        robot: &RobotProfile,
        storey: &StoreyCut,
        look: Look,
        layers: DoorLayers<'_>,
    ) -> DoorPassageRecord {
        let width_in_map_m = free_width_m(&self.plan, &storey.spec, layers.class);
        let passage = match self.verdict {
            _ if !look.is_obstacle() || !self.is_hung(phase) => DoorPassage::Absent,
            _ if look == Look::WorkedOn => DoorPassage::InProgress,
            DoorPassage::Passable if width_in_map_m < 2.0 * robot.radius_m => DoorPassage::ClosedByResolution,
            verdict => verdict,
        };
        DoorPassageRecord {
            door: self.door,
            map_storey: storey.map_storey,
            passage: passage as u32,
            sides_with_floor: sides_with_floor(&self.plan, &storey.spec, |i| layers.floor[i] != 0),
            width_in_map_m,
        }
    }
}

/// The layers that tell whether a robot can pass a door.
#[derive(Clone, Copy)]
pub(crate) struct DoorLayers<'a> {
    pub(crate) class: &'a [u8],
    pub(crate) floor: &'a [u8],
}

/// Width of the narrowest line across a passage, in cells without an obstacle, in metres. That a space beside it is blocked
/// does not make a door narrower.
fn free_width_m(plan: &OrientedBox, spec: &GridSpec, class: &[u8]) -> f64 {
    let cell = f64::from(spec.cell_tenths);
    let is_open = |at: [f64; 2]| {
        let [x, y] = at.map(|c| c / f64::from(TENTHS_PER_M));
        spec.cell_at(Point2::<Map>::new(x, y))
            .is_some_and(|c| [Class::None.id(), Class::Door.id()].contains(&class[spec.index(c)]))
    };
    // Ten samples per cell along the line: the width is right to a tenth of a cell.
    let step = cell / 10.0;
    let n_steps = (plan.half[0] / step).ceil() as i32;
    let widest = |v: f64| {
        let (mut best, mut now) = (0, 0);
        for k in -n_steps..=n_steps {
            now = if is_open(plan.at(f64::from(k) * step, v)) { now + 1 } else { 0 };
            best = best.max(now);
        }
        f64::from(best) * step / f64::from(TENTHS_PER_M)
    };
    let n_lines = (plan.half[1] / cell).ceil().max(1.0) as i32;
    (-n_lines..=n_lines).map(|k| widest(plan.half[1] * f64::from(k) / f64::from(n_lines))).fold(f64::INFINITY, f64::min)
}
