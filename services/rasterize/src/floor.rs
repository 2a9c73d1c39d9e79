//! Which cells have floor under them.

use crate::cut::{FloorPiece, Passage, StoreyCut, to_tenths};
use frames::{Map, Point2, TENTHS_PER_M};
use geometry::{FillRule, MultiPolygon, Ring, close_gaps, difference, union, union_of};
use grid::{GridSpec, Mask, covered_cells, enclosed};
use messages::{ElementState, FloorKind, Phase, Site};

/// Cracks between floor faces narrower than this, in tenths of a millimetre, are no drop-offs.
const CRACK: i32 = 20;

/// Obstacles with gaps up to this width enclose an interior.
const ENCLOSING_GAP_M: f64 = 2.0;

/// How far from a passage floor is looked for.
const BESIDE_PASSAGE_M: f64 = 0.3;

/// The cells that floor covers whole, passages through walls not yet counted.
pub(crate) fn floor_cells(site: &Site<'_>, phase: &Phase<'_>, storey: &StoreyCut, obstacles: &Mask) -> Mask {
    let spec = &storey.spec;
    let (width, height) = (spec.width as usize, spec.height as usize);
    let mut mask = Mask::new(width, height);
    match FloorKind::from_id(site.map_storeys[storey.map_storey as usize].floor) {
        Some(FloorKind::AssumedFromSpaces) => {
            let spaces = union_of(storey.spaces.iter().map(|s| &s.polygon));
            mask.set_runs(&covered_cells(&close_gaps(&difference(&spaces, &storey.from_below), CRACK), spec));
        }
        Some(FloorKind::AssumedFromEnclosure) => {
            let gap_cells = (ENCLOSING_GAP_M / spec.resolution_m()).round() as usize;
            mask.set_all(&enclosed(obstacles, gap_cells));
        }
        Some(FloorKind::Built) | None => mask.set_runs(&covered_cells(&built_floor(phase, storey), spec)),
    }
    mask
}

/// The plan of all finished floor within a step of the storey's floor.
pub(crate) fn built_floor(phase: &Phase<'_>, storey: &StoreyCut) -> MultiPolygon {
    plan_of(&storey.floor, |piece| phase.effective(piece.element as usize) == ElementState::Built)
}

/// The plan of some pieces of floor, cracks between them closed.
pub(crate) fn plan_of(pieces: &[FloorPiece], wanted: impl Fn(&FloorPiece) -> bool) -> MultiPolygon {
    let rings: Vec<Ring> = pieces.iter().filter(|p| wanted(p)).flat_map(|p| p.rings.iter().cloned()).collect();
    close_gaps(&union(&rings, FillRule::NonZero), CRACK)
}

/// On how many sides of a passage there is floor.
pub(crate) fn sides_with_floor(plan: &geometry::OrientedBox, spec: &GridSpec, floor: impl Fn(usize) -> bool) -> u32 {
    let is_floor = |at: [f64; 2]| {
        let [x, y] = at.map(|c| c / f64::from(TENTHS_PER_M));
        spec.cell_at(Point2::<Map>::new(x, y)).is_some_and(|cell| floor(spec.index(cell)))
    };
    let steps = (BESIDE_PASSAGE_M / spec.resolution_m()).ceil().max(2.0) as i32;
    let reach = f64::from(to_tenths(BESIDE_PASSAGE_M).max(2 * spec.cell_tenths));
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

/// The passages of walls that stand, with floor on both sides: they are floor, too.
pub(crate) fn floor_in_passages<'a>(
    phase: &Phase<'_>,
    storey: &'a StoreyCut,
    floor: &Mask,
) -> impl Iterator<Item = &'a Passage> {
    storey.passages.iter().filter(move |p| {
        phase.effective(p.host as usize).is_obstacle()
            && sides_with_floor(&p.plan, &storey.spec, |i| floor.cells[i]) == 2
    })
}
