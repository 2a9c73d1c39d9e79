//! The route graph of a storey: spaces, doors, junctions, staging poses at stairs and lifts.

use crate::path_search::{PathGrid, length_m};
use crate::skeleton::{Chain, skeleton, trace};
use crate::space_centre::StoreyInputs;
use crate::walked_line::{WalkedLine, walked};
use frames::{Map, Point2, TENTHS_PER_M};
use messages::DoorPassageRecord;

/// A node of the route graph.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct RouteNode {
    pub(crate) at: Point2<Map>,
    pub(crate) place: NodePlace,
    pub(crate) clearance_m: f64,
}

/// What is at a node.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum NodePlace {
    /// The centre of a space of the site.
    Space(u32),
    /// The middle of a door of the site.
    Door(u32),
    /// Ways meet.
    Junction,
    /// The robot stands before an element of the site: a door, stair, ramp or lift.
    Staging(u32),
}

/// An edge between two nodes.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct RouteEdge {
    pub(crate) nodes: [usize; 2],
    /// The door of the site through which it leads; none over floor.
    pub(crate) door: Option<u32>,
    pub(crate) line: Vec<Point2<Map>>,
    pub(crate) walked: WalkedLine,
    pub(crate) clearance_m: f64,
}

/// Nodes and edges of a storey.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct RouteGraph {
    pub(crate) nodes: Vec<RouteNode>,
    pub(crate) edges: Vec<RouteEdge>,
}

/// A place that must become a node.
pub(crate) struct Anchor {
    pub(crate) at: Point2<Map>,
    pub(crate) place: NodePlace,
}

/// Tolerance of line simplification, in cells.
const TOLERANCE: f64 = 1.5;

/// The route graph of the reachable free space, with a node for every reachable anchor and every passable door.
pub(crate) fn graph(storey: &StoreyInputs<'_>, path_grid: &PathGrid, anchors: Vec<Anchor>) -> RouteGraph {
    let anchors = anchors.into_iter().filter_map(|a| path_grid.cell_near(a.at).map(|cell| (cell, a)));
    let doors = storey.passages.iter().enumerate().filter_map(|(at, passage)| {
        // Leaves that count together are one doorway.
        let is_known = storey.passages[..at].iter().any(|before| is_same_doorway(before, passage));
        door_anchor(storey, path_grid, passage).filter(|_| !is_known)
    });
    let mut nodes: Vec<RouteNode> = Vec::new();
    let mut cells: Vec<usize> = Vec::new();
    for (cell, anchor) in anchors.chain(doors) {
        // Two nodes must not share a cell; the later one moves to a cell beside it.
        let w = path_grid.width;
        let beside =
            [cell, cell + 1, cell - 1, cell + w, cell - w, cell + w + 1, cell + w - 1, cell - w + 1, cell - w - 1];
        let Some(cell) = beside.into_iter().find(|c| path_grid.open[*c] && !cells.contains(c)) else { continue };
        cells.push(cell);
        let clearance_m = storey.free_space.clearance_m(anchor.at);
        nodes.push(RouteNode { at: anchor.at, place: anchor.place, clearance_m });
    }
    let line = skeleton(path_grid, &cells);
    let (cells, chains) = trace(path_grid, &line, &cells);
    for &cell in &cells[nodes.len()..] {
        let at = path_grid.middle(cell);
        nodes.push(RouteNode { at, place: NodePlace::Junction, clearance_m: storey.free_space.clearance_m(at) });
    }
    let mut graph = RouteGraph { nodes, edges: Vec::new() };
    for chain in chains {
        add_way(storey, path_grid, &mut graph, chain);
    }
    graph
}

/// True for leaves of one opening that count together as one doorway.
pub(crate) fn is_same_doorway(a: &DoorPassageRecord, b: &DoorPassageRecord) -> bool {
    // The axes may have opposite directions, so that sums differ in their last digits.
    let near = |a: [f64; 2], b: [f64; 2]| (0..2).all(|k| (a[k] - b[k]).abs() < 1.0);
    is_open(a) && is_open(b) && near(a.way.centre, b.way.centre) && near(a.way.half, b.way.half)
}

