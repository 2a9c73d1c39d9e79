//! Samples of topics for a client.

use crate::failure::Failure;
use crate::wait::join;
use bus::{Bus, RawSample, TopicName, Waiter};
use daemon::{SiteConfig, StopSignal};
use std::time::{Duration, Instant};

/// Interval at which topics are polled.
pub(super) const POLL_INTERVAL: Duration = Duration::from_millis(200);

/// A client that SIGTERM and SIGINT stop.
pub(super) fn stoppable(config: &SiteConfig) -> Result<(Bus, Waiter), Failure> {
    let stop = StopSignal::listen(false).map_err(Failure::work)?;
    let (bus, mut waiter) = join(config)?;
    waiter.stop_on(stop.descriptor().map_err(Failure::work)?);
    Ok((bus, waiter))
}

/// The last samples of those topics that have one.
pub(super) fn samples(
    config: &SiteConfig,
    topics: &[TopicName],
    timeout: Duration,
) -> Result<Vec<(TopicName, RawSample)>, Failure> {
    let (bus, mut waiter) = join(config)?;
    let subscribers: Vec<_> =
        topics.iter().map(|t| bus.raw_subscriber(*t)).collect::<Result<_, _>>().map_err(Failure::work)?;
    let mut found: Vec<Option<RawSample>> = topics.iter().map(|_| None).collect();
    let deadline = Instant::now() + timeout;
    while found.iter().any(Option::is_none) && Instant::now() < deadline {
        for (subscriber, found) in subscribers.iter().zip(&mut found) {
            if let Some(sample) = subscriber.take().map_err(Failure::work)? {
                *found = Some(sample);
            }
        }
        waiter
            .wait(deadline.saturating_duration_since(Instant::now()).min(POLL_INTERVAL / 4))
            .map_err(Failure::work)?;
    }
    Ok(topics.iter().zip(found).filter_map(|(topic, sample)| Some((*topic, sample?))).collect())
}
