//! Wall points: boundary points of occupied cells with normals into free space.

use crate::image::openness;
use crate::occupied_runs::{OccupiedRun, occupied_runs};
use crate::random_generator::RandomGenerator;
use crate::wall_point_cells::WallPointCells;
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
const TURN_RAD: f64 = std::f64::consts::TAU / N_LINE_DIRECTIONS as f64;

/// How a map shows surfaces.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Surfaces {
    /// How far a surface lies behind the border of the cell that shows it, on average.
    pub(crate) depth_m: f64,
    /// True if walls are occupied through and through, so that they have a surface also where nothing is known before it: a
    /// robot may stand on floor that the model does not have, or outside. What a robot's map has behind a surface is hidden.
    pub(crate) are_whole: bool,
}

/// The wall points of a map as the slopes at their cells show them; [`Self::straight`] takes the direction of the wall instead.
pub(crate) struct WallPoints {
    /// In the order of their cells.
    sloped: Vec<WallPoint>,
    cells: WallPointCells,
    /// Steps between cells to those around, nearest first.
    steps_around: Vec<isize>,
    n_around: usize,
    /// Unit vectors of the directions of lines, from half a turn back to half a turn on.
    line_directions: Vec<[f64; 2]>,
}

impl WallPoints {
    pub(crate) fn of(raster: &Raster, surfaces: Surfaces) -> Self {
        let openness = openness(raster).blurred(SIGMA);
        let (reach, n_around) = surroundings(raster.coarseness);
        let mut cells = WallPointCells::new(raster.width, raster.height, reach as usize);
        let mut sloped = Vec::new();
        let is_before = |cell: Cell| cell == Cell::Free || (surfaces.are_whole && cell == Cell::Unknown);
        for OccupiedRun { row, columns, diagonal_cells } in occupied_runs(raster) {
            // Furniture has little weight.
            let weight = (diagonal_cells * CELL_M - 0.5).clamp(0.15, 1.0);
            for column in columns {
                let index = row * raster.width + column;
                if !openness.is_inside(index) {
                    continue;
                }
                let slope = openness.slope(index);
                let steep = (slope[0] * slope[0] + slope[1] * slope[1]).sqrt();
                if steep > MIN_SLOPE && around(index, raster.width).iter().any(|&n| is_before(raster.cells[n])) {
                    let normal = slope.map(|s| f64::from(s / steep));
                    let middle = raster.middle(index);
                    let at = [0, 1].map(|k| middle[k] + normal[k] * (CELL_M / 2.0 - surfaces.depth_m));
                    cells.push([column, row]);
                    sloped.push(WallPoint { at, normal, weight, line: 0 });
                }
            }
        }
        let steps_around = nearest_first(reach).into_iter().map(|step| cells.step(step)).collect();
        let turned = |turns: i64| {
            let (sin, cos) = libm::sincos(turns as f64 * TURN_RAD);
            [cos, sin]
        };
        let line_directions = (-N_LINE_DIRECTIONS / 2..=N_LINE_DIRECTIONS / 2).map(turned).collect();
        Self { sloped, cells, steps_around, n_around, line_directions }
    }

    /// How many there are.
    pub(crate) fn len(&self) -> usize {
        self.sloped.len()
    }

    /// Where each lies: straight ones lie where sloped ones do.
    pub(crate) fn at(&self, wall_point: u32) -> Option<[f64; 2]> {
        Some(self.sloped.get(wall_point as usize)?.at)
    }

    /// The wall point of each cell.
    pub(crate) fn cells(&self) -> &WallPointCells {
        &self.cells
    }

    /// All of them with the direction of their wall, where there is a wall.
    pub(crate) fn all_straight(&self) -> Vec<WallPoint> {
        (0..self.sloped.len()).map(|k| self.straight(k)).collect()
    }

    /// One of them with the direction of its wall, where there is a wall.
    fn straight(&self, k: usize) -> WallPoint {
        let mut wall_point = self.sloped[k];
        match self.wall_normal(k) {
            Some(normal) => wall_point.normal = normal,
            None => wall_point.weight *= CROOKED_WEIGHT,
        }
        wall_point.line = self.line(&wall_point);
        wall_point
    }

    /// At most `n` of them, drawn by weight, with the direction of their walls: those that [`RandomGenerator::draw`] takes, but only
    /// few walls are looked at.
    pub(crate) fn drawn(&self, random: &mut RandomGenerator, n: usize) -> Vec<WallPoint> {
        let at_most = self.sloped.iter().map(|wall_point| wall_point.weight);
        let drawn = random.draw_with_bounds(at_most, |k| self.straight(k as usize).weight, n);
        drawn.into_iter().map(|k| self.straight(k as usize)).collect()
    }

    /// The normal of the line through the wall points around one; `None` if they make no line.
    fn wall_normal(&self, k: usize) -> Option<[f64; 2]> {
        let own = self.sloped[k];
        let (mut n, mut sum, mut squares) = (0usize, Vector2::zeros(), Matrix2::zeros());
        for step in &self.steps_around {
            let Some(other) = self.sloped.get(self.cells.beside(k, *step) as usize) else { continue };
            if other.normal[0] * own.normal[0] + other.normal[1] * own.normal[1] > SAME_DIRECTION {
                let d = Vector2::from(other.at) - Vector2::from(own.at);
                sum += d;
                squares += d * d.transpose();
                n += 1;
                if n == self.n_around {
                    break;
                }
            }
        }
        if n < 3 {
            return None;
        }
        let scatter = squares - sum * sum.transpose() / n as f64;
        let (mean, half) = (scatter.trace() / 2.0, (scatter.m11 - scatter.m22) / 2.0);
        let apart = (half * half + scatter.m12 * scatter.m12).sqrt();
        let [across, along] = [mean - apart, mean + apart];
        let linear = 1.0 - (6.0 * across / along).min(1.0);
        if linear.is_nan() || linear <= MIN_LINEAR {
            return None;
        }
        // The direction of the larger one: of a wall along y an eigenvector would lose it in a difference of like numbers.
        let (sin, cos) = libm::sincos(libm::atan2(2.0 * scatter.m12, scatter.m11 - scatter.m22) / 2.0);
        let out = -sin * own.normal[0] + cos * own.normal[1];
        Some(if out < 0.0 { [sin, -cos] } else { [-sin, cos] })
    }

    /// The number of the line that a wall point lies on.
    fn line(&self, wall_point: &WallPoint) -> u32 {
        let [x, y] = wall_point.normal;
        let direction = (libm::atan2(y, x) / TURN_RAD).round() as i64;
        let [cos, sin] = self.line_directions[(direction + N_LINE_DIRECTIONS / 2) as usize];
        let offset = ((wall_point.at[0] * cos + wall_point.at[1] * sin) / LINE_M).round() as i64;
        (offset * N_LINE_DIRECTIONS + direction.rem_euclid(N_LINE_DIRECTIONS)) as u32
    }
}

/// At most `n` wall points, each as likely.
pub(crate) fn drawn_evenly(wall_points: &[WallPoint], n: usize, random: &mut RandomGenerator) -> Vec<WallPoint> {
    random.draw_evenly(wall_points.len(), n).into_iter().map(|k| wall_points[k as usize]).collect()
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
