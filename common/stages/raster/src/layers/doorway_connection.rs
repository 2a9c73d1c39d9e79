//! Connection of the two sides of a doorway over the cells of its own outline.

use crate::model::cell_area::reach_beside;
use frames::{Map, Point2, TENTHS_PER_M};
use geometry::OrientedBox;
use grid::GridSpec;
use messages::RobotProfile;

/// The cells at the far end of a side are those within this many cells of it: more than the diagonal of one.
const END_CELLS: f64 = 1.5;

/// Cells around an outline that were seen, and those that wait; a reused buffer.
#[derive(Debug, Default)]
pub(crate) struct SeenCells {
    is_seen: Vec<bool>,
    open: Vec<usize>,
}

/// The outline in which a door is passed: its way, and on both sides as much as a robot needs to leave it.
///
/// What stands across the whole outline within the robot's diameter of the way cannot be passed on any side.
pub(crate) fn outline_of_passage(way: &OrientedBox, robot: &RobotProfile, spec: &GridSpec) -> OrientedBox {
    let diameter = 2.0 * robot.radius_m * f64::from(TENTHS_PER_M);
    let reach = reach_beside(spec).min(diameter.max(2.0 * f64::from(spec.cell_tenths)));
    OrientedBox { half: [way.half[0], way.half[1] + reach], ..*way }
}

/// True if cells without an obstacle join both ends of `outline`, and floor beside the way on `n_sides` of its sides.
///
/// Cells outside the grid hold no obstacle; a cell belongs to the outline if its middle does.
pub(crate) fn joins_sides(
    [way, outline]: [&OrientedBox; 2],
    n_sides: u32,
    spec: &GridSpec,
    (is_open, has_floor): (impl Fn(usize) -> bool, impl Fn(usize) -> bool),
    buffer: &mut SeenCells,
) -> bool {
    let SeenCells { is_seen, open } = buffer;
    let cells = CellsOfOutline::new(outline, spec);
    let end = outline.half[1] - END_CELLS * cells.cell;
    is_seen.clear();
    is_seen.resize(cells.width * cells.height, false);
    for start in 0..is_seen.len() {
        if is_seen[start] {
            continue;
        }
        let (mut ends, mut floors) = ([false; 2], [false; 2]);
        open.clear();
        open.push(start);
        while let Some(at) = open.pop() {
            if std::mem::replace(&mut is_seen[at], true) {
                continue;
            }
            let Some((v, index)) = cells.cell_within(at, outline, spec) else { continue };
            if index.is_some_and(|i| !is_open(i)) {
                continue;
            }
            let side = usize::from(v > 0.0);
            ends[side] |= v.abs() >= end;
            floors[side] |= v.abs() > way.half[1] && index.is_some_and(&has_floor);
            open.extend(cells.neighbours(at));
        }
        if ends == [true; 2] && floors.map(u32::from).iter().sum::<u32>() >= n_sides {
            return true;
        }
    }
    false
}

/// The cells around an outline, some of them outside the grid.
struct CellsOfOutline {
    /// Side of a cell in tenths of a millimetre.
    cell: f64,
    first: [f64; 2],
    width: usize,
    height: usize,
}

impl CellsOfOutline {
    fn new(outline: &OrientedBox, spec: &GridSpec) -> Self {
        let cell = f64::from(spec.cell_tenths);
        let across = outline.across();
        let reach = [0, 1].map(|k| outline.half[0] * outline.axis[k].abs() + outline.half[1] * across[k].abs());
        let first = [0, 1].map(|k| ((outline.centre[k] - reach[k]) / cell).floor());
        let n = [0, 1].map(|k| (((outline.centre[k] + reach[k]) / cell).floor() - first[k]) as usize + 1);
        Self { cell, first, width: n[0], height: n[1] }
    }

    /// Distance of a cell's middle from the middle of the outline across the wall, and its index in the grid; `None`
    /// outside the outline.
    fn cell_within(&self, at: usize, outline: &OrientedBox, spec: &GridSpec) -> Option<(f64, Option<usize>)> {
        let place = [at % self.width, at / self.width];
        let p = [0, 1].map(|k| (self.first[k] + place[k] as f64 + 0.5) * self.cell);
        let (off, across) = ([0, 1].map(|k| p[k] - outline.centre[k]), outline.across());
        let [u, v] = [outline.axis, across].map(|axis| off[0] * axis[0] + off[1] * axis[1]);
        let [x, y] = p.map(|c| c / f64::from(TENTHS_PER_M));
        let is_within = u.abs() <= outline.half[0] && v.abs() <= outline.half[1];
        is_within.then(|| (v, spec.cell_at(Point2::<Map>::new(x, y)).map(|cell| spec.index(cell))))
    }

    fn neighbours(&self, at: usize) -> impl Iterator<Item = usize> {
        let (column, row, width) = (at % self.width, at / self.width, self.width);
        let beside = [
            (column > 0).then(|| at - 1),
            (column + 1 < width).then_some(at + 1),
            (row > 0).then(|| at - width),
            (row + 1 < self.height).then_some(at + width),
        ];
        beside.into_iter().flatten()
    }
}
