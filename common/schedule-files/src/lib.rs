//! Schedules of planners' tools: bytes in, [`PlanFile`] out.
//!
//! # Guarantees
//!
//! - Quirks of products and versions are in the head of each reader (`src/mspdi/mod.rs`, `src/xer/mod.rs`,
//!   `src/pmxml/mod.rs`, `src/csv/mod.rs`, `src/xlsx/mod.rs`).
//! - What cannot be read is a finding that names the task; only a file without tasks, or with more than a schedule has, is
//!   refused.
//! - A task goes by the calendars of its resources where these differ from its own, and lasts as long as their work
//!   (`src/resources.rs`): in P6 by them alone, in MS Project by the time that they share with its own calendar
//!   (`src/combined_calendar.rs`).
//! - MPXJ is the judge: `scripts/check_schedule_files.py` generates schedules with it and compares what both read.
//!
//! # Where
//!
//! - tasks: work of resources by their calendars: `src/resources.rs`, `common/stages/schedule/src/clock.rs`

mod assemble;
mod calendars;
mod cells;
mod circles;
mod combined_calendar;
mod csv;
mod decode;
mod error;
mod iso;
mod mspdi;
mod nesting;
mod options;
mod p6;
mod plan;
mod pmxml;
mod projects;
mod read;
mod resources;
mod values;
mod written_project;
mod xer;
mod xlsx;
mod xml;

pub use cells::{cell_of, text_of};
pub use error::PlanFileError;
pub use options::{CsvColumn, ReadOptions, is_encoding};
pub use plan::{
    CalendarException, Constraint, ConstraintKind, Dependency, DependencyKind, Finding, FindingKind, LagCalendar,
    Length, PlanAssignment, PlanCalendar, PlanDate, PlanDates, PlanFile, PlanLag, PlanProject, PlanTask, PlanTaskKind,
};
pub use read::read;
