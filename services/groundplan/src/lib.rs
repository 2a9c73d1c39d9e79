//! The operator's client as a library: `main.rs` only wires.

pub mod cli;
pub mod convert;
pub mod failure;
pub mod robot_file;
pub mod summary;

mod notices;
mod progress;
