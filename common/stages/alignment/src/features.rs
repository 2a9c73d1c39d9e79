//! Features of a map for alignment, computed once per map.

use crate::corners::{Corner, corners};
use crate::random_generator::RandomGenerator;
use crate::rotations::{N_BINS, directions};
use crate::thresholds::{MAX_MATCH_M, NEAR_CORNER_M};
use crate::wall_points::{Surfaces, WallPoint, WallPoints};
use occupancy::{CELL_M, Cell, Raster};
use std::sync::OnceLock;

/// A map with its features. Points are metres from the map's lower left corner.
pub(crate) struct Features {
    pub(crate) raster: Raster,
    /// Mean of the free cells, at which errors of a pose are given.
    pub(crate) centre: [f64; 2],
    found: WallPoints,
    // Tracking draws from what was found; the rest is computed on first use.
    wall_points: OnceLock<Vec<WallPoint>>,
    corners: OnceLock<Vec<Corner>>,
    /// True for each cell that a corner is near.
    is_near_corner: OnceLock<Vec<bool>>,
    directions: OnceLock<Box<[f64; N_BINS]>>,
    /// The nearest wall point of each cell, with a margin around the map.
    nearest: OnceLock<Vec<u32>>,
}

impl Features {
    pub(crate) fn of(raster: Raster, surfaces: Surfaces) -> Self {
        let found = WallPoints::of(&raster, surfaces);
        let centre = centre(&raster);
        let (wall_points, nearest) = (OnceLock::new(), OnceLock::new());
        let (corners, is_near_corner, directions) = (OnceLock::new(), OnceLock::new(), OnceLock::new());
        Self { raster, centre, found, wall_points, corners, is_near_corner, directions, nearest }
    }

    /// All wall points, computed on first use.
    pub(crate) fn wall_points(&self) -> &[WallPoint] {
        self.wall_points.get_or_init(|| self.found.all_straight())
    }

    /// How many wall points there are.
    pub(crate) fn n_wall_points(&self) -> usize {
        self.found.len()
    }

    /// At most `n` wall points, drawn by weight.
    pub(crate) fn drawn_wall_points(&self, random: &mut RandomGenerator, n: usize) -> Vec<WallPoint> {
        self.found.drawn(random, n)
    }

    /// Length of the map's walls.
    pub(crate) fn walls_m(&self) -> f64 {
        self.n_wall_points() as f64 * CELL_M
    }

    /// Corners of the map, computed on first use.
    pub(crate) fn corners(&self) -> &[Corner] {
        self.corners.get_or_init(|| corners(&self.raster))
    }

    /// True if a corner is within [`NEAR_CORNER_M`] of the middle of a point's cell.
    pub(crate) fn is_near_corner(&self, point: [f64; 2]) -> bool {
        let is_near = self.is_near_corner.get_or_init(|| near_corners(&self.raster, self.corners()));
        self.raster.index_at(point).is_some_and(|index| is_near[index])
    }

    /// Histogram of the directions of wall points, computed on first use.
    pub(crate) fn directions(&self) -> &[f64; N_BINS] {
        self.directions.get_or_init(|| Box::new(directions(self.wall_points())))
    }

    /// The wall point nearest to the middle of a point's cell, and the squared distance to the point.
    #[inline]
    pub(crate) fn nearest(&self, point: [f64; 2]) -> Option<(&WallPoint, f64)> {
        let nearest = self.nearest.get_or_init(|| self.found.cells().nearest());
        let wall_point = nearest[self.found.cells().index_at(point)?];
        let wall_point = self.wall_points().get(wall_point as usize)?;
        Some((wall_point, squared_distance(point, wall_point.at)))
    }

    /// The squared distance to the nearest wall point within [`MAX_MATCH_M`], without looking at the whole map first: for few points.
    pub(crate) fn nearest_by_scan(&self, point: [f64; 2]) -> Option<f64> {
        let reach = (MAX_MATCH_M / CELL_M) as i64 + 1;
        let [column, row] = point.map(|c| (c / CELL_M).floor() as i64);
        let mut best: Option<f64> = None;
        for row in row - reach..=row + reach {
            // A wall point lies at most half a cell beside the middle of its own.
            let across_m = ((row as f64 + 0.5) * CELL_M - point[1]).abs() - CELL_M / 2.0;
            if best.is_some_and(|least| across_m > 0.0 && across_m * across_m > least) {
                continue;
            }
            for wall_point in self.found.cells().row(row, column - reach..column + reach + 1) {
                let Some(at) = self.found.at(*wall_point) else { continue };
                let squared = squared_distance(point, at);
                if squared <= MAX_MATCH_M * MAX_MATCH_M && best.is_none_or(|least| squared < least) {
                    best = Some(squared);
                }
            }
        }
        best
    }
}

