//! Rectangles of cells.

use crate::Run;

/// Cells from `min` to before `max`, by column and row.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CellRect {
    /// Column and row of the lower left cell.
    pub min: [u32; 2],
    /// Column and row behind the upper right cell.
    pub max: [u32; 2],
}

impl CellRect {
    /// All cells of a grid of this size.
    pub fn whole(width: u32, height: u32) -> Self {
        Self { min: [0; 2], max: [width, height] }
    }

    /// The smallest rectangle around sorted runs; `None` if there are none.
    pub fn around(runs: &[Run]) -> Option<Self> {
        let (first, last) = (runs.first()?, runs.last()?);
        let start = runs.iter().map(|r| r.start).min()?;
        let end = runs.iter().map(|r| r.end).max()?;
        Some(Self { min: [start, first.row], max: [end, last.row + 1] })
    }

    /// Columns.
    pub fn width(&self) -> usize {
        (self.max[0] - self.min[0]) as usize
    }

    /// Rows.
    pub fn height(&self) -> usize {
        (self.max[1] - self.min[1]) as usize
    }

    /// Number of cells.
    pub fn n_cells(&self) -> usize {
        self.width() * self.height()
    }

    /// True if a cell lies in both.
    pub fn meets(&self, other: &Self) -> bool {
        (0..2).all(|k| self.min[k] < other.max[k] && other.min[k] < self.max[k])
    }

    /// The smallest rectangle around both.
    pub fn around_both(&self, other: &Self) -> Self {
        Self { min: [0, 1].map(|k| self.min[k].min(other.min[k])), max: [0, 1].map(|k| self.max[k].max(other.max[k])) }
    }

    /// The smallest rectangle around all of some; `None` if there are none.
    pub fn around_all(rects: impl Iterator<Item = Self>) -> Option<Self> {
        rects.reduce(|a, b| a.around_both(&b))
    }

    /// The rectangle grown to all sides, clipped to `bounds`.
    pub fn grown(&self, cells: u32, bounds: &Self) -> Self {
        Self {
            min: [0, 1].map(|k| self.min[k].saturating_sub(cells).max(bounds.min[k])),
            max: [0, 1].map(|k| self.max[k].saturating_add(cells).min(bounds.max[k])),
        }
    }

    /// The rectangle in squares of at most `side` cells, row by row.
    pub fn tiles(&self, side: u32) -> impl Iterator<Item = Self> + use<> {
        let (min, max) = (self.min, self.max);
        let steps = move |k: usize| (min[k]..max[k]).step_by(side as usize);
        steps(1).flat_map(move |y| {
            steps(0).map(move |x| Self { min: [x, y], max: [max[0].min(x + side), max[1].min(y + side)] })
        })
    }

    /// The columns of each row, as ranges of indices in layers of `width` columns.
    pub fn rows(&self, width: usize) -> impl Iterator<Item = std::ops::Range<usize>> + use<> {
        let (first, end) = (self.min[0] as usize, self.max[0] as usize);
        (self.min[1] as usize..self.max[1] as usize).map(move |row| row * width + first..row * width + end)
    }

    /// The parts of sorted runs that lie in the rectangle, as ranges of indices in layers of `width` columns.
    pub fn clip<'r>(&self, runs: &'r [Run], width: usize) -> impl Iterator<Item = std::ops::Range<usize>> + use<'r> {
        let Self { min, max } = *self;
        let from = runs.partition_point(|r| r.row < min[1]);
        let to = from + runs[from..].partition_point(|r| r.row < max[1]);
        runs[from..to].iter().filter_map(move |run| {
            let (start, end) = (run.start.max(min[0]), run.end.min(max[0]));
            let row = run.row as usize * width;
            (start < end).then(|| row + start as usize..row + end as usize)
        })
    }
}

/// Joins rectangles while that reduces the number of cells in all.
pub fn join_rects(rects: &mut Vec<CellRect>) {
    let mut at = 0;
    while at < rects.len() {
        let other = (0..at).find(|&k| {
            let both = rects[k].around_both(&rects[at]);
            both.n_cells() <= rects[k].n_cells() + rects[at].n_cells()
        });
        match other {
            Some(k) => {
                // The joined rectangle is compared with the earlier ones again.
                let joined = rects[k].around_both(&rects[at]);
                rects.swap_remove(at);
                rects.swap_remove(k);
                rects.push(joined);
                at = k;
            }
            None => at += 1,
        }
    }
}

