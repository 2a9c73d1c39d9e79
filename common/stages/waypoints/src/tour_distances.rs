//! Path lengths between the places of a tour: paths over the borders of neighbouring regions, shorter lines near each place,
//! and sums of both for places that are far apart.

use crate::drive_cost::{cheapest_line, line_cost, step_cost};
use crate::free_space::FreeSpace;
use crate::path_search::{KEPT_OFF_FACTOR, NO_PATH, PathGrid, SIDE, SearchBuffers, length_m};
use crate::place_regions::{Border, PlaceRegions};
use crate::tour::TourProblem;
use crate::way_search::{WayCosts, WayStretch, least_costly};
use frames::{Map, Point2};
use messages::{DriveModel, WayCost};
use rayon::prelude::*;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// An order of places; lengths in metres.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct PlaceOrder {
    pub(crate) places: Vec<usize>,
    /// Lower bound of the length of any order of these places.
    pub(crate) bound_m: f64,
}

/// Maximum ratio of the length of a path over cells to the shortest line, with steps of 5 along a side and 7 across a
/// corner.
const MAX_DETOUR_FACTOR: f64 = 1.09;

/// Number of nearest places to which a shorter line than the sum of paths is looked for.
const N_NEAR: usize = 10;

/// All waypoints of a storey, with the regions around them.
pub(crate) struct StoreyPlaces<'a> {
    path_grid: &'a PathGrid,
    points: Vec<Point2<Map>>,
    cells: Vec<usize>,
    regions: PlaceRegions,
}

impl<'a> StoreyPlaces<'a> {
    pub(crate) fn of(path_grid: &'a PathGrid, points: Vec<Point2<Map>>) -> Self {
        let cells: Vec<usize> = points.iter().map(|p| path_grid.cell_near(*p).unwrap_or(0)).collect();
        let regions = PlaceRegions::of(path_grid, &cells);
        Self { path_grid, points, cells, regions }
    }

    /// Path lengths between some of the places that can be reached from each other; ascending.
    pub(crate) fn distances(&self, places: &[usize]) -> TourDistances {
        let n = places.len();
        let direct = self.direct_paths(places);
        let mut lengths = Lengths { paths: vec![Vec::new(); n] };
        direct.iter().for_each(|path| lengths.add(path.ends, path.mm));
        let shorter: Vec<Vec<([usize; 2], u32)>> =
            (0..n).into_par_iter().map(|at| self.shorter_lines(places, at, &direct, &lengths)).collect();
        shorter.into_iter().flatten().for_each(|(ends, mm)| lengths.add(ends, mm));
        TourDistances { n, distance_mm: lengths.all(), lower_bound_mm: self.lower_bounds(places, &direct) }
    }

