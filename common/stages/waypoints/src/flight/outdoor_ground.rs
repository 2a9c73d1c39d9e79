//! Heights of the ground outdoors by cell: what its map shows, and faces of terrain and roads that are too steep for the robot of the map.

use crate::input::MissionPlanInput;
use geometry::MeshView;
use messages::{FloorKind, Grid, NO_HEIGHT};

/// The ground that a storey shows, by cell.
pub(crate) struct CellGround<'a> {
    /// In tenths of a millimetre, [`NO_HEIGHT`] where there is none; empty for a level storey.
    pub(crate) heights: &'a [i32],
    pub(crate) grid: &'a Grid<'a>,
}

impl CellGround<'_> {
    pub(crate) fn at(&self, cell: usize) -> Option<i32> {
        match self.heights.get(cell) {
            Some(&height) => Some(height).filter(|&height| height != NO_HEIGHT),
            None => self.grid.height_tenths(cell),
        }
    }
}

/// Heights by cell of the grids of the ground outdoors, of which a site has one at most.
pub(crate) struct OutdoorGround {
    /// By grid; empty for levels of a building.
    heights: Vec<Vec<i32>>,
}

impl OutdoorGround {
    /// Of terrain and roads that stand at a schedule state.
    pub(crate) fn of(input: &MissionPlanInput<'_>) -> Self {
        let heights = |at: usize| {
            if input.grids.head(at).floor != FloorKind::Ground {
                return Vec::new();
            }
            input.grids.with(at, |grid| heights_of(input, grid))
        };
        Self { heights: (0..input.grids.count()).map(heights).collect() }
    }

    /// The ground of a grid.
    pub(crate) fn of_grid<'a>(&'a self, at: usize, grid: &'a Grid<'a>) -> CellGround<'a> {
        let heights = if self.heights[at].is_empty() { grid.elevation } else { &self.heights[at] };
        CellGround { heights, grid }
    }
}

fn heights_of(input: &MissionPlanInput<'_>, grid: &Grid<'_>) -> Vec<i32> {
    let MissionPlanInput { site, schedule_state, .. } = *input;
    let mut highest = vec![NO_HEIGHT; grid.spec().n_cells()];
    for (k, element) in site.elements.iter().enumerate() {
        if element.ground.get().is_outdoors() && schedule_state.effective(k).is_obstacle() {
            site.element_meshes(element).for_each(|mesh| raise(&mut highest, grid, mesh));
        }
    }
    for terrain in site.terrains.iter().filter(|terrain| terrain.ground.get().is_outdoors()) {
        site.terrain_meshes(terrain).for_each(|mesh| raise(&mut highest, grid, mesh));
    }
    // The map tells which of several surfaces is the ground.
    for (cell, height) in highest.iter_mut().enumerate() {
        *height = grid.height_tenths(cell).unwrap_or(*height);
    }
    highest
}

/// Raises cells to the faces over their middle.
fn raise(highest: &mut [i32], grid: &Grid<'_>, mesh: MeshView<'_>) {
    let spec = grid.spec();
    let cell = i64::from(spec.cell_tenths);
    // Twice the coordinates, so that the middle of a cell is a whole number.
    let middle = |first: i32, k: i64| (2 * (i64::from(first) + k) + 1) * cell;
    for triangle in mesh.corners() {
        let [a, b, c] = triangle.map(|p| p.map(i64::from));
        let area = turn(&a, &b, [2 * c[0], 2 * c[1]]);
        if area == 0 {
            continue;
        }
        let range = |axis: usize, n: u32| {
            let all = [a[axis], b[axis], c[axis]];
            let cell_at = |z: i64| z.div_euclid(cell) - i64::from(spec.first_cell[axis]);
            let [low, high] = [all.iter().min(), all.iter().max()].map(|z| cell_at(z.copied().unwrap_or(0)));
            low.max(0)..(high + 1).min(i64::from(n))
        };
        for row in range(1, spec.height) {
            for column in range(0, spec.width) {
                let at = [middle(spec.first_cell[0], column), middle(spec.first_cell[1], row)];
                let shares = [turn(&b, &c, at), turn(&c, &a, at), turn(&a, &b, at)];
                if shares.iter().any(|share| share.signum() * area.signum() < 0) {
                    continue;
                }
                let weighted: f64 = [a, b, c].iter().zip(shares).map(|(p, share)| p[2] as f64 * share as f64).sum();
                let height = (weighted / area as f64).round() as i32;
                let of_cell = &mut highest[row as usize * spec.width as usize + column as usize];
                *of_cell = (*of_cell).max(height);
            }
        }
    }
}

/// Twice twice the signed area of two corners and a place that is given by twice its coordinates.
fn turn(a: &[i64; 3], b: &[i64; 3], at: [i64; 2]) -> i128 {
    let off = |k: usize| (i128::from(b[k] - a[k]), i128::from(at[k] - 2 * a[k]));
    let ((ux, vx), (uy, vy)) = (off(0), off(1));
    ux * vy - uy * vx
}
