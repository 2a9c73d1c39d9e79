//! Shortest paths over reachable cells, with string pulling.

use crate::free_space::{FreeSpace, Run};
use frames::{Map, Point2};
use grid::{GridSpec, LineOfSight, SparseCells, SparseLayer, sparse_distances};

/// The reachable cells of a storey: a section of the grid with a border of unreachable cells. Cells are indices in the
/// section.
pub(crate) struct PathGrid {
    spec: GridSpec,
    pub(crate) width: usize,
    /// True for reachable cells.
    pub(crate) open: SparseLayer<bool>,
    /// Reachable neighbours of each reachable cell, as bits of [`Self::neighbours`].
    pub(crate) open_around: SparseLayer<u8>,
    /// Squared distance to the nearest unreachable cell, in cells.
    pub(crate) squared: SparseLayer<u32>,
    /// Lines of sight over reachable cells.
    sight: LineOfSight,
    /// Cells within distances that the robot keeps, if it does.
    kept_off: Option<KeptOff>,
}

/// Reachable cells on which the robot drives only where no other way is much shorter.
struct KeptOff {
    cells: SparseLayer<bool>,
    /// Lines of sight over the other reachable cells.
    sight: LineOfSight,
    /// Rank of each cell in thinning: those within a distance first, then the others by how far they are from these.
    rank: SparseLayer<u32>,
}

/// Costs of a step along a side and across a corner, in fifths of a cell.
pub(crate) const SIDE: u32 = 5;
const CORNER: u32 = 7;

/// A step within a distance that the robot keeps costs as so many.
pub(crate) const KEPT_OFF_FACTOR: u32 = 4;

/// Length of a path that does not exist.
pub(crate) const NO_PATH: u32 = u32::MAX;

/// Buffers of a search on a path grid, reused by the next.
pub(crate) struct SearchBuffers {
    cost: SparseLayer<u32>,
    from: SparseLayer<u32>,
    touched: Vec<u32>,
    /// Reached cells, by the cost of a path over them.
    buckets: Vec<Vec<u32>>,
    n_waiting: usize,
}

impl PathGrid {
    /// The parts of a storey for which `is_reached` is true; `None` if there are none.
    pub(crate) fn of(free_space: &FreeSpace, is_reached: impl Fn(u32) -> bool) -> Option<Self> {
        let width = free_space.spec.width as usize;
        let reached = || free_space.runs().filter(|run| is_reached(run.part));
        let (mut lo, mut hi) = ([usize::MAX; 2], [0; 2]);
        for run in reached() {
            let (cells, row) = (run.cells(), run.cells().start / width);
            let columns = [cells.start - row * width, cells.end - 1 - row * width];
            lo = [lo[0].min(columns[0]), lo[1].min(row)];
            hi = [hi[0].max(columns[1]), hi[1].max(row)];
        }
        if lo[0] > hi[0] {
            return None;
        }
        let size = [hi[0] - lo[0] + 3, hi[1] - lo[1] + 3];
        let mut closed = vec![true; size[0] * size[1]];
        let inside = |cell: usize| (cell / width - lo[1] + 1) * size[0] + cell % width - lo[0] + 1;
        for run in reached() {
            let first = inside(run.cells().start);
            closed[first..first + run.cells().len()].fill(false);
        }
        let first = [0, 1].map(|k| free_space.spec.first_cell[k] + lo[k] as i32 - 1);
        let spec = GridSpec { first_cell: first, width: size[0] as u32, height: size[1] as u32, ..free_space.spec };
        let squared = sparse_distances(&closed, size[0]);
        let open_around = open_around(squared.cells(), &closed, size[0]);
        let kept_off = free_space.kept_off_hash().map(|_| {
            let cells = reached().flat_map(Run::cells).filter(|&cell| free_space.is_kept_off(cell));
            let kept: Vec<usize> = cells.map(inside).collect();
            KeptOff::of(&mut closed, &kept, &squared, size[0])
        });
        drop(closed);
        let open = squared.map(false, |_, squared| squared != 0);
        let sight = LineOfSight::from_distances(&squared, size[0]);
        Some(Self { spec, width: size[0], open, open_around, squared, sight, kept_off })
    }

    /// Side of a cell in metres.
    pub(crate) fn resolution_m(&self) -> f64 {
        self.spec.resolution_m()
    }

