//! Schedules of planners' tools: bytes in, [`PlanFile`] out.

mod decode;
mod error;
mod plan;

pub use error::PlanFileError;
pub use plan::{
    CalendarException, Constraint, ConstraintKind, Dependency, DependencyKind, Finding, FindingKind, Length,
    PlanCalendar, PlanDate, PlanDates, PlanFile, PlanLag, PlanTask, PlanTaskKind,
};
