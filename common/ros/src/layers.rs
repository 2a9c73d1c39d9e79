//! Layers of a map storey as occupancy: as they are, moved into the robot's frame, small enough for a message.

use crate::larger_cells::LargerCells;
use grid::{GridSpec, GridSpecError, MovedGrid, occupancy_of, pixel_of};
use messages::{Grid, SlamFrame};

/// Occupied, free, and not known: the cells of nav_msgs/OccupancyGrid.
pub(crate) const OCCUPIED: i8 = 100;
const FREE: i8 = 0;
pub(crate) const UNKNOWN: i8 = -1;

/// What goes before what where several cells become one, by layer: no obstacle is lost. A cell that is not known is no way, and
/// goes before floor on the map that ways are planned on.
const PLANNING_FIRST: &[i8] = &[OCCUPIED, UNKNOWN];
const OTHERS_FIRST: &[i8] = &[OCCUPIED];
/// On a mask of speeds the lowest limit.
const SLOWEST_FIRST: [i8; 100] = {
    let (mut steps, mut k) = ([0; 100], 0);
    while k < steps.len() {
        steps[k] = k as i8 + 1;
        k += 1;
    }
    steps
};

/// A mask of speeds is never unknown: Nav2's filter would keep the limit of the cell before.
fn no_limit_elsewhere(mask: Vec<i8>) -> Vec<i8> {
    mask.into_iter().map(|steps| steps.max(0)).collect()
}

/// The layers of a map storey: -1, 0 or 100 for each cell, row-major from the lower left.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Layers {
    /// Where the cells of all layers lie.
    pub spec: GridSpec,
    /// For global planning.
    pub planning: Vec<i8>,
    /// For localization.
    pub localization: Vec<i8>,
    /// The keep-out mask.
    pub keepout: Vec<i8>,
    /// The mask of limits of speed, if there is one: 0 without a limit, else 1 to 100 steps, never unknown.
    pub speed: Option<Vec<i8>>,
}

impl Layers {
    /// Those of a grid, as Nav2's map_server reads them from files.
    pub fn of(grid: &Grid<'_>) -> Self {
        let cells = |layer: &[i8]| layer.iter().map(|&cell| occupancy_of(pixel_of(cell))).collect();
        Self {
            spec: grid.spec(),
            planning: cells(grid.planning),
            localization: cells(grid.localization),
            keepout: cells(grid.keepout),
            speed: None,
        }
    }

    /// The same with a mask of limits of speed, in cells as those of the other layers.
    pub fn with_speed(self, mask: Vec<i8>) -> Self {
        Self { speed: Some(mask), ..self }
    }

    /// The same in the robot's frame, in cells of the same size: a cell is occupied if a cell of the model's map that lies under
    /// any part of it is. Walls stay whole; a passage may become narrower by a cell. Outside of the model's map nothing is known, and
    /// nothing is free where it is not known how the robot's map lies.
    ///
    /// # Errors
    /// Too many cells, or a robot's map that folds.
    pub fn moved(&self, frame: &SlamFrame) -> Result<Self, GridSpecError> {
        let (from, side_m) = (&self.spec, self.spec.resolution_m());
        let size_m = [from.width, from.height].map(|n| f64::from(n) * side_m);
        let is_known = |place| frame.is_known_at(place);
        let grid = MovedGrid::around(from.origin_m(), size_m, side_m, &frame.motion, is_known)?;
        let [x0, y0] = from.origin_m();
        let cells = |layer: &[i8], first: &[i8]| {
            grid.resampled(first, FREE, UNKNOWN, |[x, y]| {
                let [column, row] = [(x - x0) / side_m, (y - y0) / side_m];
                let is_inside =
                    column >= 0.0 && row >= 0.0 && column < f64::from(from.width) && row < f64::from(from.height);
                if is_inside { layer[row as usize * from.width as usize + column as usize] } else { UNKNOWN }
            })
        };
        Ok(Self {
            spec: grid.spec,
            planning: cells(&self.planning, PLANNING_FIRST),
            localization: cells(&self.localization, OTHERS_FIRST),
            keepout: cells(&self.keepout, OTHERS_FIRST),
            speed: self.speed.as_ref().map(|speed| no_limit_elsewhere(cells(speed, &SLOWEST_FIRST))),
        })
    }

