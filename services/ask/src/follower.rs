//! Samples of a running site for a process that is started for one client, and reports nothing: from one generation of the bus to
//! the next, until the process ends.

use crate::site::Site;
use crate::takers::Takers;
use bus::{Bus, Daemon, Subscriber, Waiter, topics};
use daemon::{Failure, SiteConfig, chain};
use std::sync::Arc;
use std::time::Duration;

/// Interval at which a missing bus is tried again.
const RETRY: Duration = Duration::from_millis(500);
/// Longest time between two looks.
const INTERVAL: Duration = Duration::from_secs(1);

/// Follows a site on a thread of its own.
///
/// # Errors
/// A configuration without a bus, a system without threads.
pub(crate) fn follow(config: &SiteConfig, site: &Arc<Site>) -> Result<(), Failure> {
    let (domain, site) = (config.domain()?, Arc::clone(site));
    let follow = move || {
        loop {
            let followed = Bus::join(&domain, Daemon::Groundplan)
                .map_err(Failure::from)
                .and_then(|(bus, mut waiter)| follow_generation(&bus, &mut waiter, &site));
            if let Err(why) = followed {
                tracing::warn!(service = "groundplan-ask", error = chain(why.as_ref()), "there is no bus");
            }
            site.forget();
            std::thread::sleep(RETRY);
        }
    };
    std::thread::Builder::new().name("ask-follower".to_owned()).spawn(follow)?;
    Ok(())
}

/// Follows a generation of the bus to its end.
fn follow_generation(bus: &Bus, waiter: &mut Waiter, site: &Site) -> Result<(), Failure> {
    let takers = Takers::of(bus)?;
    let deviations: Subscriber<topics::Deviations> = bus.subscriber(topics::Deviations)?;
    loop {
        takers.take(site)?;
        if let Some(found) = deviations.take()? {
            site.insert_deviations(found.check()?);
        }
        site.looked();
        if waiter.wait(INTERVAL)?.superseded {
            return Ok(());
        }
    }
}
