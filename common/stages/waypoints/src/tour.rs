//! Travelling salesman problem: a short order of places by 2-opt, Or-opt and random kicks, and a lower bound of its length.

use crate::random_generator::RandomGenerator;

/// A travelling salesman problem. Distances are whole millimetres, so that sums are exact and searches end.
pub(crate) struct TourProblem<'a> {
    /// Distances between all places, row-major, symmetric.
    pub(crate) distance_mm: &'a [u32],
    /// Lower bounds of the distances; equal to them where they are exact.
    pub(crate) lower_bound_mm: &'a [u32],
    /// Number of places.
    pub(crate) n: usize,
    /// Place of the start, if fixed.
    pub(crate) start: Option<usize>,
    /// True if the tour returns to its start.
    pub(crate) is_closed: bool,
}

/// An order of places, with its length.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct TourOrder {
    pub(crate) places: Vec<usize>,
    pub(crate) length_mm: i64,
    /// Lower bound of the length of any order.
    pub(crate) bound_mm: i64,
}

/// Cost of the edge between the start and the extra node that closes an open tour, so that it is always used.
const FORCED_EDGE: i64 = -(1 << 40);

impl TourProblem<'_> {
    /// A short order, improved after each of `kicks` random kicks.
    pub(crate) fn order(&self, kicks: u32) -> TourOrder {
        if self.n == 0 {
            return TourOrder { places: Vec::new(), length_mm: 0, bound_mm: 0 };
        }
        let cycle = self.shortest_cycle(kicks);
        let places = self.cut(cycle);
        let length_mm = self.length_mm(&places);
        TourOrder { bound_mm: self.bound_mm(length_mm).min(length_mm), places, length_mm }
    }

    /// Length of an order.
    pub(crate) fn length_mm(&self, places: &[usize]) -> i64 {
        let legs: i64 = places.windows(2).map(|p| self.real(p[0], p[1])).sum();
        match (self.is_closed, places) {
            (true, [first, .., last]) => legs + self.real(*last, *first),
            _ => legs,
        }
    }

    fn real(&self, a: usize, b: usize) -> i64 {
        i64::from(self.distance_mm[a * self.n + b])
    }

    /// Number of nodes of the cycle; an open tour has an extra node at distance 0 from all places.
    fn n_nodes(&self) -> usize {
        self.n + usize::from(!self.is_closed)
    }

    fn between(&self, a: usize, b: usize) -> i64 {
        if a < self.n && b < self.n {
            self.real(a, b)
        } else if self.start == Some(a.min(b)) {
            FORCED_EDGE
        } else {
            0
        }
    }

    fn shortest_cycle(&self, kicks: u32) -> Vec<usize> {
        let n = self.n_nodes();
        let near = self.neighbours();
        let starts = (0..n).step_by(n.div_ceil(8).max(1));
        let tries = starts.map(|start| {
            let mut cycle = Cycle::new(self, &near, self.nearest_first(start));
            cycle.improve();
            cycle
        });
        let Some(mut best) = tries.min_by_key(Cycle::length) else { return Vec::new() };
        let (mut length, mut random) = (best.length(), RandomGenerator::default());
        for _ in 0..if n < 5 { 0 } else { kicks } {
            let kept = best.nodes.clone();
            best.kick(&mut random);
            best.improve();
            let now = best.length();
            if now > length {
                best.set(kept);
            } else {
                length = now;
            }
        }
        best.nodes
    }

    /// The nearest nodes of each node, nearest first.
    fn neighbours(&self) -> Vec<Vec<u32>> {
        const N_NEAR: usize = 12;
        let n = self.n_nodes();
        let near = |a: usize| {
            let mut others: Vec<u32> = (0..n as u32).filter(|&b| b as usize != a).collect();
            others.sort_by_key(|&b| (self.between(a, b as usize), b));
            others.truncate(N_NEAR);
            others
        };
        (0..n).map(near).collect()
    }

    fn nearest_first(&self, start: usize) -> Vec<usize> {
        let mut left: Vec<usize> = (0..self.n_nodes()).filter(|&k| k != start).collect();
        let mut cycle = vec![start];
        let mut at = start;
        while let Some(k) = (0..left.len()).min_by_key(|&k| (self.between(at, left[k]), left[k])) {
            at = left.swap_remove(k);
            cycle.push(at);
        }
        cycle
    }

    /// The order of places from a cycle of nodes.
    fn cut(&self, mut cycle: Vec<usize>) -> Vec<usize> {
        let first = if self.is_closed { self.start.unwrap_or(0) } else { self.n };
        let at = cycle.iter().position(|&k| k == first).unwrap_or(0);
        cycle.rotate_left(at);
        if !self.is_closed {
            cycle.remove(0);
            // An open tour without a start begins at the end with the lower index.
            let backwards = match self.start {
                Some(start) => cycle.first() != Some(&start),
                None => cycle.first() > cycle.last(),
            };
            if backwards {
                cycle.reverse();
            }
        }
        cycle
    }

    /// Held-Karp lower bound from 1-trees with node prices: a spanning tree over all nodes but one, and the two cheapest
    /// edges of that one.
    ///
    /// # Source
    /// Held and Karp, "The traveling-salesman problem and minimum spanning trees", Operations Research 18, 1970.
    fn bound_mm(&self, length_mm: i64) -> i64 {
        let n = self.n_nodes();
        if n < 3 {
            return length_mm;
        }
        let forced = if self.is_closed { None } else { self.start };
        let mut prices = vec![0i64; n];
        let mut best = 0;
        let n_rounds = (20_000_000 / (n * n)).clamp(1, 120);
        let mut step = (length_mm / (2 * n as i64)).max(1);
        for _ in 0..n_rounds {
            let (weight, degree) = self.one_tree(&prices, forced);
            best = best.max(weight - 2 * prices.iter().sum::<i64>());
            if degree.iter().all(|d| *d == 2) {
                break;
            }
            for (price, degree) in prices.iter_mut().zip(&degree) {
                *price += step * (i64::from(*degree) - 2);
            }
            step = (step * 19 / 20).max(1);
        }
        best
    }

    /// Weight and node degrees of the minimum 1-tree with prices, whose special node is the last.
    fn one_tree(&self, prices: &[i64], forced: Option<usize>) -> (i64, Vec<i32>) {
        let n = self.n_nodes();
        let cost = |a: usize, b: usize| {
            let length = if a < self.n && b < self.n {
                i64::from(self.lower_bound_mm[a * self.n + b])
            } else {
                self.between(a, b)
            };
            length + prices[a] + prices[b]
        };
        let (mut weight, mut degree) = (0, vec![0; n]);
        let mut nearest: Vec<(i64, usize)> = (0..n - 1).map(|k| (cost(0, k), 0)).collect();
        let mut left: Vec<usize> = (1..n - 1).collect();
        while let Some(k) = (0..left.len()).min_by_key(|&k| (nearest[left[k]].0, left[k])) {
            let node = left.swap_remove(k);
            let (edge, to) = nearest[node];
            weight += edge;
            degree[node] += 1;
            degree[to] += 1;
            for &other in &left {
                nearest[other] = nearest[other].min((cost(node, other), node));
            }
        }
        // The edge to the start is in every tour at no cost.
        let real = |k: usize| if forced == Some(k) { prices[k] + prices[n - 1] } else { cost(k, n - 1) };
        let mut ends: Vec<usize> = (0..n - 1).collect();
        ends.sort_by_key(|&k| (forced != Some(k), real(k), k));
        for &k in ends.iter().take(2) {
            weight += real(k);
            degree[k] += 1;
            degree[n - 1] += 1;
        }
        (weight, degree)
    }
}

