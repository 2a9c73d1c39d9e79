//! Shortest paths over reachable cells, with string pulling.

use crate::free_space::FreeSpace;
use frames::{Map, Point2};
use grid::{GridSpec, LineOfSight, squared_distances};

/// The reachable cells of a storey: a section of the grid with a border of unreachable cells. Cells are indices in the
/// section.
pub(crate) struct PathGrid {
    spec: GridSpec,
    pub(crate) width: usize,
    /// True for reachable cells.
    pub(crate) open: Vec<bool>,
    /// Squared distance to the nearest unreachable cell, in cells.
    pub(crate) squared: Vec<u32>,
    /// Lines of sight over reachable cells.
    sight: LineOfSight,
}

/// Costs of a step along a side and across a corner, in fifths of a cell.
const SIDE: u32 = 5;
const CORNER: u32 = 7;

/// Length of a path that does not exist.
pub(crate) const NO_PATH: u32 = u32::MAX;

/// Buffers of a search, reused by the next.
#[derive(Default)]
pub(crate) struct SearchBuffers {
    cost: Vec<u32>,
    from: Vec<u32>,
    touched: Vec<u32>,
    buckets: Vec<Vec<u32>>,
}

impl PathGrid {
    /// The parts of a storey for which `is_reached` is true; `None` if there are none.
    pub(crate) fn of(free_space: &FreeSpace, is_reached: impl Fn(u32) -> bool) -> Option<Self> {
        let width = free_space.spec.width as usize;
        let reached = |cell: usize| free_space.part(cell) != 0 && is_reached(free_space.part(cell));
        let (mut lo, mut hi) = ([usize::MAX; 2], [0; 2]);
        for cell in (0..free_space.spec.n_cells()).filter(|&c| reached(c)) {
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
        let first = [0, 1].map(|k| free_space.spec.first_cell[k] + lo[k] as i32 - 1);
        let spec = GridSpec { first_cell: first, width: size[0] as u32, height: size[1] as u32, ..free_space.spec };
        let closed: Vec<bool> = open.iter().map(|o| !o).collect();
        let squared = squared_distances(&closed, size[0]);
        let sight = LineOfSight::from_distances(&squared, size[0]);
        Some(Self { spec, width: size[0], open, squared, sight })
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

    /// Shortest paths from a cell to the wanted cells of `targets`, nearest first, until `enough` are found. `found` gets
    /// the index in `targets` and the cells of the path, from the target back to the start. Returns the length in metres up
    /// to which all paths are known; infinite if all targets were found.
    pub(crate) fn shortest_paths(
        &self,
        start: usize,
        targets: &Targets,
        is_wanted: impl Fn(usize) -> bool,
        enough: usize,
        buffers: &mut SearchBuffers,
        mut found: impl FnMut(usize, &[usize]),
    ) -> f64 {
        buffers.begin(self.open.len());
        buffers.reach(start, start, 0);
        let (mut n_found, mut now, mut waiting) = (0, 0, 1usize);
        let mut path = Vec::new();
        while waiting > 0 {
            let bucket = now as usize % N_BUCKETS;
            while let Some(cell) = buffers.buckets[bucket].pop() {
                waiting -= 1;
                let cell = cell as usize;
                if buffers.cost[cell] != now {
                    continue;
                }
                for target in targets.at(cell).filter(|target| is_wanted(*target)) {
                    buffers.path_back(cell, start, &mut path);
                    found(target, &path);
                    n_found += 1;
                }
                if n_found >= enough {
                    return f64::from(now) / f64::from(SIDE) * self.spec.resolution_m();
                }
                waiting += self.step(cell, now, buffers);
            }
            now += 1;
        }
        f64::INFINITY
    }

    fn step(&self, cell: usize, now: u32, buffers: &mut SearchBuffers) -> usize {
        let w = self.width;
        let [left, right, down, up] = [cell - 1, cell + 1, cell - w, cell + w];
        let [l, r, d, u] = [left, right, down, up].map(|c| self.open[c]);
        let sides = [(left, l), (right, r), (down, d), (up, u)];
        // No path passes between two blocked cells that meet at a corner.
        let corners = [(down - 1, d && l), (down + 1, d && r), (up - 1, u && l), (up + 1, u && r)];
        let mut n = 0;
        for (next, _) in sides.into_iter().filter(|s| s.1) {
            n += usize::from(buffers.reach(next, cell, now + SIDE));
        }
        for (next, _) in corners.into_iter().filter(|c| c.1 && self.open[c.0]) {
            n += usize::from(buffers.reach(next, cell, now + CORNER));
        }
        n
    }

    /// String pulling: the corners of the shortest line along a path. Cells are left out while the straight line stays over
    /// reachable cells. The line starts at `from` and ends at `to`, which may lie beside the middles of the end cells.
    pub(crate) fn pull_string(&self, cells: &[usize], from: Point2<Map>, to: Point2<Map>) -> Vec<Point2<Map>> {
        let mut points = vec![from];
        points.extend(cells.iter().map(|&cell| self.middle(cell)).chain([to]));
        points.dedup();
        let last = points.len() - 1;
        let mut line = vec![from];
        let mut at = 0;
        while at < last {
            // Doubling, then bisection finds the farthest cell in a straight line.
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

    /// True if the straight line between two points stays over reachable cells.
    pub(crate) fn is_clear(&self, a: Point2<Map>, b: Point2<Map>) -> bool {
        let inside = |p: Point2<Map>| self.cell_at(p).is_some();
        inside(a) && inside(b) && self.sight.is_clear(self.point_in_cells(a), self.point_in_cells(b))
    }

    /// True if the straight line between the middles of two cells stays over reachable cells.
    pub(crate) fn is_straight(&self, a: usize, b: usize) -> bool {
        self.sight.is_clear(self.in_cells(a), self.in_cells(b))
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

/// Length of a line in metres.
pub(crate) fn length_m(line: &[Point2<Map>]) -> f64 {
    line.windows(2).map(|p| p[1].distance_m(&p[0])).sum()
}

/// Target cells of a search; several targets may share a cell.
pub(crate) struct Targets {
    /// (cell, index of the target), sorted.
    sorted: Vec<(usize, usize)>,
    is_target: Vec<bool>,
}

impl Targets {
    pub(crate) fn new(path_grid: &PathGrid, cells: impl Iterator<Item = usize>) -> Self {
        let mut sorted: Vec<(usize, usize)> = cells.zip(0..).collect();
        sorted.sort_unstable();
        let mut is_target = vec![false; path_grid.open.len()];
        sorted.iter().for_each(|(cell, _)| is_target[*cell] = true);
        Self { sorted, is_target }
    }

    fn at(&self, cell: usize) -> impl Iterator<Item = usize> {
        let start = if self.is_target[cell] { self.sorted.partition_point(|t| t.0 < cell) } else { self.sorted.len() };
        self.sorted[start..].iter().take_while(move |t| t.0 == cell).map(|t| t.1)
    }
}

/// More than the cost of any step.
const N_BUCKETS: usize = 8;

impl SearchBuffers {
    fn begin(&mut self, n_cells: usize) {
        if self.cost.len() == n_cells {
            self.touched.drain(..).for_each(|cell| self.cost[cell as usize] = NO_PATH);
        } else {
            self.touched.clear();
            self.cost = vec![NO_PATH; n_cells];
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
        if *known == NO_PATH {
            self.touched.push(cell as u32);
        }
        *known = cost;
        self.from[cell] = from as u32;
        self.buckets[cost as usize % N_BUCKETS].push(cell as u32);
        true
    }

    fn path_back(&self, cell: usize, start: usize, path: &mut Vec<usize>) {
        path.clear();
        path.push(cell);
        let mut at = cell;
        while at != start {
            at = self.from[at] as usize;
            path.push(at);
        }
    }
}
