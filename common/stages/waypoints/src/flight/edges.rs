//! Edges between waypoints: straight ways that keep the clearance, so that waypoints hang together as the nodes do.
//!
//! Waypoints whose nodes touch are joined if they see each other. Where they do not, the way over the nodes between them is followed, and
//! places on it become waypoints too, unless waypoints that are there already lead almost as straight.

use super::air::Air;
use super::choice::{Regions, steps_between};
use super::links::{Links, distance};
use super::places::AirNode;
use std::cmp::Reverse;
use std::collections::{BTreeMap, BTreeSet, BinaryHeap};

/// A way over other waypoints may be this much longer than that over the nodes between two.
const DETOUR: f64 = 2.0;

/// Waypoints and edges, by nodes.
#[derive(Debug, Default)]
pub(crate) struct FlightGraph {
    /// Ascending.
    pub(crate) waypoints: BTreeSet<u32>,
    /// The lower node first.
    pub(crate) edges: BTreeSet<[u32; 2]>,
}

/// Where two regions touch: the two nodes between which the way from waypoint to waypoint is shortest.
#[derive(Debug, Clone, Copy)]
struct Contact {
    length: f64,
    nodes: [u32; 2],
}

/// Joins the waypoints of regions. No edge is longer than `spacing` in plan.
pub(crate) fn joined(
    nodes: &[AirNode],
    links: &Links,
    regions: &Regions,
    air: &Air,
    [clearance, spacing]: [i32; 2],
) -> FlightGraph {
    let sight = Sight { nodes, air, clearance: f64::from(clearance), spacing: i64::from(spacing) };
    let mut graph = Graph { nodes, found: FlightGraph::default(), beside: BTreeMap::new() };
    graph.found.waypoints.extend(regions.waypoint.iter().copied());
    let mut unseen: Vec<(f64, Contact, [u32; 2])> = Vec::new();
    for (ends, contact) in contacts(nodes, links, regions) {
        if sight.is_clear(ends) { graph.add(ends) } else { unseen.push((contact.length, contact, ends)) }
    }
    unseen.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.2.cmp(&b.2)));
    for (_, contact, ends) in unseen {
        let line = line_of(regions, contact.nodes);
        let length = line.windows(2).map(|pair| sight.length([pair[0], pair[1]])).sum::<f64>();
        if !graph.leads(ends, DETOUR * length) {
            sight.stretched(&line).windows(2).for_each(|pair| graph.add([pair[0], pair[1]]));
        }
    }
    graph.found
}

/// Of each two regions that touch the shortest contact.
fn contacts(nodes: &[AirNode], links: &Links, regions: &Regions) -> BTreeMap<[u32; 2], Contact> {
    let mut contacts: BTreeMap<[u32; 2], Contact> = BTreeMap::new();
    for a in 0..nodes.len() as u32 {
        for &b in links.from(a).iter().filter(|&&b| a < b) {
            let [of_a, of_b] = [a, b].map(|k| regions.waypoint[k as usize]);
            if of_a == of_b {
                continue;
            }
            let [from, to] = [a, b].map(|k| &nodes[k as usize]);
            let between = steps_between(from, to) + if from.layer == to.layer { 0.0 } else { 1.0 };
            let length = regions.steps[a as usize] + between + regions.steps[b as usize];
            let (ends, found) = if of_a < of_b { ([of_a, of_b], [a, b]) } else { ([of_b, of_a], [b, a]) };
            let contact = contacts.entry(ends).or_insert(Contact { length, nodes: found });
            if length < contact.length {
                *contact = Contact { length, nodes: found };
            }
        }
    }
    contacts
}

/// The nodes from the waypoint of one node over both to that of the other.
fn line_of(regions: &Regions, [a, b]: [u32; 2]) -> Vec<u32> {
    let way = |from: u32| {
        std::iter::successors(Some(from), |&node| Some(regions.next[node as usize]).filter(|next| *next != node))
    };
    let mut line: Vec<u32> = way(a).collect();
    line.reverse();
    line.extend(way(b));
    line
}

struct Sight<'a> {
    nodes: &'a [AirNode],
    air: &'a Air,
    clearance: f64,
    spacing: i64,
}

impl Sight<'_> {
    fn positions(&self, ends: [u32; 2]) -> [[i32; 3]; 2] {
        ends.map(|node| self.nodes[node as usize].position)
    }

    fn length(&self, ends: [u32; 2]) -> f64 {
        let [a, b] = self.positions(ends);
        distance(a, b)
    }

    /// True if two nodes are near enough to each other in plan, and the straight way between them keeps the clearance.
    fn is_clear(&self, ends: [u32; 2]) -> bool {
        let [a, b] = self.positions(ends);
        let [x, y] = [0, 1].map(|k| i64::from(a[k]) - i64::from(b[k]));
        x * x + y * y <= self.spacing * self.spacing && self.air.is_clear([a, b], self.clearance)
    }

    /// The nodes of a line over links that are left when as many as possible are left out.
    fn stretched(&self, line: &[u32]) -> Vec<u32> {
        let (mut kept, mut at) = (vec![line[0]], 0);
        while at + 1 < line.len() {
            // The next one is linked with this.
            let farthest = (at + 2..line.len()).rev().find(|&to| self.is_clear([line[at], line[to]]));
            at = farthest.unwrap_or(at + 1);
            kept.push(line[at]);
        }
        kept
    }
}

/// Waypoints with those that each is joined with.
struct Graph<'a> {
    nodes: &'a [AirNode],
    found: FlightGraph,
    beside: BTreeMap<u32, Vec<(u32, f64)>>,
}

impl Graph<'_> {
    fn add(&mut self, [a, b]: [u32; 2]) {
        if self.found.edges.insert([a.min(b), a.max(b)]) {
            self.found.waypoints.extend([a, b]);
            let length = distance(self.nodes[a as usize].position, self.nodes[b as usize].position);
            self.beside.entry(a).or_default().push((b, length));
            self.beside.entry(b).or_default().push((a, length));
        }
    }

    /// True if a way over edges from one waypoint to another is at most so long.
    fn leads(&self, [from, to]: [u32; 2], longest: f64) -> bool {
        let mut lengths = BTreeMap::from([(from, 0.0f64)]);
        let mut waiting = BinaryHeap::from([Reverse((0.0f64.to_bits(), from))]);
        while let Some(Reverse((bits, at))) = waiting.pop() {
            if at == to {
                return true;
            }
            let length = f64::from_bits(bits);
            if lengths.get(&at).is_some_and(|least| *least < length) {
                continue;
            }
            for &(next, more) in self.beside.get(&at).into_iter().flatten() {
                let far = length + more;
                if far <= longest && lengths.get(&next).is_none_or(|least| far < *least) {
                    lengths.insert(next, far);
                    waiting.push(Reverse((far.to_bits(), next)));
                }
            }
        }
        false
    }
}
