//! Heights, slopes and traversability of the cells of a map storey: as they are, moved into the robot's frame, small enough for a message.

use crate::larger_cells::LargerCells;
use crate::msg::builtin_interfaces::Time;
use crate::msg::foxglove_msgs::{Grid as FoxgloveGrid, PackedElementField, Vector2};
use crate::msg::geometry_msgs::{Point, Pose};
use crate::msg::grid_map_msgs::{GridMap, GridMapInfo};
use crate::msg::std_msgs::{Float32MultiArray, Header, MultiArrayDimension, MultiArrayLayout};
use bytemuck::{Pod, Zeroable};
use frames::metres;
use grid::{GridSpec, GridSpecError, MovedGrid};
use messages::{Grid, RobotProfile, SlamFrame};

/// What is known of a cell; NaN is what is not.
#[derive(Debug, Clone, Copy, PartialEq, Zeroable, Pod)]
#[repr(C)]
struct Cell {
    elevation_m: f32,
    slope_rad: f32,
    traversability: f32,
}

impl Cell {
    const UNKNOWN: Self = Self { elevation_m: f32::NAN, slope_rad: f32::NAN, traversability: f32::NAN };

    /// One cell in the place of several: the middle one of their heights, the steepest slope, and the traversability of the
    /// worst. None of them is a way if the robot must not be in one; nothing is said of them if nothing is known of one.
    fn joined(cells: &[Self]) -> Self {
        let mut heights: Vec<f32> = cells.iter().map(|cell| cell.elevation_m).filter(|z| !z.is_nan()).collect();
        heights.sort_unstable_by(f32::total_cmp);
        let worst = |a: f32, b: f32| {
            if a == 0.0 || b == 0.0 {
                0.0
            } else if a.is_nan() {
                a
            } else if b.is_nan() {
                b
            } else {
                a.min(b)
            }
        };
        Self {
            elevation_m: heights.get(heights.len() / 2).copied().unwrap_or(f32::NAN),
            // The larger of a number and NaN is the number.
            slope_rad: cells.iter().map(|cell| cell.slope_rad).fold(f32::NAN, f32::max),
            traversability: cells.iter().map(|cell| cell.traversability).reduce(worst).unwrap_or(f32::NAN),
        }
    }
}

/// Height, slope and traversability of the cells of a map storey; row-major from the lower left.
///
/// | layer | of a cell |
/// |---|---|
/// | `elevation` | height of the ground in its middle, in metres above the floor of the storey, in which the frame of its maps has z = 0; NaN where there is no floor. 0 on the floor of a level storey |
/// | `slope` | slope of the ground there, in radians; NaN where there is no floor. 0 on the floor of a level storey |
/// | `traversability` | how well the robot drives over it, as [`Grid::traversability`] says; NaN where nothing is known |
#[derive(Debug, Clone)]
pub struct Relief {
    /// Where the cells lie.
    pub spec: GridSpec,
    cells: Vec<Cell>,
}

