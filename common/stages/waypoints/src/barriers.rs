//! Obstacles between the robot and each part that it does not get to, on the way there that has the fewest.

use crate::floor_parts::parts_at;
use crate::free_space::FreeSpace;
use crate::input::MissionPlanInput;
use crate::portal::{Portal, PortalKind};
use crate::reachability::Reachability;
use messages::{DoorPassageRecord, EdgeKind, NONE, Site};
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// What would have to change for a way to lead on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Obstacle {
    /// A door that is closed to the robot.
    Door(DoorPassageRecord),
    /// A space that is closed by the schedule.
    Space(usize),
    /// A stair, ramp, lift or step that the robot does not use, by element.
    Portal(PortalKind, usize),
    /// Floor of a storey between two places, on which nothing stands and the robot cannot stand.
    Floor(usize, [FloorEnd; 2]),
}

/// An end of floor on which the robot cannot stand.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum FloorEnd {
    /// A part of the storey.
    Part(u32),
    /// A space that is closed by the schedule.
    Space(usize),
}

/// Obstacles on the way to each part of a storey, that nearest to it first; empty for a part that is reached, and for one to
/// which the model has no way at all. Part 0 has none.
pub(crate) type BarriersOfParts = Vec<Vec<Obstacle>>;

/// A connection of two nodes, and what closes it.
struct Link {
    ends: [usize; 2],
    obstacle: Option<Obstacle>,
}

/// Two places of a storey between which there is floor on which the robot cannot stand.
pub(crate) struct FloorBetween {
    pub(crate) storey: usize,
    pub(crate) ends: [FloorEnd; 2],
}

/// A place from which obstacles are counted, or to which.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum BarrierNode {
    /// A part of a storey.
    Part(usize, u32),
    /// A space that is closed by the schedule, which has no free space.
    Space(usize),
}

/// The node before a node on the way to it, and what closes the link between them.
type CameFrom = Option<(usize, Option<Obstacle>)>;

/// The ways with the fewest obstacles from some places to all others.
pub(crate) struct BarrierSearch {
    /// Node of part 0 of each storey.
    first_node: Vec<usize>,
    /// Node of the first space.
    first_space: usize,
    came_from: Vec<CameFrom>,
    is_reached: Vec<bool>,
}

impl BarrierSearch {
    /// From the places for which `is_source` is true. `between` are connections that neither doors nor portals make.
    pub(crate) fn of(
        input: &MissionPlanInput<'_>,
        free_spaces: &[&FreeSpace],
        portals: &[Portal],
        between: &[FloorBetween],
        is_source: impl Fn(BarrierNode) -> bool,
    ) -> Self {
        let mut first_node = Vec::with_capacity(free_spaces.len());
        let mut first_space = 0;
        for free_space in free_spaces {
            first_node.push(first_space);
            first_space += free_space.n_parts() as usize + 1;
        }
        let n_nodes = first_space + input.site.spaces.len();
        let mut links = links(input, free_spaces, portals, &first_node, first_space);
        links.extend(between.iter().map(|between| Link {
            ends: between.ends.map(|end| match end {
                FloorEnd::Part(part) => first_node[between.storey] + part as usize,
                FloorEnd::Space(space) => first_space + space,
            }),
            obstacle: Some(Obstacle::Floor(between.storey, between.ends)),
        }));
        let place = |node: usize| match node.checked_sub(first_space) {
            Some(space) => BarrierNode::Space(space),
            None => {
                let storey = first_node.partition_point(|first| *first <= node) - 1;
                BarrierNode::Part(storey, (node - first_node[storey]) as u32)
            }
        };
        let sources = (0..n_nodes).filter(|node| is_source(place(*node)));
        let obstacle_in = |node: usize| node.checked_sub(first_space).map(Obstacle::Space);
        let (came_from, is_reached) = cheapest(&links, n_nodes, sources, obstacle_in);
        Self { first_node, first_space, came_from, is_reached }
    }

    fn node(&self, place: BarrierNode) -> usize {
        match place {
            BarrierNode::Part(storey, part) => self.first_node[storey] + part as usize,
            BarrierNode::Space(space) => self.first_space + space,
        }
    }

    /// True if there is a way to a place, with whatever obstacles.
    pub(crate) fn leads_to(&self, place: BarrierNode) -> bool {
        self.is_reached[self.node(place)]
    }

    /// The obstacles on the way to a place, that nearest to it first, without the place itself; none if there is no way.
    pub(crate) fn obstacles_to(&self, place: BarrierNode) -> Vec<Obstacle> {
        let mut node = self.node(place);
        let mut obstacles = Vec::new();
        while let Some((from, obstacle)) = self.came_from[node] {
            obstacles.extend(obstacle);
            node = from;
            obstacles.extend(node.checked_sub(self.first_space).map(Obstacle::Space));
        }
        obstacles
    }
}

