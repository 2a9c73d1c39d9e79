//! Bits of the cells of a rectangle.

use crate::{CellRect, Run};

/// A bit per cell of a rectangle, each row in whole words.
pub(crate) struct Bitmap {
    rect: CellRect,
    words_per_row: usize,
    words: Vec<u64>,
}

impl Bitmap {
    /// A bitmap in which nothing is set.
    pub(crate) fn new(rect: CellRect) -> Self {
        let words_per_row = rect.width().div_ceil(64);
        Self { rect, words_per_row, words: vec![0; words_per_row * rect.height()] }
    }

    /// Sets the cells of a run that lies in the rectangle.
    pub(crate) fn set(&mut self, run: Run) {
        let row = (run.row - self.rect.min[1]) as usize * self.words_per_row;
        let (start, end) = (run.start - self.rect.min[0], run.end - self.rect.min[0]);
        let (first, last) = (start / 64, (end - 1) / 64);
        let (from, to) = (u64::MAX << (start % 64), u64::MAX >> (63 - (end - 1) % 64));
        let words = &mut self.words[row + first as usize..=row + last as usize];
        if let [word] = words {
            *word |= from & to;
            return;
        }
        let n = words.len();
        words[0] |= from;
        words[1..n - 1].fill(u64::MAX);
        words[n - 1] |= to;
    }

    /// Sets the cells of runs.
    pub(crate) fn set_runs(&mut self, runs: &[Run]) {
        runs.iter().for_each(|run| self.set(*run));
    }

    /// The cells that are set, as sorted runs that do not meet.
    pub(crate) fn runs(&self) -> Vec<Run> {
        let mut runs: Vec<Run> = Vec::new();
        for (row, words) in (self.rect.min[1]..).zip(self.words.chunks_exact(self.words_per_row)) {
            let first = runs.len();
            for (base, &word) in (self.rect.min[0]..).step_by(64).zip(words) {
                let mut left = word;
                while left != 0 {
                    let start = left.trailing_zeros();
                    let length = (left >> start).trailing_ones();
                    left &= !(u64::MAX >> (64 - length) << start);
                    let (start, end) = (base + start, base + start + length);
                    match runs[first..].last_mut() {
                        Some(run) if run.end == start => run.end = end,
                        _ => runs.push(Run { row, start, end }),
                    }
                }
            }
        }
        runs
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn runs_are_what_was_set(
            runs in prop::collection::vec((0u32..5, 0u32..300, 1u32..200), 0..20), columns in (0u32..70, 500u32..600),
        ) {
            let rect = CellRect { min: [columns.0, 3], max: [columns.0 + columns.1, 8] };
            let mut bitmap = Bitmap::new(rect);
            let mut expected = vec![[false; 700]; 8];
            for (row, start, n) in runs {
                let run = Run { row: row + 3, start: start + columns.0, end: start + columns.0 + n };
                bitmap.set(run);
                expected[run.row as usize][run.start as usize..run.end as usize].fill(true);
            }
            let found = bitmap.runs();
            prop_assert!(found.windows(2).all(|w| (w[0].row, w[0].end) < (w[1].row, w[1].start)));
            for run in found {
                for column in run.start..run.end {
                    prop_assert!(std::mem::take(&mut expected[run.row as usize][column as usize]));
                }
            }
            prop_assert!(!expected.iter().flatten().any(|on| *on));
        }
    }
}
