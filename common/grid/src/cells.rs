//! Cell masks: hole filling, enclosure, connected components.

use crate::Run;
use std::collections::VecDeque;

/// A boolean per cell, row-major.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Mask {
    /// Columns.
    pub width: usize,
    /// One per cell.
    pub cells: Vec<bool>,
}

impl Mask {
    /// A mask with all cells false.
    pub fn new(width: usize, height: usize) -> Self {
        Self { width, cells: vec![false; width * height] }
    }

    /// Rows.
    pub fn height(&self) -> usize {
        self.cells.len().checked_div(self.width).unwrap_or(0)
    }

    /// Sets the cells of the runs.
    pub fn set_runs(&mut self, runs: &[Run]) {
        for run in runs {
            let row = run.row as usize * self.width;
            self.cells[row + run.start as usize..row + run.end as usize].fill(true);
        }
    }

    /// Clears the cells of runs.
    pub fn clear_runs(&mut self, runs: &[Run]) {
        for run in runs {
            let row = run.row as usize * self.width;
            self.cells[row + run.start as usize..row + run.end as usize].fill(false);
        }
    }

    /// Sets the cells that are set in `other`.
    pub fn set_all(&mut self, other: &Self) {
        for (cell, &on) in self.cells.iter_mut().zip(&other.cells) {
            *cell |= on;
        }
    }

    /// True if no cell is set.
    pub fn is_empty(&self) -> bool {
        !self.cells.contains(&true)
    }

    /// Number of cells that are set.
    pub fn count(&self) -> usize {
        self.cells.iter().filter(|&&on| on).count()
    }
}

/// Indices of the up to four neighbours that share a side.
pub(crate) fn neighbours4(index: usize, width: usize, n_cells: usize) -> impl Iterator<Item = usize> + use<> {
    let column = index % width;
    [
        (column > 0).then(|| index - 1),
        (column + 1 < width).then(|| index + 1),
        (index >= width).then(|| index - width),
        (index + width < n_cells).then(|| index + width),
    ]
    .into_iter()
    .flatten()
}

/// The mask with holes filled: unset cells that are not 4-connected with the border through unset cells.
pub fn fill_holes(solid: &Mask) -> Mask {
    let (width, height) = (solid.width, solid.height());
    // Cells reached from the border are set; cells that stay unset at the end are holes.
    let mut reached = solid.clone();
    let mut seeds: Vec<usize> = Vec::new();
    for row in 0..height {
        let at_end = row == 0 || row + 1 == height;
        let columns = (0..width).filter(|c| at_end || *c == 0 || c + 1 == width);
        seeds.extend(columns.map(|c| row * width + c));
    }
    while let Some(seed) = seeds.pop() {
        if reached.cells[seed] {
            continue;
        }
        let row = seed / width * width;
        let start = (row..seed).rev().find(|&i| reached.cells[i]).map_or(row, |i| i + 1);
        let end = (seed..row + width).find(|&i| reached.cells[i]).unwrap_or(row + width);
        reached.cells[start..end].fill(true);
        // One seed for every stretch of unset cells above and below.
        let beside = [row.checked_sub(width), (row + width < reached.cells.len()).then_some(row + width)];
        for other in beside.into_iter().flatten() {
            let first = other + start - row;
            // One begins behind a cell that is reached, or at the first.
            let mut begins = true;
            for (k, &is_reached) in reached.cells[first..other + end - row].iter().enumerate() {
                if begins && !is_reached {
                    seeds.push(first + k);
                }
                begins = is_reached;
            }
        }
    }
    let cells = reached.cells.iter().zip(&solid.cells).map(|(&reached, &solid)| solid || !reached).collect();
    Mask { width, cells }
}

/// Labels the 4-connected regions of set cells: (label per cell, 0 for unset; number of labels).
///
/// Labels are in the order of each region's first cell.
pub fn label_components(mask: &Mask) -> (Vec<u32>, u32) {
    let mut labels = vec![0u32; mask.cells.len()];
    let mut n_labels = 0;
    let mut queue = VecDeque::new();
    for start in 0..mask.cells.len() {
        if !mask.cells[start] || labels[start] != 0 {
            continue;
        }
        n_labels += 1;
        labels[start] = n_labels;
        queue.push_back(start);
        while let Some(index) = queue.pop_front() {
            for next in neighbours4(index, mask.width, mask.cells.len()) {
                if mask.cells[next] && labels[next] == 0 {
                    labels[next] = n_labels;
                    queue.push_back(next);
                }
            }
        }
    }
    (labels, n_labels)
}