fn is_open(passage: &DoorPassageRecord) -> bool {
    !passage.passage.get().is_closed()
}

/// The node of a passage: the reachable place in it nearest to its middle.
fn door_anchor(
    storey: &StoreyInputs<'_>,
    path_grid: &PathGrid,
    passage: &DoorPassageRecord,
) -> Option<(usize, Anchor)> {
    if !is_open(passage) {
        return None;
    }
    let (door, plan) = (passage.door, passage.way.to_box());
    let tenths = f64::from(TENTHS_PER_M);
    let cell_tenths = f64::from(storey.free_space.spec.cell_tenths);
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
            if let Some(cell) = path_grid.cell_at(Point2::new(p[0], p[1]))
                && best.is_none_or(|b| (far, cell) < b)
            {
                best = Some((far, cell));
            }
        }
    }
    best.map(|(_, cell)| (cell, Anchor { at: path_grid.middle(cell), place: NodePlace::Door(door) }))
}

/// Adds a chain as edges. The piece next to a door is the edge through it, from a node at its side.
fn add_way(storey: &StoreyInputs<'_>, path_grid: &PathGrid, graph: &mut RouteGraph, chain: Chain) {
    let Chain { mut nodes, mut cells, .. } = chain;
    for end in [0, 1] {
        let node = graph.nodes[nodes[end]];
        let NodePlace::Door(door) = node.place else { continue };
        if end == 1 {
            cells.reverse();
        }
        let plan = storey.site.doors[door as usize].passage.to_box();
        let beside_m = plan.half[1] / f64::from(TENTHS_PER_M) + storey.robot.radius_m;
        let far = |cell: &usize| {
            let p = path_grid.middle(*cell);
            p.distance_m(&node.at) > beside_m
        };
        let at = cells.iter().position(far).filter(|at| at + 2 < cells.len());
        if let Some(at) = at {
            let side = path_grid.middle(cells[at]);
            let element = storey.site.doors[door as usize].element;
            let clearance_m = storey.free_space.clearance_m(side);
            graph.nodes.push(RouteNode { at: side, place: NodePlace::Staging(element), clearance_m });
            let side = graph.nodes.len() - 1;
            add_edge(storey, path_grid, graph, [nodes[end], side], &cells[..=at], Some(door));
            cells.drain(..at);
            nodes[end] = side;
        } else {
            // The chain is only the edge through the door.
            add_edge(storey, path_grid, graph, [nodes[end], nodes[1 - end]], &cells, Some(door));
            return;
        }
        if end == 1 {
            cells.reverse();
        }
    }
    add_edge(storey, path_grid, graph, nodes, &cells, None);
}

fn add_edge(
    storey: &StoreyInputs<'_>,
    path_grid: &PathGrid,
    graph: &mut RouteGraph,
    nodes: [usize; 2],
    cells: &[usize],
    door: Option<u32>,
) {
    let mut line = vec![path_grid.middle(cells[0])];
    simplify(path_grid, cells, &mut line);
    // A node need not lie in the middle of its cell; the line passes the middle if the straight line from the node is not
    // free.
    for node in [nodes[1], nodes[0]] {
        let at = graph.nodes[node].at;
        match line[..] {
            [.., next, last] if at == last || is_open_between(storey, path_grid, at, next) => line.pop(),
            _ => None,
        };
        line.push(at);
        line.reverse();
    }
    let (walked, clearance_m) = (walked(storey.free_space, &line), clearance_m(storey, &line));
    graph.edges.push(RouteEdge { nodes, door, line, walked, clearance_m });
}

/// Minimum clearance along a line, sampled twice per cell.
fn clearance_m(storey: &StoreyInputs<'_>, line: &[Point2<Map>]) -> f64 {
    let StoreyInputs { free_space, .. } = *storey;
    // The clearance of a point differs from that of its cell's middle by at most the distance to it.
    let at_least_m = |p: Point2<Map>| {
        let cell = free_space.spec.cell_at(p).map(|c| free_space.spec.index(c))?;
        Some(free_space.clearance_of(cell) - p.distance_m(&free_space.middle(cell)))
    };
    let bounds = || samples(line, free_space.spec.resolution_m() / 2.0).filter_map(|p| Some((at_least_m(p)?, p)));
    // From where the least may be few others have to be looked at.
    let first = bounds().min_by(|a, b| a.0.total_cmp(&b.0));
    let mut min_m = first.map_or(f64::INFINITY, |(_, p)| free_space.clearance_m(p));
    for (bound_m, p) in bounds() {
        if bound_m < min_m {
            min_m = min_m.min(free_space.clearance_m(p));
        }
    }
    min_m
}

