//! Chooses the nodes that are waypoints: so many that from every node one over the same space at the same height is near.

use super::links::Links;
use super::places::AirNode;
use std::cmp::Reverse;
use std::collections::{BinaryHeap, VecDeque};
use std::f64::consts::SQRT_2;

/// Nodes with their waypoint, and the way to it over links.
#[derive(Debug)]
pub(crate) struct Regions {
    /// By node: the node that is its waypoint.
    pub(crate) waypoint: Vec<u32>,
    /// By node: the next one on the way there; a waypoint itself.
    pub(crate) next: Vec<u32>,
    /// By node: length of that way in plan, in steps.
    pub(crate) steps: Vec<f64>,
}

/// No node.
const NOTHING: u32 = u32::MAX;

impl Regions {
    /// Chooses waypoints of nodes such that the way from a node to its waypoint is at most `reach` steps long in plan.
    ///
    /// The first are nodes on a coarser lattice, on which open space is covered, the same at all heights. Of what they leave, each
    /// connected rest has one at the node nearest to its middle, until nothing is left.
    pub(crate) fn of(nodes: &[AirNode], links: &Links, reach: f64) -> Self {
        let pitch = (reach * SQRT_2).floor().max(1.0) as i32;
        let is_seed = |node: &AirNode| node.at.iter().all(|c| c.rem_euclid(pitch) == 0);
        let mut seeds: Vec<u32> = (0..nodes.len() as u32).filter(|&k| is_seed(&nodes[k as usize])).collect();
        let mut growth = Growth::new(nodes, links);
        growth.grow(&seeds, reach);
        let mut rests = growth.rests((0..nodes.len() as u32).collect());
        while let Some(rest) = rests.pop() {
            let seed = middle_of(nodes, &rest);
            seeds.push(seed);
            growth.grow(&[seed], reach);
            rests.extend(growth.rests(rest));
        }
        // Of all waypoints the nearest.
        let mut growth = Growth::new(nodes, links);
        growth.grow(&seeds, f64::INFINITY);
        growth.regions
    }
}

/// The node nearest to the middle of some, in plan.
fn middle_of(nodes: &[AirNode], some: &[u32]) -> u32 {
    let sum = |k: usize| some.iter().map(|&node| i64::from(nodes[node as usize].at[k])).sum::<i64>();
    let (sums, n) = ([sum(0), sum(1)], some.len() as i64);
    let off = |node: u32| {
        let at = nodes[node as usize].at;
        let [row, column] = [0, 1].map(|k| i128::from(i64::from(at[k]) * n - sums[k]));
        (row * row + column * column, node)
    };
    some.iter().copied().min_by_key(|&node| off(node)).unwrap_or(NOTHING)
}

/// Ways from waypoints over links of one layer and space.
struct Growth<'a> {
    nodes: &'a [AirNode],
    links: &'a Links,
    regions: Regions,
}

impl<'a> Growth<'a> {
    fn new(nodes: &'a [AirNode], links: &'a Links) -> Self {
        let nothing = vec![NOTHING; nodes.len()];
        let regions = Regions { waypoint: nothing.clone(), next: nothing, steps: vec![f64::INFINITY; nodes.len()] };
        Self { nodes, links, regions }
    }

    /// The nodes that one is linked with in its layer and space, and how far they are in plan, in steps.
    fn beside(&self, node: u32) -> impl Iterator<Item = (u32, f64)> + use<'a> {
        let (nodes, from) = (self.nodes, self.nodes[node as usize]);
        self.links.from(node).iter().filter_map(move |&to| {
            let other = &nodes[to as usize];
            let is_alike = (other.layer, other.space) == (from.layer, from.space);
            is_alike.then(|| (to, steps_between(&from, other)))
        })
    }

    /// Gives nodes that are at most `reach` from a seed to it, but for those that are nearer to an earlier one.
    fn grow(&mut self, seeds: &[u32], reach: f64) {
        // Lengths are not negative: their bits have the order of the numbers.
        let mut waiting = BinaryHeap::new();
        for &seed in seeds {
            (self.regions.waypoint[seed as usize], self.regions.next[seed as usize]) = (seed, seed);
            self.regions.steps[seed as usize] = 0.0;
            waiting.push(Reverse((0.0f64.to_bits(), seed)));
        }
        while let Some(Reverse((bits, node))) = waiting.pop() {
            let (steps, at) = (f64::from_bits(bits), node as usize);
            if steps > self.regions.steps[at] {
                continue;
            }
            for (to, length) in self.beside(node) {
                let far = steps + length;
                if far <= reach && far < self.regions.steps[to as usize] {
                    self.regions.steps[to as usize] = far;
                    self.regions.next[to as usize] = node;
                    self.regions.waypoint[to as usize] = self.regions.waypoint[at];
                    waiting.push(Reverse((far.to_bits(), to)));
                }
            }
        }
    }

    /// The connected parts of those of some nodes that have no waypoint; the last of some first.
    fn rests(&self, some: Vec<u32>) -> Vec<Vec<u32>> {
        let is_left = |node: u32| self.regions.waypoint[node as usize] == NOTHING;
        let left: Vec<u32> = some.into_iter().filter(|&node| is_left(node)).collect();
        let mut is_taken = vec![false; left.len()];
        let mut rests = Vec::new();
        for first in 0..left.len() {
            if std::mem::replace(&mut is_taken[first], true) {
                continue;
            }
            let (mut rest, mut waiting) = (vec![left[first]], VecDeque::from([left[first]]));
            while let Some(node) = waiting.pop_front() {
                for (to, _) in self.beside(node) {
                    let Ok(place) = left.binary_search(&to) else { continue };
                    if !std::mem::replace(&mut is_taken[place], true) {
                        rest.push(to);
                        waiting.push_back(to);
                    }
                }
            }
            rest.sort_unstable();
            rests.push(rest);
        }
        rests
    }
}

