//! TourProblem over one connected part of a storey, with path lengths over its floor.

use crate::path_search::{NO_PATH, PathGrid, SearchBuffers, Targets, length_m};
use crate::tour::TourProblem;
use frames::{Map, Point2};
use rayon::prelude::*;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// An order of places; lengths in metres.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct PlaceOrder {
    pub(crate) order: Vec<usize>,
    /// Lower bound of the length of any order of these places.
    pub(crate) bound_m: f64,
}

/// Maximum ratio of the length of a path over cells to the shortest line, with steps of 5 along a side and 7 across a
/// corner.
const MAX_DETOUR_FACTOR: f64 = 1.09;

/// Mutually reachable places with the path lengths known between them. Places can be added; known path lengths are kept.
pub(crate) struct TourDistances<'a> {
    path_grid: &'a PathGrid,
    /// Number of nearest places without a straight line to which paths are searched; farther distances are composed of
    /// shorter ones.
    n_around: usize,
    points: Vec<Point2<Map>>,
    cells: Vec<usize>,
    /// By place: places found from it, with path lengths in millimetres.
    near: Vec<Vec<(usize, u32)>>,
    /// By place: radius in metres within which all places were found, and the number of places at that time.
    looked: Vec<(f64, usize)>,
}

impl<'a> TourDistances<'a> {
    pub(crate) fn over(path_grid: &'a PathGrid, n_around: usize) -> Self {
        Self { path_grid, n_around, points: Vec::new(), cells: Vec::new(), near: Vec::new(), looked: Vec::new() }
    }

    /// Adds places and returns the index of the first.
    pub(crate) fn add(&mut self, points: impl IntoIterator<Item = Point2<Map>>) -> usize {
        let first = self.points.len();
        self.points.extend(points);
        let path_grid = self.path_grid;
        self.cells.extend(self.points[first..].iter().map(|p| path_grid.cell_near(*p).unwrap_or(0)));
        let n = self.points.len();
        let targets = Targets::new(path_grid, self.cells.iter().copied());
        let search = |buffers: &mut SearchBuffers, from: usize| self.search(from, &targets, buffers);
        let found: Vec<(Vec<(usize, u32)>, f64)> =
            (first..n).into_par_iter().map_init(SearchBuffers::default, search).collect();
        for (near, looked_m) in found {
            self.near.push(near);
            self.looked.push((looked_m, n));
        }
        first
    }

    /// Path lengths from a place: to all with a straight line, and to the nearest of the others.
    fn search(&self, from: usize, targets: &Targets, buffers: &mut SearchBuffers) -> (Vec<(usize, u32)>, f64) {
        let Self { path_grid, points, cells, .. } = self;
        let mm = |line: &[Point2<Map>]| (length_m(line) * 1000.0).round() as u32;
        let is_straight = |&to: &usize| to != from && path_grid.is_clear(points[from], points[to]);
        let straight = (0..points.len()).filter(is_straight);
        let mut near: Vec<(usize, u32)> = straight.map(|to| (to, mm(&[points[from], points[to]]))).collect();
        if near.len() + 1 == points.len() {
            return (near, f64::INFINITY);
        }
        let mut is_known = vec![false; points.len()];
        near.iter().for_each(|(to, _)| is_known[*to] = true);
        is_known[from] = true;
        let n_unknown = is_known.iter().filter(|known| !**known).count();
        let enough = self.n_around.min(n_unknown);
        let looked_m = path_grid.shortest_paths(
            cells[from],
            targets,
            |to| !is_known[to],
            enough,
            buffers,
            |to, path| {
                near.push((to, mm(&path_grid.pull_string(path, points[to], points[from]))));
            },
        );
        let looked_m = if enough == n_unknown { f64::INFINITY } else { looked_m };
        (near, looked_m)
    }

