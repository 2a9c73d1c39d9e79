//! Obstacles between the robot and each part that it does not get to, on the way there that has the fewest.

use crate::floor_parts::parts_at;
use crate::free_space::FreeSpace;
use crate::input::MissionPlanInput;
use crate::portal::{Portal, PortalKind};
use crate::reachability::Reachability;
use messages::{DoorPassageRecord, NONE, Site};
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
}

/// Obstacles on the way to each part of a storey, that nearest to it first; empty for a part that is reached, and for one to
/// which the model has no way at all. Part 0 has none.
pub(crate) type BarriersOfParts = Vec<Vec<Obstacle>>;

/// A connection of two nodes, and what closes it.
struct Link {
    ends: [usize; 2],
    obstacle: Option<Obstacle>,
}

/// Obstacles of all storeys. Nodes are the parts of all storeys, and the spaces that are closed by the schedule: these have no
/// free space.
pub(crate) fn barriers(
    input: &MissionPlanInput<'_>,
    free_spaces: &[&FreeSpace],
    portals: &[Portal],
    reached: &Reachability,
) -> Vec<BarriersOfParts> {
    let mut first_node = Vec::with_capacity(free_spaces.len() + 1);
    let mut n_nodes = 0;
    for free_space in free_spaces {
        first_node.push(n_nodes);
        n_nodes += free_space.n_parts() as usize + 1;
    }
    let first_space = n_nodes;
    let links = links(input, free_spaces, portals, &first_node, first_space);
    let is_source = |node: &usize| {
        let storey = first_node.partition_point(|first| first <= node) - 1;
        reached.parts[storey][node - first_node[storey]]
    };
    let came_from =
        cheapest(&links, first_space + input.site.spaces.len(), (0..first_space).filter(is_source), |node| {
            node.checked_sub(first_space).map(Obstacle::Space)
        });
    let obstacles_to = |mut node: usize| {
        let mut obstacles = Vec::new();
        while let Some((from, obstacle)) = came_from[node] {
            obstacles.extend(obstacle);
            node = from;
            obstacles.extend(node.checked_sub(first_space).map(Obstacle::Space));
        }
        obstacles
    };
    let of_storey = |(storey, free_space): (usize, &&FreeSpace)| {
        (0..=free_space.n_parts() as usize).map(|part| obstacles_to(first_node[storey] + part)).collect()
    };
    free_spaces.iter().enumerate().map(of_storey).collect()
}

/// Closed doors and unusable portals between parts, and doors of spaces that are closed by the schedule.
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
        let map_storey = grids.head(storey).map_storey;
        grids.with(storey, |grid| {
            for passage in index.doors.iter().filter(|door| door.map_storey == map_storey) {
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
                let obstacle = is_closed.then_some(Obstacle::Door(*passage));
                for (k, &a) in nodes.iter().enumerate() {
                    links.extend(nodes[k + 1..].iter().map(|&b| Link { ends: [a, b], obstacle }));
                }
            }
        });
    }
    links.extend(portals.iter().filter(|portal| !portal.usable).map(|portal| Link {
        ends: portal.ends.map(|end| first_node[end.storey] + end.part as usize),
        obstacle: Some(Obstacle::Portal(portal.kind, portal.element)),
    }));
    links
}

/// Of each node where the way to it with the fewest obstacles comes from, and what closes its last link; `None` for the
/// sources and for nodes that no way leads to. Of equal ways the one over lower nodes.
fn cheapest(
    links: &[Link],
    n_nodes: usize,
    sources: impl Iterator<Item = usize>,
    obstacle_in: impl Fn(usize) -> Option<Obstacle>,
) -> Vec<Option<(usize, Option<Obstacle>)>> {
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
            let total = so_far + u32::from(obstacle.is_some()) + u32::from(obstacle_in(next).is_some());
            if total < cost[next] {
                cost[next] = total;
                came_from[next] = Some((node, obstacle));
                heap.push(Reverse((total, next)));
            }
        }
    }
    came_from
}

/// A portal that the robot does not use, in words.
pub(crate) fn portal_text(site: &Site<'_>, kind: PortalKind, element: usize) -> String {
    let id = site.text(site.elements[element].global_id);
    match kind {
        PortalKind::Stair => format!("this robot does not climb the stair {id}"),
        PortalKind::Ramp { .. } => format!("the ramp {id} is too steep for this robot"),
        PortalKind::Lift => format!("this robot does not take the lift {id}"),
        PortalKind::Escalator => format!("this robot does not use the escalator {id}"),
        PortalKind::Step => format!("the step at {id} is too high for this robot"),
    }
}
