//! Decisions on what waypoints are planned, and on which maps, around the `waypoints` stage.

mod options_setting;
pub mod service;
