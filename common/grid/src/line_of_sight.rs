//! Lines of sight on a grid.

use crate::{SparseLayer, sparse_distances};
use std::sync::LazyLock;

/// Casts lines over transparent cells.
///
/// Points are in cells from the lower left corner of the grid: the middle of the first cell is (0.5, 0.5).
#[derive(Debug, Clone)]
pub struct LineOfSight {
    width: usize,
    /// 0 for opaque cells; else 1 plus the number of whole cells that a line may pass from anywhere in the cell, in any
    /// direction.
    leap: Vec<u8>,
}

/// Diagonal of a cell: half to the middle of the cell of a line, half from the middle of the opaque cell.
const DIAGONAL: f64 = std::f64::consts::SQRT_2;

/// Bits of the fraction of a coordinate, and one cell in these units.
const ONE_BITS: u32 = 20;
const ONE: i64 = 1 << ONE_BITS;

/// Bits of the fraction of a direction: the error over a thousand cells is less than a thousandth of a cell.
const DIRECTION_BITS: u32 = 24;

/// Bits of the fraction of a coordinate where it is a multiple of a step: a thousand steps add up to less than a millionth of a cell.
const FINE_BITS: u32 = 32;
const FINE_ONE: f64 = (1u64 << FINE_BITS) as f64;

/// Longer than any line; products with the side of a cell do not overflow.
const MAX_BETWEEN: i64 = 1 << 40;

/// Lines around a point that are cast at once: see [`LineOfSight::are_clear`].
const LINES_AT_ONCE: usize = 4;

/// Step over the border that a line has reached.
const BORDER_CROSSING: i64 = 2;

/// Most cells of a leap.
const MAX_LEAP: u8 = 250;

/// [`LineOfSight::leap`] by the squared distance to the nearest opaque cell; beyond the table it is that of [`MAX_LEAP`].
static LEAPS: LazyLock<Vec<u8>> = LazyLock::new(|| {
    let farthest = u32::from(MAX_LEAP) + 3;
    let leap = |d2: u32| 1 + (f64::from(d2).sqrt() - DIAGONAL).floor().clamp(0.0, f64::from(MAX_LEAP)) as u8;
    std::iter::once(0).chain((1..=farthest * farthest).map(leap)).collect()
});

/// Where a line ends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum LineEnd {
    /// At its limit.
    Limit,
    /// At an opaque cell, given by column and row.
    Opaque { gone: f64, cell: [usize; 2] },
    /// At the border of the grid.
    Border { gone: f64 },
}

impl LineEnd {
    /// Length of the line, which ends at a limit.
    fn length(self, limit: f64) -> f64 {
        match self {
            Self::Limit => limit,
            Self::Opaque { gone, .. } | Self::Border { gone } => gone,
        }
    }
}

/// A line on its way, in fixed-point numbers.
struct Line {
    /// Its direction.
    step: [i64; 2],
    /// Its length between two borders of columns, and of rows; a line along a column never crosses one of columns.
    between: [i64; 2],
    limit: i64,
    gone: i64,
    end: LineEnd,
}

impl LineOfSight {
    /// From opaque cells, row-major, `width` wide. Outside of the grid is opaque.
    pub fn new(opaque: &[bool], width: usize) -> Self {
        Self::from_distances(&sparse_distances(opaque, width), width)
    }

    /// From the squared distance of every cell to the nearest opaque one, as of [`sparse_distances`].
    pub fn from_distances(squared: &SparseLayer<u32>, width: usize) -> Self {
        let n_cells = squared.cells().n_cells();
        let height = n_cells.checked_div(width).unwrap_or(0);
        let mut leap = vec![0; n_cells];
        let leaps: &[u8] = &LEAPS;
        // The border of the grid stops a line, too.
        let left = |at: usize, n: usize| 1 + at.min(n - 1 - at).min(usize::from(MAX_LEAP)) as u8;
        let left_of_columns: Vec<u8> = (0..width).map(|column| left(column, width)).collect();
        for (row, out) in leap.chunks_exact_mut(width.max(1)).enumerate() {
            squared.read(row * width, out, |squared| leaps.get(squared as usize).copied().unwrap_or(1 + MAX_LEAP));
            let left_of_row = left(row, height);
            out.iter_mut().zip(&left_of_columns).for_each(|(leap, left)| *leap = (*leap).min(*left).min(left_of_row));
        }
        Self { width, leap }
    }

