//! Cells of a map as polygons along the borders of cells.

use geometry::{FillRule, Ring, simple_parts, union};
use grid::{GridSpec, Run};
use std::collections::BTreeMap;

/// The cells of each label as simple polygons, counter-clockwise, that overlap nowhere.
pub(super) fn areas<L: Ord + Copy>(
    spec: &GridSpec,
    label: impl Fn(usize) -> Option<L>,
) -> impl Iterator<Item = (L, Vec<Ring>)> {
    let mut runs: BTreeMap<L, Vec<Run>> = BTreeMap::new();
    for row in 0..spec.height {
        let first = row as usize * spec.width as usize;
        let labels: Vec<Option<L>> = (first..first + spec.width as usize).map(&label).collect();
        let mut start = 0;
        for alike in labels.chunk_by(|a, b| a == b) {
            let end = start + alike.len() as u32;
            if let Some(label) = alike[0] {
                runs.entry(label).or_default().push(Run { row, start, end });
            }
            start = end;
        }
    }
    runs.into_iter().map(|(label, runs)| (label, simple_parts(&union(&blocks(spec, &runs), FillRule::NonZero))))
}

/// Rectangles of runs, in which those are joined that lie on one another and are as wide: the union has less to do.
fn blocks(spec: &GridSpec, runs: &[Run]) -> Vec<Ring> {
    let mut blocks: Vec<(Run, u32)> = Vec::new();
    let mut open: BTreeMap<(u32, u32), usize> = BTreeMap::new();
    for run in runs {
        let next = blocks.len();
        let block = open.entry((run.start, run.end)).or_insert(next);
        match blocks.get_mut(*block).filter(|(_, end)| *end == run.row) {
            Some((_, end)) => *end += 1,
            None => {
                *block = next;
                blocks.push((*run, run.row + 1));
            }
        }
    }
    blocks.iter().map(|(run, end)| rectangle(spec, [run.start, run.row], [run.end, *end])).collect()
}

/// The rectangle from a cell to before another one.
pub(super) fn rectangle(spec: &GridSpec, from: [u32; 2], to: [u32; 2]) -> Ring {
    let place = |cell: [u32; 2]| [0, 1].map(|k| (spec.first_cell[k] + cell[k] as i32) * spec.cell_tenths);
    let ([left, low], [right, high]) = (place(from), place(to));
    vec![[left, low], [right, low], [right, high], [left, high]]
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::ring_area_doubled;

    #[test]
    fn cells_are_covered_along_their_borders() {
        let spec = GridSpec { cell_tenths: 500, first_cell: [-2, 3], width: 5, height: 4 };
        let rows = ["..##.", ".###.", ".###.", "#...."];
        let is_in = |cell: usize| rows[3 - cell / 5].as_bytes()[cell % 5] == b'#';
        let mut found: Vec<Ring> =
            areas(&spec, |cell| is_in(cell).then_some(())).flat_map(|(_, rings)| rings).collect();
        found.sort_unstable_by_key(|ring| ring.iter().min().copied());
        assert_eq!(found.len(), 2, "cells that meet in a corner alone are two polygons");
        assert_eq!(ring_area_doubled(&found[0]), 2 * 500 * 500);
        assert_eq!(ring_area_doubled(&found[1]), 2 * 8 * 500 * 500);
        let mut corners = found[1].clone();
        corners.sort_unstable();
        assert_eq!(corners, [[-500, 2000], [-500, 3000], [0, 3000], [0, 3500], [1000, 2000], [1000, 3500]]);
    }
}
