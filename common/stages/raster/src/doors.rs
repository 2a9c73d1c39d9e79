//! Whether a robot can pass a door.

use crate::between::{Between, Standing, between_obstacles};
use crate::cut::StoreyCut;
use crate::floor::{cells_beside, sides_with_floor};
use crate::leaves::{Leaf, leaves_of, union_of_passages, way_through};
use crate::near::Look;
use frames::{Map, Point2, TENTHS_PER_M};
use geometry::{FillRule, OrientedBox, union};
use grid::{CellRect, Class, GridSpec, Run, overlapped_cells};
use messages::{BoxRecord, DoorPassage, DoorPassageRecord, NONE, Phase, RobotProfile, Site};

/// Widths that differ by less are equal: a door of exactly the robot's width and margin is passable.
const WIDTH_TOLERANCE_M: f64 = 1e-6;

/// A door without an opening whose box is deeper than this, in tenths of a millimetre, is drawn with an open leaf.
const MAX_DEPTH: f64 = 0.5 * TENTHS_PER_M as f64;

/// Cells that obstacles at both sides of a way may take beyond themselves, with the samples that its width is measured by:
/// where the way runs along the raster, and at an angle to it.
const CELLS_LOST: [f64; 2] = [2.2, 3.1];

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
    place: usize,
}

/// The way through a door at a phase.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Way {
    /// Passages of the leaves that count together.
    pub(crate) plan: OrientedBox,
    /// Their clear width.
    pub(crate) clear_width_m: f64,
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
        let (leaves, place) = leaves_of(site, robot, door)?;
        let plan = record.passage.to_box();
        let opening = site.openings.get(record.opening as usize);
        let is_passage = opening.is_some_and(|o| o.plan.half[0] > 0.0) || 2.0 * plan.half[1] <= MAX_DEPTH;
        let passage = if is_passage { union(&[plan.ring()], FillRule::NonZero) } else { Default::default() };
        Some(Self {
            door,
            around: cells_beside(&union_of_passages(&leaves), spec),
            passage_runs: in_both(&overlapped_cells(&passage, &[], spec), body),
            stands_here: record.map_storey == map_storey as u32,
            leaves,
            place,
        })
    }

    fn leaf(&self) -> &Leaf {
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

    /// What a robot finds there on a map of these layers, if the door's element looks like this.
    pub(crate) fn passage(
        &self,
        phase: &Phase<'_>,
        robot: &RobotProfile,
        storey: &StoreyCut,
        look: Look,
        layers: DoorLayers<'_>,
        standing: &mut Standing,
    ) -> DoorPassageRecord {
        let way = way_through(&self.leaves, self.place, phase);
        let mut record = DoorPassageRecord {
            door: self.door,
            map_storey: storey.map_storey,
            passage: DoorPassage::Passable as u32,
            sides_with_floor: sides_with_floor(&way.plan, &storey.spec, |i| layers.floor[i] != 0),
            width_in_map_m: free_width_m(&way.plan, &storey.spec, layers.class),
            clear_width_m: way.clear_width_m,
            width_between_obstacles_m: 0.0,
            needed_resolution_m: 0.0,
            way: BoxRecord::from(way.plan),
            reasons: 0,
            obstacle: NONE,
        };
        if !look.is_obstacle() || !self.is_hung(phase) {
            record.passage = DoorPassage::Absent as u32;
            return record;
        }
        let is_narrow = !is_wide_enough(robot, way.clear_width_m);
        for (is_one, reason) in [
            (look == Look::WorkedOn, DoorPassage::InProgress),
            (record.sides_with_floor == 0 || !self.stands_here, DoorPassage::NoFloor),
            (!self.leaf().opens, DoorPassage::CannotOpen),
            (is_narrow, DoorPassage::TooNarrow),
        ] {
            record.reasons |= if is_one { reason.bit() } else { 0 };
        }
        if !is_narrow && record.width_in_map_m < 2.0 * robot.radius_m {
            add_reason_of_cells(&mut record, between_obstacles(&way.plan, storey, phase, standing), robot);
        }
        record.passage = record.closed_by().next().unwrap_or(DoorPassage::Passable) as u32;
        record
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

/// Why the cells of a way that is wide enough are too narrow for the robot.
fn add_reason_of_cells(record: &mut DoorPassageRecord, between: Between, robot: &RobotProfile) {
    let spare_m = between.width_m - 2.0 * robot.radius_m;
    record.width_between_obstacles_m = between.width_m;
    let reason = if spare_m >= 0.0 {
        record.needed_resolution_m = needed_resolution_m(&record.way.to_box(), spare_m);
        DoorPassage::ClosedByResolution
    } else {
        record.obstacle = between.obstacle;
        if between.is_walled_up { DoorPassage::NoOpening } else { DoorPassage::Obstructed }
    };
    record.reasons |= reason.bit();
}

fn is_wide_enough(robot: &RobotProfile, clear_width_m: f64) -> bool {
    clear_width_m + WIDTH_TOLERANCE_M >= 2.0 * robot.radius_m + robot.door_margin_m
}

/// A resolution in whole millimetres at which a way that is wider than the robot by `spare_m` stays passable.
fn needed_resolution_m(way: &OrientedBox, spare_m: f64) -> f64 {
    let is_aligned = way.axis.iter().any(|a| a.abs() < 1e-3);
    let cells = CELLS_LOST[usize::from(!is_aligned)];
    ((spare_m / cells * 1000.0).floor() / 1000.0).max(0.001)
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
