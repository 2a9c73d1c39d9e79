//! Features of a map for alignment, computed once per map.

use crate::corners::{Corner, corners};
use crate::rotations::{N_BINS, directions};
use crate::thresholds::MAX_MATCH_M;
use crate::wall_points::{NONE, Surfaces, WallPoint, WallPoints};
use grid::nearest_marked;
use occupancy::{CELL_M, Cell, Raster};
use std::sync::OnceLock;

/// A map with its features. Points are metres from the map's lower left corner.
pub(crate) struct Features {
    pub(crate) raster: Raster,
    pub(crate) wall_points: Vec<WallPoint>,
    /// Mean of the free cells, at which errors of a pose are given.
    pub(crate) centre: [f64; 2],
    /// The wall point of each cell.
    of_cell: Vec<u32>,
    // Tracking needs only wall points; the rest is computed on first use.
    corners: OnceLock<Vec<Corner>>,
    directions: OnceLock<Box<[f64; N_BINS]>>,
    nearest: OnceLock<Nearest>,
}

/// The nearest wall point of each cell, with a margin around the map.
struct Nearest {
    wall_points: Vec<u32>,
    width: usize,
}

/// Margin around the map, in cells: the maximum distance of a match.
const MARGIN: usize = 40;

impl Features {
    pub(crate) fn of(raster: Raster, surfaces: Surfaces) -> Self {
        let WallPoints { all, of_cell } = WallPoints::of(&raster, surfaces);
        let centre = centre(&raster);
        let (corners, directions, nearest) = (OnceLock::new(), OnceLock::new(), OnceLock::new());
        Self { raster, wall_points: all, centre, of_cell, corners, directions, nearest }
    }

    /// Length of the map's walls.
    pub(crate) fn walls_m(&self) -> f64 {
        self.wall_points.len() as f64 * CELL_M
    }

    /// Corners of the map, computed on first use.
    pub(crate) fn corners(&self) -> &[Corner] {
        self.corners.get_or_init(|| corners(&self.raster))
    }

    /// Histogram of the directions of wall points, computed on first use.
    pub(crate) fn directions(&self) -> &[f64; N_BINS] {
        self.directions.get_or_init(|| Box::new(directions(&self.wall_points)))
    }

    /// The wall point nearest to the middle of a point's cell, and the squared distance to the point.
    pub(crate) fn nearest(&self, [x, y]: [f64; 2]) -> Option<(&WallPoint, f64)> {
        let nearest = self.nearest.get_or_init(|| Nearest::of(&self.of_cell, &self.raster));
        let (column, row) = (x / CELL_M + MARGIN as f64, y / CELL_M + MARGIN as f64);
        if column < 0.0 || row < 0.0 || column >= nearest.width as f64 {
            return None;
        }
        let wall_point = *nearest.wall_points.get(row as usize * nearest.width + column as usize)?;
        let wall_point = self.wall_points.get(wall_point as usize)?;
        let d = [x - wall_point.at[0], y - wall_point.at[1]];
        Some((wall_point, d[0] * d[0] + d[1] * d[1]))
    }
}

impl Features {
    /// The nearest wall point within [`MAX_MATCH_M`], and the squared distance, without looking at the whole map first: for
    /// few points.
    pub(crate) fn nearest_by_scan(&self, [x, y]: [f64; 2]) -> Option<(&WallPoint, f64)> {
        let reach = (MAX_MATCH_M / CELL_M) as i64 + 1;
        let (column, row) = ((x / CELL_M).floor() as i64, (y / CELL_M).floor() as i64);
        let columns =
            (column - reach).max(0) as usize..(column + reach + 1).clamp(0, self.raster.width as i64) as usize;
        let rows = (row - reach).max(0) as usize..(row + reach + 1).clamp(0, self.raster.height as i64) as usize;
        let mut best: Option<(&WallPoint, f64)> = None;
        for row in rows {
            let line = row * self.raster.width;
            for cell in self.of_cell.get(line + columns.start..line + columns.end).unwrap_or_default() {
                let Some(wall_point) = self.wall_points.get(*cell as usize) else { continue };
                let d = [x - wall_point.at[0], y - wall_point.at[1]];
                let squared = d[0] * d[0] + d[1] * d[1];
                if squared <= MAX_MATCH_M * MAX_MATCH_M && best.is_none_or(|(_, least)| squared < least) {
                    best = Some((wall_point, squared));
                }
            }
        }
        best
    }
}

impl Nearest {
    fn of(of_cell: &[u32], raster: &Raster) -> Self {
        let width = raster.width + 2 * MARGIN;
        let mut with_margin = vec![NONE; width * (raster.height + 2 * MARGIN)];
        for (row, line) in of_cell.chunks_exact(raster.width.max(1)).enumerate() {
            let from = (row + MARGIN) * width + MARGIN;
            with_margin[from..from + line.len()].copy_from_slice(line);
        }
        let marked: Vec<bool> = with_margin.iter().map(|f| *f != NONE).collect();
        let cells = nearest_marked(&marked, width);
        let wall_points =
            cells.into_iter().map(|cell| with_margin.get(cell as usize).copied().unwrap_or(NONE)).collect();
        Self { wall_points, width }
    }
}

/// The mean of the free cells.
fn centre(raster: &Raster) -> [f64; 2] {
    let (mut n, mut sum) = (0.0, [0.0; 2]);
    for (index, _) in raster.cells.iter().enumerate().filter(|(_, c)| **c == Cell::Free) {
        let middle = raster.middle(index);
        sum = [sum[0] + middle[0], sum[1] + middle[1]];
        n += 1.0;
    }
    if n == 0.0 { [0.0; 2] } else { sum.map(|s| s / n) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

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
            let nearest = features.wall_points.iter().map(far).min_by(f64::total_cmp);
            // A wall point lies in its cell or at most half a cell beside its middle.
            let within = nearest.filter(|squared| *squared <= MAX_MATCH_M * MAX_MATCH_M);
            prop_assert_eq!(features.nearest_by_scan([x, y]).map(|(_, squared)| squared), within);
        }
    }
}
