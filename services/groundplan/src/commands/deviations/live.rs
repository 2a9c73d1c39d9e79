//! Deviations that the running daemon found.

use super::args::Args;
use super::report::write;
use crate::failure::Failure;
use crate::wait::join;
use bus::{SiteSetReader, topics};
use std::time::{Duration, Instant};

/// A comparison follows an alignment after seconds.
const TIMEOUT: Duration = Duration::from_secs(20);
const POLL_INTERVAL: Duration = Duration::from_millis(50);

/// Takes the deviations that fit the newest site and schedule state.
///
/// # Errors
/// No daemons, no pose that was accepted, a folder that cannot be written.
pub(super) fn take(arguments: &Args) -> Result<String, Failure> {
    let (bus, mut waiter) = join(&arguments.site.config()?)?;
    let mut states = SiteSetReader::of_states(&bus).map_err(Failure::work)?;
    let founds = bus.subscriber(topics::Deviations).map_err(Failure::work)?;
    let mut found = None;
    let begun = Instant::now();
    loop {
        states.take().map_err(Failure::work)?;
        found = founds.take().map_err(Failure::work)?.or(found);
        if let Some(state) = states.state()
            && let Some(sample) = found.take_if(|found| state.made(&found.header().inputs))
        {
            let (site, schedule_state) = state.views().map_err(Failure::work)?;
            let sample = sample.check().map_err(Failure::work)?;
            let found = sample.view();
            found.check_site(&site).map_err(Failure::work)?;
            return write(arguments, &site, &schedule_state, &found);
        }
        if begun.elapsed() > TIMEOUT {
            return Err(Failure::work("nothing was compared: see groundplan align and groundplan status"));
        }
        waiter.wait(POLL_INTERVAL).map_err(Failure::work)?;
    }
}
