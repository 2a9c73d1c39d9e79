//! Deviations that the running daemon found.

use super::args::Args;
use super::report::write;
use crate::failure::Failure;
use crate::wait::join;
use bus::{Sample, Topic};
use messages::{Deviations, Phase, Site};
use std::time::{Duration, Instant};

/// A comparison follows an alignment after seconds.
const PATIENCE: Duration = Duration::from_secs(20);
const LOOK: Duration = Duration::from_millis(50);

/// Takes the deviations that fit the newest site and phase.
///
/// # Errors
/// No daemons, no pose that was accepted, a folder that cannot be written.
pub(super) fn take(arguments: &Args) -> Result<String, Failure> {
    let (bus, mut waiter) = join(&arguments.site.config()?)?;
    let subscriber = |topic| bus.subscriber(topic).map_err(Failure::work);
    let subscribers = [subscriber(Topic::Site)?, subscriber(Topic::Phase)?, subscriber(Topic::Deviations)?];
    let mut newest: [Option<Sample>; 3] = [None, None, None];
    let begun = Instant::now();
    loop {
        for (sample, subscriber) in newest.iter_mut().zip(&subscribers) {
            if let Some(newer) = subscriber.take().map_err(Failure::work)? {
                *sample = Some(newer);
            }
        }
        if let [Some(site), Some(phase), Some(found)] = &newest {
            let inputs = found.header().inputs;
            if [inputs.site, inputs.phase] == [site, phase].map(|sample| sample.header().content_hash) {
                return write_samples(arguments, site, phase, found);
            }
        }
        if begun.elapsed() > PATIENCE {
            return Err(Failure::work("nothing was compared: see groundplan align and groundplan status"));
        }
        waiter.wait(LOOK).map_err(Failure::work)?;
    }
}

fn write_samples(arguments: &Args, site: &Sample, phase: &Sample, found: &Sample) -> Result<String, Failure> {
    let site = Site::open(site.bytes()).map_err(Failure::work)?;
    let phase = Phase::open(phase.bytes()).map_err(Failure::work)?;
    let found = Deviations::open(found.bytes()).map_err(Failure::work)?;
    phase.check_site(&site).map_err(Failure::work)?;
    found.check_site(&site).map_err(Failure::work)?;
    write(arguments, &site, &phase, &found)
}