/// True for each cell that a corner is near.
fn near_corners(raster: &Raster, corners: &[Corner]) -> Vec<bool> {
    let mut is_near = vec![false; raster.cells.len()];
    let reach = (NEAR_CORNER_M / CELL_M).ceil() as i64;
    for corner in corners {
        let [column, row] = corner.at.map(|c| (c / CELL_M).floor() as i64);
        for row in (row - reach).max(0)..(row + reach + 1).min(raster.height as i64) {
            for column in (column - reach).max(0)..(column + reach + 1).min(raster.width as i64) {
                let index = row as usize * raster.width + column as usize;
                is_near[index] |= squared_distance(raster.middle(index), corner.at) <= NEAR_CORNER_M * NEAR_CORNER_M;
            }
        }
    }
    is_near
}

fn squared_distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    let d = [a[0] - b[0], a[1] - b[1]];
    d[0] * d[0] + d[1] * d[1]
}

/// The mean of the free cells.
fn centre(raster: &Raster) -> [f64; 2] {
    // So many that the sum of their columns is no large number.
    const BLOCK: usize = 4096;
    let (mut n, mut sum) = (0usize, [0usize; 2]);
    for (row, cells) in raster.cells.chunks_exact(raster.width.max(1)).enumerate() {
        for (block, cells) in cells.chunks(BLOCK).enumerate() {
            let free = cells.iter().zip(0u32..).map(|(cell, k)| if *cell == Cell::Free { [1, k] } else { [0; 2] });
            let [n_here, columns] = free.fold([0u32; 2], |sum, of_cell| [sum[0] + of_cell[0], sum[1] + of_cell[1]]);
            let n_here = n_here as usize;
            sum = [sum[0] + n_here * block * BLOCK + columns as usize, sum[1] + n_here * row];
            n += n_here;
        }
    }
    if n == 0 { [0.0; 2] } else { sum.map(|s| (s as f64 / n as f64 + 0.5) * CELL_M) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn a_place_is_near_a_corner_within_the_distance_and_in_the_map() {
        // A room with a pillar in its middle.
        let is_wall = |k: usize| {
            let [x, y] = [k % 60, k / 60];
            !(5..55).contains(&x) || !(5..35).contains(&y) || ((28..32).contains(&x) && (18..22).contains(&y))
        };
        let cells: Vec<Cell> = (0..60 * 40).map(|k| if is_wall(k) { Cell::Occupied } else { Cell::Free }).collect();
        let features = Features::of(Raster::of(&cells, 60, CELL_M), Surfaces { depth_m: 0.0, are_whole: false });
        assert!(!features.corners().is_empty());
        for index in 0..cells.len() {
            let middle = features.raster.middle(index);
            let is_near = |corner: &Corner| squared_distance(corner.at, middle) <= NEAR_CORNER_M * NEAR_CORNER_M;
            assert_eq!(features.is_near_corner(middle), features.corners().iter().any(is_near), "{middle:?}");
        }
        assert!(![[-0.1, 0.1], [0.1, -0.1], [3.1, 0.1], [0.1, 2.1]].into_iter().any(|at| features.is_near_corner(at)));
    }

    proptest! {
        #[test]
        fn a_scan_finds_the_nearest_face_within_reach_and_none_beyond(
            walls in prop::collection::vec(0usize..60 * 40, 0..60),
            x in -1.0..4.0f64,
            y in -1.0..3.0f64,
        ) {
            let mut cells = vec![Cell::Free; 60 * 40];
            walls.iter().for_each(|wall| cells[*wall] = Cell::Occupied);
            let features = Features::of(Raster::of(&cells, 60, CELL_M), Surfaces { depth_m: 0.025, are_whole: false });
            let far = |wall_point: &WallPoint| (x - wall_point.at[0]).powi(2) + (y - wall_point.at[1]).powi(2);
            let nearest = features.wall_points().iter().map(far).min_by(f64::total_cmp);
            // A wall point lies in its cell or at most half a cell beside its middle.
            let within = nearest.filter(|squared| *squared <= MAX_MATCH_M * MAX_MATCH_M);
            prop_assert_eq!(features.nearest_by_scan([x, y]), within);
        }
    }
}