    /// A short order of these places.
    pub(crate) fn order(&self, places: &[usize], start: Option<usize>, is_closed: bool, kicks: u32) -> PlaceOrder {
        let numbers: Vec<usize> = places.iter().copied().chain(start).collect();
        let all = self.distances();
        let (distance_mm, lower_bound_mm) = (all.of(&numbers, &all.millimetres), all.of(&numbers, &all.lower_bound_mm));
        let start = start.map(|_| places.len());
        let tour = TourProblem {
            distance_mm: &distance_mm,
            lower_bound_mm: &lower_bound_mm,
            n: numbers.len(),
            start,
            is_closed,
        };
        let order = tour.order(kicks);
        let order_of_places = order.places.into_iter().filter(|p| Some(*p) != start).collect();
        PlaceOrder { order: order_of_places, bound_m: order.bound_mm as f64 / 1000.0 }
    }

    fn distances(&self) -> DistanceMatrix {
        let n = self.points.len();
        let mut millimetres = vec![NO_PATH; n * n];
        for (from, near) in self.near.iter().enumerate() {
            for &(to, mm) in near {
                // String pulling may give different lengths for the two directions.
                let shorter = mm.min(millimetres[to * n + from]);
                (millimetres[to * n + from], millimetres[from * n + to]) = (shorter, shorter);
            }
            millimetres[from * n + from] = 0;
        }
        let mut lower_bound_mm = millimetres.clone();
        let looked_m = |from: usize, to: usize| {
            let (looked_m, n_known) = self.looked[from];
            if to < n_known { looked_m } else { 0.0 }
        };
        for a in 0..n {
            for b in (0..n).filter(|b| millimetres[a * n + b] == NO_PATH) {
                lower_bound_mm[a * n + b] = (looked_m(a, b).max(looked_m(b, a)) / MAX_DETOUR_FACTOR * 1000.0) as u32;
            }
        }
        complete(&mut millimetres, n);
        DistanceMatrix { n, millimetres, lower_bound_mm }
    }
}

/// Path lengths between all places, row-major.
struct DistanceMatrix {
    n: usize,
    millimetres: Vec<u32>,
    /// Lower bounds of the lengths.
    lower_bound_mm: Vec<u32>,
}

impl DistanceMatrix {
    /// The submatrix of some places.
    fn of(&self, numbers: &[usize], all: &[u32]) -> Vec<u32> {
        numbers.iter().flat_map(|a| numbers.iter().map(move |b| all[a * self.n + b])).collect()
    }
}

/// The legs of a tour: the shortest line over the free space from each point to the next.
pub(crate) fn legs(path_grid: &PathGrid, points: &[Point2<Map>]) -> Vec<Vec<Point2<Map>>> {
    let leg = |buffers: &mut SearchBuffers, pair: &[Point2<Map>]| {
        let mut line = vec![pair[0], pair[1]];
        if let [Some(from), Some(to)] = [pair[0], pair[1]].map(|p| path_grid.cell_near(p))
            && !path_grid.is_clear(pair[0], pair[1])
        {
            // Searched from the end, so that the path has the right order.
            let targets = Targets::new(path_grid, std::iter::once(from));
            path_grid.shortest_paths(
                to,
                &targets,
                |_| true,
                1,
                buffers,
                |_, path| line = path_grid.pull_string(path, pair[0], pair[1]),
            );
        }
        line
    };
    let pairs: Vec<&[Point2<Map>]> = points.windows(2).collect();
    pairs.into_par_iter().map_init(SearchBuffers::default, leg).collect()
}

/// Completes missing path lengths over places between (Dijkstra).
fn complete(millimetres: &mut [u32], n: usize) {
    let near: Vec<Vec<(usize, u32)>> = (0..n)
        .map(|a| (0..n).map(|b| (b, millimetres[a * n + b])).filter(|(b, mm)| *b != a && *mm != NO_PATH).collect())
        .collect();
    if near.iter().all(|list| list.len() + 1 == n) {
        return;
    }
    millimetres.par_chunks_exact_mut(n).enumerate().for_each(|(from, row)| {
        let mut heap: BinaryHeap<Reverse<(u32, usize)>> =
            near[from].iter().map(|&(to, mm)| Reverse((mm, to))).collect();
        while let Some(Reverse((mm, at))) = heap.pop() {
            if mm > row[at] {
                continue;
            }
            for &(to, further) in &near[at] {
                let mm = mm + further;
                if mm < row[to] {
                    row[to] = mm;
                    heap.push(Reverse((mm, to)));
                }
            }
        }
    });
}
