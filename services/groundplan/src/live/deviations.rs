//! What the running daemon found to differ.

use super::join;
use crate::cli::DeviationsArgs;
use crate::deviations::write;
use crate::failure::Failure;
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
pub fn deviations(arguments: &DeviationsArgs) -> Result<String, Failure> {
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
                return told(arguments, site, phase, found);
            }
        }
        if begun.elapsed() > PATIENCE {
            return Err(Failure::work("nothing was compared: see groundplan align and groundplan status"));
        }
        waiter.wait(LOOK).map_err(Failure::work)?;
    }
}

fn told(arguments: &DeviationsArgs, site: &Sample, phase: &Sample, found: &Sample) -> Result<String, Failure> {
    let site = Site::open(site.bytes()).map_err(Failure::work)?;
    let phase = Phase::open(phase.bytes()).map_err(Failure::work)?;
    let found = Deviations::open(found.bytes()).map_err(Failure::work)?;
    phase.check_site(&site).map_err(Failure::work)?;
    found.check_site(&site).map_err(Failure::work)?;
    write(arguments, &site, &phase, &found)
}
