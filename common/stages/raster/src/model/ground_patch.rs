//! Patches of ground that is not level with the floor of the storey: what a robot drives on there, and what stands in its way above it.

use super::element_runs::ElementRuns;
use geometry::{MultiPolygon, Plane};
use grid::{CellRect, GridSpec, Run};

/// Faces of an element in one plane, that lead from the floor of the storey to other heights.
#[derive(Debug)]
pub(crate) struct GroundPatch {
    /// [`messages::NONE`] for terrain.
    pub(crate) element: u32,
    /// True for terrain and roads.
    pub(crate) is_outdoors: bool,
    /// True for a tread of a stair.
    pub(crate) is_tread: bool,
    /// Height by which ground beside it may be lower without a break: a step of the robot, on a stair a riser.
    pub(crate) climb: i32,
    pub(crate) plane: Plane,
    /// In plan.
    pub(crate) area: MultiPolygon,
    /// Cells that the area overlaps.
    pub(crate) cells: Vec<Run>,
    /// Around these cells and those beside them in which obstacles are looked for.
    pub(crate) rect: CellRect,
    /// What stands above the patch within the height of the robot, in its cells and beside them.
    pub(crate) obstacles: Vec<ElementRuns>,
    /// Sections of lasting elements at the lidar's height above the patch.
    pub(crate) lidar: Vec<ElementRuns>,
    /// Around both.
    pub(crate) stands: Option<CellRect>,
}

/// Faces of an element in one plane within a step of the floor of the storey, for the heights of its cells.
#[derive(Debug)]
pub(crate) struct LevelFace {
    pub(crate) element: u32,
    pub(crate) plane: Plane,
    /// Cells that the faces overlap.
    pub(crate) cells: Vec<Run>,
    pub(crate) rect: CellRect,
}

/// Heights that differ by more than a step and this are no step: vertices are whole tenths of a millimetre.
pub(crate) const STEP_TOLERANCE: f64 = 5.0;

/// Height of a plane that is level, everywhere.
pub(crate) fn level_z(plane: &Plane) -> Option<f64> {
    plane.gradient().iter().all(|gradient| *gradient == 0.0).then(|| plane.z([0.0; 2]))
}

/// Middles of the cells at the corners of a rectangle, in columns and rows.
pub(crate) fn corner_middles(rect: &CellRect) -> [[f64; 2]; 4] {
    let [[left, low], [right, high]] = [rect.min.map(|k| f64::from(k) + 0.5), rect.max.map(|k| f64::from(k) - 0.5)];
    [[left, low], [right, low], [left, high], [right, high]]
}

/// True if two planes are nowhere between the corners of a rectangle as near as `most`, by their differences of height at these: there
/// they are greatest and least, but for rounding.
pub(crate) fn are_apart(off_at_corners: &[f64; 4], most: f64) -> bool {
    let most = most + 1.0;
    off_at_corners.iter().all(|off| *off > most) || off_at_corners.iter().all(|off| *off < -most)
}

/// Height of a plane at a place in columns and rows of a grid, in tenths of a millimetre.
pub(crate) fn z_at(plane: &Plane, [column, row]: [f64; 2], spec: &GridSpec) -> f64 {
    let at = |cells: f64, first: i32| (cells + f64::from(first)) * f64::from(spec.cell_tenths);
    plane.z([at(column, spec.first_cell[0]), at(row, spec.first_cell[1])])
}

impl GroundPatch {
    /// Height of the patch, or of its continuation, in the middle of a cell, by its index.
    pub(crate) fn z_of(&self, cell: usize, spec: &GridSpec) -> f64 {
        let width = spec.width as usize;
        let middle = || [(cell % width) as f64 + 0.5, (cell / width) as f64 + 0.5];
        level_z(&self.plane).unwrap_or_else(|| z_at(&self.plane, middle(), spec))
    }
}
