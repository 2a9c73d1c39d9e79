//! The layers of one storey at one phase.

use crate::cut::StoreyCut;
use crate::doors::{is_hung, verdict};
use crate::floor::{floor_cells, floor_in_passages};
use crate::keepout::{KeepoutInput, keepout};
use crate::localization::{LocalizationInput, localization};
use grid::{Class, Mask};
use messages::{DoorPassage, ElementState, FloorKind, GridLayers, NONE, Phase, RobotProfile, Site};

/// Occupied in `nav_msgs`.
pub(crate) const OCCUPIED: i8 = 100;
/// Free in `nav_msgs`.
pub(crate) const FREE: i8 = 0;
/// Unknown in `nav_msgs`.
pub(crate) const UNKNOWN: i8 = -1;

/// Fills the layers, which hold zeros.
pub(crate) fn compose(
    site: &Site<'_>,
    phase: &Phase<'_>,
    robot: &RobotProfile,
    storey: &StoreyCut,
    layers: GridLayers<'_>,
) {
    let (width, height) = (storey.spec.width as usize, storey.spec.height as usize);
    let closed_doors = draw_classes(site, phase, robot, storey, layers.class);
    let blocked = draw_spaces(phase, storey, layers.space);
    let is_obstacle = |&c: &u8| c != Class::None.id() && c != Class::Door.id();
    let obstacles = Mask { width, cells: layers.class.iter().map(is_obstacle).collect() };

    let mut floor = floor_cells(site, phase, storey, &obstacles);
    let passages: Vec<_> = floor_in_passages(phase, storey, &floor).collect();
    passages.iter().for_each(|p| floor.set_runs(&p.runs));
    let kind = match FloorKind::from_id(site.map_storeys[storey.map_storey as usize].floor) {
        Some(FloorKind::Built) | None => 1,
        Some(FloorKind::AssumedFromSpaces | FloorKind::AssumedFromEnclosure) => 2,
    };
    for (cell, &on) in layers.floor.iter_mut().zip(&floor.cells) {
        *cell = if on { kind } else { 0 };
    }

    if phase.head.plan_time().is_some() && !floor.cells.contains(&true) {
        // Nobody can stand anywhere yet, whatever stands there already.
        layers.planning.fill(UNKNOWN);
        layers.localization.fill(UNKNOWN);
        layers.keepout.fill(OCCUPIED);
        return;
    }
    let mut occupied = obstacles.clone();
    occupied.set_all(&closed_doors);
    let mut free = Mask::new(width, height);
    for index in 0..free.cells.len() {
        let open_door = layers.class[index] == Class::Door.id();
        free.cells[index] = !occupied.cells[index] && (floor.cells[index] || open_door);
        layers.planning[index] = if occupied.cells[index] || blocked.cells[index] {
            OCCUPIED
        } else if free.cells[index] {
            FREE
        } else {
            UNKNOWN
        };
    }
    let input = KeepoutInput {
        site,
        phase,
        robot,
        storey,
        free: &free,
        occupied: &occupied,
        floor: &floor,
        blocked: &blocked,
        class: layers.class,
    };
    keepout(&input, layers.keepout);
    localization(&LocalizationInput { phase, storey, floor: &floor, class: layers.class }, layers.localization);
}

/// Draws what stands, the higher class over the lower; returns the cells of doors that are closed to this robot.
fn draw_classes(
    site: &Site<'_>,
    phase: &Phase<'_>,
    robot: &RobotProfile,
    storey: &StoreyCut,
    class: &mut [u8],
) -> Mask {
    let width = storey.spec.width as usize;
    let mut closed = Mask::new(width, storey.spec.height as usize);
    let mut by_priority: Vec<_> = storey.obstacles.iter().filter(|o| stands(site, phase, o.element)).collect();
    // Elements of one class do not differ in a cell: a stable order is not needed.
    by_priority.sort_by_key(|o| o.class.draw_priority());
    for obstacle in by_priority {
        for run in &obstacle.runs {
            let row = run.row as usize * width;
            class[row + run.start as usize..row + run.end as usize].fill(obstacle.class.id());
        }
        let door = site.elements[obstacle.element as usize].door;
        let opens = |door: u32| verdict(robot, &site.doors[door as usize]) == DoorPassage::Passable;
        // A door that is being hung or taken down is as good as closed.
        if door != NONE && (is_worked_on(phase, obstacle.element) || !opens(door)) {
            closed.set_runs(&obstacle.runs);
        }
    }
    closed
}

/// True if the element is in the way at this phase: it is there, and so is the wall it hangs in.
fn stands(site: &Site<'_>, phase: &Phase<'_>, element: u32) -> bool {
    let record = &site.elements[element as usize];
    phase.effective(element as usize).is_obstacle()
        && (record.door == NONE || is_hung(site, phase, &site.doors[record.door as usize]))
}

/// Draws the spaces, the smaller over the larger; returns the cells of blocked ones.
fn draw_spaces(phase: &Phase<'_>, storey: &StoreyCut, layer: &mut [u16]) -> Mask {
    let width = storey.spec.width as usize;
    let mut blocked = Mask::new(width, storey.spec.height as usize);
    for space in &storey.spaces {
        for run in &space.runs {
            let row = run.row as usize * width;
            layer[row + run.start as usize..row + run.end as usize].fill(space.space as u16 + 1);
        }
        if phase.is_blocked(space.space as usize) {
            blocked.set_runs(&space.runs);
        }
    }
    blocked
}

/// True if work goes on at the element.
pub(crate) fn is_worked_on(phase: &Phase<'_>, element: u32) -> bool {
    matches!(phase.effective(element as usize), ElementState::InProgress | ElementState::BeingRemoved)
}