/// Obstacles of all storeys.
pub(crate) fn barriers(
    input: &MissionPlanInput<'_>,
    free_spaces: &[&FreeSpace],
    portals: &[Portal],
    reached: &Reachability,
) -> Vec<BarriersOfParts> {
    let is_source = |place: BarrierNode| match place {
        BarrierNode::Part(storey, part) => reached.parts[storey][part as usize],
        BarrierNode::Space(_) => false,
    };
    let search = BarrierSearch::of(input, free_spaces, portals, &[], is_source);
    let of_storey = |(storey, free_space): (usize, &&FreeSpace)| {
        (0..=free_space.n_parts()).map(|part| search.obstacles_to(BarrierNode::Part(storey, part))).collect()
    };
    free_spaces.iter().enumerate().map(of_storey).collect()
}

/// Closed doors and portals between parts, and doors of spaces that are closed by the schedule.
fn links(
    input: &MissionPlanInput<'_>,
    free_spaces: &[&FreeSpace],
    portals: &[Portal],
    first_node: &[usize],
    first_space: usize,
) -> Vec<Link> {
    let MissionPlanInput { site, schedule_state, index, grids, .. } = *input;
    let mut links = Vec::new();
    for (storey, free_space) in free_spaces.iter().enumerate() {
        grids.with(storey, |grid| {
            for passage in input.passages(grid) {
                let door = &site.doors[passage.door as usize];
                let rooms = door.spaces.iter().filter(|&&space| space != NONE).map(|&space| space as usize);
                let blocked: Vec<usize> = rooms.filter(|&space| schedule_state.is_blocked(space)).collect();
                let is_closed = passage.passage.get().is_closed();
                // Free space leads through any other door.
                if !is_closed && blocked.is_empty() {
                    continue;
                }
                let parts = parts_at(free_space, grid, door, index.head.robot.radius_m);
                let mut nodes: Vec<usize> = parts.into_iter().map(|part| first_node[storey] + part as usize).collect();
                nodes.extend(blocked.into_iter().map(|space| first_space + space));
                let obstacle = is_closed.then_some(Obstacle::Door(passage));
                for (k, &a) in nodes.iter().enumerate() {
                    links.extend(nodes[k + 1..].iter().map(|&b| Link { ends: [a, b], obstacle }));
                }
            }
        });
    }
    // Behind a closed door a portal that the robot uses leads on.
    links.extend(portals.iter().map(|portal| Link {
        ends: portal.ends.map(|end| first_node[end.storey] + end.part as usize),
        obstacle: (!portal.usable).then_some(Obstacle::Portal(portal.kind, portal.element)),
    }));
    links
}

/// Of each node where the way to it with the fewest obstacles comes from, and what closes its last link; `None` for the
/// sources and for nodes that no way leads to. And which nodes are sources, or have a way. Of equal ways the one over lower nodes.
fn cheapest(
    links: &[Link],
    n_nodes: usize,
    sources: impl Iterator<Item = usize>,
    obstacle_in: impl Fn(usize) -> Option<Obstacle>,
) -> (Vec<CameFrom>, Vec<bool>) {
    let mut links_of = vec![Vec::new(); n_nodes];
    for (k, link) in links.iter().enumerate() {
        link.ends.iter().for_each(|&end| links_of[end].push(k));
    }
    let mut cost = vec![u32::MAX; n_nodes];
    let mut came_from = vec![None; n_nodes];
    let mut heap = BinaryHeap::new();
    for source in sources {
        cost[source] = 0;
        heap.push(Reverse((0, source)));
    }
    while let Some(Reverse((so_far, node))) = heap.pop() {
        if so_far > cost[node] {
            continue;
        }
        for &k in &links_of[node] {
            let Link { ends: [a, b], obstacle } = links[k];
            let next = if a == node { b } else { a };
            let total = so_far + obstacle.map_or(0, weight) + u32::from(obstacle_in(next).is_some());
            if total < cost[next] {
                cost[next] = total;
                came_from[next] = Some((node, obstacle));
                heap.push(Reverse((total, next)));
            }
        }
    }
    let is_reached = cost.into_iter().map(|cost| cost != u32::MAX).collect();
    (came_from, is_reached)
}

/// What can be named as one thing counts as one obstacle; floor on which the robot cannot stand may have several causes.
fn weight(obstacle: Obstacle) -> u32 {
    if matches!(obstacle, Obstacle::Floor(..)) { 3 } else { 1 }
}

/// A portal that the robot does not use, in words.
pub fn portal_text(site: &Site<'_>, kind: EdgeKind, element: usize) -> String {
    // Floor that no element carries has none.
    let Some(element) = site.elements.get(element) else {
        return "a step on the way is too high for this robot".to_owned();
    };
    let id = site.text(element.global_id);
    match kind {
        EdgeKind::Stair => format!("this robot does not climb the stair {id}"),
        EdgeKind::Ramp => format!("the ramp {id} is too steep for this robot"),
        EdgeKind::Lift => format!("this robot does not take the lift {id}"),
        EdgeKind::Escalator => format!("this robot does not use the escalator {id}"),
        EdgeKind::Step => format!("the step at {id} is too high for this robot"),
        EdgeKind::Floor | EdgeKind::Door | EdgeKind::Ground => format!("this robot does not pass {id}"),
    }
}
