//! `relief.png` of a storey whose ground is not level: its slope in colours, with contour lines, for people.

use crate::image::{Image, Rgb, picture};
use crate::input::{ExportFile, ExportInput};
use crate::pictures::{CLOSED_DOOR, DOOR, SOLID, UNKNOWN};
use frames::TENTHS_PER_M;
use grid::Class;
use messages::Grid;

/// Colours from level ground to the steepest that the robot drives on, at equal distances.
const COLOURS: [Rgb; 4] = [[255, 255, 255], [150, 205, 130], [250, 210, 90], [225, 85, 60]];

/// Distances in height of contour lines, in tenths of a millimetre: the first of which the range of heights has no more than
/// [`MAX_INTERVALS`].
const INTERVALS: [i32; 7] = [500, 1_000, 2_500, 5_000, TENTHS_PER_M, 2 * TENTHS_PER_M, 5 * TENTHS_PER_M];
const MAX_INTERVALS: i32 = 24;

/// A contour line has this share of the colour of the ground.
const LINE_SHADE: f64 = 0.72;

/// The picture, if the storey has heights.
pub(crate) fn file(folder: &str, input: &ExportInput<'_>, grid: &Grid<'_>) -> Option<ExportFile> {
    let heights = || (0..grid.elevation.len()).filter_map(|cell| grid.height_tenths(cell));
    let (low, high) = (heights().min()?, heights().max()?);
    let range = high.saturating_sub(low);
    let fits = |interval: &&i32| range / **interval <= MAX_INTERVALS;
    let interval = INTERVALS.iter().find(fits).copied().unwrap_or(range / MAX_INTERVALS);
    let max_slope_rad = input.index.head.robot.max_slope_rad;
    let pixels = (0..grid.elevation.len()).map(|cell| colour(grid, cell, interval, max_slope_rad)).collect();
    let image = Image::new(grid.head.width as usize, pixels);
    Some(ExportFile::new(format!("{folder}/relief.png"), picture(image)))
}

fn colour(grid: &Grid<'_>, cell: usize, interval: i32, max_slope_rad: f64) -> Rgb {
    match (grid.class_of(cell), grid.height_tenths(cell)) {
        (Class::Door, _) if grid.planning[cell] == 0 => DOOR,
        (Class::Door, _) => CLOSED_DOOR,
        (Class::None, None) => UNKNOWN,
        (class, Some(height)) if class == Class::None || grid.planning[cell] == 0 => {
            let slope = slope_colour(grid.slope_rad(cell).unwrap_or(0.0), max_slope_rad);
            if is_on_line(grid, cell, height, interval) {
                slope.map(|part| (f64::from(part) * LINE_SHADE) as u8)
            } else {
                slope
            }
        }
        _ => SOLID,
    }
}

/// True if a contour line runs between a cell and that to its right or above it.
fn is_on_line(grid: &Grid<'_>, cell: usize, height: i32, interval: i32) -> bool {
    let width = grid.head.width as usize;
    let right = Some(cell + 1).filter(|other| other % width != 0);
    let beside = [right, Some(cell + width).filter(|other| *other < grid.elevation.len())];
    let band = |height: i32| height.div_euclid(interval);
    beside.into_iter().flatten().filter_map(|other| grid.height_tenths(other)).any(|other| band(other) != band(height))
}

/// The colour of a slope, by its share of the steepest on which the robot drives.
fn slope_colour(slope_rad: f64, max_slope_rad: f64) -> Rgb {
    let steps = COLOURS.len() - 1;
    let share = if slope_rad <= 0.0 { 0.0 } else { (slope_rad / max_slope_rad).min(1.0) };
    let at = share * steps as f64;
    let from = (at as usize).min(steps - 1);
    let along = at - from as f64;
    std::array::from_fn(|k| {
        let [a, b] = [COLOURS[from][k], COLOURS[from + 1][k]].map(f64::from);
        (a + along * (b - a)).round() as u8
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use messages::{ArchiveBuffer, GridHead, GridWriter};

    #[test]
    fn colours_go_from_level_to_the_steepest_that_the_robot_drives_on() {
        assert_eq!([0.0, 0.1, 0.2].map(|slope| slope_colour(slope, 0.1)), [COLOURS[0], COLOURS[3], COLOURS[3]]);
        assert_eq!(slope_colour(0.05, 0.1), [200, 208, 110], "half way between the second and the third");
        assert_eq!(
            [0.0, 0.01].map(|slope| slope_colour(slope, 0.0)),
            [COLOURS[0], COLOURS[3]],
            "a robot on level floor"
        );
    }

    #[test]
    fn a_tread_on_which_the_robot_drives_is_ground_and_another_one_is_solid() {
        let head = GridHead { cell_tenths: 1_000, width: 2, height: 1, ..GridHead::EMPTY };
        let mut buffer = ArchiveBuffer::zeroed(GridWriter::len_with_heights(2));
        let mut writer = GridWriter::new(buffer.bytes_mut(), &head);
        let layers = writer.layers();
        layers.class.fill(Class::Stair.id());
        layers.planning.copy_from_slice(&[0, 100]);
        layers.elevation.fill(1_700);
        layers.slope.fill(0);
        writer.seal();
        let grid = Grid::open(buffer.bytes()).unwrap();
        assert_eq!([0, 1].map(|cell| colour(&grid, cell, 1_000, 0.1)), [COLOURS[0], SOLID]);
    }

    #[test]
    fn contour_lines_run_where_the_height_passes_a_multiple_of_their_distance() {
        let head = GridHead { cell_tenths: 1_000, width: 4, height: 1, ..GridHead::EMPTY };
        let mut buffer = ArchiveBuffer::zeroed(GridWriter::len_with_heights(4));
        let mut writer = GridWriter::new(buffer.bytes_mut(), &head);
        writer.layers().elevation.copy_from_slice(&[-100, 100, 900, 1_100]);
        writer.seal();
        let grid = Grid::open(buffer.bytes()).unwrap();
        let lines: Vec<bool> = (0..4).map(|cell| is_on_line(&grid, cell, grid.elevation[cell], 1_000)).collect();
        assert_eq!(lines, [true, false, true, false]);
    }
}
