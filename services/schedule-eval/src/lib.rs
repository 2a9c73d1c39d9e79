//! Decisions on plan time, rules, schedule files and progress of a site around the `schedule` stage.

mod evaluation;
mod in_force;
mod outputs;
mod plan_time_setting;
mod schedule_files;
pub mod service;