    /// The same in at most `max_cells` cells: without its rims of which no layer knows anything, and where that is not enough in
    /// the smallest larger cells that do, each as the strongest of those that it holds.
    ///
    /// `None` where cells of a metre are too many.
    pub fn within(self, max_cells: usize) -> Option<Self> {
        let is_known = |k: usize| [&self.planning, &self.localization, &self.keepout].iter().any(|l| l[k] != UNKNOWN);
        if self.spec.n_cells() <= max_cells {
            return Some(self);
        }
        let larger = LargerCells::within(self.spec, is_known, max_cells)?;
        let cells = |layer: &[i8], first: &[i8]| {
            larger.joined(layer, UNKNOWN, |held| {
                let strongest = first.iter().find(|value| held.contains(value)).copied();
                strongest.or_else(|| held.iter().copied().max()).expect("a cell holds some")
            })
        };
        Some(Self {
            spec: larger.spec,
            planning: cells(&self.planning, PLANNING_FIRST),
            localization: cells(&self.localization, OTHERS_FIRST),
            keepout: cells(&self.keepout, OTHERS_FIRST),
            speed: self.speed.as_ref().map(|speed| no_limit_elsewhere(cells(speed, &SLOWEST_FIRST))),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use frames::{Map, Rigid2, Slam};
    use messages::PoseRecord;
    use proptest::prelude::*;

    fn layers(width: u32, first_cell: [i32; 2], planning: Vec<i8>) -> Layers {
        let height = planning.len() as u32 / width;
        let spec = GridSpec { cell_tenths: 500, first_cell, width, height };
        let keepout = planning.iter().map(|&cell| if cell == OCCUPIED { OCCUPIED } else { UNKNOWN }).collect();
        Layers { spec, localization: planning.clone(), keepout, planning, speed: None }
    }

    fn occupied(layers: &Layers) -> impl Iterator<Item = [f64; 2]> {
        let (width, side_m, [x, y]) = (layers.spec.width as usize, layers.spec.resolution_m(), layers.spec.origin_m());
        let cells = layers.planning.iter().enumerate().filter(|(_, cell)| **cell == OCCUPIED);
        cells.map(move |(k, _)| {
            [x + (k % width) as f64 * side_m + side_m / 2.0, y + (k / width) as f64 * side_m + side_m / 2.0]
        })
    }

    fn at(layers: &Layers, [x, y]: [f64; 2]) -> Option<i8> {
        let (side_m, origin) = (layers.spec.resolution_m(), layers.spec.origin_m());
        let [column, row] = [((x - origin[0]) / side_m).floor(), ((y - origin[1]) / side_m).floor()];
        let is_inside =
            column >= 0.0 && row >= 0.0 && column < f64::from(layers.spec.width) && row < f64::from(layers.spec.height);
        is_inside.then(|| layers.planning[row as usize * layers.spec.width as usize + column as usize])
    }

    #[test]
    fn rims_without_knowledge_go_before_cells_become_larger() {
        let mut planning = vec![UNKNOWN; 100];
        (planning[34], planning[35], planning[44]) = (0, OCCUPIED, 0);
        let cut = layers(10, [-3, 7], planning.clone()).within(99).unwrap();
        assert_eq!((cut.spec.first_cell, cut.spec.width, cut.spec.height, cut.spec.cell_tenths), ([1, 10], 2, 2, 500));
        assert_eq!(cut.planning, [0, OCCUPIED, 0, UNKNOWN]);
        let whole = layers(10, [-3, 7], planning);
        assert_eq!(whole.clone().within(100).unwrap(), whole, "what is small enough stays as it is");
    }

    #[test]
    fn a_larger_cell_is_as_the_strongest_that_it_holds() {
        let coarse = layers(4, [0, 0], vec![0, 0, 0, UNKNOWN, 0, 0, 0, 0, 0, OCCUPIED, 0, 0, UNKNOWN, 0, 0, 0])
            .within(4)
            .unwrap();
        assert_eq!((coarse.spec.cell_tenths, coarse.spec.width), (1000, 2));
        assert_eq!(coarse.planning, [0, UNKNOWN, OCCUPIED, 0], "what is not known is no way");
        assert_eq!(coarse.localization, [0, 0, OCCUPIED, 0]);
        assert_eq!(coarse.keepout, [UNKNOWN, UNKNOWN, OCCUPIED, UNKNOWN], "no cell of a mask says free");
    }

    #[test]
    fn a_larger_cell_has_the_lowest_limit_of_speed_and_none_is_unknown() {
        let fine = layers(4, [0, 0], vec![0; 16]).with_speed(vec![0, 0, 30, 0, 0, 0, 0, 20, 0, 0, 0, 0, 0, 0, 0, 0]);
        assert_eq!(fine.clone().within(4).unwrap().speed, Some(vec![0, 20, 0, 0]));
        let moved = fine.moved(&SlamFrame::rigid(&PoseRecord::NONE)).unwrap().speed.unwrap();
        assert!(moved.contains(&20) && moved.contains(&30) && moved.iter().all(|steps| *steps >= 0));
    }

    #[test]
    fn cells_of_more_than_a_metre_are_none() {
        assert!(layers(60, [0, 0], vec![0; 3600]).within(1).is_none());
        assert!(layers(20, [0, 0], vec![0; 400]).within(1).is_some());
    }

    proptest! {
        #[test]
        fn no_obstacle_is_lost_in_larger_cells_or_in_another_frame(
            cells in proptest::collection::vec(prop_oneof![Just(0_i8), Just(UNKNOWN), Just(OCCUPIED)], 144),
            first in proptest::array::uniform2(-50..50_i32), max_cells in 4..144_usize,
            x in -5.0..5.0_f64, y in -5.0..5.0_f64, yaw in -3.0..3.0_f64,
        ) {
            let before = layers(12, first, cells);
            let coarse = before.clone().within(max_cells).unwrap();
            prop_assert!(coarse.spec.n_cells() <= max_cells);
            for point in occupied(&before) {
                prop_assert_eq!(at(&coarse, point), Some(OCCUPIED));
            }
            let slam_from_map = Rigid2::<Slam, Map>::new([x, y], yaw);
            let pose = PoseRecord { map_from_slam: slam_from_map.inverse().x_y_yaw(), ..PoseRecord::NONE };
            let moved = before.moved(&SlamFrame::rigid(&pose)).unwrap();
            for point in occupied(&before) {
                prop_assert_eq!(at(&moved, slam_from_map.apply(point)), Some(OCCUPIED));
            }
        }
    }
}
