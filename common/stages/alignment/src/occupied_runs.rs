//! Runs of occupied cells, and how large the things are that they belong to.

use occupancy::{Cell, Raster};
use petgraph::unionfind::UnionFind;
use std::ops::Range;

/// Occupied cells of a row beside each other.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct OccupiedRun {
    pub(crate) row: usize,
    pub(crate) columns: Range<usize>,
    /// Diagonal of the box around all occupied cells that are joined to these by sides or corners.
    pub(crate) diagonal_cells: f64,
}

/// All runs of occupied cells, by row and column.
///
/// # Source
/// Rosenfeld and Pfaltz, "Sequential operations in digital picture processing", Journal of the ACM 13, 1966: components by rows.
pub(crate) fn occupied_runs(raster: &Raster) -> Vec<OccupiedRun> {
    let mut runs: Vec<OccupiedRun> = Vec::new();
    let mut joined = UnionFind::<u32>::new_empty();
    let mut above = 0..0;
    for (row, cells) in raster.cells.chunks_exact(raster.width.max(1)).enumerate() {
        let first = runs.len();
        let mut next_above = above.start;
        let mut start = 0;
        for cells in cells.chunk_by(|a, b| (*a == Cell::Occupied) == (*b == Cell::Occupied)) {
            let columns = start..start + cells.len();
            start = columns.end;
            if cells[0] != Cell::Occupied {
                continue;
            }
            let run = joined.new_set();
            // Those above that end before this one begins also end before all that follow.
            while next_above < above.end && runs[next_above].columns.end < columns.start {
                next_above += 1;
            }
            for k in (next_above..above.end).take_while(|k| runs[*k].columns.start <= columns.end) {
                joined.union(k as u32, run);
            }
            runs.push(OccupiedRun { row, columns, diagonal_cells: 0.0 });
        }
        above = first..runs.len();
    }
    let joined = joined.into_labeling();
    // Of each set that of the run that stands for it: the lowest column and row, and those behind the highest.
    let mut boxes = vec![[usize::MAX, usize::MAX, 0, 0]; runs.len()];
    for (run, whole) in runs.iter().zip(&joined) {
        let [left, below, right, top] = &mut boxes[*whole as usize];
        (*left, *below) = ((*left).min(run.columns.start), (*below).min(run.row));
        (*right, *top) = ((*right).max(run.columns.end), (*top).max(run.row + 1));
    }
    for (run, whole) in runs.iter_mut().zip(&joined) {
        let [left, below, right, top] = boxes[*whole as usize];
        run.diagonal_cells = libm::hypot((right - left) as f64, (top - below) as f64);
    }
    runs
}

#[cfg(test)]
mod tests {
    use super::*;
    use occupancy::CELL_M;
    use proptest::prelude::*;

    fn raster(width: usize, occupied: &[bool]) -> Raster {
        let cells: Vec<Cell> = occupied.iter().map(|o| if *o { Cell::Occupied } else { Cell::Free }).collect();
        Raster::of(&cells, width, CELL_M)
    }

    /// The diagonal of the box around the cells that are reached from one by steps to occupied neighbours.
    fn diagonal_from(start: usize, width: usize, occupied: &[bool]) -> f64 {
        let height = occupied.len() / width;
        let mut reached = vec![false; occupied.len()];
        let mut open = vec![start];
        let (mut lo, mut hi) = ([usize::MAX; 2], [0; 2]);
        while let Some(cell) = open.pop() {
            if std::mem::replace(&mut reached[cell], true) {
                continue;
            }
            let [x, y] = [cell % width, cell / width];
            (lo, hi) = ([lo[0].min(x), lo[1].min(y)], [hi[0].max(x + 1), hi[1].max(y + 1)]);
            for row in y.saturating_sub(1)..(y + 2).min(height) {
                let columns = x.saturating_sub(1)..(x + 2).min(width);
                open.extend(columns.map(|column| row * width + column).filter(|&cell| occupied[cell]));
            }
        }
        libm::hypot((hi[0] - lo[0]) as f64, (hi[1] - lo[1]) as f64)
    }

    proptest! {
        #[test]
        fn runs_are_the_occupied_cells_and_know_the_size_of_what_they_belong_to(
            width in 1usize..24,
            occupied in prop::collection::vec(prop::bool::weighted(0.45), 0..480),
        ) {
            let occupied = &occupied[..occupied.len() / width * width];
            let runs = occupied_runs(&raster(width, occupied));
            let cells = |run: &OccupiedRun| run.columns.clone().map(|column| run.row * width + column).collect::<Vec<_>>();
            let all: Vec<usize> = (0..occupied.len()).filter(|&k| occupied[k]).collect();
            prop_assert_eq!(runs.iter().flat_map(cells).collect::<Vec<_>>(), all);
            for run in &runs {
                prop_assert_eq!(run.diagonal_cells, diagonal_from(cells(run)[0], width, occupied));
            }
        }
    }
}
