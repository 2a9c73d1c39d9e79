//! Elements built since a time, and their cells.

use geometry::{Slab, footprint};
use grid::overlapped_cells;
use messages::{ElementState, Grid, ScheduleState, ScheduleStateHead, Site};

/// Elements that are built now and were finished after a time, ascending.
pub(crate) fn changed_elements(site: &Site<'_>, schedule_state: &ScheduleState<'_>, since_s: i64) -> Vec<usize> {
    let is_new = |&element: &usize| {
        let finish_s = schedule_state.schedule_of(element).finish_s;
        schedule_state.effective(element) == ElementState::Built
            && finish_s != ScheduleStateHead::NO_TIME
            && finish_s > since_s
    };
    (0..site.elements.len()).filter(is_new).collect()
}

/// Cells that the elements overlap in the slab of a map storey.
pub(crate) fn cells_of(site: &Site<'_>, grid: &Grid<'_>, elements: &[usize]) -> Vec<bool> {
    let spec = grid.spec();
    let [lo, hi] = grid.head.slab_tenths;
    let mut cells = vec![false; spec.n_cells()];
    for &element in elements {
        let plan = footprint(site.element_meshes(&site.elements[element]), Slab { lo, hi });
        for run in overlapped_cells(&plan.area, &plan.lines, &spec) {
            let line = run.row as usize * spec.width as usize;
            cells[line + run.start as usize..line + run.end as usize].fill(true);
        }
    }
    cells
}