    /// Columns.
    pub fn width(&self) -> usize {
        self.width
    }

    /// True if the cell is transparent.
    pub fn passes(&self, cell: usize) -> bool {
        self.leap[cell] != 0
    }

    /// True if all cells at less than this distance in cells are transparent.
    pub fn is_wide(&self, cell: usize, cells: u8) -> bool {
        self.leap[cell] > cells
    }

    /// True if all cells on the line between two points in the grid are transparent.
    pub fn is_clear(&self, from: [f64; 2], to: [f64; 2]) -> bool {
        self.are_clear(from, [to])[0]
    }

    /// The same for several points, at once: a line waits for memory and for its own steps, lines beside each other do not.
    pub fn are_clear<const N: usize>(&self, from: [f64; 2], to: [[f64; 2]; N]) -> [bool; N] {
        let lines = to.map(|to| {
            let d = [to[0] - from[0], to[1] - from[1]];
            let length = (d[0] * d[0] + d[1] * d[1]).sqrt();
            (if length == 0.0 { d } else { d.map(|d| d / length) }, length)
        });
        let ends = self.cast(from, lines);
        std::array::from_fn(|k| match ends[k] {
            LineEnd::Limit if lines[k].1 == 0.0 => self.cell_at(from).is_some_and(|cell| self.passes(cell)),
            LineEnd::Limit => true,
            LineEnd::Opaque { .. } | LineEnd::Border { .. } => false,
        })
    }

    /// Length of a line from a point in the grid to the first opaque cell, at most `limit`.
    pub fn run(&self, from: [f64; 2], direction: [f64; 2], limit: f64) -> f64 {
        let [end] = self.cast(from, [(direction, limit)]);
        end.length(limit)
    }

    /// Casts lines from a point in the grid, each with its direction and the length at which it ends.
    pub(crate) fn cast<const N: usize>(&self, from: [f64; 2], lines: [([f64; 2], f64); N]) -> [LineEnd; N] {
        // Fixed-point numbers: no step of the loop rounds or converts.
        let start = from.map(|c| (c * ONE as f64) as i64);
        let (width, height) = (self.width as i64, self.leap.len().checked_div(self.width).unwrap_or(0) as i64);
        let mut lines = lines.map(|(direction, limit)| Line {
            step: direction.map(|d| (d * f64::from(1 << DIRECTION_BITS)) as i64),
            between: direction.map(|d| (ONE as f64 / d.abs()).min(MAX_BETWEEN as f64) as i64),
            limit: (limit * ONE as f64) as i64,
            gone: 0,
            end: LineEnd::Limit,
        });
        let mut goes_on = true;
        while goes_on {
            goes_on = false;
            for line in &mut lines {
                goes_on |= self.step(line, start, [width, height]);
            }
        }
        lines.map(|line| line.end)
    }

    /// Moves a line on to the next border of a cell, or as far as nothing is near; false if it has ended.
    #[inline(always)]
    fn step(&self, line: &mut Line, start: [i64; 2], [width, height]: [i64; 2]) -> bool {
        let x = start[0] + ((line.step[0] * line.gone) >> DIRECTION_BITS);
        let y = start[1] + ((line.step[1] * line.gone) >> DIRECTION_BITS);
        let (column, row) = (x >> ONE_BITS, y >> ONE_BITS);
        if line.gone >= line.limit {
            return false;
        }
        let gone = line.gone as f64 / ONE as f64;
        if !(0 <= column && column < width && 0 <= row && row < height) {
            line.end = LineEnd::Border { gone };
            return false;
        }
        let leap = self.leap[(row * width + column) as usize];
        if leap == 0 {
            line.end = LineEnd::Opaque { gone, cell: [column as usize, row as usize] };
            return false;
        }
        let ahead = |at: i64, step: i64, between: i64| {
            let inside = at & (ONE - 1);
            ((if step < 0 { inside } else { ONE - inside }) * between) >> ONE_BITS
        };
        let [x, y] = [ahead(x, line.step[0], line.between[0]), ahead(y, line.step[1], line.between[1])];
        // No branch: it would often be guessed wrong.
        line.gone += (x.min(y) + BORDER_CROSSING).max(i64::from(leap - 1) << ONE_BITS);
        true
    }

