//! Site and rules in, states of all elements and spaces at any plan time out.
//!
//! [`evaluate`] works the schedule out once: dates of tasks from what is written, sequences, durations and calendars;
//! what happens to each element and who says so; when each space is closed and why. The [`Timeline`] that it returns
//! answers for any instant or period by looking up sorted changes. Nothing here knows the clock or the outside.
//!
//! Instants are civil seconds since 1970-01-01T00:00 at the site, without a zone.

mod clock;
mod closures;
mod dates;
mod durations;
mod edits;
mod evaluate;
mod findings;
mod lives;
mod rules;
mod said;
mod task_targets;
mod tasks;
mod timeline;
mod working_time;
mod works;

pub use dates::DateOrder;
pub use edits::{ABSENT, Actual, Delay, EditError, Edits, find_task, parse_actuals};
pub use evaluate::{AmbiguousDates, EvaluateError, evaluate};
pub use findings::{Finding, Severity};
pub use rules::{
    ClosedSpace, DateKind, DurationDay, Inputs, Mode, Phase, PhaseProperties, PropertyDate, Rules, RulesError, Undated,
};
pub use task_targets::{Cause, Operation, TaskTargets};
pub use tasks::{Floats, TaskDates};
pub use timeline::{Change, Period, Timeline};