/// The cells enclosed by obstacles, obstacles included, with gaps up to `gap_cells` between them closed.
pub fn enclosed(obstacles: &Mask, gap_cells: usize) -> Mask {
    let reach = gap_cells.div_ceil(2);
    let pad = 2 * reach + 1;
    let (width, height) = (obstacles.width, obstacles.height());
    let mut padded = Mask::new(width + 2 * pad, height + 2 * pad);
    for row in 0..height {
        let from = (row + pad) * padded.width + pad;
        padded.cells[from..from + width].copy_from_slice(&obstacles.cells[row * width..(row + 1) * width]);
    }
    let mut closed = fill_holes(&grown_square(&padded, reach));
    closed.cells.iter_mut().for_each(|c| *c = !*c);
    let outside = grown_square(&closed, reach);
    let mut out = Mask::new(width, height);
    for row in 0..height {
        for column in 0..width {
            out.cells[row * width + column] = !outside.cells[(row + pad) * outside.width + column + pad];
        }
    }
    out
}

/// The mask dilated by a square of `reach` cells to each side. Linear in cells, independent of the reach.
fn grown_square(mask: &Mask, reach: usize) -> Mask {
    let (width, height) = (mask.width, mask.height());
    let mut out = mask.clone();
    // True within reach after the last set cell.
    let spread = |since: &mut usize, on: bool| {
        *since = if on { 0 } else { since.saturating_add(1) };
        *since <= reach
    };
    for (from, to) in mask.cells.chunks_exact(width.max(1)).zip(out.cells.chunks_exact_mut(width.max(1))) {
        let (mut forward, mut backward) = (usize::MAX, usize::MAX);
        for column in 0..width {
            to[column] |= spread(&mut forward, from[column]);
            let mirrored = width - 1 - column;
            to[mirrored] |= spread(&mut backward, from[mirrored]);
        }
    }
    let rows = out.cells.clone();
    let (mut up, mut down) = (vec![usize::MAX; width], vec![usize::MAX; width]);
    for row in 0..height {
        let (from_below, from_above) = (row * width, (height - 1 - row) * width);
        for column in 0..width {
            out.cells[from_below + column] |= spread(&mut up[column], rows[from_below + column]);
            out.cells[from_above + column] |= spread(&mut down[column], rows[from_above + column]);
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A mask from text, `#` is on; first line is the top row.
    fn mask(text: &str) -> Mask {
        let rows: Vec<&str> = text.split_whitespace().collect();
        Mask { width: rows[0].len(), cells: rows.iter().rev().flat_map(|r| r.bytes().map(|b| b == b'#')).collect() }
    }

    #[test]
    fn a_hole_is_filled_and_a_bay_is_not() {
        assert_eq!(fill_holes(&mask("##### #...# ##### #...# #.###")), mask("##### ##### ##### #...# #.###"));
    }

    #[test]
    fn components_are_joined_by_sides_only() {
        let (labels, n) = label_components(&mask("#.# ##. ..#"));
        assert_eq!(n, 3);
        assert_eq!(labels, [0, 0, 1, 2, 2, 0, 2, 0, 3]);
    }

    #[test]
    fn a_square_grows_by_its_reach_to_all_sides() {
        assert_eq!(grown_square(&mask("..... ..... ..#.. ..... #...."), 1), mask("..... .###. .###. ####. ##..."));
    }

    #[test]
    fn an_enclosed_room_keeps_its_door_gap_closed() {
        let room = mask("........ .######. .#....#. .#...... .#....#. .######. ........");
        let inside = enclosed(&room, 1);
        assert!(inside.cells[2 * 8 + 3], "the middle of the room");
        assert!(!inside.cells[0], "the corner outside");
    }
}