    /// Calls `see` with every cell visible from a point within `range`, some more than once, in all directions or in the
    /// half-open sector of `field_of_view_rad` around `heading_rad`. Lines are a cell apart.
    pub fn look_around(
        &self,
        from: [f64; 2],
        range: f64,
        heading_rad: f64,
        field_of_view_rad: f64,
        mut see: impl FnMut(usize),
    ) {
        let n = (range * field_of_view_rad).ceil().max(8.0) as u32;
        let start = from.map(|c| (c * FINE_ONE) as i64);
        let (width, height) = (self.width as i64, self.leap.len().checked_div(self.width).unwrap_or(0) as i64);
        let is_inside =
            |[x, y]: [i64; 2]| (0..width << FINE_BITS).contains(&x) && (0..height << FINE_BITS).contains(&y);
        let direction = |k: u32| {
            let angle = heading_rad + field_of_view_rad * ((f64::from(k) + 0.5) / f64::from(n) - 0.5);
            let (sin, cos) = libm::sincos(angle);
            [cos, sin]
        };
        let lines = (0..n).step_by(LINES_AT_ONCE).flat_map(|first| {
            let numbers: [u32; LINES_AT_ONCE] = std::array::from_fn(|k| first + k as u32);
            let directions = numbers.map(direction);
            let lengths = self.cast(from, directions.map(|direction| (direction, range))).map(|end| end.length(range));
            std::iter::zip(numbers, std::iter::zip(directions, lengths))
        });
        for (k, ([cos, sin], length)) in lines.take(n as usize) {
            // Nearer to the middle every second line is enough, then every fourth ..
            let far = (range / f64::from(1u32 << k.trailing_zeros().min(16))) as i64;
            let first = if k == 0 { 0 } else { far };
            let step = [cos, sin].map(|d| (d / 2.0 * FINE_ONE) as i64);
            let place = |n_steps: i64| [0, 1].map(|k| start[k] + n_steps * step[k]);
            // A line that ends on a border ends before an opaque cell or at the border of the grid. All before its end is inside.
            let Some(last) = (first..=(length * 2.0) as i64).rev().find(|n_steps| is_inside(place(*n_steps))) else {
                continue;
            };
            let mut at = place(first);
            for _ in first..=last {
                let [column, row] = at.map(|c| (c >> FINE_BITS) as usize);
                let cell = row * self.width + column;
                if self.leap[cell] != 0 {
                    see(cell);
                }
                at = [at[0] + step[0], at[1] + step[1]];
            }
        }
    }