/// Distance in plan of nodes that are next to each other, in steps.
pub(crate) fn steps_between(a: &AirNode, b: &AirNode) -> f64 {
    match (a.at[0] != b.at[0], a.at[1] != b.at[1]) {
        (true, true) => SQRT_2,
        (false, false) => 0.0,
        _ => 1.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::collections::BTreeSet;

    fn node([row, column]: [i32; 2], height: u32, space: u32) -> AirNode {
        let position = [column * 10, row * 10, height as i32 * 10];
        AirNode { layer: [0, height], at: [row, column], position, ground: 0, space, distance: 0.0 }
    }

    /// Links between all nodes that are next to each other.
    fn linked(nodes: &[AirNode]) -> Links {
        let n = nodes.len() as u32;
        let is_beside = |a: u32, b: u32| {
            let [a, b] = [a, b].map(|k| nodes[k as usize]);
            (0..2).all(|k| a.at[k].abs_diff(b.at[k]) <= 1) && a.layer[1].abs_diff(b.layer[1]) <= 1
        };
        let pairs = (0..n).flat_map(|a| (a + 1..n).map(move |b| [a, b])).filter(|&[a, b]| is_beside(a, b));
        Links::from_pairs(nodes.len(), pairs.collect())
    }

    proptest! {
        #[test]
        fn every_node_has_a_waypoint_within_reach_of_its_own_layer_and_space(
            places in proptest::collection::btree_set((0u32..2, 0i32..14, 0i32..14), 1..150),
            reach in 1.3f64..6.0,
        ) {
            let places: BTreeSet<(u32, i32, i32)> = places;
            let nodes: Vec<AirNode> =
                places.into_iter().map(|(height, row, column)| node([row, column], height, u32::from(row > 6))).collect();
            let links = linked(&nodes);
            let regions = Regions::of(&nodes, &links, reach);
            for (k, from) in nodes.iter().enumerate() {
                let waypoint = &nodes[regions.waypoint[k] as usize];
                prop_assert_eq!((from.layer, from.space), (waypoint.layer, waypoint.space));
                prop_assert!(regions.steps[k] <= reach);
                let (mut at, mut steps) = (k as u32, 0.0);
                while regions.next[at as usize] != at {
                    let next = regions.next[at as usize];
                    prop_assert!(links.from(at).contains(&next));
                    steps += steps_between(&nodes[at as usize], &nodes[next as usize]);
                    at = next;
                }
                prop_assert_eq!(at, regions.waypoint[k]);
                prop_assert!((steps - regions.steps[k]).abs() < 1e-9);
            }
        }
    }

    #[test]
    fn open_space_has_waypoints_on_a_lattice_and_a_strip_beside_it_one_of_its_own() {
        let nodes: Vec<AirNode> = (0..9).flat_map(|row| (0..9).map(move |column| node([row, column], 0, 0))).collect();
        let regions = Regions::of(&nodes, &linked(&nodes), 3.0);
        let chosen: BTreeSet<[i32; 2]> = regions.waypoint.iter().map(|&k| nodes[k as usize].at).collect();
        // A pitch of 4 steps covers what lies between; nothing is left beside it.
        let expected: BTreeSet<[i32; 2]> = [0, 4, 8].into_iter().flat_map(|row| [0, 4, 8].map(|c| [row, c])).collect();
        assert_eq!(chosen, expected);
        let strip: Vec<AirNode> = (0..9).map(|column| node([1, column], 0, 0)).collect();
        let regions = Regions::of(&strip, &linked(&strip), 4.0);
        let chosen: BTreeSet<u32> = regions.waypoint.iter().copied().collect();
        assert_eq!(chosen, BTreeSet::from([4]));
    }
}
