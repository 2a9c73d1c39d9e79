//! The building as it is: a fine raster of what stops a beam, made from a model map.

use crate::plane::{Rectangle, Vector};
use crate::wall_grid::WallGrid;

/// Side of a cell of the world.
pub(crate) const CELL_M: f64 = 0.025;
/// Surroundings of the model map that belong to the world.
const MARGIN_M: f64 = 6.0;

/// What fills a cell of the world.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub(crate) enum Material {
    Empty,
    /// A wall where the model has it.
    Wall,
    /// A wall that the model does not have, or has elsewhere.
    OtherWall,
    /// Furniture, door leaves, people who stand.
    Furniture,
    Glass,
}

/// Cells of [`CELL_M`], row-major from the lower left corner; points are in the frame of the model map.
#[derive(Debug, Clone)]
pub(crate) struct World {
    pub(crate) width: usize,
    pub(crate) height: usize,
    pub(crate) origin: Vector,
    pub(crate) cells: Vec<Material>,
    /// Where furniture may stand: floor, but not before doors.
    pub(crate) can_be_furnished: Vec<bool>,
    /// Floor of the building.
    pub(crate) floor: Vec<bool>,
}

impl World {
    /// As the model has it.
    pub(crate) fn of(grid: &WallGrid) -> Self {
        let margin = (MARGIN_M / CELL_M) as usize;
        let scale = grid.resolution_m / CELL_M;
        let cells_of = |n: usize| (n as f64 * scale).round() as usize;
        let (inner_width, inner_height) = (cells_of(grid.width), cells_of(grid.height));
        let (width, height) = (inner_width + 2 * margin, inner_height + 2 * margin);
        let mut world = Self {
            width,
            height,
            origin: grid.origin.map(|c| c - MARGIN_M),
            cells: vec![Material::Empty; width * height],
            can_be_furnished: vec![false; width * height],
            floor: vec![false; width * height],
        };
        let columns: Vec<usize> =
            (0..inner_width).map(|x| (((x as f64 + 0.5) / scale) as usize).min(grid.width - 1)).collect();
        for y in 0..inner_height {
            let row = (((y as f64 + 0.5) / scale) as usize).min(grid.height - 1) * grid.width;
            let first = (y + margin) * width + margin;
            for (x, column) in columns.iter().enumerate() {
                if grid.walls[row + column] {
                    world.cells[first + x] = Material::Wall;
                }
                world.floor[first + x] = grid.floor[row + column];
            }
        }
        world.can_be_furnished.copy_from_slice(&world.floor);
        world
    }

    /// The index of the cell at a point; `None` outside.
    pub(crate) fn index_at(&self, p: Vector) -> Option<usize> {
        let [x, y] = [0, 1].map(|k| ((p[k] - self.origin[k]) / CELL_M).floor());
        let is_inside = 0.0 <= x && x < self.width as f64 && 0.0 <= y && y < self.height as f64;
        is_inside.then(|| y as usize * self.width + x as usize)
    }

    /// The middle of a cell.
    pub(crate) fn middle(&self, index: usize) -> Vector {
        let [x, y] = [index % self.width, index / self.width].map(|c| (c as f64 + 0.5) * CELL_M);
        [self.origin[0] + x, self.origin[1] + y]
    }

    /// Indices of the cells whose middles a rectangle holds.
    pub(crate) fn cells_in(&self, rectangle: &Rectangle) -> impl Iterator<Item = usize> + use<> {
        let (width, origin, rectangle) = (self.width, self.origin, *rectangle);
        let limits = [self.width, self.height];
        let [low, high] = rectangle.bounds();
        let first = [0, 1].map(|k| ((low[k] - origin[k]) / CELL_M).floor().clamp(0.0, limits[k] as f64) as usize);
        let end = [0, 1].map(|k| ((high[k] - origin[k]) / CELL_M).ceil().clamp(0.0, limits[k] as f64) as usize);
        (first[1]..end[1]).flat_map(move |y| (first[0]..end[0]).map(move |x| (x, y))).filter_map(move |(x, y)| {
            let p = [origin[0] + (x as f64 + 0.5) * CELL_M, origin[1] + (y as f64 + 0.5) * CELL_M];
            rectangle.contains(p).then_some(y * width + x)
        })
    }

