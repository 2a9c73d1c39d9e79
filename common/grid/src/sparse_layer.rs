//! Layers of values for the cells of a grid of which most have none: a site is mostly outside.

use std::iter::repeat_n;
use std::ops::{Index, IndexMut, Range};
use std::sync::Arc;

/// Cells in a chunk: few against a room, many against what a chunk costs.
const CHUNK_BITS: u32 = 6;
const CHUNK_CELLS: usize = 1 << CHUNK_BITS;

/// The cells of a grid that have values of their own, by chunks of 64 cells: one such cell, and all of its chunk have. Layers
/// share it.
#[derive(Debug, Clone)]
pub struct SparseCells {
    /// Where the values of each chunk begin; 0 for a chunk without.
    starts: Arc<[u32]>,
    n_cells: usize,
    /// Number of values of a layer.
    n_values: usize,
}

impl SparseCells {
    /// Those of `n_cells` cells for which `has_value` is true, and the rest of their chunks.
    pub fn of(n_cells: usize, has_value: impl Fn(usize) -> bool) -> Self {
        // The first chunk of values is that of all cells without.
        let mut n_values = CHUNK_CELLS;
        let starts = (0..n_cells.div_ceil(CHUNK_CELLS)).map(|chunk| {
            let mut cells = chunk * CHUNK_CELLS..((chunk + 1) * CHUNK_CELLS).min(n_cells);
            let has_values = cells.any(&has_value);
            let start = if has_values { n_values } else { 0 };
            n_values += if has_values { CHUNK_CELLS } else { 0 };
            u32::try_from(start).expect("a grid has fewer cells than 32 bits number")
        });
        let starts = starts.collect();
        Self { starts, n_cells, n_values }
    }

    /// Number of cells, with and without values.
    pub fn n_cells(&self) -> usize {
        self.n_cells
    }

    /// A layer in which every cell has the same value.
    pub fn layer<T: Copy>(&self, value: T) -> SparseLayer<T> {
        SparseLayer { cells: self.clone(), values: vec![value; self.n_values] }
    }

    /// A layer of values by cell; all cells without values of their own have `other`.
    pub fn layer_of<T: Copy>(&self, other: T, value_of: impl Fn(usize) -> T) -> SparseLayer<T> {
        let mut values = Vec::with_capacity(self.n_values);
        values.extend(repeat_n(other, CHUNK_CELLS));
        for cells in self.chunks() {
            let n_missing = CHUNK_CELLS - cells.len();
            values.extend(cells.map(&value_of).chain(repeat_n(other, n_missing)));
        }
        SparseLayer { cells: self.clone(), values }
    }

    /// The cells with values of their own, in their order.
    pub fn iter(&self) -> impl DoubleEndedIterator<Item = usize> {
        self.chunks().flatten()
    }

    /// The cells of each chunk with values.
    fn chunks(&self) -> impl DoubleEndedIterator<Item = Range<usize>> {
        let cells_of = |chunk: usize| chunk * CHUNK_CELLS..((chunk + 1) * CHUNK_CELLS).min(self.n_cells);
        self.starts.iter().enumerate().filter(|(_, start)| **start != 0).map(move |(chunk, _)| cells_of(chunk))
    }

    /// For each chunk of a stretch of cells its cells, counted from the first of the stretch, and the place of their values; `None` for
    /// a chunk without.
    fn places(&self, first: usize, length: usize) -> impl Iterator<Item = (Range<usize>, Option<usize>)> {
        let mut done = 0;
        std::iter::from_fn(move || {
            let n = (CHUNK_CELLS - (first + done) % CHUNK_CELLS).min(length - done);
            let place = (n > 0).then(|| self.place(first + done))?;
            done += n;
            Some((done - n..done, (place >= CHUNK_CELLS).then_some(place)))
        })
    }

    /// Place of a cell's value.
    #[inline]
    fn place(&self, cell: usize) -> usize {
        self.starts[cell >> CHUNK_BITS] as usize + cell % CHUNK_CELLS
    }
}

/// A value for each cell: of its own for [`SparseCells`], one for all others.
#[derive(Debug, Clone)]
pub struct SparseLayer<T> {
    cells: SparseCells,
    values: Vec<T>,
}

impl<T> SparseLayer<T> {
    /// The cells with values of their own.
    pub fn cells(&self) -> &SparseCells {
        &self.cells
    }

    /// The value of a cell; `None` outside of the grid.
    pub fn get(&self, cell: usize) -> Option<&T> {
        (cell < self.cells.n_cells).then(|| &self[cell])
    }
}

