//! Whether a robot can pass a door.

use crate::compose::is_worked_on;
use crate::cut::StoreyCut;
use crate::floor::sides_with_floor;
use frames::{Map, Point2, TENTHS_PER_M};
use geometry::OrientedBox;
use grid::Class;
use messages::{DoorPassage, DoorPassageRecord, DoorRecord, Grid, NONE, Phase, RobotProfile, Site};

/// Widths that differ by less are equal: a door of exactly the robot's width and margin is passable.
const WIDTH_TOLERANCE_M: f64 = 1e-6;

/// What the robot can do with a door, whatever the map's resolution.
pub(crate) fn verdict(robot: &RobotProfile, door: &DoorRecord) -> DoorPassage {
    if door.opens & robot.opens == 0 {
        DoorPassage::CannotOpen
    } else if door.clear_width_m + WIDTH_TOLERANCE_M < 2.0 * robot.radius_m + robot.door_margin_m {
        DoorPassage::TooNarrow
    } else {
        DoorPassage::Passable
    }
}

/// True if the wall that the door hangs in stands, or it hangs in none.
pub(crate) fn is_hung(site: &Site<'_>, phase: &Phase<'_>, door: &DoorRecord) -> bool {
    let host = if door.opening == NONE { NONE } else { site.openings[door.opening as usize].host };
    host == NONE || phase.effective(host as usize).is_obstacle()
}

/// What a robot finds at the doors of a storey.
pub(crate) fn passages(
    site: &Site<'_>,
    phase: &Phase<'_>,
    robot: &RobotProfile,
    storey: &StoreyCut,
    grid: &Grid<'_>,
) -> Vec<DoorPassageRecord> {
    let doors = storey.obstacles.iter().filter(|o| o.class == Class::Door);
    let doors = doors.map(|o| site.elements[o.element as usize].door).filter(|&d| d != NONE);
    doors
        .map(|index| {
            let door = &site.doors[index as usize];
            let plan = door.passage.to_box();
            let width_in_map_m = free_width_m(&plan, grid);
            let present = phase.effective(door.element as usize).is_obstacle() && is_hung(site, phase, door);
            let passage = match verdict(robot, door) {
                _ if !present => DoorPassage::Absent,
                _ if is_worked_on(phase, door.element) => DoorPassage::InProgress,
                DoorPassage::Passable if width_in_map_m < 2.0 * robot.radius_m => DoorPassage::ClosedByResolution,
                verdict => verdict,
            };
            DoorPassageRecord {
                door: index,
                map_storey: storey.map_storey,
                passage: passage as u32,
                sides_with_floor: sides_with_floor(&plan, &storey.spec, |i| grid.floor[i] != 0),
                width_in_map_m,
            }
        })
        .collect()
}

/// Width of the narrowest line across a passage, in cells without an obstacle, in metres. That a space beside it is blocked
/// does not make a door narrower.
fn free_width_m(plan: &OrientedBox, grid: &Grid<'_>) -> f64 {
    let spec = grid.spec();
    let cell = f64::from(spec.cell_tenths);
    let is_open = |at: [f64; 2]| {
        let [x, y] = at.map(|c| c / f64::from(TENTHS_PER_M));
        spec.cell_at(Point2::<Map>::new(x, y))
            .is_some_and(|c| [Class::None.id(), Class::Door.id()].contains(&grid.class[spec.index(c)]))
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
