//! Deviations that the running daemon found.

use super::args::Args;
use super::report::write;
use crate::alignment_request::{other_answer, published};
use crate::failure::Failure;
use crate::wait::{ask, join};
use bus::{Bus, PortError, Waiter, topics};
use daemon::{AlignAnswer, AlignRequest, ComparisonState, Published, Request};
use messages::{Deviations, ScheduleState, Site};
use site_view::SiteSetReader;
use std::time::{Duration, Instant};

/// Timeout of a comparison that runs.
const COMPARISON_TIMEOUT: Duration = Duration::from_secs(600);
/// Timeout of samples after their daemon said that they are published.
const PUBLISHED_TIMEOUT: Duration = Duration::from_secs(30);
const POLL_INTERVAL: Duration = Duration::from_millis(50);

/// Takes the deviations of the newest site, schedule state and map; waits only while they are on their way.
///
/// # Errors
/// No daemons; no map, no site or no pose in effect, which is told at once; a folder that cannot be written.
pub(super) fn take(arguments: &Args) -> Result<String, Failure> {
    let (bus, mut waiter) = join(&arguments.site.config()?)?;
    with_newest(&bus, &mut waiter, |site, schedule_state, found| {
        write(arguments, site, schedule_state, found, None, (&[], &[]))
    })
}

/// Works with the deviations of the newest site, schedule state and map; waits only while they are on their way.
///
/// # Errors
/// No map, no site or no pose in effect, which is told at once; those of the work.
pub(crate) fn with_newest<T>(
    bus: &Bus,
    waiter: &mut Waiter,
    work: impl FnOnce(&Site<'_>, &ScheduleState<'_>, &Deviations<'_>) -> Result<T, Failure>,
) -> Result<T, Failure> {
    let deviations = match bus.command_client(AlignRequest::DAEMON) {
        Err(PortError::ViewOnly { .. }) => published_to_viewers(bus, waiter)?,
        _ => compared(bus, waiter)?,
    };
    let mut states = SiteSetReader::of_states(bus).map_err(Failure::work)?;
    let founds = bus.subscriber(topics::Deviations).map_err(Failure::work)?;
    let mut found = None;
    let begun = Instant::now();
    loop {
        states.take().map_err(Failure::work)?;
        found = founds.take().map_err(Failure::work)?.or(found);
        if let Some(state) = states.state()
            && let Some(sample) = found.take_if(|found| {
                let header = found.header();
                deviations.epoch <= header.epoch && state.made(&header.inputs)
            })
        {
            let (site, schedule_state) = state.views().map_err(Failure::work)?;
            let sample = sample.check().map_err(Failure::work)?;
            let found = sample.view();
            found.check_site(&site).map_err(Failure::work)?;
            return work(&site, &schedule_state, &found);
        }
        if begun.elapsed() > PUBLISHED_TIMEOUT {
            return Err(Failure::work(
                "the deviations of the newest schedule state have not come: see groundplan status",
            ));
        }
        waiter.wait(POLL_INTERVAL).map_err(Failure::work)?;
    }
}

/// Waits while the daemon says that it compares; the newest deviations.
fn compared(bus: &Bus, waiter: &mut Waiter) -> Result<Published, Failure> {
    let mut at_least = None;
    let begun = Instant::now();
    loop {
        match ask(bus, waiter, &AlignRequest::Comparison { at_least })? {
            AlignAnswer::Comparison(ComparisonState::Done(deviations)) => return Ok(deviations),
            AlignAnswer::Comparison(ComparisonState::Impossible { why }) => {
                return Err(Failure::work(format!("slam-align: {why}")));
            }
            AlignAnswer::Comparison(ComparisonState::Running { comparison }) => at_least = Some(comparison),
            _ => return Err(other_answer()),
        }
        if begun.elapsed() > COMPARISON_TIMEOUT {
            return Err(Failure::work("the comparison has not ended: see groundplan status"));
        }
        waiter.wait(POLL_INTERVAL).map_err(Failure::work)?;
    }
}

/// Users who may not ask daemons take any deviations of an effective pose.
fn published_to_viewers(bus: &Bus, waiter: &mut Waiter) -> Result<Published, Failure> {
    let alignment = published(bus, waiter, Published::default())?;
    match alignment.view().why_not_usable(None) {
        Some(why) => Err(Failure::work(why)),
        None => Ok(Published::default()),
    }
}
