//! Resampling of occupancy maps to the common cell size.

/// Maps are compared in cells of this size.
pub const CELL_M: f64 = 0.05;

/// Of a cell made from finer ones: the share that makes it occupied, else free.
const OCCUPIED_SHARE: f64 = 0.15;
const FREE_SHARE: f64 = 0.3;

/// Occupancy of a cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum Cell {
    /// Free.
    Free,
    /// Occupied.
    Occupied,
    /// Unknown.
    Unknown,
}

impl Cell {
    /// From the value of `nav_msgs/OccupancyGrid`: what is neither surely free nor surely occupied is unknown.
    pub fn of_occupancy(value: i8) -> Self {
        match value {
            0..=MAX_FREE => Self::Free,
            MIN_OCCUPIED.. => Self::Occupied,
            _ => Self::Unknown,
        }
    }

    /// As a value of `nav_msgs/OccupancyGrid`.
    pub fn occupancy(self) -> i8 {
        match self {
            Self::Free => 0,
            Self::Occupied => 100,
            Self::Unknown => -1,
        }
    }
}

/// Percent, as map servers have it.
const MAX_FREE: i8 = 25;
const MIN_OCCUPIED: i8 = 65;

/// Cells of [`CELL_M`], row-major from the lower left corner. Points on it are metres from that corner.
#[derive(Debug, Clone)]
pub struct Raster {
    /// Cells in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// All cells.
    pub cells: Vec<Cell>,
    /// Size of the cells that it was made from, in its own; at least 1.
    pub coarseness: f64,
}

impl Raster {
    /// From cells of another size, row-major from the lower left corner.
    pub fn of(cells: &[Cell], width: usize, resolution_m: f64) -> Self {
        let height = cells.len().checked_div(width).unwrap_or(0);
        let scale = CELL_M / resolution_m;
        let size = [width, height].map(|n| (n as f64 / scale - 1e-6).ceil().max(0.0) as usize);
        let mut out = Self {
            width: size[0],
            height: size[1],
            cells: Vec::with_capacity(size[0] * size[1]),
            coarseness: (1.0 / scale).max(1.0),
        };
        if (scale - 1.0).abs() < 1e-6 {
            out.cells.extend_from_slice(cells);
        } else if scale < 1.0 {
            // The middle of a last cell that sticks out lies beyond the map.
            let under = |k: usize, n: usize| (((k as f64 + 0.5) * scale) as usize).min(n - 1);
            for row in 0..size[1] {
                let from = under(row, height) * width;
                out.cells.extend((0..size[0]).map(|column| cells[from + under(column, width)]));
            }
        } else {
            let rows = shares(size[1], height, scale);
            let columns = shares(size[0], width, scale);
            for row in &rows {
                for column in &columns {
                    out.cells.push(mixed(cells, width, row, column));
                }
            }
        }
        out
    }

    /// The cell at a point; unknown outside.
    pub fn at(&self, point: [f64; 2]) -> Cell {
        self.index_at(point).map_or(Cell::Unknown, |index| self.cells[index])
    }

    /// The index of the cell at a point; `None` outside.
    #[inline]
    pub fn index_at(&self, [x, y]: [f64; 2]) -> Option<usize> {
        let (column, row) = (x / CELL_M, y / CELL_M);
        let inside = column >= 0.0 && row >= 0.0 && column < self.width as f64 && row < self.height as f64;
        inside.then(|| row as usize * self.width + column as usize)
    }

    /// The middle of a cell.
    pub fn middle(&self, index: usize) -> [f64; 2] {
        [(index % self.width) as f64 + 0.5, (index / self.width) as f64 + 0.5].map(|c| c * CELL_M)
    }
}

/// Of each of `n` larger cells: the smaller ones that it overlaps, each with its share.
fn shares(n: usize, n_small: usize, scale: f64) -> Vec<Vec<(usize, f64)>> {
    let of = |k: usize| {
        let (from, to) = (k as f64 * scale, ((k + 1) as f64 * scale).min(n_small as f64));
        let small = from as usize..(to.ceil() as usize).min(n_small);
        small.map(|s| (s, ((s + 1) as f64).min(to) - (s as f64).max(from))).map(|(s, part)| (s, part / scale)).collect()
    };
    (0..n).map(of).collect()
}

fn mixed(cells: &[Cell], width: usize, row: &[(usize, f64)], column: &[(usize, f64)]) -> Cell {
    let (mut occupied, mut free) = (0.0, 0.0);
    for &(r, high) in row {
        for &(c, wide) in column {
            match cells[r * width + c] {
                Cell::Occupied => occupied += high * wide,
                Cell::Free => free += high * wide,
                Cell::Unknown => {}
            }
        }
    }
    if occupied > OCCUPIED_SHARE {
        Cell::Occupied
    } else if free > FREE_SHARE {
        Cell::Free
    } else {
        Cell::Unknown
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn maps_of_any_size_and_resolution_keep_their_extent(
            width in 1usize..60,
            height in 1usize..60,
            resolution_m in prop_oneof![0.001..0.3f64, Just(0.05), Just(0.1), Just(0.5)],
        ) {
            let raster = Raster::of(&vec![Cell::Occupied; width * height], width, resolution_m);
            prop_assert_eq!(raster.cells.len(), raster.width * raster.height);
            for (cells, n) in [(raster.width, width), (raster.height, height)] {
                let beyond_m = cells as f64 * CELL_M - n as f64 * resolution_m;
                prop_assert!(-1e-6 < beyond_m && beyond_m < CELL_M + 1e-6);
            }
            let last = [raster.width, raster.height].map(|n| (n as f64 - 1.0) * CELL_M + 1e-6);
            // A map of a few millimetres does not fill a cell.
            let fills = [width, height].iter().all(|n| *n as f64 * resolution_m > CELL_M);
            prop_assert!(raster.at([0.0; 2]) == Cell::Occupied || !fills);
            prop_assert!(raster.at(last) == Cell::Occupied || resolution_m < CELL_M);
        }
    }

    #[test]
    fn a_thin_wall_survives_coarser_cells_and_a_coarse_map_finer_ones() {
        let mut cells = vec![Cell::Free; 50 * 50];
        (0..50).for_each(|row| cells[row * 50 + 24] = Cell::Occupied);
        let coarse = Raster::of(&cells, 50, 0.02);
        assert_eq!((coarse.width, coarse.height), (20, 20));
        for row in 0..20 {
            let occupied = (0..20).filter(|c| coarse.cells[row * 20 + c] == Cell::Occupied).collect::<Vec<_>>();
            assert_eq!(occupied, [9]);
        }
        let fine = Raster::of(&[Cell::Free, Cell::Occupied, Cell::Unknown, Cell::Free], 2, 0.1);
        assert_eq!((fine.width, fine.height), (4, 4));
        assert_eq!(fine.at([0.17, 0.03]), Cell::Occupied);
        assert_eq!(fine.at([0.03, 0.17]), Cell::Unknown);
        assert_eq!(fine.at([-0.01, 0.1]), Cell::Unknown);
    }
}
