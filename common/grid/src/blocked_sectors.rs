//! Directions around a point in which all lines end at a distance, so that what lies behind is known to be hidden without a
//! line to each of its points.

use crate::LineOfSight;
use crate::line_of_sight::LineEnd;

/// Sectors for each cell of range: at its end they are some four cells wide.
const SECTORS_PER_CELL: f64 = 0.4;

/// Fewest and most sectors of a quarter turn.
const PER_QUARTER: [f64; 2] = [16.0, 256.0];

/// Share of a sector at both of its borders in which the next one counts, too: far more than lines deviate by rounding.
const MARGIN: f64 = 0.02;

/// Most cells between the ends of two lines in which a row of opaque cells is looked for.
const MAX_CELLS: usize = 64;

/// How far lines may reach into opaque cells by rounding, in cells.
const REACH: f64 = 0.01;

/// How far lines from a point run at most, by sector.
///
/// The borders of sectors lie on a square around the point at equal distances. Where the lines along both borders of a sector
/// end at cells that opaque cells join, side by side, no line between them passes: it would have to cross that row.
pub struct BlockedSectors {
    /// Squared lengths in cells; infinite where it is not known that all lines end.
    squared: Vec<f64>,
}

impl BlockedSectors {
    /// Looks around from a point in the grid, up to a range in cells.
    pub fn around(sight: &LineOfSight, from: [f64; 2], range: f64) -> Self {
        let per_quarter = (range * SECTORS_PER_CELL / 4.0).ceil().clamp(PER_QUARTER[0], PER_QUARTER[1]) as usize;
        let n_sectors = 4 * per_quarter;
        // Four lines at once, one of each quarter.
        let mut ends = vec![None; n_sectors];
        for border in 0..per_quarter {
            let lines = [0, 1, 2, 3].map(|quarter| {
                let [x, y] = direction(border + quarter * per_quarter, per_quarter);
                let length = (x * x + y * y).sqrt();
                ([x / length, y / length], range)
            });
            for (quarter, end) in sight.cast(from, lines).into_iter().enumerate() {
                ends[border + quarter * per_quarter] = match end {
                    LineEnd::Opaque { cell, .. } => Some(cell),
                    LineEnd::Limit | LineEnd::Border { .. } => None,
                };
            }
        }
        let farthest = |sector: usize| {
            let (a, b) = (ends[sector]?, ends[(sector + 1) % n_sectors]?);
            are_joined(sight, a, b).then(|| farthest_squared(from, a, b))
        };
        Self { squared: (0..n_sectors).map(|sector| farthest(sector).unwrap_or(f64::INFINITY)).collect() }
    }

    /// True if it is known that the line to a point at this offset, in cells, passes an opaque cell.
    pub fn hides(&self, offset: [f64; 2]) -> bool {
        let squared = offset[0] * offset[0] + offset[1] * offset[1];
        let at = self.place(offset);
        let sector = at as usize;
        let share = at - sector as f64;
        let next = if share < MARGIN {
            sector + self.squared.len() - 1
        } else if share > 1.0 - MARGIN {
            sector + 1
        } else {
            sector
        };
        [sector, next].iter().all(|sector| self.squared[sector % self.squared.len()] < squared)
    }

    /// True if it is known that the lines to all points between two offsets, in cells, pass an opaque cell.
    pub fn hides_all(&self, [low, high]: [[f64; 2]; 2]) -> bool {
        let nearest = [0, 1].map(|k| 0f64.clamp(low[k], high[k]));
        let squared = nearest[0] * nearest[0] + nearest[1] * nearest[1];
        if squared == 0.0 {
            return false;
        }
        // From outside of it, a rectangle covers less than half a turn.
        let n = self.squared.len() as f64;
        let middle = self.place([0, 1].map(|k| (low[k] + high[k]) / 2.0));
        let (mut first, mut last) = (0.0f64, 0.0f64);
        for corner in [[low[0], low[1]], [low[0], high[1]], [high[0], low[1]], [high[0], high[1]]] {
            let turn = self.place(corner) - middle;
            let turn = if turn > n / 2.0 {
                turn - n
            } else if turn < -n / 2.0 {
                turn + n
            } else {
                turn
            };
            (first, last) = (first.min(turn), last.max(turn));
        }
        let [first, last] = [middle + first - MARGIN, middle + last + MARGIN].map(|at| (at + n).floor() as usize);
        (first..=last).all(|sector| self.squared[sector % self.squared.len()] < squared)
    }

    /// The number of the sector of an offset, and how far it is in it.
    fn place(&self, [x, y]: [f64; 2]) -> f64 {
        let (along, across, quarter) = match (x >= 0.0, y >= 0.0) {
            (true, true) => (x, y, 0.0),
            (false, true) => (y, -x, 1.0),
            (false, false) => (-x, -y, 2.0),
            (true, false) => (-y, x, 3.0),
        };
        let sum = along + across;
        if sum > 0.0 { (quarter + across / sum) * (self.squared.len() / 4) as f64 } else { 0.0 }
    }
}

/// Direction of a border between sectors, counter-clockwise from the x axis; of no certain length.
fn direction(border: usize, per_quarter: usize) -> [f64; 2] {
    let share = (border % per_quarter) as f64 / per_quarter as f64;
    let (x, y) = (1.0 - share, share);
    match border / per_quarter {
        0 => [x, y],
        1 => [-y, x],
        2 => [-x, -y],
        _ => [y, -x],
    }
}

/// True if opaque cells lead from one cell to the other, side by side and always towards it.
fn are_joined(sight: &LineOfSight, a: [usize; 2], b: [usize; 2]) -> bool {
    let [width, height] = [0, 1].map(|k| a[k].abs_diff(b[k]) + 1);
    if width * height > MAX_CELLS {
        return false;
    }
    let towards = |k: usize, by: usize| if a[k] < b[k] { a[k] + by } else { a[k] - by };
    let mut reached = [false; MAX_CELLS];
    reached[0] = true;
    for row in 0..height {
        for column in 0..width {
            let leads = reached[column] || column > 0 && reached[column - 1];
            reached[column] = leads && !sight.passes(towards(1, row) * sight.width() + towards(0, column));
        }
    }
    reached[width - 1]
}

/// Squared distance from a point to the farthest corner of the cells between two.
fn farthest_squared(from: [f64; 2], a: [usize; 2], b: [usize; 2]) -> f64 {
    let far = |k: usize| {
        let (low, high) = (a[k].min(b[k]) as f64, (a[k].max(b[k]) + 1) as f64);
        (from[k] - low).abs().max((from[k] - high).abs()) + REACH
    };
    far(0) * far(0) + far(1) * far(1)
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
                let offset = [to[0] - from[0], to[1] - from[1]];
                let all = [offset.map(|c| c - 0.4), offset.map(|c| c + 0.6)];
                if sectors.hides(offset) || sectors.hides_all(all) {
                    prop_assert!(!sight.is_clear(from, to), "from {from:?} to {to:?}");
                }
            }
        }
    }
}
