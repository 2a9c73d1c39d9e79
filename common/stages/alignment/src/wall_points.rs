//! Wall points: boundary points of occupied cells with normals into free space.

use crate::image::openness;
use nalgebra::{Matrix2, Vector2};
use occupancy::{CELL_M, Cell, Raster};

/// A boundary point of an occupied cell with a normal into free space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct WallPoint {
    /// Metres from the map's lower left corner.
    pub(crate) at: [f64; 2],
    /// Unit normal into the free space.
    pub(crate) normal: [f64; 2],
    /// Weight: low for small objects and unclear directions.
    pub(crate) weight: f64,
    /// The same of wall points that look in about the same direction from about the same line.
    pub(crate) line: u32,
}

/// No wall point.
pub(crate) const NONE: u32 = u32::MAX;

/// Wall points of a map, and the wall point of each cell.
pub(crate) struct WallPoints {
    pub(crate) all: Vec<WallPoint>,
    pub(crate) of_cell: Vec<u32>,
}

/// Of the blur before slopes are taken, in cells.
const SIGMA: f64 = 1.6;
const MIN_SLOPE: f32 = 0.04;
/// A wall's direction is that of so many wall points at most, within so many cells; of more in maps of coarser cells, whose
/// steps are longer.
const N_AROUND: usize = 17;
const AROUND: i64 = 10;
/// Cells of half a metre: the steps of larger ones are longer than walls, and what is looked at grows with their square.
const COARSEST: f64 = 10.0;
const SAME_DIRECTION: f64 = 0.6;
const MIN_LINEAR: f64 = 0.3;
const CROOKED_WEIGHT: f64 = 0.4;

/// Directions and distances between which lines are not told apart.
const N_LINE_DIRECTIONS: i64 = 36;
const LINE_M: f64 = 0.2;

/// The number of the line that a wall point lies on.
fn line(wall_point: &WallPoint) -> u32 {
    let [x, y] = wall_point.normal;
    let turn_rad = std::f64::consts::TAU / N_LINE_DIRECTIONS as f64;
    let direction = (libm::atan2(y, x) / turn_rad).round() as i64;
    let (sin, cos) = libm::sincos(direction as f64 * turn_rad);
    let offset = ((wall_point.at[0] * cos + wall_point.at[1] * sin) / LINE_M).round() as i64;
    (offset * N_LINE_DIRECTIONS + direction.rem_euclid(N_LINE_DIRECTIONS)) as u32
}

/// How a map shows surfaces.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Surfaces {
    /// How far a surface lies behind the border of the cell that shows it, on average.
    pub(crate) depth_m: f64,
    /// True if walls are occupied through and through, so that they have a surface also where nothing is known before it: a
    /// robot may stand on floor that the model does not have, or outside. What a robot's map has behind a surface is hidden.
    pub(crate) are_whole: bool,
}

impl WallPoints {
    pub(crate) fn of(raster: &Raster, surfaces: Surfaces) -> Self {
        let openness = openness(raster).blurred(SIGMA);
        let sizes = blob_weights(raster);
        let mut wall_points = Self { all: Vec::new(), of_cell: vec![NONE; raster.cells.len()] };
        let is_before = |cell: Cell| cell == Cell::Free || (surfaces.are_whole && cell == Cell::Unknown);
        for (index, cell) in raster.cells.iter().enumerate() {
            if *cell != Cell::Occupied || !openness.is_inside(index) {
                continue;
            }
            let slope = openness.slope(index);
            let steep = (slope[0] * slope[0] + slope[1] * slope[1]).sqrt();
            if steep > MIN_SLOPE && around(index, raster.width).iter().any(|&n| is_before(raster.cells[n])) {
                let normal = slope.map(|s| f64::from(s / steep));
                let middle = raster.middle(index);
                let at = [0, 1].map(|k| middle[k] + normal[k] * (CELL_M / 2.0 - surfaces.depth_m));
                wall_points.of_cell[index] = wall_points.all.len() as u32;
                wall_points.all.push(WallPoint { at, normal, weight: sizes[index], line: 0 });
            }
        }
        wall_points.straighten(raster);
        for wall_point in &mut wall_points.all {
            wall_point.line = line(wall_point);
        }
        wall_points
    }

    /// Takes the direction of the wall for that of the slope, where there is a wall.
    fn straighten(&mut self, raster: &Raster) {
        let (reach, n_around) = surroundings(raster.coarseness);
        let nearest_first = nearest_first(reach);
        let straight: Vec<(u32, Option<[f64; 2]>)> = (0..self.of_cell.len())
            .filter(|&index| self.of_cell[index] != NONE)
            .map(|index| (self.of_cell[index], self.wall_normal(raster, index, &nearest_first, n_around)))
            .collect();
        for (wall_point, normal) in straight {
            let wall_point = &mut self.all[wall_point as usize];
            match normal {
                Some(normal) => wall_point.normal = normal,
                None => wall_point.weight *= CROOKED_WEIGHT,
            }
        }
    }