/// A cycle of nodes, with the position of each node.
struct Cycle<'a> {
    tour: &'a TourProblem<'a>,
    near: &'a [Vec<u32>],
    nodes: Vec<usize>,
    position: Vec<usize>,
    /// Nodes around which an improvement is possible.
    waiting: Vec<usize>,
    is_waiting: Vec<bool>,
}

impl<'a> Cycle<'a> {
    fn new(tour: &'a TourProblem<'a>, near: &'a [Vec<u32>], nodes: Vec<usize>) -> Self {
        let n = nodes.len();
        let mut cycle = Self {
            tour,
            near,
            nodes: Vec::new(),
            position: vec![0; n],
            waiting: (0..n).rev().collect(),
            is_waiting: vec![true; n],
        };
        cycle.set(nodes);
        cycle
    }

    fn set(&mut self, nodes: Vec<usize>) {
        nodes.iter().zip(0..).for_each(|(&node, at)| self.position[node] = at);
        self.nodes = nodes;
    }

    fn length(&self) -> i64 {
        let n = self.nodes.len();
        (0..n).map(|k| self.tour.between(self.nodes[k], self.nodes[(k + 1) % n])).sum()
    }

    fn at(&self, position: usize) -> usize {
        self.nodes[position % self.nodes.len()]
    }

    /// Applies 2-opt and Or-opt until neither finds an improvement.
    fn improve(&mut self) {
        while let Some(node) = self.waiting.pop() {
            self.is_waiting[node] = false;
            while self.two_opt(node) || self.or_opt(node) {}
        }
    }

