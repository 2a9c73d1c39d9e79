//! Links between nodes that are next to each other: the straight way between them keeps the clearance.
//!
//! Nodes of a layer are linked with those around them on the lattice, nodes over one place with the next above, and where a layer ends
//! with the nearest node of another storey in the next place, so that doorways and stairwells between storeys are found.

use super::air::Air;
use super::places::{AirNode, LatticePlace};
use geometry::DisjointSets;
use rayon::prelude::*;

/// Links in both directions.
#[derive(Debug, Default)]
pub(crate) struct Links {
    /// Where the links of each node begin; one more than there are nodes.
    first: Vec<u32>,
    to: Vec<u32>,
}

/// Half of the places around one on the lattice: the others see it from the other side.
const FORWARD: [LatticePlace; 4] = [[0, 1], [1, -1], [1, 0], [1, 1]];

const AROUND: [LatticePlace; 8] = [[-1, -1], [-1, 0], [-1, 1], [0, -1], [0, 1], [1, -1], [1, 0], [1, 1]];

impl Links {
    /// Of nodes by layer, row and column. No link along the layers climbs more than `longest`; upright ones join the heights of a place.
    pub(crate) fn of(nodes: &[AirNode], air: &Air, clearance: i32, longest: i32) -> Self {
        let search = Search { nodes, air, clearance: f64::from(clearance), longest, columns: columns_of(nodes) };
        let pairs: Vec<[u32; 2]> =
            (0..nodes.len() as u32).into_par_iter().flat_map_iter(|node| search.links_of(node)).collect();
        Self::from_pairs(nodes.len(), pairs)
    }

    pub(crate) fn from_pairs(n_nodes: usize, pairs: Vec<[u32; 2]>) -> Self {
        let mut both: Vec<[u32; 2]> = pairs.iter().flat_map(|&[a, b]| [[a, b], [b, a]]).collect();
        both.sort_unstable();
        both.dedup();
        let first = (0..=n_nodes as u32).map(|node| both.partition_point(|pair| pair[0] < node) as u32).collect();
        Self { first, to: both.into_iter().map(|[_, to]| to).collect() }
    }

    /// The nodes that one is linked with, ascending.
    pub(crate) fn from(&self, node: u32) -> &[u32] {
        &self.to[self.first[node as usize] as usize..self.first[node as usize + 1] as usize]
    }

    /// The same of the nodes that are kept, which are numbered anew.
    pub(crate) fn of_kept(&self, is_kept: &[bool]) -> Self {
        let mut n_kept = 0;
        let number = |kept: &bool| {
            n_kept += u32::from(*kept);
            n_kept.saturating_sub(1)
        };
        // Those of nodes that are not kept are not used.
        let numbers: Vec<u32> = is_kept.iter().map(number).collect();
        let mut kept = Self { first: vec![0], to: Vec::new() };
        for node in (0..numbers.len() as u32).filter(|&node| is_kept[node as usize]) {
            let to = self.from(node).iter().filter(|&&to| is_kept[to as usize]);
            kept.to.extend(to.map(|&to| numbers[to as usize]));
            kept.first.push(kept.to.len() as u32);
        }
        kept
    }

    /// The first node of the connected part of each node.
    pub(crate) fn parts(&self) -> Vec<u32> {
        let n = self.first.len() as u32 - 1;
        let mut sets = DisjointSets::new(n as usize);
        for node in 0..n {
            self.from(node).iter().for_each(|&to| sets.join(node, to));
        }
        (0..n).map(|node| sets.first(node)).collect()
    }
}

/// Nodes by their place, lowest first.
fn columns_of(nodes: &[AirNode]) -> Vec<u32> {
    let mut columns: Vec<u32> = (0..nodes.len() as u32).collect();
    columns.sort_unstable_by_key(|&k| (nodes[k as usize].at, nodes[k as usize].position[2], k));
    columns
}

struct Search<'a> {
    nodes: &'a [AirNode],
    air: &'a Air,
    clearance: f64,
    longest: i32,
    columns: Vec<u32>,
}

impl Search<'_> {
    /// Links that are found from a node: each link is found from one of its ends at least.
    fn links_of(&self, node: u32) -> Vec<[u32; 2]> {
        let from = &self.nodes[node as usize];
        let place = |[row, column]: LatticePlace| [from.at[0] + row, from.at[1] + column];
        let mut found: Vec<u32> = FORWARD.into_iter().filter_map(|off| self.in_layer(from, place(off))).collect();
        let ends = AROUND.into_iter().filter(|&off| self.in_layer(from, place(off)).is_none());
        found.extend(ends.filter_map(|off| self.of_another_storey(from, place(off))));
        found.extend(self.next_above(node));
        let is_linked = |to: &u32| self.is_clear(from, &self.nodes[*to as usize]);
        found.into_iter().filter(is_linked).map(|to| [node, to]).collect()
    }

    fn in_layer(&self, from: &AirNode, at: LatticePlace) -> Option<u32> {
        let found = self.nodes.binary_search_by_key(&(from.layer, at), |node| (node.layer, node.at));
        found.ok().map(|k| k as u32)
    }

    fn column(&self, at: LatticePlace) -> &[u32] {
        let first = self.columns.partition_point(|&k| self.nodes[k as usize].at < at);
        let n = self.columns[first..].partition_point(|&k| self.nodes[k as usize].at == at);
        &self.columns[first..first + n]
    }

    /// The node of another storey at a place that is nearest in height.
    fn of_another_storey(&self, from: &AirNode, at: LatticePlace) -> Option<u32> {
        let off = |k: u32| self.nodes[k as usize].position[2].abs_diff(from.position[2]);
        let others = self.column(at).iter().copied().filter(|&k| self.nodes[k as usize].layer[0] != from.layer[0]);
        others.min_by_key(|&k| (off(k), k)).filter(|&k| off(k) <= self.longest.unsigned_abs())
    }

    fn next_above(&self, node: u32) -> Option<u32> {
        let column = self.column(self.nodes[node as usize].at);
        let place = column.iter().position(|&k| k == node)?;
        column.get(place + 1).copied()
    }

    /// True if the straight way between two nodes keeps the clearance.
    ///
    /// A place on it is as far from everything as either end, but for its distance from that end; so none is nearer than half of what both
    /// ends have together without the length of the way.
    fn is_clear(&self, a: &AirNode, b: &AirNode) -> bool {
        let length = distance(a.position, b.position);
        (a.distance + b.distance - length) / 2.0 >= self.clearance
            || self.air.is_clear([a.position, b.position], self.clearance)
    }
}

/// Distance of two places.
pub(crate) fn distance(a: [i32; 3], b: [i32; 3]) -> f64 {
    let off = [0, 1, 2].map(|k| (i64::from(a[k]) - i64::from(b[k])) as f64);
    (off[0] * off[0] + off[1] * off[1] + off[2] * off[2]).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn links_lead_both_ways_and_parts_are_named_by_their_first_node() {
        let links = Links::from_pairs(6, vec![[3, 1], [1, 3], [4, 5], [5, 3]]);
        assert_eq!(links.from(3), [1, 5]);
        assert_eq!(links.from(5), [3, 4]);
        assert!(links.from(0).is_empty());
        assert_eq!(links.parts(), [0, 1, 2, 1, 1, 1]);
        let kept = links.of_kept(&[false, true, false, true, true, false]);
        assert_eq!([0, 1, 2].map(|node| kept.from(node)), [&[1][..], &[0], &[]]);
    }
}
