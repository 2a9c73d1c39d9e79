//! What is looked at in a map: made once for each, whatever it is compared with.

use crate::corners::{Corner, corners};
use crate::faces::{Face, Faces, NONE};
use crate::raster::{Cell, Raster};
use crate::rotations::{N_BINS, directions};
use crate::thresholds::CELL_M;
use grid::nearest_marked;

/// A map with its features. Points are metres from the map's lower left corner.
pub(crate) struct Features {
    pub(crate) raster: Raster,
    pub(crate) faces: Vec<Face>,
    pub(crate) corners: Vec<Corner>,
    /// How many faces look where.
    pub(crate) directions: [f64; N_BINS],
    /// The mean of the free cells: where errors of a pose are told.
    pub(crate) centre: [f64; 2],
    /// The nearest face of each cell, with a margin around the map.
    nearest: Vec<u32>,
    nearest_width: usize,
}

/// Around the map, in cells: as far as anything is matched.
const MARGIN: usize = 40;

impl Features {
    /// `depth_m` as for [`Faces::of`].
    pub(crate) fn of(raster: Raster, depth_m: f64) -> Self {
        let faces = Faces::of(&raster, depth_m);
        let nearest_width = raster.width + 2 * MARGIN;
        let mut of_cell = vec![NONE; nearest_width * (raster.height + 2 * MARGIN)];
        for (row, line) in faces.of_cell.chunks_exact(raster.width.max(1)).enumerate() {
            let from = (row + MARGIN) * nearest_width + MARGIN;
            of_cell[from..from + line.len()].copy_from_slice(line);
        }
        let marked: Vec<bool> = of_cell.iter().map(|f| *f != NONE).collect();
        let cells = nearest_marked(&marked, nearest_width);
        let nearest = cells.into_iter().map(|cell| of_cell.get(cell as usize).copied().unwrap_or(NONE)).collect();
        let (corners, centre) = (corners(&raster), centre(&raster));
        Self { directions: directions(&faces.all), faces: faces.all, corners, centre, raster, nearest, nearest_width }
    }

    /// The face nearest to the middle of a point's cell, and the squared distance to the point.
    pub(crate) fn nearest(&self, [x, y]: [f64; 2]) -> Option<(&Face, f64)> {
        let (column, row) = (x / CELL_M + MARGIN as f64, y / CELL_M + MARGIN as f64);
        if column < 0.0 || row < 0.0 || column >= self.nearest_width as f64 {
            return None;
        }
        let face = *self.nearest.get(row as usize * self.nearest_width + column as usize)?;
        let face = self.faces.get(face as usize)?;
        let d = [x - face.at[0], y - face.at[1]];
        Some((face, d[0] * d[0] + d[1] * d[1]))
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
