//! Rectangles of cells around points and passages, and lengths of the robot profile in tenths of a millimetre.

use geometry::OrientedBox;
use grid::{CellRect, GridSpec};
use messages::RobotProfile;

/// Distance from a passage within which floor is searched.
pub(crate) const BESIDE_PASSAGE_M: f64 = 0.3;

/// Bottom and top of the slab above the floor, in tenths of a millimetre.
pub(crate) fn slab_above_floor(robot: &RobotProfile) -> [i32; 2] {
    robot.slab_m().map(to_tenths)
}

/// Metres to tenths of a millimetre; a length beyond the range of the unit gives a large value.
pub(crate) fn to_tenths(metres: f64) -> i32 {
    frames::tenths(metres).unwrap_or(i32::MAX / 4)
}

/// The rectangle of cells around points in tenths of a millimetre, grown by `reach`; `None` outside the grid.
pub(crate) fn cells_around(points: impl Iterator<Item = [f64; 2]>, reach: f64, spec: &GridSpec) -> Option<CellRect> {
    let (mut min, mut max) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    for point in points {
        for k in 0..2 {
            (min[k], max[k]) = (min[k].min(point[k] - reach), max[k].max(point[k] + reach));
        }
    }
    // One more cell on each side: a face on the border of two cells touches both.
    let cell = |k: usize, c: f64| (c / f64::from(spec.cell_tenths)).floor() - f64::from(spec.first_cell[k]);
    let size = [spec.width, spec.height].map(f64::from);
    let low = [0, 1].map(|k| (cell(k, min[k]) - 1.0).clamp(0.0, size[k]) as u32);
    let high = [0, 1].map(|k| (cell(k, max[k]) + 2.0).clamp(0.0, size[k]) as u32);
    (low[0] < high[0] && low[1] < high[1]).then_some(CellRect { min: low, max: high })
}

/// Distance from a passage within which floor is searched, in tenths of a millimetre, at least two cells.
pub(crate) fn reach_beside(spec: &GridSpec) -> f64 {
    f64::from(to_tenths(BESIDE_PASSAGE_M).max(2 * spec.cell_tenths))
}

/// The cells of a passage and those beside it in which floor is searched.
pub(crate) fn cells_beside(plan: &OrientedBox, spec: &GridSpec) -> Option<CellRect> {
    let corners = [[-1.0, -1.0], [-1.0, 1.0], [1.0, -1.0], [1.0, 1.0]];
    cells_around(
        corners.into_iter().map(|[u, v]| plan.at(u * plan.half[0], v * plan.half[1])),
        reach_beside(spec),
        spec,
    )
}
