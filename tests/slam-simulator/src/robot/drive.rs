//! The way of the robot over the reachable floor, to the nearest place that it has not visited.

use crate::plane::{Vector, difference, direction_of, distance, scaled, sum, turned};
use crate::random_generator::RandomGenerator;
use crate::strengths::Strengths;
use crate::world::{CELL_M, World};
use std::collections::VecDeque;

/// World cells in a cell of the way: 0.1 m.
const COARSENESS: usize = 4;
const STEP_M: f64 = COARSENESS as f64 * CELL_M;
/// Half the width of the robot, in cells of the world.
const CLEARANCE_CELLS: u8 = 7;
/// A place is visited if the robot came this close to it, in cells of the way.
const VISITED_CELLS: u32 = 15;
/// Less than this is no drive.
const MIN_REGION_M2: f64 = 5.0;

/// Where the robot scans, in order.
#[derive(Debug, Clone)]
pub(crate) struct Drive {
    /// True places.
    pub(crate) places: Vec<Vector>,
    /// True directions, unit vectors.
    pub(crate) headings: Vec<Vector>,
    /// Share of the reachable floor that was visited, until each of them.
    pub(crate) covered: Vec<f64>,
    /// Length of the way, until each of them, and with what comes after the last.
    pub(crate) way_m: Vec<f64>,
    pub(crate) whole_way_m: f64,
    /// Area of the reachable floor for the middle of the robot.
    pub(crate) reachable_m2: f64,
}

impl Drive {
    /// The first so many scans.
    pub(crate) fn begin(&self, n_scans: usize) -> Self {
        Self {
            places: self.places[..n_scans].to_vec(),
            headings: self.headings[..n_scans].to_vec(),
            covered: self.covered[..n_scans].to_vec(),
            way_m: self.way_m[..n_scans].to_vec(),
            whole_way_m: self.whole_way_m,
            reachable_m2: self.reachable_m2,
        }
    }

    /// The same with more scans where the robot turns, on the spot: by at most this angle from scan to scan.
    #[must_use]
    pub(crate) fn turning(self, max_turn_rad: f64) -> Self {
        let mut turning = self.begin(0);
        for k in 0..self.places.len() {
            let before = self.headings[k.saturating_sub(1)];
            // A robot arrives in the direction in which it left, and turns there.
            let by = turned(self.headings[k], [before[0], -before[1]]);
            let turn_rad = libm::atan2(by[1], by[0]);
            let n = ((turn_rad.abs() / max_turn_rad).ceil() as usize).max(1);
            for part in 1..=n {
                let back_rad = turn_rad * (part as f64 / n as f64 - 1.0);
                turning.places.push(self.places[k]);
                turning.headings.push(turned(self.headings[k], direction_of(back_rad)));
                turning.covered.push(self.covered[k]);
                turning.way_m.push(self.way_m[k]);
            }
        }
        turning
    }

    /// Numbers of scans after equal parts of the way.
    pub(crate) fn parts(&self, n: usize) -> Vec<usize> {
        let end_m = |part: usize| self.whole_way_m * part as f64 / n as f64;
        let mut ends: Vec<usize> = (1..n).map(|part| self.way_m.partition_point(|m| *m < end_m(part)) + 1).collect();
        ends.push(self.places.len());
        ends.iter_mut().for_each(|end| *end = (*end).min(self.places.len()));
        ends
    }
}

/// The floor on which the middle of the robot can be, in cells of 0.1 m.
struct Region {
    width: usize,
    is_open: Vec<bool>,
    origin: Vector,
    /// How far each cell was from the last begin of a search; reset after each.
    steps: Vec<u32>,
}

