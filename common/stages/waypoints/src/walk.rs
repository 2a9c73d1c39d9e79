//! Shortest paths over reachable cells, with string pulling.

use crate::ground::Ground;
use frames::{Map, Point2};
use grid::{GridSpec, Sight, squared_distances};

/// The cells that a robot can get to, cut out of the grid with a border of cells that it cannot. Places are numbers of cells
/// of the cut-out.
pub(crate) struct Walk {
    spec: GridSpec,
    pub(crate) width: usize,
    /// True where the robot can get to.
    pub(crate) open: Vec<bool>,
    /// Squared distance to the nearest cell where it cannot, in cells.
    pub(crate) squared: Vec<u32>,
    /// Straight ways that stay where it can.
    sight: Sight,
}

/// Costs of a step along a side and across a corner, in fifths of a cell.
const SIDE: u32 = 5;
const CORNER: u32 = 7;

/// Length of a way that does not exist.
pub(crate) const NO_WAY: u32 = u32::MAX;

/// Memory of a search, to be used again.
#[derive(Default)]
pub(crate) struct Scratch {
    cost: Vec<u32>,
    from: Vec<u32>,
    touched: Vec<u32>,
    buckets: Vec<Vec<u32>>,
}

impl Walk {
    /// The parts of a storey for which `is_reached` says so; `None` if there are none.
    pub(crate) fn of(ground: &Ground, is_reached: impl Fn(u32) -> bool) -> Option<Self> {
        let width = ground.spec.width as usize;
        let reached = |cell: usize| ground.part(cell) != 0 && is_reached(ground.part(cell));
        let (mut lo, mut hi) = ([usize::MAX; 2], [0; 2]);
        for cell in (0..ground.spec.n_cells()).filter(|&c| reached(c)) {
            let at = [cell % width, cell / width];
            for k in 0..2 {
                (lo[k], hi[k]) = (lo[k].min(at[k]), hi[k].max(at[k]));
            }
        }
        if lo[0] > hi[0] {
            return None;
        }
        let size = [hi[0] - lo[0] + 3, hi[1] - lo[1] + 3];
        let mut open = vec![false; size[0] * size[1]];
        for row in lo[1]..=hi[1] {
            for column in lo[0]..=hi[0] {
                open[(row - lo[1] + 1) * size[0] + column - lo[0] + 1] = reached(row * width + column);
            }
        }
        let first = [0, 1].map(|k| ground.spec.first_cell[k] + lo[k] as i32 - 1);
        let spec = GridSpec { first_cell: first, width: size[0] as u32, height: size[1] as u32, ..ground.spec };
        let closed: Vec<bool> = open.iter().map(|o| !o).collect();
        let squared = squared_distances(&closed, size[0]);
        let sight = Sight::from_distances(&squared, size[0]);
        Some(Self { spec, width: size[0], open, squared, sight })
    }

    /// The cell of the cut-out at a point, if the robot can get there.
    pub(crate) fn cell_at(&self, p: Point2<Map>) -> Option<usize> {
        self.spec.cell_at(p).map(|c| self.spec.index(c)).filter(|&c| self.open[c])
    }

    /// The cell at a point, or the nearest of those around it that the robot can get to: a place between the middles of cells may
    /// be clear although that of its own cell is not.
    pub(crate) fn cell_near(&self, p: Point2<Map>) -> Option<usize> {
        self.cell_at(p).or_else(|| {
            let cell = self.spec.index(self.spec.cell_at(p)?);
            let around = [1, self.width - 1, self.width, self.width + 1];
            let cells = around.iter().flat_map(|&k| [cell.checked_sub(k), Some(cell + k)]).flatten();
            let far = |c: &usize| {
                let middle = self.middle(*c);
                libm::hypot(middle.x_m - p.x_m, middle.y_m - p.y_m)
            };
            cells.filter(|&c| self.open.get(c) == Some(&true)).min_by(|a, b| far(a).total_cmp(&far(b)).then(a.cmp(b)))
        })
    }

    /// The middle of a cell.
    pub(crate) fn middle(&self, cell: usize) -> Point2<Map> {
        self.spec.centre_of(self.spec.cell_of(cell))
    }

    /// Shortest ways from a cell to those of `targets` (cells) that are wanted, nearest first, until `enough` are found. `found`
    /// gets the place in `targets` and the cells of the way, from the target back to the cell. Returns the length up to which all ways are
    /// known, in metres; infinite if all were found.
    pub(crate) fn ways(
        &self,
        start: usize,
        targets: &Targets,
        is_wanted: impl Fn(usize) -> bool,
        enough: usize,
        scratch: &mut Scratch,
        mut found: impl FnMut(usize, &[usize]),
    ) -> f64 {
        scratch.begin(self.open.len());
        scratch.reach(start, start, 0);
        let (mut n_found, mut now, mut waiting) = (0, 0, 1usize);
        let mut way = Vec::new();
        while waiting > 0 {
            let bucket = now as usize % N_BUCKETS;
            while let Some(cell) = scratch.buckets[bucket].pop() {
                waiting -= 1;
                let cell = cell as usize;
                if scratch.cost[cell] != now {
                    continue;
                }
                for target in targets.at(cell).filter(|target| is_wanted(*target)) {
                    scratch.way_back(cell, start, &mut way);
                    found(target, &way);
                    n_found += 1;
                }
                if n_found >= enough {
                    return f64::from(now) / f64::from(SIDE) * self.spec.resolution_m();
                }
                waiting += self.step(cell, now, scratch);
            }
            now += 1;
        }
        f64::INFINITY
    }

