//! Growing regions of cells through others, without leaking through walls.

/// Set by [`Growth::grow`]; the other seven bits of a cell are the caller's regions.
pub const REACHED: u8 = 128;

/// Cost of a step along a side, and across a corner.
const SIDE: u16 = 5;
const CORNER: u16 = 7;

/// The farthest that a region can grow, in cells.
pub const MAX_REACH_CELLS: f64 = ((u16::MAX - CORNER) / SIDE) as f64;

/// Grows regions again and again in memory that it keeps: after the largest window it allocates no more.
#[derive(Debug, Default)]
pub struct Growth {
    width: usize,
    /// The cells with a rim of one cell around them, so that every cell has eight neighbours.
    cells: Vec<u8>,
    cost: Vec<u16>,
    /// Places by cost.
    buckets: Vec<Vec<u32>>,
    /// Of one row: whether a cell or those above and below are a target, and whether it is a seed beside one.
    column: Vec<u8>,
    front: Vec<u8>,
}

impl Growth {
    /// Takes a window: rows of `width` cells from the lowest on, and the regions that each cell belongs to, as bits.
    pub fn load<'a, T: Copy + 'a>(
        &mut self,
        width: usize,
        rows: impl Iterator<Item = &'a [T]>,
        regions: impl Fn(T) -> u8,
    ) {
        let padded = width + 2;
        self.width = width;
        self.cells.clear();
        self.cells.resize(padded, 0);
        for row in rows {
            self.cells.push(0);
            self.cells.extend(row.iter().map(|&cell| regions(cell)));
            self.cells.push(0);
        }
        self.cells.resize(self.cells.len() + padded, 0);
    }

    /// Marks as [`REACHED`] the cells of one region, and not of the other, within `reach_cells` of the other, measured along
    /// paths that stay in `through`. `seeds` and `through` are bits of regions.
    ///
    /// Steps cost 1 along a side and 7/5 across a corner; a corner between two cells of neither region is closed, so that
    /// growth never leaks through a diagonal wall. What is decided about a cell depends on cells at most `reach_cells` columns
    /// and rows away. Marks of earlier calls stay. A reach beyond [`MAX_REACH_CELLS`] is that.
    pub fn grow(&mut self, seeds: u8, through: u8, reach_cells: f64) {
        let limit = (reach_cells.clamp(0.0, MAX_REACH_CELLS) * f64::from(SIDE)).floor() as u16;
        if limit < SIDE {
            return;
        }
        self.buckets.iter_mut().for_each(Vec::clear);
        if self.buckets.len() <= usize::from(limit) {
            self.buckets.resize_with(usize::from(limit) + 1, Vec::new);
        }
        self.find_front(seeds, through);
        if self.buckets[0].is_empty() {
            return;
        }
        self.cost.clear();
        self.cost.resize(self.cells.len(), u16::MAX);
        for now in 0..=limit - SIDE {
            let mut at = 0;
            while let Some(&place) = self.buckets[usize::from(now)].get(at) {
                at += 1;
                // A seed has no cost; a cell that was reached in a cheaper way since has gone on already.
                if now == 0 || self.cost[place as usize] == now {
                    self.step(place as usize, [seeds, through], now, limit);
                }
            }
        }
    }

    /// The rows of the window, with marks.
    pub fn rows(&self) -> impl Iterator<Item = &[u8]> {
        let inner = self.cells.len() / (self.width + 2) - 2;
        self.cells.chunks_exact(self.width + 2).skip(1).take(inner).map(|row| &row[1..row.len() - 1])
    }

    /// Seeds with a neighbour to grow into. Written so that the compiler takes many cells at once.
    fn find_front(&mut self, seeds: u8, through: u8) {
        let padded = self.width + 2;
        let Self { cells, buckets, column, front, .. } = self;
        let target = |cell: u8| u8::from(cell & (seeds | through) == through);
        column.resize(padded, 0);
        front.resize(self.width, 0);
        for row in (padded..cells.len() - padded).step_by(padded) {
            let below = &cells[row - padded..row];
            let (here, above) = (&cells[row..row + padded], &cells[row + padded..row + 2 * padded]);
            if here.iter().fold(0, |all, cell| all | cell) & seeds == 0 {
                continue;
            }
            // A seed is no target, so a cell itself may be counted among those around it.
            for (((column, &below), &here), &above) in column.iter_mut().zip(below).zip(here).zip(above) {
                *column = target(below) | target(here) | target(above);
            }
            let beside = column.iter().zip(&column[1..]).zip(&column[2..]);
            let mut any = 0;
            for ((front, &here), ((&left, &middle), &right)) in front.iter_mut().zip(&here[1..]).zip(beside) {
                *front = (left | middle | right) & u8::from(here & seeds != 0);
                any |= *front;
            }
            if any != 0 {
                let on = front.iter().enumerate().filter(|(_, on)| **on != 0);
                buckets[0].extend(on.map(|(k, _)| (row + k + 1) as u32));
            }
        }
    }

