//! Grid specification: resolution, origin and size.

use crate::cells::neighbours4;
use frames::{Map, Point2, TENTHS_PER_M, metres};
use geometry::Bounds;

/// Maximum number of cells of a grid.
pub const MAX_CELLS: u64 = 1 << 28;

/// Resolution, origin and size of a grid; the origin is a whole number of cells from the frame's origin.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct GridSpec {
    /// Side of a cell in tenths of a millimetre.
    pub cell_tenths: i32,
    /// Column and row of the lower left cell, counted from the frame's origin.
    pub first_cell: [i32; 2],
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
}

/// Column and row in a grid, from its lower left cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Cell {
    /// Column.
    pub column: u32,
    /// Row.
    pub row: u32,
}

/// Errors of grid specifications.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum GridSpecError {
    /// Cells are squares of whole tenths of a millimetre.
    #[error("resolution {resolution_m} m is not a whole number of tenths of a millimetre from 0.001 to 1")]
    Resolution {
        /// Requested resolution.
        resolution_m: f64,
    },
    /// A motion between frames under which places of a map are none of the other.
    #[error("the robot's map bends so much that it folds: places of the model's map lie nowhere in it")]
    Folded,
    /// More than [`MAX_CELLS`].
    #[error("a grid of {width} x {height} cells is larger than 2^28 cells{}", finest_text(*finest_m))]
    TooLarge {
        /// Columns.
        width: u64,
        /// Rows.
        height: u64,
        /// The finest resolution in which the same area has a grid.
        finest_m: Option<f64>,
    },
}

fn finest_text(finest_m: Option<f64>) -> String {
    finest_m.map_or_else(String::new, |finest_m| format!("; the finest resolution that works is {finest_m} m"))
}

impl GridSpec {
    /// The grid of `resolution_m` that holds the bounds and `margin_tenths` around them.
    ///
    /// # Errors
    /// A resolution that is no whole number of tenths of a millimetre, or too many cells.
    pub fn around(bounds: Bounds, margin_tenths: i32, resolution_m: f64) -> Result<Self, GridSpecError> {
        let cell = Self::cell_tenths_of(resolution_m)?;
        let margin = i64::from(margin_tenths);
        let extent = |cell: i32| {
            let first = bounds.min.map(|c| (i64::from(c) - margin).div_euclid(i64::from(cell)));
            let last = bounds.max.map(|c| (i64::from(c) + margin).div_euclid(i64::from(cell)));
            (first, [0, 1].map(|k| (last[k] - first[k] + 1) as u64))
        };
        let is_small = |cell: i32| extent(cell).1.iter().product::<u64>() <= MAX_CELLS;
        let (first, [width, height]) = extent(cell);
        if !is_small(cell) {
            let finest_m = (cell + 1..=TENTHS_PER_M).find(|cell| is_small(*cell)).map(metres);
            return Err(GridSpecError::TooLarge { width, height, finest_m });
        }
        Ok(Self { cell_tenths: cell, first_cell: first.map(|c| c as i32), width: width as u32, height: height as u32 })
    }

    /// The side of a cell in tenths of a millimetre.
    ///
    /// # Errors
    /// A resolution that is no whole number of tenths from 1 mm to 1 m.
    pub fn cell_tenths_of(resolution_m: f64) -> Result<i32, GridSpecError> {
        let tenths = (resolution_m * f64::from(TENTHS_PER_M)).round();
        let whole = (tenths - resolution_m * f64::from(TENTHS_PER_M)).abs() < 1e-6;
        if whole && (10.0..=f64::from(TENTHS_PER_M)).contains(&tenths) {
            Ok(tenths as i32)
        } else {
            Err(GridSpecError::Resolution { resolution_m })
        }
    }

    /// Metres per cell.
    pub fn resolution_m(&self) -> f64 {
        metres(self.cell_tenths)
    }

    /// Lower left corner of the lower left cell, in metres.
    pub fn origin_m(&self) -> [f64; 2] {
        // One rounding: the nearest number to the exact decimal.
        self.first_cell.map(|c| (i64::from(c) * i64::from(self.cell_tenths)) as f64 / f64::from(TENTHS_PER_M))
    }