    /// The cell at a point, if it is reachable.
    pub(crate) fn cell_at(&self, p: Point2<Map>) -> Option<usize> {
        self.spec.cell_at(p).map(|c| self.spec.index(c)).filter(|&c| self.open[c])
    }

    /// The cell at a point, or the nearest reachable neighbour: a point between the middles of cells may be clear although
    /// the middle of its own cell is not.
    pub(crate) fn cell_near(&self, p: Point2<Map>) -> Option<usize> {
        self.cell_at(p).or_else(|| {
            let cell = self.spec.index(self.spec.cell_at(p)?);
            let around = [1, self.width - 1, self.width, self.width + 1];
            let cells = around.iter().flat_map(|&k| [cell.checked_sub(k), Some(cell + k)]).flatten();
            let far = |c: &usize| {
                let middle = self.middle(*c);
                middle.distance_m(&p)
            };
            cells.filter(|&c| self.open.get(c) == Some(&true)).min_by(|a, b| far(a).total_cmp(&far(b)).then(a.cmp(b)))
        })
    }

    /// The middle of a cell.
    pub(crate) fn middle(&self, cell: usize) -> Point2<Map> {
        self.spec.centre_of(self.spec.cell_of(cell))
    }

    /// The same cell in the whole grid of the storey.
    pub(crate) fn cell_in(&self, whole: &GridSpec, cell: usize) -> usize {
        let at = [cell % self.width, cell / self.width];
        // The border around the cells may lie outside of the whole grid; what is asked for does not.
        let [column, row] = [0, 1].map(|k| at[k] as i64 + i64::from(self.spec.first_cell[k] - whole.first_cell[k]));
        (row * i64::from(whole.width) + column) as usize
    }

    /// True for a cell within a distance that the robot keeps.
    pub(crate) fn is_kept_off(&self, cell: usize) -> bool {
        self.kept_off.as_ref().is_some_and(|kept_off| kept_off.cells[cell])
    }

    /// True if the robot keeps distances.
    pub(crate) fn keeps_distances(&self) -> bool {
        self.kept_off.is_some()
    }

    /// Order in which reachable cells are taken away in thinning: the squared distance to what is unreachable, and within a distance
    /// that the robot keeps less than everywhere else. 0 for unreachable cells.
    pub(crate) fn ranks(&self) -> &SparseLayer<u32> {
        self.kept_off.as_ref().map_or(&self.squared, |kept_off| &kept_off.rank)
    }

    /// The eight cells around a cell, counter-clockwise from the right.
    pub(crate) fn neighbours(&self, cell: usize) -> [usize; 8] {
        around(cell, self.width)
    }

    /// Calls `visit` with every cell to which a step leads from a cell, and the cost of the step.
    pub(crate) fn steps_from(&self, cell: usize, mut visit: impl FnMut(usize, u32)) {
        self.steps_on(cell, NO_STEP, |next, step, _| visit(next, step));
    }

    /// Calls `visit` with every cell to which a search in the order of costs goes on from a cell that it reached by a step in
    /// this direction, or by [`NO_STEP`]: with the cost of the step and its direction. Left out are cells that it has reached at
    /// no more cost from the cells before.
    ///
    /// # Source
    /// Harabor, Grastien, "Online graph pruning for pathfinding on grid maps", AAAI 2011: natural and forced neighbours, here
    /// with straight steps before steps across a corner.
    pub(crate) fn steps_on(&self, cell: usize, reached_by: u8, mut visit: impl FnMut(usize, u32, u8)) {
        // Within distances that the robot keeps a way around may cost less.
        let reached_by = if self.keeps_distances() { NO_STEP } else { reached_by };
        let mut steps = STEPS_ON[usize::from(reached_by)][usize::from(self.open_around[cell])];
        let is_dear = self.is_kept_off(cell);
        let cost = |next: usize, step: u32| {
            if is_dear || self.is_kept_off(next) { KEPT_OFF_FACTOR * step } else { step }
        };
        while steps != 0 {
            let Step { direction, beside, above, length } = STEP_ORDER[steps.trailing_zeros() as usize];
            let next = cell.wrapping_add_signed(above * self.width as isize + beside);
            visit(next, cost(next, length), direction);
            steps &= steps - 1;
        }
    }

