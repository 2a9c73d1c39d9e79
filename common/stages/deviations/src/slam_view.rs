//! A SLAM map in `map` coordinates: cell lookup and probing along a line.

use crate::input::DeviationInput;
use crate::thresholds::{BEYOND_M, DEEP_M, FREE_SHARE, FRONT_M, MIN_CELL_M, REACH_M};
use frames::{BentMotion, Map, Rigid2, Slam};
use grid::PlaceLattice;
use messages::SlamFrame;
use occupancy::{Cell, Raster};
use rayon::prelude::*;
use std::borrow::Cow;

/// Side of the squares within which a SLAM map is taken for straight, in metres: bends reach over several.
const SQUARE_M: f64 = 0.5;

/// The frame of a SLAM map's cells: metres from its lower left corner, along its rows and columns.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Cells {}

/// A SLAM map as it lies in the model's map.
pub(crate) struct SlamView<'a> {
    pub(crate) cells: Vec<Cell>,
    pub(crate) width: usize,
    pub(crate) cell_m: f64,
    slam_from_cells: Rigid2<Slam, Cells>,
    motion: Cow<'a, BentMotion<Map, Slam>>,
    whole: Rigid2<Map, Slam>,
    /// Where places in `map` lie in the SLAM map.
    in_slam: PlaceLattice,
}

/// A probe along the inward normal of a side.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Probe {
    pub(crate) at: [f64; 2],
    pub(crate) normal: [f64; 2],
    pub(crate) thick_m: f64,
    /// Surfaces nearer than this are the side itself.
    pub(crate) tolerance_m: f64,
}

/// The result of a probe.
#[derive(Debug, Clone, Default)]
pub(crate) struct ProbeResult {
    /// Offsets along the outward normal of surfaces with the same orientation as the side.
    pub(crate) offsets_m: Vec<f64>,
    /// True if the robot saw through the solid.
    pub(crate) through: bool,
    /// Depth of the first surface behind the side, if all before it is free.
    pub(crate) free_m: Option<f64>,
}

impl<'a> SlamView<'a> {
    /// `bounds_m` are the lower left and upper right corner of what is looked at, in `map`.
    pub(crate) fn of(input: &DeviationInput<'a>, bounds_m: [[f64; 2]; 2]) -> Self {
        let (map, motion) = (input.slam, input.motion());
        let slam_from_cells = Rigid2::of_x_y_yaw(map.origin);
        let (mut cells, width, cell_m) = if map.resolution_m < MIN_CELL_M * 0.99 {
            let raster = Raster::of(&map.cells, map.width, map.resolution_m);
            (raster.cells, raster.width, MIN_CELL_M)
        } else {
            (map.cells.clone(), map.width, map.resolution_m)
        };
        forget_unknown_places(&mut cells, width, cell_m, &slam_from_cells, input.slam_frame);
        let size_m = [width, cells.len().checked_div(width).unwrap_or(0)].map(|n| n as f64 * cell_m);
        let [low, high] = extent_m(&slam_from_cells, size_m, &motion);
        let low = [0, 1].map(|k| low[k].max(bounds_m[0][k]));
        let size_m = [0, 1].map(|k| (high[k].min(bounds_m[1][k]) - low[k]).max(0.0));
        let in_slam = PlaceLattice::over(low, size_m, SQUARE_M, |place| motion.apply_inverse(place));
        Self { cells, width, cell_m, slam_from_cells, motion, whole: input.slam_frame.map_from_slam(), in_slam }
    }

    pub(crate) fn height(&self) -> usize {
        self.cells.len().checked_div(self.width).unwrap_or(0)
    }

    /// The cell at a point in `map`; unknown outside.
    pub(crate) fn at(&self, place: [f64; 2]) -> Cell {
        let Some(in_slam) = self.in_slam.at(place) else { return Cell::Unknown };
        let [x, y] = self.slam_from_cells.apply_inverse(in_slam).map(|c| (c / self.cell_m).floor());
        let inside = x >= 0.0 && y >= 0.0 && x < self.width as f64;
        let cell = if inside { self.cells.get(y as usize * self.width + x as usize) } else { None };
        cell.copied().unwrap_or(Cell::Unknown)
    }

