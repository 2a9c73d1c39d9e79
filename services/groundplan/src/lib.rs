//! The operator's client as a library: `main.rs` only wires.

pub mod align;
pub mod args;
pub mod changes;
pub mod cli;
pub mod convert;
pub mod deviations;
pub mod failure;
pub mod live;
pub mod manual;
pub mod monitor;
pub mod states;
mod storey_choice;
pub mod summary;
pub mod tasks;

mod maps;
mod notices;
mod plan_date;
mod progress;
