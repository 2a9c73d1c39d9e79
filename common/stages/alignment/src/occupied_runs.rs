//! Runs of occupied cells, and how large the things are that they belong to.

use occupancy::{Cell, Raster};
use std::ops::Range;

/// Occupied cells of a row beside each other.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct OccupiedRun {
    pub(crate) row: usize,
    pub(crate) columns: Range<usize>,
    /// Diagonal of the box around all occupied cells that are joined to these by sides or corners.
    pub(crate) diagonal_cells: f64,
}

/// Sets of joined runs, each with its box.
struct Joined {
    /// By run: one of the same set, itself for the one that stands for all.
    parents: Vec<u32>,
    /// By run that stands for a set: the lowest column and row, and those behind the highest.
    boxes: Vec<[usize; 4]>,
}

impl Joined {
    fn of(&mut self, mut run: u32) -> u32 {
        while self.parents[run as usize] != run {
            let above = self.parents[self.parents[run as usize] as usize];
            self.parents[run as usize] = above;
            run = above;
        }
        run
    }

    fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.of(a), self.of(b));
        if a == b {
            return;
        }
        let (a, b) = (a.min(b), a.max(b));
        self.parents[b as usize] = a;
        let [of_a, of_b] = [a, b].map(|run| self.boxes[run as usize]);
        self.boxes[a as usize] =
            std::array::from_fn(|k| if k < 2 { of_a[k].min(of_b[k]) } else { of_a[k].max(of_b[k]) });
    }
}

/// All runs of occupied cells, by row and column.
///
/// # Source
/// Rosenfeld and Pfaltz, "Sequential operations in digital picture processing", Journal of the ACM 13, 1966: components by rows.
pub(crate) fn occupied_runs(raster: &Raster) -> Vec<OccupiedRun> {
    let mut runs: Vec<OccupiedRun> = Vec::new();
    let mut joined = Joined { parents: Vec::new(), boxes: Vec::new() };
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
            let run = runs.len() as u32;
            joined.parents.push(run);
            joined.boxes.push([columns.start, row, columns.end, row + 1]);
            // Those above that end before this one begins also end before all that follow.
            while next_above < above.end && runs[next_above].columns.end < columns.start {
                next_above += 1;
            }
            for k in (next_above..above.end).take_while(|k| runs[*k].columns.start <= columns.end) {
                joined.join(k as u32, run);
            }
            runs.push(OccupiedRun { row, columns, diagonal_cells: 0.0 });
        }
        above = first..runs.len();
    }
    for (run, number) in runs.iter_mut().zip(0..) {
        let whole = joined.of(number);
        let [left, below, right, top] = joined.boxes[whole as usize];
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
