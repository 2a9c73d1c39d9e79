//! The commands, a file or folder for each: arguments, help, what it does, tests.

pub mod actuals;
pub mod align;
pub mod changes;
pub mod completions;
pub mod confirm;
pub mod convert;
pub mod date;
pub mod deviations;
pub mod doctor;
pub mod down;
pub mod export;
pub mod keeper;
pub mod load;
pub mod log;
pub mod man;
pub mod metrics;
pub mod monitor;
pub mod relay;
pub mod robot;
pub mod slam_map;
pub mod states;
pub mod status;
pub mod tasks;
pub mod topic;
pub mod up;
pub mod waypoints;
