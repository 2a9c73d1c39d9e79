//! Leaves of one door opening that a robot can have open at the same time.

use super::presence::Look;
use frames::TENTHS_PER_M;
use geometry::OrientedBox;
use messages::{ClearWidth, DoorRecord, NONE, Phase, RobotProfile, Site};

/// Leaves of one opening; more are doors in a row.
const MAX_LEAVES: usize = 32;

/// Frame and leaves take this much of the width of leaves whose frame the model does not tell.
const ASSUMED_LOSS_M: f64 = 0.10;

/// A leaf of an opening.
#[derive(Debug, Clone)]
pub(crate) struct Leaf {
    /// Its element.
    pub(crate) element: u32,
    /// Element in which it hangs, or [`NONE`].
    pub(crate) host: u32,
    /// True if the robot opens doors of this operation.
    pub(crate) opens: bool,
    /// Its width, no more than that of its passage.
    width_m: f64,
    clear_width_m: f64,
    /// True if the clear width follows from its lining and its leaf.
    clear_width_is_told: bool,
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
            clear_width_is_told: record.clear_width_from == ClearWidth::LiningAndPanel as u32,
            passage,
        }
    }

    /// True if the wall that it hangs in stands, or it hangs in none.
    pub(crate) fn host_stands(&self, phase: &Phase<'_>) -> bool {
        self.host == NONE || phase.effective(self.host as usize).is_obstacle()
    }

    /// True if a robot can have it open: it hangs and opens, or it is not there yet.
    fn is_open(&self, phase: &Phase<'_>) -> bool {
        match Look::of(phase.effective(self.element as usize)) {
            Look::Built => self.opens,
            Look::WorkedOn => false,
            Look::Absent => true,
        }
    }
}

/// The way through a door at a phase.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Way {
    /// Passages of the leaves that count together.
    pub(crate) plan: OrientedBox,
    /// Their clear width.
    pub(crate) clear_width_m: f64,
}

/// The leaves of the opening that a door hangs in, in the order in which they follow each other, and the door's place among
/// them; `None` for a door that the site does not have.
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
            // A broken archive may hold neighbours that do not know each other.
            if !beside.beside.contains(&before) {
                break;
            }
            let at = if side == 0 { 0 } else { row.len() };
            row.insert(at, next);
            next = beside.beside[usize::from(beside.beside[0] == before)];
        }
    }
    let place = row.iter().position(|&d| d == door)?;
    Some((row.iter().map(|&d| Leaf::new(site, robot, &site.doors[d as usize])).collect(), place))
}

/// The way through the leaf at this place: together with those beside it that are open, as far as the first that is not.
pub(crate) fn way_through(leaves: &[Leaf], place: usize, phase: &Phase<'_>) -> Way {
    let is_open = |k: usize| leaves[k].is_open(phase);
    let (mut first, mut last) = (place, place);
    // What is worked on or does not open is a way of its own, which is closed.
    if is_open(place) {
        while first > 0 && is_open(first - 1) {
            first -= 1;
        }
        while last + 1 < leaves.len() && is_open(last + 1) {
            last += 1;
        }
    }
    let together = &leaves[first..=last];
    let plan = union_of_passages(together);
    Way { plan, clear_width_m: clear_width_m(together, &plan) }
}

/// Clear width of leaves that follow each other: what their frames leave, where the model tells them; else their widths less
/// what one frame takes.
fn clear_width_m(leaves: &[Leaf], plan: &OrientedBox) -> f64 {
    if let [leaf] = leaves {
        return leaf.clear_width_m;
    }
    let told = leaves.iter().filter(|l| l.clear_width_is_told).map(|l| l.clear_width_m).sum::<f64>();
    let assumed = leaves.iter().filter(|l| !l.clear_width_is_told).map(|l| l.width_m).sum::<f64>();
    let whole_m = 2.0 * plan.half[0] / f64::from(TENTHS_PER_M);
    (told + (assumed - ASSUMED_LOSS_M).max(0.0)).min(whole_m)
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