    /// Goes on from a cell that is reached at cost `now`.
    fn step(&mut self, place: usize, [seeds, through]: [u8; 2], now: u16, limit: u16) {
        let padded = self.width + 2;
        let [left, right, down, up] = [place - 1, place + 1, place - padded, place + padded];
        for next in [left, right, down, up] {
            self.reach(next, [seeds, through], now + SIDE);
        }
        if now + CORNER > limit {
            return;
        }
        let [l, r, d, u] = [left, right, down, up].map(|side| self.cells[side] & (seeds | through) != 0);
        for (next, is_open) in [(down - 1, d | l), (down + 1, d | r), (up - 1, u | l), (up + 1, u | r)] {
            if is_open {
                self.reach(next, [seeds, through], now + CORNER);
            }
        }
    }

    fn reach(&mut self, next: usize, [seeds, through]: [u8; 2], cost: u16) {
        if self.cells[next] & (seeds | through) == through && cost < self.cost[next] {
            self.cost[next] = cost;
            self.cells[next] |= REACHED;
            self.buckets[usize::from(cost)].push(next as u32);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Mask;
    use proptest::prelude::*;

    const SEED: u8 = 1;
    const THROUGH: u8 = 2;

    fn grow(growth: &mut Growth, seeds: &Mask, through: &Mask, reach_cells: f64) -> Mask {
        let both: Vec<(bool, bool)> = seeds.cells.iter().copied().zip(through.cells.iter().copied()).collect();
        growth.load(seeds.width, both.chunks(seeds.width), |(seed, through)| {
            u8::from(seed) * SEED + u8::from(through) * THROUGH
        });
        growth.grow(SEED, THROUGH, reach_cells);
        let cells = growth.rows().flatten().map(|cell| cell & REACHED != 0).collect();
        Mask { width: seeds.width, cells }
    }

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
        let grown = grow(&mut Growth::default(), &seeds, &free, 3.0);
        assert_eq!(grown, mask("...#... ...#... .#####. ###.###"));
    }

    #[test]
    fn growth_does_not_leak_between_diagonal_cells() {
        let free = mask(".# #.");
        assert_eq!(grow(&mut Growth::default(), &mask(".. #."), &free, 5.0).count(), 0);
    }

    /// The same by asking every cell again and again until nothing changes.
    fn slowly(seeds: &Mask, through: &Mask, limit: u16) -> Mask {
        let (width, height) = (seeds.width as i64, seeds.height() as i64);
        let at = |x: i64, y: i64| (0 <= x && x < width && 0 <= y && y < height).then(|| (y * width + x) as usize);
        let mut cost: Vec<u16> = seeds.cells.iter().map(|&s| if s { 0 } else { u16::MAX }).collect();
        let open = |i: Option<usize>| i.is_some_and(|i| through.cells[i] || seeds.cells[i]);
        loop {
            let before = cost.clone();
            for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
                let Some(here) = at(x, y).filter(|&i| through.cells[i]) else { continue };
                for (dx, dy) in (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| (dx, dy))) {
                    let Some(from) = at(x + dx, y + dy).filter(|&i| before[i] < u16::MAX) else { continue };
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
        let cells = cost.iter().zip(&seeds.cells).map(|(&c, &s)| c < u16::MAX && !s).collect();
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
            let mut growth = Growth::default();
            let large = Mask { width: 20, cells: vec![true; 400] };
            let one = Mask { width: 20, cells: (0..400).map(|k| k == 7).collect() };
            grow(&mut growth, &one, &large, 9.0);
            prop_assert_eq!(grow(&mut growth, &large, &large, 9.0).count(), 0);
            let grown = grow(&mut growth, &seeds, &through, reach);
            prop_assert_eq!(grown, slowly(&seeds, &through, (reach * 5.0).floor() as u16));
        }
    }
}
