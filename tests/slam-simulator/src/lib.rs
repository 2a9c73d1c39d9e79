//! Simulated SLAM maps of real buildings: model maps in, maps of a robot with their true poses out.
//!
//! A model map becomes a building in use ([`simulated`]): walls are missing or elsewhere, furniture hides them, doors are open or
//! closed, people walk, glass lets beams through. A robot drives through it and maps what its lidar sees, with drift. The
//! same seed gives the same bytes. [`write_logs`] leaves the map to a program for SLAM, which reads the scans with the odometry. Lengths are metres, angles radians, frames those of the maps.
//!
//! Only for tests and calibration: no product depends on it, and it knows no alignment, which is judged by its maps.
//!
//! # Guarantees
//!
//! - The building as it is comes first (`building`), then the robot in it (`robot`): a fine raster of what stops a beam is
//!   all that both share.
//! - `scanned_drive` is a drive with its scans; a map is made of them with the robot's own errors (`simulation`), or they are
//!   written with a drifting odometry (`logs`), and a real SLAM program makes the map: `scripts/slam-maps`.
//! - Every effect draws from a generator of its own, seeded by the pair: the number of threads changes nothing.
//! - Uniqueness is decided by branch and bound over all rigid motions (`src/uniqueness.rs`), not by the search of
//!   `alignment`.
//! - `as_built` makes buildings whose elements are known by GlobalId from a converted model, with elements removed, displaced
//!   or cut, and counts the beams that met each element or crossed its place: `scripts/bench-deviations` judges verdicts by
//!   it.
//! - `floor_plans` draws model maps of offices, homes and halls, so that tests and calibrations need no building models.

mod as_built;
mod building;
mod carmen_log;
mod logs;
mod map_files;
mod openings;
mod output_error;
mod pairs;
mod plane;
mod random_generator;
mod reference;
mod robot;
mod scanned_drive;
mod simulation;
mod strengths;
mod uniqueness;
mod wall_grid;
mod wall_stretches;
mod world;

pub mod floor_plans;

pub use as_built::{ModelError, RunError, RunOptions, write_runs};
pub use building::Contents;
pub use logs::{LogOptions, write_logs};
pub use map_files::write_map;
pub use openings::Opening;
pub use output_error::OutputError;
pub use pairs::{PairError, PairOptions, Wrong, write_pairs};
pub use plane::{Rectangle, Vector};
pub use random_generator::RandomGenerator;
pub use reference::{Reference, ReferenceError};
pub use robot::drift::Residual;
pub use simulation::{Growth, Measures, Simulation, simulated, simulated_growth};
pub use strengths::{Clutter, Lidar, Strengths};
pub use uniqueness::{fits, is_unique, overlap};
pub use wall_grid::WallGrid;
pub use wall_stretches::WallStretch;
