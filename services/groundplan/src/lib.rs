//! The operator's client as a library: `main.rs` only wires.
//!
//! # Guarantees
//!
//! - `export` writes what `convert --date` writes at that instant, byte for byte (`tests/tests/equivalence.rs`).
//! - `date` returns when an index of the new state is published; it reads that in the report of rasterize, so that readers of
//!   the maps cannot keep it out.
//! - A site is healthy while clock, schedule state and grids are of each other, or differ for no longer than is usual
//!   (`services/groundplan/src/lag.rs`).
//! - `export --watch` writes maps on one thread; on another it compares what the folder holds with what the daemons publish,
//!   replaces `fresh` once a second while both are equal, and runs the hooks, so that neither large maps nor a hook that
//!   hangs keep a stale map fresh.
//!
//! # Where
//!
//! - daemons: progress of a request: `common/daemon/src/progress.rs`, `common/stages/ingest/src/progress.rs`,
//!   `src/load_progress.rs`, `src/progress_line.rs`
//! - monitor: what it shows: `src/monitor/screen.rs`
//! - recording: which messages, when: `src/film.rs`, `src/commands/record.rs`, `src/recording.rs`

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
mod monitor;
mod output_file;
mod progress_line;
mod progress_record;
mod question;
mod recording;
mod revision_report;
#[cfg(test)]
mod shipped_schema;
mod site_check;
mod site_service;
mod supervise;
mod wait;
