//! Builds a door of a storey: its leaves, and its body's cells in its passage.

use crate::model::cell_area::cells_beside;
use crate::model::door::StoreyDoor;
use crate::model::door_leaves::{leaves_of, union_of_passages};
use frames::TENTHS_PER_M;
use geometry::{FillRule, union};
use grid::{GridSpec, Run, overlapped_cells};
use messages::{RobotProfile, Site};

/// A door without an opening whose box is deeper than this, in tenths of a millimetre, is drawn with an open leaf.
const MAX_DEPTH: f64 = 0.5 * TENTHS_PER_M as f64;

/// The door of the site with this index, whose body covers the runs `body` on a map storey; `None` for [`messages::NONE`].
pub(crate) fn storey_door(
    site: &Site<'_>,
    robot: &RobotProfile,
    (spec, map_storey): (&GridSpec, usize),
    door: u32,
    body: &[Run],
) -> Option<StoreyDoor> {
    let record = site.doors.get(door as usize)?;
    let (leaves, leaf_index) = leaves_of(site, robot, door)?;
    let plan = record.passage.to_box();
    let opening = site.openings.get(record.opening as usize);
    let is_passage = opening.is_some_and(|o| o.plan.half[0] > 0.0) || 2.0 * plan.half[1] <= MAX_DEPTH;
    let passage = if is_passage { union(&[plan.ring()], FillRule::NonZero) } else { Default::default() };
    Some(StoreyDoor {
        door,
        around: cells_beside(&union_of_passages(&leaves), spec),
        passage_runs: in_both(&overlapped_cells(&passage, &[], spec), body),
        stands_here: record.map_storey == map_storey as u32,
        leaves,
        leaf_index,
    })
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
