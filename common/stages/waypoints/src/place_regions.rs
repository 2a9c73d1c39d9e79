//! Regions of the floor: the cells that are nearest to each place, and the paths between places of neighbouring regions. One
//! search over the cells for all places.
//!
//! A minimum spanning tree over these paths is one over the shortest paths between all places.
//!
//! # Source
//! Mehlhorn, "A faster approximation algorithm for the Steiner problem in graphs", Information Processing Letters 27, 1988.

use crate::path_search::{NO_PATH, NO_STEP, PathGrid, around};
use grid::SparseLayer;

/// Regions of places, given by the cells in which they lie.
pub(crate) struct PlaceRegions {
    cells: SparseLayer<Reached>,
    /// Pairs of places with neighbouring regions, ascending.
    pub(crate) borders: Vec<Border>,
    /// Cells of a row.
    width: usize,
}

/// How a cell is reached from the place of its region.
#[derive(Debug, Clone, Copy)]
struct Reached {
    /// The place; `NONE` where none can be reached from.
    region: u32,
    /// Cost of the path from it.
    cost: u32,
    /// Direction of the last step of that path; [`NO_STEP`] in its own cell.
    by: u8,
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
        let mut reached = path_grid.open.cells().layer(Reached { region: NONE, cost: NO_PATH, by: NO_STEP });
        let mut buckets = vec![Vec::new(); N_BUCKETS];
        let (mut n_waiting, mut now) = (0usize, 0u32);
        for (&cell, place) in cells.iter().zip(0..) {
            if path_grid.open[cell] && reached[cell].region == NONE {
                reached[cell] = Reached { region: place, cost: 0, by: NO_STEP };
                buckets[0].push(cell as u32);
                n_waiting += 1;
            }
        }
        while n_waiting > 0 {
            while let Some(cell) = buckets[now as usize % N_BUCKETS].pop() {
                n_waiting -= 1;
                let cell = cell as usize;
                let Reached { region, cost, by } = reached[cell];
                if cost != now {
                    continue;
                }
                path_grid.steps_on(cell, by, |next, step, by| {
                    let next_reached = &mut reached[next];
                    if now + step < next_reached.cost {
                        *next_reached = Reached { region, cost: now + step, by };
                        buckets[(now + step) as usize % N_BUCKETS].push(next as u32);
                        n_waiting += 1;
                    }
                });
            }
            now += 1;
        }
        let borders = find_borders(path_grid, &reached);
        Self { cells: reached, borders, width: path_grid.width }
    }

    /// The cells of the path between two places, the first one's first.
    pub(crate) fn path(&self, border: &Border) -> Vec<usize> {
        let towards = |cell: u32| std::iter::successors(Some(cell as usize), |&cell| self.before(cell));
        let mut path: Vec<usize> = towards(border.cells[0]).collect();
        path.reverse();
        path.extend(towards(border.cells[1]));
        path
    }

    /// The next cell towards the place of a cell's region; `None` in the place's own cell.
    fn before(&self, cell: usize) -> Option<usize> {
        let by = self.cells[cell].by;
        (by != NO_STEP).then(|| around(cell, self.width)[usize::from(by + 4) % 8])
    }
}

/// The shortest path between each two neighbouring regions.
fn find_borders(path_grid: &PathGrid, reached: &SparseLayer<Reached>) -> Vec<Border> {
    let mut borders = Vec::new();
    let w = path_grid.width;
    let (mut here, mut above) = (vec![NONE; w], vec![NONE; w]);
    let read = |row: usize, out: &mut [u32]| reached.read(row, out, |reached| reached.region);
    read(w, &mut above);
    // Steps lead both ways: those to later cells are all. No step leads from the border of unreachable cells.
    for row in (w..reached.cells().n_cells() - w).step_by(w) {
        std::mem::swap(&mut here, &mut above);
        read(row + w, &mut above);
        for column in 1..w - 1 {
            let region = here[column];
            let beside = [here[column + 1], above[column - 1], above[column], above[column + 1]];
            if region == NONE || beside == [region; 4] {
                continue;
            }
            let cell = row + column;
            path_grid.steps_from(cell, |next, step| {
                let [own, other] = [reached[cell], reached[next]];
                if next < cell || other.region == region {
                    return;
                }
                let [a, b] = if region < other.region { [cell, next] } else { [next, cell] };
                borders.push(Border {
                    places: [region.min(other.region), region.max(other.region)],
                    cost: own.cost + step + other.cost,
                    cells: [a as u32, b as u32],
                });
            });
        }
    }
    borders.sort_unstable();
    borders.dedup_by_key(|border| border.places);
    borders
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

    /// The paths over a drawn floor, and those of its cells that were picked.
    fn picked(text: &str, picks: &[usize]) -> Option<(PathGrid, Vec<usize>)> {
        let free_space = FreeSpace::of(&Grid::open(drawn(text).bytes()).unwrap(), 0.1);
        let path_grid = PathGrid::of(&free_space, |_| true)?;
        let open: Vec<usize> = path_grid.open.cells().iter().filter(|&cell| path_grid.open[cell]).collect();
        let mut cells: Vec<usize> = picks.iter().map(|k| open[k % open.len()]).collect();
        cells.sort_unstable();
        cells.dedup();
        Some((path_grid, cells))
    }

    /// The search of [`PlaceRegions::of`] over all steps: by cell the region, the cost and the cell before.
    fn over_all_steps(path_grid: &PathGrid, places: &[usize]) -> Vec<Option<(u32, u32, usize)>> {
        let mut reached: Vec<Option<(u32, u32, usize)>> = vec![None; path_grid.open.cells().n_cells()];
        let mut buckets: Vec<Vec<usize>> = vec![places.to_vec()];
        places.iter().zip(0..).for_each(|(&cell, place)| reached[cell] = Some((place, 0, cell)));
        let mut now = 0;
        while now < buckets.len() {
            while let Some(cell) = buckets[now].pop() {
                let (region, cost, _) = reached[cell].unwrap();
                if cost as usize != now {
                    continue;
                }
                path_grid.steps_from(cell, |next, step| {
                    if reached[next].is_none_or(|known| cost + step < known.1) {
                        reached[next] = Some((region, cost + step, cell));
                        buckets.resize(buckets.len().max((cost + step) as usize + 1), Vec::new());
                        buckets[(cost + step) as usize].push(next);
                    }
                });
            }
            now += 1;
        }
        reached
    }

    proptest! {
        #[test]
        fn a_search_that_goes_on_only_where_it_can_gain_reaches_all_as_one_over_all_steps(
            text in floors(),
            picks in prop::collection::vec(0usize..400, 1..9),
        ) {
            let Some((path_grid, cells)) = picked(&text, &picks) else { return Ok(()) };
            let regions = PlaceRegions::of(&path_grid, &cells);
            for (cell, expected) in over_all_steps(&path_grid, &cells).into_iter().enumerate() {
                let Reached { region, cost, .. } = regions.cells[cell];
                let before = || regions.before(cell).unwrap_or(cell);
                prop_assert_eq!((region != NONE).then(|| (region, cost, before())), expected);
            }
        }

        #[test]
        fn paths_over_borders_lead_from_place_to_place_and_the_cheapest_of_a_place_is_a_shortest_one(
            text in floors(),
            picks in prop::collection::vec(0usize..400, 2..9),
        ) {
            let Some((path_grid, cells)) = picked(&text, &picks) else { return Ok(()) };
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