    fn wake(&mut self, node: usize) {
        if !std::mem::replace(&mut self.is_waiting[node], true) {
            self.waiting.push(node);
        }
    }

    /// 2-opt: exchanges two edges, one of them at the node, for two others.
    fn two_opt(&mut self, a: usize) -> bool {
        let (n, d) = (self.nodes.len(), |a, b| self.tour.between(a, b));
        if n < 4 {
            return false;
        }
        for forward in [true, false] {
            let beside = |cycle: &Self, node: usize| cycle.at(cycle.position[node] + if forward { 1 } else { n - 1 });
            let b = beside(self, a);
            for k in 0..self.near[a].len() {
                let c = self.near[a][k] as usize;
                if d(a, c) >= d(a, b) {
                    break;
                }
                let e = beside(self, c);
                if c == b || e == a || d(a, c) + d(b, e) >= d(a, b) + d(c, e) {
                    continue;
                }
                // Forward a-b .. c-e becomes a-c .. b-e; backward is symmetric.
                let (from, to) =
                    if forward { (self.position[b], self.position[c]) } else { (self.position[a], self.position[e]) };
                self.reverse(from, to);
                [a, b, c, e].into_iter().for_each(|node| self.wake(node));
                return true;
            }
        }
        false
    }

    /// Reverses the nodes between two positions, or all others, which gives the same cycle.
    fn reverse(&mut self, from: usize, to: usize) {
        let n = self.nodes.len();
        let inner = (to + n - from) % n + 1;
        let (mut i, mut j, length) =
            if inner * 2 <= n { (from, to, inner) } else { ((to + 1) % n, (from + n - 1) % n, n - inner) };
        for _ in 0..length / 2 {
            self.nodes.swap(i, j);
            (self.position[self.nodes[i]], self.position[self.nodes[j]]) = (i, j);
            (i, j) = ((i + 1) % n, (j + n - 1) % n);
        }
    }

    /// Or-opt: moves one to three nodes from this one on between two others, in either direction.
    fn or_opt(&mut self, first: usize) -> bool {
        let (n, d) = (self.nodes.len(), |a, b| self.tour.between(a, b));
        for length in 1..=3 {
            if n < length + 3 {
                return false;
            }
            for forward in [true, false] {
                let step = |cycle: &Self, node: usize, by: usize| {
                    cycle.at(cycle.position[node] + if forward { by } else { n - by })
                };
                let segment: Vec<usize> = (0..length).map(|by| step(self, first, by)).collect();
                let last = segment[length - 1];
                let (before, after) = (step(self, first, n - 1), step(self, last, 1));
                let gain = d(before, first) + d(last, after) - d(before, after);
                for k in 0..self.near[first].len() {
                    let c = self.near[first][k] as usize;
                    if d(first, c) >= gain {
                        break;
                    }
                    if segment.contains(&c) {
                        continue;
                    }
                    // First comes beside c; last beside the one before or after it.
                    for e in [step(self, c, 1), step(self, c, n - 1)] {
                        let is_gap = segment.contains(&e) || (c == before && e == after) || (c == after && e == before);
                        if !is_gap && d(first, c) + d(last, e) - d(c, e) < gain {
                            self.move_between(&segment, c, e);
                            [before, after, c, e].into_iter().chain(segment).for_each(|node| self.wake(node));
                            return true;
                        }
                    }
                }
            }
        }
        false
    }

    /// The segment between c and e, its first node beside c.
    fn move_between(&mut self, segment: &[usize], c: usize, e: usize) {
        let n = self.nodes.len();
        let e_follows = self.at(self.position[c] + 1) == e;
        let start = self.position[if e_follows { c } else { e }];
        let rest: Vec<usize> = (1..n).map(|k| self.at(start + k)).filter(|node| !segment.contains(node)).collect();
        let head = self.nodes[start];
        let mut nodes = vec![head];
        if e_follows {
            nodes.extend(segment);
        } else {
            nodes.extend(segment.iter().rev());
        }
        nodes.extend(rest);
        self.set(nodes);
    }

