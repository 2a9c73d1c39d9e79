//! Tells the new places of a growing SLAM map from those that earlier looks have known.

use crate::pose::Cells;
use frames::{Rigid2, Slam};
use grid::squared_distances;
use messages::{AlignmentEvidence, AlignmentEvidenceBuilder, AlignmentEvidenceHead};
use occupancy::{CELL_M, Cell, Raster};

/// What lies within this of a place that was known is not new: a map bends at loop closures, and a wall that moved is the same.
const BESIDE_KNOWN_M: f64 = 0.3;

/// A SLAM map as it is compared, and where its cells lie in its frame.
#[derive(Clone, Copy)]
pub(crate) struct PlacedRaster<'a> {
    pub(crate) raster: &'a Raster,
    pub(crate) slam_from_cells: &'a Rigid2<Slam, Cells<Slam>>,
}

/// The places of a SLAM map that are not beside what earlier looks have known.
pub(crate) struct NewPlaces {
    width: usize,
    is_new: Vec<bool>,
}

impl NewPlaces {
    /// Of a map at which these earlier looks were taken.
    pub(crate) fn of(map: PlacedRaster<'_>, earlier: &AlignmentEvidence<'_>) -> Self {
        let cells = EvidenceCells::of(earlier.head);
        let was_known: Vec<bool> = (0..map.raster.cells.len())
            .map(|k| cells.index_at(map.middle(k)).is_some_and(|index| earlier.is_known(index)))
            .collect();
        let far = (BESIDE_KNOWN_M / CELL_M) as u32;
        let distances = squared_distances(&was_known, map.raster.width);
        Self { width: map.raster.width, is_new: distances.iter().map(|squared| *squared > far * far).collect() }
    }

    /// True of a place of the map, in metres from its lower left corner.
    pub(crate) fn has(&self, [x, y]: [f64; 2]) -> bool {
        let (column, row) = ((x / CELL_M).floor(), (y / CELL_M).floor());
        let is_inside = 0.0 <= column && column < self.width as f64 && 0.0 <= row;
        is_inside && self.is_new.get(row as usize * self.width + column as usize).copied().unwrap_or(false)
    }

    /// New cells that the map knows.
    pub(crate) fn n_known(&self, raster: &Raster) -> usize {
        self.is_new.iter().zip(&raster.cells).filter(|(is_new, cell)| **is_new && **cell != Cell::Unknown).count()
    }
}

impl PlacedRaster<'_> {
    /// The middle of a cell in the frame of the SLAM map.
    fn middle(&self, index: usize) -> [f64; 2] {
        self.slam_from_cells.apply(self.raster.middle(index))
    }

    /// Cells that earlier looks have known, and how many of them this map knows.
    pub(crate) fn kept_of(&self, earlier: &AlignmentEvidence<'_>) -> [usize; 2] {
        let cells = EvidenceCells::of(earlier.head);
        let known = (0..cells.n()).filter(|index| earlier.is_known(*index));
        known.fold([0, 0], |[n, n_kept], index| {
            let here = self.raster.at(self.slam_from_cells.apply_inverse(cells.middle(index)));
            [n + 1, n_kept + usize::from(here != Cell::Unknown)]
        })
    }

    /// The head of evidence whose cells hold this map and all earlier looks; the rest of it is zero.
    pub(crate) fn evidence_head(&self, earlier: Option<&AlignmentEvidence<'_>>) -> AlignmentEvidenceHead {
        let cells = earlier.map_or_else(
            || EvidenceCells {
                slam_from_cells: *self.slam_from_cells,
                size: [self.raster.width, self.raster.height].map(|n| n as i64),
            },
            |earlier| EvidenceCells::of(earlier.head),
        );
        let [width, height] = [self.raster.width, self.raster.height].map(|n| n as f64 * CELL_M);
        let corners = [[0.0, 0.0], [width, 0.0], [0.0, height], [width, height]]
            .map(|corner| cells.slam_from_cells.apply_inverse(self.slam_from_cells.apply(corner)).map(|c| c / CELL_M));
        // Corners that lie on the lines of the cells do not add a row by rounding.
        let low = [0, 1].map(|k| corners.iter().map(|c| (c[k] + 1e-6).floor() as i64).fold(0, i64::min));
        let high = [0, 1].map(|k| corners.iter().map(|c| (c[k] - 1e-6).ceil() as i64).fold(cells.size[k], i64::max));
        let origin = cells.slam_from_cells.apply(low.map(|c| c as f64 * CELL_M));
        AlignmentEvidenceHead {
            origin: [origin[0], origin[1], cells.slam_from_cells.yaw_rad()],
            width: (high[0] - low[0]) as u32,
            height: (high[1] - low[1]) as u32,
            ..bytemuck::Zeroable::zeroed()
        }
    }

    /// Marks what this map knows, and what earlier looks have known.
    pub(crate) fn mark(&self, earlier: Option<&AlignmentEvidence<'_>>, builder: &mut AlignmentEvidenceBuilder) {
        let cells = EvidenceCells::of(&builder.head);
        if let Some(earlier) = earlier {
            let of = EvidenceCells::of(earlier.head);
            for index in (0..of.n()).filter(|index| earlier.is_known(*index)) {
                cells.index_at(of.middle(index)).into_iter().for_each(|k| builder.mark_known(k));
            }
        }
        for (k, _) in self.raster.cells.iter().enumerate().filter(|(_, cell)| **cell != Cell::Unknown) {
            cells.index_at(self.middle(k)).into_iter().for_each(|k| builder.mark_known(k));
        }
    }
}

/// The cells of evidence over looks.
struct EvidenceCells {
    slam_from_cells: Rigid2<Slam, Cells<Slam>>,
    /// Columns and rows.
    size: [i64; 2],
}

impl EvidenceCells {
    fn of(head: &AlignmentEvidenceHead) -> Self {
        let size = [head.width, head.height].map(i64::from);
        Self { slam_from_cells: Rigid2::of_x_y_yaw(head.origin), size }
    }

    fn n(&self) -> usize {
        (self.size[0] * self.size[1]) as usize
    }

    fn index_at(&self, in_slam_m: [f64; 2]) -> Option<usize> {
        let [column, row] = self.slam_from_cells.apply_inverse(in_slam_m).map(|c| (c / CELL_M).floor() as i64);
        let is_inside = 0 <= column && column < self.size[0] && 0 <= row && row < self.size[1];
        is_inside.then(|| (row * self.size[0] + column) as usize)
    }

    /// The middle of a cell in the frame of the SLAM map.
    fn middle(&self, index: usize) -> [f64; 2] {
        let [column, row] = [index as i64 % self.size[0], index as i64 / self.size[0]];
        self.slam_from_cells.apply([column, row].map(|c| (c as f64 + 0.5) * CELL_M))
    }
}