    /// The paths between places with neighbouring regions, and between those in one cell.
    fn direct_paths(&self, places: &[usize]) -> Vec<DirectPath<'_>> {
        let position = |place: u32| places.binary_search(&(place as usize)).ok();
        let ends = |border: &Border| Some([position(border.places[0])?, position(border.places[1])?]);
        let over_border = |border| ends(border).map(|ends| (ends, Some(border)));
        let mut by_cell: Vec<(usize, usize)> = places.iter().map(|&place| self.cells[place]).zip(0..).collect();
        by_cell.sort_unstable();
        // The first of a cell has its region.
        let in_one_cell = by_cell
            .chunk_by(|a, b| a.0 == b.0)
            .flat_map(|same| same[1..].iter().map(|other| ([same[0].1, other.1], None)));
        let mut all: Vec<([usize; 2], Option<&Border>)> =
            self.regions.borders.iter().filter_map(over_border).chain(in_one_cell).collect();
        all.sort_unstable_by_key(|path| path.0);
        all.into_par_iter().map(|(ends, border)| self.direct_path(places, ends, border)).collect()
    }

    fn direct_path<'b>(&self, places: &[usize], ends: [usize; 2], border: Option<&'b Border>) -> DirectPath<'b> {
        let cells = border.map_or(Vec::new(), |border| self.regions.path(border));
        let mm = self.line_mm(ends.map(|end| places[end]), &cells);
        DirectPath { ends, cost: border.map_or(0, |border| border.cost), mm, border }
    }

    /// Length of the line between two places: straight, or pulled tight along the cells between.
    fn line_mm(&self, [a, b]: [usize; 2], cells: &[usize]) -> u32 {
        let [from, to] = [a, b].map(|place| self.points[place]);
        let is_straight = cells.is_empty() || self.path_grid.is_clear(from, to);
        let line_m =
            if is_straight { from.distance_m(&to) } else { length_m(&self.path_grid.pull_string(cells, from, to)) };
        (line_m * 1000.0).round() as u32
    }

    /// Lines from a place to the nearest ones behind its neighbours that are shorter than the sum of the paths.
    fn shorter_lines(
        &self,
        places: &[usize],
        from: usize,
        direct: &[DirectPath<'_>],
        lengths: &Lengths,
    ) -> Vec<([usize; 2], u32)> {
        let near = lengths.nearest(from, N_NEAR);
        let mut lines = Vec::new();
        for (to, before, mm) in near.iter().copied().filter(|(to, before, _)| *before != from && from < *to) {
            let mut hops = vec![[before, to]];
            let mut at = before;
            while let Some(&(_, before, _)) = near.iter().find(|(to, ..)| *to == at) {
                hops.push([before, at]);
                at = before;
            }
            let cells: Vec<usize> = hops.iter().rev().flat_map(|&hop| self.cells_between(direct, hop)).collect();
            let shorter = self.line_mm([places[from], places[to]], &cells);
            if shorter < mm {
                lines.push(([from, to], shorter));
            }
        }
        lines
    }

    /// The cells of the path over the border between two places, the first one's first.
    fn cells_between(&self, direct: &[DirectPath<'_>], [a, b]: [usize; 2]) -> Vec<usize> {
        let ends = [a.min(b), a.max(b)];
        let path = direct.binary_search_by_key(&ends, |path| path.ends).ok().and_then(|k| direct[k].border);
        let mut cells = path.map_or(Vec::new(), |border| self.regions.path(border));
        if a > b {
            cells.reverse();
        }
        cells
    }

    /// Lower bounds of the path lengths between all places: straight lines, and the longest path of a spanning tree between
    /// two places, because a shorter way over other regions crosses a border at least as far away.
    fn lower_bounds(&self, places: &[usize], direct: &[DirectPath<'_>]) -> Vec<u32> {
        let n = places.len();
        // A path within distances that the robot keeps costs more than its length.
        let dearest = if self.path_grid.keeps_distances() { f64::from(KEPT_OFF_FACTOR) } else { 1.0 };
        let cell_mm = self.path_grid.resolution_m() * 1000.0 / f64::from(SIDE) / MAX_DETOUR_FACTOR / dearest;
        let mut bounds = vec![0; n * n];
        for (a, row) in bounds.chunks_exact_mut(n.max(1)).enumerate() {
            let from = self.points[places[a]];
            row.iter_mut().zip(places).for_each(|(mm, &to)| *mm = (from.distance_m(&self.points[to]) * 1000.0) as u32);
        }
        let tree = spanning_tree(n, direct);
        for start in 0..n {
            let mut waiting = vec![(start, start, 0)];
            while let Some((at, before, cost)) = waiting.pop() {
                let bound = &mut bounds[start * n + at];
                *bound = (*bound).max((f64::from(cost) * cell_mm) as u32);
                let onward = tree[at].iter().filter(|(to, _)| *to != before);
                waiting.extend(onward.map(|&(to, step)| (to, at, cost.max(step))));
            }
        }
        bounds
    }
}

/// A path between two places, given by their positions, the lower one first.
struct DirectPath<'a> {
    ends: [usize; 2],
    /// In steps over cells.
    cost: u32,
    mm: u32,
    /// None within one cell.
    border: Option<&'a Border>,
}

/// Neighbours of each place in a minimum spanning tree, with the costs of the paths.
fn spanning_tree(n: usize, direct: &[DirectPath<'_>]) -> Vec<Vec<(usize, u32)>> {
    let mut sorted: Vec<&DirectPath<'_>> = direct.iter().collect();
    sorted.sort_by_key(|path| (path.cost, path.ends));
    let mut root: Vec<usize> = (0..n).collect();
    let find = |root: &mut [usize], mut at: usize| {
        while root[at] != at {
            root[at] = root[root[at]];
            at = root[at];
        }
        at
    };
    let mut tree = vec![Vec::new(); n];
    for path in sorted {
        let [a, b] = path.ends.map(|end| find(&mut root, end));
        if a != b {
            root[a] = b;
            let [a, b] = path.ends;
            tree[a].push((b, path.cost));
            tree[b].push((a, path.cost));
        }
    }
    tree
}

/// Known path lengths between places in millimetres.
struct Lengths {
    /// By place: other places and lengths.
    paths: Vec<Vec<(usize, u32)>>,
}

impl Lengths {
    fn add(&mut self, [a, b]: [usize; 2], mm: u32) {
        self.paths[a].push((b, mm));
        self.paths[b].push((a, mm));
    }

    /// The nearest places of a place, itself left out: each with the place before it and the length.
    fn nearest(&self, from: usize, n: usize) -> Vec<(usize, usize, u32)> {
        let mut found: Vec<(usize, usize, u32)> = Vec::new();
        let mut heap = BinaryHeap::from([Reverse((0u32, from, from))]);
        while let Some(Reverse((mm, at, before))) = heap.pop() {
            if found.iter().any(|known| known.0 == at) || (at == from && before != from) {
                continue;
            }
            if at != from {
                found.push((at, before, mm));
            }
            if found.len() == n {
                break;
            }
            heap.extend(self.paths[at].iter().map(|&(to, further)| Reverse((mm + further, to, at))));
        }
        found
    }

    /// Lengths of the shortest sums of paths between all places, row-major.
    fn all(&self) -> Vec<u32> {
        let n = self.paths.len();
        let mut millimetres = vec![NO_PATH; n * n];
        millimetres.par_chunks_exact_mut(n.max(1)).enumerate().for_each(|(from, row)| {
            row[from] = 0;
            let mut heap = BinaryHeap::from([Reverse((0, from))]);
            while let Some(Reverse((mm, at))) = heap.pop() {
                if mm > row[at] {
                    continue;
                }
                for &(to, further) in &self.paths[at] {
                    if mm + further < row[to] {
                        row[to] = mm + further;
                        heap.push(Reverse((mm + further, to)));
                    }
                }
            }
        });
        millimetres
    }
}

/// Path lengths between all places of a tour, row-major.
pub(crate) struct TourDistances {
    n: usize,
    distance_mm: Vec<u32>,
    /// Lower bounds of the lengths.
    lower_bound_mm: Vec<u32>,
}

impl TourDistances {
    /// A short order of the places; without the start, if one is given.
    pub(crate) fn order(&self, start: Option<usize>, is_closed: bool, kicks: u32) -> PlaceOrder {
        let Self { n, distance_mm, lower_bound_mm } = self;
        let order = TourProblem { distance_mm, lower_bound_mm, n: *n, start, is_closed }.order(kicks);
        let places = order.places.into_iter().filter(|place| Some(*place) != start).collect();
        PlaceOrder { places, bound_m: order.bound_mm as f64 / 1000.0 }
    }
}

/// The lines over the free space between pairs of points that are the shortest, or take the least time or energy.
pub(crate) fn legs(
    path_grid: &PathGrid,
    free_space: &FreeSpace,
    drive: &DriveModel,
    pairs: &[[Point2<Map>; 2]],
) -> Vec<Vec<Point2<Map>>> {
    let shortest = |buffers: &mut SearchBuffers, &[from, to]: &[Point2<Map>; 2]| {
        if let [Some(first), Some(last)] = [from, to].map(|p| path_grid.cell_near(p))
            && !path_grid.is_clear(from, to)
        {
            path_grid.pull_string(&path_grid.shortest_path(first, last, buffers), from, to)
        } else {
            vec![from, to]
        }
    };
    let leg = |buffers: &mut SearchBuffers, pair: &[Point2<Map>; 2]| {
        let shortest = shortest(buffers, pair);
        match cheap_leg(path_grid, free_space, drive, *pair) {
            Some(cheap) if line_cost(drive, free_space, &cheap) < line_cost(drive, free_space, &shortest) => cheap,
            _ => shortest,
        }
    };
    // Buffers are as large as the storey: one for each thread.
    let chunk = pairs.len().div_ceil(rayon::current_num_threads()).max(1);
    let legs_of = |pairs: &[[Point2<Map>; 2]]| {
        let mut buffers = SearchBuffers::of(path_grid);
        pairs.iter().map(|pair| leg(&mut buffers, pair)).collect::<Vec<_>>()
    };
    pairs.par_chunks(chunk).flat_map_iter(legs_of).collect()
}

/// The line between two points that takes the least time or energy; `None` where that is the shortest by itself.
fn cheap_leg(
    path_grid: &PathGrid,
    free_space: &FreeSpace,
    drive: &DriveModel,
    [from, to]: [Point2<Map>; 2],
) -> Option<Vec<Point2<Map>>> {
    if drive.cost == WayCost::Length || free_space.is_level() {
        return None;
    }
    let [first, last] = [path_grid.cell_near(from)?, path_grid.cell_near(to)?];
    let step = |_, cells: [usize; 2], step: u32| step_cost(drive, free_space, path_grid, cells, step);
    let costs = WayCosts { step: &step, portal: &|_, _| NO_PATH };
    let found = least_costly(&[Some(path_grid)], &[], &costs, |_| [None; 2], (0, first), (0, last))?;
    let [WayStretch::Floor(_, cells)] = &found[..] else { return None };
    Some(cheapest_line(drive, free_space, path_grid, cells, [from, to]))
}
