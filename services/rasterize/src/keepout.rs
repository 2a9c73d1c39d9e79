//! Where a robot must not go.

use crate::compose::{OCCUPIED, is_worked_on};
use crate::cut::{StoreyCut, cells_of};
use grid::{Class, Mask, fill_holes, grow_through};
use messages::{ElementState, FloorKind, Phase, RobotProfile, Site};

/// What the mask is made from.
pub(crate) struct KeepoutInput<'a> {
    pub(crate) site: &'a Site<'a>,
    pub(crate) phase: &'a Phase<'a>,
    pub(crate) robot: &'a RobotProfile,
    pub(crate) storey: &'a StoreyCut,
    /// Floor and open doors without obstacles, blocked spaces included.
    pub(crate) free: &'a Mask,
    /// Obstacles and closed doors.
    pub(crate) occupied: &'a Mask,
    pub(crate) floor: &'a Mask,
    /// Cells of blocked spaces.
    pub(crate) blocked: &'a Mask,
    pub(crate) class: &'a [u8],
}

/// Writes the mask: blocked spaces, work, cells without floor inside the outline, and margins around work and edges.
///
/// Margins grow through free cells only, so that they never leak through a wall. Outside the outline only what lies at
/// the edge of free cells is marked: beyond a door, or beyond the rim of a slab.
pub(crate) fn keepout(input: &KeepoutInput<'_>, layer: &mut [i8]) {
    let spec = &input.storey.spec;
    let (width, height) = (spec.width as usize, spec.height as usize);
    let outline = outline(input);

    // A door without floor beyond stays passable, so it is no drop-off itself.
    let void = |i: usize| !input.floor.cells[i] && input.class[i] != Class::Door.id();
    let edges = Mask { width, cells: (0..layer.len()).map(|i| void(i) && !input.occupied.cells[i]).collect() };
    let edge_reach = cells_of(spec, input.robot.edge_margin_m);
    let mut forbidden = grow_through(&edges, input.free, edge_reach);
    let beyond_edges = grow_through(input.free, &edges, edge_reach.max(1.0));
    forbidden.set_all(&beyond_edges);

    let mut work = Mask::new(width, height);
    for element in input.storey.overhead.iter().filter(|o| is_worked_on(input.phase, o.element)) {
        work.set_runs(input.storey.overhead_runs(input.site, element));
    }
    forbidden.set_all(&grow_through(&work, input.free, cells_of(spec, input.robot.work_margin_m)));
    forbidden.set_all(&work);
    forbidden.set_all(input.blocked);

    for (index, value) in layer.iter_mut().enumerate() {
        if forbidden.cells[index] || (outline.cells[index] && void(index)) {
            *value = OCCUPIED;
        }
    }
}

/// Everything inside the storey when it is complete: what is not built yet is a drop-off inside it, not outside.
fn outline(input: &KeepoutInput<'_>) -> Mask {
    let storey = input.storey;
    let mut ground = input.floor.clone();
    storey.obstacles.iter().for_each(|o| ground.set_runs(&o.runs));
    storey.spaces.iter().for_each(|s| ground.set_runs(&s.runs));
    storey.passages.iter().for_each(|p| ground.set_runs(&p.runs));
    let is_built = |element: u32| input.phase.effective(element as usize) == ElementState::Built;
    let is_assumed = input.site.map_storeys[storey.map_storey as usize].floor != FloorKind::Built as u32;
    if !is_assumed && !storey.floor.iter().all(|piece| is_built(piece.element)) {
        ground.set_runs(storey.complete_floor());
    }
    fill_holes(&ground)
}
