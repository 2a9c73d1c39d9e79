//! Schedules of planners' tools: bytes in, [`PlanFile`] out.

mod assemble;
mod calendars;
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
mod xml;

pub use error::PlanFileError;
pub use options::{CsvColumn, ReadOptions, is_encoding};
pub use plan::{
    CalendarException, Constraint, ConstraintKind, Dependency, DependencyKind, Finding, FindingKind, LagCalendar,
    Length, PlanAssignment, PlanCalendar, PlanDate, PlanDates, PlanFile, PlanLag, PlanProject, PlanTask, PlanTaskKind,
};
pub use read::read;
