//! Deviations that the running daemon found.

use super::args::Args;
use super::report::write;
use crate::failure::Failure;
use crate::wait::join;
use bus::{CheckedSample, topics};
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
    let sites = bus.subscriber(topics::Site).map_err(Failure::work)?;
    let phases = bus.subscriber(topics::Phase).map_err(Failure::work)?;
    let founds = bus.subscriber(topics::Deviations).map_err(Failure::work)?;
    let (mut site, mut phase, mut found) = (None, None, None);
    let begun = Instant::now();
    loop {
        site = sites.take().map_err(Failure::work)?.or(site);
        phase = phases.take().map_err(Failure::work)?.or(phase);
        found = founds.take().map_err(Failure::work)?.or(found);
        let belong = match (&site, &phase, &found) {
            (Some(site), Some(phase), Some(found)) => {
                let inputs = found.header().inputs;
                inputs.site == site.header().content_hash && inputs.phase == phase.header().content_hash
            }
            _ => false,
        };
        if let (Some(site), Some(phase), Some(found)) =
            (site.take_if(|_| belong), phase.take_if(|_| belong), found.take_if(|_| belong))
        {
            let site = site.check().map_err(Failure::work)?;
            let phase = phase.check().map_err(Failure::work)?;
            return write_samples(arguments, &site, &phase, &found.check().map_err(Failure::work)?);
        }
        if begun.elapsed() > PATIENCE {
            return Err(Failure::work("nothing was compared: see groundplan align and groundplan status"));
        }
        waiter.wait(LOOK).map_err(Failure::work)?;
    }
}

fn write_samples(
    arguments: &Args,
    site: &CheckedSample<topics::Site>,
    phase: &CheckedSample<topics::Phase>,
    found: &CheckedSample<topics::Deviations>,
) -> Result<String, Failure> {
    let (site, phase, found) = (site.view(), phase.view(), found.view());
    phase.check_site(&site).map_err(Failure::work)?;
    found.check_site(&site).map_err(Failure::work)?;
    write(arguments, &site, &phase, &found)
}
