//! The operator's client as a library: `main.rs` only wires.

mod alignment_report;
mod alignment_request;
pub mod args;
pub mod cli;
pub mod commands;
pub mod failure;
pub mod live;
pub mod manual;
pub mod monitor;

mod maps;
mod plan_date;
mod progress;
pub mod run;
mod task_name;
mod wait;
