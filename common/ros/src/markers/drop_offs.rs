//! Edges of floors.

use super::drawing::{BLOCKED, Drawing, point};
use crate::msg::builtin_interfaces::Time;
use crate::msg::geometry_msgs::Point;
use crate::msg::visualization_msgs::MarkerArray;
use grid::GridSpec;
use messages::Grid;

/// The borders between floor and cells without floor in which no obstacle stands, as one list of lines in `drop_offs`.
pub fn drop_offs(grid: &Grid<'_>, frame_id: &str, stamp: Time) -> MarkerArray {
    let mut drawing = Drawing::new(frame_id, stamp);
    let sides: Vec<u8> =
        grid.floor.iter().zip(grid.planning).map(|(&floor, &planning)| side(floor, planning)).collect();
    drawing.line_list(("drop_offs", 0), BLOCKED, edges(&grid.spec(), &sides));
    drawing.finish()
}

/// Two points for each straight piece of the borders: those between rows, then those between columns.
fn edges(spec: &GridSpec, sides: &[u8]) -> Vec<Point> {
    let width = spec.width.max(1) as usize;
    let is_edge = |a: u8, b: u8| (a | b) == FLOOR | DROP;
    let mut points = Vec::new();
    for (row, rows) in sides.windows(2 * width).step_by(width).enumerate() {
        let (below, above) = rows.split_at(width);
        // Most rows have none.
        if below.iter().zip(above).fold(false, |any, (&a, &b)| any | is_edge(a, b)) {
            let ends = runs(width, |column| is_edge(below[column], above[column])).into_iter().flatten();
            points.extend(ends.map(|column| corner(spec, column, row + 1)));
        }
    }
    // Row by row, as the cells lie in memory.
    let mut of_column: Vec<Vec<[usize; 2]>> = vec![Vec::new(); width];
    for (row, cells) in sides.chunks(width).enumerate() {
        if cells.windows(2).fold(false, |any, pair| any | is_edge(pair[0], pair[1])) {
            for (column, _) in (1..).zip(cells.windows(2)).filter(|(_, pair)| is_edge(pair[0], pair[1])) {
                extend(&mut of_column[column], row);
            }
        }
    }
    for (column, runs) in of_column.into_iter().enumerate() {
        points.extend(runs.into_iter().flatten().map(|row| corner(spec, column, row)));
    }
    points
}

/// A cell that a robot may stand on, and one that it would fall into; 0 for all others.
const FLOOR: u8 = 1;
const DROP: u8 = 2;

fn side(floor: u8, planning: i8) -> u8 {
    match floor {
        0 if planning < 0 => DROP,
        0 => 0,
        _ if planning == 100 => 0,
        _ => FLOOR,
    }
}

/// Begin and end of each run of places that have something, the end exclusive.
fn runs(n: usize, has: impl Fn(usize) -> bool) -> Vec<[usize; 2]> {
    let mut runs = Vec::new();
    (0..n).filter(|&at| has(at)).for_each(|at| extend(&mut runs, at));
    runs
}

/// Takes the next place into the last run, or begins another.
fn extend(runs: &mut Vec<[usize; 2]>, at: usize) {
    match runs.last_mut() {
        Some([_, end]) if *end == at => *end = at + 1,
        _ => runs.push([at, at + 1]),
    }
}

/// The lower left corner of a cell.
fn corner(spec: &GridSpec, column: usize, row: usize) -> Point {
    let origin = spec.origin_m();
    point([origin[0] + column as f64 * spec.resolution_m(), origin[1] + row as f64 * spec.resolution_m()])
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn runs_are_as_long_as_they_can_be() {
        let has = [true, true, false, true, false, false, true];
        assert_eq!(runs(has.len(), |at| has[at]), [[0, 2], [3, 4], [6, 7]]);
        assert!(runs(0, |_| true).is_empty());
    }

    proptest! {
        #[test]
        fn all_borders_between_floor_and_drop_are_lines_and_no_others(
            width in 1_usize..7,
            cells in proptest::collection::vec(0_u8..3, 1..40),
        ) {
            let sides = &cells[..cells.len() - cells.len() % width];
            let height = sides.len() / width;
            let spec = GridSpec { cell_tenths: 10_000, first_cell: [0, 0], width: width as u32, height: height as u32 };
            let mut pieces: Vec<[i64; 4]> = Vec::new();
            for ends in edges(&spec, sides).chunks(2) {
                let [x0, y0, x1, y1] = [ends[0].x, ends[0].y, ends[1].x, ends[1].y].map(|value| value.round() as i64);
                pieces.extend((x0..x1).map(|x| [x, y0, x + 1, y0]).chain((y0..y1).map(|y| [x0, y, x0, y + 1])));
            }
            let is_border = |a: usize, b: usize| [[FLOOR, DROP], [DROP, FLOOR]].contains(&[sides[a], sides[b]]);
            let mut expected: Vec<[i64; 4]> = Vec::new();
            for (row, column) in (0..height).flat_map(|row| (0..width).map(move |column| (row, column))) {
                let (cell, [x, y]) = (row * width + column, [column, row].map(|n| n as i64));
                if row > 0 && is_border(cell - width, cell) {
                    expected.push([x, y, x + 1, y]);
                }
                if column > 0 && is_border(cell - 1, cell) {
                    expected.push([x, y, x, y + 1]);
                }
            }
            pieces.sort_unstable();
            expected.sort_unstable();
            prop_assert_eq!(pieces, expected);
        }
    }
}