/// A drive from a random place; `None` if there is no floor to drive on.
pub(crate) fn drive(
    world: &World,
    clearance: &[u8],
    strengths: &Strengths,
    random: &mut RandomGenerator,
) -> Option<Drive> {
    let mut region = Region::of(world, clearance);
    let start = region.keep_largest(random)?;
    let n_open = region.is_open.iter().filter(|c| **c).count();
    if (n_open as f64) * STEP_M * STEP_M < MIN_REGION_M2 {
        return None;
    }
    let wanted = (strengths.coverage.min(0.98) * n_open as f64) as usize;
    let mut is_visited = vec![false; region.is_open.len()];
    let mut n_visited = region.visit(start, &mut is_visited);
    let mut way = vec![start];
    let mut n_visited_at = vec![n_visited];
    while n_visited < wanted {
        let Some(leg) = region.way_to(way[way.len() - 1], |cell| !is_visited[cell]) else { break };
        for (k, &cell) in leg.iter().enumerate() {
            if k % 6 == 5 || k + 1 == leg.len() {
                n_visited += region.visit(cell, &mut is_visited);
            }
            n_visited_at.push(n_visited);
        }
        way.extend(leg);
    }
    if random.happens(0.5) {
        let back = region.way_to(way[way.len() - 1], |cell| cell == start);
        way.extend(back.unwrap_or_default());
        n_visited_at.resize(way.len(), n_visited);
    }
    let line = region.smoothed(&way);
    let (scanned, way_m): (Vec<usize>, Vec<f64>) = spaced(&line, strengths.scan_spacing_m, random).into_iter().unzip();
    let places: Vec<Vector> = scanned.iter().map(|&k| line[k]).collect();
    let headings = headings(&places, random);
    let whole_way_m = line.windows(2).map(|p| distance(p[0], p[1])).sum();
    let covered = scanned.iter().map(|&k| n_visited_at[k] as f64 / n_open as f64).collect();
    Some(Drive { places, headings, covered, way_m, whole_way_m, reachable_m2: n_open as f64 * STEP_M * STEP_M })
}

impl Region {
    fn of(world: &World, clearance: &[u8]) -> Self {
        let (width, height) = (world.width / COARSENESS, world.height / COARSENESS);
        let is_open = |k: usize| {
            let (x, y) = (k % width * COARSENESS + COARSENESS / 2, k / width * COARSENESS + COARSENESS / 2);
            let index = y * world.width + x;
            world.floor[index] && clearance[index] > CLEARANCE_CELLS
        };
        let is_open: Vec<bool> = (0..width * height).map(is_open).collect();
        let steps = vec![u32::MAX; is_open.len()];
        Self { width, is_open, origin: world.origin, steps }
    }

    fn neighbours(&self, cell: usize) -> impl Iterator<Item = usize> + use<> {
        // The border of the world is no floor.
        let w = self.width as isize;
        [1, -1, w, -w, w + 1, w - 1, -w + 1, -w - 1].into_iter().map(move |d| (cell as isize + d) as usize)
    }

    /// Closes all but the largest connected part; a random cell of that.
    fn keep_largest(&mut self, random: &mut RandomGenerator) -> Option<usize> {
        let mut part_of = vec![0u32; self.is_open.len()];
        let mut largest: Vec<usize> = Vec::new();
        for seed in 0..self.is_open.len() {
            if !self.is_open[seed] || part_of[seed] != 0 {
                continue;
            }
            let mut cells = vec![seed];
            part_of[seed] = 1;
            let mut k = 0;
            while k < cells.len() {
                for beside in self.neighbours(cells[k]) {
                    if self.is_open[beside] && part_of[beside] == 0 {
                        part_of[beside] = 1;
                        cells.push(beside);
                    }
                }
                k += 1;
            }
            if cells.len() > largest.len() {
                largest = cells;
            }
        }
        self.is_open.fill(false);
        largest.iter().for_each(|&k| self.is_open[k] = true);
        (!largest.is_empty()).then(|| random.one_of(&largest))
    }

