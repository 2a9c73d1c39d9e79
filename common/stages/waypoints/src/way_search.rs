//! The least costly way over the cells of several storeys and the portals between them.

use crate::path_search::{NO_PATH, PathGrid};
use crate::portal::Portal;
use grid::SparseLayer;
use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap};

/// A place: storey, and cell of its path grid.
pub(crate) type Place = (usize, usize);

/// A stretch of a way.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum WayStretch {
    /// Over cells of the path grid of a storey, each beside the one before it.
    Floor(usize, Vec<usize>),
    /// Through a portal, by its number; true from its first end to its second.
    Portal(usize, bool),
}

/// What steps and portals cost.
pub(crate) struct WayCosts<'a> {
    /// Of a step on a storey, from a cell to another, that costs so much by length.
    pub(crate) step: &'a dyn Fn(usize, [usize; 2], u32) -> u32,
    /// Of a portal, by its number; true from its first end to its second.
    pub(crate) portal: &'a dyn Fn(usize, bool) -> u32,
}

/// The stretches of the way from a place to another that costs least; `None` if there is none. `path_grids` are by storey, and only
/// usable portals may be given. Of ways that cost the same the one over lower storeys and cells.
///
/// # Source
/// Dijkstra, "A note on two problems in connexion with graphs", Numerische Mathematik 1, 1959.
pub(crate) fn least_costly(
    path_grids: &[Option<&PathGrid>],
    portals: &[&Portal],
    costs: &WayCosts<'_>,
    ends: impl Fn(&Portal) -> [Option<Place>; 2],
    from: Place,
    to: Place,
) -> Option<Vec<WayStretch>> {
    // By place: other ends with the cost of the way there, the portal and its direction.
    let mut ways_from: BTreeMap<Place, Vec<(Place, u32, usize, bool)>> = BTreeMap::new();
    for (k, portal) in portals.iter().enumerate() {
        let [Some(low), Some(high)] = ends(portal) else { continue };
        ways_from.entry(low).or_default().push((high, (costs.portal)(k, true), k, true));
        ways_from.entry(high).or_default().push((low, (costs.portal)(k, false), k, false));
    }
    let layer = |value: u32| -> Vec<Option<SparseLayer<u32>>> {
        path_grids.iter().map(|grid| grid.map(|grid| grid.open.cells().layer(value))).collect()
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
        let (Some(grid), Some(known), Some(cells)) = (path_grids[storey], &mut cost[storey], &mut came_from[storey])
        else {
            continue;
        };
        if so_far > known[cell] {
            continue;
        }
        grid.steps_from(cell, |next, step| {
            let total = so_far.saturating_add((costs.step)(storey, [cell, next], step));
            if total < known[next] {
                (known[next], cells[next]) = (total, cell as u32);
                came_through.remove(&(storey, next));
                heap.push(Reverse((total, (storey, next))));
            }
        });
        for &(next, step, portal, is_forward) in ways_from.get(&place).into_iter().flatten() {
            let total = so_far.saturating_add(step);
            let Some(known) = &mut cost[next.0] else { continue };
            if total < known[next.1] {
                known[next.1] = total;
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
) -> Vec<WayStretch> {
    let mut stretches = Vec::new();
    let (mut at, mut cells) = (to, vec![to.1]);
    while at != from {
        if let Some(&(portal, is_forward)) = came_through.get(&at) {
            cells.reverse();
            stretches.push(WayStretch::Floor(at.0, std::mem::take(&mut cells)));
            stretches.push(WayStretch::Portal(portal, is_forward));
            let [low, high] = ends(portals[portal]);
            at = if is_forward { low } else { high }.expect("a portal that was taken has both ends");
        } else {
            let layer = came_from[at.0].as_ref().expect("a storey that was walked on has cells");
            at = (at.0, layer[at.1] as usize);
        }
        cells.push(at.1);
    }
    cells.reverse();
    stretches.push(WayStretch::Floor(at.0, cells));
    stretches.reverse();
    stretches
}
