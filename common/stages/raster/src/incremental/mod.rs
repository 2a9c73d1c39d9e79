//! Grids that are kept and brought to each schedule state: only what looks different is drawn again.

mod difference;
mod ground;
pub(crate) mod scene;
pub(crate) mod storey_grid;