    /// The cells of a shortest path from a cell to another, both included; empty if there is none.
    ///
    /// # Source
    /// Hart, Nilsson, Raphael, "A formal basis for the heuristic determination of minimum cost paths", IEEE Transactions on
    /// Systems Science and Cybernetics 4, 1968.
    pub(crate) fn shortest_path(&self, from: usize, to: usize, buffers: &mut SearchBuffers) -> Vec<usize> {
        // The cost of a path over open floor is never more than that of a path around obstacles.
        let left = |cell: usize| {
            let [dx, dy] =
                [(cell % self.width).abs_diff(to % self.width), (cell / self.width).abs_diff(to / self.width)];
            SIDE * dx.max(dy) as u32 + (CORNER - SIDE) * dx.min(dy) as u32
        };
        buffers.begin();
        let mut now = left(from);
        buffers.reach(from, from, 0, now);
        while buffers.n_waiting > 0 {
            while let Some(cell) = buffers.next(now) {
                let cost = buffers.cost[cell];
                if cell == to {
                    return buffers.path(from, to);
                }
                // A cell that was reached at less cost since has been looked at.
                if cost + left(cell) == now {
                    self.steps_from(cell, |next, step| {
                        buffers.reach(next, cell, cost + step, cost + step + left(next))
                    });
                }
            }
            now += 1;
        }
        Vec::new()
    }

    /// String pulling: the corners of the shortest line along a path. Cells are left out while the straight line stays over
    /// reachable cells, and off those that the path keeps off. The line starts at `from` and ends at `to`, which may lie beside
    /// the middles of the end cells.
    pub(crate) fn pull_string(&self, cells: &[usize], from: Point2<Map>, to: Point2<Map>) -> Vec<Point2<Map>> {
        let mut line = vec![from];
        let mut rest = cells;
        while let Some(&first) = rest.first() {
            let is_kept_off = self.is_kept_off(first);
            let n = rest.iter().take_while(|&&cell| self.is_kept_off(cell) == is_kept_off).count();
            let (stretch, after) = rest.split_at(n);
            // The first cell behind a stretch is where the next one begins.
            let end = after.first().map_or(to, |&next| self.middle(next));
            let begin = line[line.len() - 1];
            let pulled = self.pull_stretch(stretch, begin, end, is_kept_off);
            line.extend(pulled.into_iter().skip(1));
            rest = after;
        }
        if line.len() == 1 {
            line.push(to);
        }
        line
    }

    /// The same of a part of a path within distances that the robot keeps, or off them.
    fn pull_stretch(&self, cells: &[usize], from: Point2<Map>, to: Point2<Map>, is_kept_off: bool) -> Vec<Point2<Map>> {
        let mut points = vec![from];
        points.extend(cells.iter().map(|&cell| self.middle(cell)).chain([to]));
        points.dedup();
        pulled(&points, |at, to| {
            if is_kept_off { self.is_open(points[at], points[to]) } else { self.is_clear(points[at], points[to]) }
        })
    }

    /// True if the straight line between two points stays over reachable cells, and off distances that the robot keeps.
    pub(crate) fn is_clear(&self, a: Point2<Map>, b: Point2<Map>) -> bool {
        let keeps_off = |kept_off: &KeptOff| {
            let is_kept_off = |p: Point2<Map>| self.cell_at(p).is_some_and(|cell| kept_off.cells[cell]);
            let ends = [a, b].map(|p| self.point_in_cells(p));
            !is_kept_off(a) && !is_kept_off(b) && kept_off.sight.is_clear(ends[0], ends[1])
        };
        self.is_open(a, b) && self.kept_off.as_ref().is_none_or(keeps_off)
    }

    /// True if the straight line between two points stays over reachable cells.
    fn is_open(&self, a: Point2<Map>, b: Point2<Map>) -> bool {
        let inside = |p: Point2<Map>| self.cell_at(p).is_some();
        inside(a) && inside(b) && self.sight.is_clear(self.point_in_cells(a), self.point_in_cells(b))
    }

    /// True if the straight line between the ends of a chain of cells stays over reachable cells, and off distances that the
    /// chain keeps.
    pub(crate) fn is_straight(&self, chain: &[usize]) -> bool {
        let [a, b] = [chain[0], chain[chain.len() - 1]].map(|cell| self.in_cells(cell));
        let keeps_off =
            |kept_off: &KeptOff| chain.iter().any(|&cell| kept_off.cells[cell]) || kept_off.sight.is_clear(a, b);
        self.sight.is_clear(a, b) && self.kept_off.as_ref().is_none_or(keeps_off)
    }

