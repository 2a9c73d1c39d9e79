//! Region growing through other regions, without leaking through walls.

/// Set by [`Growth::grow`]; the other seven bits of a cell are the caller's regions.
pub const REACHED: u8 = 128;

/// Cost of a step along a side, and across a corner.
pub(crate) const SIDE: u16 = 5;
pub(crate) const CORNER: u16 = 7;

/// Steps of column and row to the neighbours of a cell.
const DIRECTIONS: [[isize; 2]; 8] = [[1, 0], [-1, 0], [0, 1], [0, -1], [1, 1], [-1, 1], [1, -1], [-1, -1]];

/// Number of cells between the cell at 1 to `last` and the rim, in a direction.
fn room(at: usize, direction: isize, last: usize) -> usize {
    match direction {
        0 => usize::MAX,
        1.. => last - at,
        _ => at - 1,
    }
}

/// Maximum distance by which a region can grow, in cells.
pub const MAX_REACH_CELLS: f64 = ((u16::MAX - CORNER) / SIDE) as f64;

/// Grows regions in tiles. Buffers are reused: after the largest tile nothing is allocated.
#[derive(Debug, Default)]
pub struct Growth {
    width: usize,
    /// The cells with a rim of one cell around them, so that every cell has eight neighbours.
    cells: Vec<u8>,
    cost: Vec<u16>,
    /// Cells by cost.
    buckets: Vec<Vec<u32>>,
    /// Buffers of [`Self::find_beside`], for one row.
    column: Vec<u8>,
    front: Vec<u8>,
}

impl Growth {
    /// Loads a tile: rows of `width` cells from the lowest on, with the regions of each cell as bits.
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

