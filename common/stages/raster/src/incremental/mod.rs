//! Incremental redraw: grids are kept, and only cells that differ are drawn again.

mod flag_difference;
mod outdoor_floor;
mod shown_patches;
mod state_difference;
mod storey_floor;
pub(crate) mod storey_grid;
pub(crate) mod version_history;