    fn point_in_cells(&self, p: Point2<Map>) -> [f64; 2] {
        let resolution_m = self.spec.resolution_m();
        [
            p.x_m() / resolution_m - f64::from(self.spec.first_cell[0]),
            p.y_m() / resolution_m - f64::from(self.spec.first_cell[1]),
        ]
    }

    fn in_cells(&self, cell: usize) -> [f64; 2] {
        [(cell % self.width) as f64 + 0.5, (cell / self.width) as f64 + 0.5]
    }
}

/// The eight cells around a cell of a grid, counter-clockwise from the right.
pub(crate) fn around(cell: usize, width: usize) -> [usize; 8] {
    let (up, down) = (cell + width, cell - width);
    [cell + 1, up + 1, up, up - 1, cell - 1, down - 1, down, down + 1]
}

/// For each cell that is not closed those around it that are not, as bits, counter-clockwise from the right. The cells at the rim are
/// closed. Written so that the compiler vectorises it.
fn open_around(cells: &SparseCells, closed: &[bool], width: usize) -> SparseLayer<u8> {
    let mut layer = cells.layer(0);
    let mut bits = vec![0; width - 2];
    for row in (width..closed.len() - width).step_by(width) {
        let open = |cell: usize| &closed[cell..cell + width - 2];
        let sides = [
            row + 2,
            row + width + 2,
            row + width + 1,
            row + width,
            row,
            row - width,
            row - width + 1,
            row - width + 2,
        ];
        let own = open(row + 1);
        bits.iter_mut().zip(own).for_each(|(bits, closed)| *bits = u8::from(*closed).wrapping_sub(1));
        for (k, side) in sides.into_iter().enumerate() {
            let clear = |(bits, closed): (&mut u8, &bool)| *bits &= !(u8::from(*closed) << k);
            bits.iter_mut().zip(open(side)).for_each(clear);
        }
        layer.write(row + 1, &bits);
    }
    layer
}

/// The steps that lead from a cell, as bits, by its reachable neighbours: no path passes between two blocked cells that meet at a
/// corner, nor past one.
const STEPS: [u8; 256] = {
    let mut table = [0; 256];
    let mut open = 0;
    while open < 256 {
        let sides = open as u8 & 0b0101_0101;
        // A corner is between the sides before and after it.
        table[open] = sides | (open as u8 & 0b1010_1010 & sides.rotate_left(1) & sides.rotate_right(1));
        open += 1;
    }
    table
};

/// The direction of no step: in the cell where a search begins.
pub(crate) const NO_STEP: u8 = 8;

/// A step from a cell to one around it.
#[derive(Clone, Copy)]
struct Step {
    /// As a bit of [`PathGrid::neighbours`].
    direction: u8,
    /// Cells to the right, and rows upwards.
    beside: isize,
    above: isize,
    length: u32,
}

/// All steps in the order in which a search tries them.
const STEP_ORDER: [Step; 8] = [
    Step { direction: 4, beside: -1, above: 0, length: SIDE },
    Step { direction: 0, beside: 1, above: 0, length: SIDE },
    Step { direction: 6, beside: 0, above: -1, length: SIDE },
    Step { direction: 2, beside: 0, above: 1, length: SIDE },
    Step { direction: 5, beside: -1, above: -1, length: CORNER },
    Step { direction: 7, beside: 1, above: -1, length: CORNER },
    Step { direction: 3, beside: -1, above: 1, length: CORNER },
    Step { direction: 1, beside: 1, above: 1, length: CORNER },
];

/// Directions as bits of the steps that are tried.
const fn in_order(directions: u8) -> u8 {
    let (mut steps, mut k) = (0, 0);
    while k < STEP_ORDER.len() {
        steps |= (directions >> STEP_ORDER[k].direction & 1) << k;
        k += 1;
    }
    steps
}

