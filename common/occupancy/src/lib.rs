//! Occupancy maps of robots: files of map servers, the `slam-map` archive, cells of one size.
//!
//! Shared by the stages that compare a robot's map with the model. A map is row-major from its lower left corner; lengths
//! are metres, angles radians.
//!
//! # Guarantees
//!
//! - Grey 205 is unknown, independent of the thresholds of the file.

mod archive;
mod cell_raster;
mod map_file;

pub use cell_raster::{CELL_M, Cell, Raster};
pub use map_file::{MapFault, MapFileContent, MapFileError, OccupancyMap, UndecidedCells};
