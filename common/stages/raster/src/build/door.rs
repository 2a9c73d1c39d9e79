//! Builds a door of a storey: its leaves, and its body's cells in its passage.

use crate::model::cell_area::cells_beside;
use crate::model::door::StoreyDoor;
use crate::model::door_leaves::{leaves_of, union_of_passages};
use frames::TENTHS_PER_M;
use geometry::{FillRule, OrientedBox, union};
use grid::{GridSpec, Run, overlapped_cells};
use messages::{DoorRecord, RobotProfile, Site};

/// A door without an opening whose box is deeper than this, in tenths of a millimetre, is drawn with an open leaf.
const MAX_DEPTH: f64 = 0.5 * TENTHS_PER_M as f64;

/// The door of the site with this index, whose body covers the runs `body`; `None` for [`messages::NONE`]. `stands_here` tells whether
/// a door belongs to the floor that is drawn.
pub(crate) fn storey_door(
    site: &Site<'_>,
    robot: &RobotProfile,
    spec: &GridSpec,
    (door, body): (u32, &[Run]),
    stands_here: impl Fn(&DoorRecord) -> bool,
) -> Option<StoreyDoor> {
    let record = site.doors.get(door as usize)?;
    let (leaves, leaf_index) = leaves_of(site, robot, door)?;
    let plan = record.passage.to_box();
    let opening = site.openings.get(record.opening as usize);
    let is_passage = opening.is_some_and(messages::OpeningRecord::is_in_wall) || 2.0 * plan.half[1] <= MAX_DEPTH;
    let passage = if is_passage { union(&[plan.ring()], FillRule::NonZero) } else { Default::default() };
    let has_fixed_leaf = site.moving_leaves(record).is_some_and(|leaves| leaves.share < 1.0);
    let fixed_runs = if has_fixed_leaf { beyond(&plan, body, spec) } else { Vec::new() };
    Some(StoreyDoor {
        door,
        around: cells_beside(&union_of_passages(&leaves), spec),
        passage_runs: in_both(&overlapped_cells(&passage, &[], spec), body),
        fixed_runs,
        stands_here: stands_here(record),
        leaves,
        leaf_index,
    })
}

/// The cells of a body that a passage does not hold: half a cell of the passage belongs to what stands beside it.
fn beyond(passage: &OrientedBox, body: &[Run], spec: &GridSpec) -> Vec<Run> {
    let half = [passage.half[0] - f64::from(spec.cell_tenths) / 2.0, passage.half[1]].map(|h| h.max(0.0));
    let inner = union(&[OrientedBox { half, ..*passage }.ring()], FillRule::NonZero);
    let inside = in_both(&overlapped_cells(&inner, &[], spec), body);
    let mut found = Vec::new();
    for run in body {
        let mut start = run.start;
        for hole in inside.iter().filter(|i| i.row == run.row && run.start <= i.start && i.end <= run.end) {
            if start < hole.start {
                found.push(Run { row: run.row, start, end: hole.start });
            }
            start = hole.end;
        }
        if start < run.end {
            found.push(Run { row: run.row, start, end: run.end });
        }
    }
    found
}

/// The intersection of two sorted lists of runs, sorted.
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
