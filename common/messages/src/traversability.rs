//! Traversability of a cell for the robot of its map: 0 where it must not be, else falling with the slope of the ground.

use crate::grid_archive::Grid;
use crate::robot::RobotProfile;
use grid::Class;

/// Of a cell that the robot can drive on, on the steepest ground that it takes: 0 alone means that it must not be there.
const LEAST: f64 = 0.01;

impl Grid<'_> {
    /// How well the robot whose map this is drives over a cell: 0 to 1; `None` where nothing is known.
    ///
    /// - 0 where its centre must not be: the planning map is occupied, or the keep-out mask is set.
    /// - Else `None` where the planning map is unknown.
    /// - Else it is free: `1 - slope / max_slope_rad`, at least 0.01. That is 1 on level ground. On a tread the share is the cost of stairs
    ///   in the robot's profile, because a tread is level and a flight is not.
    ///
    /// As in the planning map, obstacles are not inflated by the radius of the robot.
    ///
    /// # Source
    /// The slope filter of leggedrobotics' `traversability_estimation`, which is linear between level and a critical slope: Wermelinger
    /// et al., "Navigation Planning for Legged Robots in Challenging Terrain", IROS 2016.
    pub fn traversability(&self, cell: usize, robot: &RobotProfile) -> Option<f64> {
        if self.planning[cell] > 0 || self.is_keepout(cell) {
            return Some(0.0);
        }
        let slope_rad = self.slope_rad(cell).filter(|_| self.planning[cell] == 0)?;
        let share = match self.class_of(cell) {
            Class::Stair => f64::from(robot.stair_cost) / 100.0,
            _ if slope_rad > 0.0 => slope_rad / robot.max_slope_rad,
            _ => 0.0,
        };
        Some((1.0 - share).max(LEAST))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::archive::ArchiveBuffer;
    use crate::grid_archive::{GridHead, GridLayers, GridWriter, NO_SLOPE};

    /// Traversability of cells of planning, keep-out and slope, for a robot that takes some slope.
    fn check<const N: usize>(cells: [(i8, i8, u16); N], max_slope_rad: f64) -> [Option<f64>; N] {
        check_class(cells, Class::None, RobotProfile { max_slope_rad, ..RobotProfile::DEFAULT })
    }

    /// The same of cells of a class.
    fn check_class<const N: usize>(cells: [(i8, i8, u16); N], shown: Class, robot: RobotProfile) -> [Option<f64>; N] {
        let head = GridHead { cell_tenths: 500, width: N as u32, height: 1, ..GridHead::EMPTY };
        let mut buffer = ArchiveBuffer::zeroed(GridWriter::len_with_heights(N));
        let mut writer = GridWriter::new(buffer.bytes_mut(), &head);
        let GridLayers { class, planning, keepout, slope, floor, .. } = writer.layers();
        class.fill(shown.id());
        for (k, cell) in cells.into_iter().enumerate() {
            (planning[k], keepout[k], slope[k]) = cell;
            floor[k] = u8::from(cell.2 != NO_SLOPE);
        }
        writer.seal();
        let grid = Grid::open(buffer.bytes()).unwrap();
        std::array::from_fn(|cell| grid.traversability(cell, &robot))
    }

    #[test]
    fn on_a_tread_it_is_what_the_cost_of_stairs_leaves() {
        let robot = RobotProfile { climbs_stairs: 1, stair_cost: 60, ..RobotProfile::DEFAULT };
        let found = check_class([(0, -1, 0), (100, -1, 0)], Class::Stair, robot);
        assert_eq!(found, [0.4, 0.0].map(Some));
    }

    #[test]
    fn it_falls_with_the_slope_and_is_0_only_where_the_robot_must_not_be() {
        let free = |slope: u16| (0, -1, slope);
        assert_eq!(check([free(0), free(50), free(200), free(201)], 0.2), [1.0, 0.75, LEAST, LEAST].map(Some));
        let kept_out = [(100, -1, 0), (0, 100, 0), (-1, 100, NO_SLOPE), (100, 100, 50)];
        assert_eq!(check(kept_out, 0.2), [Some(0.0); 4]);
        assert_eq!(check([(-1, -1, 0), (-1, -1, NO_SLOPE), (0, -1, NO_SLOPE)], 0.2), [None; 3]);
        assert_eq!(check([free(0), free(1)], 0.0), [1.0, LEAST].map(Some), "a robot that takes no slope at all");
    }
}
