//! Whether a robot can pass a door.

use crate::cut::StoreyCut;
use crate::floor::{cells_beside, sides_with_floor};
use crate::near::Look;
use frames::{Map, Point2, TENTHS_PER_M};
use geometry::{FillRule, OrientedBox, union};
use grid::{CellRect, Class, GridSpec, Run, overlapped_cells};
use messages::{DoorPassage, DoorPassageRecord, DoorRecord, NONE, Phase, RobotProfile, Site};

/// Widths that differ by less are equal: a door of exactly the robot's width and margin is passable.
const WIDTH_TOLERANCE_M: f64 = 1e-6;

/// A door without an opening whose box is deeper than this, in tenths of a millimetre, is drawn with an open leaf.
const MAX_DEPTH: f64 = 0.5 * TENTHS_PER_M as f64;

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
    /// Cells of its body in its passage: they stay free without floor. Leaves and thresholds beside it carry no robot.
    pub(crate) passage_runs: Vec<Run>,
    /// True if no other map storey's floor is nearer to its threshold: one of another level is no way on this one.
    pub(crate) stands_here: bool,
    verdict: DoorPassage,
    plan: OrientedBox,
}

impl DoorAt {
    /// The door of the site with this number, whose body takes these cells of a map storey; `None` for [`NONE`].
    pub(crate) fn new(
        site: &Site<'_>,
        robot: &RobotProfile,
        (spec, map_storey): (&GridSpec, usize),
        door: u32,
        body: &[Run],
    ) -> Option<Self> {
        let record = site.doors.get(door as usize)?;
        let plan = record.passage.to_box();
        let opening = site.openings.get(record.opening as usize);
        let is_passage = opening.is_some_and(|o| o.plan.half[0] > 0.0) || 2.0 * plan.half[1] <= MAX_DEPTH;
        let passage = if is_passage { union(&[plan.ring()], FillRule::NonZero) } else { Default::default() };
        Some(Self {
            door,
            host: opening.map_or(NONE, |o| o.host),
            around: cells_beside(&plan, spec),
            stands_here: stands_on(site, map_storey, site.elements[record.element as usize].min_tenths[2]),
            passage_runs: in_both(&overlapped_cells(&passage, &[], spec), body),
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

/// What two lists of sorted runs have in common, sorted.
fn in_both(a: &[Run], b: &[Run]) -> Vec<Run> {
    let (mut i, mut k, mut found) = (0, 0, Vec::new());
    while let (Some(x), Some(y)) = (a.get(i), b.get(k)) {
        let (start, end) = (x.start.max(y.start), x.end.min(y.end));
        if x.row == y.row && start < end {
            found.push(Run { row: x.row, start, end });
        }
        if (x.row, x.end) <= (y.row, y.end) { i += 1 } else { k += 1 }
    }
    found
}

/// True if no other map storey's floor is nearer to a threshold.
fn stands_on(site: &Site<'_>, map_storey: usize, threshold_z: i32) -> bool {
    let far = |k: usize| (i64::from(site.map_storeys[k].floor_z_tenths) - i64::from(threshold_z)).abs();
    (0..site.map_storeys.len()).all(|k| far(map_storey) <= far(k))
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
