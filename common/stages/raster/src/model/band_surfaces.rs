//! Surfaces above each other in a band of rows, by rectangles of cells that have the same.

use grid::{CellRect, Run};
use messages::NONE;
use std::ops::Range;

/// Marks a surface on which a body of ground stands in the way.
pub(crate) const FILLED: u32 = 1 << 31;

/// Rows of cells whose surfaces are looked at with the same patches.
const BAND_ROWS: u32 = 64;

/// The bands of a rectangle, in their order.
pub(crate) fn bands(rect: &CellRect) -> impl Iterator<Item = CellRect> + use<> {
    let CellRect { min, max } = *rect;
    let band = move |first: u32| CellRect { min: [min[0], first], max: [max[0], max[1].min(first + BAND_ROWS)] };
    (min[1]..max[1]).step_by(BAND_ROWS as usize).map(band)
}

/// Looks for the surfaces of bands; its buffers serve for many.
#[derive(Debug, Default)]
pub(crate) struct BandSurfaces {
    /// Those of a band, each with its next run.
    sources: Vec<(Source, usize)>,
    /// Of a row, source by source.
    ends: Vec<End>,
    /// Of the row behind those that are alike.
    next_ends: Vec<End>,
    /// Of a row, from left to right.
    sorted: Vec<End>,
    /// Surfaces of a stretch or beside it, ascending.
    active: Vec<Active>,
    /// Surfaces of a stretch.
    surfaces: Vec<u32>,
}

/// A surface, or a body that stands on it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Source {
    pub(crate) surface: u32,
    /// The number of the body; [`NONE`] for the surface itself.
    pub(crate) body: u32,
}

/// An end of a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct End {
    column: u32,
    surface: u32,
    is_body: bool,
    is_begin: bool,
}

/// How many runs of a surface, and of bodies on it, go on.
#[derive(Debug)]
struct Active {
    surface: u32,
    n_runs: u32,
    n_bodies: u32,
}

impl BandSurfaces {
    /// Calls `each` with rectangles that make up a band, from its first row on, and the surfaces of their cells, ascending, with
    /// [`FILLED`] where a body stands on them. `runs` are the sorted runs of each source.
    pub(crate) fn rects<'r>(
        &mut self,
        band: &CellRect,
        sources: impl Iterator<Item = Source>,
        runs: impl Fn(Source) -> &'r [Run],
        mut each: impl FnMut(CellRect, &[u32]),
    ) {
        self.sources.clear();
        let first_run = |source: Source| runs(source).partition_point(|run| run.row < band.min[1]);
        self.sources.extend(sources.map(|source| (source, first_run(source))));
        let columns = band.min[0]..band.max[0];
        let mut first = band.min[1];
        self.find_next_ends(&runs, first, &columns);
        for row in band.min[1] + 1..=band.max[1] {
            if row == first + 1 {
                std::mem::swap(&mut self.ends, &mut self.next_ends);
            }
            if row < band.max[1] {
                self.find_next_ends(&runs, row, &columns);
                if self.ends == self.next_ends {
                    continue;
                }
            }
            self.stretches(&columns, |columns, surfaces| {
                each(CellRect { min: [columns.start, first], max: [columns.end, row] }, surfaces);
            });
            first = row;
        }
    }

    /// Finds the ends of the runs of a row, each row once and in their order.
    fn find_next_ends<'r>(&mut self, runs: &impl Fn(Source) -> &'r [Run], row: u32, columns: &Range<u32>) {
        let Self { sources, next_ends, .. } = self;
        next_ends.clear();
        for (source, next) in sources {
            let runs = runs(*source);
            while let Some(run) = runs.get(*next).filter(|run| run.row == row) {
                *next += 1;
                let (start, end) = (run.start.max(columns.start), run.end.min(columns.end));
                if start < end {
                    let Source { surface, body } = *source;
                    let begin = End { column: start, surface, is_body: body != NONE, is_begin: true };
                    next_ends.extend([begin, End { column: end, is_begin: false, ..begin }]);
                }
            }
        }
    }

    /// Calls `each` with the stretches of a row between ends, from left to right, and their surfaces.
    fn stretches(&mut self, columns: &Range<u32>, mut each: impl FnMut(Range<u32>, &[u32])) {
        let Self { ends, sorted, active, surfaces, .. } = self;
        sorted.clone_from(ends);
        sorted.sort_unstable_by_key(|end| end.column);
        active.clear();
        let mut from = columns.start;
        for at_column in sorted.chunk_by(|a, b| a.column == b.column) {
            let column = at_column[0].column;
            if from < column {
                surfaces.clear();
                let of_stretch = active.iter().filter(|active| active.n_runs > 0);
                surfaces.extend(of_stretch.map(|a| a.surface | if a.n_bodies > 0 { FILLED } else { 0 }));
                each(from..column, surfaces);
                from = column;
            }
            // Those that begin first: no count falls below 0.
            for begins in [true, false] {
                for end in at_column.iter().filter(|end| end.is_begin == begins) {
                    let at = active.partition_point(|active| active.surface < end.surface);
                    if active.get(at).is_none_or(|active| active.surface != end.surface) {
                        active.insert(at, Active { surface: end.surface, n_runs: 0, n_bodies: 0 });
                    }
                    let Active { n_runs, n_bodies, .. } = &mut active[at];
                    let n = if end.is_body { n_bodies } else { n_runs };
                    *n = if begins { *n + 1 } else { *n - 1 };
                }
            }
            active.retain(|active| active.n_runs + active.n_bodies > 0);
        }
        if from < columns.end {
            each(from..columns.end, &[]);
        }
    }
}