impl Relief {
    /// Names of the layers.
    pub const LAYERS: [&'static str; 3] = ["elevation", "slope", "traversability"];

    /// Bytes of a cell in a message.
    pub const CELL_BYTES: usize = size_of::<Cell>();

    /// That of a grid, which was made for this robot.
    pub fn of(grid: &Grid<'_>, robot: &RobotProfile) -> Self {
        let number = |value: Option<f64>| value.map_or(f32::NAN, f64_to_f32);
        let height_m = |z_tenths: i32| metres(z_tenths) - metres(grid.head.floor_z_tenths);
        let cell = |cell: usize| Cell {
            elevation_m: number(grid.height_tenths(cell).map(height_m)),
            slope_rad: number(grid.slope_rad(cell)),
            traversability: number(grid.traversability(cell, robot)),
        };
        Self { spec: grid.spec(), cells: (0..grid.spec().n_cells()).map(cell).collect() }
    }

    /// The same in the robot's frame, in cells of the same size, each made of several places in it: the middle one of their heights,
    /// the steepest slope, and where the robot must not be at one of them, it must not be in the cell. Where it is not
    /// known how the robot's map lies, nothing is said but where it must not be.
    ///
    /// # Errors
    /// Too many cells, or a robot's map that folds.
    pub fn moved(&self, frame: &SlamFrame) -> Result<Self, GridSpecError> {
        let (from, side_m) = (&self.spec, self.spec.resolution_m());
        let size_m = [from.width, from.height].map(|n| f64::from(n) * side_m);
        let grid = MovedGrid::around(from.origin_m(), size_m, side_m, &frame.motion, |place| frame.is_known_at(place))?;
        let [x0, y0] = from.origin_m();
        let at = |[x, y]: [f64; 2]| {
            let [column, row] = [(x - x0) / side_m, (y - y0) / side_m];
            let is_inside =
                column >= 0.0 && row >= 0.0 && column < f64::from(from.width) && row < f64::from(from.height);
            is_inside.then(|| self.cells[row as usize * from.width as usize + column as usize])
        };
        let sample = |place: Option<[f64; 2]>, is_known: bool| {
            let cell = place.and_then(at).unwrap_or(Cell::UNKNOWN);
            match cell.traversability {
                _ if is_known => cell,
                0.0 => Cell { traversability: 0.0, ..Cell::UNKNOWN },
                _ => Cell::UNKNOWN,
            }
        };
        Ok(Self { spec: grid.spec, cells: grid.joined(sample, Cell::joined) })
    }

    /// The same in at most `max_cells` cells: without its rims of which nothing is known, and where that is not enough in the
    /// smallest larger cells that do, each made of those that it holds as in [`Self::moved`].
    ///
    /// `None` where cells of a metre are too many.
    pub fn within(self, max_cells: usize) -> Option<Self> {
        if self.spec.n_cells() <= max_cells {
            return Some(self);
        }
        let is_known = |k: usize| {
            let Cell { elevation_m, slope_rad, traversability } = self.cells[k];
            [elevation_m, slope_rad, traversability].iter().any(|value| !value.is_nan())
        };
        let larger = LargerCells::within(self.spec, is_known, max_cells)?;
        Some(Self { spec: larger.spec, cells: larger.joined(&self.cells, Cell::UNKNOWN, Cell::joined) })
    }
}

/// The layers as a map of `grid_map`, of which the elevation makes a cell valid.
pub fn grid_map(relief: &Relief, frame_id: &str, stamp: Time) -> GridMap {
    let GridSpec { width, height, .. } = relief.spec;
    let (resolution, [x, y]) = (relief.spec.resolution_m(), relief.spec.origin_m());
    let [length_x, length_y] = [width, height].map(|n| f64::from(n) * resolution);
    let middle = Point { x: x + length_x / 2.0, y: y + length_y / 2.0, z: 0.0 };
    let [columns, rows] = GridMap::DIMENSIONS.map(str::to_owned);
    let dim = vec![
        MultiArrayDimension { label: columns, size: height, stride: width * height },
        MultiArrayDimension { label: rows, size: width, stride: width },
    ];
    // Rows of its matrices are cells along x, and both directions are reversed: all of it is.
    let layer = |value: fn(&Cell) -> f32| Float32MultiArray {
        layout: MultiArrayLayout { dim: dim.clone(), data_offset: 0 },
        data: relief.cells.iter().rev().map(value).collect(),
    };
    GridMap {
        header: Header { stamp, frame_id: frame_id.to_owned() },
        info: GridMapInfo { resolution, length_x, length_y, pose: Pose { position: middle, ..Pose::default() } },
        layers: Relief::LAYERS.map(str::to_owned).into(),
        basic_layers: vec![Relief::LAYERS[0].to_owned()],
        data: vec![layer(|cell| cell.elevation_m), layer(|cell| cell.slope_rad), layer(|cell| cell.traversability)],
        outer_start_index: 0,
        inner_start_index: 0,
    }
}

/// The layers as fields of a grid that Foxglove colours by any of them.
pub fn foxglove_grid(relief: &Relief, frame_id: &str, stamp: Time) -> FoxgloveGrid {
    let (resolution, [x, y]) = (relief.spec.resolution_m(), relief.spec.origin_m());
    let cell_stride = size_of::<Cell>() as u32;
    let field = |(name, offset): (&str, usize)| PackedElementField {
        name: name.to_owned(),
        offset: offset as u32,
        r#type: PackedElementField::FLOAT32,
    };
    let offsets = [0, 1, 2].map(|k| k * size_of::<f32>());
    FoxgloveGrid {
        timestamp: stamp,
        frame_id: frame_id.to_owned(),
        pose: Pose { position: Point { x, y, z: 0.0 }, ..Pose::default() },
        column_count: relief.spec.width,
        cell_size: Vector2 { x: resolution, y: resolution },
        row_stride: relief.spec.width * cell_stride,
        cell_stride,
        fields: Relief::LAYERS.into_iter().zip(offsets).map(field).collect(),
        data: bytemuck::cast_slice(&relief.cells).to_vec(),
    }
}

#[expect(clippy::cast_possible_truncation, reason = "the messages have 32 bits")]
fn f64_to_f32(value: f64) -> f32 {
    value as f32
}

#[cfg(test)]
mod tests {
    use super::*;
    use frames::{Map, Rigid2, Slam};
    use messages::PoseRecord;
    use proptest::prelude::*;

