//! Edges of floor at which a stair leads down: the cells without floor over a stair that comes from below, and the gap around it.

use crate::local_ground::Band;
use crate::rule_elements::StoreyElements;
use frames::TENTHS_PER_M;
use geometry::Slab;
use grid::{CellRect, Class, Run, fifths_of, grow_labelled};
use messages::ElementRecord;

/// A stair leads down where it reaches so far below the floor.
const MIN_DEPTH: i32 = TENTHS_PER_M / 10;

/// Widest gap between a stair and the edge of the opening in which it lies, metres.
const GAP_M: f64 = 0.5;

/// The stairs that lead down from the storey, each with the cells that have no floor over it.
pub(crate) fn stair_edges(storey: StoreyElements<'_>) -> Vec<(u32, Vec<Run>)> {
    let (spec, grid) = (storey.spec(), storey.grid);
    let stairs = (0..)
        .zip(storey.site.elements)
        .filter(|(element, record)| record.class() == Class::Stair && record.n_parts > 0 && storey.is_there(*element));
    let is_void = |cell: usize| grid.floor[cell] == 0 && grid.planning[cell] < 0;
    let plans: Vec<(u32, Vec<Run>)> = stairs
        .map(|(element, record)| {
            let rect = storey.ground.rect_of(record, std::iter::empty());
            let runs = storey.ground.cells(rect, |band| below_ground(storey, record, band));
            (element, without_floor(storey, &runs))
        })
        .collect();
    let seeds = plans.iter().map(|(element, runs)| (*element, runs.as_slice()));
    let whole = CellRect::whole(spec.width, spec.height);
    let around = grow_labelled(whole, is_void, seeds, fifths_of(GAP_M / spec.resolution_m()));
    let mut edges: Vec<(u32, Vec<Run>)> = plans;
    for (cell, nearest) in around.iter().enumerate() {
        let Some(nearest) = nearest else { continue };
        let at = spec.cell_of(cell);
        let run = Run { row: at.row, start: at.column, end: at.column + 1 };
        if let Some((_, runs)) = edges.iter_mut().find(|(element, _)| *element == nearest.label) {
            runs.push(run);
        }
    }
    edges.retain(|(_, runs)| !runs.is_empty());
    edges
}

/// Cells of a stair that leads down from ground in a band, as far as the next floor below; none of one that does not lead down.
fn below_ground(storey: StoreyElements<'_>, record: &ElementRecord, [_, highest]: Band) -> Vec<Run> {
    let lower = storey.site.levels().map(|(_, s)| s.floor_z_tenths).filter(|z| *z <= highest - MIN_DEPTH);
    let below = lower.max().unwrap_or(i32::MIN);
    let slab = Slab { lo: record.min_tenths[2].max(below), hi: highest + storey.grid.head.slab_tenths[0].max(1) };
    let leads_down = record.min_tenths[2] <= highest - MIN_DEPTH && below < record.max_tenths[2];
    if leads_down && slab.lo < slab.hi { storey.cut(record, slab) } else { Vec::new() }
}

/// Cells of runs on which there is no floor of the storey.
fn without_floor(storey: StoreyElements<'_>, runs: &[Run]) -> Vec<Run> {
    let width = storey.spec().width as usize;
    let cells = runs.iter().flat_map(|run| (run.start..run.end).map(move |column| (run.row, column)));
    cells
        .filter(|(row, column)| storey.grid.floor[*row as usize * width + *column as usize] == 0)
        .map(|(row, column)| Run { row, start: column, end: column + 1 })
        .collect()
}
