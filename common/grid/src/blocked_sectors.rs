//! Directions around a point in which all lines end at a distance, so that what lies behind is known to be hidden without a
//! line to each of its points.

use crate::LineOfSight;

/// Number of sectors; their borders lie on a square around the point at equal distances.
const N_SECTORS: usize = 256;

/// Share of a sector at both of its borders in which nothing is said: far more than lines deviate by rounding.
const MARGIN: f64 = 0.02;

/// Most cells that are looked at between the ends of two lines.
const MAX_CELLS: usize = 64;

/// How far lines reach beyond the first opaque cell by rounding, in cells.
const REACH: f64 = 0.01;

/// How far lines from a point run at most, by sector.
pub struct BlockedSectors {
    /// Squared lengths in cells; infinite where it is not known that all lines end.
    squared: Vec<f64>,
}

impl BlockedSectors {
    /// Looks around from a point in the grid, up to a range in cells.
    ///
    /// Two neighbouring lines that end at cells of one rectangle of opaque cells end all lines between them: the rectangle is
    /// convex.
    pub fn around(sight: &LineOfSight, from: [f64; 2], range: f64) -> Self {
        let end = |k: usize| {
            let [x, y] = direction(k);
            let length = (x * x + y * y).sqrt();
            sight.trace(from, [x / length, y / length], range)
        };
        let first = end(0);
        let mut before = first;
        let squared = (1..=N_SECTORS).map(|k| {
            let after = if k == N_SECTORS { first } else { end(k) };
            let ends = [std::mem::replace(&mut before, after), after];
            let [Some(a), Some(b)] = ends.map(|end| end.1) else { return f64::INFINITY };
            let farthest = ends[0].0.max(ends[1].0) + REACH;
            if is_opaque(sight, a, b) { farthest * farthest } else { f64::INFINITY }
        });
        Self { squared: squared.collect() }
    }

    /// True if it is known that the line to a point at this offset, in cells, passes an opaque cell.
    pub fn hides(&self, offset: [f64; 2]) -> bool {
        let at = place(offset);
        let sector = at as usize;
        let share = at - sector as f64;
        let squared = offset[0] * offset[0] + offset[1] * offset[1];
        MARGIN < share && share < 1.0 - MARGIN && self.squared.get(sector).is_some_and(|most| squared > *most)
    }
}

/// Direction of a border between sectors, counter-clockwise from the x axis; of no certain length.
fn direction(border: usize) -> [f64; 2] {
    let per_quarter = N_SECTORS / 4;
    let share = (border % per_quarter) as f64 / per_quarter as f64;
    let (x, y) = (1.0 - share, share);
    match border / per_quarter {
        0 => [x, y],
        1 => [-y, x],
        2 => [-x, -y],
        _ => [y, -x],
    }
}

/// The number of the sector of an offset, and how far it is in it.
fn place([x, y]: [f64; 2]) -> f64 {
    let (across, quarter) = match (x >= 0.0, y >= 0.0) {
        (true, true) => ([x, y], 0.0),
        (false, true) => ([y, -x], 1.0),
        (false, false) => ([-x, -y], 2.0),
        (true, false) => ([-y, x], 3.0),
    };
    let sum = across[0] + across[1];
    if sum > 0.0 { (quarter + across[1] / sum) * (N_SECTORS / 4) as f64 } else { 0.0 }
}

/// True if all cells of the rectangle between two cells are opaque.
fn is_opaque(sight: &LineOfSight, a: [usize; 2], b: [usize; 2]) -> bool {
    let [columns, rows] = [0, 1].map(|k| a[k].min(b[k])..=a[k].max(b[k]));
    let n_cells = columns.clone().count() * rows.clone().count();
    n_cells <= MAX_CELLS
        && rows.into_iter().all(|row| columns.clone().all(|at| !sight.passes(row * sight.width() + at)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn what_stands_behind_a_wall_is_hidden_and_what_stands_before_it_or_beside_is_not() {
        let width = 40;
        let opaque: Vec<bool> = (0..40 * width).map(|cell| cell % width == 30 && cell / width < 35).collect();
        let sight = LineOfSight::new(&opaque, width);
        let sectors = BlockedSectors::around(&sight, [10.5, 10.5], 60.0);
        let hidden = (0..30).filter(|k| sectors.hides([24.0, f64::from(*k) * 0.31 - 4.0])).count();
        assert!(hidden > 20, "{hidden} of 30 are known to be hidden");
        assert!((0..30).all(|k| !sectors.hides([18.0, f64::from(k) * 0.31 - 4.0])));
        assert!(!sectors.hides([24.0, 40.0]) && !sectors.hides([0.0, 0.0]));
    }

    proptest! {
        #[test]
        fn no_line_to_what_is_hidden_is_clear(
            width in 8usize..40,
            opaque in prop::collection::vec(prop::bool::weighted(0.2), 64..1_600),
            walls in prop::collection::vec((0usize..40, 0usize..40, 1usize..30, prop::bool::ANY), 0..4),
            from in prop::array::uniform2(0.01f64..0.99),
            to in prop::collection::vec(prop::array::uniform2(0.01f64..0.99), 200),
        ) {
            let height = opaque.len() / width;
            let mut opaque = opaque[..height * width].to_vec();
            for (column, row, length, is_upright) in walls {
                for k in 0..length {
                    let (column, row) = if is_upright { (column, row + k) } else { (column + k, row) };
                    if column < width && row < height {
                        opaque[row * width + column] = true;
                    }
                }
            }
            let size = [width as f64, height as f64];
            let from = [from[0] * size[0], from[1] * size[1]];
            let sight = LineOfSight::new(&opaque, width);
            let sectors = BlockedSectors::around(&sight, from, 100.0);
            for to in to {
                let to = [to[0] * size[0], to[1] * size[1]];
                if sectors.hides([to[0] - from[0], to[1] - from[1]]) {
                    prop_assert!(!sight.is_clear(from, to), "from {from:?} to {to:?}");
                }
            }
        }
    }
}
