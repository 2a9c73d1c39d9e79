//! Requests to the daemons in the name of a viewer.

use bus::{Bus, Daemon};
use daemon::{AlignRequest, Failure, Request, RequestTimeouts, ScheduleRequest, SiteConfig, ask};
use frames::PlanTime;
use std::time::Duration;

/// For a daemon to answer; it may just be started again.
const TIMEOUTS: RequestTimeouts = RequestTimeouts { starting: Duration::from_secs(5), answer: Duration::from_secs(20) };
/// Interval between two looks.
const POLL_INTERVAL: Duration = Duration::from_millis(20);

/// Sets the plan time.
///
/// # Errors
/// A text that is no plan time; the daemon refuses or does not answer.
pub(super) fn set_plan_time(config: &SiteConfig, text: &str) -> Result<(), Failure> {
    config.check_draws()?;
    let at: PlanTime = text.parse()?;
    request(config, &ScheduleRequest::SetPlanTime { at_s: at.civil_seconds() }).map(drop)
}

/// Confirms that an element is absent.
///
/// # Errors
/// An element that the robot has not seen through; the daemon does not answer.
pub(super) fn confirm_absent(config: &SiteConfig, global_id: &str) -> Result<(), Failure> {
    request(config, &AlignRequest::ConfirmAbsent { elements: vec![global_id.to_owned()] }).map(drop)
}

/// Each request joins the bus anew: it may have been replaced since the last.
fn request<R: Request>(config: &SiteConfig, request: &R) -> Result<R::Answer, Failure> {
    let (bus, mut waiter) = Bus::join(&config.domain()?, Daemon::Groundplan)?;
    let pause = || waiter.wait(POLL_INTERVAL).map(drop).map_err(Into::into);
    Ok(ask(&bus, request, TIMEOUTS, |_| {}, pause)?)
}