    /// Fills empty cells of a rectangle.
    pub(crate) fn fill(&mut self, rectangle: &Rectangle, material: Material) {
        for index in self.cells_in(rectangle) {
            if self.cells[index] == Material::Empty {
                self.cells[index] = material;
            }
        }
    }

    /// Fills empty cells of a disc.
    pub(crate) fn fill_disc(&mut self, centre: Vector, radius_m: f64, material: Material) {
        let square = Rectangle::new(centre, [1.0, 0.0], 2.0 * radius_m, 2.0 * radius_m);
        for index in self.cells_in(&square) {
            let p = self.middle(index);
            if crate::plane::distance(p, centre) <= radius_m && self.cells[index] == Material::Empty {
                self.cells[index] = material;
            }
        }
    }

    /// True if furniture fits there.
    pub(crate) fn has_room_for(&self, rectangle: &Rectangle) -> bool {
        let mut n = 0;
        let fits = self.cells_in(rectangle).all(|index| {
            n += 1;
            self.can_be_furnished[index] && self.cells[index] == Material::Empty
        });
        fits && n > 0
    }

    /// True if there is nothing but floor.
    pub(crate) fn is_open(&self, rectangle: &Rectangle) -> bool {
        self.cells_in(rectangle).all(|index| self.floor[index] && self.cells[index] == Material::Empty)
    }

    /// Number of cells from each cell to the nearest that is not empty, in the larger of both axes; at most 255.
    pub(crate) fn clearance(&self) -> Vec<u8> {
        let mut out: Vec<u8> = self.cells.iter().map(|&c| if c == Material::Empty { 255 } else { 0 }).collect();
        let w = self.width;
        // Every cell learns from the four before it, row by row upwards and to the right; then back from the four after it.
        for row in 0..self.height {
            let (before, rest) = out.split_at_mut(row * w);
            if row > 0 {
                relax(&mut rest[..w], &before[(row - 1) * w..]);
            }
            (1..w).for_each(|k| rest[k] = rest[k].min(rest[k - 1].saturating_add(1)));
        }
        for row in (0..self.height).rev() {
            let (before, rest) = out.split_at_mut((row + 1) * w);
            let cells = &mut before[row * w..];
            if !rest.is_empty() {
                relax(cells, &rest[..w]);
            }
            (0..w - 1).rev().for_each(|k| cells[k] = cells[k].min(cells[k + 1].saturating_add(1)));
        }
        out
    }
}

/// Lets a row know the distances of the row beside it.
fn relax(row: &mut [u8], beside: &[u8]) {
    let last = row.len() - 1;
    row[0] = row[0].min(beside[0].min(beside[last.min(1)]).saturating_add(1));
    row[last] = row[last].min(beside[last].min(beside[last.saturating_sub(1)]).saturating_add(1));
    for (cell, three) in row[1..].iter_mut().zip(beside.windows(3)) {
        *cell = (*cell).min(three[0].min(three[1]).min(three[2]).saturating_add(1));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clearance_is_the_chessboard_distance() {
        let (width, height) = (23, 17);
        let n = width * height;
        let mut world = World {
            width,
            height,
            origin: [0.0; 2],
            cells: vec![Material::Empty; n],
            can_be_furnished: vec![true; n],
            floor: vec![true; n],
        };
        let marked = [5 * width + 3, 12 * width + 20, 16 * width];
        marked.iter().for_each(|&k| world.cells[k] = Material::Wall);
        for (index, got) in world.clearance().into_iter().enumerate() {
            let far = |k: &usize| (k % width).abs_diff(index % width).max((k / width).abs_diff(index / width));
            assert_eq!(usize::from(got), marked.iter().map(far).min().unwrap());
        }
    }
}
