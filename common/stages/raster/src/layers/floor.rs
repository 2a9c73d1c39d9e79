//! Floor cells of a storey at a schedule state, from finished floor elements or assumed floor.

use super::ground_floor::{GroundFloor, ground_floor};
use super::other_levels::at_other_levels;
use crate::model::cell_area::{BESIDE_PASSAGE_M, reach_beside};
use crate::model::gap::FLOOR_CRACK;
use crate::model::ground_patch::GroundPatch;
use crate::model::storey_slice::{FloorPiece, StoreySlice};
use frames::{Map, Point2, TENTHS_PER_M};
use geometry::{FillRule, MultiPolygon, OrientedBox, Ring, close_gaps, difference, union, union_of};
use grid::{Class, GridSpec, Mask, Run, enclosed, fill_holes};
use messages::{FloorKind, NONE, RegionRecord, RobotProfile, Site};
use std::borrow::Cow;
use std::collections::HashMap;

/// Obstacles with gaps up to this width enclose an interior.
const ENCLOSING_GAP_M: f64 = 2.0;

/// Limit of the cached runs of a storey; beyond it the cache is cleared.
pub(crate) const MAX_CACHED_BYTES: usize = 32 << 20;

/// The finished floor of a storey, in cells; not that of the ground outdoors.
#[derive(Debug, Default)]
pub(crate) struct BuiltFloor {
    /// Cells that floor covers whole, without passages through walls. Empty where the floor is assumed from what obstacles
    /// enclose, or missing.
    pub(crate) runs: Vec<Run>,
    /// Cells of ground that is not level with the floor, by patch of the storey.
    pub(crate) patches: Vec<(Run, u32)>,
    /// Floor at other levels.
    pub(crate) regions: Vec<RegionRecord>,
    /// True if rooms without a slab are part of it.
    pub(crate) has_assumed: bool,
}

/// Cache of [`BuiltFloor`] by the set of finished floor elements.
#[derive(Debug, Default)]
pub(crate) struct BuiltFloorCache {
    by_finished: HashMap<Box<[u64]>, BuiltFloor>,
    bytes: usize,
}

/// True if the bit of an index is set.
pub(crate) fn bit_is_set(set: &[u64], index: u32) -> bool {
    set.get(index as usize / 64).is_some_and(|word| word >> (index % 64) & 1 == 1)
}

/// Sets or clears the bit of an index.
pub(crate) fn set_bit(set: &mut Vec<u64>, index: u32, value: bool) {
    let (word, bit) = (index as usize / 64, 1u64 << (index % 64));
    if set.len() <= word {
        set.resize(word + 1, 0);
    }
    if value { set[word] |= bit } else { set[word] &= !bit }
}

impl BuiltFloorCache {
    /// The floor when these floor elements of the storey are finished.
    pub(crate) fn of(
        &mut self,
        site: &Site<'_>,
        robot: &RobotProfile,
        storey: &StoreySlice,
        finished: &[u64],
    ) -> &BuiltFloor {
        if !self.by_finished.contains_key(finished) {
            let floor = built_floor(site, robot, storey, finished);
            let BuiltFloor { runs, patches, regions, .. } = &floor;
            let bytes =
                size_of_val(runs.as_slice()) + size_of_val(patches.as_slice()) + size_of_val(regions.as_slice());
            if self.bytes + bytes > MAX_CACHED_BYTES {
                self.by_finished.clear();
                self.bytes = 0;
            }
            self.bytes += bytes;
            self.by_finished.insert(finished.into(), floor);
        }
        &self.by_finished[finished]
    }
}

