//! Floor cells of a storey at a schedule state, from finished floor elements or assumed floor.

use super::other_levels::at_other_levels;
use crate::model::cell_area::{BESIDE_PASSAGE_M, reach_beside};
use crate::model::gap::CRACK;
use crate::model::storey_slice::{FloorPiece, StoreyCut};
use frames::{Map, Point2, TENTHS_PER_M};
use geometry::{FillRule, MultiPolygon, OrientedBox, Ring, close_gaps, difference, union};
use grid::{Class, GridSpec, Mask, Run, covered_cells, enclosed, fill_holes};
use messages::{FloorKind, RegionRecord, RobotProfile, Site};
use std::collections::HashMap;

/// Obstacles with gaps up to this width enclose an interior.
const ENCLOSING_GAP_M: f64 = 2.0;

/// Bytes of runs that are kept of a storey before all are made anew.
const MAX_KEPT_BYTES: usize = 32 << 20;

/// What the finished floor of a storey makes of it.
#[derive(Debug, Default)]
pub(crate) struct FloorPlan {
    /// Cells that floor covers whole, passages through walls not counted; none on a storey whose floor is what its obstacles
    /// enclose, or that has none.
    pub(crate) runs: Vec<Run>,
    /// Floor at other levels.
    pub(crate) regions: Vec<RegionRecord>,
}

/// Floor plans by which elements are finished: made once, looked up when a date comes again.
#[derive(Debug, Default)]
pub(crate) struct FloorPlans {
    plans: HashMap<Box<[u64]>, FloorPlan>,
    bytes: usize,
}

/// A set of places, as bits.
pub(crate) fn is_in(set: &[u64], place: u32) -> bool {
    set.get(place as usize / 64).is_some_and(|word| word >> (place % 64) & 1 == 1)
}

/// Puts a place into a set or out of it.
pub(crate) fn put(set: &mut Vec<u64>, place: u32, is_in: bool) {
    let (word, bit) = (place as usize / 64, 1u64 << (place % 64));
    if set.len() <= word {
        set.resize(word + 1, 0);
    }
    if is_in { set[word] |= bit } else { set[word] &= !bit }
}

impl FloorPlans {
    /// The plan when these of the storey's floor elements are finished.
    pub(crate) fn of(
        &mut self,
        site: &Site<'_>,
        robot: &RobotProfile,
        storey: &StoreyCut,
        finished: &[u64],
    ) -> &FloorPlan {
        if !self.plans.contains_key(finished) {
            let plan = floor_plan(site, robot, storey, finished);
            let bytes = size_of_val(plan.runs.as_slice()) + size_of_val(plan.regions.as_slice());
            if self.bytes + bytes > MAX_KEPT_BYTES {
                self.plans.clear();
                self.bytes = 0;
            }
            self.bytes += bytes;
            self.plans.insert(finished.into(), plan);
        }
        &self.plans[finished]
    }
}

fn floor_plan(site: &Site<'_>, robot: &RobotProfile, storey: &StoreyCut, finished: &[u64]) -> FloorPlan {
    let places = storey.dependents.iter().filter_map(|n| Some((n.element, n.floor_place?)));
    let is_finished: Vec<u32> = places.filter(|(_, place)| is_in(finished, *place)).map(|(e, _)| e).collect();
    let built = plan_of(&storey.floor, |piece| is_finished.binary_search(&piece.element).is_ok());
    // Where another level lies in the way of the robot nobody stands on this one.
    let above = plan_of(&storey.floor_above, |piece| is_finished.binary_search(&piece.element).is_ok());
    let runs = match storey.floor_kind {
        FloorKind::AssumedFromSpaces => storey.assumed_floor.clone(),
        FloorKind::AssumedFromEnclosure | FloorKind::Missing => Vec::new(),
        FloorKind::Built if above.is_empty() => covered_cells(&built, &storey.spec),
        FloorKind::Built => covered_cells(&difference(&built, &above), &storey.spec),
    };
    FloorPlan { runs, regions: at_other_levels(site, robot, storey, &is_finished, &built) }
}

/// The plan of some pieces of floor, cracks between them closed.
fn plan_of(pieces: &[FloorPiece], wanted: impl Fn(&FloorPiece) -> bool) -> MultiPolygon {
    let rings: Vec<Ring> = pieces.iter().filter(|p| wanted(p)).flat_map(|p| p.rings.iter().cloned()).collect();
    close_gaps(&union(&rings, FillRule::NonZero), CRACK)
}

/// What those obstacles enclose that stand, doors not counted: the floor of a storey without floor faces and spaces.
pub(crate) fn enclosed_floor(storey: &StoreyCut, stands: impl Fn(u32) -> bool) -> Mask {
    let mut obstacles = Mask::new(storey.spec.width as usize, storey.spec.height as usize);
    let standing = storey.obstacles.iter().filter(|o| o.class != Class::Door && stands(o.element));
    standing.for_each(|o| obstacles.set_runs(&o.runs));
    enclosed(&obstacles, (ENCLOSING_GAP_M / storey.spec.resolution_m()).round() as usize)
}

/// Everything inside the storey when it is complete: what is not built yet is a drop-off inside it, not outside.
/// `complete` is the floor when everything is finished.
pub(crate) fn outline(storey: &StoreyCut, complete: &FloorPlan) -> Mask {
    let mut ground = match storey.floor_kind {
        FloorKind::AssumedFromEnclosure => enclosed_floor(storey, |_| true),
        FloorKind::Built | FloorKind::AssumedFromSpaces | FloorKind::Missing => {
            Mask::new(storey.spec.width as usize, storey.spec.height as usize)
        }
    };
    storey.obstacles.iter().for_each(|o| ground.set_runs(&o.runs));
    ground.set_runs(&complete.runs);
    storey.spaces.iter().for_each(|s| ground.set_runs(&s.runs));
    storey.passages.iter().for_each(|p| ground.set_runs(&p.runs));
    fill_holes(&ground)
}

/// On how many sides of a passage there is floor.
pub(crate) fn sides_with_floor(plan: &OrientedBox, spec: &GridSpec, floor: impl Fn(usize) -> bool) -> u32 {
    let is_floor = |at: [f64; 2]| {
        let [x, y] = at.map(|c| c / f64::from(TENTHS_PER_M));
        spec.cell_at(Point2::<Map>::new(x, y)).is_some_and(|cell| floor(spec.index(cell)))
    };
    let steps = (BESIDE_PASSAGE_M / spec.resolution_m()).ceil().max(2.0) as i32;
    let reach = reach_beside(spec);
    let along = [-0.6, -0.3, 0.0, 0.3, 0.6];
    let side = |sign: f64| {
        let beside = |u: f64| {
            (1..=steps).any(|k| {
                let off = reach * f64::from(k) / f64::from(steps);
                is_floor(plan.at(u * plan.half[0], sign * (plan.half[1] + off)))
            })
        };
        2 * along.iter().filter(|u| beside(**u)).count() > along.len()
    };
    u32::from(side(-1.0)) + u32::from(side(1.0))
}
