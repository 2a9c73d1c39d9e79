//! Ids of nodes and edges that do not depend on the date: of what they are at, not of their numbers.

use crate::ids::id_of;
use export::ExportInput;
use messages::{NodeKind, RouteNodeRecord};
use std::collections::BTreeMap;

/// Ids of the nodes and edges of the storeys that are written.
pub(super) struct Names {
    nodes: Vec<String>,
    edges: Vec<DirectedEdge>,
}

/// A way that this robot can take, in one direction.
pub(super) struct DirectedEdge {
    pub(super) id: String,
    /// Nodes of the mission plan.
    pub(super) from: u32,
    pub(super) to: u32,
    /// Edge of the mission plan.
    pub(super) edge: u32,
    /// True if it leads against the edge's line.
    pub(super) is_back: bool,
}

impl Names {
    pub(super) fn of(input: &ExportInput<'_>) -> Self {
        let plan = input.mission_plan;
        let nodes = distinct(plan.nodes.iter().map(|node| node_name(input, node)).collect());
        let is_written = |node: u32| input.writes(plan.nodes[node as usize].map_storey);
        let usable = (0..).zip(plan.edges).filter(|(_, e)| e.usable == 1 && e.nodes.iter().all(|&n| is_written(n)));
        let mut edges: Vec<DirectedEdge> = usable
            .flat_map(|(edge, record)| {
                let [a, b] = record.nodes;
                [(a, b, false), (b, a, true)].map(|(from, to, is_back)| {
                    let id = format!("{}..{}", nodes[from as usize], nodes[to as usize]);
                    DirectedEdge { id, from, to, edge, is_back }
                })
            })
            .collect();
        let ids = distinct(edges.iter().map(|edge| [edge.id.clone(), edge_name(input, edge)]).collect());
        edges.iter_mut().zip(ids).for_each(|(edge, id)| edge.id = id);
        Self { nodes, edges }
    }

    pub(super) fn node(&self, node: u32) -> &str {
        &self.nodes[node as usize]
    }

    pub(super) fn edges(&self) -> &[DirectedEdge] {
        &self.edges
    }
}

/// What a node is at, with its storey, and what tells it from others there.
fn node_name(input: &ExportInput<'_>, node: &RouteNodeRecord) -> [String; 2] {
    let site = input.site;
    let element = |element: u32| site.elements.get(element as usize).map_or("", |e| site.text(e.global_id));
    let of = match node.kind.get() {
        NodeKind::Space => site.spaces.get(node.of as usize).map_or("", |space| site.text(space.global_id)),
        NodeKind::Door => site.doors.get(node.of as usize).map_or("", |door| element(door.element)),
        NodeKind::Staging => element(node.of),
        NodeKind::Junction => "",
    };
    let [x, y] = [0, 1].map(|k| (node.position_in_map_m[k] * 100.0).round());
    let place = format!("{x}:{y}");
    let (kind, storey) = (node.kind.get().name(), node.map_storey);
    match (node.kind.get(), of) {
        (NodeKind::Space | NodeKind::Door, of) if !of.is_empty() => [format!("{kind}:{}:{storey}", id_of(of)), place],
        (_, "") => [format!("{kind}:{storey}:{place}"), String::new()],
        _ => [format!("{kind}:{}:{storey}:{place}", id_of(of)), String::new()],
    }
}

/// What tells an edge from others between its nodes.
fn edge_name(input: &ExportInput<'_>, edge: &DirectedEdge) -> String {
    let record = &input.mission_plan.edges[edge.edge as usize];
    format!("{}:{}", record.kind.get().name(), (record.length_m * 100.0).round())
}

/// Each first text where no other is equal; else with its second, and with a number where that is not enough.
fn distinct(names: Vec<[String; 2]>) -> Vec<String> {
    let mut counts: BTreeMap<String, u32> = BTreeMap::new();
    names.iter().for_each(|[name, _]| *counts.entry(name.clone()).or_default() += 1);
    let longer = names.into_iter().map(|[name, more]| if counts[&name] > 1 { format!("{name}:{more}") } else { name });
    let mut seen: BTreeMap<String, u32> = BTreeMap::new();
    longer
        .map(|name| {
            let n = seen.entry(name.clone()).or_default();
            *n += 1;
            if *n > 1 { format!("{name}:{n}") } else { name }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_has_a_place_of_its_own_is_named_by_that_alone() {
        let names = [["a", "1"], ["b", "1"], ["b", "2"], ["b", "2"]].map(|pair| pair.map(str::to_owned));
        assert_eq!(distinct(names.to_vec()), ["a", "b:1", "b:2", "b:2:2"]);
    }
}
