//! Growing regions of cells through others, without leaking through walls.

use crate::Mask;

const THROUGH: u8 = 1;
const SEED: u8 = 2;
const REACHED: u8 = 4;

/// Cost of a step along a side, and across a corner.
const SIDE: u32 = 5;
const CORNER: u32 = 7;

/// Grows regions again and again in memory that it keeps: after the largest grid it allocates no more.
#[derive(Debug, Default)]
pub struct Growth {
    /// The cells with a rim of one cell around them, so that every cell has eight neighbours.
    cells: Vec<u8>,
    cost: Vec<u32>,
    /// Places by cost.
    buckets: Vec<Vec<u32>>,
    front: Vec<bool>,
}

impl Growth {
    /// Switches on in `grown` the cells of `through` within `reach_cells` of `seeds`, measured along paths that stay in
    /// `through`. All are row-major with `width` columns.
    ///
    /// Seeds need not lie in `through` and are not part of the answer. Steps cost 1 along a side and 7/5 across a corner;
    /// a corner between two cells that are neither seeds nor in `through` is closed, so that growth never leaks through a
    /// diagonal wall. What is decided about a cell depends on cells at most `reach_cells` columns and rows away.
    pub fn grow(&mut self, width: usize, seeds: &[bool], through: &[bool], reach_cells: f64, grown: &mut [bool]) {
        let limit = (reach_cells * f64::from(SIDE)).floor().max(0.0) as u32;
        if limit < SIDE || !seeds.contains(&true) || !through.contains(&true) {
            return;
        }
        let padded = width + 2;
        self.take(width, seeds, through);
        self.buckets.iter_mut().for_each(Vec::clear);
        if self.buckets.len() <= limit as usize {
            self.buckets.resize_with(limit as usize + 1, Vec::new);
        }
        self.find_front(padded);
        if self.buckets[0].is_empty() {
            return;
        }
        self.cost.clear();
        self.cost.resize(self.cells.len(), u32::MAX);
        for &place in &self.buckets[0] {
            self.cost[place as usize] = 0;
        }
        for now in 0..=limit - SIDE {
            let mut at = 0;
            while let Some(&place) = self.buckets[now as usize].get(at) {
                at += 1;
                if self.cost[place as usize] == now {
                    self.step(place as usize, padded, now, limit);
                }
            }
        }
        let rows = self.cells.chunks_exact(padded).skip(1);
        for (row, grown) in rows.zip(grown.chunks_exact_mut(width)) {
            for (grown, cell) in grown.iter_mut().zip(&row[1..=width]) {
                *grown |= cell & (REACHED | SEED) == REACHED;
            }
        }
    }

    fn take(&mut self, width: usize, seeds: &[bool], through: &[bool]) {
        let (padded, height) = (width + 2, seeds.len() / width);
        self.cells.clear();
        self.cells.resize(padded * (height + 2), 0);
        let rows = self.cells.chunks_exact_mut(padded).skip(1);
        for ((row, seeds), through) in rows.zip(seeds.chunks_exact(width)).zip(through.chunks_exact(width)) {
            for ((cell, &seed), &through) in row[1..=width].iter_mut().zip(seeds).zip(through) {
                *cell = (u8::from(through) * THROUGH) | (u8::from(seed) * SEED);
            }
        }
    }

    /// Seeds with a neighbour to grow into.
    fn find_front(&mut self, padded: usize) {
        let cells = &self.cells;
        let is_target = |cell: u8| cell == THROUGH;
        self.front.resize(padded, false);
        for row in (padded..cells.len() - padded).step_by(padded) {
            let (below, here, above) = (&cells[row - padded..row], &cells[row..row + padded], &cells[row + padded..]);
            let mut any = false;
            for k in 1..padded - 1 {
                let beside = is_target(below[k - 1])
                    | is_target(below[k])
                    | is_target(below[k + 1])
                    | is_target(here[k - 1])
                    | is_target(here[k + 1])
                    | is_target(above[k - 1])
                    | is_target(above[k])
                    | is_target(above[k + 1]);
                self.front[k] = beside & (here[k] & SEED != 0);
                any |= self.front[k];
            }
            if any {
                let on = self.front[..padded - 1].iter().enumerate().skip(1).filter(|(_, on)| **on);
                self.buckets[0].extend(on.map(|(k, _)| (row + k) as u32));
            }
        }
    }