    /// The cell of a point; `None` outside of the grid.
    #[inline]
    pub fn cell_at(&self, at: [f64; 2]) -> Option<usize> {
        let is_inside = at[0] >= 0.0 && at[0] < self.width as f64 && at[1] >= 0.0;
        is_inside.then(|| at[1] as usize * self.width + at[0] as usize).filter(|&cell| cell < self.leap.len())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// From text, `#` stops lines; first line is the top row.
    fn sight(text: &str) -> LineOfSight {
        let rows: Vec<&str> = text.split_whitespace().collect();
        let opaque: Vec<bool> = rows.iter().rev().flat_map(|r| r.bytes().map(|b| b == b'#')).collect();
        LineOfSight::new(&opaque, rows[0].len())
    }

    #[test]
    fn a_wall_hides_what_is_behind_it_and_a_gap_does_not() {
        let sight = sight("....... ###.### .......");
        assert!(sight.is_clear([0.5, 0.5], [6.5, 0.5]));
        assert!(!sight.is_clear([0.5, 0.5], [0.5, 2.5]));
        assert!(sight.is_clear([3.5, 0.5], [3.5, 2.5]));
        assert!(sight.is_clear([3.1, 0.2], [3.9, 2.8]));
        assert!(!sight.is_clear([2.0, 0.2], [5.0, 2.8]));
    }

    #[test]
    fn a_line_ends_at_the_border_of_the_cell_that_stops_it() {
        let sight = sight(".....# .....# .....#");
        let run = sight.run([0.5, 1.5], [1.0, 0.0], 20.0);
        assert!((run - 4.5).abs() < 1e-5, "{run}");
        assert_eq!(sight.run([0.5, 1.5], [1.0, 0.0], 3.0), 3.0);
        assert!((sight.run([0.5, 1.5], [0.0, -1.0], 20.0) - 1.5).abs() < 1e-5, "the grid ends there");
    }

    /// By asking for every cell whether the line runs through more than a corner of it.
    fn slowly(opaque: &[bool], width: usize, from: [f64; 2], to: [f64; 2]) -> bool {
        let cells =
            opaque.iter().enumerate().filter(|(_, o)| **o).map(|(k, _)| [(k % width) as f64, (k / width) as f64]);
        for cell in cells {
            let (mut lo, mut hi) = (0.0f64, 1.0f64);
            for k in 0..2 {
                let d = to[k] - from[k];
                let (a, b) = ((cell[k] - from[k]) / d, (cell[k] + 1.0 - from[k]) / d);
                (lo, hi) = (lo.max(a.min(b)), hi.min(a.max(b)));
            }
            if lo + 1e-5 < hi {
                return false;
            }
        }
        true
    }

    #[test]
    fn what_stops_a_line_is_not_what_it_passes() {
        let text = "########## #........# #........# #........# #........# #........# #........# ##########";
        let sight = sight(text);
        for k in 0..400 {
            let from = [1.25 + 0.5 * f64::from(k % 16), 1.25 + 0.25 * f64::from(k / 16 % 22)];
            sight.look_around(from, 20.0, 0.0, std::f64::consts::TAU, |cell| {
                assert!(sight.passes(cell), "cell {cell} from {from:?}");
            });
        }
    }

    #[test]
    fn a_line_that_ends_at_the_border_of_the_grid_sees_no_cell_beyond_it() {
        let (width, height) = (30usize, 20usize);
        let sight = LineOfSight::new(&vec![false; width * height], width);
        for k in 0..width * height {
            let from = [(k % width) as f64 + 0.5, (k / width) as f64 + 0.25];
            sight.look_around(from, 9.0, 0.0, std::f64::consts::TAU, |cell| {
                let d = [(cell % width) as f64 + 0.5 - from[0], (cell / width) as f64 + 0.5 - from[1]];
                assert!(d[0].hypot(d[1]) < 9.0 + DIAGONAL, "cell {cell} is seen from {from:?}");
            });
        }
    }

    proptest! {
        #[test]
        fn lines_agree_with_looking_at_every_cell(
            width in 2usize..12,
            opaque in prop::collection::vec(prop::bool::weighted(0.15), 24..140),
            ends in prop::array::uniform4(0.01f64..0.99),
        ) {
            let opaque = &opaque[..opaque.len() / width * width];
            let size = [width as f64, (opaque.len() / width) as f64];
            let (from, to) = ([ends[0] * size[0], ends[1] * size[1]], [ends[2] * size[0], ends[3] * size[1]]);
            prop_assume!((from[0] - to[0]).abs() > 1e-3 && (from[1] - to[1]).abs() > 1e-3);
            let sight = LineOfSight::new(opaque, width);
            // Lines that pass a corner within rounding may go either way.
            let near_corner = (0..=width).any(|x| (0..=size[1] as usize).any(|y| {
                let d = [to[0] - from[0], to[1] - from[1]];
                let off = (x as f64 - from[0]) * d[1] - (y as f64 - from[1]) * d[0];
                off.abs() < 1e-4 * (d[0].abs() + d[1].abs())
            }));
            // So may those that end at a border within rounding.
            let at_border = from.into_iter().chain(to).any(|c| (c - c.round()).abs() < 1e-4);
            prop_assume!(!near_corner && !at_border);
            prop_assert_eq!(sight.is_clear(from, to), slowly(opaque, width, from, to));
            let several = [to, [to[0], from[1]], from, [size[0] - 0.3, size[1] - 0.3]];
            prop_assert_eq!(sight.are_clear(from, several), several.map(|to| sight.is_clear(from, to)));
        }
    }
}