    /// Number of cells.
    pub fn n_cells(&self) -> usize {
        self.width as usize * self.height as usize
    }

    /// Index of a cell in row-major layers.
    pub fn index(&self, cell: Cell) -> usize {
        cell.row as usize * self.width as usize + cell.column as usize
    }

    /// The cell at an index of row-major layers.
    pub fn cell_of(&self, index: usize) -> Cell {
        Cell { column: (index % self.width as usize) as u32, row: (index / self.width as usize) as u32 }
    }

    /// The cells along the sides of a cell, by their indices.
    pub fn beside(&self, index: usize) -> impl Iterator<Item = usize> + use<> {
        neighbours4(index, self.width as usize, self.n_cells())
    }

    /// The cell that holds the point; `None` outside the grid.
    pub fn cell_at(&self, p: Point2<Map>) -> Option<Cell> {
        let place = |k: usize, m: f64| {
            let c = (m / self.resolution_m()).floor() - f64::from(self.first_cell[k]);
            let n = if k == 0 { self.width } else { self.height };
            (0.0 <= c && c < f64::from(n)).then_some(c as u32)
        };
        Some(Cell { column: place(0, p.x_m())?, row: place(1, p.y_m())? })
    }

    /// The middle of a cell.
    pub fn centre_of(&self, cell: Cell) -> Point2<Map> {
        let middle = |k: usize, c: u32| {
            let doubled = 2 * (i64::from(self.first_cell[k]) + i64::from(c)) + 1;
            (doubled * i64::from(self.cell_tenths)) as f64 / f64::from(2 * TENTHS_PER_M)
        };
        Point2::new(middle(0, cell.column), middle(1, cell.row))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn spec() -> GridSpec {
        GridSpec::around(Bounds { min: [-12_345, 0], max: [40_000, 20_000] }, 10_000, 0.05).unwrap()
    }

    #[test]
    fn the_origin_is_a_multiple_of_the_resolution_and_below_the_margin() {
        assert_eq!(spec().origin_m(), [-2.25, -1.0]);
        assert_eq!((spec().width, spec().height), (146, 81));
    }

    #[test]
    fn the_centre_of_every_cell_lies_in_it() {
        let spec = spec();
        for index in 0..spec.n_cells() {
            let cell = spec.cell_of(index);
            assert_eq!(spec.cell_at(spec.centre_of(cell)), Some(cell));
            assert_eq!(spec.index(cell), index);
        }
        assert_eq!(spec.cell_at(Point2::new(-2.3, 0.0)), None);
    }

    #[test]
    fn the_finest_resolution_that_is_told_works_and_the_next_finer_one_does_not() {
        let bounds = Bounds { min: [-70_000, 0], max: [190_000, 170_000] };
        let Err(GridSpecError::TooLarge { finest_m: Some(finest_m), .. }) = GridSpec::around(bounds, 20_000, 0.001)
        else {
            panic!("it is too large")
        };
        assert!(GridSpec::around(bounds, 20_000, finest_m).is_ok());
        assert!(GridSpec::around(bounds, 20_000, finest_m - 0.0001).is_err());
    }

    #[test]
    fn odd_resolutions_and_huge_grids_are_refused() {
        assert!(matches!(GridSpec::cell_tenths_of(0.033_33), Err(GridSpecError::Resolution { .. })));
        assert!(matches!(GridSpec::cell_tenths_of(0.0), Err(GridSpecError::Resolution { .. })));
        assert!(matches!(GridSpec::cell_tenths_of(f64::NAN), Err(GridSpecError::Resolution { .. })));
        assert_eq!(GridSpec::cell_tenths_of(0.0125), Ok(125));
        let far = Bounds { min: [0, 0], max: [1_000_000_000, 1_000_000_000] };
        assert!(matches!(GridSpec::around(far, 0, 0.05), Err(GridSpecError::TooLarge { finest_m: None, .. })));
    }
}