    /// The middle of a cell in `map`.
    pub(crate) fn middle(&self, index: usize) -> [f64; 2] {
        let [column, row] = [index % self.width, index / self.width];
        self.in_map([column, row].map(|c| c as f64 + 0.5))
    }

    /// Where a place that is given in cells from the lower left corner lies in `map`.
    pub(crate) fn in_map(&self, in_cells: [f64; 2]) -> [f64; 2] {
        self.motion.apply(self.slam_from_cells.apply(in_cells.map(|c| c * self.cell_m)))
    }

    /// How far the SLAM map is off at a place in `map` from where its pose as a whole puts it, if it is off by this much from where its
    /// frame puts it; as by its frame where the SLAM map does not reach.
    pub(crate) fn off_whole_m(&self, at: [f64; 2], off_frame_m: [f64; 2]) -> [f64; 2] {
        let seen_at = [0, 1].map(|k| at[k] + off_frame_m[k]);
        let by_whole = self.in_slam.at(seen_at).map_or(seen_at, |in_slam| self.whole.apply(in_slam));
        [0, 1].map(|k| by_whole[k] - at[k])
    }

    /// Probes along the normal of a side from outside to behind it, on three lines a cell apart, because sparsely hit walls
    /// have gaps.
    pub(crate) fn probe(&self, probe: &Probe) -> ProbeResult {
        let lines = [0.0, -self.cell_m, self.cell_m].map(|aside_m| self.line(probe, aside_m));
        let through = probe.thick_m >= self.cell_m
            && self.is_free(&lines[0], probe)
            && self.goes_on(&lines[0], probe)
            && !lines[1..].iter().any(|line| self.span(line, probe).contains(&Cell::Occupied));
        let offsets_m = lines.iter().map(|line| self.surfaces(line)).find(|s| !s.is_empty()).unwrap_or_default();
        ProbeResult { offsets_m, through, free_m: self.free_m(&lines) }
    }

    /// Depth behind the side at which the first line meets a surface, if the middle line is free up to there.
    fn free_m(&self, lines: &[Vec<Cell>; 3]) -> Option<f64> {
        let from = (REACH_M / self.step_m()).round() as usize;
        let meets = |line: &Vec<Cell>| line.iter().skip(from).position(|c| *c == Cell::Occupied);
        let n = lines.iter().filter_map(meets).min()?;
        let free = lines[0].iter().skip(from).take(n).filter(|c| **c == Cell::Free).count();
        (n > 0 && free as f64 >= FREE_SHARE * n as f64).then(|| (n as f64 + 0.5) * self.step_m() - FRONT_M)
    }

    fn step_m(&self) -> f64 {
        self.cell_m / 2.0
    }

    /// Cells from the farthest place outside inward.
    fn line(&self, probe: &Probe, aside_m: f64) -> Vec<Cell> {
        let Probe { at, normal, thick_m, tolerance_m } = *probe;
        let length_m = REACH_M + FRONT_M + REACH_M.max(thick_m.min(DEEP_M) + 2.0 * tolerance_m + BEYOND_M);
        let n = (length_m / self.step_m()).ceil() as usize;
        let at = [at[0] - normal[1] * aside_m, at[1] + normal[0] * aside_m];
        let place = |k: usize| {
            let out_m = REACH_M + FRONT_M - k as f64 * self.step_m();
            [at[0] + normal[0] * out_m, at[1] + normal[1] * out_m]
        };
        (0..n).map(|k| self.at(place(k))).collect()
    }

    /// True if a line goes on as free behind the solid, or ends at a surface there: beams have an end. Free cells before
    /// unknown ones are what is left of a wall whose hits are spread.
    fn goes_on(&self, line: &[Cell], probe: &Probe) -> bool {
        let to = self.span(line, probe).len() + self.index(FRONT_M);
        let beyond = line[to.min(line.len())..].iter().take((BEYOND_M / self.step_m()).round() as usize);
        let before_surface: Vec<&Cell> = beyond.take_while(|c| **c != Cell::Occupied).collect();
        let free = before_surface.iter().filter(|c| ***c == Cell::Free).count();
        free as f64 >= FREE_SHARE * before_surface.len() as f64
    }

    /// Where a line is that far outside of the side.
    fn index(&self, out_m: f64) -> usize {
        ((REACH_M + FRONT_M - out_m) / self.step_m()).round() as usize
    }

