//! Brute-force reference implementations of planning steps.

use frames::{Map, Point2};
use grid::Cell;
use messages::{Grid, ScanSensor, WaypointRecord};

/// A tenth of a millimetre is no obstacle.
pub(crate) const TOLERANCE_M: f64 = 1e-4;

/// Distance from a point to the middle of the nearest cell that is not free.
pub(crate) fn clearance_m(grid: &Grid<'_>, [x, y]: [f64; 2]) -> f64 {
    let spec = grid.spec();
    let stops = (0..spec.n_cells()).filter(|&c| grid.planning[c] != 0).map(|c| spec.centre_of(spec.cell_of(c)));
    stops.map(|c| (c.x_m() - x).hypot(c.y_m() - y)).fold(f64::INFINITY, f64::min)
}

/// Cells on which a robot of this radius can stand.
pub(crate) fn standing(grid: &Grid<'_>, radius_m: f64) -> Vec<bool> {
    let spec = grid.spec();
    let reach = (radius_m / spec.resolution_m()).ceil() as i64 + 1;
    let is_clear = |cell: usize| {
        let at = spec.cell_of(cell);
        let around = |c: u32, n: u32| (i64::from(c) - reach).max(0)..(i64::from(c) + reach + 1).min(i64::from(n));
        around(at.row, spec.height).all(|row| {
            around(at.column, spec.width).all(|column| {
                let d = [column - i64::from(at.column), row - i64::from(at.row)].map(|d| d as f64);
                let other = spec.index(Cell { column: column as u32, row: row as u32 });
                grid.planning[other] == 0 || d[0].hypot(d[1]) * spec.resolution_m() >= radius_m - TOLERANCE_M
            })
        })
    };
    (0..spec.n_cells()).map(|c| grid.planning[c] == 0 && grid.keepout[c] == -1 && is_clear(c)).collect()
}

/// The cells connected along sides with a cell.
pub(crate) fn flood(open: &[bool], width: usize, start: usize) -> Vec<bool> {
    let mut reached = vec![false; open.len()];
    reached[start] = true;
    let mut waiting = vec![start];
    while let Some(cell) = waiting.pop() {
        // A frame of nothing is around every drawing.
        for next in [cell - 1, cell + 1, cell - width, cell + width] {
            if open[next] && !reached[next] {
                reached[next] = true;
                waiting.push(next);
            }
        }
    }
    reached
}

/// The part of what a robot can stand on with the most cells of rooms; of equals the larger, then the one with the lowest cell.
pub(crate) fn first_part(grid: &Grid<'_>, open: &[bool]) -> Vec<bool> {
    let width = grid.spec().width as usize;
    let mut best = ((0, 0), vec![false; open.len()]);
    let mut left = open.to_vec();
    for start in 0..open.len() {
        if left[start] {
            let part = flood(open, width, start);
            let n_cells = part.iter().filter(|p| **p).count();
            let n_room_cells = part.iter().zip(grid.space).filter(|(p, space)| **p && **space != 0).count();
            let size = (n_room_cells, n_cells);
            left.iter_mut().zip(&part).for_each(|(l, p)| *l &= !p);
            if size > best.0 {
                best = (size, part);
            }
        }
    }
    best.1
}

/// True if a mark is on the cell at a point or on one beside it.
pub(crate) fn is_at_or_beside(grid: &Grid<'_>, marks: &[bool], [x, y]: [f64; 2]) -> bool {
    let spec = grid.spec();
    let cell = spec.index(spec.cell_at(Point2::<Map>::new(x, y)).unwrap());
    let w = spec.width as usize;
    [cell - w, cell, cell + w].into_iter().flat_map(|c| [c - 1, c, c + 1]).any(|c| marks[c])
}

/// A side of an occupied cell before which a cell is free; lengths in cells.
pub(crate) struct Side {
    pub(crate) cell: usize,
    pub(crate) front: usize,
    pub(crate) middle: [f64; 2],
    out: [f64; 2],
    normal: [f64; 2],
}