    /// Goes on from a cell that is reached at cost `now`.
    fn step(&mut self, place: usize, padded: usize, now: u32, limit: u32) {
        let open = |cell: u8| cell & (THROUGH | SEED) != 0;
        let [left, right, down, up] = [place - 1, place + 1, place - padded, place + padded];
        for next in [left, right, down, up] {
            self.reach(next, now + SIDE);
        }
        if now + CORNER > limit {
            return;
        }
        let [l, r, d, u] = [left, right, down, up].map(|side| open(self.cells[side]));
        for (next, is_open) in [(down - 1, d | l), (down + 1, d | r), (up - 1, u | l), (up + 1, u | r)] {
            if is_open {
                self.reach(next, now + CORNER);
            }
        }
    }

    fn reach(&mut self, next: usize, cost: u32) {
        // Seeds in `through` begin at no cost, whether or not they are in front.
        if self.cells[next] & (THROUGH | SEED) == THROUGH && cost < self.cost[next] {
            self.cost[next] = cost;
            self.cells[next] |= REACHED;
            self.buckets[cost as usize].push(next as u32);
        }
    }
}

/// The cells of `through` within `reach_cells` of `seeds`: see [`Growth::grow`].
pub fn grow_through(seeds: &Mask, through: &Mask, reach_cells: f64) -> Mask {
    let mut grown = Mask { width: seeds.width, cells: vec![false; seeds.cells.len()] };
    if seeds.width > 0 {
        Growth::default().grow(seeds.width, &seeds.cells, &through.cells, reach_cells, &mut grown.cells);
    }
    grown
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// A mask from text, `#` is on; first line is the top row.
    fn mask(text: &str) -> Mask {
        let rows: Vec<&str> = text.split_whitespace().collect();
        Mask { width: rows[0].len(), cells: rows.iter().rev().flat_map(|r| r.bytes().map(|b| b == b'#')).collect() }
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

    /// The same by asking every cell again and again until nothing changes.
    fn slowly(seeds: &Mask, through: &Mask, limit: u32) -> Mask {
        let (width, height) = (seeds.width as i64, seeds.height() as i64);
        let at = |x: i64, y: i64| (0 <= x && x < width && 0 <= y && y < height).then(|| (y * width + x) as usize);
        let mut cost: Vec<u32> = seeds.cells.iter().map(|&s| if s { 0 } else { u32::MAX }).collect();
        let open = |i: Option<usize>| i.is_some_and(|i| through.cells[i] || seeds.cells[i]);
        loop {
            let before = cost.clone();
            for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
                let Some(here) = at(x, y).filter(|&i| through.cells[i]) else { continue };
                for (dx, dy) in (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| (dx, dy))) {
                    let Some(from) = at(x + dx, y + dy).filter(|&i| before[i] < u32::MAX) else { continue };
                    let diagonal = dx != 0 && dy != 0;
                    let passes = !diagonal || open(at(x + dx, y)) || open(at(x, y + dy));
                    let then = before[from] + if diagonal { CORNER } else { SIDE };
                    if passes && then <= limit {
                        cost[here] = cost[here].min(then);
                    }
                }
            }
            if cost == before {
                break;
            }
        }
        let cells = cost.iter().zip(&seeds.cells).map(|(&c, &s)| c < u32::MAX && !s).collect();
        Mask { width: seeds.width, cells }
    }

    proptest! {
        #[test]
        fn growth_is_what_the_slow_way_gives_also_in_memory_that_was_used(
            width in 1usize..9,
            cells in prop::collection::vec((prop::bool::weighted(0.15), prop::bool::weighted(0.6)), 1..70),
            reach in 0.0f64..6.0,
        ) {
            let n = cells.len() / width * width;
            prop_assume!(n > 0);
            let seeds = Mask { width, cells: cells[..n].iter().map(|c| c.0).collect() };
            let through = Mask { width, cells: cells[..n].iter().map(|c| c.1).collect() };
            let wanted = slowly(&seeds, &through, (reach * 5.0).floor() as u32);
            let mut growth = Growth::default();
            let mut before = vec![false; 400];
            growth.grow(20, &[true; 400], &[true; 400], 9.0, &mut before);
            growth.grow(20, &std::array::from_fn::<_, 400, _>(|k| k == 7), &[true; 400], 9.0, &mut before);
            let mut grown = vec![false; n];
            growth.grow(width, &seeds.cells, &through.cells, reach, &mut grown);
            prop_assert_eq!(grown, wanted.cells);
        }
    }
}
