//! The commands, a file or folder for each: arguments, help, what it does, tests.

pub mod actuals;
pub mod align;
pub mod changes;
pub mod confirm;
pub mod convert;
pub mod date;
pub mod deviations;
pub mod load;
pub mod robot;
pub mod slam_map;
pub mod states;
pub mod tasks;
pub mod waypoints;
