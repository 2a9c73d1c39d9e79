//! The operator's client as a library: `main.rs` only wires.

pub mod args;
pub mod cli;
pub mod commands;
pub mod failure;
pub mod run;

mod alignment_report;
mod alignment_request;
mod date_argument;
mod film;
mod input_document;
mod lag;
mod load_progress;
mod maps;
mod monitor;
mod progress_line;
mod progress_record;
mod recording;
mod revision_report;
#[cfg(test)]
mod shipped_schema;
mod site_check;
mod site_service;
mod supervise;
mod task_name;
mod wait;
