//! Compares a schedule state with the drawn one and finds the cells that may differ.

use super::flag_difference::FlagDifference;
use crate::layers::floor::set_bit;
use crate::model::presence::Presence;
use crate::model::storey_inputs::StoreyInputs;
use grid::CellRect;
use messages::ScheduleState;

/// The inputs from a schedule state on which a grid depends, as drawn last.
#[derive(Debug, Default)]
pub(crate) struct DrawnState {
    /// [`Presence`] of every dependent, then whether each space is blocked, then whether there is a plan time.
    pub(crate) state_bytes: Vec<u8>,
    /// Finished floor elements, as bits by floor index.
    pub(crate) finished_floors: Vec<u64>,
}

/// Cells in which a schedule state may differ from the drawn one.
#[derive(Debug, Default)]
pub(crate) struct StateDifference {
    /// Cells whose flags may differ.
    pub(crate) cells: Vec<CellRect>,
    /// Cells whose floor may differ.
    pub(crate) floor_cells: Vec<CellRect>,
    /// Cells below which work began or ended.
    pub(crate) work: Vec<CellRect>,
    /// Cells below all elements that are worked on.
    pub(crate) working: Vec<CellRect>,
    /// Indices in `StoreySlice::overhead` of the elements that are worked on.
    pub(crate) worked_on: Vec<u32>,
    /// True if the set of finished floor elements differs.
    pub(crate) floor_differs: bool,
    /// Cells of any layer that may differ.
    pub(crate) changed: Vec<CellRect>,
    /// Cells whose flags differ.
    pub(crate) flags: FlagDifference,
    /// Buffer of the rectangles in which a layer is recomputed.
    pub(crate) affected: Vec<CellRect>,
}

impl StateDifference {
    /// Compares a schedule state with the drawn state and replaces that; false if nothing differs.
    pub(crate) fn compare(
        &mut self,
        drawn_state: &mut DrawnState,
        inputs: StoreyInputs<'_>,
        schedule_state: &ScheduleState<'_>,
    ) -> bool {
        let storey = inputs.storey;
        let is_first = drawn_state.state_bytes.is_empty();
        let (n_dependents, n_spaces) = (storey.dependents.len(), storey.spaces.len());
        // A value that no drawn state has.
        let DrawnState { state_bytes, finished_floors } = drawn_state;
        state_bytes.resize(n_dependents + n_spaces + 1, u8::MAX);
        self.clear();
        let mut differs = is_first;
        for (dependent, drawn) in storey.dependents.iter().zip(&mut *state_bytes) {
            let presence = Presence::of(schedule_state.effective(dependent.element as usize));
            let before = std::mem::replace(drawn, presence as u8);
            let overhead =
                dependent.overhead.filter(|_| presence == Presence::WorkedOn || before == Presence::WorkedOn as u8);
            let work = overhead.and_then(|index| storey.overhead_rect(inputs.site, index));
            if presence == Presence::WorkedOn {
                self.worked_on.extend(dependent.overhead);
                self.working.extend(work);
            }
            if before == presence as u8 {
                continue;
            }
            differs = true;
            self.cells.extend(dependent.cells);
            if (before == Presence::WorkedOn as u8) != (presence == Presence::WorkedOn) {
                self.work.extend(work);
            }
            if let Some(index) = dependent.floor_index {
                set_bit(finished_floors, index, presence == Presence::Built);
                self.floor_cells.extend(dependent.floor);
                self.floor_differs = true;
            }
        }
        for (space, drawn) in storey.spaces.iter().zip(&mut state_bytes[n_dependents..]) {
            let blocked = u8::from(schedule_state.is_blocked(space.space as usize));
            if std::mem::replace(drawn, blocked) != blocked {
                differs = true;
                self.cells.extend(space.rect);
            }
        }
        let dated = u8::from(schedule_state.head.plan_time().is_some());
        if std::mem::replace(&mut state_bytes[n_dependents + n_spaces], dated) != dated {
            // Without a plan time a storey without floor is not all unknown.
            differs = true;
        }
        let StateDifference { cells, work, .. } = self;
        cells.extend_from_slice(work);
        differs
    }

    fn clear(&mut self) {
        let lists = [&mut self.cells, &mut self.floor_cells, &mut self.work, &mut self.working];
        lists.into_iter().for_each(Vec::clear);
        self.worked_on.clear();
        self.floor_differs = false;
    }
}
