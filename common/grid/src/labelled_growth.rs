//! Regions that grow from labelled seeds, each cell to the nearest of them, without leaking through walls.

use crate::growth::{CORNER, SIDE};
use crate::{CellRect, Run};
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// The nearest seed of a cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct NearestSeed {
    /// Length of the path to it, in fifths of a cell.
    pub fifths: u32,
    /// Its label.
    pub label: u32,
}

/// Fifths of a cell in a distance in cells.
pub fn fifths_of(cells: f64) -> u32 {
    (cells.max(0.0) * f64::from(SIDE) + 1e-6).floor() as u32
}

/// For each open cell within `reach_fifths` of a seed along a path over open cells, the nearest seed; of equally near ones that
/// with the lowest label. `seeds` are runs of cells with their labels, which need not be open.
///
/// Steps cost as those of [`crate::Growth`]: 5 fifths along a side and 7 across a corner; a corner between two cells that are
/// neither open nor seeds is closed. Open cells of a seed are at 0.
pub fn grow_labelled<'a>(
    whole: CellRect,
    is_open: impl Fn(usize) -> bool,
    seeds: impl Iterator<Item = (u32, &'a [Run])>,
    reach_fifths: u32,
) -> Vec<Option<NearestSeed>> {
    let width = whole.width();
    let mut nearest: Vec<Option<NearestSeed>> = vec![None; whole.n_cells()];
    for (label, runs) in seeds {
        for cell in runs.iter().flat_map(|run| {
            let row = run.row as usize * width;
            row + run.start as usize..row + run.end as usize
        }) {
            let seed = NearestSeed { fifths: 0, label };
            nearest[cell] = Some(nearest[cell].map_or(seed, |other| other.min(seed)));
        }
    }
    let is_seed: Vec<bool> = nearest.iter().map(Option::is_some).collect();
    let mut waiting: BinaryHeap<Reverse<(NearestSeed, usize)>> =
        nearest.iter().enumerate().filter_map(|(cell, seed)| Some(Reverse(((*seed)?, cell)))).collect();
    let passes = |cell: usize| is_open(cell) || is_seed[cell];
    while let Some(Reverse((seed, cell))) = waiting.pop() {
        if nearest[cell] != Some(seed) {
            continue;
        }
        for (next, cost) in steps(&whole, cell, &passes) {
            let reached = NearestSeed { fifths: seed.fifths + u32::from(cost), label: seed.label };
            let is_nearer = nearest[next].is_none_or(|other| reached < other);
            if reached.fifths <= reach_fifths && is_nearer && is_open(next) {
                nearest[next] = Some(reached);
                waiting.push(Reverse((reached, next)));
            }
        }
    }
    nearest.iter_mut().enumerate().filter(|(cell, _)| !is_open(*cell)).for_each(|(_, seed)| *seed = None);
    nearest
}

/// The cells around a cell to which a step leads, with its cost.
fn steps(whole: &CellRect, cell: usize, passes: &impl Fn(usize) -> bool) -> impl Iterator<Item = (usize, u16)> {
    let width = whole.width();
    let (column, row) = (cell % width, cell / width);
    let n_rows = whole.n_cells() / width;
    let at = |dx: isize, dy: isize| {
        let (x, y) = (column.checked_add_signed(dx)?, row.checked_add_signed(dy)?);
        (x < width && y < n_rows).then(|| y * width + x)
    };
    let sides = [[-1, 0], [1, 0], [0, -1], [0, 1]].map(|[dx, dy]| at(dx, dy));
    let [left, right, down, up] = sides.map(|side| side.is_some_and(passes));
    let corners = [
        at(-1, -1).filter(|_| left || down),
        at(1, -1).filter(|_| right || down),
        at(-1, 1).filter(|_| left || up),
        at(1, 1).filter(|_| right || up),
    ];
    let sides = sides.into_iter().flatten().map(|next| (next, SIDE));
    sides.chain(corners.into_iter().flatten().map(|next| (next, CORNER)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Growth, REACHED};
    use proptest::prelude::*;

    fn runs(width: usize, cells: impl Iterator<Item = usize>) -> Vec<Run> {
        cells
            .map(|cell| {
                let (row, start) = ((cell / width) as u32, (cell % width) as u32);
                Run { row, start, end: start + 1 }
            })
            .collect()
    }

    #[test]
    fn a_cell_belongs_to_the_nearest_seed_and_of_two_to_the_lowest() {
        let whole = CellRect::whole(7, 1);
        let (left, right) = (runs(7, 0..1), runs(7, 6..7));
        let seeds = [(9, left.as_slice()), (4, right.as_slice())];
        let found = grow_labelled(whole, |_| true, seeds.into_iter(), fifths_of(5.0));
        let labels: Vec<_> = found.iter().map(|seed| seed.map(|seed| (seed.label, seed.fifths / 5))).collect();
        let expected = [(9, 0), (9, 1), (9, 2), (4, 3), (4, 2), (4, 1), (4, 0)].map(Some);
        assert_eq!(labels, expected);
    }

    proptest! {
        #[test]
        fn what_is_reached_is_what_growth_reaches(
            (width, cells) in (1usize..9, prop::collection::vec(0u8..4, 1..80)).prop_map(|(width, mut cells)| {
                cells.resize(cells.len().next_multiple_of(width), 0);
                (width, cells)
            }),
            reach in 1u32..6,
        ) {
            // Bit 0 is a seed, bit 1 is open.
            let whole = CellRect::whole(width as u32, (cells.len() / width) as u32);
            let seeds = runs(width, (0..cells.len()).filter(|cell| cells[*cell] & 1 != 0));
            let reach_fifths = fifths_of(f64::from(reach));
            let found = grow_labelled(whole, |c| cells[c] & 2 != 0, [(0, seeds.as_slice())].into_iter(), reach_fifths);
            let mut growth = Growth::default();
            growth.load(width, cells.chunks(width), |cell| cell);
            growth.grow(1, 2, f64::from(reach));
            for ((grown, &cell), found) in growth.rows().flatten().zip(&cells).zip(found) {
                let expected = grown & REACHED != 0 || cell == 3;
                prop_assert_eq!(found.is_some(), expected);
            }
        }
    }
}
