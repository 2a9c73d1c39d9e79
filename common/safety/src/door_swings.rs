//! The floor over which leaves of doors swing: quarters of a circle around the hinges, as far as nothing stands in them.

use crate::rule_elements::StoreyElements;
use geometry::OrientedBox;
use grid::{CellRect, Run, grow_labelled};
use messages::door_operations::{DoorFrame, Leaf, LeafMotion, OperationSource, mirrored, operation_of};
use messages::{DoorCapability, DoorRecord, FloorKind, NONE};

/// An operation type that says nothing: as a door that is hung on either side, both ways.
const UNKNOWN: [&str; 2] = ["DOUBLE_SWING_LEFT", "DOUBLE_SWING_RIGHT"];

/// Corners of a quarter of a circle besides the hinge.
const N_CORNERS: u32 = 13;

/// The doors of the storey that are hung and swing, each with the cells over which its leaves do.
pub(crate) fn door_swings(storey: StoreyElements<'_>, is_open: &impl Fn(usize) -> bool) -> Vec<(u32, Vec<Run>)> {
    // A door belongs to the storey of its floor; outdoors are those that open at the height of the ground before them.
    let is_outdoors = storey.grid.head.floor == FloorKind::Ground;
    let is_here = |door: &&DoorRecord| {
        let swings = DoorCapability::Swing as u32 | DoorCapability::Folding as u32;
        let swings = door.opens & swings != 0 && door.passage.half[0] > 0.0 && storey.is_hung(door);
        let here = || door.map_storey == storey.grid.head.map_storey || door.map_storey == NONE;
        swings && (here() || is_outdoors && storey.is_at_robot(door.element))
    };
    let doors = storey.site.doors.iter().filter(is_here);
    doors.map(|door| (door.element, swept(storey, door, is_open))).filter(|(_, runs)| !runs.is_empty()).collect()
}

/// Cells of the sectors that hang together with the passage of the door.
fn swept(storey: StoreyElements<'_>, door: &DoorRecord, is_open: &impl Fn(usize) -> bool) -> Vec<Run> {
    let moving = door.passage.to_box();
    let Some(leaves) = storey.site.moving_leaves(door) else { return Vec::new() };
    let whole = leaves.whole_of(&moving, door.hanging.along);
    let spec = storey.spec();
    let (all, width) = (CellRect::whole(spec.width, spec.height), spec.width as usize);
    let mut is_swept = vec![false; spec.n_cells()];
    for sector in sectors(storey, door, &whole) {
        for cells in all.clip(&storey.overlapped(&sector), width) {
            is_swept[cells].fill(true);
        }
    }
    let [u, v] = moving.half;
    let passage = storey.overlapped(&[[-u, -v], [u, -v], [u, v], [-u, v]].map(|[u, v]| moving.at(u, v)));
    // The leaf does not swing through a wall beside the door.
    let reached =
        grow_labelled(all, |cell| is_swept[cell] && is_open(cell), [(0, passage.as_slice())].into_iter(), u32::MAX / 2);
    let cells = reached.iter().enumerate().filter(|(_, nearest)| nearest.is_some()).map(|(cell, _)| spec.cell_of(cell));
    cells.map(|at| Run { row: at.row, start: at.column, end: at.column + 1 }).collect()
}

/// Sectors of all leaves of a door in `map`.
fn sectors(storey: StoreyElements<'_>, door: &DoorRecord, whole: &OrientedBox) -> Vec<Vec<[f64; 2]>> {
    let frame = DoorFrame::of(door, whole);
    let width = 2.0 * whole.half[0];
    let mut found = Vec::new();
    for unknown in UNKNOWN {
        let Some((_, mut leaves, source)) = operation_of(storey.site, door, unknown) else { continue };
        if frame.turned {
            mirrored(&mut leaves);
        }
        for leaf in &leaves {
            let Leaf { span, motion } = *leaf;
            let (left, ways) = match motion {
                LeafMotion::Swing { left, both: true, .. } => (left, vec![-1.0, 1.0]),
                // Which side is the front, the model does not say.
                LeafMotion::Swing { left, .. } if frame.assumed => (left, vec![-1.0, 1.0]),
                LeafMotion::Swing { left, towards, .. } => (left, vec![towards]),
                LeafMotion::Fold { .. } => {
                    // Folded in the middle it stands out by half of its width.
                    let [from, to] = span.map(|share| share * width);
                    let depth = (to - from) / 2.0;
                    found.push(rectangle(&frame, [from, to], depth));
                    continue;
                }
                LeafMotion::Slide { .. } | LeafMotion::Rise | LeafMotion::Turn | LeafMotion::Fixed => continue,
            };
            let radius = (span[1] - span[0]) * width;
            let hinge = width * if left { span[0] } else { span[1] };
            let side = if left { 1.0 } else { -1.0 };
            found.extend(ways.into_iter().map(|way| sector(&frame, hinge, radius, [side, way])));
        }
        if source != OperationSource::Assumed {
            break;
        }
    }
    found
}

/// The rectangle over a stretch of the door's x axis, so deep on both sides; counter-clockwise.
fn rectangle(frame: &DoorFrame, [from, to]: [f64; 2], depth: f64) -> Vec<[f64; 2]> {
    let corners = [[from, -depth], [to, -depth], [to, depth], [from, depth]];
    corners.map(|[x, y]| frame.at(x, y)).to_vec()
}

/// A quarter of a circle, counter-clockwise: around a hinge on the door's x axis, to one side along it and one way across.
fn sector(frame: &DoorFrame, hinge: f64, radius: f64, [side, way]: [f64; 2]) -> Vec<[f64; 2]> {
    let at = |x: f64, y: f64| frame.at(x, y);
    // Corners lie outside of the circle, so that the polygon holds it.
    let step = std::f64::consts::FRAC_PI_2 / f64::from(N_CORNERS - 1);
    let outer = radius / libm::cos(step / 2.0);
    let mut corners = vec![at(hinge, 0.0)];
    corners.extend((0..N_CORNERS).map(|k| {
        let angle = f64::from(k) * step;
        at(hinge + side * outer * libm::cos(angle), way * outer * libm::sin(angle))
    }));
    if side * way < 0.0 {
        corners.reverse();
    }
    corners
}
