//! `groundplan keeper`: creates the bus and removes resources of dead participants.

use crate::failure::Failure;
use crate::run::{Outcome, Run};
use crate::site_service::ServiceArgs;
use bus::{DomainError, Keeper};
use daemon::{ProcessReport, SiteConfig, SiteProcess, StopSignal};
use std::time::Duration;
use tracing::{info, warn};

/// Interval at which dead participants are removed.
const TICK: Duration = Duration::from_secs(1);
const ACTIVITY: &str = "holds bus";

/// Arguments of `keeper`.
#[derive(Debug, Clone, clap::Args)]
pub struct Args {
    /// The site, and when to stop.
    #[command(flatten)]
    service: ServiceArgs,
}

impl Run for Args {
    /// Holds the bus until it is stopped.
    ///
    /// # Errors
    /// A bus that cannot be created.
    fn run(&self) -> Result<Outcome, Failure> {
        self.service.run("keeper", hold_bus)
    }
}

fn hold_bus(config: &SiteConfig, mut stop: StopSignal) -> Result<(), Failure> {
    let domain = config.domain().map_err(Failure::usage)?;
    let mut keeper = Keeper::start(&domain).map_err(Failure::work)?;
    info!(service = "keeper", generation = keeper.generation(), "bus created");
    let mut report = ProcessReport::of(&config.bus.root, SiteProcess::Keeper);
    let mut error = None;
    daemon::ready(ACTIVITY);
    loop {
        report.alive(ACTIVITY, error.take());
        if stop.is_raised_within(TICK) {
            break;
        }
        match keeper.renew_if_damaged() {
            Ok(None) => {}
            Ok(Some(missing)) => {
                let (missing, generation) = (missing.display(), keeper.generation());
                warn!(service = "keeper", %missing, generation, "a file of the bus was deleted; the bus is created anew");
            }
            // The other one holds the bus that participants see.
            Err(why @ DomainError::KeeperRuns { .. }) => return Err(Failure::work(why)),
            Err(why) => error = Some(failed(&why, "cannot create the bus anew")),
        }
        match keeper.tick() {
            Ok(0) => {}
            Ok(dead) => info!(service = "keeper", dead, "cleaned up behind dead participants"),
            Err(why) => error = Some(failed(&why, "cannot clean up")),
        }
    }
    report.leave();
    Ok(())
}

/// Logs what failed; the words for the status board.
fn failed(why: &(dyn std::error::Error + 'static), what: &str) -> String {
    let error = daemon::chain(why);
    warn!(service = "keeper", error, "{what}");
    format!("{what}: {error}")
}