    /// The normal of the line through the wall points around a cell; `None` if they make no line.
    fn wall_normal(
        &self,
        raster: &Raster,
        index: usize,
        nearest_first: &[[i64; 2]],
        n_around: usize,
    ) -> Option<[f64; 2]> {
        let (column, row) = ((index % raster.width) as i64, (index / raster.width) as i64);
        let own = self.all[self.of_cell[index] as usize];
        let (mut n, mut sum, mut squares) = (0usize, Vector2::zeros(), Matrix2::zeros());
        for [dx, dy] in nearest_first {
            let (x, y) = (column + dx, row + dy);
            if x < 0 || y < 0 || x >= raster.width as i64 || y >= raster.height as i64 {
                continue;
            }
            let wall_point = self.of_cell[y as usize * raster.width + x as usize];
            if wall_point == NONE {
                continue;
            }
            let wall_point = &self.all[wall_point as usize];
            if wall_point.normal[0] * own.normal[0] + wall_point.normal[1] * own.normal[1] > SAME_DIRECTION {
                let d = Vector2::from(wall_point.at) - Vector2::from(own.at);
                sum += d;
                squares += d * d.transpose();
                n += 1;
                if n == n_around {
                    break;
                }
            }
        }
        if n < 3 {
            return None;
        }
        let scatter = squares - sum * sum.transpose() / n as f64;
        let across_and_along = scatter.symmetric_eigenvalues();
        let linear = 1.0 - (6.0 * across_and_along.min() / across_and_along.max()).min(1.0);
        if linear.is_nan() || linear <= MIN_LINEAR {
            return None;
        }
        // The direction of the larger one: of a wall along y an eigenvector would lose it in a difference of like numbers.
        let (sin, cos) = libm::sincos(libm::atan2(2.0 * scatter.m12, scatter.m11 - scatter.m22) / 2.0);
        let out = -sin * own.normal[0] + cos * own.normal[1];
        Some(if out < 0.0 { [sin, -cos] } else { [-sin, cos] })
    }
}

/// Within how many cells a wall's direction is looked for, and of how many wall points it is made.
fn surroundings(coarseness: f64) -> (i64, usize) {
    let coarseness = coarseness.min(COARSEST);
    (libm::round(AROUND as f64 * coarseness) as i64, (N_AROUND as f64 * coarseness) as usize)
}

/// Steps to the cells around, nearest first.
fn nearest_first(reach: i64) -> Vec<[i64; 2]> {
    let mut steps: Vec<[i64; 2]> = (-reach..=reach).flat_map(|y| (-reach..=reach).map(move |x| [x, y])).collect();
    let far = |s: &[i64; 2]| s[0] * s[0] + s[1] * s[1];
    steps.retain(|s| far(s) <= reach * reach);
    steps.sort_by_key(|s| (far(s), s[1], s[0]));
    steps
}

fn around(index: usize, width: usize) -> [usize; 8] {
    let (up, down) = (index + width, index - width);
    [index + 1, up + 1, up, up - 1, index - 1, down - 1, down, down + 1]
}

/// Weight of each occupied cell by the diagonal of its connected component, so that furniture has little weight.
fn blob_weights(raster: &Raster) -> Vec<f64> {
    let (width, height) = (raster.width as i64, raster.height as i64);
    let mut weights = vec![0.0; raster.cells.len()];
    let mut blob: Vec<usize> = Vec::new();
    for start in 0..raster.cells.len() {
        if raster.cells[start] != Cell::Occupied || weights[start] != 0.0 {
            continue;
        }
        blob.clear();
        blob.push(start);
        weights[start] = 1.0;
        let (mut lo, mut hi) = ([i64::MAX; 2], [i64::MIN; 2]);
        let mut next = 0;
        while next < blob.len() {
            let at = [(blob[next] % raster.width) as i64, (blob[next] / raster.width) as i64];
            next += 1;
            for k in 0..2 {
                (lo[k], hi[k]) = (lo[k].min(at[k]), hi[k].max(at[k] + 1));
            }
            for (dx, dy) in (-1..=1).flat_map(|y| (-1..=1).map(move |x| (x, y))) {
                let (x, y) = (at[0] + dx, at[1] + dy);
                if x >= 0 && y >= 0 && x < width && y < height {
                    let index = (y * width + x) as usize;
                    if raster.cells[index] == Cell::Occupied && weights[index] == 0.0 {
                        weights[index] = 1.0;
                        blob.push(index);
                    }
                }
            }
        }
        let diagonal_m = libm::hypot((hi[0] - lo[0]) as f64, (hi[1] - lo[1]) as f64) * CELL_M;
        let weight = (diagonal_m - 0.5).clamp(0.15, 1.0);
        blob.iter().for_each(|&cell| weights[cell] = weight);
    }
    weights
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_looked_at_around_a_face_grows_with_the_cells_of_the_map_and_ends() {
        assert_eq!(surroundings(1.0), (10, 17));
        assert_eq!(surroundings(5.0), (50, 85));
        // A map of one cell of 10 m would otherwise sort millions of steps, and look at them from every face.
        assert_eq!(surroundings(200.0), surroundings(COARSEST));
        assert!(nearest_first(surroundings(200.0).0).len() < 32_000);
    }
}