    const NAN: f32 = f32::NAN;

    fn cell([elevation_m, slope_rad, traversability]: [f32; 3]) -> Cell {
        Cell { elevation_m, slope_rad, traversability }
    }

    fn relief(width: u32, first_cell: [i32; 2], cells: Vec<Cell>) -> Relief {
        let height = cells.len() as u32 / width;
        Relief { spec: GridSpec { cell_tenths: 500, first_cell, width, height }, cells }
    }

    fn at(relief: &Relief, [x, y]: [f64; 2]) -> Option<Cell> {
        let (side_m, origin) = (relief.spec.resolution_m(), relief.spec.origin_m());
        let [column, row] = [((x - origin[0]) / side_m).floor(), ((y - origin[1]) / side_m).floor()];
        let is_inside =
            column >= 0.0 && row >= 0.0 && column < f64::from(relief.spec.width) && row < f64::from(relief.spec.height);
        is_inside.then(|| relief.cells[row as usize * relief.spec.width as usize + column as usize])
    }

    /// Middles of cells in which the robot must not be.
    fn kept_out(relief: &Relief) -> impl Iterator<Item = [f64; 2]> {
        let (width, side_m, [x, y]) = (relief.spec.width as usize, relief.spec.resolution_m(), relief.spec.origin_m());
        let cells = relief.cells.iter().enumerate().filter(|(_, cell)| cell.traversability == 0.0);
        cells.map(move |(k, _)| {
            [x + (k % width) as f64 * side_m + side_m / 2.0, y + (k / width) as f64 * side_m + side_m / 2.0]
        })
    }

    #[test]
    fn several_cells_are_as_high_as_the_middle_one_as_steep_as_the_steepest_and_no_better_than_the_worst() {
        let check = |cells: &[[f32; 3]], expected: [f32; 3]| {
            let joined = Cell::joined(&cells.iter().copied().map(cell).collect::<Vec<_>>());
            let found = [joined.elevation_m, joined.slope_rad, joined.traversability].map(f32::to_bits);
            assert_eq!(found, expected.map(f32::to_bits), "{cells:?}");
        };
        check(&[[3.0, 0.1, 0.5], [1.0, 0.0, 1.0], [2.0, 0.2, 0.75]], [2.0, 0.2, 0.5]);
        check(&[[3.0, 0.1, 0.5], [NAN, NAN, NAN]], [3.0, 0.1, NAN]);
        check(&[[3.0, 0.1, 0.5], [NAN, NAN, NAN], [NAN, NAN, 0.0]], [3.0, 0.1, 0.0]);
        check(&[[NAN, NAN, NAN]; 2], [NAN; 3]);
    }

