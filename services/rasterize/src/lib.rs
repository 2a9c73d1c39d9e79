//! The rasterize service around the `raster` stage.

mod saved_robot;
pub mod service;