    /// The part of a line from before the side to behind the solid, or deep inside of it.
    fn span<'l>(&self, line: &'l [Cell], probe: &Probe) -> &'l [Cell] {
        let behind_m = probe.thick_m.min(DEEP_M) + probe.tolerance_m;
        let (from, to) = (self.index(FRONT_M), self.index(-behind_m));
        &line[from.min(line.len())..to.min(line.len())]
    }

    fn is_free(&self, line: &[Cell], probe: &Probe) -> bool {
        let span = self.span(line, probe);
        let free = span.iter().filter(|c| **c == Cell::Free).count();
        !span.contains(&Cell::Occupied) && free as f64 >= FREE_SHARE * span.len() as f64 && free > 0
    }

    /// Offsets at which a line enters occupied cells from free ones. Behind the side it must be free all the way from before it:
    /// what stands in the next room is seen from there, and no view of this side. A surface lies in the middle of the cell that shows it;
    /// noise spreads it over two at most.
    fn surfaces(&self, line: &[Cell]) -> Vec<f64> {
        let (step_m, front) = (self.step_m(), (FRONT_M / self.step_m()) as usize);
        let side = (REACH_M / step_m).round() as usize;
        let mut found = Vec::new();
        for k in 1..line.len() {
            if line[k] != Cell::Occupied || line[k - 1] == Cell::Occupied {
                continue;
            }
            let before = line[k.saturating_sub(front)..k].iter().rev();
            let comes_from_free = before.take_while(|c| **c != Cell::Occupied).any(|c| *c == Cell::Free);
            let enters_m = REACH_M + FRONT_M - (k as f64 - 0.5) * step_m;
            let passed = &line[side.min(k)..k];
            let n_free = passed.iter().filter(|c| **c == Cell::Free).count();
            let is_open = !passed.contains(&Cell::Occupied) && n_free as f64 >= FREE_SHARE * passed.len() as f64;
            if comes_from_free && is_open {
                let run = line[k..].iter().take_while(|c| **c == Cell::Occupied).count().min(4);
                found.push(enters_m - run as f64 * step_m / 2.0);
            }
        }
        found.retain(|d| d.abs() <= REACH_M);
        found
    }
}

/// Cells of places of which is not known where they lie are not known.
fn forget_unknown_places(
    cells: &mut [Cell],
    width: usize,
    cell_m: f64,
    slam_from_cells: &Rigid2<Slam, Cells>,
    frame: &SlamFrame,
) {
    let side_cells = (SQUARE_M / cell_m).ceil() as usize;
    let n_columns = width.div_ceil(side_cells);
    let n_rows = cells.len().checked_div(width).unwrap_or(0).div_ceil(side_cells);
    let is_known = |square: usize| {
        let middle = [square % n_columns, square / n_columns].map(|n| (n as f64 + 0.5) * side_cells as f64 * cell_m);
        frame.is_known_at(slam_from_cells.apply(middle))
    };
    let is_known: Vec<bool> = (0..n_columns * n_rows).into_par_iter().map(is_known).collect();
    for (index, cell) in cells.iter_mut().enumerate() {
        if !is_known[index / width / side_cells * n_columns + index % width / side_cells] {
            *cell = Cell::Unknown;
        }
    }
}

/// Lower left and upper right corner of a SLAM map in `map`, in metres; and a metre around it, since it bends.
fn extent_m(slam_from_cells: &Rigid2<Slam, Cells>, size_m: [f64; 2], motion: &BentMotion<Map, Slam>) -> [[f64; 2]; 2] {
    let n_steps = size_m.map(|length_m| length_m.ceil() as usize);
    let along = |axis: usize| (0..=n_steps[axis]).map(move |k| (k as f64).min(size_m[axis]));
    let border =
        along(0).flat_map(|x| [[x, 0.0], [x, size_m[1]]]).chain(along(1).flat_map(|y| [[0.0, y], [size_m[0], y]]));
    let border = border.map(|place| motion.apply(slam_from_cells.apply(place)));
    border.fold([[f64::MAX; 2], [f64::MIN; 2]], |[low, high], p| {
        [[0, 1].map(|k| low[k].min(p[k] - 1.0)), [0, 1].map(|k| high[k].max(p[k] + 1.0))]
    })
}