/// Points along a line, at most so far apart, with all its corners.
fn samples(line: &[Point2<Map>], step_m: f64) -> impl Iterator<Item = Point2<Map>> {
    line.windows(2).flat_map(move |ends| {
        let d = [ends[1].x_m() - ends[0].x_m(), ends[1].y_m() - ends[0].y_m()];
        let n = (libm::hypot(d[0], d[1]) / step_m).ceil().max(1.0);
        (0..=n as u32).map(move |k| {
            let share = f64::from(k) / n;
            Point2::new(ends[0].x_m() + share * d[0], ends[0].y_m() + share * d[1])
        })
    })
}

/// True if the straight line between two points is free and reachable, except at corners of cells.
fn is_open_between(storey: &StoreyInputs<'_>, path_grid: &PathGrid, a: Point2<Map>, b: Point2<Map>) -> bool {
    let free_space = storey.free_space;
    let n = (length_m(&[a, b]) / free_space.spec.resolution_m() * 4.0).ceil().max(1.0) as u32;
    let is_open = |k: u32| {
        let t = f64::from(k) / f64::from(n);
        path_grid.cell_at(Point2::new(a.x_m() + (b.x_m() - a.x_m()) * t, a.y_m() + (b.y_m() - a.y_m()) * t)).is_some()
    };
    (0..=n).all(is_open) && storey.sight.is_clear(free_space.in_cells(a), free_space.in_cells(b))
}

