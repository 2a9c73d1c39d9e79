//! A SLAM map as it would be if it had not bent.

use crate::pose_field::PoseField;
use crate::prepared_map::PreparedMap;
use frames::{BentMotion, Map, Rigid2, Slam};
use grid::PlaceLattice;
use occupancy::{CELL_M, Cell};

/// A motion is taken as straight between places so far from each other, in metres.
const SQUARE_M: f64 = 0.5;

impl PreparedMap<Slam> {
    /// The map moved by its field of poses, and back by the pose of the whole: what the field knows to be bent is straight.
    pub(crate) fn unbent(&self, field: &PoseField, whole: &Rigid2<Map, Slam>) -> Option<Self> {
        let motion = BentMotion::of(
            field.parts.iter().map(|part| (part.about_m, part.map_from_slam, part.covariance.worst_m())),
        )?;
        let (raster, frame) = (&self.features.raster, self.frame_from_cells());
        let size_m = [raster.width, raster.height].map(|n| n as f64 * CELL_M);
        let before = PlaceLattice::over([0.0; 2], size_m, SQUARE_M, |place| {
            motion.apply_inverse(whole.apply(frame.apply(place))).map(|in_slam| frame.apply_inverse(in_slam))
        });
        let cell = |index: usize| before.at(raster.middle(index)).map_or(Cell::Unknown, |place| raster.at(place));
        Some(self.with_cells((0..raster.cells.len()).map(cell).collect()))
    }
}
