//! Decisions on robot and resolution, and drawing of the grids that a schedule state changes, around the `raster` stage.

mod drawing_settings;
mod outputs;
pub mod service;
