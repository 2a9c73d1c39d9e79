//! A project as a file writes it.

use crate::plan::{LagCalendar, PlanDate};

/// A project as it is written.
#[derive(Debug, Default)]
pub(crate) struct WrittenProject {
    pub(crate) uid: String,
    pub(crate) name: String,
    pub(crate) data_date: Option<PlanDate>,
    pub(crate) start: Option<PlanDate>,
    /// Identity of the calendar of tasks that name none; empty if it is not said.
    pub(crate) calendar: String,
    /// `None`: lags count day and night.
    pub(crate) lag_calendar: Option<LagCalendar>,
    /// Its tasks end when they are expected to.
    pub(crate) uses_expected_finishes: bool,
    /// It is in the file for its relationships with others alone, and no part of the plan.
    pub(crate) is_outside: bool,
}
