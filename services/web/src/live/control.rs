//! Requests to the daemons in the name of a viewer.

use daemon::{AlignRequest, Failure, ScheduleRequest, SiteConfig, ask_site};
use frames::PlanTime;

/// Sets the plan time.
///
/// # Errors
/// A text that is no plan time; the daemon refuses or does not answer.
pub(super) fn set_plan_time(config: &SiteConfig, text: &str) -> Result<(), Failure> {
    config.check_draws()?;
    let at: PlanTime = text.parse()?;
    ask_site(config, &ScheduleRequest::SetPlanTime { at_s: at.civil_seconds() }).map(drop)
}

/// Confirms that an element is absent.
///
/// # Errors
/// An element that the robot has not seen through; the daemon does not answer.
pub(super) fn confirm_absent(config: &SiteConfig, global_id: &str) -> Result<(), Failure> {
    ask_site(config, &AlignRequest::ConfirmAbsent { elements: vec![global_id.to_owned()] }).map(drop)
}
