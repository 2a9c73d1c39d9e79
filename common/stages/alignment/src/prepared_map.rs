//! Maps of models and of robots that are ready to be compared.

use crate::features::Features;
use crate::pose::{Cells, Pose};
use crate::wall_points::Surfaces;
use frames::{Map, Rigid2, Slam};
use occupancy::{CELL_M, Cell, OccupancyMap, Raster};

/// A map that is ready to be compared; `Frame` is that of the model's map or of the robot's.
pub struct PreparedMap<Frame> {
    pub(crate) features: Features,
    frame_from_cells: Rigid2<Frame, Cells<Frame>>,
}

impl PreparedMap<Map> {
    /// A map that was drawn from a model: its cells are occupied up to the surfaces of walls.
    pub fn of_model(map: &OccupancyMap) -> Self {
        Self::of(map, Surfaces { depth_m: 0.0, are_whole: true })
    }
}

impl PreparedMap<Slam> {
    /// The same map as its image shows it if left and right are exchanged.
    pub(crate) fn mirrored(&self) -> Self {
        let raster = &self.features.raster;
        let rows = raster.cells.chunks_exact(raster.width.max(1));
        self.with_cells(rows.flat_map(|row| row.iter().rev().copied()).collect())
    }

    /// The part of the map whose places, in its frame, are in: nothing is known of the others.
    pub(crate) fn within(&self, is_in: impl Fn([f64; 2]) -> bool) -> Self {
        let raster = &self.features.raster;
        let is_kept = |index: usize| is_in(self.frame_from_cells.apply(raster.middle(index)));
        let kept = |(index, cell): (usize, &Cell)| match *cell {
            Cell::Unknown => Cell::Unknown,
            known => {
                if is_kept(index) {
                    known
                } else {
                    Cell::Unknown
                }
            }
        };
        self.with_cells(raster.cells.iter().enumerate().map(kept).collect())
    }

    /// A map of the same place and size with other cells.
    pub(crate) fn with_cells(&self, cells: Vec<Cell>) -> Self {
        let raster = &self.features.raster;
        let surfaces = Surfaces { depth_m: raster.coarseness * CELL_M / 2.0, are_whole: false };
        let features = Features::of(Raster { cells, ..raster.clone() }, surfaces);
        Self { features, frame_from_cells: self.frame_from_cells }
    }

    /// A map that a robot made: a cell in which a surface was hit is occupied, and it lies anywhere in it.
    pub fn of_slam(map: &OccupancyMap) -> Self {
        Self::of(map, Surfaces { depth_m: map.resolution_m / 2.0, are_whole: false })
    }
}

impl<Frame> PreparedMap<Frame> {
    fn of(map: &OccupancyMap, surfaces: Surfaces) -> Self {
        let features = Features::of(Raster::of(&map.cells, map.width, map.resolution_m), surfaces);
        Self { features, frame_from_cells: Rigid2::of_x_y_yaw(map.origin) }
    }

    /// Length of the faces of its walls, in metres.
    pub fn walls_m(&self) -> f64 {
        self.features.walls_m()
    }

    pub(crate) fn frame_from_cells(&self) -> &Rigid2<Frame, Cells<Frame>> {
        &self.frame_from_cells
    }
}

impl<Frame> AsRef<Self> for PreparedMap<Frame> {
    fn as_ref(&self) -> &Self {
        self
    }
}

/// The pose of the cells of two maps whose frames lie to each other by a motion.
pub(crate) fn between_cells(
    reference: &PreparedMap<Map>,
    slam: &PreparedMap<Slam>,
    map_from_slam: &Rigid2<Map, Slam>,
) -> Pose {
    &(&reference.frame_from_cells.inverse() * map_from_slam) * &slam.frame_from_cells
}