/// Simplifies a chain of cells to the corners of a line within the tolerance that stays in the free space; without the first
/// corner.
///
/// # Source
/// Douglas and Peucker, "Algorithms for the reduction of the number of points required to represent a digitized line",
/// Cartographica 10, 1973.
fn simplify(path_grid: &PathGrid, cells: &[usize], line: &mut Vec<Point2<Map>>) {
    let mut waiting = vec![(0, cells.len() - 1)];
    while let Some((a, b)) = waiting.pop() {
        let at = |k: usize| [(cells[k] % path_grid.width) as f64, (cells[k] / path_grid.width) as f64];
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
            Some(k) if off(k) > TOLERANCE || !path_grid.is_straight(&cells[a..=b]) => {
                waiting.push((k, b));
                waiting.push((a, k));
            }
            _ => line.push(path_grid.middle(cells[b])),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::free_space::FreeSpace;
    use crate::free_space::tests::{drawn, floors};
    use bytemuck::Zeroable;
    use messages::*;
    use proptest::prelude::*;

    /// Two rooms of 2.0 m behind a door that is 0.8 m wide, in a wall of 0.2 m.
    fn rooms() -> String {
        let room = "#                    ##                    #".replace(' ', ".");
        let door = "#                    DD                    #".replace(' ', ".");
        let wall = "#".repeat(room.len());
        let rows = (0..20).map(|k| if (6..14).contains(&k) { door.clone() } else { room.clone() });
        [wall.clone()].into_iter().chain(rows).chain([wall]).collect::<Vec<_>>().join("\n")
    }

    /// The graph of the two rooms, with a door of this passage and an anchor in either room.
    fn graph_of(passage: DoorPassage, anchors: [[f64; 2]; 2]) -> (RouteGraph, ArchiveBuffer) {
        let mut builder = SiteBuilder::default();
        let none = ElementRecord { whole: NONE, storey: NONE, space: NONE, stair: NONE, ..Zeroable::zeroed() };
        builder.elements.extend([ElementRecord { door: NONE, ..none }, ElementRecord { door: 0, ..none }]);
        builder.doors.push(DoorRecord {
            clear_width_from: ClearWidth::Assumed.into(),
            element: 1,
            opening: NONE,
            spaces: [NONE; 2],
            beside: [NONE; 2],
            map_storey: NONE,
            passage: BoxRecord { centre: [22_000.0, 11_000.0], axis: [0.0, 1.0], half: [4_000.0, 1_000.0] },
            ..Zeroable::zeroed()
        });
        let (site, buffer) = (builder.finish(), drawn(&rooms()));
        let (site, grid) = (Site::open(site.bytes()).unwrap(), Grid::open(buffer.bytes()).unwrap());
        let way = builder.doors[0].passage;
        let passage = DoorPassageRecord { door: 0, passage: passage.into(), way, ..Zeroable::zeroed() };
        (graph_on(&site, &grid, 0.2, &[passage], &anchors), buffer)
    }

    fn graph_on(
        site: &Site<'_>,
        grid: &Grid<'_>,
        radius_m: f64,
        passages: &[DoorPassageRecord],
        anchors: &[[f64; 2]],
    ) -> RouteGraph {
        let robot = RobotProfile { radius_m, ..RobotProfile::DEFAULT };
        let free_space = FreeSpace::of(grid, radius_m);
        let reached = vec![true; free_space.n_parts() as usize + 1];
        let schedule_state =
            ScheduleStateBuilder::everything_built(site.content_hash(), site.elements.len(), 0).finish();
        let schedule_state = ScheduleState::open(schedule_state.bytes()).unwrap();
        let storey = StoreyInputs {
            site,
            schedule_state: &schedule_state,
            grid,
            free_space: &free_space,
            sight: &free_space.sight(),
            robot: &robot,
            passages,
            reached: &reached,
            barriers: &vec![Vec::new(); reached.len()],
        };
        let Some(path_grid) = PathGrid::of(&free_space, |_| true) else { return RouteGraph::default() };
        let anchor = |(at, of): (&[f64; 2], u32)| Anchor { at: Point2::new(at[0], at[1]), place: NodePlace::Space(of) };
        graph(&storey, &path_grid, anchors.iter().zip(0..).map(anchor).collect())
    }

    fn nodes_at(graph: &RouteGraph, is_it: impl Fn(NodePlace) -> bool) -> Vec<usize> {
        (0..graph.nodes.len()).filter(|&n| is_it(graph.nodes[n].place)).collect()
    }

    fn is_door(place: NodePlace) -> bool {
        matches!(place, NodePlace::Door(_))
    }

    fn is_staging(place: NodePlace) -> bool {
        matches!(place, NodePlace::Staging(_))
    }

    const ANCHORS: [[f64; 2]; 2] = [[1.1, 1.1], [3.3, 1.1]];

    #[test]
    fn the_way_through_a_door_begins_and_ends_beside_it() {
        let (graph, _) = graph_of(DoorPassage::Passable, ANCHORS);
        let (doors, sides) = (nodes_at(&graph, is_door), nodes_at(&graph, is_staging));
        assert_eq!((graph.nodes.len(), doors.len(), sides.len()), (5, 1, 2));
        let door = graph.nodes[doors[0]];
        assert!((door.at.x_m() - 2.2).abs() < 0.11 && (door.at.y_m() - 1.1).abs() < 0.11, "{door:?}");
        for side in sides {
            let node = graph.nodes[side];
            // Half the wall and the robot's radius away.
            let far_m = node.at.distance_m(&door.at);
            assert!(0.3 < far_m && far_m < 0.5, "{far_m}");
            assert_eq!(node.place, NodePlace::Staging(1), "the door's element");
            let mut doors: Vec<Option<u32>> =
                graph.edges.iter().filter(|e| e.nodes.contains(&side)).map(|e| e.door).collect();
            doors.sort_unstable();
            assert_eq!(doors, [None, Some(0)], "one edge over floor, one through the door");
        }
    }

    #[test]
    fn an_anchor_before_a_door_leaves_no_place_beside_it() {
        let (graph, _) = graph_of(DoorPassage::Passable, [[1.95, 1.1], [3.3, 1.1]]);
        let nodes = graph.edges.iter().filter(|e| e.door.is_some()).map(|e| e.nodes);
        let anchored: Vec<[usize; 2]> = nodes.filter(|n| n.contains(&0)).collect();
        assert_eq!((anchored.len(), nodes_at(&graph, is_staging).len()), (1, 1));
    }

    #[test]
    fn a_door_that_cannot_be_passed_is_no_node_and_a_hole_for_one_is() {
        for passage in [DoorPassage::TooNarrow, DoorPassage::CannotOpen, DoorPassage::InProgress] {
            assert!(nodes_at(&graph_of(passage, ANCHORS).0, is_door).is_empty());
        }
        assert_eq!(nodes_at(&graph_of(DoorPassage::Absent, ANCHORS).0, is_door).len(), 1);
    }

    #[test]
    fn clearances_are_those_of_the_narrowest_cell() {
        let (graph, buffer) = graph_of(DoorPassage::Passable, ANCHORS);
        let free_space = FreeSpace::of(&Grid::open(buffer.bytes()).unwrap(), 0.2);
        for node in &graph.nodes {
            assert_eq!(node.clearance_m, free_space.clearance_m(node.at));
        }
        let clearances = |door: Option<u32>| graph.edges.iter().filter(move |e| e.door == door).map(|e| e.clearance_m);
        // The opening is eight cells wide: its fourth or fifth is four from the jamb's nearest cell.
        assert!(clearances(Some(0)).all(|m| (m - 0.4).abs() < 1e-9), "{:?}", graph.edges);
        assert!(clearances(None).all(|m| 0.4 < m));
    }

    #[test]
    fn lines_begin_and_end_at_their_nodes_and_are_as_long_as_they_say() {
        // Anchors away from the middles of cells.
        let (graph, _) = graph_of(DoorPassage::Passable, [[0.31, 0.62], [3.99, 1.87]]);
        for edge in &graph.edges {
            let ends = edge.nodes.map(|n| graph.nodes[n].at);
            assert_eq!([edge.line[0], *edge.line.last().unwrap()], ends);
            assert_eq!(edge.walked.length_m, length_m(&edge.line));
            assert!(edge.line.windows(2).all(|p| p[0] != p[1]), "{:?}", edge.line);
        }
    }

    #[test]
    fn anchors_in_one_place_are_nodes_side_by_side() {
        let (graph, _) = graph_of(DoorPassage::Passable, [[1.1, 1.1], [1.1, 1.1]]);
        assert_eq!(nodes_at(&graph, |place| matches!(place, NodePlace::Space(_))).len(), 2);
        assert!(graph.edges.iter().any(|e| e.nodes.contains(&0)) && graph.edges.iter().any(|e| e.nodes.contains(&1)));
    }

    proptest! {
        #[test]
        fn lines_run_over_free_floor_wherever_their_nodes_are(
            text in floors(),
            anchors in prop::collection::vec((0.1f64..2.5, 0.1f64..1.7), 1..6),
        ) {
            let (site, buffer) = (SiteBuilder::default().finish(), drawn(&text));
            let (site, grid) = (Site::open(site.bytes()).unwrap(), Grid::open(buffer.bytes()).unwrap());
            let spec = grid.spec();
            let planning = |at: [f64; 2]| {
                spec.cell_at(Point2::new(at[0], at[1])).map_or(-1, |cell| grid.planning[spec.index(cell)])
            };
            let anchors: Vec<[f64; 2]> =
                anchors.into_iter().map(|(x, y)| [x, y]).filter(|at| planning(*at) == 0).collect();
            let graph = graph_on(&site, &grid, 0.1, &[], &anchors);
            for ends in graph.edges.iter().flat_map(|e| e.line.windows(2)) {
                for k in 0..=200 {
                    let t = f64::from(k) / 200.0;
                    let [x, y] = [[ends[0].x_m(), ends[1].x_m()], [ends[0].y_m(), ends[1].y_m()]].map(|[a, b]| a + (b - a) * t);
                    // A line may run along a side of a cell, and over its corner.
                    let beside = [[-1e-5, -1e-5], [-1e-5, 1e-5], [1e-5, -1e-5], [1e-5, 1e-5]];
                    let is_free = beside.iter().any(|d| planning([x + d[0], y + d[1]]) == 0);
                    prop_assert!(is_free, "{:?} at {}, {} in\n{}", ends, x, y, text);
                }
            }
        }
    }
}
