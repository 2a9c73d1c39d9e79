//! Decides whether a robot can pass a door on a map, with every reason against it.

use super::cell_flags::OCCUPIED;
use super::doorway_clearance::{CoveredSamples, DoorwayClearance, doorway_clearance};
use super::doorway_connection::{SeenCells, joins_sides, outline_of_passage};
use super::floor::sides_with_floor;
use crate::model::cell_area::slab_above_floor;
use crate::model::door::{StoreyDoor, is_wide_enough};
use crate::model::door_leaves::doorway;
use crate::model::presence::Presence;
use crate::model::storey_inputs::StoreyInputs;
use frames::{Map, Point2, TENTHS_PER_M};
use geometry::OrientedBox;
use grid::{Class, GridSpec};
use messages::{BoxRecord, DoorPassage, DoorPassageRecord, NONE, ScheduleState};

/// Cells of width lost to rasterised obstacles on both sides of a doorway, including the sampling error: for doorways along
/// the raster, and at an angle to it.
const CELLS_LOST: [f64; 2] = [2.2, 3.1];

/// The layers on which the passage of a door depends.
#[derive(Clone, Copy)]
pub(crate) struct DoorLayers<'a> {
    pub(crate) class: &'a [u8],
    pub(crate) floor: &'a [u8],
    /// A byte of [`cell_flags`](super::cell_flags) per cell.
    pub(crate) flags: &'a [u8],
}

impl DoorLayers<'_> {
    /// True for a cell without an obstacle, also in a blocked space: a tread that is floor is none.
    fn is_open(&self, cell: usize) -> bool {
        match self.class[cell] {
            class if class == Class::Stair.id() => self.flags[cell] & OCCUPIED == 0,
            class => [Class::None.id(), Class::Door.id()].contains(&class),
        }
    }
}

/// The passage of a door on a map with these layers, where its element has this presence.
pub(crate) fn door_passage(
    door: &StoreyDoor,
    inputs: StoreyInputs<'_>,
    schedule_state: &ScheduleState<'_>,
    presence: Presence,
    layers: DoorLayers<'_>,
    nearby: &mut CoveredSamples,
    seen: &mut SeenCells,
) -> DoorPassageRecord {
    let StoreyInputs { robot, storey, .. } = inputs;
    let way = doorway(&door.leaves, door.leaf_index, schedule_state);
    let mut record = DoorPassageRecord {
        door: door.door,
        map_storey: storey.map_storey,
        passage: DoorPassage::Passable.into(),
        sides_with_floor: sides_with_floor(&way.plan, &storey.spec, |i| layers.floor[i] != 0),
        width_in_map_m: free_width_m(&way.plan, &storey.spec, |cell| layers.is_open(cell)),
        clear_width_m: way.clear_width_m,
        width_between_obstacles_m: 0.0,
        needed_resolution_m: 0.0,
        way: BoxRecord::from(way.plan),
        reasons: 0,
        obstacle: NONE,
    };
    if !presence.is_obstacle() || !door.is_hung(schedule_state) {
        record.passage = DoorPassage::Absent.into();
        return record;
    }
    let is_narrow = !is_wide_enough(robot, way.clear_width_m);
    for (is_one, reason) in [
        (presence == Presence::WorkedOn, DoorPassage::InProgress),
        (record.sides_with_floor == 0 || !door.stands_here, DoorPassage::NoFloor),
        (!door.leaf().opens, DoorPassage::CannotOpen),
        (is_narrow, DoorPassage::TooNarrow),
    ] {
        record.reasons |= if is_one { reason.bit() } else { 0 };
    }
    let outline = outline_of_passage(&way.plan, robot, &storey.spec);
    let is_narrow_in_map = record.width_in_map_m < 2.0 * robot.radius_m;
    let joins = |seen| {
        let has_floor = |cell: usize| layers.floor[cell] != 0;
        let is_open = |cell| layers.is_open(cell);
        joins_sides([&way.plan, &outline], record.sides_with_floor, &storey.spec, (is_open, has_floor), seen)
    };
    if !is_narrow && (is_narrow_in_map || !joins(seen)) {
        // The way alone first: what stands beside it matters only where nothing stands in it.
        let mut clearance = doorway_clearance(&way.plan, inputs, schedule_state, nearby);
        if !is_narrow_in_map && clearance.width_m >= 2.0 * robot.radius_m {
            clearance = doorway_clearance(&outline, inputs, schedule_state, nearby);
        }
        add_reason_of_cells(&mut record, clearance, inputs, door);
    }
    record.passage = record.closed_by().next().unwrap_or(DoorPassage::Passable).into();
    record
}

/// Adds the reason why a doorway of sufficient clear width is too narrow on the map.
fn add_reason_of_cells(
    record: &mut DoorPassageRecord,
    clearance: DoorwayClearance,
    inputs: StoreyInputs<'_>,
    door: &StoreyDoor,
) {
    let StoreyInputs { robot, storey, .. } = inputs;
    let spare_m = clearance.width_m - 2.0 * robot.radius_m;
    record.width_between_obstacles_m = clearance.width_m;
    let reason = if spare_m >= 0.0 {
        // Where a finer map would not open it either, no resolution is named.
        let needed_m = needed_resolution_m(&record.way.to_box(), spare_m);
        record.needed_resolution_m = if needed_m < storey.spec.resolution_m() { needed_m } else { 0.0 };
        DoorPassage::ClosedByResolution
    } else {
        record.obstacle = clearance.obstacle;
        if clearance.is_walled_up { walled_up(inputs, door, clearance.obstacle) } else { DoorPassage::Obstructed }
    };
    record.reasons |= reason.bit();
}

/// Why walls close a doorway: another wall stands there, the opening begins above the floor, it leaves its wall uncut, or
/// there is none.
fn walled_up(inputs: StoreyInputs<'_>, door: &StoreyDoor, obstacle: u32) -> DoorPassage {
    let StoreyInputs { site, robot, storey } = inputs;
    let Some(opening) = site.openings.get(site.doors[door.door as usize].opening as usize) else {
        return DoorPassage::NoOpening;
    };
    if opening.host != obstacle {
        DoorPassage::Obstructed
    } else if opening.bottom_z_tenths > storey.floor_z + slab_above_floor(robot)[0] {
        DoorPassage::Threshold
    } else {
        DoorPassage::WallUncut
    }
}

/// A resolution in whole millimetres at which a doorway that is wider than the robot by `spare_m` stays passable.
fn needed_resolution_m(way: &OrientedBox, spare_m: f64) -> f64 {
    let is_aligned = way.axis.iter().any(|a| a.abs() < 1e-3);
    let cells = CELLS_LOST[usize::from(!is_aligned)];
    ((spare_m / cells * 1000.0).floor() / 1000.0).max(0.001)
}

/// Width of the narrowest line across a passage over cells without an obstacle, in metres. Blocked spaces beside a door do
/// not make it narrower.
fn free_width_m(plan: &OrientedBox, spec: &GridSpec, is_open: impl Fn(usize) -> bool) -> f64 {
    let cell = f64::from(spec.cell_tenths);
    let is_open = |at: [f64; 2]| {
        let [x, y] = at.map(|c| c / f64::from(TENTHS_PER_M));
        spec.cell_at(Point2::<Map>::new(x, y)).is_some_and(|c| is_open(spec.index(c)))
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
