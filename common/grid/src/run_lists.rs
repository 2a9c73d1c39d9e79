//! Lists of runs: what two have in common, and what lies around one.

use crate::bitmap::Bitmap;
use crate::{CellRect, Run};

/// Cells of both of two lists of runs, each sorted and without runs that meet.
pub fn common_runs(a: &[Run], b: &[Run]) -> Vec<Run> {
    let (mut i, mut k) = (0, 0);
    let mut common = Vec::new();
    while let (Some(one), Some(other)) = (a.get(i), b.get(k)) {
        let (start, end) = (one.start.max(other.start), one.end.min(other.end));
        if one.row == other.row && start < end {
            common.push(Run { row: one.row, start, end });
        }
        if (one.row, one.end) < (other.row, other.end) { i += 1 } else { k += 1 }
    }
    common
}

/// Cells at most `reach` columns and rows from sorted runs, within `bounds`.
pub fn grown_runs(runs: &[Run], reach: u32, bounds: &CellRect) -> Vec<Run> {
    let Some(rect) = CellRect::around(runs).map(|rect| rect.grown(reach, bounds)) else { return Vec::new() };
    let mut bitmap = Bitmap::new(rect);
    for run in runs {
        let (start, end) = (run.start.saturating_sub(reach).max(rect.min[0]), (run.end + reach).min(rect.max[0]));
        let rows = run.row.saturating_sub(reach).max(rect.min[1])..(run.row + reach + 1).min(rect.max[1]);
        rows.for_each(|row| bitmap.set(Run { row, start, end }));
    }
    bitmap.runs()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const SIDE: u32 = 12;

    fn runs_of(cells: &[bool]) -> Vec<Run> {
        let mut bitmap = Bitmap::new(CellRect::whole(SIDE, SIDE));
        for k in (0..SIDE * SIDE).filter(|&k| cells[k as usize]) {
            bitmap.set(Run { row: k / SIDE, start: k % SIDE, end: k % SIDE + 1 });
        }
        bitmap.runs()
    }

    fn cells_of(runs: &[Run]) -> Vec<bool> {
        let mut cells = vec![false; (SIDE * SIDE) as usize];
        for run in runs {
            let row = run.row * SIDE;
            cells[(row + run.start) as usize..(row + run.end) as usize].fill(true);
        }
        cells
    }

    proptest! {
        #[test]
        fn runs_in_common_and_around_hold_the_cells_that_they_should(
            a in prop::collection::vec(any::<bool>(), 144), b in prop::collection::vec(any::<bool>(), 144), reach in 0u32..3,
        ) {
            let both: Vec<bool> = a.iter().zip(&b).map(|(a, b)| a & b).collect();
            prop_assert_eq!(cells_of(&common_runs(&runs_of(&a), &runs_of(&b))), both);
            let is_near = |k: u32| (0..144).any(|n: u32| {
                a[n as usize] && (n / SIDE).abs_diff(k / SIDE) <= reach && (n % SIDE).abs_diff(k % SIDE) <= reach
            });
            let near: Vec<bool> = (0..144).map(is_near).collect();
            let grown = grown_runs(&runs_of(&a), reach, &CellRect::whole(SIDE, SIDE));
            prop_assert_eq!(cells_of(&grown), near);
        }
    }
}
