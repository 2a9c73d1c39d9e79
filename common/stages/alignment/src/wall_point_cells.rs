//! The wall point of each cell of a map.

use grid::nearest_marked;
use occupancy::CELL_M;
use std::ops::Range;

/// No wall point.
pub(crate) const NONE: u32 = u32::MAX;

/// Cells around a map, 2 m: a refinement looks for wall points within 1.8 m.
const LEAST_MARGIN: usize = 40;

/// The wall point of each cell, row-major, with a margin around the map, so that steps from a cell lead to a cell.
pub(crate) struct WallPointCells {
    wall_points: Vec<u32>,
    /// The place of the cell of each wall point.
    places: Vec<u32>,
    /// Cells in a row and rows, with the margin on both sides.
    size: [usize; 2],
    margin: usize,
}

impl WallPointCells {
    /// Without wall points; steps are at most `reach` cells long.
    pub(crate) fn new(width: usize, height: usize, reach: usize) -> Self {
        let margin = reach.max(LEAST_MARGIN);
        let size = [width, height].map(|n| n + 2 * margin);
        Self { wall_points: vec![NONE; size[0] * size[1]], places: Vec::new(), size, margin }
    }

    /// The next wall point lies in this column and row of the map.
    pub(crate) fn push(&mut self, [column, row]: [usize; 2]) {
        let place = (row + self.margin) * self.size[0] + column + self.margin;
        self.wall_points[place] = self.places.len() as u32;
        self.places.push(place as u32);
    }

    /// Columns and rows between two cells as a step.
    pub(crate) fn step(&self, [columns, rows]: [i64; 2]) -> isize {
        (rows * self.size[0] as i64 + columns) as isize
    }

    /// The wall point a step beside one; [`NONE`] if there is none.
    #[inline]
    pub(crate) fn beside(&self, wall_point: usize, step: isize) -> u32 {
        self.wall_points[(self.places[wall_point] as usize).wrapping_add_signed(step)]
    }

    /// Those in these columns of a row of the map, which may lie in the margin.
    pub(crate) fn row(&self, row: i64, columns: Range<i64>) -> &[u32] {
        let within = |cell: i64, k: usize| (cell + self.margin as i64).clamp(0, self.size[k] as i64) as usize;
        if within(row, 1) == within(row + 1, 1) {
            return &[];
        }
        let line = within(row, 1) * self.size[0];
        &self.wall_points[line + within(columns.start, 0)..line + within(columns.end, 0)]
    }

    /// The index of the cell of a point, in metres from the map's lower left corner; `None` beyond the margin.
    #[inline]
    pub(crate) fn index_at(&self, [x, y]: [f64; 2]) -> Option<usize> {
        let (column, row) = (x / CELL_M + self.margin as f64, y / CELL_M + self.margin as f64);
        if column < 0.0 || row < 0.0 || column >= self.size[0] as f64 || row >= self.size[1] as f64 {
            return None;
        }
        Some(row as usize * self.size[0] + column as usize)
    }

    /// By index of a cell: the nearest wall point, [`NONE`] if there is none at all.
    pub(crate) fn nearest(&self) -> Vec<u32> {
        let marked: Vec<bool> = self.wall_points.iter().map(|wall_point| *wall_point != NONE).collect();
        let cells = nearest_marked(&marked, self.size[0]);
        cells.into_iter().map(|cell| self.wall_points.get(cell as usize).copied().unwrap_or(NONE)).collect()
    }
}