    /// Cells in the order of their distance from `start`, until `until` says so; their steps are in `self.steps`.
    fn search(&mut self, start: usize, mut until: impl FnMut(usize, u32) -> bool) -> Vec<usize> {
        let mut reached = vec![start];
        let mut queue = VecDeque::from([start]);
        self.steps[start] = 0;
        'all: while let Some(cell) = queue.pop_front() {
            for beside in self.neighbours(cell) {
                if self.is_open[beside] && self.steps[beside] == u32::MAX {
                    self.steps[beside] = self.steps[cell] + 1;
                    reached.push(beside);
                    queue.push_back(beside);
                    if until(beside, self.steps[beside]) {
                        break 'all;
                    }
                }
            }
        }
        reached
    }

    /// Marks what is around a cell as visited; the number of new cells.
    fn visit(&mut self, cell: usize, is_visited: &mut [bool]) -> usize {
        let reached = self.search(cell, |_, steps| steps > VISITED_CELLS);
        let mut n = 0;
        for &k in &reached {
            n += usize::from(!is_visited[k]);
            is_visited[k] = true;
            self.steps[k] = u32::MAX;
        }
        n
    }

    /// The shortest way to the nearest cell that is wanted, without the start.
    fn way_to(&mut self, start: usize, wanted: impl Fn(usize) -> bool) -> Option<Vec<usize>> {
        let mut goal = None;
        let reached = self.search(start, |cell, _| {
            if wanted(cell) {
                goal = Some(cell);
            }
            goal.is_some()
        });
        let way = goal.map(|goal| {
            let mut way = vec![goal];
            let mut cell = goal;
            while self.steps[cell] > 1 {
                let before = self.steps[cell] - 1;
                cell = self.neighbours(cell).find(|&b| self.steps[b] == before).expect("a search leaves a way back");
                way.push(cell);
            }
            way.reverse();
            way
        });
        reached.iter().for_each(|&k| self.steps[k] = u32::MAX);
        way
    }

    fn middle(&self, cell: usize) -> Vector {
        let [x, y] = [cell % self.width, cell / self.width].map(|c| (c as f64 + 0.5) * STEP_M);
        [self.origin[0] + x, self.origin[1] + y]
    }

    /// Metres along the way, corners cut where there is floor.
    fn smoothed(&self, way: &[usize]) -> Vec<Vector> {
        let of = |k: usize| {
            let around = &way[k.saturating_sub(3)..(k + 4).min(way.len())];
            let whole = around.iter().fold([0.0; 2], |s, &cell| sum(s, self.middle(cell)));
            let mean = scaled(whole, 1.0 / around.len() as f64);
            let [x, y] = [0, 1].map(|axis| ((mean[axis] - self.origin[axis]) / STEP_M) as usize);
            if self.is_open[y * self.width + x] { mean } else { self.middle(way[k]) }
        };
        (0..way.len()).map(of).collect()
    }
}

/// Points of a line by number at this distance from each other, more or less; with the length of the line until each.
fn spaced(line: &[Vector], spacing_m: f64, random: &mut RandomGenerator) -> Vec<(usize, f64)> {
    let mut places = vec![(0, 0.0)];
    let mut wanted = spacing_m;
    let (mut driven, mut whole) = (0.0, 0.0);
    for (k, pair) in line.windows(2).enumerate() {
        let step = distance(pair[0], pair[1]);
        driven += step;
        whole += step;
        if driven >= wanted {
            places.push((k + 1, whole));
            driven = 0.0;
            wanted = spacing_m * random.between(0.8, 1.2);
        }
    }
    places
}

/// Directions of travel; the robot turns on the spot for its first scan.
fn headings(places: &[Vector], random: &mut RandomGenerator) -> Vec<Vector> {
    let mut headings = Vec::with_capacity(places.len());
    let mut last = direction_of(random.between(0.0, std::f64::consts::TAU));
    for k in 0..places.len() {
        if let Some(next) = places.get(k + 1) {
            let length = distance(*next, places[k]);
            if length > 1e-6 {
                last = scaled(difference(*next, places[k]), 1.0 / length);
            }
        }
        let sway = direction_of(0.06 * random.normal());
        headings.push(turned(last, sway));
    }
    headings
}
