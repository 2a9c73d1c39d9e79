//! Grid spec, conservative rasterisation, cell regions, distances, Nav2 map files.
//!
//! Grids are row-major from the lower left cell, as `nav_msgs/OccupancyGrid`. A grid carries its spec: the only way
//! from metres to cells and back. This crate does no I/O: map files are made and read as bytes.

mod bitmap;
mod cells;
mod class;
mod distance;
mod growth;
mod line_of_sight;
mod nav2;
mod place_lattice;
mod raster;
mod rect;
mod resample;
mod run;
mod sparse_layer;
mod spec;

pub use cells::{Mask, enclosed, fill_holes, label_components};
pub use class::Class;
pub use distance::{nearest_marked, sparse_distances, squared_distances};
pub use growth::{Growth, MAX_REACH_CELLS, REACHED};
pub use line_of_sight::LineOfSight;
pub use nav2::{FREE, MapMode, MapYaml, OCCUPIED, UNKNOWN, decode_pgm, encode_pgm, occupancy_of, pixel_of};
pub use place_lattice::PlaceLattice;
pub use raster::{cells_of_cut, covered_cells, overlapped_cells};
pub use rect::{CellRect, join_rects};
pub use resample::MovedGrid;
pub use run::Run;
pub use sparse_layer::{SparseCells, SparseLayer};
pub use spec::{Cell, GridSpec, GridSpecError, MAX_CELLS};