    /// Exchanges two short adjacent segments at a random position (double bridge), which 2-opt does not undo at once.
    fn kick(&mut self, random: &mut RandomGenerator) {
        let n = self.nodes.len();
        let longest = (n / 3).min(30);
        let lengths = [1 + random.below(longest), 1 + random.below(longest)];
        let start = random.below(n);
        let nodes: Vec<usize> = (0..n).map(|k| self.at(start + k)).collect();
        let (a, b) = (1 + lengths[0], 1 + lengths[0] + lengths[1]);
        let kicked = [&nodes[..1], &nodes[a..b], &nodes[1..a], &nodes[b..]].concat();
        let ends = [kicked[0], kicked[1], kicked[lengths[1]], kicked[lengths[1] + 1], kicked[b - 1], kicked[b % n]];
        self.set(kicked);
        ends.into_iter().for_each(|node| self.wake(node));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn distances(points: &[(u32, u32)]) -> Vec<u32> {
        let d = |a: &(u32, u32), b: &(u32, u32)| {
            f64::from(a.0.abs_diff(b.0)).hypot(f64::from(a.1.abs_diff(b.1))).round() as u32
        };
        points.iter().flat_map(|a| points.iter().map(move |b| d(a, b))).collect()
    }

    fn permutations(n: usize) -> Vec<Vec<usize>> {
        if n == 0 {
            return vec![Vec::new()];
        }
        let shorter = permutations(n - 1);
        shorter.iter().flat_map(|p| (0..n).map(move |at| [&p[..at], &[n - 1], &p[at..]].concat())).collect()
    }

    #[test]
    fn a_line_of_places_is_visited_from_end_to_end() {
        let points: Vec<(u32, u32)> = (0..30).map(|k| (k * 7 % 30 * 1000, 0)).collect();
        let distance_mm = distances(&points);
        let order = TourProblem {
            distance_mm: &distance_mm,
            lower_bound_mm: &distance_mm,
            n: 30,
            start: None,
            is_closed: false,
        }
        .order(50);
        assert_eq!((order.length_mm, order.bound_mm), (29_000, 29_000));
        let closed = TourProblem {
            distance_mm: &distance_mm,
            lower_bound_mm: &distance_mm,
            n: 30,
            start: Some(4),
            is_closed: true,
        }
        .order(50);
        assert_eq!((closed.length_mm, closed.places[0]), (58_000, 4));
    }

    #[test]
    fn places_on_a_circle_are_visited_around_it() {
        let at = |k: u32| f64::from(k * 17 % 40) * std::f64::consts::TAU / 40.0;
        let points: Vec<(u32, u32)> = (0..40)
            .map(|k| ((10_000.0 + 9_000.0 * libm::cos(at(k))) as u32, (10_000.0 + 9_000.0 * libm::sin(at(k))) as u32))
            .collect();
        let distance_mm = distances(&points);
        let order = TourProblem {
            distance_mm: &distance_mm,
            lower_bound_mm: &distance_mm,
            n: 40,
            start: None,
            is_closed: true,
        }
        .order(0);
        assert!(order.length_mm < 56_600, "the circle's length is 56.5 m: {}", order.length_mm);
        assert!(order.bound_mm * 100 > order.length_mm * 99, "{} of {}", order.bound_mm, order.length_mm);
    }

    #[test]
    fn tours_of_six_places_are_the_shortest() {
        let closed = [(2903, 2947), (4269, 422), (4881, 2712), (1324, 3512), (2761, 3943), (3493, 2358)];
        let open = [(2688, 3644), (1414, 1734), (2994, 2965), (2575, 2842), (709, 1205), (3427, 1009)];
        for (points, is_closed) in [(closed, true), (open, false)] {
            let distance_mm = distances(&points);
            let tour =
                TourProblem { distance_mm: &distance_mm, lower_bound_mm: &distance_mm, n: 6, start: None, is_closed };
            let shortest = permutations(6).iter().map(|p| tour.length_mm(p)).min().unwrap();
            assert_eq!(tour.order(40).length_mm, shortest);
        }
    }

    proptest! {
        #[test]
        fn small_tours_are_the_shortest_and_bounds_hold(
            points in prop::collection::vec((0u32..5_000, 0u32..5_000), 1..8),
            start in prop::option::of(0usize..8),
            is_closed: bool,
        ) {
            let n = points.len();
            let start = start.filter(|s| *s < n);
            let distance_mm = distances(&points);
            let tour = TourProblem { distance_mm: &distance_mm, lower_bound_mm: &distance_mm, n, start, is_closed };
            let order = tour.order(40);
            let fits = |p: &Vec<usize>| start.is_none() || p.first() == start.as_ref();
            let shortest = permutations(n).iter().filter(|p| fits(p)).map(|p| tour.length_mm(p)).min().unwrap();
            let mut sorted = order.places.clone();
            sorted.sort_unstable();
            prop_assert_eq!(sorted, (0..n).collect::<Vec<_>>());
            prop_assert!(fits(&order.places));
            prop_assert_eq!(tour.length_mm(&order.places), order.length_mm);
            prop_assert!(order.bound_mm <= shortest, "{} is no bound of {}", order.bound_mm, shortest);
            prop_assert!(order.length_mm <= shortest + shortest / 50, "{} for {}", order.length_mm, shortest);
        }
    }
}
