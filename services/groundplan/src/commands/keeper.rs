//! `groundplan keeper`: creates the bus and removes resources of dead participants.

use crate::args::SiteArgs;
use crate::failure::Failure;
use crate::run::{Outcome, Run};
use bus::{DomainError, Keeper};
use daemon::StopSignal;
use std::time::Duration;
use tracing::{info, warn};

/// Interval at which dead participants are removed.
const TICK: Duration = Duration::from_secs(1);

/// Arguments of `keeper`.
#[derive(Debug, Clone, clap::Args)]
pub struct Args {
    /// The site.
    #[command(flatten)]
    site: SiteArgs,

    /// Stop when standard input ends
    #[arg(long)]
    with_stdin: bool,
}

impl Run for Args {
    /// Holds the bus until it is stopped.
    ///
    /// # Errors
    /// A bus that cannot be created.
    fn run(&self) -> Result<Outcome, Failure> {
        let config = self.site.own_config()?;
        let domain = config.domain().map_err(Failure::usage)?;
        let mut stop = StopSignal::listen(self.with_stdin).map_err(Failure::work)?;
        let mut keeper = Keeper::start(&domain).map_err(Failure::work)?;
        info!(service = "keeper", generation = keeper.generation(), "bus created");
        daemon::ready("holds the bus");
        while !stop.is_raised_within(TICK) {
            daemon::alive("holds the bus");
            match keeper.renew_if_damaged() {
                Ok(None) => {}
                Ok(Some(missing)) => {
                    let (missing, generation) = (missing.display(), keeper.generation());
                    warn!(service = "keeper", %missing, generation, "a file of the bus was deleted; the bus is created anew");
                }
                // The other one holds the bus that participants see.
                Err(why @ DomainError::KeeperRuns { .. }) => return Err(Failure::work(why)),
                Err(why) => warn!(service = "keeper", error = daemon::chain(&why), "cannot create the bus anew"),
            }
            match keeper.tick() {
                Ok(0) => {}
                Ok(dead) => info!(service = "keeper", dead, "cleaned up behind dead participants"),
                Err(why) => warn!(service = "keeper", error = daemon::chain(&why), "cannot clean up"),
            }
        }
        daemon::stopping();
        Ok(Outcome::silent())
    }
}
