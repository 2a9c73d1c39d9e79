//! Heights of the ground around each cell: those at which a robot stands that is beside what lies in the cell.
//!
//! A grid of which all floor is at one height has one band, that height, in all cells. In others a cell has the lowest and the highest
//! ground within three cells, in steps of 2 cm from the storey's height, rounded outward: an edge that is no floor of the map, between
//! ground and what stands beside it, is up to two cells wide, of which ground covers one in part and breaks off from the other. Up to
//! half a metre beside the ground, and at least three cells, it is that of the nearest cells with ground, and beyond that the height of
//! the storey, or none outdoors, where a storey has no height.

use frames::TENTHS_PER_M;
use grid::{CellRect, GridSpec, Run};
use messages::{ElementRecord, FloorKind, Grid};
use std::collections::BTreeMap;

/// Heights are rounded to steps of 2 cm.
const STEP: i32 = TENTHS_PER_M / 50;

/// How far beside the ground its height counts: what stands there is in the frame of a window, or at the edge of a hole.
const BESIDE: i32 = TENTHS_PER_M / 2;

/// Most cells of an edge between ground and what stands beside it.
const EDGE: i32 = 2;

/// Of cells around which there is no ground.
const NONE: u32 = u32::MAX;

/// The lowest and the highest ground around a cell, tenths of a millimetre in `map`.
pub(crate) type Band = [i32; 2];

/// The bands of all cells of a grid.
#[derive(Debug)]
pub(crate) struct LocalGround {
    spec: GridSpec,
    bands: Vec<Band>,
    /// Index of the band of each cell, or [`NONE`]; empty if all cells have the only band.
    of_cell: Vec<u32>,
    /// Cells with ground, and those of an edge beside it; empty if all cells have the only band.
    is_beside: Vec<bool>,
}

impl LocalGround {
    pub(crate) fn of(grid: &Grid<'_>) -> Self {
        let (spec, floor_z) = (grid.spec(), grid.head.floor_z_tenths);
        if grid.elevation.is_empty() {
            return Self { spec, bands: vec![[floor_z; 2]], of_cell: Vec::new(), is_beside: Vec::new() };
        }
        let mut around: Vec<Option<Band>> =
            (0..spec.n_cells()).map(|cell| grid.height_tenths(cell).map(|z| [z; 2])).collect();
        for _ in 0..EDGE {
            around = neighbours_joined(&spec, &around, true);
        }
        let is_beside = around.iter().map(Option::is_some).collect();
        around = neighbours_joined(&spec, &around, true);
        for _ in EDGE + 1..BESIDE / spec.cell_tenths {
            around = neighbours_joined(&spec, &around, false);
        }
        let beyond = (grid.head.floor != FloorKind::Ground).then_some([floor_z; 2]);
        let rounded = |[low, high]: Band| {
            let steps = [(low - floor_z).div_euclid(STEP), -(floor_z - high).div_euclid(STEP)];
            steps.map(|n| floor_z + n * STEP)
        };
        let mut known: BTreeMap<Band, u32> = BTreeMap::new();
        let mut bands = Vec::new();
        let mut index = |band: Band| {
            *known.entry(band).or_insert_with(|| {
                bands.push(band);
                bands.len() as u32 - 1
            })
        };
        let of_cell =
            around.into_iter().map(|band| band.or(beyond).map_or(NONE, |band| index(rounded(band)))).collect();
        Self { spec, bands, of_cell, is_beside }
    }

    /// True if all cells have one band.
    pub(crate) fn is_level(&self) -> bool {
        self.of_cell.is_empty()
    }

    /// True for a cell with ground or of an edge beside it, where the ground is not level. An edge from which it breaks off is no floor of
    /// a map, and what stands behind the edge is near all the same.
    pub(crate) fn is_beside(&self, cell: usize) -> bool {
        self.is_beside.get(cell).is_some_and(|is_beside| *is_beside)
    }

    /// The cells of an element that `cut` finds between the heights to which it is asked for the ground around them; sorted runs.
    ///
    /// `cut` gives the cells of all of the element for a band, and is asked for each band that there is in the rectangle.
    pub(crate) fn cells(&self, rect: CellRect, mut cut: impl FnMut(Band) -> Vec<Run>) -> Vec<Run> {
        if self.is_level() {
            return cut(self.bands[0]);
        }
        let width = self.spec.width as usize;
        let mut wanted: Vec<u32> = rect.rows(width).flatten().map(|cell| self.of_cell[cell]).collect();
        wanted.sort_unstable();
        wanted.dedup();
        let mut found = Vec::new();
        for band in wanted.into_iter().filter(|&band| band != NONE) {
            for run in cut(self.bands[band as usize]) {
                let cells = &self.of_cell[run.row as usize * width..][run.start as usize..run.end as usize];
                let mut start = run.start;
                for same in cells.chunk_by(|a, b| a == b) {
                    let end = start + same.len() as u32;
                    if same[0] == band {
                        found.push(Run { row: run.row, start, end });
                    }
                    start = end;
                }
            }
        }
        found.sort_unstable();
        found
    }

    /// The cells around an element and what of it lies between other corners, tenths of a millimetre.
    pub(crate) fn rect_of(&self, record: &ElementRecord, others: impl Iterator<Item = [f64; 2]>) -> CellRect {
        let GridSpec { cell_tenths, first_cell, width, height } = self.spec;
        let own = [record.min_tenths, record.max_tenths].map(|c| [f64::from(c[0]), f64::from(c[1])]);
        let all: Vec<[f64; 2]> = own.into_iter().chain(others).collect();
        let at = |k: usize, c: f64, beyond: f64| {
            let cell = (c / f64::from(cell_tenths)).floor() - f64::from(first_cell[k]) + beyond;
            cell.clamp(0.0, f64::from([width, height][k])) as u32
        };
        let end = |k: usize, pick: fn(f64, f64) -> f64, start: f64| all.iter().map(|p| p[k]).fold(start, pick);
        CellRect {
            min: [0, 1].map(|k| at(k, end(k, f64::min, f64::INFINITY), -1.0)),
            max: [0, 1].map(|k| at(k, end(k, f64::max, f64::NEG_INFINITY), 2.0)),
        }
    }
}

/// For each cell the range of those of its eight neighbours and its own; only for cells without one unless `all`.
fn neighbours_joined(spec: &GridSpec, bands: &[Option<Band>], all: bool) -> Vec<Option<Band>> {
    let (width, height) = (spec.width as usize, spec.height as usize);
    let joined = |cell: usize| {
        if !all && bands[cell].is_some() {
            return bands[cell];
        }
        let (column, row) = (cell % width, cell / width);
        let rows = row.saturating_sub(1)..(row + 2).min(height);
        let columns = column.saturating_sub(1)..(column + 2).min(width);
        let around = rows.flat_map(|row| columns.clone().map(move |column| row * width + column));
        around.filter_map(|cell| bands[cell]).reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])])
    };
    (0..bands.len()).map(joined).collect()
}
