//! Updates the floor of a storey for a schedule state: finished floor, enclosed floor, open passages.

use super::outdoor_floor::OutdoorFloor;
use super::state_difference::StateDifference;
use crate::layers::cell_flags::BASE_FLOOR;
use crate::layers::floor::{BuiltFloorCache, enclosed_floor, set_bit, sides_with_floor};
use crate::layers::shown_surface::LEVEL;
use crate::model::storey_inputs::StoreyInputs;
use grid::{Run, join_rects};
use messages::{FloorKind, RegionRecord, ScheduleState};

/// The floor of a storey as drawn last.
#[derive(Debug)]
pub(crate) struct StoreyFloor {
    floor_cache: BuiltFloorCache,
    /// Of the ground outdoors, in the place of the cache.
    outdoors: Option<OutdoorFloor>,
    /// True if any cell has [`BASE_FLOOR`].
    pub(crate) has_floor: bool,
    /// By passage of the storey: true if it is open, and therefore floor.
    pub(crate) open_passages: Vec<bool>,
    /// True if rooms without a slab are part of the floor.
    has_assumed: bool,
    /// The patch that each cell shows, or [`LEVEL`]; empty on a storey without ground at other heights.
    pub(crate) patch_of: Vec<u32>,
    /// Finished floor at other levels.
    pub(crate) regions: Vec<RegionRecord>,
}

impl StoreyFloor {
    /// A storey without floor, and the cells of its floor when everything is finished.
    pub(crate) fn new(inputs: StoreyInputs<'_>) -> (Self, Vec<Run>) {
        let StoreyInputs { site, robot, storey } = inputs;
        let mut all = Vec::new();
        storey.dependents.iter().filter_map(|n| n.floor_index).for_each(|index| set_bit(&mut all, index, true));
        let is_outdoors = storey.floor_kind == FloorKind::Ground && !storey.ground.is_empty();
        let mut floor = Self {
            floor_cache: BuiltFloorCache::default(),
            outdoors: is_outdoors.then(|| OutdoorFloor::new(storey)),
            has_floor: false,
            has_assumed: false,
            open_passages: Vec::new(),
            patch_of: if storey.ground.is_empty() { Vec::new() } else { vec![LEVEL; storey.spec.n_cells()] },
            regions: Vec::new(),
        };
        let complete = match &mut floor.outdoors {
            Some(outdoors) => {
                outdoors.update(inputs, &all, &mut floor.patch_of, &mut Vec::new());
                outdoors.runs(storey.spec.width as usize)
            }
            None => floor.floor_cache.of(site, robot, storey, &all).runs.clone(),
        };
        (floor, complete)
    }

    /// Updates [`BASE_FLOOR`] for the finished floor elements.
    pub(crate) fn update_floor(
        &mut self,
        flags: &mut [u8],
        difference: &mut StateDifference,
        finished_floors: &[u64],
        (inputs, schedule_state): (StoreyInputs<'_>, &ScheduleState<'_>),
        is_first: bool,
    ) {
        let storey = inputs.storey;
        let whole = storey.whole();
        if is_first {
            difference.floor_cells.clear();
            difference.floor_cells.push(whole);
        }
        if is_first || difference.floor_differs {
            match &mut self.outdoors {
                Some(outdoors) => {
                    let floor_cells = &mut difference.floor_cells;
                    outdoors.update(inputs, finished_floors, &mut self.patch_of, floor_cells);
                    join_rects(floor_cells);
                    for cell in floor_cells.iter().flat_map(|rect| rect.rows(whole.width())).flatten() {
                        flags[cell] = flags[cell] & !BASE_FLOOR | if outdoors.is_floor(cell) { BASE_FLOOR } else { 0 };
                    }
                }
                None => self.update_level(flags, difference, finished_floors, inputs),
            }
        }
        if storey.floor_kind == FloorKind::AssumedFromEnclosure {
            enclose(flags, difference, inputs, schedule_state);
        }
        if is_first || !difference.floor_cells.is_empty() {
            self.has_floor = flags.iter().any(|f| f & BASE_FLOOR != 0);
        }
        let StateDifference { cells, floor_cells, .. } = difference;
        cells.extend_from_slice(floor_cells);
    }

    /// The same on a storey with a level.
    fn update_level(
        &mut self,
        flags: &mut [u8],
        difference: &mut StateDifference,
        finished_floors: &[u64],
        inputs: StoreyInputs<'_>,
    ) {
        let StoreyInputs { site, robot, storey } = inputs;
        let whole = storey.whole();
        let plan = self.floor_cache.of(site, robot, storey, finished_floors);
        self.regions.clone_from(&plan.regions);
        if std::mem::replace(&mut self.has_assumed, plan.has_assumed) != plan.has_assumed {
            difference.floor_cells.push(whole);
        }
        join_rects(&mut difference.floor_cells);
        for rect in &difference.floor_cells {
            rect.rows(whole.width()).for_each(|row| flags[row].iter_mut().for_each(|f| *f &= !BASE_FLOOR));
            let covered = rect.clip(&plan.runs, whole.width());
            covered.for_each(|cells| flags[cells].iter_mut().for_each(|f| *f |= BASE_FLOOR));
            if storey.ground.is_empty() {
                continue;
            }
            rect.rows(whole.width()).for_each(|row| self.patch_of[row].fill(LEVEL));
            for (run, patch) in &plan.patches {
                let cells = rect.clip(std::slice::from_ref(run), whole.width());
                cells.for_each(|cells| self.patch_of[cells].fill(*patch));
            }
        }
    }

    /// Opens the passages of standing walls with floor on both sides, and closes the others.
    pub(crate) fn update_passages(
        &mut self,
        flags: &[u8],
        difference: &mut StateDifference,
        (inputs, schedule_state): (StoreyInputs<'_>, &ScheduleState<'_>),
        is_first: bool,
    ) {
        self.open_passages.resize(inputs.storey.passages.len(), false);
        for (passage, open) in inputs.storey.passages.iter().zip(&mut self.open_passages) {
            let Some(around) = passage.around else { continue };
            if !is_first && !difference.cells.iter().any(|rect| rect.meets(&around)) {
                continue;
            }
            let is_open = schedule_state.effective(passage.host as usize).is_obstacle()
                && sides_with_floor(&passage.plan, &inputs.storey.spec, |i| flags[i] & BASE_FLOOR != 0) == 2;
            if std::mem::replace(open, is_open) != is_open {
                difference.cells.extend(passage.rect);
            }
        }
    }
}

/// Sets [`BASE_FLOOR`] to the cells that obstacles enclose, on a storey without floor faces and spaces.
fn enclose(
    flags: &mut [u8],
    difference: &mut StateDifference,
    inputs: StoreyInputs<'_>,
    schedule_state: &ScheduleState<'_>,
) {
    let enclosed = enclosed_floor(inputs.storey, |element| schedule_state.effective(element as usize).is_obstacle());
    for (flags, inside) in flags.iter_mut().zip(enclosed.cells) {
        *flags = *flags & !BASE_FLOOR | if inside { BASE_FLOOR } else { 0 };
    }
    difference.floor_cells.clear();
    difference.floor_cells.push(inputs.storey.whole());
}