    #[test]
    fn cell_0_is_at_the_largest_x_and_y_and_the_next_one_beside_it_along_x() {
        let cells = (0..6).map(|k| cell([k as f32, 0.0, 1.0])).collect();
        let map = grid_map(&relief(3, [-2, 10], cells), "map", Time::default());
        assert_eq!(map.data[0].data, [5.0, 4.0, 3.0, 2.0, 1.0, 0.0]);
        let dim = &map.data[0].layout.dim;
        let dimensions: Vec<_> = dim.iter().map(|d| (d.label.as_str(), d.size, d.stride)).collect();
        assert_eq!(dimensions, [("column_index", 2, 6), ("row_index", 3, 3)]);
        let GridMapInfo { resolution, length_x, length_y, pose } = map.info;
        assert!((resolution, length_x, length_y) == (0.05, 3.0 * 0.05, 0.1), "{:?}", map.info);
        assert!((pose.position.x + 0.025).abs() < 1e-12 && (pose.position.y - 0.55).abs() < 1e-12, "{pose:?}");
        assert_eq!(map.layers.len(), map.data.len());
    }

    #[test]
    fn fields_of_a_grid_for_foxglove_lie_where_it_says() {
        let cells = vec![cell([1.5, 0.25, 0.75]), cell([NAN, NAN, 0.0])];
        let grid = foxglove_grid(&relief(2, [-2, 10], cells), "map", Time::default());
        let value = |cell: usize, field: usize| {
            let start = cell * grid.cell_stride as usize + grid.fields[field].offset as usize;
            f32::from_le_bytes(grid.data[start..start + 4].try_into().unwrap())
        };
        assert_eq!([0, 1, 2].map(|field| value(0, field)), [1.5, 0.25, 0.75]);
        assert!(value(1, 0).is_nan() && value(1, 2) == 0.0);
        assert_eq!((grid.row_stride, grid.data.len(), grid.column_count), (24, 24, 2));
        let corner = grid.pose.position;
        assert_eq!((corner.x, corner.y, corner.z), (-0.1, 0.5, 0.0));
    }

    #[test]
    fn what_is_small_enough_stays_as_it_is_and_a_rim_without_knowledge_goes_first() {
        let mut cells = vec![Cell::UNKNOWN; 100];
        (cells[34], cells[45]) = (cell([1.0, 0.0, 1.0]), cell([NAN, NAN, 0.0]));
        let whole = relief(10, [-3, 7], cells);
        assert_eq!(whole.clone().within(100).unwrap().spec, whole.spec);
        let cut = whole.clone().within(99).unwrap();
        assert_eq!((cut.spec.first_cell, cut.spec.width, cut.spec.height, cut.spec.cell_tenths), ([1, 10], 2, 2, 500));
        let larger = whole.within(2).unwrap();
        assert_eq!((larger.spec.cell_tenths, larger.spec.n_cells()), (1000, 2));
        assert!(relief(60, [0, 0], vec![cell([0.0; 3]); 3600]).within(1).is_none(), "cells of a metre are too many");
    }

    proptest! {
        #[test]
        fn no_place_where_the_robot_must_not_be_is_lost_in_larger_cells_or_in_another_frame(
            cells in proptest::collection::vec(prop_oneof![Just(0.0_f32), Just(NAN), Just(0.5)], 144),
            first in proptest::array::uniform2(-50..50_i32), max_cells in 4..144_usize,
            x in -5.0..5.0_f64, y in -5.0..5.0_f64, yaw in -3.0..3.0_f64,
        ) {
            let before = relief(12, first, cells.into_iter().map(|t| cell([t, t, t])).collect());
            let coarse = before.clone().within(max_cells).unwrap();
            prop_assert!(coarse.spec.n_cells() <= max_cells);
            let slam_from_map = Rigid2::<Slam, Map>::new([x, y], yaw);
            let pose = PoseRecord { map_from_slam: slam_from_map.inverse().x_y_yaw(), ..PoseRecord::NONE };
            let moved = before.moved(&SlamFrame::rigid(&pose)).unwrap();
            for point in kept_out(&before) {
                prop_assert_eq!(at(&coarse, point).map(|c| c.traversability), Some(0.0));
                prop_assert_eq!(at(&moved, slam_from_map.apply(point)).map(|c| c.traversability), Some(0.0));
            }
        }
    }
}
