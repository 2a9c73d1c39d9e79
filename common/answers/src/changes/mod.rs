//! Changes: at every change instant of a schedule, of each element and space, between two dates, by a new revision of the plan.

mod calendar;
mod difference;
mod list;
mod revised_steps;
mod revision;

pub use calendar::Calendar;
pub use difference::{Difference, Side, difference};
pub use list::{Causes, Changes, causes_of, document, text};
pub use revision::{PlanRevision, revision};
