//! `groundplan topic echo`: samples of a topic as JSON.

use super::description::describe;
use super::samples::{POLL_INTERVAL, samples, stoppable};
use crate::failure::Failure;
use bus::TopicName;
use daemon::SiteConfig;
use std::io::Write;
use std::time::Duration;

/// A topic whose last sample has not come within this time has none. Producers that give way to all other processes may take
/// long to serve a newcomer.
const TIMEOUT: Duration = Duration::from_secs(5);

/// Prints the last sample.
pub(super) fn echo(config: &SiteConfig, topic: TopicName, json: bool) -> Result<String, Failure> {
    let found = samples(config, &[topic], TIMEOUT)?.pop();
    let (_, sample) = found.ok_or_else(|| Failure::work(format!("{topic} has no sample")))?;
    let described = describe(&sample).map_err(Failure::work)?;
    let text = if json { serde_json::to_string(&described) } else { serde_json::to_string_pretty(&described) };
    Ok(text.map_err(Failure::work)? + "\n")
}

/// Prints every sample, beginning with the last one, until it is stopped.
pub(super) fn follow(config: &SiteConfig, topic: TopicName) -> Result<String, Failure> {
    let (bus, mut waiter) = stoppable(config)?;
    let subscriber = bus.raw_subscriber(topic).map_err(Failure::work)?;
    loop {
        if let Some(sample) = subscriber.take().map_err(Failure::work)? {
            let line = serde_json::to_string(&describe(&sample).map_err(Failure::work)?).map_err(Failure::work)?;
            // A reader that wants no more, such as `head`, ends it.
            if writeln!(std::io::stdout(), "{line}").is_err() {
                return Ok(String::new());
            }
        }
        let wake = waiter.wait(POLL_INTERVAL).map_err(Failure::work)?;
        if wake.stopped || wake.superseded {
            return Ok(String::new());
        }
    }
}
