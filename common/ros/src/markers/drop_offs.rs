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
    drawing.line_list(("drop_offs", 0), BLOCKED, edges(grid));
    drawing.finish()
}

/// Two points for each straight piece of the borders.
fn edges(grid: &Grid<'_>) -> Vec<Point> {
    let spec = grid.spec();
    let (width, height) = (spec.width as usize, spec.height as usize);
    let is_edge = |a: usize, b: usize| {
        let drops = |floor: usize, other: usize| {
            grid.floor[floor] != 0 && grid.planning[floor] != 100 && grid.floor[other] == 0 && grid.planning[other] < 0
        };
        drops(a, b) || drops(b, a)
    };
    let mut points = Vec::new();
    for row in 1..height {
        let is_edge = |column: usize| is_edge((row - 1) * width + column, row * width + column);
        let ends = runs(width, is_edge).into_iter().flatten();
        points.extend(ends.map(|column| corner(&spec, column, row)));
    }
    for column in 1..width {
        let is_edge = |row: usize| is_edge(row * width + column - 1, row * width + column);
        let ends = runs(height, is_edge).into_iter().flatten();
        points.extend(ends.map(|row| corner(&spec, column, row)));
    }
    points
}

/// Begin and end of each run of places that have something, the end exclusive.
fn runs(n: usize, has: impl Fn(usize) -> bool) -> Vec<[usize; 2]> {
    let mut runs: Vec<[usize; 2]> = Vec::new();
    for at in (0..n).filter(|&at| has(at)) {
        match runs.last_mut() {
            Some([_, end]) if *end == at => *end = at + 1,
            _ => runs.push([at, at + 1]),
        }
    }
    runs
}

/// The lower left corner of a cell.
fn corner(spec: &GridSpec, column: usize, row: usize) -> Point {
    let origin = spec.origin_m();
    point([origin[0] + column as f64 * spec.resolution_m(), origin[1] + row as f64 * spec.resolution_m()])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_are_as_long_as_they_can_be() {
        let has = [true, true, false, true, false, false, true];
        assert_eq!(runs(has.len(), |at| has[at]), [[0, 2], [3, 4], [6, 7]]);
        assert!(runs(0, |_| true).is_empty());
    }
}
