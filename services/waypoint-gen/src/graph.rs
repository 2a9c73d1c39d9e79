//! The route graph of a storey: spaces, doors, meeting points on the middle lines, places before stairs and lifts.

use crate::centre::Storey;
use crate::skeleton::{Chain, skeleton, trace};
use crate::walk::{Walk, length_m};
use frames::{Map, Point2, TENTHS_PER_M};
use messages::{DoorPassage, EdgeKind, NONE, NodeKind};

/// A place of the graph.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Node {
    pub(crate) at: Point2<Map>,
    pub(crate) kind: NodeKind,
    /// Space, door or element of the site.
    pub(crate) of: u32,
    pub(crate) clearance_m: f64,
}

/// A way between two nodes.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Edge {
    pub(crate) nodes: [usize; 2],
    pub(crate) kind: EdgeKind,
    /// Door of the site.
    pub(crate) door: u32,
    pub(crate) line: Vec<Point2<Map>>,
    pub(crate) length_m: f64,
    pub(crate) clearance_m: f64,
}

/// Places and the ways between them.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Graph {
    pub(crate) nodes: Vec<Node>,
    pub(crate) edges: Vec<Edge>,
}

/// What is to be a node, whatever the floor looks like.
pub(crate) struct Anchor {
    pub(crate) at: Point2<Map>,
    pub(crate) kind: NodeKind,
    pub(crate) of: u32,
}

/// A line may be this far from the cells that it stands for, in cells.
const TOLERANCE: f64 = 1.5;

/// The graph of what the robot can get to, with a node for every anchor that it can get to and for every door that it can
/// pass.
pub(crate) fn graph(storey: &Storey<'_>, walk: &Walk, anchors: Vec<Anchor>) -> Graph {
    let anchors = anchors.into_iter().filter_map(|a| walk.cell_near(a.at).map(|cell| (cell, a)));
    let doors =
        storey.passages.iter().filter_map(|p| door_anchor(storey, walk, p.door, DoorPassage::from_id(p.passage)?));
    let mut nodes: Vec<Node> = Vec::new();
    let mut cells: Vec<usize> = Vec::new();
    for (cell, anchor) in anchors.chain(doors) {
        // Two nodes do not share a cell: the later one goes beside it.
        let w = walk.width;
        let beside =
            [cell, cell + 1, cell - 1, cell + w, cell - w, cell + w + 1, cell + w - 1, cell - w + 1, cell - w - 1];
        let Some(cell) = beside.into_iter().find(|c| walk.open[*c] && !cells.contains(c)) else { continue };
        cells.push(cell);
        let clearance_m = storey.ground.clearance_m(anchor.at);
        nodes.push(Node { at: anchor.at, kind: anchor.kind, of: anchor.of, clearance_m });
    }
    let line = skeleton(walk, &cells);
    let (cells, chains) = trace(&line, walk.width, &cells);
    for &cell in &cells[nodes.len()..] {
        let at = walk.middle(cell);
        nodes.push(Node { at, kind: NodeKind::Junction, of: NONE, clearance_m: storey.ground.clearance_m(at) });
    }
    let mut graph = Graph { nodes, edges: Vec::new() };
    for chain in chains {
        add_way(storey, walk, &mut graph, chain);
    }
    graph
}

/// The node in a passage: the place nearest to its middle that the robot can get to inside of it.
fn door_anchor(storey: &Storey<'_>, walk: &Walk, door: u32, passage: DoorPassage) -> Option<(usize, Anchor)> {
    if !matches!(passage, DoorPassage::Passable | DoorPassage::Absent) {
        return None;
    }
    let plan = storey.site.doors[door as usize].passage.to_box();
    let tenths = f64::from(TENTHS_PER_M);
    let cell_tenths = f64::from(storey.ground.spec.cell_tenths);
    let steps = |half: f64| (half / cell_tenths).ceil() as i32 * 2;
    let mut best: Option<(f64, usize)> = None;
    for u in -steps(plan.half[0])..=steps(plan.half[0]) {
        for v in -steps(plan.half[1])..=steps(plan.half[1]) {
            let [u, v] = [u, v].map(|k| f64::from(k) * cell_tenths / 2.0);
            if u.abs() > plan.half[0] || v.abs() > plan.half[1] {
                continue;
            }
            let p = plan.at(u, v).map(|c| c / tenths);
            let far = u * u + v * v;
            if let Some(cell) = walk.cell_at(Point2::new(p[0], p[1]))
                && best.is_none_or(|b| (far, cell) < b)
            {
                best = Some((far, cell));
            }
        }
    }
    best.map(|(_, cell)| (cell, Anchor { at: walk.middle(cell), kind: NodeKind::Door, of: door }))
}