/// All sides of elements that look at free cells.
pub(crate) fn sides(grid: &Grid<'_>) -> Vec<Side> {
    let width = i64::from(grid.head.width);
    let mut sides = Vec::new();
    for cell in (0..grid.planning.len()).filter(|&c| grid.planning[c] == 100 && grid.class[c] != 0) {
        for [dx, dy] in [[1i64, 0], [-1, 0], [0, 1], [0, -1]] {
            let front = (cell as i64 + dx + dy * width) as usize;
            if grid.planning[front] != 0 {
                continue;
            }
            let out = [dx as f64, dy as f64];
            let at = [(cell as i64 % width) as f64 + 0.5, (cell as i64 / width) as f64 + 0.5];
            let middle = [0, 1].map(|k| at[k] + 0.501 * out[k]);
            sides.push(Side { cell, front, middle, out, normal: normal(grid, cell, front) });
        }
    }
    sides
}

/// Away from the cells of the 5 x 5 around the free one that are connected with the occupied one.
fn normal(grid: &Grid<'_>, cell: usize, front: usize) -> [f64; 2] {
    let width = i64::from(grid.head.width);
    let (x0, y0) = (front as i64 % width, front as i64 / width);
    let is_near = |c: i64| (c % width - x0).abs() <= 2 && (c / width - y0).abs() <= 2;
    let mut surface = vec![cell as i64];
    let mut next = 0;
    while next < surface.len() {
        let at = surface[next];
        next += 1;
        for step in [-1 - width, -width, 1 - width, -1, 1, width - 1, width, width + 1] {
            let other = at + step;
            let is_there = 0 <= other && (other as usize) < grid.planning.len();
            if is_there && is_near(other) && grid.planning[other as usize] == 100 && !surface.contains(&other) {
                surface.push(other);
            }
        }
    }
    let sum = surface.iter().fold([0.0; 2], |s, c| [s[0] - (c % width - x0) as f64, s[1] - (c / width - y0) as f64]);
    let length = sum[0].hypot(sum[1]);
    let out =
        [(front as i64 % width - cell as i64 % width) as f64, (front as i64 / width - cell as i64 / width) as f64];
    if length == 0.0 { out } else { sum.map(|c| c / length) }
}

/// True if a scan from a waypoint sees the side: step by step along the line.
pub(crate) fn sees(grid: &Grid<'_>, sensor: &ScanSensor, scan: &WaypointRecord, side: &Side) -> bool {
    let spec = grid.spec();
    let origin = spec.origin_m();
    let at = [0, 1].map(|k| (scan.position_in_map_m[k] - origin[k]) / spec.resolution_m());
    let d = [0, 1].map(|k| at[k] - side.middle[k]);
    let length = d[0].hypot(d[1]);
    let length_m = length * spec.resolution_m();
    let dot = |v: [f64; 2]| d[0] * v[0] + d[1] * v[1];
    let turn_rad = (libm::atan2(-d[1], -d[0]) - scan.yaw_rad).rem_euclid(std::f64::consts::TAU);
    let off_rad = turn_rad.min(std::f64::consts::TAU - turn_rad);
    if !(sensor.min_range_m..=sensor.range_m).contains(&length_m)
        || dot(side.out) <= 0.0
        || libm::acos((dot(side.normal) / length).clamp(-1.0, 1.0)) > sensor.max_incidence_rad
        || (!sensor.sees_around() && off_rad > sensor.field_of_view_rad / 2.0)
    {
        return false;
    }
    let n = (length * 50.0).ceil() as usize;
    (0..=n).all(|k| {
        let p = [0, 1].map(|c| side.middle[c] + d[c] * (k as f64 / n as f64));
        grid.planning[p[1] as usize * spec.width as usize + p[0] as usize] == 0
    })
}
