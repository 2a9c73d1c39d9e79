//! Incremental redraw: grids are kept, and only cells that differ are drawn again.

mod state_difference;
mod storey_floor;
pub(crate) mod storey_grid;
