//! The shortest way over the cells of several storeys and the portals between them.

use crate::path_search::{NO_PATH, PathGrid, SIDE};
use crate::portal::Portal;
use grid::SparseLayer;
use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap};

/// A place: storey, and cell of its path grid.
pub(super) type Place = (usize, usize);

/// A stretch of a way.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Stretch {
    /// Over cells of the path grid of a storey, each beside the one before it.
    Floor(usize, Vec<usize>),
    /// Through a portal, by its number; true from its first end to its second.
    Portal(usize, bool),
}

/// The stretches of the shortest way from a place to another; `None` if there is none. `path_grids` are by storey, and only
/// usable portals may be given. Of equally short ways the one over lower storeys and cells.
///
/// # Source
/// Dijkstra, "A note on two problems in connexion with graphs", Numerische Mathematik 1, 1959.
pub(super) fn shortest(
    path_grids: &[Option<PathGrid>],
    portals: &[&Portal],
    ends: impl Fn(&Portal) -> [Option<Place>; 2],
    from: Place,
    to: Place,
) -> Option<Vec<Stretch>> {
    // By place: other ends with the cost of the way there, the portal and its direction.
    let mut ways_from: BTreeMap<Place, Vec<(Place, u32, usize, bool)>> = BTreeMap::new();
    for (k, portal) in portals.iter().enumerate() {
        let [Some(low), Some(high)] = ends(portal) else { continue };
        let resolution_m = path_grids[low.0].as_ref()?.resolution_m();
        let cost = (portal.length_m / resolution_m * f64::from(SIDE)).ceil() as u32;
        ways_from.entry(low).or_default().push((high, cost, k, true));
        ways_from.entry(high).or_default().push((low, cost, k, false));
    }
    let layer = |value: u32| -> Vec<Option<SparseLayer<u32>>> {
        path_grids.iter().map(|grid| grid.as_ref().map(|grid| grid.open.cells().layer(value))).collect()
    };
    let (mut cost, mut came_from) = (layer(NO_PATH), layer(0));
    let mut came_through: BTreeMap<Place, (usize, bool)> = BTreeMap::new();
    let mut heap = BinaryHeap::from([Reverse((0u32, from))]);
    cost[from.0].as_mut()?[from.1] = 0;
    while let Some(Reverse((so_far, place))) = heap.pop() {
        let (storey, cell) = place;
        if place == to {
            return Some(stretches(&came_from, &came_through, portals, &ends, from, to));
        }
        let (Some(grid), Some(costs), Some(cells)) = (&path_grids[storey], &mut cost[storey], &mut came_from[storey])
        else {
            continue;
        };
        if so_far > costs[cell] {
            continue;
        }
        grid.steps_from(cell, |next, step| {
            let total = so_far.saturating_add(step);
            if total < costs[next] {
                (costs[next], cells[next]) = (total, cell as u32);
                came_through.remove(&(storey, next));
                heap.push(Reverse((total, (storey, next))));
            }
        });
        for &(next, step, portal, is_forward) in ways_from.get(&place).into_iter().flatten() {
            let total = so_far.saturating_add(step);
            let Some(costs) = &mut cost[next.0] else { continue };
            if total < costs[next.1] {
                costs[next.1] = total;
                came_through.insert(next, (portal, is_forward));
                heap.push(Reverse((total, next)));
            }
        }
    }
    None
}

/// The stretches of a way that was found, from its end back to where it begins.
fn stretches(
    came_from: &[Option<SparseLayer<u32>>],
    came_through: &BTreeMap<Place, (usize, bool)>,
    portals: &[&Portal],
    ends: &impl Fn(&Portal) -> [Option<Place>; 2],
    from: Place,
    to: Place,
) -> Vec<Stretch> {
    let mut stretches = Vec::new();
    let (mut at, mut cells) = (to, vec![to.1]);
    while at != from {
        if let Some(&(portal, is_forward)) = came_through.get(&at) {
            cells.reverse();
            stretches.push(Stretch::Floor(at.0, std::mem::take(&mut cells)));
            stretches.push(Stretch::Portal(portal, is_forward));
            let [low, high] = ends(portals[portal]);
            at = if is_forward { low } else { high }.expect("a portal that was taken has both ends");
        } else {
            let layer = came_from[at.0].as_ref().expect("a storey that was walked on has cells");
            at = (at.0, layer[at.1] as usize);
        }
        cells.push(at.1);
    }
    cells.reverse();
    stretches.push(Stretch::Floor(at.0, cells));
    stretches.reverse();
    stretches
}