    fn step(&self, cell: usize, now: u32, scratch: &mut Scratch) -> usize {
        let w = self.width;
        let [left, right, down, up] = [cell - 1, cell + 1, cell - w, cell + w];
        let [l, r, d, u] = [left, right, down, up].map(|c| self.open[c]);
        let sides = [(left, l), (right, r), (down, d), (up, u)];
        // No way squeezes between two cells that meet at a corner.
        let corners = [(down - 1, d && l), (down + 1, d && r), (up - 1, u && l), (up + 1, u && r)];
        let mut n = 0;
        for (next, _) in sides.into_iter().filter(|s| s.1) {
            n += usize::from(scratch.reach(next, cell, now + SIDE));
        }
        for (next, _) in corners.into_iter().filter(|c| c.1 && self.open[c.0]) {
            n += usize::from(scratch.reach(next, cell, now + CORNER));
        }
        n
    }

    /// The corners of the shortest line along a way: cells are left out while the straight line stays where the robot can be.
    /// The ends are `from` and `to`, which may lie beside the middles of the way's ends.
    pub(crate) fn pulled(&self, cells: &[usize], from: Point2<Map>, to: Point2<Map>) -> Vec<Point2<Map>> {
        let mut points = vec![from];
        points.extend(cells.iter().map(|&cell| self.middle(cell)).chain([to]));
        points.dedup();
        let last = points.len() - 1;
        let mut line = vec![from];
        let mut at = 0;
        while at < last {
            // Doubling, then halving: the farthest place in a straight line, found in a few looks.
            let clear = |to: usize| self.is_clear(points[at], points[to]);
            let (mut good, mut step) = (at + 1, 1);
            while good < last && clear((good + step).min(last)) {
                good = (good + step).min(last);
                step *= 2;
            }
            let mut bad = (good + step).min(last + 1);
            while good + 1 < bad {
                let middle = good.midpoint(bad);
                if clear(middle) { good = middle } else { bad = middle }
            }
            at = good;
            line.push(points[at]);
        }
        if line.len() == 1 {
            line.push(to);
        }
        line
    }

    /// True if the straight way between two places stays where the robot can be.
    pub(crate) fn is_clear(&self, a: Point2<Map>, b: Point2<Map>) -> bool {
        let inside = |p: Point2<Map>| self.cell_at(p).is_some();
        inside(a) && inside(b) && self.sight.is_clear(self.place(a), self.place(b))
    }

    /// The same between the middles of two cells.
    pub(crate) fn is_straight(&self, a: usize, b: usize) -> bool {
        self.sight.is_clear(self.in_cells(a), self.in_cells(b))
    }

    fn place(&self, p: Point2<Map>) -> [f64; 2] {
        let resolution_m = self.spec.resolution_m();
        [
            p.x_m / resolution_m - f64::from(self.spec.first_cell[0]),
            p.y_m / resolution_m - f64::from(self.spec.first_cell[1]),
        ]
    }

    fn in_cells(&self, cell: usize) -> [f64; 2] {
        [(cell % self.width) as f64 + 0.5, (cell / self.width) as f64 + 0.5]
    }
}

/// Length of a line in metres.
pub(crate) fn length_m(line: &[Point2<Map>]) -> f64 {
    line.windows(2).map(|p| libm::hypot(p[1].x_m - p[0].x_m, p[1].y_m - p[0].y_m)).sum()
}

/// Cells to be found, several perhaps in one place.
pub(crate) struct Targets {
    /// (cell, place in the list), sorted.
    sorted: Vec<(usize, usize)>,
    is_target: Vec<bool>,
}

impl Targets {
    pub(crate) fn new(walk: &Walk, cells: impl Iterator<Item = usize>) -> Self {
        let mut sorted: Vec<(usize, usize)> = cells.zip(0..).collect();
        sorted.sort_unstable();
        let mut is_target = vec![false; walk.open.len()];
        sorted.iter().for_each(|(cell, _)| is_target[*cell] = true);
        Self { sorted, is_target }
    }

    fn at(&self, cell: usize) -> impl Iterator<Item = usize> {
        let start = if self.is_target[cell] { self.sorted.partition_point(|t| t.0 < cell) } else { self.sorted.len() };
        self.sorted[start..].iter().take_while(move |t| t.0 == cell).map(|t| t.1)
    }
}

/// More than the dearest step.
const N_BUCKETS: usize = 8;

impl Scratch {
    fn begin(&mut self, n_cells: usize) {
        if self.cost.len() == n_cells {
            self.touched.drain(..).for_each(|cell| self.cost[cell as usize] = NO_WAY);
        } else {
            self.touched.clear();
            self.cost = vec![NO_WAY; n_cells];
            self.from = vec![0; n_cells];
        }
        self.buckets.resize_with(N_BUCKETS, Vec::new);
        self.buckets.iter_mut().for_each(Vec::clear);
    }

    fn reach(&mut self, cell: usize, from: usize, cost: u32) -> bool {
        let known = &mut self.cost[cell];
        if cost >= *known {
            return false;
        }
        if *known == NO_WAY {
            self.touched.push(cell as u32);
        }
        *known = cost;
        self.from[cell] = from as u32;
        self.buckets[cost as usize % N_BUCKETS].push(cell as u32);
        true
    }

    fn way_back(&self, cell: usize, start: usize, way: &mut Vec<usize>) {
        way.clear();
        way.push(cell);
        let mut at = cell;
        while at != start {
            at = self.from[at] as usize;
            way.push(at);
        }
    }
}
