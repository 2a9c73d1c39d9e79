//! The rasterize service around the `raster` stage.

pub mod service;
