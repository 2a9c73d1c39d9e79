//! Decisions on where the robot's map lies in the model's, and on observations that change the schedule, around the `alignment` and
//! `deviations` stages.

pub mod background_worker;
mod compared_elements;
mod in_force;
pub mod job;
mod map_setting;
mod newest_inputs;
pub mod observed_table;
mod outputs;
mod persisted_state;
mod robot_map;
mod searches;
pub mod service;
mod stored_evidence;
mod stored_map;
