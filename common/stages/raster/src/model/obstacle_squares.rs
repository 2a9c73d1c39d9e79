//! Finds the obstacles near a place without looking at all of them.

use grid::{CellRect, GridSpec};

/// Cells along the side of a square.
const SIDE: u32 = 64;

/// The obstacles of a storey by squares of cells.
#[derive(Debug, Default)]
pub(crate) struct ObstacleSquares {
    n_columns: u32,
    /// Indices of the obstacles whose rectangle meets each square, row by row.
    squares: Vec<Vec<u32>>,
}

impl ObstacleSquares {
    /// Of the rectangles around the obstacles, by index.
    pub(crate) fn of(rects: impl Iterator<Item = Option<CellRect>>, spec: &GridSpec) -> Self {
        let [n_columns, n_rows] = [spec.width, spec.height].map(|n| n.div_ceil(SIDE));
        let mut all = Self { n_columns, squares: vec![Vec::new(); (n_columns * n_rows) as usize] };
        for (index, rect) in (0..).zip(rects) {
            for square in rect.into_iter().flat_map(|rect| squares_around(rect, n_columns)) {
                all.squares[square].push(index);
            }
        }
        all
    }

    /// Indices of the obstacles that may meet a rectangle; some come several times.
    pub(crate) fn around(&self, rect: CellRect) -> impl Iterator<Item = u32> {
        squares_around(rect, self.n_columns).flat_map(|square| self.squares[square].iter().copied())
    }
}

fn squares_around(rect: CellRect, n_columns: u32) -> impl Iterator<Item = usize> {
    let squares = move |k: usize| rect.min[k] / SIDE..rect.max[k].div_ceil(SIDE);
    squares(1).flat_map(move |row| squares(0).map(move |column| (row * n_columns + column) as usize))
}
