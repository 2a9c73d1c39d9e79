//! Length and slopes of a line over the ground of a storey.

use crate::free_space::FreeSpace;
use crate::path_search::length_m;
use frames::{Map, Point2};

/// Length and slopes of a line over the ground.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct WalkedLine {
    /// Along the slope.
    pub(crate) length_m: f64,
    /// Sum of all rises.
    pub(crate) climb_m: f64,
    /// Sum of all falls.
    pub(crate) descent_m: f64,
    /// Slope of the steepest ground under it.
    pub(crate) slope_rad: f64,
}

/// A line as a robot drives it: heights are taken once a cell, slopes are those of the cells under it.
pub(crate) fn walked(free_space: &FreeSpace, line: &[Point2<Map>]) -> WalkedLine {
    if free_space.is_level() {
        return WalkedLine { length_m: length_m(line), ..WalkedLine::default() };
    }
    let spec = &free_space.spec;
    let mut walked = WalkedLine::default();
    for Stretch { plan_m, rise_m } in stretches(free_space, line) {
        walked.length_m += libm::hypot(plan_m, rise_m);
        walked.climb_m += rise_m.max(0.0);
        walked.descent_m += (-rise_m).max(0.0);
    }
    for cell in line.windows(2).flat_map(|pair| once_a_cell(free_space, pair)).filter_map(|at| spec.cell_at(at)) {
        walked.slope_rad = walked.slope_rad.max(free_space.slope_rad(spec.index(cell)));
    }
    walked
}

/// A stretch of a line, of even slope.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Stretch {
    /// Its length in plan.
    pub(crate) plan_m: f64,
    /// How much higher it ends.
    pub(crate) rise_m: f64,
}

/// The stretches of a line: one a cell, between two corners one on a level storey.
pub(crate) fn stretches(free_space: &FreeSpace, line: &[Point2<Map>]) -> impl Iterator<Item = Stretch> {
    line.windows(2).flat_map(move |pair| {
        let points = if free_space.is_level() { pair.to_vec() } else { once_a_cell(free_space, pair) };
        let plan_m = pair[1].distance_m(&pair[0]) / (points.len() - 1) as f64;
        let z_m: Vec<f64> = points.iter().map(|at| free_space.z_between_m(*at)).collect();
        let rises_m: Vec<f64> = z_m.windows(2).map(|pair| pair[1] - pair[0]).collect();
        rises_m.into_iter().map(move |rise_m| Stretch { plan_m, rise_m })
    })
}

/// Points between two corners, from the one to the other, no farther apart than the side of a cell.
fn once_a_cell(free_space: &FreeSpace, pair: &[Point2<Map>]) -> Vec<Point2<Map>> {
    let n_steps = (pair[1].distance_m(&pair[0]) / free_space.spec.resolution_m()).ceil().max(1.0) as u32;
    let ([x0, y0], [x1, y1]) = (pair[0].coordinates_m(), pair[1].coordinates_m());
    let at = |k: u32| {
        let t = f64::from(k) / f64::from(n_steps);
        Point2::<Map>::new(x0 + t * (x1 - x0), y0 + t * (y1 - y0))
    };
    (0..=n_steps).map(at).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use messages::{ArchiveBuffer, Grid, GridHead, GridWriter};

    /// A strip of 60 by 5 cells of 0.1 m: two metres level, then two metres that rise by 10 %, then two metres level.
    fn hill() -> ArchiveBuffer {
        let head = GridHead { cell_tenths: 1_000, width: 60, height: 5, floor_z_tenths: 5_000, ..GridHead::EMPTY };
        let mut buffer = ArchiveBuffer::zeroed(GridWriter::len_with_heights(head.spec().n_cells()));
        let mut writer = GridWriter::new(buffer.bytes_mut(), &head);
        let layers = writer.layers();
        layers.planning.fill(0);
        layers.keepout.fill(-1);
        for cell in 0..layers.elevation.len() {
            let steps = (cell % 60) as i32 - 20;
            layers.elevation[cell] = 5_000 + (100 * steps + 50).clamp(0, 2_000);
            layers.slope[cell] = if (0..20).contains(&steps) { 100 } else { 0 };
        }
        writer.seal();
        buffer
    }

    #[test]
    fn a_line_over_a_hill_is_as_long_as_its_slope_and_climbs_as_far() {
        let buffer = hill();
        let free_space = FreeSpace::of(&Grid::open(buffer.bytes()).unwrap(), 0.1);
        let line = [Point2::new(0.25, 0.25), Point2::new(5.75, 0.25)];
        let up = walked(&free_space, &line);
        let expected_m = 3.5 + libm::hypot(2.0, 0.2);
        assert!((up.length_m - expected_m).abs() < 2e-3, "{up:?}");
        assert!((up.climb_m - 0.2).abs() < 1e-9 && up.descent_m == 0.0 && (up.slope_rad - 0.1).abs() < 1e-9, "{up:?}");
        let [a, b] = line;
        let down = walked(&free_space, &[b, a]);
        assert_eq!((down.climb_m, down.descent_m, down.slope_rad), (0.0, up.climb_m, up.slope_rad));
        assert!((down.length_m - up.length_m).abs() < 1e-9);
        let level = walked(&free_space, &[Point2::new(0.25, 0.25), Point2::new(1.75, 0.25)]);
        assert!((level.length_m - 1.5).abs() < 1e-9 && level.slope_rad == 0.0, "{level:?}");
    }

    #[test]
    fn a_line_along_a_slope_does_not_climb() {
        let head = GridHead { cell_tenths: 500, width: 200, height: 200, ..GridHead::EMPTY };
        let mut buffer = ArchiveBuffer::zeroed(GridWriter::len_with_heights(head.spec().n_cells()));
        let mut writer = GridWriter::new(buffer.bytes_mut(), &head);
        let layers = writer.layers();
        layers.planning.fill(0);
        layers.keepout.fill(-1);
        layers.slope.fill(200);
        // A plane that rises by a fifth at a right angle to the direction of 30 degrees.
        let (sin, cos) = (0.5, libm::sqrt(0.75));
        for cell in 0..layers.elevation.len() {
            let [x, y] = [cell % 200, cell / 200].map(|at| (at as f64 + 0.5) * 500.0);
            layers.elevation[cell] = (0.2 * (y * cos - x * sin)).round() as i32;
        }
        writer.seal();
        let free_space = FreeSpace::of(&Grid::open(buffer.bytes()).unwrap(), 0.1);
        let line = [Point2::new(0.5, 0.5), Point2::new(0.5 + 8.0 * cos, 0.5 + 8.0 * sin)];
        let along = walked(&free_space, &line);
        assert!(along.climb_m < 0.01 && along.descent_m < 0.01 && (along.length_m - 8.0).abs() < 1e-3, "{along:?}");
        let up = walked(&free_space, &[Point2::new(5.0, 1.0), Point2::new(5.0 - 3.0 * sin, 1.0 + 3.0 * cos)]);
        assert!((up.climb_m - 0.6).abs() < 2e-3 && up.descent_m < 1e-3, "{up:?}");
    }
}
