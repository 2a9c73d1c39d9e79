//! A tour through places of one part of a storey, over the floor.

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

/// Ways from a place are looked for until this many places are found; what is farther goes over those.
const N_NEAR: usize = 8;

/// A way over cells is at most this much longer than the straight one between its ends: steps of 5 along a side and 7 across
/// a corner.
const LONGEST_DETOUR: f64 = 1.09;

/// An order in which to visit places that can all be got to from one another.
pub(crate) fn trip(
    walk: &Walk,
    stops: &[Point2<Map>],
    start: Option<Point2<Map>>,
    is_closed: bool,
    kicks: u32,
) -> Trip {
    let points: Vec<Point2<Map>> = stops.iter().copied().chain(start).collect();
    let distances = Distances::between(walk, &points);
    let start = start.map(|_| stops.len());
    let tour =
        Tour { distance_mm: &distances.millimetres, least_mm: &distances.least_mm, n: points.len(), start, is_closed };
    let order = tour.order(kicks);
    let places = order.places.into_iter().filter(|p| Some(*p) != start).collect();
    Trip { order: places, bound_m: order.bound_mm as f64 / 1000.0 }
}

/// The shortest lines over the floor from each point to the next.
pub(crate) fn legs(walk: &Walk, points: &[Point2<Map>]) -> Vec<Vec<Point2<Map>>> {
    let leg = |scratch: &mut Scratch, pair: &[Point2<Map>]| {
        let mut line = vec![pair[0], pair[1]];
        if let [Some(from), Some(to)] = [pair[0], pair[1]].map(|p| walk.cell_near(p))
            && !walk.is_straight(from, to)
        {
            // From the end back: the way comes out in the right order.
            let targets = Targets::new(walk, std::iter::once(from));
            walk.ways(to, &targets, 1, scratch, |_, way| line = walk.pulled(way, pair[0], pair[1]));
        }
        line
    };
    let pairs: Vec<&[Point2<Map>]> = points.windows(2).collect();
    pairs.into_par_iter().map_init(Scratch::default, leg).collect()
}

/// Distances over the floor between all points.
struct Distances {
    millimetres: Vec<u32>,
    least_mm: Vec<u32>,
}

impl Distances {
    fn between(walk: &Walk, points: &[Point2<Map>]) -> Self {
        let n = points.len();
        let cells: Vec<usize> = points.iter().map(|p| walk.cell_near(*p).unwrap_or(0)).collect();
        let targets = Targets::new(walk, cells.iter().copied());
        // What each finds: its nearest, and how far it looked.
        let search = |scratch: &mut Scratch, from: usize| {
            let mut near: Vec<(usize, u32)> = Vec::new();
            let mm = |line: &[Point2<Map>]| (length_m(line) * 1000.0).round() as u32;
            // What can be driven to straight is known without a search.
            let is_straight = |&to: &usize| to != from && walk.is_straight(cells[from], cells[to]);
            near.extend((0..n).filter(is_straight).map(|to| (to, mm(&[points[from], points[to]]))));
            if near.len() + 1 == n {
                return (near, f64::INFINITY);
            }
            let looked_m = walk.ways(cells[from], &targets, N_NEAR, scratch, |to, way| {
                near.push((to, mm(&walk.pulled(way, points[to], points[from]))));
            });
            (near, looked_m)
        };
        let found: Vec<(Vec<(usize, u32)>, f64)> = (0..n).into_par_iter().map_init(Scratch::default, search).collect();
        let mut millimetres = vec![NO_WAY; n * n];
        for (from, (near, _)) in found.iter().enumerate() {
            for &(to, mm) in near {
                // The two ways around may be pulled straight in two ways.
                let shorter = mm.min(millimetres[to * n + from]);
                (millimetres[to * n + from], millimetres[from * n + to]) = (shorter, shorter);
            }
            millimetres[from * n + from] = 0;
        }
        let mut least_mm = millimetres.clone();
        for a in 0..n {
            for b in (0..n).filter(|b| millimetres[a * n + b] == NO_WAY) {
                let looked_m = found[a].1.max(found[b].1);
                least_mm[a * n + b] = (looked_m / LONGEST_DETOUR * 1000.0) as u32;
            }
        }
        complete(&mut millimetres, n);
        Self { millimetres, least_mm }
    }
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