/// Sorted runs that do not meet as rectangles: runs of the same columns in rows above each other are one.
pub fn stacked_runs(runs: &[Run]) -> Vec<CellRect> {
    let mut rects: Vec<CellRect> = Vec::new();
    // Those that end with the row below, and those that end with this one, from left to right.
    let (mut below, mut own) = (Vec::new(), Vec::new());
    for row in runs.chunk_by(|a, b| a.row == b.row) {
        let mut left_below = below.iter().copied().peekable();
        for run in row {
            while left_below.next_if(|&rect: &usize| rects[rect].min[0] < run.start).is_some() {}
            let goes_on = |rect: &usize| {
                let CellRect { min, max } = rects[*rect];
                [min[0], max[0], max[1]] == [run.start, run.end, run.row]
            };
            let rect = left_below.next_if(goes_on).unwrap_or(rects.len());
            match rects.get_mut(rect) {
                Some(rect) => rect.max[1] += 1,
                None => rects.push(CellRect { min: [run.start, run.row], max: [run.end, run.row + 1] }),
            }
            own.push(rect);
        }
        std::mem::swap(&mut below, &mut own);
        own.clear();
    }
    rects
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn rect(min: [u32; 2], max: [u32; 2]) -> CellRect {
        CellRect { min, max }
    }

    #[test]
    fn runs_are_cut_to_the_rectangle() {
        let runs = [
            Run { row: 0, start: 0, end: 9 },
            Run { row: 1, start: 0, end: 3 },
            Run { row: 1, start: 5, end: 9 },
            Run { row: 3, start: 2, end: 4 },
        ];
        let places = |r: CellRect| r.clip(&runs, 10).collect::<Vec<_>>();
        assert_eq!(places(rect([2, 1], [6, 3])), [12..13, 15..16]);
        assert_eq!(places(rect([0, 2], [10, 3])), []);
        assert_eq!(CellRect::around(&runs), Some(rect([0, 0], [9, 4])));
    }

    #[test]
    fn runs_of_a_block_are_one_rectangle_and_a_gap_ends_it() {
        let runs = [(0, 2, 4), (1, 0, 1), (1, 2, 4), (2, 0, 1), (2, 2, 5), (4, 0, 1), (5, 2, 5)];
        let runs = runs.map(|(row, start, end)| Run { row, start, end });
        let expected = [
            rect([2, 0], [4, 2]),
            rect([0, 1], [1, 3]),
            rect([2, 2], [5, 3]),
            rect([0, 4], [1, 5]),
            rect([2, 5], [5, 6]),
        ];
        assert_eq!(stacked_runs(&runs), expected);
    }

    #[test]
    fn tiles_cover_a_rectangle_once() {
        let tiles: Vec<CellRect> = rect([3, 1], [12, 6]).tiles(4).collect();
        assert_eq!(tiles.len(), 6);
        assert_eq!(tiles.iter().map(CellRect::n_cells).sum::<usize>(), 45);
        assert_eq!(tiles.last(), Some(&rect([11, 5], [12, 6])));
    }

    proptest! {
        #[test]
        fn stacked_runs_are_the_cells_of_the_runs_once(cells in prop::collection::vec(prop::bool::weighted(0.8), 48)) {
            let width = 8;
            let row = |(row, cells): (usize, &[bool])| {
                let ends = |column: usize| [column.checked_sub(1), Some(column)].map(|c| c.and_then(|c| cells.get(c)).copied().unwrap_or(false));
                let borders: Vec<u32> = (0..=width).filter(|&column| ends(column)[0] != ends(column)[1]).map(|c| c as u32).collect();
                let run = |ends: &[u32]| Run { row: row as u32, start: ends[0], end: ends[1] };
                borders.chunks_exact(2).map(run).collect::<Vec<_>>()
            };
            let runs: Vec<Run> = cells.chunks_exact(width).enumerate().flat_map(row).collect();
            let mut n_rects = vec![0; cells.len()];
            for rect in stacked_runs(&runs) {
                rect.rows(width).flatten().for_each(|cell| n_rects[cell] += 1);
            }
            prop_assert!(n_rects.iter().zip(&cells).all(|(n, is_set)| *n == i32::from(*is_set)));
        }


        #[test]
        fn joined_rectangles_hold_the_same_cells_and_do_not_grow_in_all(
            corners in prop::collection::vec((0u32..40, 0u32..40, 1u32..10, 1u32..10), 0..12)
        ) {
            let before: Vec<CellRect> = corners.iter().map(|&(x, y, w, h)| rect([x, y], [x + w, y + h])).collect();
            let mut after = before.clone();
            join_rects(&mut after);
            let cells = |rects: &[CellRect]| rects.iter().map(CellRect::n_cells).sum::<usize>();
            prop_assert!(cells(&after) <= cells(&before));
            for one in &before {
                let inside = |r: &CellRect| (0..2).all(|k| r.min[k] <= one.min[k] && one.max[k] <= r.max[k]);
                prop_assert!(after.iter().any(inside));
            }
        }
    }
}