fn built_floor(site: &Site<'_>, robot: &RobotProfile, storey: &StoreySlice, finished: &[u64]) -> BuiltFloor {
    let floors = storey.dependents.iter().filter_map(|n| Some((n.element, n.floor_index?)));
    let is_finished: Vec<u32> = floors.filter(|(_, index)| bit_is_set(finished, *index)).map(|(e, _)| e).collect();
    let built = floor_area(&storey.floor, |piece| is_finished.binary_search(&piece.element).is_ok());
    // Where another level lies within the slab this level is no floor.
    let above = floor_area(&storey.floor_above, |piece| is_finished.binary_search(&piece.element).is_ok());
    // Before anything of a storey is built that has slabs, nobody stands on it.
    let is_begun = storey.floor_kind == FloorKind::AssumedFromSpaces || !built.is_empty();
    let has_assumed = is_begun && !storey.assumed_floor.is_empty();
    let is_there = |patch: &GroundPatch| patch.element == NONE || is_finished.binary_search(&patch.element).is_ok();
    let GroundFloor { floor: runs, patches } = match storey.floor_kind {
        FloorKind::AssumedFromEnclosure | FloorKind::Missing | FloorKind::Ground => GroundFloor::default(),
        FloorKind::Built | FloorKind::AssumedFromSpaces => {
            ground_floor(storey, robot, &walked_on(storey, &built, &above, has_assumed), is_there)
        }
    };
    let ground = storey.ground.iter().filter(|patch| is_there(patch)).map(|patch| &patch.area);
    let regions = match storey.floor_kind {
        FloorKind::Ground => Vec::new(),
        _ if patches.is_empty() => at_other_levels(site, robot, storey, &is_finished, &built),
        _ => at_other_levels(site, robot, storey, &is_finished, &union_of(ground.chain([&built]))),
    };
    BuiltFloor { runs, patches, has_assumed, regions }
}

/// Built floor without that of other levels, with what is assumed in rooms without a slab, and without shafts.
fn walked_on<'a>(
    storey: &StoreySlice,
    built: &'a MultiPolygon,
    above: &MultiPolygon,
    has_assumed: bool,
) -> Cow<'a, MultiPolygon> {
    let mut floor = Cow::Borrowed(built);
    if !above.is_empty() {
        floor = Cow::Owned(difference(&floor, above));
    }
    if has_assumed {
        floor = Cow::Owned(union_of([&*floor, &storey.assumed_floor]));
    }
    if !storey.shafts.is_empty() {
        floor = Cow::Owned(difference(&floor, &storey.shafts));
    }
    floor
}

/// The union of floor pieces, with cracks between them closed.
fn floor_area(pieces: &[FloorPiece], wanted: impl Fn(&FloorPiece) -> bool) -> MultiPolygon {
    let rings: Vec<Ring> = pieces.iter().filter(|p| wanted(p)).flat_map(|p| p.rings.iter().cloned()).collect();
    close_gaps(&union(&rings, FillRule::NonZero), FLOOR_CRACK)
}

/// The cells enclosed by standing obstacles without doors, but for places open to below: the floor of a storey that has neither floor
/// faces nor spaces.
pub(crate) fn enclosed_floor(storey: &StoreySlice, stands: impl Fn(u32) -> bool) -> Mask {
    let mut obstacles = Mask::new(storey.spec.width as usize, storey.spec.height as usize);
    let nearby = storey.obstacles.iter().filter(|o| o.class != Class::Door && stands(o.element));
    nearby.for_each(|o| obstacles.set_runs(&o.runs));
    let mut inside = enclosed(&obstacles, (ENCLOSING_GAP_M / storey.spec.resolution_m()).round() as usize);
    inside.clear_runs(&storey.open_to_below);
    inside
}

/// The outline of the complete storey; floor that is not built yet is a drop-off inside it. `complete` are the cells of the floor
/// when everything is finished.
pub(crate) fn outline(storey: &StoreySlice, complete: &[Run]) -> Mask {
    let mut outline = match storey.floor_kind {
        FloorKind::AssumedFromEnclosure => enclosed_floor(storey, |_| true),
        FloorKind::Built | FloorKind::AssumedFromSpaces | FloorKind::Missing | FloorKind::Ground => {
            Mask::new(storey.spec.width as usize, storey.spec.height as usize)
        }
    };
    storey.obstacles.iter().for_each(|o| outline.set_runs(&o.runs));
    outline.set_runs(complete);
    storey.spaces.iter().for_each(|s| outline.set_runs(&s.runs));
    storey.passages.iter().for_each(|p| outline.set_runs(&p.runs));
    fill_holes(&outline)
}

/// Number of sides of a passage with floor: 0 to 2.
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