/// The steps by which a search goes on from a cell, as bits of [`STEP_ORDER`], by the direction of the step that reached it and its
/// reachable neighbours.
static STEPS_ON: [[u8; 256]; NO_STEP as usize + 1] = {
    let mut table = [[0; 256]; NO_STEP as usize + 1];
    let mut by = 0;
    while by <= NO_STEP as usize {
        let mut open = 0;
        while open < 256 {
            // Directions counted from that of the step.
            let closed = !(open as u8).rotate_right(by as u32);
            let kept = if by == NO_STEP as usize {
                u8::MAX
            } else if by % 2 == 0 {
                // What is beside the cell before leads to what is beside this one, where it is reachable.
                0b1000_0011 | (closed >> 3 & 1) << 2 | (closed >> 5 & 1) << 6
            } else {
                // Both cells between the two lead there; so do those behind them.
                0b0000_0001 | (closed >> 2 & 1) << 1 | (closed >> 6 & 1) << 7
            };
            table[by][open] = in_order(STEPS[open] & u8::rotate_left(kept, by as u32));
            open += 1;
        }
        by += 1;
    }
    table
};

impl KeptOff {
    /// Of cells of a section of a grid; `closed` are its unreachable ones, and these afterwards.
    fn of(closed: &mut [bool], cells: &[usize], squared: &SparseLayer<u32>, width: usize) -> Self {
        cells.iter().for_each(|&cell| closed[cell] = true);
        let others = sparse_distances(closed, width);
        let farthest = cells.iter().map(|&cell| squared[cell]).max().unwrap_or(0);
        let mut is_kept_off = squared.cells().layer(false);
        let mut rank = squared.cells().layer_of(0, |cell| if others[cell] == 0 { 0 } else { farthest + others[cell] });
        for &cell in cells {
            (is_kept_off[cell], rank[cell]) = (true, squared[cell]);
        }
        Self { cells: is_kept_off, sight: LineOfSight::from_distances(&others, width), rank }
    }
}

/// Length of a line in metres.
pub(crate) fn length_m(line: &[Point2<Map>]) -> f64 {
    line.windows(2).map(|p| p[1].distance_m(&p[0])).sum()
}

/// More than the least cost of a path over a cell grows with any step.
const N_BUCKETS: usize = 64;
const _: () = assert!(N_BUCKETS > ((KEPT_OFF_FACTOR + 1) * CORNER) as usize);

impl SearchBuffers {
    pub(crate) fn of(path_grid: &PathGrid) -> Self {
        let cells = path_grid.open.cells();
        let buckets = vec![Vec::new(); N_BUCKETS];
        Self { cost: cells.layer(NO_PATH), from: cells.layer(0), touched: Vec::new(), buckets, n_waiting: 0 }
    }

    fn begin(&mut self) {
        self.touched.drain(..).for_each(|cell| self.cost[cell as usize] = NO_PATH);
        self.buckets.iter_mut().for_each(Vec::clear);
        self.n_waiting = 0;
    }

    /// Reaches a cell from another; `rank` is the cost of a path over it, and tells when it is looked at.
    fn reach(&mut self, cell: usize, from: usize, cost: u32, rank: u32) {
        let known = &mut self.cost[cell];
        if cost >= *known {
            return;
        }
        if *known == NO_PATH {
            self.touched.push(cell as u32);
        }
        *known = cost;
        self.from[cell] = from as u32;
        self.buckets[rank as usize % N_BUCKETS].push(cell as u32);
        self.n_waiting += 1;
    }

    fn next(&mut self, rank: u32) -> Option<usize> {
        let cell = self.buckets[rank as usize % N_BUCKETS].pop()?;
        self.n_waiting -= 1;
        Some(cell as usize)
    }

    fn path(&self, from: usize, to: usize) -> Vec<usize> {
        let before = |&cell: &usize| (cell != from).then(|| self.from[cell] as usize);
        let mut path: Vec<usize> = std::iter::successors(Some(to), before).collect();
        path.reverse();
        path
    }
}

/// The points of a line that are left when those between two are left out, by their places, wherever `may_skip` them; at least two.
pub(crate) fn pulled(points: &[Point2<Map>], may_skip: impl Fn(usize, usize) -> bool) -> Vec<Point2<Map>> {
    let last = points.len() - 1;
    let mut line = vec![points[0]];
    let mut at = 0;
    while at < last {
        // Doubling, then bisection finds the farthest point.
        let (mut good, mut step) = (at + 1, 1);
        while good < last && may_skip(at, (good + step).min(last)) {
            good = (good + step).min(last);
            step *= 2;
        }
        let mut bad = (good + step).min(last + 1);
        while good + 1 < bad {
            let middle = good.midpoint(bad);
            if may_skip(at, middle) { good = middle } else { bad = middle }
        }
        at = good;
        line.push(points[at]);
    }
    if line.len() == 1 {
        line.push(points[last]);
    }
    line
}
