//! A grid in larger cells, where one in its own would be too large for a message.

use grid::GridSpec;

/// Larger cells over the part of a grid of which something is known.
pub(crate) struct LargerCells {
    /// Where they lie.
    pub(crate) spec: GridSpec,
    of: GridSpec,
    /// Cells of the grid along a side of a larger one.
    factor: i32,
}

impl LargerCells {
    /// The smallest whole multiples of the cells of a grid of which at most `max_cells` hold all that are known; `None` where
    /// cells of a metre are too many.
    pub(crate) fn within(of: GridSpec, is_known: impl Fn(usize) -> bool, max_cells: usize) -> Option<Self> {
        let (window, mut factor) = (known_window(&of, is_known), 1);
        loop {
            let spec = coarser(&of, window, factor)?;
            if spec.n_cells() <= max_cells {
                return Some(Self { spec, of, factor });
            }
            factor += 1;
        }
    }

    /// A layer in larger cells: what `join` makes of the values that each of them holds, `outside` for those outside of the grid.
    pub(crate) fn joined<T: Copy>(&self, layer: &[T], outside: T, join: impl Fn(&[T]) -> T) -> Vec<T> {
        let Self { spec, of, factor } = self;
        let (width, height) = (of.width.cast_signed(), of.height.cast_signed());
        let mut held = Vec::new();
        let cell = |index: usize| {
            let larger = [index % spec.width as usize, index / spec.width as usize].map(|n| n as i32);
            let first = [0, 1].map(|k| (spec.first_cell[k] + larger[k]) * factor - of.first_cell[k]);
            held.clear();
            held.extend((0..factor * factor).map(|k| {
                let [column, row] = [first[0] + k % factor, first[1] + k / factor];
                let is_inside = (0..width).contains(&column) && (0..height).contains(&row);
                if is_inside { layer[row as usize * width as usize + column as usize] } else { outside }
            }));
            join(&held)
        };
        (0..spec.n_cells()).map(cell).collect()
    }
}

/// Columns and rows, first and last, of the cells that are known; one cell if none is.
fn known_window(spec: &GridSpec, is_known: impl Fn(usize) -> bool) -> [[u32; 2]; 2] {
    let width = spec.width as usize;
    let known = (0..spec.n_cells()).filter(|&k| is_known(k)).map(|k| [(k % width) as u32, (k / width) as u32]);
    let window = known.fold(None, |window: Option<[[u32; 2]; 2]>, cell| {
        let [low, high] = window.unwrap_or([cell, cell]);
        Some([[0, 1].map(|k| low[k].min(cell[k])), [0, 1].map(|k| high[k].max(cell[k]))])
    });
    window.unwrap_or_default()
}

/// The grid over a window in cells that are so many times larger; `None` beyond a metre.
fn coarser(spec: &GridSpec, [low, high]: [[u32; 2]; 2], factor: i32) -> Option<GridSpec> {
    let cell_tenths = spec.cell_tenths.checked_mul(factor)?;
    GridSpec::cell_tenths_of(frames::metres(cell_tenths)).ok()?;
    let at = |cell: [u32; 2]| [0, 1].map(|k| (spec.first_cell[k] + cell[k].cast_signed()).div_euclid(factor));
    let (first_cell, last) = (at(low), at(high));
    let [width, height] = [0, 1].map(|k| (last[k] - first_cell[k] + 1).unsigned_abs());
    Some(GridSpec { cell_tenths, first_cell, width, height })
}