impl<T: Copy> SparseLayer<T> {
    /// The cells with values of their own, each with its value, in their order; fastest where it is folded, as by `for_each`.
    pub fn iter(&self) -> impl DoubleEndedIterator<Item = (usize, T)> + '_ {
        self.chunks().flat_map(|(first, values)| values.iter().enumerate().map(move |(k, &value)| (first + k, value)))
    }

    /// The same by stretches of consecutive cells: the first of them, and their values.
    pub fn chunks(&self) -> impl DoubleEndedIterator<Item = (usize, &[T])> + '_ {
        self.cells.chunks().map(|cells| {
            let place = self.cells.place(cells.start);
            (cells.start, &self.values[place..place + cells.len()])
        })
    }

    /// A layer of values by cell and its value here; all cells without values of their own have `other`.
    pub fn map<U: Copy>(&self, other: U, value_of: impl Fn(usize, T) -> U) -> SparseLayer<U> {
        let mut values = Vec::with_capacity(self.values.len());
        values.extend(repeat_n(other, CHUNK_CELLS));
        for (first, own) in self.chunks() {
            values.extend(own.iter().enumerate().map(|(k, &value)| value_of(first + k, value)));
            values.extend(repeat_n(other, CHUNK_CELLS - own.len()));
        }
        SparseLayer { cells: self.cells.clone(), values }
    }

    /// Gives consecutive cells one value; those without values of their own stay.
    pub fn fill(&mut self, cells: Range<usize>, value: T) {
        for (cells, place) in self.cells.places(cells.start, cells.len()) {
            if let Some(place) = place {
                self.values[place..place + cells.len()].fill(value);
            }
        }
    }

    /// Copies what is wanted of the values of a stretch of cells.
    pub fn read<U: Copy>(&self, first: usize, out: &mut [U], wanted: impl Fn(T) -> U) {
        for (cells, place) in self.cells.places(first, out.len()) {
            match place {
                Some(place) => {
                    let values = &self.values[place..place + cells.len()];
                    out[cells].iter_mut().zip(values).for_each(|(out, value)| *out = wanted(*value));
                }
                None => out[cells].fill(wanted(self.values[0])),
            }
        }
    }

    /// Sets the values of a stretch of cells; those of cells without values of their own stay.
    pub fn write(&mut self, first: usize, values: &[T]) {
        for (cells, place) in self.cells.places(first, values.len()) {
            if let Some(place) = place {
                self.values[place..place + cells.len()].copy_from_slice(&values[cells]);
            }
        }
    }
}

impl<T> Index<usize> for SparseLayer<T> {
    type Output = T;

    #[inline]
    fn index(&self, cell: usize) -> &T {
        &self.values[self.cells.place(cell)]
    }
}

impl<T> IndexMut<usize> for SparseLayer<T> {
    /// # Panics
    /// The cell has no value of its own, but that of all such cells.
    #[inline]
    fn index_mut(&mut self, cell: usize) -> &mut T {
        let place = self.cells.place(cell);
        assert!(place >= CHUNK_CELLS, "the cell has a value of its own");
        &mut self.values[place]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn every_cell_has_its_value_and_cells_without_take_no_room(
            stretches in prop::collection::vec((0u32..4, 0usize..300), 0..20),
        ) {
            let numbers: Vec<u32> = stretches.iter().flat_map(|&(number, n)| repeat_n(number, n)).collect();
            let has_values = |chunk: &[u32]| chunk.iter().any(|number| *number != 0);
            let cells = SparseCells::of(numbers.len(), |cell| numbers[cell] != 0);
            let layer = cells.layer_of(0, |cell| numbers[cell]);
            let mapped = layer.map(0, |cell, number| cell as u32 + number);
            let mut written = cells.layer(9u64);
            for cell in cells.iter() {
                written[cell] = u64::from(numbers[cell]);
            }
            for (cell, &number) in numbers.iter().enumerate() {
                prop_assert_eq!(layer[cell], number);
                let is_own = numbers.chunks(CHUNK_CELLS).nth(cell / CHUNK_CELLS).is_some_and(has_values);
                prop_assert_eq!(written[cell], if is_own { u64::from(number) } else { 9 });
                prop_assert_eq!(mapped[cell], if is_own { cell as u32 + number } else { 0 });
            }
            let own: Vec<(usize, u64)> = cells.iter().map(|cell| (cell, u64::from(numbers[cell]))).collect();
            prop_assert_eq!(written.iter().collect::<Vec<_>>(), &own[..]);
            prop_assert_eq!(written.iter().rev().collect::<Vec<_>>(), own.iter().rev().copied().collect::<Vec<_>>());
            let (from, to) = (numbers.len() / 3, numbers.len() / 2);
            let mut filled = layer.clone();
            filled.fill(from..to, 8);
            for (cell, &number) in numbers.iter().enumerate() {
                let is_filled = (from..to).contains(&cell) && written[cell] != 9;
                prop_assert_eq!(filled[cell], if is_filled { 8 } else { number });
            }
            prop_assert_eq!(layer.get(numbers.len()), None);
            prop_assert_eq!(written.cells().n_cells(), numbers.len());
            let n_chunks = numbers.chunks(CHUNK_CELLS).filter(|chunk| has_values(chunk)).count();
            prop_assert_eq!(layer.values.len(), (n_chunks + 1) * CHUNK_CELLS);
        }
    }

    #[test]
    #[should_panic(expected = "the cell has a value of its own")]
    fn a_cell_without_a_value_of_its_own_cannot_be_written() {
        SparseCells::of(200, |cell| cell == 100).layer(0)[10] = 1;
    }
}
