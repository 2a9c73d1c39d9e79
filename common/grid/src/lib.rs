//! Grid spec, conservative rasterisation, cell regions, distances, Nav2 map files.
//!
//! Grids are row-major from the lower left cell, as `nav_msgs/OccupancyGrid`. A grid carries its spec: the only way
//! from metres to cells and back. This crate does no I/O: map files are made and read as bytes.
//!
//! # Guarantees
//!
//! - The lines of a raster lie half a unit inside its cells.
//! - A body is painted triangle by triangle, as its parts overlap cells; nothing is united for that. `SlabCut` of `geometry`
//!   holds the parts, and polygons are made of them where a file or a doorway asks for one.
//! - A cell is covered by an obstacle that overlaps it by a tenth of a millimetre in both axes, and by floor only if floor
//!   covers it whole: both errors are on the safe side, and a thin wall never vanishes.
//! - What is planned on a storey lies in sparse layers (`src/sparse_layer.rs`): a large site is mostly outside, where no
//!   robot goes. Lines of sight are dense, because millions of them are cast.
//! - Yaw of a map is 0 and its origin a whole number of cells, because Nav2 ignores the one and aliases on the other.
//!
//! # Where
//!
//! - cells: which a polygon overlaps, which it covers whole: `src/raster.rs`
//! - classes: which one a cell shows where elements overlap: `src/class.rs`
//! - pixel values of map files: `src/nav2.rs`

mod bitmap;
mod blocked_sectors;
mod cells;
mod class;
mod distance;
mod growth;
mod labelled_growth;
mod line_of_sight;
mod nav2;
mod place_lattice;
mod raster;
mod rect;
mod resample;
mod run;
mod run_lists;
mod sparse_layer;
mod spec;

pub use blocked_sectors::BlockedSectors;
pub use cells::{Mask, enclosed, fill_holes, label_components};
pub use class::Class;
pub use distance::{nearest_marked, sparse_distances, squared_distances};
pub use growth::{Growth, MAX_REACH_CELLS, REACHED};
pub use labelled_growth::{NearestSeed, fifths_of, grow_labelled};
pub use line_of_sight::LineOfSight;
pub use nav2::{FREE, MapMode, MapYaml, OCCUPIED, UNKNOWN, decode_pgm, encode_pgm, occupancy_of, pixel_of};
pub use place_lattice::PlaceLattice;
pub use raster::{cells_of_cut, covered_cells, overlapped_cells};
pub use rect::{CellRect, join_rects, stacked_runs};
pub use resample::MovedGrid;
pub use run::Run;
pub use run_lists::{common_runs, grown_runs};
pub use sparse_layer::{SparseCells, SparseLayer};
pub use spec::{Cell, GridSpec, GridSpecError, MAX_CELLS};
