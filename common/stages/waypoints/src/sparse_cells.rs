//! A number for each cell of a grid of which most are 0: a site is mostly outside.

/// Cells in a run: short against a room, long against what a run costs.
const RUN_BITS: u32 = 6;
const RUN_CELLS: usize = 1 << RUN_BITS;

/// A number for each cell; runs of zeros take no room.
pub(crate) struct SparseCells {
    /// Where the numbers of each run begin.
    starts: Vec<u32>,
    /// The first run is that of zeros.
    numbers: Vec<u32>,
}

impl SparseCells {
    /// Of all cells, row by row.
    pub(crate) fn of(cells: &[u32]) -> Self {
        let mut numbers = vec![0; RUN_CELLS];
        let start_of = |run: &[u32]| {
            if run.iter().all(|number| *number == 0) {
                return 0;
            }
            let start = numbers.len() as u32;
            numbers.extend_from_slice(run);
            start
        };
        let starts = cells.chunks(RUN_CELLS).map(start_of).collect();
        numbers.shrink_to_fit();
        Self { starts, numbers }
    }

    /// The number of a cell.
    pub(crate) fn get(&self, cell: usize) -> u32 {
        self.numbers[self.starts[cell >> RUN_BITS] as usize + cell % RUN_CELLS]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn every_cell_has_its_number_and_zeros_take_no_room(runs in prop::collection::vec((0u32..4, 0usize..300), 0..20)) {
            let cells: Vec<u32> = runs.iter().flat_map(|&(number, n)| std::iter::repeat_n(number, n)).collect();
            let sparse = SparseCells::of(&cells);
            for (cell, number) in cells.iter().enumerate() {
                prop_assert_eq!(sparse.get(cell), *number);
            }
            let n_others = cells.chunks(RUN_CELLS).filter(|run| run.iter().any(|number| *number > 0)).count();
            prop_assert!(sparse.numbers.len() <= (n_others + 1) * RUN_CELLS);
        }
    }
}