    /// Marks as [`REACHED`] the cells of `through` that are not in `seeds`, within `reach_cells` of `seeds` along paths in
    /// `through`. Both are bits of regions.
    ///
    /// Steps cost 1 along a side and 7/5 across a corner; a corner between two cells of neither region is closed, so that
    /// growth never leaks through a diagonal wall. The result of a cell depends on cells at most `reach_cells` columns and
    /// rows away. Marks of earlier calls stay. A larger reach than [`MAX_REACH_CELLS`] is clamped.
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
                // A seed has no cost. A cell reached at a lower cost meanwhile was expanded already.
                if now == 0 || self.cost[place as usize] == now {
                    self.step(place as usize, [seeds, through], now, limit);
                }
            }
        }
    }

    /// Adds to `region` the cells of a gap: those on a straight line between a cell of `from` and one of `to`, along a row,
    /// a column or a diagonal, with at most `max_cells` cells of neither region between them, on a diagonal correspondingly
    /// fewer.
    ///
    /// Regions are bits, and `region` is none of the others. A diagonal step between two cells of `to` is closed, so that a gap never
    /// leads through a wall.
    pub fn bridge(&mut self, [from, to]: [u8; 2], region: u8, max_cells: usize) {
        let padded = self.width + 2;
        let n_rows = self.cells.len() / padded - 2;
        let max_on_diagonal = (max_cells * usize::from(SIDE)).div_ceil(usize::from(CORNER));
        for row in 1..=n_rows {
            // A gap begins with a cell of neither.
            if !self.find_beside(row * padded, |cell| cell & to != 0, |cell| cell & (from | to) == 0) {
                continue;
            }
            for column in 1..=self.width {
                if self.front[column - 1] == 0 {
                    continue;
                }
                for [dx, dy] in DIRECTIONS {
                    let room = room(column, dx, self.width).min(room(row, dy, n_rows));
                    let is_diagonal = dx != 0 && dy != 0;
                    let max_cells = if is_diagonal { max_on_diagonal } else { max_cells };
                    let line = [dx, dy * padded as isize + dx];
                    self.bridge_from(row * padded + column, line, [from, to, region], max_cells.min(room));
                }
            }
        }
    }

    /// The rows of the tile, with marks.
    pub fn rows(&self) -> impl Iterator<Item = &[u8]> {
        let inner = self.cells.len() / (self.width + 2) - 2;
        self.cells.chunks_exact(self.width + 2).skip(1).take(inner).map(|row| &row[1..row.len() - 1])
    }

    /// Finds seeds with a neighbour to grow into.
    fn find_front(&mut self, seeds: u8, through: u8) {
        let padded = self.width + 2;
        for row in (padded..self.cells.len() - padded).step_by(padded) {
            if self.find_beside(row, |cell| cell & seeds != 0, |cell| cell & (seeds | through) == through) {
                let on = self.front.iter().enumerate().filter(|(_, on)| **on != 0);
                self.buckets[0].extend(on.map(|(k, _)| (row + k + 1) as u32));
            }
        }
    }

    /// Sets `front` for the cells of a row that fit and have a neighbour among the targets, none of which fits itself; false if there
    /// are none. Written so that the compiler vectorises it.
    fn find_beside(&mut self, row: usize, fits: impl Fn(u8) -> bool, is_target: impl Fn(u8) -> bool) -> bool {
        let padded = self.width + 2;
        let Self { cells, column, front, .. } = self;
        let (below, here) = (&cells[row - padded..row], &cells[row..row + padded]);
        let above = &cells[row + padded..row + 2 * padded];
        if !here.iter().fold(false, |any, &cell| any | fits(cell)) {
            return false;
        }
        column.resize(padded, 0);
        front.resize(self.width, 0);
        // No target fits, so a cell may be counted among its own neighbours.
        for (((column, &below), &here), &above) in column.iter_mut().zip(below).zip(here).zip(above) {
            *column = u8::from(is_target(below) | is_target(here) | is_target(above));
        }
        let beside = column.iter().zip(&column[1..]).zip(&column[2..]);
        let mut any = 0;
        for ((front, &here), ((&left, &middle), &right)) in front.iter_mut().zip(&here[1..]).zip(beside) {
            *front = (left | middle | right) & u8::from(fits(here));
            any |= *front;
        }
        any != 0
    }

    /// Follows a line from a cell of `to` over at most `max_cells` cells of neither region, and marks them if a cell of
    /// `from` follows. A line is given by its steps of column and of index.
    fn bridge_from(&mut self, place: usize, [dx, step]: [isize; 2], [from, to, region]: [u8; 3], max_cells: usize) {
        let at = |n: usize| place.wrapping_add_signed(step * n as isize);
        let is_diagonal = dx != 0 && step != dx;
        for n in 0..=max_cells {
            let sides = [at(n).wrapping_add_signed(dx), at(n + 1).wrapping_add_signed(-dx)];
            if is_diagonal && sides.iter().all(|side| self.cells[*side] & to != 0) {
                return;
            }
            let next = self.cells[at(n + 1)];
            if next & to != 0 {
                return;
            }
            if next & from != 0 {
                (1..=n).for_each(|k| self.cells[at(k)] |= region);
                return;
            }
        }
    }

    /// Expands a cell that was reached at cost `now`.
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

    const GAP: u8 = 4;

    /// `f` is one region, `#` the other; `-` comes back for a gap between them.
    fn bridged(text: &str, max_cells: usize) -> String {
        let rows: Vec<&str> = text.split_whitespace().collect();
        let mut growth = Growth::default();
        growth.load(rows[0].len(), rows.iter().map(|r| r.as_bytes()), |cell| match cell {
            b'f' => SEED,
            b'#' => THROUGH,
            _ => 0,
        });
        growth.bridge([SEED, THROUGH], GAP, max_cells);
        let row =
            |cells: &[u8]| cells.iter().map(|cell| [".", "f", "#", "?", "-"][usize::from(*cell)]).collect::<String>();
        growth.rows().map(row).collect::<Vec<_>>().join(" ")
    }

    #[test]
    fn a_gap_is_bridged_if_it_is_narrow() {
        assert_eq!(bridged("ff..# ff..# ff.ff", 2), "ff--# ff--# ff.ff");
        assert_eq!(bridged("ff...# ff...#", 2), "ff...# ff...#");
        assert_eq!(bridged("f..... ...... ..#...", 1), "f..... .-.... ..#...", "along a diagonal");
        assert_eq!(bridged("f#.# f#.# f#.#", 2), "f#.# f#.# f#.#", "not behind a wall");
        assert_eq!(bridged("f.#. .#.. #..#", 3), "f-#. -#.. #..#", "nor through a diagonal one");
    }

    /// The same from the other side: every cell of `from` looks for one of `to`.
    fn bridged_slowly(cells: &[u8], width: usize, max_cells: usize) -> Vec<u8> {
        let at = |x: i32, y: i32| {
            let is_inside = 0 <= x && x < width as i32 && 0 <= y && y < (cells.len() / width) as i32;
            is_inside.then(|| y as usize * width + x as usize)
        };
        let is = |x: i32, y: i32, region: u8| at(x, y).is_some_and(|place| cells[place] & region != 0);
        let mut out = cells.to_vec();
        for place in (0..cells.len()).filter(|place| cells[*place] & SEED != 0) {
            let (x, y) = ((place % width) as i32, (place / width) as i32);
            for [dx, dy] in DIRECTIONS.map(|d| d.map(|c| c as i32)) {
                let most = if dx != 0 && dy != 0 { (max_cells * 5).div_ceil(7) } else { max_cells } as i32;
                let Some(n) = (1..=most + 1).find(|n| is(x + n * dx, y + n * dy, SEED | THROUGH)) else { continue };
                let is_closed = |k: i32| {
                    let (x, y) = (x + k * dx, y + k * dy);
                    dx != 0 && dy != 0 && is(x + dx, y, THROUGH) && is(x, y + dy, THROUGH)
                };
                if is(x + n * dx, y + n * dy, THROUGH) && !(0..n).any(is_closed) {
                    (1..n).filter_map(|k| at(x + k * dx, y + k * dy)).for_each(|gap| out[gap] |= GAP);
                }
            }
        }
        out
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
        fn gaps_are_the_same_from_both_sides(
            (width, cells) in (1usize..9, prop::collection::vec(prop::sample::select(vec![0, 0, 0, SEED, THROUGH]), 1..80))
                .prop_map(|(width, mut cells)| {
                    cells.resize(cells.len().next_multiple_of(width), 0);
                    (width, cells)
                }),
            max_cells in 0usize..6,
        ) {
            let mut growth = Growth::default();
            growth.load(width, cells.chunks(width), |cell| cell);
            growth.bridge([SEED, THROUGH], GAP, max_cells);
            let found: Vec<u8> = growth.rows().flatten().copied().collect();
            prop_assert_eq!(found, bridged_slowly(&cells, width, max_cells));
        }

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
