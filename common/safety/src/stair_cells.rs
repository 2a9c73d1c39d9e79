//! Stairs on which the robot drives: the cells that show a tread, by the element that it belongs to.

use crate::rule_elements::StoreyElements;
use geometry::treads;
use grid::{CellRect, Class, Run, overlapped_cells};
use messages::GroundClass;

/// Treads whose heights differ by less are one: heights are whole tenths of a millimetre.
const SAME_HEIGHT: u32 = 5;

/// The stairs that are there, each with the cells in which the map shows a tread of it.
pub(crate) fn stair_cells(storey: StoreyElements<'_>) -> Vec<(u32, Vec<Run>)> {
    let (spec, grid) = (storey.spec(), storey.grid);
    let whole = CellRect::whole(spec.width, spec.height);
    let stairs = (0..).zip(storey.site.elements).filter(|(element, record)| {
        record.ground == GroundClass::StairTread && record.n_parts > 0 && storey.is_there(*element)
    });
    let cells = |(element, record)| {
        let mut runs = Vec::new();
        for tread in treads(storey.site.element_meshes(record)) {
            let shows = |cell: usize| {
                grid.class_of(cell) == Class::Stair
                    && grid.planning[cell] == 0
                    && grid.height_tenths(cell).is_some_and(|z| z.abs_diff(tread.z) <= SAME_HEIGHT)
            };
            let plan = overlapped_cells(&tread.plan, &[], &spec);
            let cells = whole.clip(&plan, spec.width as usize).flatten();
            runs.extend(cells.filter(|&cell| shows(cell)).map(|cell| {
                let at = spec.cell_of(cell);
                Run { row: at.row, start: at.column, end: at.column + 1 }
            }));
        }
        (element, runs)
    };
    stairs.map(cells).filter(|(_, runs)| !runs.is_empty()).collect()
}
