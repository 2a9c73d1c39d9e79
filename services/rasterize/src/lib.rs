//! The rasterize service around the `raster` stage.

mod drawing_settings;
pub mod service;
