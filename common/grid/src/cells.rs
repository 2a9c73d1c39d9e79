//! Regions of cells: filling, growing, labelling.

use crate::Run;
use std::collections::VecDeque;

/// A yes or no for every cell, row-major.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Mask {
    /// Columns.
    pub width: usize,
    /// One per cell.
    pub cells: Vec<bool>,
}

impl Mask {
    /// A mask with all cells off.
    pub fn new(width: usize, height: usize) -> Self {
        Self { width, cells: vec![false; width * height] }
    }

    /// Rows.
    pub fn height(&self) -> usize {
        self.cells.len().checked_div(self.width).unwrap_or(0)
    }

    /// Switches the cells of the runs on.
    pub fn set_runs(&mut self, runs: &[Run]) {
        for run in runs {
            let row = run.row as usize * self.width;
            self.cells[row + run.start as usize..row + run.end as usize].fill(true);
        }
    }

    /// Switches on what is on in `other`.
    pub fn set_all(&mut self, other: &Self) {
        for (cell, &on) in self.cells.iter_mut().zip(&other.cells) {
            *cell |= on;
        }
    }

    /// True if no cell is on.
    pub fn is_empty(&self) -> bool {
        !self.cells.contains(&true)
    }

    /// Number of cells that are on.
    pub fn count(&self) -> usize {
        self.cells.iter().filter(|&&on| on).count()
    }
}

/// Places of the up to four neighbours that share a side.
fn neighbours4(index: usize, width: usize, n_cells: usize) -> impl Iterator<Item = usize> {
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

/// The mask with its holes filled: cells that no path of side neighbours that are off joins to the border.
pub fn fill_holes(solid: &Mask) -> Mask {
    let (width, height) = (solid.width, solid.height());
    let mut outside = vec![false; solid.cells.len()];
    let mut queue = VecDeque::new();
    let border = (0..width)
        .flat_map(|c| [c, (height.max(1) - 1) * width + c])
        .chain((0..height).flat_map(|r| [r * width, r * width + width - 1]));
    let reach = |index: usize, outside: &mut Vec<bool>, queue: &mut VecDeque<usize>| {
        if !solid.cells[index] && !outside[index] {
            outside[index] = true;
            queue.push_back(index);
        }
    };
    if !solid.cells.is_empty() {
        border.for_each(|index| reach(index, &mut outside, &mut queue));
    }
    while let Some(index) = queue.pop_front() {
        for next in neighbours4(index, width, solid.cells.len()) {
            reach(next, &mut outside, &mut queue);
        }
    }
    Mask { width, cells: outside.into_iter().map(|o| !o).collect() }
}

/// The cells of `through` within `reach_cells` of `seeds`, measured along paths that stay in `through`.
///
/// Seeds need not lie in `through` and are not part of the answer. Steps cost 1 along a side and 7/5 across a corner;
/// a corner between two cells outside `through` is closed, so that growth never leaks through a diagonal wall.
pub fn grow_through(seeds: &Mask, through: &Mask, reach_cells: f64) -> Mask {
    let (width, n) = (seeds.width, seeds.cells.len());
    let limit = (reach_cells * 5.0).floor().max(0.0) as u32;
    let mut cost = vec![u32::MAX; n];
    // A bucket per cost: steps are at most 7.
    let mut buckets: Vec<Vec<usize>> = vec![Vec::new(); limit as usize + 1];
    for (index, _) in seeds.cells.iter().enumerate().filter(|(_, on)| **on) {
        cost[index] = 0;
        if neighbours8(index, width, n).any(|(next, _)| through.cells[next] && !seeds.cells[next]) {
            buckets[0].push(index);
        }
    }
    let mut grown = Mask { width, cells: vec![false; n] };
    for now in 0..=limit {
        let mut at = 0;
        while at < buckets[now as usize].len() {
            let index = buckets[now as usize][at];
            at += 1;
            if cost[index] != now {
                continue;
            }
            for (next, diagonal) in neighbours8(index, width, n) {
                let corner_open =
                    diagonal.is_none_or(|sides| sides.iter().any(|&s| through.cells[s] || seeds.cells[s]));
                let then = now + if diagonal.is_some() { 7 } else { 5 };
                if through.cells[next] && corner_open && then <= limit && then < cost[next] {
                    cost[next] = then;
                    grown.cells[next] = !seeds.cells[next];
                    buckets[then as usize].push(next);
                }
            }
        }
    }
    grown
}

/// The up to eight neighbours; for those across a corner, the two cells beside that corner.
fn neighbours8(index: usize, width: usize, n_cells: usize) -> impl Iterator<Item = (usize, Option<[usize; 2]>)> {
    let (column, row, height) = ((index % width) as i64, (index / width) as i64, (n_cells / width) as i64);
    let width = width as i64;
    (-1..=1).flat_map(move |dy| (-1..=1).map(move |dx| (dx, dy))).filter_map(move |(dx, dy): (i64, i64)| {
        let (c, r) = (column + dx, row + dy);
        let inside = 0 <= c && c < width && 0 <= r && r < height && (dx, dy) != (0, 0);
        let at = |c: i64, r: i64| (r * width + c) as usize;
        inside.then(|| (at(c, r), (dx != 0 && dy != 0).then(|| [at(c, row), at(column, r)])))
    })
}

/// Labels the connected regions (by sides) of cells that are on: (label per cell, 0 for off; number of labels).
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

/// What obstacles enclose, themselves included, once gaps up to `gap_cells` between them are closed.
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

/// The mask grown by a square of `reach` cells to each side.
fn grown_square(mask: &Mask, reach: usize) -> Mask {
    let (width, height) = (mask.width, mask.height());
    let mut rows = Mask::new(width, height);
    for (from, to) in mask.cells.chunks_exact(width.max(1)).zip(rows.cells.chunks_exact_mut(width.max(1))) {
        for (c, _) in from.iter().enumerate().filter(|(_, on)| **on) {
            to[c.saturating_sub(reach)..(c + reach + 1).min(width)].fill(true);
        }
    }
    let mut out = Mask::new(width, height);
    for row in 0..height {
        for near in row.saturating_sub(reach)..(row + reach + 1).min(height) {
            for column in 0..width {
                out.cells[row * width + column] |= rows.cells[near * width + column];
            }
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
    fn growth_goes_through_the_door_and_not_through_the_wall() {
        let through = mask("....... ###.### ....... .......");
        let seeds = mask("....... ....... ....... ...#...");
        let free = Mask { width: 7, cells: through.cells.iter().map(|c| !c).collect() };
        let grown = grow_through(&seeds, &free, 3.0);
        assert_eq!(grown, mask("...#... ...#... .#####. ###.###"));
    }

    #[test]
    fn growth_does_not_leak_between_diagonal_cells() {
        let free = mask(".# #.");
        assert_eq!(grow_through(&mask(".. #."), &free, 5.0).count(), 0);
    }

    #[test]
    fn components_are_joined_by_sides_only() {
        let (labels, n) = label_components(&mask("#.# ##. ..#"));
        assert_eq!(n, 3);
        assert_eq!(labels, [0, 0, 1, 2, 2, 0, 2, 0, 3]);
    }

    #[test]
    fn an_enclosed_room_keeps_its_door_gap_closed() {
        let room = mask("........ .######. .#....#. .#...... .#....#. .######. ........");
        let inside = enclosed(&room, 1);
        assert!(inside.cells[2 * 8 + 3], "the middle of the room");
        assert!(!inside.cells[0], "the corner outside");
    }
}
