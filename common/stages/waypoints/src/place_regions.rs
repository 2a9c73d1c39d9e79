//! Regions of the floor: the cells that are nearest to each place, and the paths between places of neighbouring regions. One
//! search over the cells for all places.
//!
//! A minimum spanning tree over these paths is one over the shortest paths between all places.
//!
//! # Source
//! Mehlhorn, "A faster approximation algorithm for the Steiner problem in graphs", Information Processing Letters 27, 1988.

use crate::path_search::{NO_PATH, PathGrid};
use grid::SparseLayer;

/// Regions of places, given by the cells in which they lie.
pub(crate) struct PlaceRegions {
    /// Place of each cell; `NONE` where none can be reached from.
    region: SparseLayer<u32>,
    /// Next cell towards the place of the region.
    from: SparseLayer<u32>,
    /// Pairs of places with neighbouring regions, ascending.
    pub(crate) borders: Vec<Border>,
}

/// Where the path between the places of two neighbouring regions crosses their border.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Border {
    /// The lower one first.
    pub(crate) places: [u32; 2],
    /// Cost of the path, as of [`PathGrid::steps_from`].
    pub(crate) cost: u32,
    /// The last cell in the first region, and the first in the other.
    cells: [u32; 2],
}

const NONE: u32 = u32::MAX;

/// More than the cost of any step.
const N_BUCKETS: usize = 64;

impl PlaceRegions {
    /// Of places in the same cell the first one has the region, the others have none.
    pub(crate) fn of(path_grid: &PathGrid, cells: &[usize]) -> Self {
        let floor = path_grid.open.cells();
        let mut cost = floor.layer(NO_PATH);
        let mut regions = Self { region: floor.layer(NONE), from: floor.layer(NONE), borders: Vec::new() };
        let mut buckets = vec![Vec::new(); N_BUCKETS];
        let (mut n_waiting, mut now) = (0usize, 0u32);
        for (&cell, place) in cells.iter().zip(0..) {
            if path_grid.open[cell] && regions.region[cell] == NONE {
                (cost[cell], regions.region[cell]) = (0, place);
                buckets[0].push(cell as u32);
                n_waiting += 1;
            }
        }
        while n_waiting > 0 {
            while let Some(cell) = buckets[now as usize % N_BUCKETS].pop() {
                n_waiting -= 1;
                let cell = cell as usize;
                if cost[cell] != now {
                    continue;
                }
                let place = regions.region[cell];
                path_grid.steps_from(cell, |next, step| {
                    if now + step < cost[next] {
                        (cost[next], regions.region[next], regions.from[next]) = (now + step, place, cell as u32);
                        buckets[(now + step) as usize % N_BUCKETS].push(next as u32);
                        n_waiting += 1;
                    }
                });
            }
            now += 1;
        }
        regions.borders = regions.find_borders(path_grid, &cost);
        regions
    }

    /// The shortest path between each two neighbouring regions.
    fn find_borders(&self, path_grid: &PathGrid, cost: &SparseLayer<u32>) -> Vec<Border> {
        let mut borders = Vec::new();
        let w = path_grid.width;
        // Steps lead both ways: those to later cells are all.
        for cell in cost.cells().iter().filter(|&cell| self.region[cell] != NONE) {
            let region = self.region[cell];
            if [cell + 1, cell + w - 1, cell + w, cell + w + 1].iter().all(|&next| self.region[next] == region) {
                continue;
            }
            path_grid.steps_from(cell, |next, step| {
                if next < cell || self.region[next] == region {
                    return;
                }
                let [a, b] = if region < self.region[next] { [cell, next] } else { [next, cell] };
                borders.push(Border {
                    places: [self.region[a], self.region[b]],
                    cost: cost[cell] + step + cost[next],
                    cells: [a as u32, b as u32],
                });
            });
        }
        borders.sort_unstable();
        borders.dedup_by_key(|border| border.places);
        borders
    }

    /// The cells of the path between two places, the first one's first.
    pub(crate) fn path(&self, border: &Border) -> Vec<usize> {
        let towards = |cell: u32| {
            let next = |&cell: &u32| Some(self.from[cell as usize]).filter(|next| *next != NONE);
            std::iter::successors(Some(cell), next).map(|cell| cell as usize)
        };
        let mut path: Vec<usize> = towards(border.cells[0]).collect();
        path.reverse();
        path.extend(towards(border.cells[1]));
        path
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::free_space::FreeSpace;
    use crate::free_space::tests::{drawn, floors};
    use crate::path_search::SearchBuffers;
    use messages::Grid;
    use proptest::prelude::*;

    /// Cost of a path, and that it is one.
    fn cost(path_grid: &PathGrid, path: &[usize]) -> u32 {
        let step = |pair: &[usize]| {
            let mut found = None;
            path_grid.steps_from(pair[0], |next, cost| found = found.or((next == pair[1]).then_some(cost)));
            found.unwrap()
        };
        path.windows(2).map(step).sum()
    }

    proptest! {
        #[test]
        fn paths_over_borders_lead_from_place_to_place_and_the_cheapest_of_a_place_is_a_shortest_one(
            text in floors(),
            picks in prop::collection::vec(0usize..400, 2..9),
        ) {
            let free_space = FreeSpace::of(&Grid::open(drawn(&text).bytes()).unwrap(), 0.1);
            let Some(path_grid) = PathGrid::of(&free_space, |_| true) else { return Ok(()) };
            let open: Vec<usize> = path_grid.open.cells().iter().filter(|&cell| path_grid.open[cell]).collect();
            let mut cells: Vec<usize> = picks.into_iter().map(|k| open[k % open.len()]).collect();
            cells.sort_unstable();
            cells.dedup();
            let regions = PlaceRegions::of(&path_grid, &cells);
            let mut buffers = SearchBuffers::of(&path_grid);
            let mut shortest = |a: usize, b: usize| {
                let path = path_grid.shortest_path(cells[a], cells[b], &mut buffers);
                (!path.is_empty()).then(|| cost(&path_grid, &path))
            };
            for border in &regions.borders {
                let path = regions.path(border);
                let ends = border.places.map(|place| cells[place as usize]);
                prop_assert_eq!([path[0], path[path.len() - 1]], ends);
                prop_assert_eq!(cost(&path_grid, &path), border.cost);
                let [a, b] = border.places.map(|place| place as usize);
                prop_assert!(shortest(a, b).unwrap() <= border.cost);
            }
            for a in 0..cells.len() {
                let nearest = (0..cells.len()).filter(|&b| b != a).filter_map(|b| shortest(a, b)).min();
                let own = regions.borders.iter().filter(|border| border.places.contains(&(a as u32)));
                prop_assert_eq!(own.map(|border| border.cost).min(), nearest);
            }
        }
    }
}
