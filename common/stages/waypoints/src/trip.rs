//! Tour over one connected part of a storey, with path lengths over its floor.

use crate::tour::Tour;
use crate::walk::{NO_WAY, Scratch, Targets, Walk, length_m};
use frames::{Map, Point2};
use rayon::prelude::*;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Places in order. Lengths in metres.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Trip {
    pub(crate) order: Vec<usize>,
    /// No order of these places is shorter.
    pub(crate) bound_m: f64,
}

/// A way over cells is at most this much longer than the straight one between its ends: steps of 5 along a side and 7 across
/// a corner.
const LONGEST_DETOUR: f64 = 1.09;

/// Places that can all be got to from one another, and what is known of the ways between them. Places are added one after the
/// other; ways that are known stay known.
pub(crate) struct Ways<'a> {
    walk: &'a Walk,
    /// Ways around something are looked for until this many are found; what is farther goes over other places.
    n_around: usize,
    points: Vec<Point2<Map>>,
    cells: Vec<usize>,
    /// By place: places that were found from it, with lengths in millimetres.
    near: Vec<Vec<(usize, u32)>>,
    /// By place: how far all around was looked, and how many places there were.
    looked: Vec<(f64, usize)>,
}

impl<'a> Ways<'a> {
    pub(crate) fn over(walk: &'a Walk, n_around: usize) -> Self {
        Self { walk, n_around, points: Vec::new(), cells: Vec::new(), near: Vec::new(), looked: Vec::new() }
    }

    /// Adds places, and returns the number of the first.
    pub(crate) fn add(&mut self, points: impl IntoIterator<Item = Point2<Map>>) -> usize {
        let first = self.points.len();
        self.points.extend(points);
        let walk = self.walk;
        self.cells.extend(self.points[first..].iter().map(|p| walk.cell_near(*p).unwrap_or(0)));
        let n = self.points.len();
        let targets = Targets::new(walk, self.cells.iter().copied());
        let search = |scratch: &mut Scratch, from: usize| self.search(from, &targets, scratch);
        let found: Vec<(Vec<(usize, u32)>, f64)> =
            (first..n).into_par_iter().map_init(Scratch::default, search).collect();
        for (near, looked_m) in found {
            self.near.push(near);
            self.looked.push((looked_m, n));
        }
        first
    }

    /// What is found from a place: all that can be driven to straight, and the nearest of the others.
    fn search(&self, from: usize, targets: &Targets, scratch: &mut Scratch) -> (Vec<(usize, u32)>, f64) {
        let Self { walk, points, cells, .. } = self;
        let mm = |line: &[Point2<Map>]| (length_m(line) * 1000.0).round() as u32;
        let is_straight = |&to: &usize| to != from && walk.is_clear(points[from], points[to]);
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
        let looked_m = walk.ways(
            cells[from],
            targets,
            |to| !is_known[to],
            enough,
            scratch,
            |to, way| {
                near.push((to, mm(&walk.pulled(way, points[to], points[from]))));
            },
        );
        let looked_m = if enough == n_unknown { f64::INFINITY } else { looked_m };
        (near, looked_m)
    }

    /// An order in which to visit these places.
    pub(crate) fn trip(&self, places: &[usize], start: Option<usize>, is_closed: bool, kicks: u32) -> Trip {
        let numbers: Vec<usize> = places.iter().copied().chain(start).collect();
        let all = self.distances();
        let (distance_mm, least_mm) = (all.of(&numbers, &all.millimetres), all.of(&numbers, &all.least_mm));
        let start = start.map(|_| places.len());
        let tour = Tour { distance_mm: &distance_mm, least_mm: &least_mm, n: numbers.len(), start, is_closed };
        let order = tour.order(kicks);
        let order_of_places = order.places.into_iter().filter(|p| Some(*p) != start).collect();
        Trip { order: order_of_places, bound_m: order.bound_mm as f64 / 1000.0 }
    }

    fn distances(&self) -> Distances {
        let n = self.points.len();
        let mut millimetres = vec![NO_WAY; n * n];
        for (from, near) in self.near.iter().enumerate() {
            for &(to, mm) in near {
                // The two ways around may be pulled straight in two ways.
                let shorter = mm.min(millimetres[to * n + from]);
                (millimetres[to * n + from], millimetres[from * n + to]) = (shorter, shorter);
            }
            millimetres[from * n + from] = 0;
        }
        let mut least_mm = millimetres.clone();
        let looked_m = |from: usize, to: usize| {
            let (looked_m, n_known) = self.looked[from];
            if to < n_known { looked_m } else { 0.0 }
        };
        for a in 0..n {
            for b in (0..n).filter(|b| millimetres[a * n + b] == NO_WAY) {
                least_mm[a * n + b] = (looked_m(a, b).max(looked_m(b, a)) / LONGEST_DETOUR * 1000.0) as u32;
            }
        }
        complete(&mut millimetres, n);
        Distances { n, millimetres, least_mm }
    }
}

/// Distances over the floor between all places, row-major.
struct Distances {
    n: usize,
    millimetres: Vec<u32>,
    /// What they cannot be below.
    least_mm: Vec<u32>,
}

impl Distances {
    /// Those between some places.
    fn of(&self, numbers: &[usize], all: &[u32]) -> Vec<u32> {
        numbers.iter().flat_map(|a| numbers.iter().map(move |b| all[a * self.n + b])).collect()
    }
}

/// The shortest lines over the floor from each point to the next.
pub(crate) fn legs(walk: &Walk, points: &[Point2<Map>]) -> Vec<Vec<Point2<Map>>> {
    let leg = |scratch: &mut Scratch, pair: &[Point2<Map>]| {
        let mut line = vec![pair[0], pair[1]];
        if let [Some(from), Some(to)] = [pair[0], pair[1]].map(|p| walk.cell_near(p))
            && !walk.is_clear(pair[0], pair[1])
        {
            // From the end back: the way comes out in the right order.
            let targets = Targets::new(walk, std::iter::once(from));
            walk.ways(to, &targets, |_| true, 1, scratch, |_, way| line = walk.pulled(way, pair[0], pair[1]));
        }
        line
    };
    let pairs: Vec<&[Point2<Map>]> = points.windows(2).collect();
    pairs.into_par_iter().map_init(Scratch::default, leg).collect()
}

/// Distances that are missing, over the places between.
fn complete(millimetres: &mut [u32], n: usize) {
    let near: Vec<Vec<(usize, u32)>> = (0..n)
        .map(|a| (0..n).map(|b| (b, millimetres[a * n + b])).filter(|(b, mm)| *b != a && *mm != NO_WAY).collect())
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
