//! The operator's client as a library: `main.rs` only wires.

pub mod align;
pub mod args;
pub mod cli;
pub mod commands;
pub mod deviations;
pub mod failure;
pub mod live;
pub mod manual;
pub mod monitor;

mod maps;
mod plan_date;
mod progress;
pub mod run;
mod task_name;