/// A chain as edges: what is next to a door is the way through it, from a place on its side.
fn add_way(storey: &Storey<'_>, walk: &Walk, graph: &mut Graph, chain: Chain) {
    let Chain { mut nodes, mut cells, .. } = chain;
    for end in [0, 1] {
        let node = graph.nodes[nodes[end]];
        if node.kind != NodeKind::Door {
            continue;
        }
        if end == 1 {
            cells.reverse();
        }
        let plan = storey.site.doors[node.of as usize].passage.to_box();
        let beside_m = plan.half[1] / f64::from(TENTHS_PER_M) + storey.robot.radius_m;
        let far = |cell: &usize| {
            let p = walk.middle(*cell);
            libm::hypot(p.x_m - node.at.x_m, p.y_m - node.at.y_m) > beside_m
        };
        let at = cells.iter().position(far).filter(|at| at + 2 < cells.len());
        if let Some(at) = at {
            let side = walk.middle(cells[at]);
            let element = storey.site.doors[node.of as usize].element;
            let clearance_m = storey.ground.clearance_m(side);
            graph.nodes.push(Node { at: side, kind: NodeKind::Staging, of: element, clearance_m });
            let side = graph.nodes.len() - 1;
            add_edge(storey, walk, graph, [nodes[end], side], &cells[..=at], node.of);
            cells.drain(..at);
            nodes[end] = side;
        } else {
            // Nothing but the way through the door.
            add_edge(storey, walk, graph, [nodes[end], nodes[1 - end]], &cells, node.of);
            return;
        }
        if end == 1 {
            cells.reverse();
        }
    }
    add_edge(storey, walk, graph, nodes, &cells, NONE);
}

fn add_edge(storey: &Storey<'_>, walk: &Walk, graph: &mut Graph, nodes: [usize; 2], cells: &[usize], door: u32) {
    let mut line = vec![graph.nodes[nodes[0]].at];
    simplify(walk, cells, &mut line);
    let last = line.len() - 1;
    line[last] = graph.nodes[nodes[1]].at;
    let kind = if door == NONE { EdgeKind::Floor } else { EdgeKind::Door };
    let (length_m, clearance_m) = (length_m(&line), clearance_m(storey, &line));
    graph.edges.push(Edge { nodes, kind, door, line, length_m, clearance_m });
}

/// The least clearance along a line, looked at twice in each cell.
fn clearance_m(storey: &Storey<'_>, line: &[Point2<Map>]) -> f64 {
    let Storey { ground, .. } = *storey;
    let step_m = ground.spec.resolution_m() / 2.0;
    let mut least_m = f64::INFINITY;
    let mut look = |p: Point2<Map>| {
        let Some(cell) = ground.spec.cell_at(p).map(|c| ground.spec.index(c)) else { return };
        let middle = ground.middle(cell);
        // Not less than that of the cell's middle by more than the way there.
        if ground.clearance_of(cell) - libm::hypot(p.x_m - middle.x_m, p.y_m - middle.y_m) < least_m {
            least_m = least_m.min(ground.clearance_m(p));
        }
    };
    for ends in line.windows(2) {
        let d = [ends[1].x_m - ends[0].x_m, ends[1].y_m - ends[0].y_m];
        let n = (libm::hypot(d[0], d[1]) / step_m).ceil().max(1.0);
        for k in 0..=n as u32 {
            let share = f64::from(k) / n;
            look(Point2::new(ends[0].x_m + share * d[0], ends[0].y_m + share * d[1]));
        }
    }
    least_m
}

/// The corners of a line that stays near the cells, and where the robot can be; without the first.
///
/// # Source
/// Douglas and Peucker, "Algorithms for the reduction of the number of points required to represent a digitized line",
/// Cartographica 10, 1973.
fn simplify(walk: &Walk, cells: &[usize], line: &mut Vec<Point2<Map>>) {
    let mut waiting = vec![(0, cells.len() - 1)];
    while let Some((a, b)) = waiting.pop() {
        let at = |k: usize| [(cells[k] % walk.width) as f64, (cells[k] / walk.width) as f64];
        let (p, q) = (at(a), at(b));
        let d = [q[0] - p[0], q[1] - p[1]];
        let length = (d[0] * d[0] + d[1] * d[1]).sqrt();
        let off = |k: usize| {
            let r = at(k);
            let e = [r[0] - p[0], r[1] - p[1]];
            if length == 0.0 { libm::hypot(e[0], e[1]) } else { ((e[0] * d[1] - e[1] * d[0]) / length).abs() }
        };
        let farthest = (a + 1..b).max_by(|&i, &j| off(i).total_cmp(&off(j)).then(j.cmp(&i)));
        match farthest {
            Some(k) if off(k) > TOLERANCE || !walk.is_straight(cells[a], cells[b]) => {
                waiting.push((k, b));
                waiting.push((a, k));
            }
            _ => line.push(walk.middle(cells[b])),
        }
    }
}
