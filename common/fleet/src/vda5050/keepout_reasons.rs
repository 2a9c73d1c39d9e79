//! Reasons of keep-out cells of a map: a closed room, work, or no floor at its level.

use export::ExportInput;
use geometry::{Slab, SlabCut};
use grid::{CellRect, Class, Run, cells_of_cut, fifths_of, grow_labelled};
use messages::{ElementState, FloorKind, Grid, SpaceState};

/// Least height of a storey, as maps take it: a nearer floor is another level of the same one.
const MIN_STOREY_HEIGHT: i32 = 2 * frames::TENTHS_PER_M;

/// Why a robot must not enter a cell. Where several hold, the first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum KeepoutReason {
    /// In this space, which is closed.
    ClosedRoom(u32),
    /// Below this element, which is worked on, or within the margin around it.
    Work(u32),
    /// No floor at the level of the map, or within the margin around that.
    DropOff,
}

/// The reason of each cell of a grid; `None` where it is not keep-out.
pub(super) fn keepout_reasons(input: &ExportInput<'_>, grid: &Grid<'_>) -> Vec<Option<KeepoutReason>> {
    let work = nearest_work(input, grid);
    let closed_room = |cell: usize| {
        let space = u32::from(grid.space[cell]).checked_sub(1)?;
        let state = input.schedule_state.spaces.get(space as usize)?.state.get();
        (state == SpaceState::Blocked).then_some(KeepoutReason::ClosedRoom(space))
    };
    let reason = |cell: usize| {
        let of_work = || work[cell].map(KeepoutReason::Work);
        closed_room(cell).or_else(of_work).unwrap_or(KeepoutReason::DropOff)
    };
    (0..grid.spec().n_cells()).map(|cell| grid.is_keepout(cell).then(|| reason(cell))).collect()
}

/// The element that is worked on below which each cell is, or within whose margin, the nearest of several.
fn nearest_work(input: &ExportInput<'_>, grid: &Grid<'_>) -> Vec<Option<u32>> {
    let spec = grid.spec();
    let seeds = work_cells(input, grid);
    if seeds.is_empty() {
        return vec![None; spec.n_cells()];
    }
    // Margins grow over floor on which nothing stands, in closed rooms, too.
    let is_open =
        |cell: usize| grid.planning[cell] == 0 || (grid.floor[cell] != 0 && grid.class[cell] == Class::None.id());
    let reach = fifths_of(input.index.head.robot.work_margin_m / spec.resolution_m());
    let whole = CellRect::whole(spec.width, spec.height);
    let runs = seeds.iter().map(|(element, runs)| (*element, runs.as_slice()));
    let nearest = grow_labelled(whole, is_open, runs.clone(), reach);
    let mut found: Vec<Option<u32>> = nearest.into_iter().map(|seed| seed.map(|seed| seed.label)).collect();
    for (element, runs) in runs.rev() {
        for row in whole.clip(runs, spec.width as usize) {
            found[row].fill(Some(element));
        }
    }
    found
}

/// The elements that are worked on between this floor and the next, with the cells below them.
fn work_cells(input: &ExportInput<'_>, grid: &Grid<'_>) -> Vec<(u32, Vec<Run>)> {
    let (site, spec) = (input.site, grid.spec());
    let slab = match grid.head.floor.get() {
        FloorKind::Ground => Slab { lo: i32::MIN / 2, hi: i32::MAX / 2 },
        _ => {
            let floor_z = grid.head.floor_z_tenths;
            Slab { lo: floor_z, hi: site.next_floor_z_tenths(floor_z, MIN_STOREY_HEIGHT) }
        }
    };
    let is_worked_on = |element: u32| {
        matches!(
            input.schedule_state.effective(element as usize),
            ElementState::InProgress | ElementState::BeingRemoved
        )
    };
    (0..)
        .zip(site.elements)
        .filter(|(element, record)| record.n_parts > 0 && is_worked_on(*element))
        .map(|(element, record)| (element, cells_of_cut(&SlabCut::of(site.element_meshes(record), slab), &spec)))
        .filter(|(_, runs)| !runs.is_empty())
        .collect()
}
