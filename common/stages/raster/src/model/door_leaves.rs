//! Leaves of one door opening that can be open at the same time, and their combined clear width.

use super::presence::Presence;
use frames::TENTHS_PER_M;
use geometry::OrientedBox;
use messages::{ClearWidth, DoorRecord, NONE, RobotProfile, ScheduleState, Site};

/// Limit of leaves of one opening; a longer row consists of separate doors.
const MAX_LEAVES: usize = 32;

/// Width taken by frame and leaves where the model does not give the lining.
const ASSUMED_FRAME_WIDTH_M: f64 = 0.10;

/// A leaf of an opening.
#[derive(Debug, Clone)]
pub(crate) struct Leaf {
    /// Its element.
    pub(crate) element: u32,
    /// Element in which it hangs, or [`NONE`].
    pub(crate) host: u32,
    /// True if the robot can open doors of this operation type.
    pub(crate) opens: bool,
    /// Overall width, at most that of its passage.
    width_m: f64,
    clear_width_m: f64,
    /// True if the clear width follows from its lining and its leaf.
    clear_width_is_modelled: bool,
    passage: OrientedBox,
}

impl Leaf {
    fn new(site: &Site<'_>, robot: &RobotProfile, record: &DoorRecord) -> Self {
        let passage = record.passage.to_box();
        let passage_m = 2.0 * passage.half[0] / f64::from(TENTHS_PER_M);
        let opening = site.openings.get(record.opening as usize);
        Self {
            element: record.element,
            host: opening.map_or(NONE, |o| o.host),
            opens: record.opens & robot.opens != 0,
            width_m: record.overall_width_m.min(passage_m),
            clear_width_m: record.clear_width_m,
            clear_width_is_modelled: record.clear_width_from == ClearWidth::LiningAndPanel,
            passage,
        }
    }

    /// True if the host wall stands, or there is none.
    pub(crate) fn host_stands(&self, schedule_state: &ScheduleState<'_>) -> bool {
        self.host == NONE || schedule_state.effective(self.host as usize).is_obstacle()
    }

    /// True if the robot can pass it: it is built and opens, or it is absent.
    fn is_open(&self, schedule_state: &ScheduleState<'_>) -> bool {
        match Presence::of(schedule_state.effective(self.element as usize)) {
            Presence::Built => self.opens,
            Presence::WorkedOn => false,
            Presence::Absent => true,
        }
    }
}

/// The passable opening at a door in a schedule state: one leaf, or several adjoining leaves.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Doorway {
    /// Box around the passages of these leaves.
    pub(crate) plan: OrientedBox,
    /// Their clear width.
    pub(crate) clear_width_m: f64,
}

/// The leaves of the opening of a door in the order in which they adjoin, and the index of the door among them; `None` for a
/// door that is not in the site.
pub(crate) fn leaves_of(site: &Site<'_>, robot: &RobotProfile, door: u32) -> Option<(Vec<Leaf>, usize)> {
    let record = site.doors.get(door as usize)?;
    let mut row = vec![door];
    for side in [0, 1] {
        let mut next = record.beside[side];
        while let Some(beside) = site.doors.get(next as usize)
            && row.len() < MAX_LEAVES
            && !row.contains(&next)
        {
            let before = if side == 0 { row[0] } else { row[row.len() - 1] };
            // In a broken archive neighbours may not refer to each other.
            if !beside.beside.contains(&before) {
                break;
            }
            let at = if side == 0 { 0 } else { row.len() };
            row.insert(at, next);
            next = beside.beside[usize::from(beside.beside[0] == before)];
        }
    }
    let index = row.iter().position(|&d| d == door)?;
    Some((row.iter().map(|&d| Leaf::new(site, robot, &site.doors[d as usize])).collect(), index))
}

/// The doorway through the leaf at this index: with its neighbours on both sides as far as the first leaf that is not open.
pub(crate) fn doorway(leaves: &[Leaf], index: usize, schedule_state: &ScheduleState<'_>) -> Doorway {
    let is_open = |k: usize| leaves[k].is_open(schedule_state);
    let (mut first, mut last) = (index, index);
    // A leaf that is worked on or cannot be opened is a doorway of its own, which is closed.
    if is_open(index) {
        while first > 0 && is_open(first - 1) {
            first -= 1;
        }
        while last + 1 < leaves.len() && is_open(last + 1) {
            last += 1;
        }
    }
    let together = &leaves[first..=last];
    let plan = union_of_passages(together);
    Doorway { plan, clear_width_m: clear_width_m(together, &plan) }
}

/// Clear width of adjoining leaves: the sum of modelled clear widths and, for the other leaves, of their widths less one
/// assumed frame.
fn clear_width_m(leaves: &[Leaf], plan: &OrientedBox) -> f64 {
    if let [leaf] = leaves {
        return leaf.clear_width_m;
    }
    let modelled = leaves.iter().filter(|l| l.clear_width_is_modelled).map(|l| l.clear_width_m).sum::<f64>();
    let assumed = leaves.iter().filter(|l| !l.clear_width_is_modelled).map(|l| l.width_m).sum::<f64>();
    let whole_m = 2.0 * plan.half[0] / f64::from(TENTHS_PER_M);
    (modelled + (assumed - ASSUMED_FRAME_WIDTH_M).max(0.0)).min(whole_m)
}

/// The box around the passages of leaves, along the axis of the first.
pub(crate) fn union_of_passages(leaves: &[Leaf]) -> OrientedBox {
    let Some((first, rest)) = leaves.split_first() else {
        return OrientedBox { centre: [0.0; 2], axis: [1.0, 0.0], half: [0.0; 2] };
    };
    let axis = first.passage.axis;
    let across = first.passage.across();
    let range = |b: &OrientedBox, to: [f64; 2]| {
        let dot = |v: [f64; 2]| v[0] * to[0] + v[1] * to[1];
        let reach = b.half[0] * dot(b.axis).abs() + b.half[1] * dot(b.across()).abs();
        [dot(b.centre) - reach, dot(b.centre) + reach]
    };
    let mut ranges = [axis, across].map(|to| range(&first.passage, to));
    for leaf in rest {
        for (whole, to) in ranges.iter_mut().zip([axis, across]) {
            let own = range(&leaf.passage, to);
            *whole = [whole[0].min(own[0]), whole[1].max(own[1])];
        }
    }
    if rest.is_empty() {
        return first.passage;
    }
    let middle = ranges.map(|[lo, hi]| (lo + hi) / 2.0);
    OrientedBox {
        centre: [0, 1].map(|k| axis[k] * middle[0] + across[k] * middle[1]),
        axis,
        half: ranges.map(|[lo, hi]| (hi - lo) / 2.0),
    }
}
